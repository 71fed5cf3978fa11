//! Where files lie that are not in the repository.

use std::path::{Path, PathBuf};

/// The folder of shared scenes and references: `ETENDUE_SHARED`, else `shared` beside the repository. It need not
/// exist.
pub fn shared() -> PathBuf {
    let beside = || Path::new(env!("CARGO_MANIFEST_DIR")).join("../../../shared");
    std::env::var_os("ETENDUE_SHARED").map_or_else(beside, PathBuf::from)
}
