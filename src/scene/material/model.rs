//! Scattering models of materials: their textures, their limits, and the surface at one point. A new model is a struct
//! and a variant of [`MaterialModel`], with an arm in each match here and in `settle`, `usage` and the hash.

use super::Coordinates;
use crate::bsdf::{Lambert, MetallicRoughness, Surface, Wall};
use crate::scene::description::{DiffuseMaterial, MaterialModel, MetalFresnel, MetallicRoughnessMaterial, Volume};
use crate::scene::usage::Usage;
use crate::spectrum::Spectrum;
use crate::texture::{Extremes, Texture};

/// An opaque metallic-roughness surface with textures of its colour, roughness and metalness, and a normal map.
#[derive(Debug, Clone, Copy)]
pub struct TexturedSurface<'a> {
    /// Its parameters where the textures are white.
    pub factors: MetallicRoughness,
    /// Colour.
    pub base_color: Option<&'a Texture>,
    /// Roughness in green, metalness in blue.
    pub metallic_roughness: Option<&'a Texture>,
    /// Shading normals.
    pub normal: Option<&'a Texture>,
}

/// Texture and vertex colour values at a point, 1 where the model has no such texture.
pub(super) struct TextureValues {
    base: [f32; 4],
    metallic_roughness: [f32; 4],
    specular: [f32; 4],
    specular_color: [f32; 4],
    transmission: [f32; 4],
    color: [f32; 4],
}

impl TextureValues {
    /// Values without textures.
    pub(super) const ONE: TextureValues = TextureValues {
        base: [1.0; 4],
        metallic_roughness: [1.0; 4],
        specular: [1.0; 4],
        specular_color: [1.0; 4],
        transmission: [1.0; 4],
        color: [1.0; 4],
    };

    /// Number of corners of the box of the parameters that determine lobes.
    pub(super) const CORNERS: u32 = 1 << 5;

    /// Returns the extremes of one corner; each bit selects the end of one parameter.
    pub(super) fn corner(usage: &Usage, corner: u32) -> Self {
        let end = |bit: u32, of: &Extremes| if corner >> bit & 1 == 0 { of.min } else { of.max };
        let [rough, metal] = [end(1, &usage.metallic_roughness)[1], end(2, &usage.metallic_roughness)[2]];
        TextureValues {
            base: end(0, &usage.base),
            metallic_roughness: [1.0, rough, metal, 1.0],
            specular: end(3, &usage.specular),
            specular_color: usage.specular_color.max,
            transmission: end(4, &usage.transmission),
            color: end(0, &usage.colors),
        }
    }
}

impl MaterialModel {
    /// Returns all textures that affect scattering.
    pub(super) fn textures(&self) -> impl Iterator<Item = &Texture> {
        let textures = match self {
            MaterialModel::Unlit => [None; 5],
            MaterialModel::Diffuse(m) => [m.reflectance_texture.as_ref(), None, None, None, None],
            MaterialModel::MetallicRoughness(m) => [
                m.base_color_texture.as_ref(),
                m.metallic_roughness_texture.as_ref(),
                m.specular_texture.as_ref(),
                m.specular_color_texture.as_ref(),
                m.transmission_texture.as_ref(),
            ],
        };
        textures.into_iter().flatten()
    }

    /// Returns it with the normal map `normal`, if it is a [`TexturedSurface`].
    pub(in crate::scene) fn textured<'a>(&'a self, normal: Option<&'a Texture>) -> Option<TexturedSurface<'a>> {
        let MaterialModel::MetallicRoughness(m) = self else { return None };
        let others = [&m.specular_texture, &m.specular_color_texture, &m.transmission_texture];
        let is_plain = m.transmission <= 0.0 && m.metal_fresnel == MetalFresnel::Schlick;
        (is_plain && others.iter().all(|texture| texture.is_none())).then(|| TexturedSurface {
            factors: m.parameters(&TextureValues::ONE, 1.0),
            base_color: m.base_color_texture.as_ref(),
            metallic_roughness: m.metallic_roughness_texture.as_ref(),
            normal,
        })
    }

