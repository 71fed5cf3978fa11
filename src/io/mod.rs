//! Files: what étendue reads and writes.

pub mod atomic;
pub mod exr;
pub mod gltf;
pub mod png;
