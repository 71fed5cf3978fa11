//! The artists' parameters of subsurface scattering: a colour and a mean free path, turned into a medium.
//!
//! The colour is a reflectance by multiple scattering of an infinitely deep, flat, index-matched body of the medium. Two
//! meanings occur ([`Colour`]). The exact relation to the single-scattering albedo ω is known for isotropic scattering
//! ([`super::half_space`]). A rational function of the colour inverts it here within 6e-5 of A (1 − A), far
//! better than the fits in use ([`kulla_conty`], [`chiang`]).
//!
//! Anisotropic scattering is inverted by similarity: two media look nearly alike if they share σa and (1 − g) σs. That
//! is exact only for light that has been scattered often. The walk measures these errors of the reflectance, in percent:
//!
//! | colour | g = −0.5 | 0.3 | 0.6 | 0.8 | 0.9 | standard error |
//! |---|---|---|---|---|---|---|
//! | diffuse 0.1 | +5.4 | −2.0 | −2.7 | −3.0 | −2.8 | 0.2 |
//! | diffuse 0.3 | +2.1 | −0.4 | −0.3 | −0.7 | −0.2 | 0.2 |
//! | diffuse 0.5 | +0.7 | −0.0 | −0.0 | −0.0 | +0.2 | 0.2 |
//! | diffuse 0.8 | −0.2 | +0.3 | +0.3 | −0.2 | −0.1 | 0.2 |
//! | normal 0.1 | +26.6 | −14.8 | −26.1 | −33.6 | −37.1 | 0.4 |
//! | normal 0.3 | +11.1 | −5.7 | −9.8 | −12.9 | −13.7 | 0.3 |
//! | normal 0.5 | +3.8 | −2.2 | −4.0 | −5.1 | −5.7 | 0.3 |
//! | normal 0.8 | +0.1 | −0.8 | −0.4 | −0.2 | −1.4 | 0.4 |
//!
//! A boundary of another index makes the body darker, since light is reflected back into it. The colour does not
//! include that.

use super::{LANES, Lanes, Medium};
use std::array::from_fn;

/// Which reflectance of the index-matched half-space a colour means.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Colour {
    /// The reflectance of diffuse light, that is the mean over cosine-weighted directions of incidence. A body under a
    /// cloudy sky has this colour. The published inversions mean this one.
    #[default]
    Diffuse,
    /// The reflectance of light at normal incidence. It is up to a quarter darker than [`Colour::Diffuse`] in dark
    /// media. Searchlight profiles such as [`super::diffusion::Burley::searchlight`] integrate to this one.
    Normal,
}

/// Coefficients p₁, p₂, q₁, q₂ of s = (1 − A) (1 + p₁ A + p₂ A²) / (1 + q₁ A + q₂ A²) where s = √(1 − ω). Fitted to 400
/// exact values with equal weight of the error of ln(A / (1 − A)), which is at most 1.2e-5.
const DIFFUSE: [f64; 4] = [1.024_976_5, 0.021_190_80, 2.469_116_0, 1.256_249_2];

/// The same for [`Colour::Normal`]. The error is at most 5.5e-5.
const NORMAL: [f64; 4] = [1.572_725_7, 0.062_587_99, 3.831_439_4, 2.831_138_9];

/// Returns √(1 − ω) for isotropic scattering of the single-scattering albedo ω that gives a half-space the reflectance
/// `albedo` in [0, 1].
///
/// The root keeps its digits in bright media, where ω does not. `albedo` is clamped to [0, 1].
pub fn similarity(albedo: f64, colour: Colour) -> f64 {
    let a = albedo.clamp(0.0, 1.0);
    let [p1, p2, q1, q2] = match colour {
        Colour::Diffuse => DIFFUSE,
        Colour::Normal => NORMAL,
    };
    (1.0 - a) * (1.0 + a * (p1 + a * p2)) / (1.0 + a * (q1 + a * q2))
}

/// Returns the single-scattering albedo for isotropic scattering. See [`similarity`].
pub fn single_scattering_albedo(albedo: f64, colour: Colour) -> f64 {
    let s = similarity(albedo, colour);
    (1.0 - s) * (1.0 + s)
}

/// Returns the medium of one lane with the reflectance `albedo` in [0, 1] and the mean free path 1 / σt.
///
/// `mean_cosine` is g of the phase function, inside (−1, 1). It enters by similarity, 1 − ω' = (1 − ω) / (1 − g ω)
/// [vandeHulst80]. The index of refraction is 1.
///
/// # Panics
/// Unless `mean_free_path` is positive and finite and `mean_cosine` inside (−1, 1).
pub fn medium_of(albedo: f64, mean_free_path: f64, mean_cosine: f64, colour: Colour) -> Medium {
    assert!(mean_free_path > 0.0 && mean_free_path.is_finite(), "mean free path {mean_free_path}");
    assert!(mean_cosine.abs() < 1.0, "mean cosine {mean_cosine}");
    let s = similarity(albedo, colour);
    // 1 − ω and ω, each without cancellation.
    let scale = 1.0 / (mean_free_path * (1.0 - mean_cosine * s * s));
    let absorption = (1.0 - mean_cosine) * s * s * scale;
    let scattering = (1.0 - s) * (1.0 + s) * scale;
    Medium { absorption, scattering, mean_cosine, eta: 1.0 }
}

