//! The copy of the repository that has the mutations. Sources are copied, the rest is linked. A file whose text is as
//! it was keeps its time stamp, so that cargo builds nothing twice.

use crate::manifest;
use crate::mutations::{Mutation, read, root};
use crate::schemata::{self, SWITCH};
use crate::sites;
use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::io;
use std::path::{Path, PathBuf};

/// What is copied. It is what cargo compiles.
const COPIED: &[&str] = &["src", "tests", "sys", "Cargo.toml", "Cargo.lock", "build.rs"];
/// What is neither copied nor linked, besides hidden files: cargo reads .cargo/config.toml from the parent folder.
const LEFT_OUT: &[&str] = &["target", "out"];

/// Brings the copy up to date and returns its path.
pub(crate) fn build(mutations: &[Mutation]) -> Result<PathBuf, String> {
    let parent = root().join("target/kill-matrix");
    let tree = parent.join("tree");
    let changed = changed(mutations)?;
    let update = || {
        fs::create_dir_all(&tree)?;
        for name in COPIED {
            copy(Path::new(name), &tree, &changed)?;
        }
        put(&tree.join(SWITCH), schemata::switch(mutations).as_bytes(), None)?;
        link_rest(&tree)?;
        // Some tests look for a folder `shared` beside the repository.
        link(&root().join("../shared"), &parent.join("shared"))
    };
    update().map_err(|e: io::Error| format!("{}: {e}", tree.display()))?;
    Ok(tree)
}

/// Returns the files whose text differs in the copy.
fn changed(mutations: &[Mutation]) -> Result<BTreeMap<PathBuf, String>, String> {
    let mut changed = BTreeMap::new();
    for (file, edits) in sites::by_file(mutations) {
        let text = read(&root().join(file))?;
        let sites = sites::locate(&text, &edits).map_err(|complaints| complaints.join("\n       "))?;
        changed.insert(PathBuf::from(file), schemata::apply(&text, &sites));
    }
    let library = PathBuf::from("src/lib.rs");
    let text = changed.get(&library).cloned().map_or_else(|| read(&root().join(&library)), Ok)?;
    changed.insert(library, format!("#![allow(warnings, clippy::all)]\n{text}\nmod mutant;\n"));
    changed.insert("Cargo.toml".into(), manifest::of_copy(&read(&root().join("Cargo.toml"))?)?);
    Ok(changed)
}

/// Copies the file or folder `path`, relative to the root, and removes what is no longer there.
fn copy(path: &Path, tree: &Path, changed: &BTreeMap<PathBuf, String>) -> io::Result<()> {
    let (from, to) = (root().join(path), tree.join(path));
    if !from.is_dir() {
        return match changed.get(path) {
            Some(text) => put(&to, text.as_bytes(), None),
            None => put(&to, &fs::read(&from)?, Some(from.metadata()?.modified()?)),
        };
    }
    fs::create_dir_all(&to)?;
    let names = names(&from)?;
    for name in names_to_remove(&to, &names)? {
        let old = to.join(name);
        if old != tree.join(SWITCH) {
            remove(&old)?;
        }
    }
    names.iter().try_for_each(|name| copy(&path.join(name), tree, changed))
}

/// Writes a file unless it has this text. A new file gets the time stamp `modified`, so that what is the same in the
/// copy is also as old.
fn put(path: &Path, text: &[u8], modified: Option<std::time::SystemTime>) -> io::Result<()> {
    let old = fs::read(path);
    if old.as_ref().is_ok_and(|old| old == text) {
        return Ok(());
    }
    fs::write(path, text)?;
    match modified.filter(|_| old.is_err()) {
        Some(time) => fs::File::options().append(true).open(path)?.set_modified(time),
        None => Ok(()),
    }
}

/// Links what is not copied. Tests read it, as scenes and documents.
fn link_rest(tree: &Path) -> io::Result<()> {
    let mut names = names(root())?;
    names.retain(|name| !LEFT_OUT.contains(&name.as_str()));
    for name in names_to_remove(tree, &names)? {
        // The build of the copy may have written it, as a target folder.
        let old = tree.join(name);
        if old.is_symlink() {
            remove(&old)?;
        }
    }
    names.retain(|name| !COPIED.contains(&name.as_str()));
    names.iter().try_for_each(|name| link(&root().join(name), &tree.join(name)))
}

/// Makes `at` a link to `to`, if `to` exists.
fn link(to: &Path, at: &Path) -> io::Result<()> {
    if fs::read_link(at).is_ok_and(|old| old == to) || !to.exists() {
        return Ok(());
    }
    if at.is_symlink() || at.exists() {
        remove(at)?;
    }
    std::os::unix::fs::symlink(to, at)
}

fn remove(path: &Path) -> io::Result<()> {
    if path.is_dir() && !path.is_symlink() { fs::remove_dir_all(path) } else { fs::remove_file(path) }
}

/// Returns the names of visible entries of a folder.
fn names(folder: &Path) -> io::Result<BTreeSet<String>> {
    let names: io::Result<Vec<_>> = fs::read_dir(folder)?.map(|entry| Ok(entry?.file_name())).collect();
    Ok(names?.into_iter().filter_map(|name| name.into_string().ok()).filter(|name| !name.starts_with('.')).collect())
}

/// Returns the names of visible entries of a folder that are not among `kept`.
fn names_to_remove(folder: &Path, kept: &BTreeSet<String>) -> io::Result<Vec<String>> {
    Ok(names(folder)?.difference(kept).cloned().collect())
}
