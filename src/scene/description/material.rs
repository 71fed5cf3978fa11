//! Materials as loaded: a scattering model, with the properties that all models share.

use crate::medium::Phase;
use crate::spectrum::Spectrum;
use crate::texture::Texture;

/// Interpretation of alpha.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub enum AlphaMode {
    /// Alpha is ignored.
    #[default]
    Opaque,
    /// The surface exists where alpha reaches the cutoff.
    Mask {
        /// The cutoff.
        cutoff: f32,
    },
    /// The surface exists with probability alpha.
    Blend,
}

/// Fresnel reflectance of metals.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum MetalFresnel {
    /// Schlick's approximation, rising to white at grazing angles, as specified by glTF.
    #[default]
    Schlick,
    /// The base colour at every angle (`extras.etendue.fresnel = "constant"`).
    Constant,
}

/// The medium inside a solid.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Volume {
    /// Absorption coefficient per file unit of length.
    pub absorption: Spectrum,
    /// Scattering coefficient per file unit of length.
    pub scattering: Spectrum,
    /// Emitted radiance per file unit of length.
    pub emission: Spectrum,
    /// How it scatters.
    pub phase: Phase,
    /// Index into [`Description::densities`](super::Description::densities) of what multiplies its coefficients; `None`
    /// is 1 everywhere.
    pub density: Option<usize>,
    /// Index into [`Description::albedos`](super::Description::albedos) of what multiplies its scattering; what that
    /// takes away is absorbed. `None` is 1 everywhere.
    pub albedo: Option<usize>,
    /// Index into [`Description::emissions`](super::Description::emissions) of what multiplies its emission; `None` is
    /// 1 everywhere.
    pub emission_grid: Option<usize>,
}

impl Volume {
    /// A medium that light passes unchanged.
    pub const CLEAR: Volume = Volume {
        absorption: Spectrum::ZERO,
        scattering: Spectrum::ZERO,
        emission: Spectrum::ZERO,
        phase: Phase::Isotropic,
        density: None,
        albedo: None,
        emission_grid: None,
    };

    /// Returns the medium in which white light takes `color` (0 to 1) by absorption after `distance` in file units.
    pub fn absorbing(distance: f64, color: Spectrum) -> Volume {
        let coefficient = |c: f32| (-f64::from(c.clamp(f32::MIN_POSITIVE, 1.0)).ln() / distance) as f32 + 0.0; // not −0
        Volume { absorption: color.map(|c: f32| coefficient(c).min(MOST_ABSORPTION)), ..Volume::CLEAR }
    }
}

/// Greatest coefficient of absorption from a distance and a colour: nothing passes, and all products stay within f32.
const MOST_ABSORPTION: f32 = 1e12;

/// A material: how a surface scatters, what it emits, and where it exists. Each texture multiplies its factor.
#[derive(Debug, Clone)]
pub struct Material {
    /// Name, generated if the file has none.
    pub name: String,
    /// How it scatters.
    pub model: MaterialModel,
    /// Alpha factor.
    pub alpha: f32,
    /// Alpha in the texture's alpha channel.
    pub alpha_texture: Option<Texture>,
    /// Interpretation of alpha.
    pub alpha_mode: AlphaMode,
    /// Tangent-space normals, and their scale.
    pub normal_texture: Option<(Texture, f32)>,
    /// Emitted radiance, strength included.
    pub emission: Spectrum,
    /// Emission (sRGB) texture.
    pub emission_texture: Option<Texture>,
    /// Whether the back emits and is visible to the camera; both sides always scatter.
    pub double_sided: bool,
    /// Precedence of overlapping bodies: higher priority first, then smaller bodies.
    pub priority: i32,
}

/// Scattering model of a material.
#[derive(Debug, Clone)]
#[allow(clippy::large_enum_variant)] // scenes have few materials
pub enum MaterialModel {
    /// Does not scatter. The emission is multiplied by vertex colours, seen by the camera, and illuminates nothing.
    Unlit,
    /// Lambertian reflection.
    Diffuse(DiffuseMaterial),
    /// Metals, dielectrics and mixtures of both, by metalness and roughness.
    MetallicRoughness(MetallicRoughnessMaterial),
}

