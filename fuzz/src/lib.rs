//! What the fuzz targets share: mutating glTF by its structure, and files that readers of paths can open.

mod container;
mod structure;

pub use container::Container;
pub use structure::{cross, mutate};

use std::path::PathBuf;
use std::sync::LazyLock;

static FOLDER: LazyLock<tempfile::TempDir> = LazyLock::new(|| {
    let memory = std::path::Path::new("/dev/shm");
    let made = if memory.is_dir() { tempfile::tempdir_in(memory) } else { tempfile::tempdir() };
    made.expect("a temporary folder")
});

/// A file of this process with these contents.
pub fn file(name: &str, bytes: &[u8]) -> PathBuf {
    let path = FOLDER.path().join(name);
    std::fs::write(&path, bytes).expect("a written file");
    path
}

/// One line, as every error must be.
pub fn check(error: &etendue::error::Error) {
    let chain = error.chain();
    assert!(!chain.contains('\n'), "an error of two lines: {chain:?}");
}
