//! File formats that étendue reads and writes.

pub mod atomic;
pub(crate) mod blackbody;
pub mod environment;
pub mod exr;
pub mod gltf;
pub(crate) mod hashed;
pub mod hdr;
pub(crate) mod medium;
pub mod png;
pub mod primaries;
mod reading;
pub mod scene_file;
pub mod volume;
