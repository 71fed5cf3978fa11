//! Statistics of a scene for reports.

/// Counts, sizes and warnings.
#[derive(Debug, Clone, Default, serde::Serialize, serde::Deserialize)]
pub struct SceneInfo {
    /// Triangles in distinct meshes.
    pub triangles: usize,
    /// Placed triangles, counting all instances.
    pub placed_triangles: usize,
    /// Distinct meshes (one material each).
    pub meshes: usize,
    /// Placed meshes.
    pub instances: usize,
    /// Materials.
    pub materials: usize,
    /// Lights with nonzero emission; every emitting triangle counts.
    pub lights: usize,
    /// Distinct images in use.
    pub images: usize,
    /// Bytes of decoded images, including the environment map and its sampling table.
    pub texture_bytes: usize,
    /// Bytes of meshes.
    pub geometry_bytes: usize,
    /// Bytes of the acceleration structure, as reported by the backend.
    pub accel_bytes: usize,
    /// Bytes of the light tree; 0 where lights are selected by power.
    #[serde(default)]
    pub light_tree_bytes: usize,
    /// Bytes of the densities of media.
    #[serde(default)]
    pub density_bytes: usize,
    /// Names of the file's animations, by index.
    #[serde(default)]
    pub animations: Vec<String>,
    /// Features: see [`super::Features`].
    pub features: Vec<String>,
    /// Features of the file that étendue does not support.
    pub ignored: Vec<String>,
    /// Defaults for missing data, and changes to unusable data.
    pub warnings: Vec<String>,
    /// The point of the file that becomes the scene origin.
    pub centre: glam::DVec3,
    /// Scene units per file unit.
    pub scale: f64,
    /// Build time in seconds, without the acceleration structure.
    pub prepare_seconds: f64,
    /// Build time of the acceleration structure in seconds.
    pub accel_seconds: f64,
}

impl SceneInfo {
    /// Returns the bytes of the scene in all.
    pub fn bytes(&self) -> usize {
        let parts = [self.geometry_bytes, self.accel_bytes, self.texture_bytes, self.light_tree_bytes];
        parts.into_iter().sum::<usize>() + self.density_bytes
    }
}
