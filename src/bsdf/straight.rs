//! Straight transmission: the unscattered transmission of thin clear walls and of boundaries between equal refractive
//! indices. It belongs to the edge that passes, like alpha blending, so that every technique sees lights through it.
//! The rest of the surface scatters like any other.

use super::{Bsdf, Conductor, Lobes, Surface};
use crate::geometry::Local;
use crate::transport::TransportMode;
use crate::{sampling::Density, spectrum::Spectrum};

impl Surface {
    /// Returns the share of light transmitted straight at incidence cosine `cos` ≥ 0, and the probability that a walk
    /// passes. Both are the same from both sides. `None` without straight transmission.
    pub fn straight(&self, cos: f32) -> Option<(Spectrum, f32)> {
        if !self.passes_straight() {
            return None;
        }
        let known = Local::new((1.0 - cos * cos).max(0.0).sqrt(), 0.0, cos);
        let through = self.dirac(known, TransportMode::Radiance, Lobes::DIRAC_TRANSMIT)?;
        let Density::Delta(probability) = through.density else { return None };
        Some((through.value, probability))
    }

    fn passes_straight(&self) -> bool {
        match self {
            Surface::Thin(wall) => wall.ggx.is_dirac(),
            Surface::Dielectric(glass) => glass.is_matched(),
            Surface::MetalDielectric(mixture) => mixture.passes_straight(),
            Surface::Black | Surface::Lambert(_) | Surface::Conductor(_) => false,
        }
    }

    /// Returns the scattering part: everything except [`Surface::straight`].
    #[must_use]
    pub fn rest(self) -> Surface {
        match self {
            Surface::Thin(wall) if wall.ggx.is_dirac() => {
                Surface::Conductor(Conductor { ggx: wall.ggx, fresnel: wall.fresnel })
            }
            Surface::Dielectric(glass) if glass.is_matched() => Surface::Black,
            Surface::MetalDielectric(mixture) if mixture.passes_straight() => {
                Surface::MetalDielectric(mixture.opaque())
            }
            other => other,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::bsdf::{MetallicRoughness, Wall};

    fn glassy(wall: Wall, transmission: f32, ior: f32) -> Surface {
        MetallicRoughness {
            base: Spectrum([0.9, 0.5, 0.2]),
            metallic: 0.0,
            roughness: 0.0,
            specular: 1.0,
            specular_color: Spectrum::ONE,
            ior,
            outside: 1.0,
            transmission,
            wall,
            metal_f90: Spectrum::ONE,
        }
        .surface()
    }

    /// The passing and the remaining part form the whole: a walk that scatters at the rest with the complementary
    /// probability has all lobes.
    #[test]
    fn surface_is_sum_of_straight_transmission_and_rest() {
        for whole in [glassy(Wall::Thin, 1.0, 1.5), glassy(Wall::Thin, 0.6, 1.5), glassy(Wall::Solid, 0.6, 1.0)] {
            for cos in [1.0f32, 0.6, 0.05] {
                let (_, probability) = whole.straight(cos).expect("it is clear");
                let known = Local::new((1.0 - cos * cos).sqrt(), 0.0, cos);
                assert!(!whole.rest().lobes().intersects(Lobes::DIRAC_TRANSMIT));
                let mirrored = |s: Surface| s.dirac(known, TransportMode::Radiance, Lobes::DIRAC_REFLECT);
                // Nothing is reflected at normal incidence where indices are equal.
                let (Some(all), Some(rest)) = (mirrored(whole), mirrored(whole.rest())) else { continue };
                assert_eq!(all.value, rest.value);
                // Probabilities are sums and quotients of albedos: sixteen roundings.
                let met = (1.0 - probability) * rest.density.value();
                assert!((met - all.density.value()).abs() < 16.0 * f32::EPSILON, "{met} {all:?}");
            }
        }
    }

    #[test]
    fn surface_of_equal_iors_transmits_its_tint_straight() {
        let (value, probability) = glassy(Wall::Solid, 1.0, 1.0).straight(0.3).expect("it is clear");
        assert_eq!((value, probability), (Spectrum([0.9, 0.5, 0.2]), 1.0));
        assert!(matches!(glassy(Wall::Solid, 1.0, 1.0).rest(), Surface::Black));
        assert!(glassy(Wall::Solid, 1.0, 1.5).straight(0.3).is_none());
    }
}
