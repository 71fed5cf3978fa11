//! Exact identities: samples carry what `eval` and `pdf` say, f32 computes what f64 does, values are reciprocal, lobes
//! add up, densities are Jacobians.

use crate::models::{Model, any_direction, direction, models};
use etendue::bsdf::ggx::reflect;
use etendue::bsdf::{Bsdf, Dielectric, Ggx, Lobes, Surface};
use etendue::geometry::Local;
use etendue::sampling::Density;
use etendue::spectrum::Spectrum;
use etendue::transport::TransportMode;
use etendue_testing::backward::range;
use etendue_testing::random::{Random, samples};

const ALPHAS: [f32; 5] = [1e-4, 1e-3, 0.05, 0.3, 1.0];
const WAYS: [TransportMode; 2] = [TransportMode::Radiance, TransportMode::Importance];

pub(crate) fn value(surface: &Surface, mode: TransportMode, known: Local<f64>, other: Local<f64>) -> f64 {
    let (wi, wo) = mode.flow(known, other);
    surface.eval(wi, wo, Lobes::SMOOTH)[1]
}

/// Compares single-precision results with ranges, and counts those that can be compared.
#[derive(Default)]
struct Comparison {
    compared: u32,
    unresolved: u32,
}

impl Comparison {
    fn check(&mut self, what: &str, got: f32, range: Option<[f64; 2]>) {
        let Some([low, high]) = range else { return self.unresolved += 1 };
        let got = f64::from(got);
        assert!((low..=high).contains(&got), "{what}: {got} is not in {low} .. {high}");
        self.compared += 1;
    }
}

impl Drop for Comparison {
    fn drop(&mut self) {
        let enough = self.compared > 4 * self.unresolved;
        assert!(enough || std::thread::panicking(), "{} compared, {} not resolved", self.compared, self.unresolved);
    }
}

/// Some known direction, often grazing, on either side.
fn known_direction(random: &mut Random) -> Local {
    let [a, b, c] = random.cube();
    let cos = if a < 0.5 { 1e-4f32.powf(b) } else { b.max(1e-4) };
    direction(if c < 0.5 { cos } else { -cos }, 40.0 * c)
}

fn compare(
    comparison: &mut Comparison,
    model: &Model,
    mode: TransportMode,
    [known, other]: [Local; 2],
    got: (f32, f32),
) {
    let (directions, epsilon) = ([known.cast(), other.cast()], f64::from(f32::EPSILON));
    let what = format!("{} {mode:?} {known:?} {other:?}", model.name);
    let f = range(directions, epsilon, model.base, |k, o| value(&model.surface, mode, k, o));
    comparison.check(&format!("value of {what}"), got.0, f);
    let p = range(directions, epsilon, model.base, |k, o| model.surface.pdf(k, o, mode, Lobes::SMOOTH));
    comparison.check(&format!("density of {what}"), got.1, p);
}

#[test]
fn a_sample_carries_its_value_and_density() {
    let (mut random, mut comparison) = (Random::new(1), Comparison::default());
    for model in ALPHAS.into_iter().flat_map(models) {
        for i in 0..samples(400) {
            let (mode, known) = (WAYS[i as usize % 2], known_direction(&mut random));
            let Some(sample) = model.surface.sample(known, mode, random.cube()) else { continue };
            let Density::Smooth(pdf) = sample.density else { continue };
            let got = (sample.value[1], pdf.value());
            compare(&mut comparison, &model, mode, [known, sample.direction], got);
        }
    }
}

#[test]
fn single_precision_computes_what_double_does() {
    let (mut random, mut comparison) = (Random::new(2), Comparison::default());
    for model in ALPHAS.into_iter().flat_map(models) {
        for i in 0..samples(400) {
            let mode = WAYS[i as usize % 2];
            let (known, other) = (known_direction(&mut random), any_direction(random.cube()));
            let (wi, wo) = mode.flow(known, other);
            let f = model.surface.eval(wi, wo, Lobes::SMOOTH)[1];
            let pdf = model.surface.pdf(known, other, mode, Lobes::SMOOTH);
            compare(&mut comparison, &model, mode, [known, other], (f, pdf));
        }
    }
}

