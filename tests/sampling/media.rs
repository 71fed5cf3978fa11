//! Phase functions and free flights against their integrals.

use etendue::medium::{Collision, Flight, Homogeneous, Phase, density};
use etendue::sampling::lanes::uniform_sphere;
use etendue::spectrum::Spectrum;
use etendue_testing::random::{Random, samples};
use glam::{DVec3, Vec3};
use statrs::distribution::{ChiSquared, ContinuousCDF};
use std::f64::consts::{PI, TAU};

/// What the selection of a lane leaves of its number is uniform, whatever the shares: χ² of 32 cells in each part of
/// the number, at the level 1e-6.
#[test]
fn flights_leave_a_uniform_number() {
    for prior in [[1.0, 1.0, 1.0], [0.1, 0.0, 2.9], [2.0, 0.7, 0.3], [0.0, 0.0, 3.0f32]] {
        let mut random = Random::new(31);
        let (n, mut cells) = (64_000, [0u32; 32]);
        for _ in 0..n {
            let rest = Flight::new(Spectrum(prior), random.cube()).rest();
            cells[(rest * 32.0) as usize] += 1;
        }
        let expected = f64::from(n) / 32.0;
        let chi2: f64 = cells.iter().map(|&count| (f64::from(count) - expected).powi(2) / expected).sum();
        assert!(ChiSquared::new(31.0).expect("positive").sf(chi2) > 1e-6, "{prior:?}: {cells:?}");
    }
}

const PHASES: [Phase; 11] = [
    Phase::Isotropic,
    Phase::Rayleigh,
    Phase::HenyeyGreenstein(0.0),
    Phase::HenyeyGreenstein(1e-7),
    Phase::HenyeyGreenstein(-1e-3),
    Phase::HenyeyGreenstein(0.5),
    Phase::HenyeyGreenstein(-0.5),
    Phase::HenyeyGreenstein(0.95),
    Phase::HenyeyGreenstein(-0.95),
    Phase::Mixture([0.8, -0.3], 0.7),
    Phase::Mixture([-0.9, 0.9], 0.25),
];

fn direction(random: &mut Random) -> Vec3 {
    uniform_sphere(random.cube()).into()
}

/// Value at the cosine of the angle by which light is turned, from the textbook.
fn textbook(phase: Phase, cos: f64) -> f64 {
    let hg = |g: f32| {
        let g = f64::from(g);
        (1.0 - g * g) / (4.0 * PI * (1.0 + g * g - 2.0 * g * cos).powf(1.5))
    };
    match phase {
        Phase::Isotropic => 0.25 / PI,
        Phase::Rayleigh => 3.0 / (16.0 * PI) * (1.0 + cos * cos),
        Phase::HenyeyGreenstein(g) => hg(g),
        Phase::Mixture([a, b], share) => f64::from(share) * hg(a) + (1.0 - f64::from(share)) * hg(b),
    }
}

/// The integral of `f` over the cosine, times 2π. Midpoints of a substitution that is narrow at both ends.
fn integral(f: impl Fn(f64) -> f64) -> f64 {
    const STEPS: u32 = 100_000;
    let step = |k: u32| {
        let angle = PI * (f64::from(k) + 0.5) / f64::from(STEPS);
        f(angle.cos()) * angle.sin()
    };
    TAU * (0..STEPS).map(step).sum::<f64>() * PI / f64::from(STEPS)
}

#[test]
fn phase_functions_have_the_values_of_the_textbook() {
    let mut random = Random::new(70);
    for phase in PHASES {
        assert!((integral(|cos| textbook(phase, cos)) - 1.0).abs() < 1e-6, "{phase:?}");
        let mean = integral(|cos| cos * textbook(phase, cos));
        assert!((mean - f64::from(phase.mean_cosine())).abs() < 1e-6, "{phase:?}: {mean}");
        for _ in 0..samples(2000) {
            let [wi, wo]: [Vec3; 2] = [(); 2].map(|()| direction(&mut random));
            let cos = -wi.as_dvec3().normalize().dot(wo.as_dvec3().normalize());
            let (value, expected) = (f64::from(phase.eval(wi, wo)), textbook(phase, cos));
            // Directions are unit vectors within rounding: 1 ∓ cos is off by 4 ulps, which (1 ∓ g)² divides.
            let slack = 32.0 * f64::from(f32::EPSILON) * (1.0 + expected * 4.0 * PI);
            assert!((value / expected - 1.0).abs() < slack, "{phase:?} at {cos}: {value} {expected}");
        }
    }
}

