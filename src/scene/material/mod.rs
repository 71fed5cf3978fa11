//! Compiled materials: a constant surface where nothing varies, texture lookups elsewhere, and bounds on the results.

mod model;
mod settle;

pub use model::TexturedSurface;
pub(super) use settle::settle;

use super::description::{self, AlphaMode};
use super::interior::Interior;
use super::rebase::Rebase;
use super::usage::Usage;
use crate::bsdf::{Bsdf, Ggx, Lobes, Surface};
use crate::light::{Coverage, Emission};
use crate::medium::Homogeneous;
use crate::spectrum::Spectrum;
use crate::texture::Texture;
use glam::{Vec2, Vec4};
use model::TextureValues;
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

impl Material {
    /// Compiles `source` for a scene in the units of `rebase`. `usage` holds the remaining variation: see [`settle`].
    pub(super) fn new(source: description::Material, usage: &Usage, rebase: &Rebase) -> Self {
        let interior = interior(&source, rebase);
        let emission_texture = source.emission_texture.clone().map(Arc::new);
        let least_roughness = source.model.least_roughness(usage);
        let (lobes, culled) = (Lobes::NONE, false);
        let mut material =
            Material { source, constant: None, lobes, least_roughness, emission_texture, interior, culled };
        let m = &material.source;
        let seen_through = m.is_unlit() || material.emission().is_black() && !m.model.transmits();
        material.culled = !m.double_sided && seen_through;
        if !material.has_surface_textures() {
            let whole = m.model.surface(&TextureValues::ONE, 1.0);
            material.constant = Some([whole, material.scattering(whole)]);
        }
        material.lobes = material.possible_lobes(usage);
        material
    }

    /// Returns the least slope deviation α of its glossy lobes; `None` without such a lobe.
    pub(super) fn least_slope(&self) -> Option<f64> {
        self.source.model.is_glossy().then(|| f64::from(self.least_roughness).powi(2))
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
        let surface = |corner| self.source.model.surface(&TextureValues::corner(usage, corner), 1.0);
        let corners = (0..TextureValues::CORNERS).map(|corner| seen(surface(corner)).lobes());
        corners.fold(Lobes::NONE, Lobes::union)
    }

    /// Returns all lobes that occur on the objects of this material.
    pub(super) fn lobes(&self) -> Lobes {
        self.lobes
    }

    /// Returns whether a texture affects its scattering.
    pub(super) fn has_surface_textures(&self) -> bool {
        self.source.model.textures().next().is_some()
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
        if !self.source.model.transmits() || !self.emission().is_black() {
            return false;
        }
        match self.interior {
            Some(interior) => (interior.ior - outside).abs() <= 0.0,
            None => Ggx::new(self.least_roughness * self.least_roughness).is_dirac(),
        }
    }

    /// Returns the full surface at `at` with the outside index `outside`.
    pub(super) fn resolve(&self, at: &Coordinates, outside: f32) -> Surface {
        let model = &self.source.model;
        model.surface(&model.values(at), outside)
    }

    /// Returns the part of the surface `whole` that scatters: without straight transmission, unless it emits, since
    /// emitters are hit with their full coverage.
    fn scattering(&self, whole: Surface) -> Surface {
        if self.emission().is_black() { whole.rest() } else { whole }
    }

    /// Returns the alpha at `at` from factor, texture and vertex colour.
    pub(super) fn alpha(&self, at: &Coordinates) -> f32 {
        self.source.alpha * at.look_up(&self.source.alpha_texture)[3] * at.color.w
    }

    /// Returns whether it transmits light into a body.
    pub(super) fn refracts(&self) -> bool {
        self.lobes.intersects(Lobes::TRANSMIT.union(Lobes::DIRAC_TRANSMIT)) && self.interior.is_some()
    }

    /// Returns whether rays continue behind it: it transmits, or blends by alpha.
    pub(super) fn lets_light_pass(&self) -> bool {
        self.source.model.transmits() || self.source.alpha_mode == AlphaMode::Blend
    }

    /// Returns whether its back is culled for the camera: it is single-sided, and unlit or neither emitting nor
    /// transmitting.
    #[inline]
    pub(super) fn is_culled(&self) -> bool {
        self.culled
    }

    /// Returns the radiance factor of the emission, without textures.
    pub(super) fn emission(&self) -> Spectrum {
        self.source.emission
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
                texture: m.alpha_texture.as_ref().map(|t| (Arc::new(t.clone()), corner_uvs(t))),
                cutoff: if let AlphaMode::Mask { cutoff } = m.alpha_mode { Some(cutoff) } else { None },
            })
        });
        let shown = colors.filter(|_| m.is_unlit());
        let corners = shown.map(|colors| Box::new(colors.map(|c| Spectrum::from_rgb(c.truncate().to_array()))));
        let (radiance, two_sided, only_seen) = (self.emission(), m.double_sided, m.is_unlit());
        let emission = Emission { radiance, texture, corners, two_sided, only_seen, coverage };
        (!emission.is_black()).then_some(emission)
    }

    /// Returns all its textures.
    pub(super) fn images(&self) -> impl Iterator<Item = &Texture> {
        let m = &self.source;
        let normal = m.normal_texture.as_ref().map(|(t, _)| t);
        m.model.textures().chain(&m.alpha_texture).chain(&m.emission_texture).chain(normal)
    }
}

/// Returns the interior of a transmitting material with a volume.
fn interior(m: &description::Material, rebase: &Rebase) -> Option<Interior> {
    let (ior, volume) = m.model.inside()?;
    let rebased = |coefficient: Spectrum| coefficient.map(|s: f32| (f64::from(s) / rebase.scale) as f32);
    let medium = Homogeneous::new(rebased(volume.absorption), rebased(volume.scattering), volume.phase)
        .emitting(rebased(volume.emission));
    let &description::Volume { density, albedo, emission_grid, .. } = volume;
    Some(Interior { medium, density, albedo, emission_grid, ior, priority: m.priority })
}