#[test]
fn values_over_the_square_of_the_index_are_reciprocal() {
    let mut random = Random::new(3);
    for model in ALPHAS.into_iter().flat_map(models) {
        let index = |w: Local<f64>| if w.z > 0.0 { 1.0 } else { f64::from(model.eta) };
        for _ in 0..samples(400) {
            let [a, b] = [random.cube(), random.cube()].map(|u| any_direction(u).cast::<f64>().normalized());
            let forth = |a: Local<f64>, b: Local<f64>| {
                value(&model.surface, TransportMode::Importance, a, b) / index(b).powi(2)
            };
            let Some([low, high]) = range([a, b], f64::EPSILON, model.base, |a, b| forth(b, a)) else { continue };
            assert!((low..=high).contains(&forth(a, b)), "{} {a:?} {b:?}: {} and {low}", model.name, forth(a, b));
        }
    }
}

#[test]
fn reflection_and_transmission_add_up() {
    let mut random = Random::new(4);
    for model in ALPHAS.into_iter().flat_map(models) {
        for _ in 0..samples(100) {
            let (a, b) = (any_direction(random.cube()), any_direction(random.cube()));
            let value = |lobes| model.surface.eval(a, b, lobes);
            assert_eq!(value(Lobes::REFLECT) + value(Lobes::TRANSMIT), value(Lobes::ALL), "{}", model.name);
            assert!(value(Lobes::DIRAC).is_black());
            let pdf = |lobes| model.surface.pdf(a, b, TransportMode::Radiance, lobes);
            assert_eq!(pdf(Lobes::REFLECT) + pdf(Lobes::TRANSMIT), pdf(Lobes::ALL), "{}", model.name);
        }
    }
}

/// |∂w/∂u₀ × ∂w/∂u₁| of a map from the square to directions, by central differences.
fn jacobian(map: impl Fn(f64, f64) -> Local<f64>, u: [f64; 2]) -> f64 {
    const STEP: f64 = 1e-5;
    let slope = |a: Local<f64>, b: Local<f64>| a.plus(b.reversed()).scale(0.5 / STEP);
    let p = slope(map(u[0] + STEP, u[1]), map(u[0] - STEP, u[1]));
    let q = slope(map(u[0], u[1] + STEP), map(u[0], u[1] - STEP));
    let cross = Local::new(p.y * q.z - p.z * q.y, p.z * q.x - p.x * q.z, p.x * q.y - p.y * q.x);
    cross.dot(cross).sqrt()
}

fn visible_normal(ggx: Ggx, w: Local<f64>, u: f64, v: f64) -> Local<f64> {
    let (sin, cos) = (std::f64::consts::TAU * u).sin_cos();
    ggx.cap_normal(w, [cos, sin], v)
}

/// `w` refracted into the index ratio `eta` at the normal `h` by Snell's law; `None` under total reflection.
fn snell(w: Local<f64>, h: Local<f64>, eta: f64) -> Option<Local<f64>> {
    let along = h.scale(w.dot(h));
    let across = w.plus(along.reversed()).scale(-1.0 / eta);
    let cos2 = 1.0 - across.dot(across);
    (cos2 > 0.0).then(|| across.plus(h.scale(-cos2.sqrt())))
}

/// Relative error of central differences with steps of 1e-5 in numbers kept 0.05 from the edges: (h / 0.05)² ∂³ of maps
/// whose third derivatives relative to the first stay below 100, and roundings of 1e-16 / 1e-5.
const DIFFERENCES: f64 = 1e-5;

#[test]
fn densities_are_the_jacobians_of_the_maps() {
    let mut random = Random::new(5);
    for ggx in ALPHAS.map(Ggx::new) {
        for _ in 0..samples(100) {
            let known: Local<f64> = any_direction(random.cube()).cast();
            let known = Local::new(known.x, known.y, known.z.abs().max(0.02)).normalized();
            let u = [random.f64(), 0.05 + 0.9 * random.f64()];
            let h = visible_normal(ggx, known, u[0], u[1]);
            let normals = jacobian(|a, b| visible_normal(ggx, known, a, b), u) * ggx.visible_normal_pdf(known, h);
            assert!((normals - 1.0).abs() < DIFFERENCES, "normals: {normals}");
            let mirrored =
                jacobian(|a, b| reflect(known, visible_normal(ggx, known, a, b)), u) * ggx.reflection_pdf(known, h);
            assert!((mirrored - 1.0).abs() < DIFFERENCES, "reflections: {mirrored}");
        }
    }
}

