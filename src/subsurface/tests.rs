//! Tests of all profiles.

use super::beam::Beam;
use super::numeric::integrate_to_infinity;
use super::reference::{Bins, Incidence, Walk};
use super::totals::normal_total;
use super::*;
use crate::spectrum::{LANES, Spectrum};
use etendue_testing::random::Random;
use std::f64::consts::{LN_2, TAU};

/// Number of equally probable bins of [`assert_uniform`].
const BINS: usize = 32;

/// Quantile of χ² with 31 degrees of freedom that is exceeded with probability 1e-6.
const CRITICAL: f64 = 83.64;

/// Tests at the level 1e-6 whether shares in [0, 1] are uniform.
fn assert_uniform(shares: impl Iterator<Item = f64>, what: &str) {
    let mut counts = [0u32; BINS];
    let mut total = 0.0;
    for share in shares {
        counts[((share * BINS as f64) as usize).min(BINS - 1)] += 1;
        total += 1.0;
    }
    let expected = total / BINS as f64;
    let statistic: f64 = counts.iter().map(|&n| (f64::from(n) - expected).powi(2) / expected).sum();
    assert!(statistic < CRITICAL, "{what}: χ² = {statistic} of {BINS} bins");
}

/// Returns 2π ∫ r f(r) dr over (0, ∞), for `f` that falls like e^(−r / `length`) or faster at the end.
fn integrate_plane(length: f64, f: impl Fn(f64) -> f64) -> f64 {
    TAU * length * length * integrate_to_infinity(|x| x * f(length * x))
}

/// The share of light at normal incidence that leaves after exactly one isotropic scattering: (ω / 2) (1 − ln 2).
fn normal_single_scattering(omega: f64) -> f64 {
    0.5 * omega * (1.0 - LN_2)
}

/// Profiles of all models with a length over which each falls by e at least, far out.
fn profiles() -> Vec<(String, f64, Box<dyn RadialProfile>)> {
    let mut all: Vec<(String, f64, Box<dyn RadialProfile>)> = Vec::new();
    for omega in [0.1, 0.5, 0.9, 0.99] {
        for (mean_cosine, eta) in [(0.0, 1.0), (0.7, 1.4)] {
            let medium = MediumLane { absorption: 2.0 * (1.0 - omega), scattering: 2.0 * omega, mean_cosine, eta };
            let (name, length) = (format!("{omega} {mean_cosine} {eta}"), decay_length(&medium));
            all.push((format!("classical {name}"), length, Box::new(Dipole::classical(&medium))));
            all.push((format!("better {name}"), length, Box::new(Dipole::better(&medium))));
            all.push((format!("beam {name}"), length, Box::new(photon_beam(&medium))));
        }
        all.push((format!("searchlight {omega}"), 4.0, Box::new(Burley::searchlight(omega, 0.5))));
        all.push((format!("diffuse {omega}"), 4.0, Box::new(Burley::diffuse(omega, 0.5))));
        all.push((format!("length {omega}"), 1.0, Box::new(Burley::diffuse_length(omega, 0.5))));
    }
    all
}

/// Returns a length that the diffusion length does not exceed in either model.
fn decay_length(medium: &MediumLane) -> f64 {
    let reduced = medium.reduced();
    (1.0 / (reduced.absorption * reduced.extinction()).sqrt()).max(1.0 / reduced.extinction())
}

/// 2π ∫ r density dr = 1. The bound for smooth profiles is ten times the quadrature's error. The table is integrated by
/// the trapezoidal rule over ln r at the step h = 0.005: the error is at most h² / 8 = 3e-6 times the sum of its kinks,
/// about 1.
#[test]
fn densities_integrate_to_one() {
    for (name, length, profile) in profiles() {
        if name.starts_with("beam") {
            let (h, first) = (0.005, 1e-9 * length);
            let radius = |i: i32| first * (f64::from(i) * h).exp();
            // Up to 1e3 lengths.
            let sum: f64 = (0..5530).map(|i| radius(i).powi(2) * profile.density(radius(i))).sum();
            let integral = TAU * h * sum;
            assert!((integral - 1.0).abs() < 1e-5, "{name}: {integral}");
        } else {
            let integral = integrate_plane(length, |r| profile.density(r));
            assert!((integral - 1.0).abs() < 1e-10, "{name}: {integral}");
        }
    }
}

