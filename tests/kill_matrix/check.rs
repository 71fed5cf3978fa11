//! The check of the data, without a build: a stale mutation fails by its name.

use crate::killers::KILLERS;
use crate::mutations::{self, Mutation};
use crate::sites;
use std::collections::HashSet;

/// Returns all mutations, if they and the list of killers are in order.
pub(crate) fn mutations() -> Result<Vec<Mutation>, String> {
    let all = mutations::load()?;
    let mut complaints: Vec<String> = all.iter().flat_map(sentences).collect();
    complaints.extend(twice(all.iter().map(|m| m.name.clone())));
    complaints.extend(twice(KILLERS.iter().map(|killer| killer.name())));
    for (file, edits) in sites::by_file(&all) {
        match mutations::read(&mutations::root().join(file)) {
            Ok(text) => complaints.extend(sites::locate(&text, &edits).err().into_iter().flatten()),
            Err(what) => complaints.push(format!("{}: {what}", edits[0].1.name)),
        }
    }
    if complaints.is_empty() { Ok(all) } else { Err(complaints.join("\n       ")) }
}

/// What is wrong with a mutation's own texts.
fn sentences(mutation: &Mutation) -> Vec<String> {
    let Mutation { name, wrong, source, edit } = mutation;
    let is_name = |c: char| c.is_ascii_lowercase() || c.is_ascii_digit() || c == '-';
    let faults = [
        (name.is_empty() || !name.chars().all(is_name), "the name is not of small letters, digits and hyphens"),
        (wrong.trim().is_empty() || !wrong.ends_with('.'), "`wrong` is no sentence"),
        (source.trim().is_empty(), "`source` is empty"),
        (edit.is_empty(), "it edits nothing"),
        (edit.iter().any(|e| e.before.trim().is_empty()), "`before` is empty"),
        (edit.iter().any(|e| e.before == e.after), "`after` is `before`"),
        (edit.iter().any(|e| !e.file.starts_with("src/")), "it edits a file outside src"),
    ];
    faults.iter().filter(|(is_so, _)| *is_so).map(|(_, what)| format!("{name}: {what}")).collect()
}

/// A complaint for each name that was there before.
fn twice(names: impl Iterator<Item = String>) -> Vec<String> {
    let mut known = HashSet::new();
    names.filter_map(|name| (!known.insert(name.clone())).then(|| format!("{name} is listed twice"))).collect()
}
