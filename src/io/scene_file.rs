//! Scene files of every format. This is the one place that tells formats apart.

use super::gltf;
use super::reading::read_file;
use crate::error::{Error, Result};
use crate::scene::description::Description;
use std::path::Path;

pub use super::reading::ReadOptions;

/// Format of a scene file.
enum SceneFormat {
    /// `.gltf` and `.glb`.
    Gltf,
}

impl SceneFormat {
    /// Returns the format by the contents of the file, else by the extension of `path`; `None` if it is unknown.
    fn of(path: &Path, file: &[u8]) -> Option<Self> {
        let extension = path.extension().unwrap_or_default().to_ascii_lowercase();
        (gltf::is_gltf(file) || extension == "gltf" || extension == "glb").then_some(SceneFormat::Gltf)
    }
}

/// Reads the scene in `path` at rest, with the default memory limit.
///
/// # Errors
/// As [`load_with`].
pub fn load(path: &Path) -> Result<Description> {
    load_with(path, &ReadOptions::default())
}

/// Reads the scene in `path`. Files it refers to lie beside it.
///
/// # Errors
/// A scene error, in one sentence that begins with the path, if the file or one that it refers to cannot be read, has
/// an unknown format, or is not valid; other classes as for its format, such as [`gltf::parse`].
pub fn load_with(path: &Path, options: &ReadOptions) -> Result<Description> {
    let file = read_file(path, u64::MAX)?;
    let base = path.parent().unwrap_or(Path::new(""));
    let description = match SceneFormat::of(path, &file) {
        Some(SceneFormat::Gltf) => gltf::parse(&file, base, options),
        None => Err(Error::scene("this is not a scene that étendue reads, which are .gltf and .glb files")),
    };
    description.map_err(|e| e.context(path.display()))
}