/// The slope of the tail is the density. Central differences at h = 1e-3 r have the relative error h² / 6 · f'' / f, at
/// most 1e-5 here; a node of the table inside the step adds h times its kink, 1e-3 · 0.03.
#[test]
fn the_tail_is_the_integral_of_the_density() {
    for (name, _, profile) in profiles() {
        // Odd radii keep the step off the table's nodes.
        for r in [0.0123, 0.1357, 0.731, 2.97] {
            let h = 1e-3 * r;
            let slope = (profile.tail(r - h) - profile.tail(r + h)) / (2.0 * h);
            let expected = TAU * r * profile.density(r);
            assert!((slope - expected).abs() < 1e-4 * expected + 1e-13 / h, "{name} {r}: {slope} {expected}");
        }
    }
}

/// The bound is the rounding of the tail where it is 1 − small, and of the logarithm where it is small.
#[test]
fn the_radius_inverts_the_tail() {
    for (name, _, profile) in profiles() {
        for tail in [1.0 - 1e-6, 0.999, 0.9, 0.5, 0.1, 1e-3, 1e-8] {
            let r = profile.radius(tail);
            let back = profile.tail(r);
            assert!((back - tail).abs() < 1e-12 * tail + 1e-15, "{name} {tail}: {r} {back}");
        }
        assert!(profile.radius(1.0) >= 0.0 && profile.density(0.0).is_finite() && profile.density(0.0) > 0.0);
    }
}

/// χ² at the level 1e-6 over 32 bins of equal probability. The bin of a sample comes from quadrature of the density
/// alone, tabulated at 2000 radii, and not from the closed tail. A scale that is wrong by 5 % fails.
#[test]
fn sampled_radii_follow_the_density() {
    let mut random = Random::new(5);
    for (name, length, profile) in profiles() {
        let (first, step) = (1e-7 * length, 0.012);
        let mut shares = vec![0.0];
        for i in 0..2000 {
            // Simpson's rule over ln r, whose error is below 1e-8 of a bin.
            let f = |x: f64| {
                let r = first * (step * x).exp();
                TAU * r * r * profile.density(r)
            };
            let x = f64::from(i);
            shares.push(shares[i as usize] + step / 6.0 * (f(x) + 4.0 * f(x + 0.5) + f(x + 1.0)));
        }
        let share = |r: f64| {
            let x = ((r / first).ln() / step).clamp(0.0, 1999.0);
            let i = x as usize;
            shares[i] + (x - i as f64) * (shares[i + 1] - shares[i])
        };
        let samples = (0..40_000).map(|_| share(profile.radius(1.0 - random.f64())));
        assert_uniform(samples, &name);
    }
}

/// The closed form [Jensen01 §2.4] and its printed digits: half a unit of the last one.
#[test]
fn the_classical_total_is_the_closed_form() {
    for (omega, printed) in [(0.5, 0.087808), (0.8, 0.249988), (0.9, 0.385584), (0.95, 0.514880), (0.99, 0.746714)] {
        let total = Dipole::classical(&MediumLane::isotropic(omega)).total();
        assert!((total - printed).abs() < 0.51e-6, "{omega}: {total}");
        let root = (3.0 * (1.0 - omega)).sqrt();
        let closed = 0.5 * omega * (1.0 + (-4.0 / 3.0 * root).exp()) * (-root).exp();
        assert!((total - closed).abs() < 1e-14);
    }
    let total = Dipole::classical(&MediumLane::isotropic(0.999)).total();
    assert!((total - 0.912451).abs() < 0.51e-6, "{total}");
}

/// The errors that light-transport.md prints, in percent, with exact single scattering: half a unit of the last digit.
#[test]
fn the_better_total_has_the_printed_error() {
    for (omega, printed, digit) in [(0.5, 6.5, 0.1), (0.8, 13.0, 1.0), (0.9, 16.0, 1.0), (0.99, 18.0, 1.0)] {
        let total = Dipole::better(&MediumLane::isotropic(omega)).total() + normal_single_scattering(omega);
        let error = 100.0 * (total / normal_total(&MediumLane::isotropic(omega)) - 1.0);
        assert!((error - printed).abs() < 0.51 * digit, "{omega}: {error}");
    }
}

