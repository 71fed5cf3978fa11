//! The check of the data, without a build: a stale mutation fails by its name.

use crate::killers::{KILLERS, Killer};
use crate::mutations::{self, Mutation};
use crate::sites;
use std::collections::HashSet;
use std::path::{Path, PathBuf};

/// Returns all mutations, if they and the list of killers are in order.
pub(crate) fn mutations() -> Result<Vec<Mutation>, String> {
    let all = mutations::load()?;
    let mut complaints: Vec<String> = all.iter().flat_map(sentences).collect();
    complaints.extend(twice(all.iter().map(|m| m.name.clone())));
    complaints.extend(twice(KILLERS.iter().map(|killer| killer.name())));
    complaints
        .extend(KILLERS.iter().filter(|killer| !exists(**killer)).map(|killer| format!("no test {}", killer.name())));
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

/// Whether the killer's test is in a file of its module.
fn exists(killer: Killer) -> bool {
    let (modules, name) = killer.test.rsplit_once("::").unwrap_or(("", killer.test));
    let path = modules.trim_end_matches("::tests").replace("::", "/");
    let path = if killer.binary == "lib" { format!("src/{path}") } else { format!("tests/{}/{path}", killer.binary) };
    // `path` is a folder, or the files of a module begin with it: `a.rs`, `a_tests.rs`.
    let path = mutations::root().join(path);
    let (folder, stem) = if path.is_dir() { (path, String::new()) } else { parts(&path) };
    let entries = std::fs::read_dir(folder).into_iter().flatten().flatten();
    let of_module = entries.filter(|entry| entry.file_name().to_string_lossy().starts_with(&stem));
    let has_test = |text: String| text.contains(&format!("fn {name}()"));
    of_module.filter_map(|entry| std::fs::read_to_string(entry.path()).ok()).any(has_test)
}

/// The parent and the last name of a path.
fn parts(path: &Path) -> (PathBuf, String) {
    let name = path.file_name().unwrap_or_default().to_string_lossy().into_owned();
    (path.parent().unwrap_or(path).to_owned(), name)
}

/// A complaint for each name that was there before.
fn twice(names: impl Iterator<Item = String>) -> Vec<String> {
    let mut known = HashSet::new();
    names.filter_map(|name| (!known.insert(name.clone())).then(|| format!("{name} is listed twice"))).collect()
}