/// Lambertian reflection; vertex colours multiply the reflectance.
#[derive(Debug, Clone)]
pub struct DiffuseMaterial {
    /// Reflectance, 0 to 1.
    pub reflectance: Spectrum,
    /// Reflectance (sRGB) texture.
    pub reflectance_texture: Option<Texture>,
}

/// glTF's metallic-roughness model with specular, ior, transmission and volume [glTF20]; vertex colours multiply the
/// base colour.
#[derive(Debug, Clone)]
pub struct MetallicRoughnessMaterial {
    /// Base colour factor, linear.
    pub base_color: Spectrum,
    /// Base colour (sRGB) texture.
    pub base_color_texture: Option<Texture>,
    /// Metalness, 0 to 1.
    pub metallic: f32,
    /// Perceptual roughness, 0 to 1: α is its square.
    pub roughness: f32,
    /// Roughness in green, metalness in blue.
    pub metallic_roughness_texture: Option<Texture>,
    /// Strength of the dielectric reflection; 0 is exactly Lambertian.
    pub specular: f32,
    /// Strength in the texture's alpha channel.
    pub specular_texture: Option<Texture>,
    /// Colour of the dielectric reflection at normal incidence.
    pub specular_color: Spectrum,
    /// Specular colour (sRGB) texture.
    pub specular_color_texture: Option<Texture>,
    /// Refractive index, at least 1; or 0, for which Schlick's formula gives reflectance 1.
    pub ior: f32,
    /// Transmitted fraction of light.
    pub transmission: f32,
    /// Transmitted fraction in the texture's red channel.
    pub transmission_texture: Option<Texture>,
    /// `Some` for solid glass, `None` for a thin wall.
    pub volume: Option<Volume>,
    /// Fresnel reflectance of the metallic part.
    pub metal_fresnel: MetalFresnel,
}

impl Default for Material {
    /// An opaque one-sided material of the default [`MetallicRoughnessMaterial`], which emits nothing.
    fn default() -> Self {
        Material {
            name: "default".into(),
            model: MaterialModel::MetallicRoughness(MetallicRoughnessMaterial::default()),
            alpha: 1.0,
            alpha_texture: None,
            alpha_mode: AlphaMode::Opaque,
            normal_texture: None,
            emission: Spectrum::ZERO,
            emission_texture: None,
            double_sided: false,
            priority: 0,
        }
    }
}

impl Default for MetallicRoughnessMaterial {
    /// White metal of roughness 1, the default of glTF.
    fn default() -> Self {
        MetallicRoughnessMaterial {
            base_color: Spectrum::ONE,
            base_color_texture: None,
            metallic: 1.0,
            roughness: 1.0,
            metallic_roughness_texture: None,
            specular: 1.0,
            specular_texture: None,
            specular_color: Spectrum::ONE,
            specular_color_texture: None,
            ior: 1.5,
            transmission: 0.0,
            transmission_texture: None,
            volume: None,
            metal_fresnel: MetalFresnel::Schlick,
        }
    }
}

impl Material {
    /// Returns an opaque one-sided material of Lambertian reflectance `reflectance`.
    pub fn diffuse(reflectance: Spectrum) -> Self {
        let model = MaterialModel::Diffuse(DiffuseMaterial { reflectance, reflectance_texture: None });
        Material { name: "diffuse".into(), model, ..Material::default() }
    }

    /// Whether it does not scatter: see [`MaterialModel::Unlit`].
    pub fn is_unlit(&self) -> bool {
        matches!(self.model, MaterialModel::Unlit)
    }
}

impl From<MetallicRoughnessMaterial> for Material {
    /// An opaque one-sided material.
    fn from(model: MetallicRoughnessMaterial) -> Self {
        Material { model: MaterialModel::MetallicRoughness(model), ..Material::default() }
    }
}
