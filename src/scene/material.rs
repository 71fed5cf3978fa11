//! Materials as shading uses them: a constant surface where nothing varies, textures looked up where something does.

use super::description::{self, AlphaMode, MetalFresnel};
use crate::bsdf::{MetallicRoughness, Surface, Wall};
use crate::geometry::MediumId;
use crate::light::{Coverage, Emission};
use crate::spectrum::Spectrum;
use crate::texture::Texture;
use glam::{Vec2, Vec4};
use std::sync::Arc;

/// A compiled material.
#[derive(Debug)]
pub(super) struct Material {
    /// As loaded.
    pub(super) source: description::Material,
    /// The surface, if it is the same everywhere (vertex colours apart).
    constant: Option<Surface>,
    /// The emission texture, shared by the lights of the material.
    emission_texture: Option<Arc<Texture>>,
    /// What is inside an object of this material.
    pub(super) interior: MediumId,
    /// See [`Material::is_culled`].
    culled: bool,
}

/// Where textures are looked up: coordinates of both sets and the vertex colour.
#[derive(Debug, Clone, Copy)]
pub(super) struct Coordinates {
    pub(super) uvs: [Vec2; 2],
    pub(super) color: Vec4,
}

impl Coordinates {
    fn look_up(&self, texture: &Option<Texture>) -> [f32; 4] {
        texture.as_ref().map_or([1.0; 4], |t| t.at(self.uvs[t.uv_set]))
    }
}

impl Material {
    pub(super) fn new(source: description::Material, interior: MediumId) -> Self {
        let nowhere = Coordinates { uvs: [Vec2::ZERO; 2], color: Vec4::ONE };
        let emission_texture = emission_map(&source).cloned().map(Arc::new);
        let mut material = Material { source, constant: None, emission_texture, interior, culled: false };
        let m = &material.source;
        material.culled = !m.double_sided && material.emission().is_black() && m.transmission <= 0.0;
        if !material.has_surface_textures() {
            material.constant = Some(material.resolve(&nowhere));
        }
        material
    }

    /// Whether a texture changes how it scatters.
    pub(super) fn has_surface_textures(&self) -> bool {
        let m = &self.source;
        !m.unlit
            && [
                &m.base_color_texture,
                &m.metallic_roughness_texture,
                &m.specular_texture,
                &m.specular_color_texture,
                &m.transmission_texture,
            ]
            .into_iter()
            .any(Option::is_some)
    }

    /// The surface, if neither textures nor vertex colours change it.
    #[inline]
    pub(super) fn constant(&self) -> Option<&Surface> {
        self.constant.as_ref()
    }

    /// The surface at `at`.
    pub(super) fn resolve(&self, at: &Coordinates) -> Surface {
        let m = &self.source;
        if m.unlit {
            return Surface::Black;
        }
        let [r, g, b, _] = at.look_up(&m.base_color_texture);
        let [_, rough, metal, _] = at.look_up(&m.metallic_roughness_texture);
        let [sr, sg, sb, _] = at.look_up(&m.specular_color_texture);
        let vertex = Spectrum::from_rgb(at.color.truncate().to_array());
        let base = m.base_color * Spectrum::from_rgb([r, g, b]) * vertex;
        MetallicRoughness {
            base,
            metallic: m.metallic * metal,
            roughness: m.roughness * rough,
            specular: m.specular * at.look_up(&m.specular_texture)[3],
            specular_color: m.specular_color * Spectrum::from_rgb([sr, sg, sb]),
            ior: m.ior,
            transmission: m.transmission * at.look_up(&m.transmission_texture)[0],
            wall: if m.volume.is_some() { Wall::Solid } else { Wall::Thin },
            metal_f90: if m.metal_fresnel == MetalFresnel::Constant { base } else { Spectrum::ONE },
        }
        .surface()
    }

    /// Coverage at `at` by factor, texture and vertex colour.
    pub(super) fn alpha(&self, at: &Coordinates) -> f32 {
        self.source.alpha * at.look_up(&self.source.base_color_texture)[3] * at.color.w
    }

    /// Whether alpha makes holes in it, whatever its textures say; `has_colors` if the mesh has vertex colours.
    pub(super) fn has_holes(&self, has_colors: bool) -> bool {
        let varies = self.source.base_color_texture.is_some() || has_colors;
        match self.source.alpha_mode {
            AlphaMode::Opaque => false,
            AlphaMode::Mask { cutoff } => varies || self.source.alpha < cutoff,
            AlphaMode::Blend => varies || self.source.alpha < 1.0,
        }
    }

    /// Whether rays go on behind it: it transmits, or blends by alpha.
    pub(super) fn lets_light_pass(&self, has_colors: bool) -> bool {
        self.source.transmission > 0.0 || self.source.alpha_mode == AlphaMode::Blend && self.has_holes(has_colors)
    }

    /// Whether the camera sees through its back: single-sided, without light of its own or through it.
    #[inline]
    pub(super) fn is_culled(&self) -> bool {
        self.culled
    }

    /// Radiance factor of the emission, textures apart.
    pub(super) fn emission(&self) -> Spectrum {
        if self.source.unlit { self.source.base_color } else { self.source.emission }
    }

    /// The emission of a triangle with the given texture coordinates (by set) and vertex alpha at its corners.
    pub(super) fn emission_of(&self, uvs: impl Fn(usize) -> Option<[Vec2; 3]>, alphas: Option<[f32; 3]>) -> Emission {
        let corner_uvs = |t: &Texture| uvs(t.uv_set).unwrap_or_default();
        let texture = self.emission_texture.as_ref().map(|t| Box::new((Arc::clone(t), corner_uvs(t))));
        let m = &self.source;
        let coverage = self.has_holes(alphas.is_some()).then(|| {
            Box::new(Coverage {
                corners: alphas.unwrap_or([1.0; 3]).map(|a| a * m.alpha),
                texture: m.base_color_texture.as_ref().map(|t| (Arc::new(t.clone()), corner_uvs(t))),
                cutoff: if let AlphaMode::Mask { cutoff } = m.alpha_mode { Some(cutoff) } else { None },
            })
        });
        Emission { radiance: self.emission(), texture, two_sided: m.double_sided || m.unlit, coverage }
    }

    /// Mean linear colour of the emission texture, white without one.
    pub(super) fn mean_emission_texture(&self) -> Spectrum {
        self.emission_texture.as_ref().map_or(Spectrum::ONE, |t| {
            let [r, g, b, _] = t.image.mean(t.encoding);
            Spectrum::from_rgb([r, g, b])
        })
    }

    /// Bytes of images, counted once per image in `seen`.
    pub(super) fn images(&self) -> impl Iterator<Item = &Texture> {
        let m = &self.source;
        let normal = m.normal_texture.as_ref().map(|(t, _)| t);
        [
            &m.base_color_texture,
            &m.metallic_roughness_texture,
            &m.emission_texture,
            &m.specular_texture,
            &m.specular_color_texture,
            &m.transmission_texture,
        ]
        .into_iter()
        .filter_map(Option::as_ref)
        .chain(normal)
    }
}

/// The texture that the emission factor is multiplied with.
fn emission_map(source: &description::Material) -> Option<&Texture> {
    if source.unlit { source.base_color_texture.as_ref() } else { source.emission_texture.as_ref() }
}
