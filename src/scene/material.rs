//! Compiled materials: a constant surface where nothing varies, texture lookups elsewhere, and bounds on the results.

use super::description::{self, AlphaMode, MetalFresnel};
use super::interior::Interior;
use super::usage::Usage;
use crate::bsdf::{Bsdf, Ggx, Lobes, MetallicRoughness, Surface, Wall};
use crate::light::{Coverage, Emission};
use crate::spectrum::Spectrum;
use crate::texture::{Extremes, Texture};
use glam::{Vec2, Vec4};
use std::sync::Arc;

/// A compiled material.
#[derive(Debug)]
pub(super) struct Material {
    /// The loaded material, with constant textures folded into its factors. Its alpha mode is opaque if alpha has no
    /// effect.
    pub(super) source: description::Material,
    /// The surface outside all other bodies, in full and without its straight transmission, if it is constant (apart
    /// from vertex colours).
    constant: Option<[Surface; 2]>,
    /// All lobes that occur anywhere.
    lobes: Lobes,
    /// Least roughness that occurs anywhere.
    least_roughness: f32,
    /// The emission texture, shared by the lights of the material.
    emission_texture: Option<Arc<Texture>>,
    /// Interior of objects of this material.
    pub(super) interior: Option<Interior>,
    /// See [`Material::is_culled`].
    culled: bool,
}

/// Lookup coordinates: both texture coordinate sets and the vertex colour.
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

/// Texture and vertex colour values at a point.
struct Found {
    base: [f32; 4],
    metallic_roughness: [f32; 4],
    specular: [f32; 4],
    specular_color: [f32; 4],
    transmission: [f32; 4],
    color: [f32; 4],
}

impl Material {
    /// Compiles `source` with its interior. `usage` holds the remaining variation: see [`settle`].
    pub(super) fn new(source: description::Material, usage: &Usage, interior: Option<Interior>) -> Self {
        let emission_texture = emission_map(&source).cloned().map(Arc::new);
        let least_roughness = source.roughness * usage.metallic_roughness.min[1];
        let (lobes, culled) = (Lobes::NONE, false);
        let mut material =
            Material { source, constant: None, lobes, least_roughness, emission_texture, interior, culled };
        let m = &material.source;
        let seen_through = m.unlit || material.emission().is_black() && m.transmission <= 0.0;
        material.culled = !m.double_sided && seen_through;
        if !material.has_surface_textures() {
            let whole = material.surface_of(&Found::corner(&Usage::NOTHING, 0), 1.0);
            material.constant = Some([whole, material.scattering(whole)]);
        }
        material.lobes = material.possible_lobes(usage);
        material
    }

    /// Returns the least slope deviation α of its glossy lobes; `None` without such a lobe.
    pub(super) fn least_slope(&self) -> Option<f64> {
        let m = &self.source;
        let is_glossy = !m.unlit && (m.metallic > 0.0 || m.specular > 0.0 || m.transmission > 0.0);
        is_glossy.then(|| f64::from(self.least_roughness).powi(2))
    }

    /// Returns whether it has a lobe wider than a mirror's.
    pub(super) fn has_wide_lobes(&self) -> bool {
        self.lobes.intersects(Lobes::SMOOTH)
    }

    /// Returns all lobes of the surfaces at the corners of its parameter box. These include all lobes within the box. A
    /// lobe is present depending on the sign of a weight, which is monotone in each parameter, or on the least
    /// roughness.
    fn possible_lobes(&self, usage: &Usage) -> Lobes {
        // Inside a body another index may surround the surface; it may then refract though it does not in empty space.
        let seen = |whole: Surface| if self.interior.is_some() { whole } else { self.scattering(whole) };
        let corners =
            (0..Found::CORNERS).map(|corner| seen(self.surface_of(&Found::corner(usage, corner), 1.0)).lobes());
        corners.fold(Lobes::NONE, Lobes::union)
    }

    /// Returns all lobes that occur on the objects of this material.
    pub(super) fn lobes(&self) -> Lobes {
        self.lobes
    }

    /// Returns whether a texture affects its scattering.
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

    /// Returns the surface outside all other bodies, in full and without its straight transmission, if neither textures
    /// nor vertex colours affect it.
    #[inline]
    pub(super) fn constant(&self) -> Option<&[Surface; 2]> {
        self.constant.as_ref()
    }

