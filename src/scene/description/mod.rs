//! A scene as loaded: plain data in the file's own units, before anything is rebased or built.

pub(in crate::scene) mod hash;

use crate::spectrum::Spectrum;
use crate::texture::{Image, RadianceMap, Texture};
use glam::{DAffine3, Vec2, Vec3, Vec4};
use std::sync::Arc;

/// Everything a scene file says, in its own coordinates (metres, Y up for glTF).
#[derive(Debug, Default)]
pub struct Description {
    /// Distinct meshes.
    pub meshes: Vec<Mesh>,
    /// Where meshes stand.
    pub instances: Vec<Instance>,
    /// Materials that primitives refer to.
    pub materials: Vec<Material>,
    /// Decoded images that textures refer to; shared ones are decoded once.
    pub images: Vec<Arc<Image>>,
    /// Point, spot and directional lights.
    pub lights: Vec<PunctualLight>,
    /// Whether the file has lights without extent, even if they are hidden now: see [`Description::lights`].
    pub has_punctual_lights: bool,
    /// Whether some material of the file emits, even if what it is on is hidden now.
    pub has_emission: bool,
    /// Whether something of the file is hidden now, so that a scene without triangles is no error.
    pub hides: bool,
    /// Cameras in file order.
    pub cameras: Vec<Camera>,
    /// What arrives where nothing is hit.
    pub environment: Option<Environment>,
    /// Names of the file's animations, which is played or not.
    pub animations: Vec<String>,
    /// The time in seconds at which nothing moves any more; `None` if nothing does, or no time was asked for.
    pub animation_end: Option<f64>,
    /// What the file uses and étendue does not, one sentence each, without repeats.
    pub ignored: Vec<String>,
    /// What was changed or is doubtful, one sentence each.
    pub warnings: Vec<String>,
}

/// Light from outside the scene.
#[derive(Debug, Clone)]
pub enum Environment {
    /// The same radiance from every direction.
    Uniform(Spectrum),
    /// A latitude-longitude map around the up axis, +y; see [`crate::light::LatLong`].
    Map {
        /// Its texels.
        map: Arc<RadianceMap>,
        /// What their radiance is multiplied by.
        scale: f32,
        /// How far it is turned about the up axis, in degrees, counter-clockwise seen from above.
        rotation: f64,
    },
}

/// A mesh: one or more primitives.
#[derive(Debug)]
pub struct Mesh {
    /// Its name, made up if the file gives none.
    pub name: String,
    /// Its parts, one material each.
    pub primitives: Vec<Primitive>,
}

/// Triangles of one material, in object space as the file stores them.
#[derive(Debug, Default)]
pub struct Primitive {
    /// Vertex positions.
    pub positions: Vec<Vec3>,
    /// Vertex indices, counter-clockwise seen from the front.
    pub triangles: Vec<[u32; 3]>,
    /// Unit normals. Where a file has none the spec wants flat ones: `None` here, and vertices stay shared.
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

/// A mesh at a place.
#[derive(Debug)]
pub struct Instance {
    /// The node's name, made up if the file gives none.
    pub name: String,
    /// Index into [`Description::meshes`].
    pub mesh: usize,
    /// Object to world.
    pub transform: DAffine3,
}

/// How alpha is used.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub enum AlphaMode {
    /// Alpha is ignored.
    #[default]
    Opaque,
    /// The surface is there where alpha reaches the cutoff.
    Mask {
        /// The cutoff.
        cutoff: f32,
    },
    /// The surface is there with probability alpha.
    Blend,
}

/// What Fresnel reflectance a metal has.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum MetalFresnel {
    /// Schlick's approximation up to white at grazing angles, as glTF says.
    #[default]
    Schlick,
    /// The base colour at every angle (`extras.etendue.fresnel = "constant"`).
    Constant,
}

/// Transmission through the surface.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Volume {
    /// Distance after which white light has the attenuation colour; infinite for none. In file units.
    pub attenuation_distance: f64,
    /// The attenuation colour.
    pub attenuation_color: Spectrum,
}