/// Forward light goes on: `wi` points back to where it came from.
#[test]
fn light_goes_on_where_the_mean_cosine_is_positive() {
    let (wi, on, back) = (Vec3::Z, Vec3::NEG_Z, Vec3::Z);
    let forward = Phase::HenyeyGreenstein(0.8);
    assert!(forward.eval(wi, on) > 100.0 * forward.eval(wi, back));
}

/// χ² of sampled cosines in cells of equal probability, azimuths, and densities with the bits of values.
#[test]
fn phase_functions_are_sampled_by_their_value() {
    const CELLS: usize = 64;
    let count = samples(1 << 17);
    let mut random = Random::new(71);
    for phase in PHASES {
        let known: Vec3 = direction(&mut random);
        let axis = -known.as_dvec3().normalize();
        let (s, t) = axis.any_orthonormal_pair();
        let mut cells = [[0u32; 2]; CELLS];
        let mut mean = DVec3::ZERO;
        for _ in 0..count {
            let sample = phase.sample(known, random.cube());
            let w = sample.direction.as_dvec3();
            assert!((w.length() - 1.0).abs() < 1e-6, "{phase:?}");
            let cos = w.dot(axis).clamp(-1.0, 1.0);
            // The density belongs to the cosine that was sampled, the value to the rounded direction.
            let expected = textbook(phase, cos);
            let slack = 1e-5 * (1.0 + expected * 4.0 * PI);
            assert!((f64::from(sample.pdf.value()) / expected - 1.0).abs() < slack, "{phase:?} {cos}");
            let place = |x: f64| ((x * CELLS as f64) as usize).min(CELLS - 1);
            cells[place(distribution(phase, cos))][0] += 1;
            cells[place(w.dot(t).atan2(w.dot(s)) / TAU + 0.5)][1] += 1;
            mean += w;
        }
        let expected = f64::from(count) / CELLS as f64;
        for kind in 0..2 {
            let chi2: f64 = cells.iter().map(|cell| (f64::from(cell[kind]) - expected).powi(2) / expected).sum();
            let p = 1.0 - ChiSquared::new((CELLS - 1) as f64).expect("a law").cdf(chi2);
            // 22 tests: one in a hundred thousand runs fails.
            assert!(p > 1e-5 / 22.0, "{phase:?}, {}: {chi2}", ["cosines", "azimuths"][kind]);
        }
    }
}

/// The distribution function of cosines, in closed form.
fn distribution(phase: Phase, cos: f64) -> f64 {
    let hg = |g: f32| {
        let g = f64::from(g);
        if g.abs() < 1e-4 {
            return 0.5 * (1.0 + cos); // off by 1e-4 · 3/4 at most, far below a cell's error
        }
        (1.0 - g * g) / (2.0 * g) * ((1.0 + g * g - 2.0 * g * cos).powf(-0.5) - (1.0 + g).recip())
    };
    match phase {
        Phase::Isotropic => 0.5 * (1.0 + cos),
        Phase::Rayleigh => (cos * cos * cos + 3.0 * cos + 4.0) / 8.0,
        Phase::HenyeyGreenstein(g) => hg(g),
        Phase::Mixture([a, b], share) => f64::from(share) * hg(a) + (1.0 - f64::from(share)) * hg(b),
    }
}

/// Coefficients of absorption and of scattering.
const MEDIA: [[[f32; 3]; 2]; 5] = [
    [[0.0; 3], [1.5; 3]],
    [[0.5, 0.2, 0.1], [1.0, 2.0, 3.0]],
    [[0.0, 0.0, 4.0], [0.3, 0.0, 0.0]],
    [[0.1, 0.2, 30.0], [0.01, 1.0, 100.0]],
    [[1.0, 0.5, 0.0], [0.0; 3]],
];

