//! Internal reflection at a smooth boundary, and its moments.

use super::numeric::integrate;

/// Returns the reflectance of unpolarized light that meets the boundary from inside at the cosine `mu` in [0, 1].
/// `eta` is the index inside over that outside, at least 1. It is 1 under total reflection [Jensen01 §2.1].
pub(super) fn internal_reflectance(mu: f64, eta: f64) -> f64 {
    let sin2 = eta * eta * (1.0 - mu * mu);
    if sin2 >= 1.0 {
        // Without a boundary no light is reflected, also along it.
        return if eta > 1.0 { 1.0 } else { 0.0 };
    }
    reflectance(mu, (1.0 - sin2).sqrt(), eta)
}

/// Returns the reflectance of unpolarized light that meets the boundary from outside at the cosine `mu` in [0, 1].
/// `eta` is the index inside over that outside, at least 1.
pub(super) fn external_reflectance(mu: f64, eta: f64) -> f64 {
    reflectance((1.0 - (1.0 - mu * mu) / (eta * eta)).sqrt(), mu, eta)
}

/// Returns the share of diffuse light outside that passes the boundary: 1 − 2 ∫ F μ dμ from outside. By reciprocity it
/// is that of diffuse light inside times η².
pub fn exit_share(eta: f64) -> f64 {
    eta * eta * (1.0 - moments(eta).first)
}

/// Returns the reflectance for the cosines `inside` and `outside` that Snell's law connects.
fn reflectance(inside: f64, outside: f64, eta: f64) -> f64 {
    let perpendicular = (eta * inside - outside) / (eta * inside + outside);
    let parallel = (inside - eta * outside) / (inside + eta * outside);
    0.5 * (perpendicular * perpendicular + parallel * parallel)
}

/// Moments of the internal reflectance F over the cosine.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Moments {
    /// 2 ∫ F μ dμ: the internal reflectance of diffuse light, Fdr of [Jensen01 §2.1] and 2 C₁ of [dEon11].
    pub(super) first: f64,
    /// 3 ∫ F μ² dμ: 3 C₂ of [dEon11].
    pub(super) second: f64,
}

/// Returns the moments for the relative index `eta`, at least 1. The relative error is about 1e-13.
///
/// Directions of total reflection are integrated in closed form, the others over the cosine outside.
pub(super) fn moments(eta: f64) -> Moments {
    if eta <= 1.0 {
        return Moments { first: 0.0, second: 0.0 };
    }
    let critical = (1.0 - 1.0 / (eta * eta)).sqrt();
    let inside = |outside: f64| (1.0 - (1.0 - outside * outside) / (eta * eta)).sqrt();
    let transmitted = |f: &dyn Fn(f64) -> f64| {
        integrate(0.0, 1.0, |outside| {
            let mu = inside(outside);
            f(mu) * reflectance(mu, outside, eta) * outside / (eta * eta)
        })
    };
    Moments {
        first: critical.powi(2) + 2.0 * transmitted(&|_| 1.0),
        second: critical.powi(3) + 3.0 * transmitted(&|mu| mu),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The cubic fit of the diffuse reflectance [Jensen01 §2.1] holds to about 0.2 % of 1 between 1.2 and 1.6. The
    /// bound is 0.006, the error of the fit that was found here.
    #[test]
    fn the_first_moment_follows_the_fit() {
        for eta in [1.2, 1.3, 1.4, 1.5, 1.6] {
            let fit = -1.440 / (eta * eta) + 0.710 / eta + 0.668 + 0.0636 * eta;
            let exact = moments(eta).first;
            assert!((exact - fit).abs() < 0.006, "{eta}: {exact} {fit}");
        }
    }

    /// The bound is ten times the quadrature's error.
    #[test]
    fn what_passes_from_outside_is_what_passes_from_inside() {
        for eta in [1.0, 1.3, 1.5, 2.5] {
            let passes = 2.0 * integrate(0.0, 1.0, |mu| mu * (1.0 - external_reflectance(mu, eta)));
            assert!((exit_share(eta) - passes).abs() < 1e-12, "{eta}: {passes}");
        }
    }

    /// Against the plain quadrature on both sides of the critical angle. The bound is the error stated for the rule
    /// times ten.
    #[test]
    fn moments_equal_plain_quadrature() {
        for eta in [1.0, 1.1, 1.5, 2.5] {
            let critical = f64::max(1.0 - 1.0 / (eta * eta), 0.0).sqrt();
            let plain = |f: &dyn Fn(f64) -> f64| {
                let g = |mu: f64| internal_reflectance(mu, eta) * f(mu);
                integrate(0.0, critical, g) + integrate(critical, 1.0, g)
            };
            let m = moments(eta);
            assert!((m.first - 2.0 * plain(&|mu| mu)).abs() < 1e-12, "{eta}");
            assert!((m.second - 3.0 * plain(&|mu| mu * mu)).abs() < 1e-12, "{eta}");
        }
    }
}