/// A metallic-roughness material with its extensions. Textures multiply the factors beside them.
#[derive(Debug, Clone)]
pub struct Material {
    /// Its name, made up if the file gives none.
    pub name: String,
    /// Base colour factor, linear.
    pub base_color: Spectrum,
    /// Alpha factor.
    pub alpha: f32,
    /// Base colour (sRGB) and alpha texture.
    pub base_color_texture: Option<Texture>,
    /// Metalness, 0 to 1.
    pub metallic: f32,
    /// Perceptual roughness, 0 to 1: α is its square.
    pub roughness: f32,
    /// Roughness in green, metalness in blue.
    pub metallic_roughness_texture: Option<Texture>,
    /// Tangent-space normals, and their scale.
    pub normal_texture: Option<(Texture, f32)>,
    /// Emitted radiance, strength included.
    pub emission: Spectrum,
    /// Emission (sRGB) texture.
    pub emission_texture: Option<Texture>,
    /// Use of alpha.
    pub alpha_mode: AlphaMode,
    /// Whether the back emits too, and the camera sees it; both sides always scatter.
    pub double_sided: bool,
    /// KHR_materials_specular's strength; 0 is exactly Lambert.
    pub specular: f32,
    /// Strength in the texture's alpha.
    pub specular_texture: Option<Texture>,
    /// KHR_materials_specular's colour at normal incidence.
    pub specular_color: Spectrum,
    /// Specular colour (sRGB) texture.
    pub specular_color_texture: Option<Texture>,
    /// Refractive index, 1 or more; or 0, with which Schlick's formula gives reflectance 1 (KHR_materials_ior).
    pub ior: f32,
    /// KHR_materials_transmission's share of light that goes through.
    pub transmission: f32,
    /// Share in the texture's red.
    pub transmission_texture: Option<Texture>,
    /// `Some` for solid glass (KHR_materials_volume with a thickness above 0), `None` for a thin wall.
    pub volume: Option<Volume>,
    /// Which of the bodies that share a place has it: those of higher priority (`extras.etendue.priority`), then smaller ones.
    pub priority: i32,
    /// Fresnel of the metallic part.
    pub metal_fresnel: MetalFresnel,
    /// KHR_materials_unlit: emits its base colour and scatters nothing.
    pub unlit: bool,
}

impl Default for Material {
    /// glTF's default material.
    fn default() -> Self {
        Material {
            name: "default".into(),
            base_color: Spectrum::ONE,
            alpha: 1.0,
            base_color_texture: None,
            metallic: 1.0,
            roughness: 1.0,
            metallic_roughness_texture: None,
            normal_texture: None,
            emission: Spectrum::ZERO,
            emission_texture: None,
            alpha_mode: AlphaMode::Opaque,
            double_sided: false,
            specular: 1.0,
            specular_texture: None,
            specular_color: Spectrum::ONE,
            specular_color_texture: None,
            ior: 1.5,
            transmission: 0.0,
            transmission_texture: None,
            volume: None,
            priority: 0,
            metal_fresnel: MetalFresnel::Schlick,
            unlit: false,
        }
    }
}

/// What a punctual light does; it shines along −z of its transform.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum PunctualKind {
    /// Intensity in watts per steradian and lane.
    Point,
    /// Intensity on the axis in watts per steradian and lane, falling off between the angles (radians).
    Spot {
        /// Where the fall-off begins.
        inner: f32,
        /// Where it reaches zero.
        outer: f32,
    },
    /// Irradiance on a perpendicular surface in watts per square metre and lane.
    Directional,
}

/// A light without extent.
#[derive(Debug)]
pub struct PunctualLight {
    /// Its name.
    pub name: String,
    /// Its shape.
    pub kind: PunctualKind,
    /// Colour times intensity.
    pub intensity: Spectrum,
    /// Local to world.
    pub transform: DAffine3,
}

/// How a camera projects.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Projection {
    /// A pinhole.
    Perspective {
        /// Vertical field of view in radians.
        yfov: f64,
        /// Width over height, if the file says so.
        aspect: Option<f64>,
    },
    /// Parallel rays.
    Orthographic {
        /// Half the width of the view in scene units.
        xmag: f64,
        /// Half its height.
        ymag: f64,
    },
}

/// A camera, looking along −z of its transform with +y up.
#[derive(Debug, Clone)]
pub struct Camera {
    /// Its name, made up if the file gives none.
    pub name: String,
    /// Its projection.
    pub projection: Projection,
    /// Local to world.
    pub transform: DAffine3,
}
