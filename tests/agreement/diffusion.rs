//! Diffusion models in the path tracer, against integrals of their profiles. What the models are worth is measured
//! elsewhere: see `docs/diffusion-table.md`.

use crate::picture::{Shot, render, scene};
use etendue::bsdf::fresnel::dielectric;
use etendue::integrator::{MethodConfig, PathConfig};
use etendue::medium::Phase;
use etendue::named::Named;
use etendue::scene::description::{Description, EnvironmentDescription, Material, PunctualKind, PunctualLight, Volume};
use etendue::spectrum::{LANES, Spectrum};
use etendue::subsurface::{DiffusionModel, MediumLane, RadialProfile, Tabulated, exit_share};
use etendue_testing::deep;
use etendue_testing::studio::{add_box, add_square, camera, glass, matte, narrow, point_light, with_model};
use glam::{DAffine3, DQuat, DVec3, Vec3};
use std::f64::consts::{PI, TAU};

const INDEX: f32 = 1.4;

/// Coefficients by lane, per metre: the lanes have different depths and colours.
const ABSORPTION: [f32; LANES] = [1.0, 4.0, 20.0];
const SCATTERING: [f32; LANES] = [99.0, 46.0, 60.0];

/// A share of light that probes do not reach.
const LOST: f64 = 1e-4;

fn wax() -> Material {
    with_model(glass(0.0), |m| {
        m.ior = INDEX;
        let (absorption, scattering) = (Spectrum(ABSORPTION), Spectrum(SCATTERING));
        m.volume = Some(Volume { absorption, scattering, phase: Phase::Isotropic, ..Volume::CLEAR });
    })
}

/// A block of wax, one metre high and two wide, seen along its normal at the distance `beside` from its edge.
fn block(beside: f64) -> Description {
    let mut scene = Description::default();
    add_box(&mut scene, Vec3::ZERO, Vec3::new(1.0, 0.5, 1.0), wax());
    let at = DVec3::new(1.0 - beside, 0.5, 0.0);
    scene.cameras.push(narrow(camera(at + DVec3::new(0.0, 3.0, 1e-4), at), 1e-5));
    scene
}

fn profiles(model: DiffusionModel) -> [Tabulated; LANES] {
    std::array::from_fn(|lane| {
        let [absorption, scattering] = [ABSORPTION[lane], SCATTERING[lane]].map(f64::from);
        model.profile(&MediumLane { absorption, scattering, mean_cosine: 0.0, eta: INDEX.into() })
    })
}

fn methods(model: DiffusionModel) -> [MethodConfig; 2] {
    let config = PathConfig { subsurface: Some(model) };
    [MethodConfig::Path(config), MethodConfig::PathNee(config)]
}

/// Renders `scene` and compares each lane with `expected`, at six standard errors, what probes do not reach, and
/// `error`.
fn judge(description: Description, model: DiffusionModel, expected: impl Fn(usize, &Tabulated) -> f64, error: f64) {
    let scene = scene(description);
    let profiles = profiles(model);
    for method in methods(model) {
        let found = render(&scene, Shot::new(method, 16, if deep() { 1 << 14 } else { 1 << 7 })).blocks(1);
        for lane in 0..LANES {
            let (noise, expected) = (found[lane].variance.sqrt(), expected(lane, &profiles[lane]));
            println!("{method:?} lane {lane}: {:.6} ± {noise:.6}, {expected:.6}", found[lane].mean);
            let bound = 6.0 * noise + (LOST + error) * expected;
            assert!((found[lane].mean - expected).abs() < bound, "{method:?} {lane}: {found:?} {expected}");
        }
    }
}

/// Under a white sky a flat body reflects the total of its profile of what enters.
#[test]
fn a_flat_body_reflects_the_total_of_its_profile() {
    for &model in DiffusionModel::all() {
        let mut description = block(1.0);
        description.environment = Some(EnvironmentDescription::Uniform(Spectrum::ONE));
        let reflected = dielectric(1.0f64, INDEX.into());
        judge(description, model, |_, profile| reflected + (1.0 - reflected) * profile.total(), 1e-5);
    }
}

