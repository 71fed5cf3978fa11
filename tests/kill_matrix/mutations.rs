//! The mutations: wrong variants of the renderer's code, as data in mutations/*.toml.

use std::path::{Path, PathBuf};

/// The root of the repository.
pub(crate) fn root() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR"))
}

/// A file of mutations.
#[derive(serde::Deserialize)]
#[serde(deny_unknown_fields)]
struct Listed {
    mutation: Vec<Mutation>,
}

/// A wrong variant of the renderer.
#[derive(Debug, serde::Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct Mutation {
    /// The value of `ETENDUE_MUTANT` that turns it on.
    pub(crate) name: String,
    /// What is wrong, in a sentence.
    pub(crate) wrong: String,
    /// Where it is known from.
    pub(crate) source: String,
    /// Its edits, which are on together.
    pub(crate) edit: Vec<Edit>,
}

/// A replacement in one file.
#[derive(Debug, serde::Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct Edit {
    /// The file, relative to the root of the repository.
    pub(crate) file: String,
    /// Text that occurs once in the file and has `before` once; the whole file if absent.
    pub(crate) within: Option<String>,
    /// The right text: an expression, or statements whose bindings are not used after it.
    pub(crate) before: String,
    /// The wrong text.
    pub(crate) after: String,
}

/// Reads all mutations, by the names of their files and in the order of each file.
pub(crate) fn load() -> Result<Vec<Mutation>, String> {
    let folder = root().join("tests/kill_matrix/mutations");
    let entries = std::fs::read_dir(&folder).map_err(|e| format!("{}: {e}", folder.display()))?;
    let mut paths: Vec<PathBuf> = entries.filter_map(|entry| Some(entry.ok()?.path())).collect();
    paths.retain(|path| path.extension().is_some_and(|extension| extension == "toml"));
    paths.sort();
    let mut all = Vec::new();
    for path in paths {
        let text = read(&path)?;
        let listed: Listed = toml::from_str(&text).map_err(|e| format!("{}: {e}", path.display()))?;
        all.extend(listed.mutation);
    }
    Ok(all)
}

/// Reads a text file.
pub(crate) fn read(path: &Path) -> Result<String, String> {
    std::fs::read_to_string(path).map_err(|e| format!("{}: {e}", path.display()))
}
