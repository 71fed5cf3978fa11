//! Parameters of the metallic-roughness model at one point, and the cheapest surface model that represents them
//! exactly.

use super::albedo::Albedo;
use super::metal_dielectric::{MetalDielectric, Schlick, Transmission};
use super::{Conductor, Dielectric, Fresnel, Ggx, Lambert, Surface, Thin};
use crate::spectrum::Spectrum;

/// Geometry behind a transmitting surface.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Wall {
    /// A sheet without interior or refraction.
    Thin,
    /// A refracting solid. A refractive index below 1 (glTF's 0 means that everything is reflected) is treated as a
    /// sheet.
    Solid,
}

/// Parameters of glTF's metallic-roughness model with specular, ior and transmission, after texturing [glTF20].
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct MetallicRoughness {
    /// Base colour, 0 to 1.
    pub base: Spectrum,
    /// Metalness, 0 to 1.
    pub metallic: f32,
    /// Perceptual roughness, 0 to 1: α is its square.
    pub roughness: f32,
    /// Strength of the dielectric reflection, 0 to 1.
    pub specular: f32,
    /// Colour of the dielectric reflection at normal incidence.
    pub specular_color: Spectrum,
    /// Refractive index.
    pub ior: f32,
    /// Refractive index outside a solid: 1 for empty space.
    pub outside: f32,
    /// Share of the base that transmits light, 0 to 1.
    pub transmission: f32,
    /// Geometry behind the surface.
    pub wall: Wall,
    /// Reflectance of the metal at grazing angles: white in glTF, the base colour for a constant Fresnel.
    pub metal_f90: Spectrum,
}

impl MetallicRoughness {
    /// Returns the surface with these parameters: a plain model if one is equivalent, [`Surface::MetalDielectric`] for
    /// mixtures.
    pub fn surface(&self) -> Surface {
        let ggx = Ggx::new(self.roughness * self.roughness);
        if self.metallic >= 1.0 {
            return Surface::Conductor(Conductor {
                ggx,
                fresnel: Fresnel::Schlick { f0: self.base, f90: self.metal_f90 },
            });
        }
        let layer = self.layer();
        if self.metallic <= 0.0 && self.transmission >= 1.0 {
            return match self.glass(1.0) {
                Some(glass) => Surface::Dielectric(glass),
                None => {
                    let fresnel = Fresnel::Schlick { f0: layer.f0, f90: layer.f90 };
                    Surface::Thin(Thin { ggx, fresnel, transmit: self.base })
                }
            };
        }
        if self.metallic <= 0.0 && self.transmission <= 0.0 && self.specular <= 0.0 {
            return if self.base.is_black() { Surface::Black } else { Surface::Lambert(Lambert { albedo: self.base }) };
        }
        Surface::MetalDielectric(self.mixture(ggx, layer))
    }

    fn mixture(&self, ggx: Ggx, layer: Schlick) -> MetalDielectric {
        let (metal, dielectric) = (self.metallic, 1.0 - self.metallic);
        let transmitting = dielectric * self.transmission;
        let (transmission, schlick_share) = match self.glass(transmitting) {
            _ if transmitting <= 0.0 => (Transmission::None, dielectric),
            Some(glass) => (Transmission::Solid(glass), dielectric - transmitting),
            None => (Transmission::Thin(self.base * transmitting), dielectric),
        };
        let albedo = Albedo::of(ggx);
        let passed = Spectrum::ONE - albedo.mean(layer.f0, layer.f90);
        MetalDielectric {
            ggx,
            base: self.base,
            specular: Schlick {
                f0: self.base * metal + layer.f0 * schlick_share,
                f90: self.metal_f90 * metal + layer.f90 * schlick_share,
            },
            layer,
            albedo,
            diffuse: self.base * (dielectric - transmitting),
            // No light reaches a base under a layer that reflects everything.
            coupling: passed.map(|x| if x > 0.0 { x.recip() } else { 0.0 }),
            transmission,
        }
    }

    /// Returns the reflectance of the dielectric layer [glTF20 KHR_materials_specular].
    pub(super) fn layer(&self) -> Schlick {
        let root = (self.ior - 1.0) / (self.ior + 1.0);
        let f0 = self.specular_color.map(|color| (root * root * color).min(1.0) * self.specular);
        Schlick { f0, f90: Spectrum::splat(self.specular) }
    }

    /// Returns the boundary of a solid, scaled by `weight`.
    fn glass(&self, weight: f32) -> Option<Dielectric> {
        (self.wall == Wall::Solid && self.ior >= 1.0).then(|| Dielectric {
            ggx: Ggx::new(self.roughness * self.roughness),
            eta: self.ior / self.outside,
            reflect: Spectrum::splat(weight),
            transmit: self.base * weight,
        })
    }
}