fn medium([absorption, scattering]: [[f32; 3]; 2]) -> Homogeneous {
    Homogeneous::new(Spectrum(absorption), Spectrum(scattering), Phase::Isotropic)
}

/// Sums of a number and of its square, one a lane.
type Sums = [[f64; 2]; 3];

fn add(sums: &mut Sums, factor: Spectrum) {
    for (lane, [sum, squares]) in sums.iter_mut().enumerate() {
        let x = f64::from(factor[lane]);
        assert!((0.0..=3.0 * (1.0 + 1e-5)).contains(&x), "factor {x}");
        (*sum, *squares) = (*sum + x, *squares + x * x);
    }
}

/// Flights along two media estimate the light that each scatters, ∫ σs T, and the transmittance of both, in every lane.
/// A factor is at most the number of lanes.
#[test]
fn flights_estimate_collisions_and_transmittance() {
    let mut random = Random::new(72);
    let count = samples(1 << 15);
    for (first, second) in (0..MEDIA.len()).flat_map(|i| (0..MEDIA.len()).map(move |k| (i, k))) {
        for length in [0.01f32, 0.7, f32::INFINITY] {
            let parts = [(MEDIA[first], 0.4f32), (MEDIA[second], length)];
            let mut sums = [[[0.0; 2]; 3]; 3];
            for _ in 0..count {
                let mut flight = Flight::new(Spectrum::ONE, random.cube());
                let collision = parts.iter().enumerate().find_map(|(number, &(of, length))| {
                    let Collision { distance, factor, .. } =
                        flight.cross(&medium(of).into(), Vec3::ZERO, Vec3::X, length)?;
                    assert!((0.0..length).contains(&distance), "{distance} of {length}");
                    Some((number, factor))
                });
                let (place, factor) = collision.unwrap_or_else(|| (2, flight.factor()));
                add(&mut sums[place], factor);
            }
            let mut before = [1.0f64; 3];
            for (number, (of, length)) in parts.into_iter().enumerate() {
                let through = medium(of).transmittance(length);
                for lane in 0..3 {
                    let [absorbed, scattered] = of.map(|coefficients| f64::from(coefficients[lane]));
                    let albedo = if scattered > 0.0 { scattered / (absorbed + scattered) } else { 0.0 };
                    let through = f64::from(through[lane]);
                    check(&sums[number][lane], count, before[lane] * albedo * (1.0 - through));
                    before[lane] *= through;
                }
            }
            (0..3).for_each(|lane| check(&sums[2][lane], count, before[lane]));
        }
    }
}

/// Six standard errors: 675 checks fail once in a million runs. What is hardly ever sampled has 3 / n a sample at most.
fn check([sum, squares]: &[f64; 2], count: u32, expected: f64) {
    let n = f64::from(count);
    let mean = sum / n;
    let error = ((squares / n - mean * mean) / n).max(0.0).sqrt();
    assert!((mean - expected).abs() < 6.0 * error + 18.0 / n + 1e-5, "{mean} ± {error}, expected {expected}");
}

/// The density of a collision is the derivative of the probability of getting as far.
#[test]
fn densities_of_collisions_are_those_of_the_flight() {
    for of in MEDIA {
        let medium = medium(of);
        let mut random = Random::new(73);
        for _ in 0..samples(200) {
            let mut flight = Flight::new(Spectrum::ONE, random.cube());
            let Some(Collision { distance, .. }) = flight.cross(&medium.into(), Vec3::ZERO, Vec3::X, f32::INFINITY)
            else {
                continue;
            };
            let found = density(flight.through(), medium.extinction);
            let chance = |length: f64| {
                let lane = |lane: usize| (-(f64::from(of[0][lane]) + f64::from(of[1][lane])) * length).exp();
                (lane(0) + lane(1) + lane(2)) / 3.0
            };
            let (at, step) = (f64::from(distance), 1e-5);
            let expected = (chance(at - step) - chance(at + step)) / (2.0 * step);
            // The third derivative times step² / 6, and rounding of f32.
            assert!((f64::from(found) / expected - 1.0).abs() < 1e-4, "{of:?} at {at}: {found} {expected}");
        }
    }
}