/// Without absorption all light leaves: the boundary conditions of both dipoles conserve energy for every index.
#[test]
fn dipoles_conserve_energy() {
    for eta in [1.0, 1.3, 1.5, 2.0] {
        let medium = MediumLane { eta, ..MediumLane::isotropic(1.0) };
        for dipole in [Dipole::classical(&medium), Dipole::better(&medium)] {
            assert!((dipole.total() - 1.0).abs() < 1e-12, "{eta}: {}", dipole.total());
            assert!((dipole.tail(dipole.radius(1e-3)) - 1e-3).abs() < 1e-14);
        }
    }
}

/// Single scattering along the beam integrates to its closed form (ω / 2) (1 − ln 2). The bound is ten times the
/// quadrature's error.
#[test]
fn the_beam_scatters_once_exactly() {
    let model = Beam::new(&MediumLane::isotropic(0.7));
    let total = integrate_plane(1.0, |r| model.single(r));
    assert!((total / normal_single_scattering(0.7) - 1.0).abs() < 1e-10, "{total}");
}

/// Multiple scattering along the beam against another program's product quadrature of the published formula (Gauss and
/// Legendre, 400² nodes over ln r and ln t). The bound is half a unit of the last digit.
#[test]
fn the_beam_scatters_often_as_published() {
    for (omega, expected) in [(0.2, 0.006_413_46), (0.5, 0.051_243_48), (0.9, 0.336_134_28), (0.99, 0.689_196_91)] {
        let medium = MediumLane::isotropic(omega);
        let model = Beam::new(&medium);
        let total = integrate_plane(decay_length(&medium), |r| model.multiple(r));
        assert!((total - expected).abs() < 0.51e-8, "{omega}: {total}");
    }
}

/// Against the walk in a medium that scatters little, ring by ring: this tells forward from backward scattering and
/// checks the boundary. Student's tests with 63 degrees of freedom, at the level 1e-6 each. Light scattered twice adds
/// up to 5 ω = 5e-4 of a ring, and the walk's table of single scattering errs by 2e-4.
#[test]
fn the_beam_scatters_once_like_the_walk() {
    let omega = 1e-4;
    let bins = Bins { first: 0.05, last: 5.0, count: 12 };
    for (mean_cosine, eta) in [(0.0, 1.0), (0.6, 1.0), (-0.5, 1.4)] {
        let (albedos, depth, incidence) = (vec![omega], f64::INFINITY, Incidence::Normal);
        let found = &Walk { albedos, mean_cosine, eta, depth, incidence, bins }.run(300_000, 8)[0];
        let medium = MediumLane { absorption: 1.0 - omega, scattering: omega, mean_cosine, eta };
        let single = single_scattering(&medium);
        for (i, ring) in found.rings.iter().enumerate() {
            let expected = single.total() * (single.tail(bins.edge(i)) - single.tail(bins.edge(i + 1)));
            let bound = 5.42 * ring.standard_error + 7e-4 * expected;
            assert!((ring.value - expected).abs() < bound, "{mean_cosine} {eta} {i}: {ring:?} {expected}");
        }
    }
}

/// The table's total against quadrature of the model. Between nodes at the distance h of ln r the error is at most
/// h² / 8 · |d² ln f / d(ln r)²|, where the last factor is 1.5 in the mean over the light. With h = 0.03 this is 2e-4.
#[test]
fn the_table_keeps_the_total() {
    for omega in [0.2, 0.9, 0.99] {
        for (mean_cosine, eta) in [(0.0, 1.0), (0.5, 1.5)] {
            let medium = MediumLane { absorption: 1.0 - omega, scattering: omega, mean_cosine, eta };
            let model = Beam::new(&medium);
            let exact = integrate_plane(decay_length(&medium), |r| model.multiple(r) + model.single(r));
            let table = photon_beam(&medium).total();
            assert!((table - exact).abs() <= 2e-4 * exact, "{omega} {eta}: {table} {exact}");
        }
    }
}