    /// Returns whether its surface depends neither on position (apart from vertex colours) nor on the medium around it.
    pub(super) fn is_plain(&self) -> bool {
        self.source.normal_texture.is_none() && self.constant.is_some_and(|[whole, _]| !whole.refracts())
    }

    /// Returns whether it may transmit light straight through with the outside index `outside`.
    pub(super) fn may_pass(&self, outside: f32) -> bool {
        let m = &self.source;
        if m.unlit || m.transmission <= 0.0 || m.metallic >= 1.0 || !self.emission().is_black() {
            return false;
        }
        match self.interior {
            Some(interior) => (interior.ior - outside).abs() <= 0.0,
            None => Ggx::new(self.least_roughness * self.least_roughness).is_dirac(),
        }
    }

    /// Returns the full surface at `at` with the outside index `outside`.
    pub(super) fn resolve(&self, at: &Coordinates, outside: f32) -> Surface {
        let m = &self.source;
        if m.unlit {
            return Surface::Black;
        }
        let found = Found {
            base: at.look_up(&m.base_color_texture),
            metallic_roughness: at.look_up(&m.metallic_roughness_texture),
            specular: at.look_up(&m.specular_texture),
            specular_color: at.look_up(&m.specular_color_texture),
            transmission: at.look_up(&m.transmission_texture),
            color: at.color.to_array(),
        };
        self.surface_of(&found, outside)
    }

    /// Returns the part of the surface `whole` that scatters: without straight transmission, unless it emits, since
    /// emitters are hit with their full coverage.
    fn scattering(&self, whole: Surface) -> Surface {
        if self.emission().is_black() { whole.rest() } else { whole }
    }

    fn surface_of(&self, found: &Found, outside: f32) -> Surface {
        let m = &self.source;
        if m.unlit {
            return Surface::Black;
        }
        let rgb = |[r, g, b, _]: [f32; 4]| Spectrum::from_rgb([r, g, b]);
        let [_, rough, metal, _] = found.metallic_roughness;
        let base = m.base_color * rgb(found.base) * rgb(found.color);
        MetallicRoughness {
            base,
            metallic: m.metallic * metal,
            roughness: m.roughness * rough,
            specular: m.specular * found.specular[3],
            specular_color: m.specular_color * rgb(found.specular_color),
            ior: m.ior,
            outside,
            transmission: m.transmission * found.transmission[0],
            wall: if m.volume.is_some() { Wall::Solid } else { Wall::Thin },
            metal_f90: if m.metal_fresnel == MetalFresnel::Constant { base } else { Spectrum::ONE },
        }
        .surface()
    }

    /// Returns the alpha at `at` from factor, texture and vertex colour.
    pub(super) fn alpha(&self, at: &Coordinates) -> f32 {
        self.source.alpha * at.look_up(&self.source.base_color_texture)[3] * at.color.w
    }

    /// Returns whether it transmits light into a body.
    pub(super) fn refracts(&self) -> bool {
        self.lobes.intersects(Lobes::TRANSMIT.union(Lobes::DIRAC_TRANSMIT)) && self.source.volume.is_some()
    }

    /// Returns whether rays continue behind it: it transmits, or blends by alpha.
    pub(super) fn lets_light_pass(&self) -> bool {
        self.source.transmission > 0.0 || self.source.alpha_mode == AlphaMode::Blend
    }

    /// Returns whether its back is culled for the camera: it is single-sided, and unlit or neither emitting nor
    /// transmitting.
    #[inline]
    pub(super) fn is_culled(&self) -> bool {
        self.culled
    }

    /// Returns the radiance factor of the emission, without textures.
    pub(super) fn emission(&self) -> Spectrum {
        if self.source.unlit { self.source.base_color } else { self.source.emission }
    }

