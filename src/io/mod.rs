//! Files in and out: glTF scenes, EXR and PNG images.

pub mod exr;
pub mod gltf;
pub mod png;
