//! Where the edits of a file apply.

use crate::mutations::{Edit, Mutation};
use std::cmp::Reverse;
use std::collections::BTreeMap;
use std::ops::Range;

/// A place where one mutation replaces text.
#[derive(Debug, Clone)]
pub(crate) struct Site<'m> {
    /// The replaced bytes of the file.
    pub(crate) span: Range<usize>,
    /// Position of the mutation in the list of all, counted from 1.
    pub(crate) number: usize,
    /// The mutation.
    pub(crate) mutation: &'m Mutation,
    /// The wrong text.
    pub(crate) after: &'m str,
}

/// An edit, its mutation and the mutation's number.
pub(crate) type Numbered<'m> = (usize, &'m Mutation, &'m Edit);

/// Returns the edits of all mutations by file.
pub(crate) fn by_file(mutations: &[Mutation]) -> BTreeMap<&str, Vec<Numbered<'_>>> {
    let mut files: BTreeMap<&str, Vec<Numbered<'_>>> = BTreeMap::new();
    for (i, mutation) in mutations.iter().enumerate() {
        for edit in &mutation.edit {
            files.entry(&edit.file).or_default().push((i + 1, mutation, edit));
        }
    }
    files
}

/// Returns the sites of `edits` in `text` by their begin, an outer one before those inside it. Fails with a sentence
/// for each edit that does not apply.
pub(crate) fn locate<'m>(text: &str, edits: &[Numbered<'m>]) -> Result<Vec<Site<'m>>, Vec<String>> {
    let mut complaints = Vec::new();
    let mut sites = Vec::new();
    for &(number, mutation, edit) in edits {
        match span(text, edit) {
            Ok(span) => sites.push(Site { span, number, mutation, after: &edit.after }),
            Err(what) => complaints.push(format!("{} is stale: {what} in {}", mutation.name, edit.file)),
        }
    }
    sites.sort_by_key(|site| (site.span.start, Reverse(site.span.end), site.number));
    for (i, site) in sites.iter().enumerate() {
        let cut = |other: &&Site| other.span.start < site.span.end && other.span.end > site.span.end;
        complaints.extend(sites[i + 1..].iter().filter(cut).map(|other| {
            format!("{} and {} overlap and neither contains the other", site.mutation.name, other.mutation.name)
        }));
    }
    if complaints.is_empty() { Ok(sites) } else { Err(complaints) }
}

/// Returns the bytes of `text` that `edit` replaces.
fn span(text: &str, edit: &Edit) -> Result<Range<usize>, String> {
    let (offset, around) = match &edit.within {
        Some(within) => (once(text, within).map_err(|n| format!("`within` occurs {n} times"))?, within.as_str()),
        None => (0, text),
    };
    let start = offset + once(around, &edit.before).map_err(|n| format!("`before` occurs {n} times"))?;
    Ok(start..start + edit.before.len())
}

/// Returns the position of the only occurrence of `part` in `text`, else how often it occurs.
fn once(text: &str, part: &str) -> Result<usize, usize> {
    let mut found = text.match_indices(part);
    match (found.next(), found.count()) {
        (Some((at, _)), 0) => Ok(at),
        (first, more) => Err(usize::from(first.is_some()) + more),
    }
}
