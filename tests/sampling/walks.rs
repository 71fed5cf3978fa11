//! Random walks in a medium without end: their moments, and the fluence around a point that emits.

use etendue::accel::Backend;
use etendue::geometry::Ray;
use etendue::medium::Phase;
use etendue::path::{FlightEnd, MediumPoint, PhaseAt, RandomWalk, TraceStats};
use etendue::sampling::{Address, Density, IndependentSampler, Sampler, Slot, warp};
use etendue::scene::description::{Description, Volume};
use etendue::scene::{BuildOptions, Scene};
use etendue::spectrum::Spectrum;
use etendue_testing::random::{Random, samples};
use etendue_testing::studio::{add_box, camera, glass, with_model};
use glam::{DVec3, Vec3};
use std::f64::consts::PI;

/// A medium of extinction 1 in a box so wide that no walk reaches its boundary.
fn medium(albedo: f32, phase: Phase) -> Scene {
    let mut scene = Description::default();
    let fog = with_model(glass(0.0), |m| {
        m.ior = 1.0;
        let [absorption, scattering] = [1.0 - albedo, albedo].map(Spectrum::splat);
        m.volume = Some(Volume { absorption, scattering, phase, ..Volume::CLEAR });
    });
    add_box(&mut scene, Vec3::ZERO, Vec3::splat(300.0), fog);
    scene.cameras.push(camera(DVec3::Z * 900.0, DVec3::ZERO));
    let options = BuildOptions { backend: Backend::Obvhs, threads: 1, ..BuildOptions::default() };
    Scene::build(scene, &options).expect("a valid scene")
}

/// A walk from the origin and the numbers that it draws.
struct Walker<'a> {
    scene: &'a Scene,
    walk: RandomWalk<'a>,
    sampler: IndependentSampler,
    tally: TraceStats,
}

impl<'a> Walker<'a> {
    fn new(scene: &'a Scene, seed: u64, w: Vec3) -> Self {
        let start = scene.rebase().point(DVec3::ZERO).as_vec3();
        let ray = Ray::new(start, w);
        let ray = ray.carrying(ray.state.within(scene.bodies_at(start)));
        let sampler = IndependentSampler::new(Address::new(77).with(seed));
        Walker { scene, walk: RandomWalk::from_light(scene, ray, Spectrum::ONE), sampler, tally: TraceStats::default() }
    }

    /// Returns the point `p` of the scene in mean free paths.
    fn place(&self, p: Vec3) -> DVec3 {
        self.scene.rebase().point_in_file(p.as_dvec3())
    }

    /// Flies to the next collision.
    fn fly(&mut self) -> MediumPoint {
        match self.walk.fly(&mut self.sampler, &mut self.tally).end {
            Some(FlightEnd::Medium(point)) => point,
            _ => panic!("the walk has left the medium"),
        }
    }

    fn scatter(&mut self, point: &MediumPoint) {
        let phase = PhaseAt::new(point, -self.walk.ray.direction);
        let sample = phase.sample(self.sampler.u2(self.walk.bounce, Slot::Direction));
        self.walk.scatter_in_medium(point, sample.direction, Density::Smooth(sample.pdf));
    }
}

/// Mean and standard error of what is counted.
#[derive(Default)]
struct Mean {
    n: f64,
    sum: f64,
    squares: f64,
}

impl Mean {
    fn add(&mut self, x: f64) {
        (self.n, self.sum, self.squares) = (self.n + 1.0, self.sum + x, self.squares + x * x);
    }

    fn value(&self) -> f64 {
        self.sum / self.n
    }

    fn error(&self) -> f64 {
        ((self.squares / self.n - self.value().powi(2)) / self.n).sqrt()
    }
}

