//! What a ray is traced for. Rays of a class are alike for a backend: those of the camera run side by side, those of bounces in
//! all directions, and shadow rays ask only whether there is anything.

/// What a ray is traced for.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum RayClass {
    /// From the camera, until the first surface that counts.
    Camera,
    /// From the scattering event of that number, counted from 1.
    Bounce(u32),
    /// Toward a light.
    Shadow,
}

impl std::fmt::Display for RayClass {
    /// `camera`, `bounce-3`, `shadow`.
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            RayClass::Camera => f.write_str("camera"),
            RayClass::Bounce(depth) => write!(f, "bounce-{depth}"),
            RayClass::Shadow => f.write_str("shadow"),
        }
    }
}