#[test]
fn the_density_of_refraction_is_the_jacobian_of_snells_law() {
    let mut random = Random::new(6);
    for (alpha, eta) in [(1e-3, 1.5f32), (0.3, 1.5), (1.0, 1.5), (0.3, 0.7), (1.0, 0.7)] {
        let ggx = Ggx::new(alpha);
        let glass = Dielectric { ggx, eta, reflect: Spectrum::ZERO, transmit: Spectrum::ONE };
        for _ in 0..samples(100) {
            let known: Local<f64> = any_direction(random.cube()).cast();
            let known = Local::new(known.x, known.y, known.z.abs().max(0.1)).normalized();
            let u = [random.f64(), 0.05 + 0.9 * random.f64()];
            let map = |a, b| snell(known, visible_normal(ggx, known, a, b), f64::from(eta));
            let Some(other) = map(u[0], u[1]).filter(|w| w.z < -1e-3) else { continue };
            let critical = known.dot(visible_normal(ggx, known, u[0], u[1]));
            if 1.0 - critical * critical > 0.95 * f64::from(eta).powi(2) {
                continue; // differences fail at the angle of total reflection, where Snell's law has a root
            }
            let got = jacobian(|a, b| map(a, b).unwrap_or(other), u)
                * glass.pdf(known, other, TransportMode::Radiance, Lobes::ALL);
            assert!((got - 1.0).abs() < DIFFERENCES, "alpha {alpha} eta {eta} {known:?} {other:?}: {got}");
        }
    }
}

/// What weights take for the density of a Dirac refraction, P |w·ns| η², is as rough glass has it in both directions:
/// the ratio of the densities of both ways through nearly smooth facets is that of the smooth face. Masking adds a
/// share of α² / cos² each way.
#[test]
fn dirac_densities_are_the_limit_of_rough_ones() {
    let alpha = 1e-3;
    let glass = |alpha| Dielectric { ggx: Ggx::new(alpha), eta: 1.5, reflect: Spectrum::ONE, transmit: Spectrum::ONE };
    let (smooth, rough) = (glass(0.0), glass(alpha));
    for known in [1.0f32, 0.9, 0.5, 0.2, -1.0, -0.95, -0.8].map(|cos| direction(cos, 0.7)) {
        let there =
            smooth.dirac(known, TransportMode::Importance, Lobes::DIRAC_TRANSMIT).expect("below the critical angle");
        let back = smooth.dirac(there.direction, TransportMode::Radiance, Lobes::DIRAC_TRANSMIT).expect("the way back");
        let eta2 = f64::from(there.eta).powi(2);
        let forward = f64::from(there.density.value() * there.direction.z.abs()) * eta2;
        let reverse = f64::from(back.density.value() * known.z.abs());
        // In f64 the refracted direction must be exact: the lobe is a thousand times narrower than it is bright.
        let other =
            snell(known.cast(), Local::new(0.0, 0.0, 1.0f64.copysign(f64::from(known.z))), f64::from(there.eta));
        let other = other.expect("refracted");
        let pdf = |a: Local<f64>, b: Local<f64>, mode| rough.pdf(a, b, mode, Lobes::SMOOTH);
        let limit =
            pdf(other, known.cast(), TransportMode::Radiance) / pdf(known.cast(), other, TransportMode::Importance);
        let slack =
            4.0 * f64::from(alpha).powi(2) / f64::from(known.z.abs().min(there.direction.z.abs())).powi(2) + 1e-5; // f32 inputs
        assert!((reverse / forward / limit - 1.0).abs() < slack, "{known:?}: {reverse} / {forward} against {limit}");
    }
}
