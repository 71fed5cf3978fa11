//! A scene as loaded: plain data in file units, before rebasing and construction.

mod density;
pub(in crate::scene) mod hash;
mod material;

pub use density::{ColorGrid, DensityGrid};
pub use material::{
    AlphaMode, DiffuseMaterial, Material, MaterialModel, MetalFresnel, MetallicRoughnessMaterial, Volume,
};

use crate::spectrum::Spectrum;
use crate::texture::{Bitmap, RadianceMap};
use glam::{DAffine3, Vec2, Vec3, Vec4};
use std::sync::Arc;

/// Contents of a scene file, in its own coordinates (metres, Y up for glTF).
#[derive(Debug, Default)]
pub struct Description {
    /// Distinct meshes.
    pub meshes: Vec<Mesh>,
    /// Placed meshes.
    pub instances: Vec<Instance>,
    /// Materials of the primitives.
    pub materials: Vec<Material>,
    /// Densities of media.
    pub densities: Vec<DensityGrid>,
    /// Albedos of media.
    pub albedos: Vec<ColorGrid>,
    /// What multiplies the emission of media.
    pub emissions: Vec<ColorGrid>,
    /// Media in the space around everything, cameras and lamps included. One with a density fills the density's box.
    pub media: Vec<Volume>,
    /// Decoded images of the textures; shared images are decoded once.
    pub images: Vec<Arc<Bitmap>>,
    /// Point, spot and directional lights.
    pub lights: Vec<PunctualLight>,
    /// Whether the file has punctual lights, including hidden ones: see [`Description::lights`].
    pub has_punctual_lights: bool,
    /// Whether any material of the file emits, including those of hidden objects.
    pub has_emission: bool,
    /// Whether any part of the file is hidden, so that a scene without triangles is not an error.
    pub hides: bool,
    /// Cameras in file order.
    pub cameras: Vec<CameraDescription>,
    /// Light from infinity.
    pub environment: Option<EnvironmentDescription>,
    /// Names of all animations of the file, played or not.
    pub animations: Vec<String>,
    /// Time in seconds after which nothing moves; `None` if nothing moves, or no time was requested.
    pub animation_end: Option<f64>,
    /// Features of the file that étendue does not support, one sentence each, without repeats.
    pub ignored: Vec<String>,
    /// Changes to the file's data and doubtful data, one sentence each.
    pub warnings: Vec<String>,
}

/// Light from outside the scene.
#[derive(Debug, Clone)]
pub enum EnvironmentDescription {
    /// The same radiance from every direction.
    Uniform(Spectrum),
    /// A latitude-longitude map around the up axis, +y; see [`crate::light::EnvironmentMap`].
    Map {
        /// The texels.
        map: Arc<RadianceMap>,
        /// Multiplier of their radiance.
        scale: f32,
        /// Rotation about the up axis in degrees, counter-clockwise seen from above.
        rotation: f64,
    },
}

/// A mesh: one or more primitives.
#[derive(Debug)]
pub struct Mesh {
    /// Name, generated if the file has none.
    pub name: String,
    /// Its primitives, one material each.
    pub primitives: Vec<Primitive>,
}

/// Triangles of one material, in object space as stored in the file.
#[derive(Debug, Default)]
pub struct Primitive {
    /// Vertex positions.
    pub positions: Vec<Vec3>,
    /// Vertex indices, counter-clockwise seen from the front.
    pub triangles: Vec<[u32; 3]>,
    /// Unit normals. glTF specifies flat normals where a file has none: `None` here, so that vertices stay shared.
    pub normals: Option<Vec<Vec3>>,
    /// Tangents with handedness in w.
    pub tangents: Option<Vec<Vec4>>,
    /// Texture coordinate sets 0 and 1.
    pub uvs: [Option<Vec<Vec2>>; 2],
    /// Linear colours with alpha.
    pub colors: Option<Vec<Vec4>>,
    /// Index into [`Description::materials`].
    pub material: usize,
}

/// A placed mesh.
#[derive(Debug)]
pub struct Instance {
    /// Name of the node, generated if the file has none.
    pub name: String,
    /// Index into [`Description::meshes`].
    pub mesh: usize,
    /// Object to world.
    pub transform: DAffine3,
}

/// Type of a punctual light; it shines along −z of its transform.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum PunctualKind {
    /// Intensity in watts per steradian and channel.
    Point,
    /// Axial intensity in watts per steradian and channel, with a fall-off between the angles (radians).
    Spot {
        /// Angle at which the fall-off begins.
        inner: f32,
        /// Angle at which the intensity reaches zero.
        outer: f32,
    },
    /// Irradiance on a perpendicular surface in watts per square metre and channel.
    Directional,
}

/// A punctual light.
#[derive(Debug)]
pub struct PunctualLight {
    /// Its name.
    pub name: String,
    /// Its type.
    pub kind: PunctualKind,
    /// Colour times intensity.
    pub intensity: Spectrum,
    /// Local to world.
    pub transform: DAffine3,
}

/// Projection of a camera.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Projection {
    /// A pinhole.
    Perspective {
        /// Vertical field of view in radians.
        yfov: f64,
        /// Aspect ratio (width over height), if the file gives one.
        aspect: Option<f64>,
    },
    /// Parallel rays.
    Orthographic {
        /// Half the width of the view in scene units.
        xmag: f64,
        /// Half the height of the view in scene units.
        ymag: f64,
    },
}

/// Lens of a perspective camera. One whose radius or focus is not positive makes it a pinhole.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct Lens {
    /// Radius of a round aperture, in file units. One with blades has the same area.
    pub radius: f64,
    /// Distance from the lens to the plane of focus along the axis, in file units.
    pub focus: f64,
    /// Number of blades, the sides of a regular polygon, at least 3; 0 for a round aperture.
    pub blades: u32,
    /// Angle by which a polygon is turned counter-clockwise, seen from behind the camera, from a corner on the right,
    /// in degrees.
    pub rotation: f64,
}

impl Lens {
    /// Largest number of blades. More cannot be told from a disk.
    pub const MOST_BLADES: u32 = 64;
}

/// A camera, looking along −z of its transform with +y up.
#[derive(Debug, Clone)]
pub struct CameraDescription {
    /// Name, generated if the file has none.
    pub name: String,
    /// Its projection.
    pub projection: Projection,
    /// Its lens, if it has one. Orthographic cameras ignore it.
    pub lens: Option<Lens>,
    /// Local to world.
    pub transform: DAffine3,
}