/// Coefficients of a medium by lane, per unit of length.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Coefficients {
    /// σa.
    pub absorption: Lanes,
    /// σs.
    pub scattering: Lanes,
}

/// Returns the coefficients for a colour and mean free paths by lane. See [`medium_of`].
///
/// # Panics
/// Unless each mean free path is positive and finite and `mean_cosine` inside (−1, 1).
pub fn coefficients(albedo: Lanes, mean_free_path: Lanes, mean_cosine: f32, colour: Colour) -> Coefficients {
    let media: [Medium; LANES] =
        from_fn(|lane| medium_of(albedo[lane].into(), mean_free_path[lane].into(), mean_cosine.into(), colour));
    Coefficients { absorption: media.map(|m| m.absorption as f32), scattering: media.map(|m| m.scattering as f32) }
}

/// Returns the single-scattering albedo of [KullaConty17], the inverse of van de Hulst's approximation
/// A = (1 − s) (1 − 0.139 s) / (1 + 1.17 s). It means [`Colour::Diffuse`]. For comparison only.
pub fn kulla_conty(albedo: f64) -> f64 {
    let s = 4.09712 + 4.20863 * albedo - (9.59217 + albedo * (41.6808 + 17.7126 * albedo)).sqrt();
    1.0 - s * s
}

/// Returns the single-scattering albedo of [Chiang16]. It means [`Colour::Diffuse`]. For comparison only.
pub fn chiang(albedo: f64) -> f64 {
    -(albedo * (-5.09406 + albedo * (2.61188 - 4.31805 * albedo))).exp_m1()
}

#[cfg(test)]
mod tests {
    use super::super::half_space::{diffuse_albedo, normal_albedo};
    use super::*;

    const COLOURS: [f64; 13] = [0.01, 0.02, 0.05, 0.1, 0.2, 0.3, 0.5, 0.7, 0.8, 0.9, 0.95, 0.98, 0.99];

    /// The bounds are the errors of the fits over the 400 values, rounded up by a tenth.
    #[test]
    fn the_round_trip_returns_the_colour() {
        for a in COLOURS {
            let diffuse = diffuse_albedo(single_scattering_albedo(a, Colour::Diffuse));
            assert!((diffuse - a).abs() < 1.3e-5 * a * (1.0 - a), "{a}: {diffuse}");
            let normal = normal_albedo(single_scattering_albedo(a, Colour::Normal));
            assert!((normal - a).abs() < 6e-5 * a * (1.0 - a), "{a}: {normal}");
        }
    }

    #[test]
    fn the_ends_are_exact() {
        for colour in [Colour::Diffuse, Colour::Normal] {
            assert!(single_scattering_albedo(0.0, colour).abs() < 1e-15);
            assert!((single_scattering_albedo(1.0, colour) - 1.0).abs() < 1e-15);
            assert!(single_scattering_albedo(7.0, colour) <= 1.0 && single_scattering_albedo(-1.0, colour) >= 0.0);
        }
    }

    /// A brighter colour needs less absorption: steps of 1e-3.
    #[test]
    fn the_inversion_is_monotonic() {
        for colour in [Colour::Diffuse, Colour::Normal] {
            for k in 0..1000 {
                let a = f64::from(k) * 1e-3;
                assert!(similarity(a + 1e-3, colour) < similarity(a, colour), "{a}");
            }
        }
    }

    /// Errors of the published fits as measured in [HalfSpaceTable]: within 0.4 % for ω ≥ 0.7, at most 1.1 % at 0.5.
    #[test]
    fn the_published_fits_mean_diffuse_light() {
        for omega in [0.7, 0.8, 0.9, 0.95, 0.99] {
            let a = diffuse_albedo(omega);
            for fit in [kulla_conty(a), chiang(a)] {
                assert!((fit / omega - 1.0).abs() < 0.004, "{omega}: {fit}");
            }
        }
        let a = diffuse_albedo(0.5);
        assert!((kulla_conty(a) / 0.5 - 1.0).abs() < 0.011 && (chiang(a) / 0.5 - 1.0).abs() < 0.011);
        // Fed with the wrong reflectance: −14 % at 0.5.
        let wrong = chiang(normal_albedo(0.5));
        assert!((wrong / 0.5 - 0.86).abs() < 0.01, "{wrong}");
    }

    /// The coefficients have the mean free path and the reduced albedo asked for. Bounds of rounding.
    #[test]
    fn the_medium_has_the_parameters() {
        for g in [-0.7, 0.0, 0.3, 0.95] {
            let medium = medium_of(0.6, 0.25, g, Colour::Diffuse);
            assert!((medium.extinction() - 4.0).abs() < 1e-13);
            let reduced = medium.reduced().albedo();
            assert!((reduced - single_scattering_albedo(0.6, Colour::Diffuse)).abs() < 1e-14, "{g}");
        }
        let lanes = coefficients([0.0, 0.5, 1.0], [1.0, 2.0, 0.5], 0.5, Colour::Normal);
        assert!(lanes.scattering[0].abs() < 1e-7 && (lanes.absorption[0] - 1.0).abs() < 1e-6);
        assert!(lanes.absorption[2].abs() < 1e-7 && (lanes.scattering[2] - 2.0).abs() < 1e-6);
        assert!((lanes.absorption[1] + lanes.scattering[1] - 0.5).abs() < 1e-6);
    }
}
