//! Exact reflectance of an index-matched half-space that scatters isotropically.
//!
//! The solution is Chandrasekhar's H-function [Chandrasekhar60 ch. V]. Everything here is a quadrature in f64. It serves
//! as the reference of [`super::inversion`] and of the diffusion models, at set-up and in tests only.

use super::numeric::integrate;
use std::f64::consts::{FRAC_PI_2, LN_2, PI};

/// Returns 1 − θ / tan θ for θ in [0, π/2]. The series is used where the difference loses digits.
fn one_minus_x_cot_x(theta: f64) -> f64 {
    if theta < 0.05 {
        let q = theta * theta;
        // The next term is below 1e-15 of the first.
        q / 3.0 * (1.0 + q / 15.0 * (1.0 + q * 2.0 / 21.0 * (1.0 + q / 10.0 * (1.0 + q * 10.0 / 99.0))))
    } else {
        1.0 - theta / theta.tan()
    }
}

/// Returns Chandrasekhar's H(μ) for isotropic scattering of albedo `omega` in [0, 1], at the cosine `mu` in (0, 1]
/// [Chandrasekhar60 ch. V]:
///
/// ln H(μ) = −(μ / π) ∫₀^∞ ln(1 − ω arctan(t) / t) / (1 + μ² t²) dt, with t = tan θ.
///
/// The relative error is about 1e-12.
pub fn h_function(omega: f64, mu: f64) -> f64 {
    let integrand = |theta: f64| {
        let (sin, cos) = theta.sin_cos();
        ((1.0 - omega) + omega * one_minus_x_cot_x(theta)).ln() / (cos * cos + mu * mu * sin * sin)
    };
    (-mu / PI * integrate(0.0, FRAC_PI_2, integrand)).exp()
}

/// Returns the share of a collimated beam that is reflected: 1 − √(1 − ω) H(μ) [Chandrasekhar60 ch. V].
///
/// `omega` is the single-scattering albedo in [0, 1] and `mu` the cosine of incidence in (0, 1].
pub fn directional_albedo(omega: f64, mu: f64) -> f64 {
    1.0 - (1.0 - omega).sqrt() * h_function(omega, mu)
}

/// Returns the share of a beam at normal incidence that is reflected. See [`directional_albedo`].
pub fn normal_albedo(omega: f64) -> f64 {
    directional_albedo(omega, 1.0)
}

/// Returns the share of diffuse light that is reflected: 1 − 2 √(1 − ω) ∫₀¹ H(μ) μ dμ [Chandrasekhar60 ch. V].
///
/// `omega` is the single-scattering albedo in [0, 1].
pub fn diffuse_albedo(omega: f64) -> f64 {
    1.0 - 2.0 * (1.0 - omega).sqrt() * integrate(0.0, 1.0, |mu| mu * h_function(omega, mu))
}

/// Returns the share of a beam at normal incidence that leaves after exactly one isotropic scattering:
/// (ω / 2) (1 − ln 2).
pub fn normal_single_scattering(omega: f64) -> f64 {
    0.5 * omega * (1.0 - LN_2)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Printed digits of an independent computation [HalfSpaceTable]: the bound is half a unit of the last digit, plus
    /// the quadrature's error.
    #[test]
    fn albedos_equal_the_printed_digits() {
        let normal = [
            (0.3, 0.057214),
            (0.5, 0.115226),
            (0.7, 0.208680),
            (0.8, 0.285255),
            (0.9, 0.414947),
            (0.95, 0.535541),
            (0.99, 0.752721),
            (0.999, 0.912845),
        ];
        for (omega, albedo) in normal {
            assert!((normal_albedo(omega) - albedo).abs() < 0.51e-6, "{omega}: {}", normal_albedo(omega));
        }
        let diffuse = [
            (0.3, 0.074451),
            (0.5, 0.146544),
            (0.7, 0.256557),
            (0.8, 0.341867),
            (0.9, 0.478024),
            (0.95, 0.596669),
            (0.99, 0.794564),
            (0.999, 0.929713),
        ];
        for (omega, albedo) in diffuse {
            assert!((diffuse_albedo(omega) - albedo).abs() < 0.51e-6, "{omega}: {}", diffuse_albedo(omega));
        }
    }

    /// H is the fixed point of Chandrasekhar's equation 1 / H = √(1 − ω) + (ω / 2) ∫ ν H(ν) / (μ + ν) dν
    /// [Chandrasekhar60 ch. V], which the quadrature does not use. The bound is ten times the error stated.
    #[test]
    fn h_solves_its_equation() {
        for omega in [0.1, 0.5, 0.9, 0.999, 1.0] {
            for mu in [0.01, 0.3, 1.0] {
                let integral = integrate(0.0, 1.0, |nu| nu * h_function(omega, nu) / (mu + nu));
                let inverse = f64::sqrt(1.0 - omega) + 0.5 * omega * integral;
                assert!((inverse * h_function(omega, mu) - 1.0).abs() < 1e-11, "{omega} {mu}");
            }
        }
    }

    #[test]
    fn the_limits_are_exact() {
        assert!(normal_albedo(0.0).abs() < 1e-15 && diffuse_albedo(0.0).abs() < 1e-14);
        assert!((normal_albedo(1.0) - 1.0).abs() < 1e-15 && (diffuse_albedo(1.0) - 1.0).abs() < 1e-15);
        // A weak scatterer reflects its single scattering, up to O(ω²).
        assert!((normal_albedo(1e-6) / normal_single_scattering(1e-6) - 1.0).abs() < 1e-6);
    }
}
