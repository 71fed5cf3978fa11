//! Names of the extensions that are read.

/// Copies of a mesh.
pub(super) const INSTANCING: &str = "EXT_mesh_gpu_instancing";

/// Scattering in a volume, a draft.
pub(super) const SCATTERING: &str = "KHR_materials_volume_scatter";

/// Supported extensions. KHR_mesh_quantization needs no code beyond the checked component types.
pub(super) const READ: [&str; 11] = [
    INSTANCING,
    "KHR_lights_punctual",
    "KHR_materials_emissive_strength",
    "KHR_materials_ior",
    "KHR_materials_specular",
    "KHR_materials_transmission",
    "KHR_materials_unlit",
    "KHR_materials_volume",
    SCATTERING,
    "KHR_mesh_quantization",
    "KHR_texture_transform",
];