/// Media without absorption or without scattering have profiles that can be sampled, and the latter reflect nothing.
#[test]
fn the_extremes_have_profiles() {
    for omega in [0.0, 1e-20, 1.0 - 1e-12, 1.0] {
        let medium = MediumLane { eta: 1.3, ..MediumLane::isotropic(omega) };
        let profiles: [Box<dyn RadialProfile>; 5] = [
            Box::new(Dipole::classical(&medium)),
            Box::new(Dipole::better(&medium)),
            Box::new(photon_beam(&medium)),
            Box::new(single_scattering(&medium)),
            Box::new(Burley::searchlight(omega, 1.0)),
        ];
        for (i, profile) in profiles.iter().enumerate() {
            assert!((omega > 0.0) == (profile.total() > 0.0), "{i} {omega}");
            for tail in [1.0, 0.5, 1e-7] {
                let r = profile.radius(tail);
                assert!(r.is_finite() && profile.density(r) > 0.0 && profile.density(r).is_finite(), "{i} {omega} {r}");
            }
        }
    }
}

#[test]
fn burley_has_its_albedo() {
    for albedo in [0.0, 0.2, 0.8, 1.0] {
        for profile in
            [Burley::searchlight(albedo, 3.0), Burley::diffuse(albedo, 3.0), Burley::diffuse_length(albedo, 3.0)]
        {
            let total = integrate_plane(12.0, |r| profile.value(r));
            assert!((total - albedo).abs() < 1e-10, "{albedo}: {total}");
        }
    }
}

/// Every model by its name, whose table has its total and shape: within the bound stated for tables.
#[test]
fn models_are_tables_of_their_profiles() {
    let medium = MediumLane { absorption: 0.2, scattering: 1.8, mean_cosine: 0.0, eta: 1.3 };
    let total = totals::diffuse_total(&medium);
    let (better, once) = (Dipole::better(&medium), single_scattering(&medium));
    let dipole = Dipole::classical(&medium);
    let burley = Burley::diffuse(total, 0.5);
    let beam = photon_beam(&medium);
    for r in [0.01, 0.1, 0.7, 3.0] {
        for (model, expected) in [
            (DiffusionModel::Dipole, dipole.value(r)),
            (DiffusionModel::BetterDipole, better.value(r) + once.value(r)),
            (DiffusionModel::PhotonBeam, beam.density(r) * total),
            (DiffusionModel::Burley, burley.value(r)),
        ] {
            let found = model.profile(&medium).value(r);
            // Between nodes at 0.03 in ln r a profile is off by h² / 8 times its curvature there, at most 10.
            assert!((found / expected - 1.0).abs() < 2e-3, "{model:?} {r}: {found} {expected}");
        }
    }
    assert!((DiffusionModel::Burley.profile(&medium).total() - total).abs() < 1e-12);
}

/// The density is that of the mixture, whose estimates of the totals are normal tests at the level 1e-6.
#[test]
fn lanes_share_their_samples() {
    let medium = |omega: f64, path: f64| MediumLane {
        absorption: (1.0 - omega) / path,
        scattering: omega / path,
        ..MediumLane::isotropic(0.5)
    };
    let lanes = ProfileLanes(
        [medium(0.99, 1.0), medium(0.9, 0.3), medium(0.6, 0.1)].map(|m| DiffusionModel::Burley.profile(&m)),
    );
    let shares = Spectrum([0.6, 0.4, 0.0]);
    let mut random = Random::new(6);
    let (mut sums, mut squares) = ([0.0; LANES], [0.0; LANES]);
    let n = 100_000;
    for _ in 0..n {
        let radius = lanes.sample(shares, random.f32(), random.f32());
        let over = lanes.value(radius) / lanes.density(shares, radius);
        for lane in 0..LANES {
            sums[lane] += f64::from(over.0[lane]);
            squares[lane] += f64::from(over.0[lane]).powi(2);
        }
    }
    for lane in 0..2 {
        let (mean, total) = (sums[lane] / f64::from(n), f64::from(lanes.total().0[lane]));
        let error = ((squares[lane] / f64::from(n) - mean * mean) / f64::from(n)).sqrt();
        assert!((mean - total).abs() < 4.9 * error + 1e-6, "{lane}: {mean} {total}");
    }
    assert!(lanes.max_radius(1e-3) > lanes.max_radius(1e-2));
}
