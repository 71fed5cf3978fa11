//! Purpose of a ray. Rays of a class are similar for a backend: camera rays are coherent, bounce rays are incoherent,
//! and shadow rays need only occlusion.

/// Purpose of a ray.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum RayClass {
    /// From the camera to the first surface.
    Camera,
    /// From a scattering event with its index, counted from 1.
    Bounce(u32),
    /// Toward a light.
    Shadow,
}

impl std::fmt::Display for RayClass {
    /// Formats as `camera`, `bounce-3`, `shadow`.
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            RayClass::Camera => f.write_str("camera"),
            RayClass::Bounce(depth) => write!(f, "bounce-{depth}"),
            RayClass::Shadow => f.write_str("shadow"),
        }
    }
}