/// Free flights of mean 1 whose cosines have the mean g: ⟨r²⟩ = 2 (n + Σ (n − k) gᵏ) after n of them, and ⟨x⟩ = Σ gᵏ
/// along the first.
#[test]
fn walks_have_their_moments() {
    for (phase, g) in [
        (Phase::Isotropic, 0.0),
        (Phase::Rayleigh, 0.0),
        (Phase::HenyeyGreenstein(0.8), 0.8),
        (Phase::HenyeyGreenstein(-0.6), -0.6f64),
        (Phase::Mixture([0.9, -0.3], 0.75), 0.6),
    ] {
        let scene = medium(1.0, phase);
        let flights = [1, 2, 5, 20];
        let mut moments = flights.map(|_| [Mean::default(), Mean::default()]);
        for seed in 0..u64::from(samples(40_000)) {
            let mut walker = Walker::new(&scene, seed, Vec3::X);
            for n in 1..=20 {
                let point = walker.fly();
                if let Some(at) = flights.iter().position(|&flight| flight == n) {
                    let place = walker.place(point.p);
                    moments[at][0].add(place.length_squared());
                    moments[at][1].add(place.x);
                }
                walker.scatter(&point);
            }
        }
        for (&n, [square, ahead]) in flights.iter().zip(&moments) {
            let expected = 2.0 * (f64::from(n) + (1..n).map(|k| f64::from(n - k) * g.powi(k)).sum::<f64>());
            let along: f64 = (0..n).map(|k| g.powi(k)).sum();
            println!("{phase:?} {n}: {:.5} ± {:.5}, {expected:.5}", square.value(), square.error());
            // Forty normal tests at six standard errors, and roundings of places in a box of 600 mean free paths.
            assert!((square.value() - expected).abs() < 6.0 * square.error() + 1e-3, "{phase:?} {n}");
            assert!((ahead.value() - along).abs() < 6.0 * ahead.error() + 1e-3, "{phase:?} {n}: {}", ahead.value());
        }
    }
}

/// What a flight from `p` along the unit vector `w` expects to fly inside of the ball of radius `r` around the origin.
fn within_ball(p: DVec3, w: DVec3, r: f64) -> f64 {
    let b = p.dot(w);
    let discriminant = b * b - p.length_squared() + r * r;
    if discriminant <= 0.0 {
        return 0.0;
    }
    let [near, far] = [-b - discriminant.sqrt(), -b + discriminant.sqrt()].map(|t| t.max(0.0));
    (-near).exp() - (-far).exp()
}

/// Fluences at some radii, in mean free paths, around a point of unit power.
struct Fluences {
    albedo: f32,
    walks: u32,
    places: &'static [(f64, f64)],
}

const FLUENCES: [Fluences; 3] = [
    Fluences { albedo: 0.5, walks: 200_000, places: &[(1.0, 5.869514e-2), (2.0, 7.927624e-3), (5.0, 1.291324e-4)] },
    Fluences {
        albedo: 0.9,
        walks: 60_000,
        places: &[(0.25, 1.639311), (1.0, 0.1432839), (2.0, 3.712640e-2), (5.0, 2.915125e-3)],
    },
    Fluences {
        albedo: 0.99,
        walks: 20_000,
        places: &[(1.0, 0.2201946), (2.0, 8.497689e-2), (5.0, 1.984174e-2), (10.0, 4.185092e-3)],
    },
];

/// The fluence around a point of unit power that emits in all directions, by Case's solution.
#[test]
fn the_fluence_around_a_point_is_that_of_case() {
    for &Fluences { albedo, walks, places: fluences } in &FLUENCES {
        let scene = medium(albedo, Phase::Isotropic);
        let mut found: Vec<Mean> = fluences.iter().map(|_| Mean::default()).collect();
        let mut random = Random::new(u64::from(walks));
        for seed in 0..u64::from(samples(walks)) {
            let mut walker = Walker::new(&scene, seed, warp::uniform_sphere(random.cube()));
            let mut scores = vec![0.0; fluences.len()];
            loop {
                let (p, w) = (walker.place(walker.walk.ray.origin), walker.walk.ray.direction.as_dvec3());
                let beta = f64::from(walker.walk.beta.mean());
                for (score, &(r, _)) in scores.iter_mut().zip(fluences) {
                    let [inner, outer] = [0.99 * r, 1.01 * r];
                    let shell = 4.0 / 3.0 * PI * (outer.powi(3) - inner.powi(3));
                    *score += beta * (within_ball(p, w, outer) - within_ball(p, w, inner)) / shell;
                }
                let point = walker.fly();
                walker.scatter(&point);
                if !walker.walk.survives(&mut walker.sampler, &mut walker.tally) {
                    break;
                }
            }
            found.iter_mut().zip(scores).for_each(|(mean, score)| mean.add(score));
        }
        for (mean, &(r, expected)) in found.iter().zip(fluences) {
            println!("{albedo} at {r}: {:.6e} ± {:.1e}, {expected:.6e}", mean.value(), mean.error());
            // Eleven normal tests at six standard errors. A shell of 2 % has the mean of its middle but for h²/24 of the
            // second derivative of r² φ, 1.7e-5 times at most 30 at these depths.
            assert!((mean.value() - expected).abs() < 6.0 * mean.error() + 5e-4 * expected, "{albedo} at {r}");
        }
    }
}