    /// Returns whether it has a glossy lobe.
    pub(super) fn is_glossy(&self) -> bool {
        match self {
            MaterialModel::Unlit | MaterialModel::Diffuse(_) => false,
            MaterialModel::MetallicRoughness(m) => m.metallic > 0.0 || m.specular > 0.0 || m.transmission > 0.0,
        }
    }

    /// Returns the least perceptual roughness of the textured model.
    pub(super) fn least_roughness(&self, usage: &Usage) -> f32 {
        match self {
            MaterialModel::Unlit | MaterialModel::Diffuse(_) => 1.0,
            MaterialModel::MetallicRoughness(m) => m.roughness * usage.metallic_roughness.min[1],
        }
    }

    /// Returns whether light passes it.
    pub(in crate::scene) fn transmits(&self) -> bool {
        match self {
            MaterialModel::Unlit | MaterialModel::Diffuse(_) => false,
            MaterialModel::MetallicRoughness(m) => m.transmission > 0.0 && m.metallic < 1.0,
        }
    }

    /// Returns the refractive index and attenuation of the body that transmitted light enters, if there is one.
    pub(super) fn inside(&self) -> Option<(f32, &Volume)> {
        match self {
            MaterialModel::MetallicRoughness(m) if self.transmits() && m.ior >= 1.0 => {
                Some((m.ior, m.volume.as_ref()?))
            }
            _ => None,
        }
    }

    /// Returns the texture values at `at`.
    pub(super) fn values(&self, at: &Coordinates) -> TextureValues {
        let plain = TextureValues { color: at.color.to_array(), ..TextureValues::ONE };
        match self {
            MaterialModel::Unlit => plain,
            MaterialModel::Diffuse(m) => TextureValues { base: at.look_up(&m.reflectance_texture), ..plain },
            MaterialModel::MetallicRoughness(m) => TextureValues {
                base: at.look_up(&m.base_color_texture),
                metallic_roughness: at.look_up(&m.metallic_roughness_texture),
                specular: at.look_up(&m.specular_texture),
                specular_color: at.look_up(&m.specular_color_texture),
                transmission: at.look_up(&m.transmission_texture),
                ..plain
            },
        }
    }

    /// Returns the full surface with these texture values and the outside index `outside`.
    pub(super) fn surface(&self, values: &TextureValues, outside: f32) -> Surface {
        match self {
            MaterialModel::Unlit => Surface::Black,
            MaterialModel::Diffuse(m) => m.surface(values),
            MaterialModel::MetallicRoughness(m) => m.parameters(values, outside).surface(),
        }
    }
}

impl DiffuseMaterial {
    fn surface(&self, values: &TextureValues) -> Surface {
        let albedo = self.reflectance * rgb(values.base) * rgb(values.color);
        if albedo.is_black() { Surface::Black } else { Surface::Lambert(Lambert { albedo }) }
    }
}

impl MetallicRoughnessMaterial {
    fn parameters(&self, values: &TextureValues, outside: f32) -> MetallicRoughness {
        let [_, rough, metal, _] = values.metallic_roughness;
        let base = self.base_color * rgb(values.base) * rgb(values.color);
        MetallicRoughness {
            base,
            metallic: self.metallic * metal,
            roughness: self.roughness * rough,
            specular: self.specular * values.specular[3],
            specular_color: self.specular_color * rgb(values.specular_color),
            ior: self.ior,
            outside,
            transmission: self.transmission * values.transmission[0],
            wall: if self.volume.is_some() { Wall::Solid } else { Wall::Thin },
            metal_f90: if self.metal_fresnel == MetalFresnel::Constant { base } else { Spectrum::ONE },
        }
    }
}

/// Returns the colour of a texture value without its alpha.
pub(super) fn rgb([r, g, b, _]: [f32; 4]) -> Spectrum {
    Spectrum::from_rgb([r, g, b])
}
