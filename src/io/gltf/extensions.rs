//! Names of the extensions that are read.

/// Copies of a mesh.
pub(super) const INSTANCING: &str = "EXT_mesh_gpu_instancing";

/// Supported extensions. KHR_mesh_quantization needs no code beyond the checked component types.
pub(super) const READ: [&str; 10] = [
    INSTANCING,
    "KHR_lights_punctual",
    "KHR_materials_emissive_strength",
    "KHR_materials_ior",
    "KHR_materials_specular",
    "KHR_materials_transmission",
    "KHR_materials_unlit",
    "KHR_materials_volume",
    "KHR_mesh_quantization",
    "KHR_texture_transform",
];
