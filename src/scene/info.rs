//! What a scene holds, in numbers and sentences for people.

/// Counts, sizes and warnings.
#[derive(Debug, Clone, Default, serde::Serialize, serde::Deserialize)]
pub struct SceneInfo {
    /// Triangles in distinct meshes.
    pub triangles: usize,
    /// Triangles as placed: instances counted each.
    pub placed_triangles: usize,
    /// Distinct meshes (one material each).
    pub meshes: usize,
    /// Meshes at places.
    pub instances: usize,
    /// Materials.
    pub materials: usize,
    /// Lights that shine; every emitting triangle is one.
    pub lights: usize,
    /// Distinct images in use.
    pub images: usize,
    /// Bytes of decoded images, the environment's with its table among them.
    pub texture_bytes: usize,
    /// Bytes of meshes.
    pub geometry_bytes: usize,
    /// Bytes of the acceleration structure, as far as the backend tells.
    pub accel_bytes: usize,
    /// Names of the file's animations, in the order of their numbers.
    #[serde(default)]
    pub animations: Vec<String>,
    /// What kernels must know: see [`super::Features`].
    pub features: Vec<String>,
    /// What the file uses and étendue does not.
    pub ignored: Vec<String>,
    /// What was made up because the file does not say it, or changed because it cannot be used.
    pub warnings: Vec<String>,
    /// The point of the file that is the origin of the scene's own coordinates.
    pub centre: glam::DVec3,
    /// Scene units per file unit.
    pub scale: f64,
    /// Seconds spent on building everything but the acceleration structure.
    pub prepare_seconds: f64,
    /// Seconds spent on building the acceleration structure.
    pub accel_seconds: f64,
}
