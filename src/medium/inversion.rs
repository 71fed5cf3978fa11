//! The artists' parameters of a medium: a colour and a mean free path, turned into coefficients.
//!
//! The colour is the reflectance of diffuse light by an infinitely deep, flat body of the medium without a boundary of
//! its own: a wall of it under a cloudy sky has this colour. For isotropic scattering the relation to the
//! single-scattering albedo ω is Chandrasekhar's; a rational function inverts it within 1.3e-5 A (1 − A). The fits in
//! use are good to 0.4 % of ω above 0.7 and to 4 % below.
//!
//! Limits: anisotropic scattering is inverted by similarity, equal σa and (1 − g) σs, which is exact only for light
//! that has been scattered often. A boundary of another index reflects light back into the body and makes it darker
//! than its colour.

use crate::spectrum::Spectrum;

/// Coefficients p₁, p₂, q₁, q₂ of √(1 − ω) = (1 − A) (1 + p₁ A + p₂ A²) / (1 + q₁ A + q₂ A²), fitted to 400 exact
/// values.
const INVERSE: [f64; 4] = [1.024_976_5, 0.021_190_80, 2.469_116_0, 1.256_249_2];

/// Absorption and scattering per unit of length.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Coefficients {
    /// σa.
    pub absorption: Spectrum,
    /// σs.
    pub scattering: Spectrum,
}

/// Returns √(1 − ω) for the single-scattering albedo ω of isotropic scattering by which a half-space reflects `color`
/// of diffuse light. The root keeps its digits in bright media. The colour is clamped to [0, 1].
fn root_of_absorption(color: f64) -> f64 {
    let a = color.clamp(0.0, 1.0);
    let [p1, p2, q1, q2] = INVERSE;
    (1.0 - a) * (1.0 + a * (p1 + a * p2)) / (1.0 + a * (q1 + a * q2))
}

/// Returns the medium of this `color` in [0, 1], mean free paths 1 / σt (positive) and mean cosine g in (−1, 1). By
/// similarity 1 − ω' = (1 − ω) / (1 − g ω) [vandeHulst80].
pub fn invert(color: Spectrum, mean_free_path: Spectrum, g: f32) -> Coefficients {
    let g = f64::from(g);
    let lane = |lane: usize| {
        let s = root_of_absorption(color.0[lane].into());
        let scale = 1.0 / (f64::from(mean_free_path.0[lane]) * (1.0 - g * s * s));
        // 1 − ω and ω, each without cancellation.
        [(1.0 - g) * s * s * scale, (1.0 - s) * (1.0 + s) * scale].map(|x| x as f32)
    };
    let [a, b, c] = [0, 1, 2].map(lane);
    Coefficients { absorption: Spectrum([a[0], b[0], c[0]]), scattering: Spectrum([a[1], b[1], c[1]]) }
}

/// Returns the single-scattering albedo for the colour `a` in [0, 1] by the approximation of [KullaConty17], which
/// glTF's draft of scattering prescribes.
pub fn kulla_conty(a: f32) -> f32 {
    let a = f64::from(a.clamp(0.0, 1.0));
    let s = 4.09712 + 4.20863 * a - (9.59217 + a * (41.6808 + 17.7126 * a)).sqrt();
    (1.0 - s * s) as f32
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::{FRAC_PI_2, PI};

    /// The double exponential rule [TakahasiMori74] for what is analytic between 0 and `end`.
    fn integrate(end: f64, f: impl Fn(f64) -> f64) -> f64 {
        let at = |k: i32| {
            let t = f64::from(k) / 16.0;
            let exponent = FRAC_PI_2 * t.sinh();
            let share = 1.0 / (1.0 + (2.0 * exponent.abs()).exp());
            let x = if exponent < 0.0 { end * share } else { end * (1.0 - share) };
            if x > 0.0 && x < end { f(x) * FRAC_PI_2 * t.cosh() / exponent.cosh().powi(2) } else { 0.0 }
        };
        0.5 * end / 16.0 * (-54..=54).map(at).sum::<f64>()
    }

    /// H(μ) for isotropic scattering [Chandrasekhar60 ch. V]:
    /// ln H = −(μ / π) ∫ ln(1 − ω arctan(t) / t) / (1 + μ² t²) dt over t > 0, with t = tan θ.
    fn h(omega: f64, mu: f64) -> f64 {
        let at = |theta: f64| {
            let (sin, cos) = theta.sin_cos();
            let ratio = if theta < 1e-6 { 1.0 } else { theta / theta.tan() };
            (1.0 - omega * ratio).ln() / (cos * cos + mu * mu * sin * sin)
        };
        (-mu / PI * integrate(FRAC_PI_2, at)).exp()
    }

    /// What a half-space reflects of diffuse light: 1 − 2 √(1 − ω) ∫ H(μ) μ dμ.
    fn reflectance(omega: f64) -> f64 {
        1.0 - 2.0 * (1.0 - omega).sqrt() * integrate(1.0, |mu| mu * h(omega, mu))
    }

    /// Digits of an independent computation; the bound is half a unit of the last digit.
    #[test]
    fn half_spaces_reflect_what_tables_say() {
        for (omega, a) in [(0.3, 0.074451), (0.7, 0.256557), (0.95, 0.596669), (0.999, 0.929713)] {
            assert!((reflectance(omega) - a).abs() < 0.51e-6, "{omega}: {}", reflectance(omega));
        }
    }

    /// The bound is the error of the fit over its 400 values, rounded up by a tenth.
    #[test]
    fn a_half_space_of_the_medium_has_the_colour() {
        for a in [0.01, 0.05, 0.2, 0.5, 0.8, 0.95, 0.99] {
            let s = root_of_absorption(a);
            let found = reflectance((1.0 - s) * (1.0 + s));
            assert!((found - a).abs() < 1.3e-5 * a * (1.0 - a), "{a}: {found}");
        }
    }

    /// Bounds of rounding in f32.
    #[test]
    fn media_have_their_mean_free_path_and_reduced_albedo() {
        for g in [-0.7f32, 0.0, 0.3, 0.9] {
            let Coefficients { absorption, scattering } =
                invert(Spectrum([0.0, 0.6, 1.0]), Spectrum([0.25, 0.5, 2.0]), g);
            let extinction = absorption + scattering;
            for (lane, expected) in [4.0f32, 2.0, 0.5].into_iter().enumerate() {
                assert!((extinction.0[lane] / expected - 1.0).abs() < 4.0 * f32::EPSILON, "{g}: {extinction:?}");
            }
            assert!(scattering.0[0] <= 0.0 && absorption.0[2] <= 0.0, "black and white: {absorption:?} {scattering:?}");
            let reduced = (1.0 - f64::from(g)) * f64::from(scattering.0[1]);
            let albedo = reduced / (reduced + f64::from(absorption.0[1]));
            let expected = 1.0 - root_of_absorption(f64::from(0.6f32)).powi(2);
            assert!((albedo / expected - 1.0).abs() < 8.0 * f64::from(f32::EPSILON), "{g}: {albedo} {expected}");
        }
    }

    /// Within 0.4 % of the single-scattering albedo from 0.7, and 1.1 % at 0.5.
    #[test]
    fn the_published_fit_means_the_same_colour() {
        for (omega, error) in [(0.5, 0.011), (0.7, 0.004), (0.9, 0.004), (0.99, 0.004)] {
            let fit = f64::from(kulla_conty(reflectance(omega) as f32));
            assert!((fit / omega - 1.0).abs() < error, "{omega}: {fit}");
        }
    }
}