/// Probes through a plate of ten mean free paths find both of its faces, of which a black floor leaves one without
/// light.
#[test]
fn a_plate_over_a_black_floor_is_lit_from_above() {
    let mut description = Description::default();
    add_box(&mut description, Vec3::ZERO, Vec3::new(1.0, 0.105, 1.0), wax());
    add_square(&mut description, Vec3::NEG_Y * 0.2, Vec3::X * 40.0, Vec3::NEG_Z * 40.0, matte(0.0, 0.0));
    description.cameras.push(narrow(camera(DVec3::new(0.0, 3.0, 1e-4), DVec3::ZERO), 1e-5));
    description.environment = Some(EnvironmentDescription::Uniform(Spectrum::ONE));
    let reflected = dielectric(1.0f64, INDEX.into());
    judge(description, DiffusionModel::Burley, |_, profile| reflected + (1.0 - reflected) * profile.total(), 1e-5);
}

/// Beside an edge light leaves through both faces: the profile at the distance through the body, integrated over them.
#[test]
fn light_leaves_around_an_edge() {
    let beside = 0.012;
    for model in [DiffusionModel::PhotonBeam, DiffusionModel::Burley] {
        let mut description = block(beside);
        description.environment = Some(EnvironmentDescription::Uniform(Spectrum::ONE));
        let reflected = dielectric(1.0f64, INDEX.into());
        // The top up to the edge, and the half-plane of the side below it; r = e^x by the midpoint rule.
        let expected = |_: usize, profile: &Tabulated| {
            let steps = 40_000;
            let (first, last) = (1e-9f64.ln(), 1.0f64.ln());
            let step = (last - first) / f64::from(steps);
            let sum: f64 = (0..steps)
                .map(|k| {
                    let r = (first + (f64::from(k) + 0.5) * step).exp();
                    let open = if r > beside { TAU - 2.0 * (beside / r).acos() } else { TAU };
                    r * r * (open * profile.value(r) + PI * profile.value(beside.hypot(r)))
                })
                .sum();
            reflected + (1.0 - reflected) * sum * step
        };
        // The midpoint rule at the kink of the angle, and the width of the view.
        judge(description, model, expected, 1e-3);
    }
}

/// Light of one direction enters by the Fresnel transmittance of its angle: E T(θ) / (π c) of it leaves along the
/// normal, with c the share of diffuse light that passes.
#[test]
fn light_enters_by_its_angle() {
    for cos in [1.0, 0.5, 0.1f64] {
        let mut description = block(1.0);
        let down = DVec3::new(-(1.0 - cos * cos).sqrt(), -cos, 0.0);
        let transform = DAffine3::from_quat(DQuat::from_rotation_arc(DVec3::NEG_Z, down));
        let kind = PunctualKind::Directional;
        let intensity = Spectrum::splat(2.0);
        description.lights.push(PunctualLight { name: "sun".into(), kind, intensity, transform });
        let passed = |cos: f64| 1.0 - dielectric(cos, f64::from(INDEX));
        let entering = 2.0 * cos * passed(cos) / (PI * exit_share(INDEX.into()));
        judge(description, DiffusionModel::Burley, |_, profile| passed(1.0) * profile.total() * entering, 1e-5);
    }
}

/// A lamp of some size and one of none light it by all techniques alike, and a floor around it is lit by it.
#[test]
fn lamps_light_it_by_both_techniques_alike() {
    let mut description = block(0.1);
    add_square(&mut description, Vec3::new(0.8, 2.0, 0.0), Vec3::X * 0.5, Vec3::Z * 0.5, matte(0.0, 5.0));
    add_square(&mut description, Vec3::new(0.0, -0.5, 0.0), Vec3::X * 4.0, Vec3::NEG_Z * 4.0, matte(0.8, 0.0));
    description.lights.push(point_light(DVec3::new(1.5, 0.8, 0.2), 1.0));
    description.cameras[0] = narrow(camera(DVec3::new(3.0, 2.0, 2.0), DVec3::new(0.6, 0.0, 0.0)), 0.6);
    let scene = scene(description);
    let [path, nee] = methods(DiffusionModel::PhotonBeam)
        .map(|method| render(&scene, Shot { seed: method.kind() as u64, ..Shot::new(method, 32, 256) }).blocks(2));
    for (a, b) in path.iter().zip(&nee) {
        // Twelve blocks at six standard errors.
        assert!(a.z(*b).abs() < 6.0, "{a:?} {b:?}");
    }
}
