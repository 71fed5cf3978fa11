//! Dipoles: a point source below the surface, and its mirror image that holds the boundary condition.

use super::MediumLane;
use super::RadialProfile;
use super::fresnel::moments;
use super::numeric::increasing_root;
use std::f64::consts::PI;

/// The boundary's part in a dipole.
#[derive(Debug, Clone, Copy)]
pub(super) struct Boundary {
    /// σtr, the reciprocal of the diffusion length.
    pub(super) decay: f64,
    /// Twice the extrapolation distance: the image lies this much farther than the source.
    pub(super) gap: f64,
    /// Weight of the flux through the surface.
    pub(super) flux: f64,
    /// Weight of the fluence, over the diffusion coefficient.
    pub(super) fluence: f64,
}

impl Boundary {
    /// Classical diffusion: D = 1 / 3 σt' and the boundary condition by Fdr [Jensen01 §2.1].
    fn classical(reduced: &MediumLane) -> Self {
        let reflected = moments(reduced.eta).first;
        let change = (1.0 + reflected) / (1.0 - reflected);
        let decay = (3.0 * reduced.absorption * reduced.extinction()).sqrt();
        Boundary { decay, gap: 4.0 / 3.0 * change / reduced.extinction(), flux: 1.0, fluence: 0.0 }
    }

    /// Grosjean's diffusion: D = (2 σa + σs') / 3 σt'², with radiance that leaves by flux and fluence [dEon12].
    pub(super) fn better(reduced: &MediumLane) -> Self {
        let m = moments(reduced.eta);
        let extinction = reduced.extinction();
        let diffusion = (2.0 * reduced.absorption + reduced.scattering) / (3.0 * extinction * extinction);
        let change = (1.0 + m.second) / (1.0 - m.first);
        Boundary {
            decay: (reduced.absorption / diffusion).sqrt(),
            gap: 4.0 * change * diffusion,
            flux: 0.5 * (1.0 - m.second),
            fluence: 0.25 * (1.0 - m.first) / diffusion,
        }
    }

    /// Returns the sum S over source and image at the distance `r` from a source at the depth `depth`. A source of unit
    /// power has R_d = S / 4π.
    pub(super) fn sum(&self, depth: f64, r: f64) -> f64 {
        let image = depth + self.gap;
        let (near, far) = (depth.hypot(r), image.hypot(r));
        let term = |z: f64, d: f64| z * (1.0 + self.decay * d) / (d * d * d);
        let apart = self.apart(depth, near, far);
        let flux = term(depth, near) + term(image, far) * (-self.decay * apart).exp();
        // 1 / near − e^(−decay apart) / far, without cancellation.
        let fluence = (apart / near + self.decay * self.damped(apart)) / far;
        (-self.decay * near).exp() * (self.flux * flux + self.fluence * fluence)
    }

    /// Returns ∫ r S dr beyond the radius `r`. A source of unit power reflects half of it there.
    pub(super) fn tail(&self, depth: f64, r: f64) -> f64 {
        let image = depth + self.gap;
        let (near, far) = (depth.hypot(r), image.hypot(r));
        let apart = self.apart(depth, near, far);
        let flux = depth / near + image / far * (-self.decay * apart).exp();
        (-self.decay * near).exp() * (self.flux * flux + self.fluence * self.damped(apart))
    }

    /// Returns `far` − `near` without cancellation.
    fn apart(&self, depth: f64, near: f64, far: f64) -> f64 {
        self.gap * (2.0 * depth + self.gap) / (near + far)
    }

    /// Returns (1 − e^(−decay x)) / decay, x without decay.
    fn damped(&self, x: f64) -> f64 {
        if self.decay > 0.0 { -(-self.decay * x).exp_m1() / self.decay } else { x }
    }
}

/// A dipole profile.
///
/// Its distribution of radii has a closed form, which is inverted by Newton's method in about 1.5 µs. Where
/// that counts, a [`super::Tabulated`] of it samples in 0.1 µs.
#[derive(Debug, Clone, Copy)]
pub struct Dipole {
    boundary: Boundary,
    /// Depth of the source.
    depth: f64,
    /// Power of the source for unit flux that enters.
    power: f64,
    /// [`Boundary::tail`] at 0.
    norm: f64,
}

impl Dipole {
    fn new(boundary: Boundary, depth: f64, power: f64) -> Self {
        Dipole { boundary, depth, power, norm: boundary.tail(depth, 0.0) }
    }

    /// Returns the classical dipole [Jensen01 §2.1]. Its source holds all light scattered once or more.
    ///
    /// The total is (α' / 2) (1 + e^(−4 A √(3 (1 − α')) / 3)) e^(−√(3 (1 − α'))) [Jensen01 §2.4].
    ///
    /// # Panics
    /// Unless `medium` is in the ranges its fields state, with positive extinction.
    pub fn classical(medium: &MediumLane) -> Self {
        medium.check();
        let reduced = medium.reduced();
        Dipole::new(Boundary::classical(&reduced), 1.0 / reduced.extinction(), reduced.albedo())
    }

    /// Returns the better dipole [dEon12]. It has light scattered twice or more. Exact single scattering added to it
    /// counts some light near the entry twice; see the table of errors.
    ///
    /// # Panics
    /// Unless `medium` is in the ranges its fields state, with positive extinction.
    pub fn better(medium: &MediumLane) -> Self {
        medium.check();
        let reduced = medium.reduced();
        Dipole::new(Boundary::better(&reduced), 1.0 / reduced.extinction(), reduced.albedo().powi(2))
    }
}

impl RadialProfile for Dipole {
    fn total(&self) -> f64 {
        0.5 * self.power * self.norm
    }

    fn density(&self, r: f64) -> f64 {
        self.boundary.sum(self.depth, r) / (2.0 * PI * self.norm)
    }

    fn tail(&self, r: f64) -> f64 {
        self.boundary.tail(self.depth, r) / self.norm
    }

    fn radius(&self, tail: f64) -> f64 {
        debug_assert!(tail > 0.0 && tail <= 1.0, "tail {tail}");
        let wanted = -tail.ln();
        // In q = ln(1 + r² / depth²) the logarithm of the tail is nearly straight, also in media without absorption,
        // whose tail is a power of r.
        let radius = |q: f64| self.depth * q.exp_m1().sqrt();
        let excess = |q: f64| {
            let r = radius(q);
            let rest = self.boundary.tail(self.depth, r);
            // dr / dq = (depth² + r²) / 2 r.
            let slope = 0.5 * self.boundary.sum(self.depth, r) * (self.depth * self.depth + r * r) / rest;
            (-(rest / self.norm).ln() - wanted, slope)
        };
        // The logarithm of the tail has no lower bound, so the doubling ends.
        let mut high = 1.0;
        while high < MAX_LOG && excess(high).0 < 0.0 {
            high *= 2.0;
        }
        radius(increasing_root(0.0, high, excess))
    }
}

/// Largest q of [`Dipole::radius`], where r is 1e138 depths.
const MAX_LOG: f64 = 640.0;