    /// Returns the emission of a triangle with the given texture coordinates (by set) and vertex colours at its
    /// corners; `None` if it is black or has zero coverage everywhere.
    pub(super) fn emission_of(
        &self,
        uvs: impl Fn(usize) -> Option<[Vec2; 3]>,
        colors: Option<[Vec4; 3]>,
    ) -> Option<Emission> {
        let corner_uvs = |t: &Texture| uvs(t.uv_set).unwrap_or_default();
        let texture = self.emission_texture.as_ref().map(|t| Box::new((Arc::clone(t), corner_uvs(t))));
        let m = &self.source;
        let coverage = (m.alpha_mode != AlphaMode::Opaque).then(|| {
            Box::new(Coverage {
                corners: colors.map_or([1.0; 3], |colors| colors.map(|c| c.w)).map(|a| a * m.alpha),
                texture: m.base_color_texture.as_ref().map(|t| (Arc::new(t.clone()), corner_uvs(t))),
                cutoff: if let AlphaMode::Mask { cutoff } = m.alpha_mode { Some(cutoff) } else { None },
            })
        });
        // Vertex colours multiply the base colour, which is the emission of unlit materials [KHR_materials_unlit].
        let shown = colors.filter(|_| m.unlit);
        let corners = shown.map(|colors| Box::new(colors.map(|c| Spectrum::from_rgb(c.truncate().to_array()))));
        let (radiance, two_sided, only_seen) = (self.emission(), m.double_sided, m.unlit);
        let emission = Emission { radiance, texture, corners, two_sided, only_seen, coverage };
        (!emission.is_black()).then_some(emission)
    }

    /// Returns the mean linear colour of the emission texture, white without one.
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

/// Returns the texture that multiplies the emission factor.
fn emission_map(source: &description::Material) -> Option<&Texture> {
    if source.unlit { source.base_color_texture.as_ref() } else { source.emission_texture.as_ref() }
}

impl Found {
    /// Number of corners of the box of the parameters that determine lobes.
    const CORNERS: u32 = 1 << 5;

    /// Returns the extremes of one corner; each bit selects the end of one parameter.
    fn corner(usage: &Usage, corner: u32) -> Self {
        let end = |bit: u32, of: &Extremes| if corner >> bit & 1 == 0 { of.min } else { of.max };
        let [rough, metal] = [end(1, &usage.metallic_roughness)[1], end(2, &usage.metallic_roughness)[2]];
        Found {
            base: end(0, &usage.base),
            metallic_roughness: [1.0, rough, metal, 1.0],
            specular: end(3, &usage.specular),
            specular_color: usage.specular_color.max,
            transmission: end(4, &usage.transmission),
            color: end(0, &usage.colors),
        }
    }
}

/// Folds constant textures into the factors, and removes these textures from both `m` and `usage`. Sets the alpha mode
/// to opaque if alpha has no effect.
pub(super) fn settle(m: &mut description::Material, usage: &mut Usage) {
    let holes = match m.alpha_mode {
        AlphaMode::Opaque => false,
        AlphaMode::Mask { cutoff } => least_alpha(m, usage) < cutoff,
        AlphaMode::Blend => least_alpha(m, usage) < 1.0,
    };
    if !holes {
        m.alpha_mode = AlphaMode::Opaque;
    }
    let rgb = |[r, g, b, _]: [f32; 4]| Spectrum::from_rgb([r, g, b]);
    if let Some(base) = take(&mut m.base_color_texture, &mut usage.base, if holes { &[0, 1, 2, 3] } else { &[0, 1, 2] })
    {
        m.base_color *= rgb(base);
        m.alpha *= base[3];
    }
    if let Some([_, rough, metal, _]) = take(&mut m.metallic_roughness_texture, &mut usage.metallic_roughness, &[1, 2])
    {
        m.roughness *= rough;
        m.metallic *= metal;
    }
    if let Some(emission) = take(&mut m.emission_texture, &mut usage.emission, &[0, 1, 2]) {
        m.emission *= rgb(emission);
    }
    if let Some(specular) = take(&mut m.specular_texture, &mut usage.specular, &[3]) {
        m.specular *= specular[3];
    }
    if let Some(color) = take(&mut m.specular_color_texture, &mut usage.specular_color, &[0, 1, 2]) {
        m.specular_color *= rgb(color);
    }
    if let Some(transmission) = take(&mut m.transmission_texture, &mut usage.transmission, &[0]) {
        m.transmission *= transmission[0];
    }
}

/// Removes the texture if the relevant `channels` are constant wherever it is used; returns their values.
fn take(texture: &mut Option<Texture>, extremes: &mut Extremes, channels: &[usize]) -> Option<[f32; 4]> {
    let constant = texture.is_some() && extremes.is_constant(channels);
    let value = constant.then_some(extremes.min)?;
    (*texture, *extremes) = (None, Extremes::ONE);
    Some(value)
}

fn least_alpha(m: &description::Material, usage: &Usage) -> f32 {
    let ends = |e: &Extremes| [e.min[3], e.max[3]];
    let products =
        ends(&usage.base).into_iter().flat_map(|base| ends(&usage.colors).map(|color| m.alpha * base * color));
    products.fold(f32::INFINITY, f32::min)
}
