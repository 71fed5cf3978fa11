//! Light tracing and bidirectional path tracing against path tracing, exact answers and themselves.
//!
//! Splats of one walk fall on several pixels, so that pixels are not independent: every error here is that between
//! whole renders with seeds of their own, and every judgement Welch's or Student's at a family-wise level.

use crate::equilibrium::{KINDS, Kind, equilibrium};
use crate::picture::{LEVEL, Shot, scene};
use crate::reciprocity::{IN_GLASS, INDEX, alcove};
use etendue::film::{Crop, Filter, Layout, PassFilm};
use etendue::integrator::{self, Guards, IntegratorConfig, Method, PilotEstimate};
use etendue::parallel::Cancel;
use etendue::path::{Technique, Techniques};
use etendue::sampling::SamplerKind;
use etendue::scene::Scene;
use etendue::scene::description::{CameraDescription, Projection};
use etendue::stats::{Estimate, Moments, t_test, welch_test};
use etendue_testing::deep;
use etendue_testing::levels::sidak_level;
use etendue_testing::methods::ChainOptions;
use etendue_testing::studio::{camera, matte, point_light};
use etendue_testing::worlds::{World, all};
use glam::DVec3;

/// Independent renders of a picture.
const RUNS: u64 = 16;

/// Colours of independent renders: run by run, pixel by pixel, lane by lane.
pub(crate) struct Runs {
    side: usize,
    pub(crate) images: Vec<Vec<f64>>,
}

/// What the runs vary besides what a [`Shot`] says.
#[derive(Clone, Copy)]
pub(crate) struct How {
    pub(crate) shot: Shot,
    pub(crate) techniques: Techniques,
    pub(crate) crop: Option<Crop>,
    pub(crate) chains: ChainOptions,
}

impl How {
    pub(crate) fn new(method: Method, side: u32, spp: u64) -> Self {
        How {
            shot: Shot::new(method, side, spp),
            techniques: Techniques::ALL,
            crop: None,
            chains: ChainOptions::default(),
        }
    }

    pub(crate) fn without(self, left_out: &[Technique]) -> Self {
        How { techniques: Techniques::without(left_out), ..self }
    }
}

/// The sum of passes of one seed over their number.
pub(crate) fn image(scene: &Scene, camera: usize, how: &How, seed: u64) -> Vec<f64> {
    let Shot { side, spp, method, depth, .. } = how.shot;
    let layout = Layout::new(side, side, how.crop, &[]);
    let options = IntegratorConfig {
        seed,
        max_depth: depth,
        filter: how.shot.filter,
        sampler: SamplerKind::Sobol,
        replicates: 1,
        ..IntegratorConfig::new(how.chains.config(method.kind(), how.techniques), &layout)
    };
    let camera = scene.camera(Some(&camera.to_string()), side, side).expect("a camera");
    let pilot = integrator::pilot(scene, &camera, &options, &layout);
    let integrator = integrator::build(scene, camera, &options, &pilot);
    let (mut pass, mut sums) = (PassFilm::new(&layout), vec![0.0; layout.pixels() * 3]);
    for k in 0..spp {
        pass.clear();
        let report = integrator.run_pass(k, &Cancel::new(), &mut pass).expect("not cancelled");
        assert_eq!(report.guards, Guards::default(), "a guard fired");
        sums.iter_mut().zip(pass.values()).for_each(|(sum, &v)| *sum += f64::from(v) / spp as f64);
    }
    sums
}

pub(crate) fn runs(scene: &Scene, how: &How) -> Runs {
    some_runs(scene, how, RUNS)
}

/// So many of them, where each begins with a costly pilot.
pub(crate) fn some_runs(scene: &Scene, how: &How, count: u64) -> Runs {
    let images = (0..count).map(|run| image(scene, 0, how, 100 * (how.shot.method.kind() as u64 + 1) + run)).collect();
    let side = how.crop.map_or(how.shot.side, |crop| crop.x1 - crop.x0) as usize;
    Runs { side, images }
}

impl Runs {
    /// Means of `n` × `n` blocks, each lane on its own, and of the whole image.
    fn blocks(&self, n: usize) -> Vec<Estimate> {
        let size = self.side / n;
        let of = |block: usize, lane: usize| -> Estimate {
            let (x, y) = (block % n * size, block / n * size);
            let mean = |image: &Vec<f64>| {
                let pixels = (y..y + size).flat_map(|y| (x..x + size).map(move |x| y * self.side + x));
                pixels.map(|p| image[3 * p + lane]).sum::<f64>() / (size * size) as f64
            };
            estimate(self.images.iter().map(mean))
        };
        let blocks =
            (0..n * n).flat_map(|block| (0..3).map(move |lane| (block, lane))).map(|(block, lane)| of(block, lane));
        blocks.chain(std::iter::once(self.overall())).collect()
    }

    /// The same, so many times as bright.
    pub(crate) fn scaled(&self, factor: f64) -> Runs {
        Runs {
            side: self.side,
            images: self.images.iter().map(|image| image.iter().map(|v| v * factor).collect()).collect(),
        }
    }

    pub(crate) fn overall(&self) -> Estimate {
        estimate(self.images.iter().map(|image| image.iter().sum::<f64>() / image.len() as f64))
    }
}

fn estimate(values: impl Iterator<Item = f64>) -> Estimate {
    values.collect::<Moments>().estimate().expect("runs")
}

pub(crate) fn times(a: Estimate, factor: f64) -> Estimate {
    Estimate { value: a.value * factor, standard_error: a.standard_error * factor, ..a }
}

/// Whether the blocks of both have the same means.
pub(crate) fn agree(a: &Runs, b: &Runs) -> Result<(), String> {
    let pairs: Vec<_> = a.blocks(4).into_iter().zip(b.blocks(4)).collect();
    // Blocks that nothing reaches in either have no error to compare by.
    let lit = pairs.iter().filter(|(a, b)| a.standard_error > 0.0 || b.standard_error > 0.0);
    let least = lit.map(|(a, b)| welch_test(a, b).p_value).fold(1.0, f64::min);
    let (a, b) = pairs[pairs.len() - 1];
    let text = format!(
        "least p {least:.1e}; {:.5} ± {:.5}, {:.5} ± {:.5}",
        a.value, a.standard_error, b.value, b.standard_error
    );
    println!("{text}");
    if least > sidak_level(LEVEL, pairs.len() as u64) { Ok(()) } else { Err(text) }
}

pub(crate) fn spp(shallow: u64) -> u64 {
    if deep() { 64 * shallow } else { shallow }
}

/// Mirrors, glass, mixtures, bent normals, absorption, textures apart: everything that both find.
#[test]
fn bdpt_and_light_match_path() {
    for World { name, scene, .. } in all().into_iter().filter(|w| w.name != "open") {
        let path = runs(&scene, &How::new(Method::Path, 16, spp(16)));
        let bdpt = runs(&scene, &How::new(Method::Bdpt, 16, spp(8)));
        agree(&path, &bdpt).unwrap_or_else(|e| panic!("{name}: {e}"));
        // Path tracing finds caustics by chance, with much noise.
        let planted = if scene.features().dirac { 1.2 } else { 1.03 };
        assert!(agree(&path, &bdpt.scaled(planted)).is_err(), "{name}: {planted} times as bright is not convicted");
        if !scene.features().dirac {
            let light = runs(&scene, &How::new(Method::Light, 16, spp(16)));
            agree(&path, &light).unwrap_or_else(|e| panic!("{name}, light tracing: {e}"));
        }
    }
}

/// Techniques that are switched off leave every weight: what is left still adds up, as far as it finds everything.
#[test]
fn complete_technique_subsets_agree() {
    use Technique::{Connect, Hit, NextEvent, Splat};
    for World { name, scene, .. } in all() {
        // Under lights without extent and behind mirrors each of these misses something.
        let sets: &[&[Technique]] = match name {
            "open" => &[&[Connect], &[Hit, Connect]],
            "rough" => &[&[Connect], &[Splat], &[Hit], &[NextEvent], &[Hit, NextEvent], &[Connect, NextEvent, Splat]],
            _ => &[&[Connect], &[Splat], &[NextEvent], &[Splat, Connect]],
        };
        let whole = runs(&scene, &How::new(Method::Bdpt, 16, spp(8)));
        for set in sets.iter().filter(|set| name != "open" || set.len() == 1) {
            let part = runs(&scene, &How::new(Method::Bdpt, 16, spp(8)).without(set));
            agree(&whole, &part).unwrap_or_else(|e| panic!("{name} without {set:?}: {e}"));
        }
    }
}

/// Random scenes in thermal equilibrium are of one brightness, whatever stands in them: see `equilibrium.rs`.
#[test]
fn bdpt_and_light_keep_thermal_equilibrium() {
    let rounds = if deep() { 20 } else { 2 };
    let cases: Vec<(Kind, u64)> = (0..rounds).flat_map(|round| KINDS.map(|kind| (kind, round))).collect();
    for &(kind, round) in &cases {
        let (description, expected) = equilibrium(kind, 1000 + round * 10 + kind as u64);
        let scene = scene(description);
        let methods: &[Method] = if kind == Kind::Matte { &[Method::Bdpt, Method::Light] } else { &[Method::Bdpt] };
        for &method in methods {
            let found =
                runs(&scene, &How::new(method, 16, spp(if method == Method::Light { 32 } else { 8 }))).overall();
            println!("{kind:?} {round} {method:?}: {} ± {:.1e} of {expected}", found.value, found.standard_error);
            let level = sidak_level(LEVEL, 2 * cases.len() as u64);
            // In a scene that loses nothing every sample may be exact but for a few dozen roundings.
            let exact = (found.value - expected).abs() < 64.0 * f64::from(f32::EPSILON) * expected;
            let right = |found: &Estimate| t_test(found, expected).p_value > level;
            assert!(exact || right(&found), "{kind:?} {round}, {method:?}: {found:?} of {expected}");
            assert!(!right(&times(found, 1.1)), "{kind:?} {round}, {method:?}: 10 % are not convicted, {found:?}");
        }
    }
}

/// ∫ L dω at `eye` under a point light of intensity 1 at `light`, by six views.
fn response(eye: DVec3, light: DVec3, method: Method, spp: u64) -> Estimate {
    const SIDE: u32 = 16;
    let projection = Projection::Perspective { yfov: std::f64::consts::FRAC_PI_2, aspect: None };
    let mut alcove = alcove();
    alcove.lights.push(point_light(light, 1.0));
    for axis in [DVec3::X, DVec3::NEG_X, DVec3::Y, DVec3::NEG_Y, DVec3::Z, DVec3::NEG_Z] {
        alcove.cameras.push(CameraDescription { projection, ..camera(eye, eye + axis) });
    }
    let alcove = scene(alcove);
    let weight = |pixel: usize| {
        let at = |k: usize| (2 * k + 1) as f64 / f64::from(SIDE) - 1.0;
        let (u, v) = (at(pixel % SIDE as usize), at(pixel / SIDE as usize));
        (2.0 / f64::from(SIDE)).powi(2) * (1.0 + u * u + v * v).powf(-1.5)
    };
    let of_run = |run: u64| {
        let view = |face: usize| {
            let image = image(&alcove, face, &How::new(method, SIDE, spp), 6 * run + face as u64);
            image.chunks(3).enumerate().map(|(pixel, rgb)| weight(pixel) * rgb[0]).sum::<f64>()
        };
        (0..6).map(view).sum::<f64>()
    };
    estimate((0..RUNS).map(of_run))
}

/// CameraDescription and light swapped: see `reciprocity.rs`. The weights' change within a pixel of 1/8 is second
/// order, 4e-3, and nearly the same both ways.
#[test]
fn bdpt_and_light_are_reciprocal() {
    let (a, b) = (DVec3::new(-0.9, 1.3, 0.9), DVec3::new(0.9, 0.9, 0.6));
    let cases = [
        (Method::Bdpt, a, b, 1.0, 8, 1.1),
        (Method::Light, a, b, 1.0, 64, 1.25),
        (Method::Bdpt, IN_GLASS, b, INDEX * INDEX, 16, 1.25),
    ];
    for (method, here, there, factor, samples, planted) in cases {
        let [forth, back] = [response(here, there, method, spp(samples)), response(there, here, method, spp(samples))];
        let back = times(back, factor);
        let level = sidak_level(LEVEL, cases.len() as u64);
        println!("{method:?}: {forth:?} and {back:?}");
        assert!(welch_test(&forth, &back).p_value > level, "{method:?}: {forth:?} and {back:?}");
        assert!(welch_test(&forth, &times(back, planted)).p_value < level, "{method:?}: {planted} is not convicted");
    }
}

/// A crop has the light of the same pixels in the whole, though as many walks as its pixels start from lights.
pub(crate) fn expect_crop(scene: &Scene, how: How, filter: Filter) {
    let mut how = how;
    how.shot.filter = filter;
    let whole = runs(scene, &how);
    let crop = Crop { x0: 4, y0: 6, x1: 12, y1: 14 };
    let part = runs(scene, &How { crop: Some(crop), ..how });
    let cut = |image: &Vec<f64>| {
        let rows = (crop.y0..crop.y1).map(|y| (16 * y + crop.x0) as usize * 3..(16 * y + crop.x1) as usize * 3);
        rows.flat_map(|row| image[row].to_vec()).collect()
    };
    let same = Runs { side: 8, images: whole.images.iter().map(cut).collect() };
    agree(&part, &same).unwrap_or_else(|e| panic!("{:?}, {filter:?}: {e}", how.shot.method));
}

#[test]
fn bdpt_crop_matches_the_full_image() {
    let World { scene, .. } = all().into_iter().next().expect("rough");
    expect_crop(&scene, How::new(Method::Light, 16, spp(8)), Filter::Box);
}

#[test]
fn bdpt_crop_matches_the_full_image_under_wide_filters() {
    let World { scene, .. } = all().into_iter().next().expect("rough");
    expect_crop(&scene, How::new(Method::Light, 16, spp(8)), Filter::BlackmanHarris);
    expect_crop(&scene, How::new(Method::Bdpt, 16, spp(8)), Filter::Gaussian);
    expect_crop(&scene, How::new(Method::Bdpt, 16, spp(8)), Filter::Box);
}

#[test]
fn bdpt_mean_is_independent_of_resolution() {
    let World { scene, .. } = all().into_iter().next().expect("rough");
    for method in [Method::Light, Method::Bdpt] {
        let [coarse, fine] = [16, 32].map(|side| runs(&scene, &How::new(method, side, spp(8))));
        agree(&coarse, &fine).unwrap_or_else(|e| panic!("{method:?}: {e}"));
    }
}

/// Depth counts scattering events in every technique.
#[test]
fn max_depth_agrees_between_path_and_bdpt() {
    let World { scene, .. } = all().into_iter().next().expect("rough");
    for depth in [0, 1, 2, 3] {
        let of = |method| {
            let mut how = How::new(method, 16, spp(16));
            how.shot.depth = Some(depth);
            runs(&scene, &how)
        };
        let path = of(Method::Path);
        for method in [Method::Light, Method::Bdpt] {
            agree(&path, &of(method)).unwrap_or_else(|e| panic!("{method:?}, depth {depth}: {e}"));
        }
    }
}

/// A pass is the same bits on any number of threads.
#[test]
fn bdpt_is_independent_of_thread_count() {
    let World { scene, .. } = all().into_iter().next().expect("rough");
    let layout = Layout::new(40, 40, None, &[]);
    let camera = scene.camera(None, 40, 40).expect("a camera");
    for method in [Method::Light, Method::Bdpt, Method::Pssmlt, Method::Mmlt, Method::Mlt] {
        let options = IntegratorConfig::new(method, &layout);
        let integrator = integrator::build(&scene, camera.clone(), &options, &PilotEstimate::default());
        let on = |threads: usize| {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("threads");
            let mut pass = PassFilm::new(&layout);
            pool.install(|| integrator.run_pass(3, &Cancel::new(), &mut pass)).expect("not cancelled");
            pass.values().to_vec()
        };
        let one = on(1);
        assert!([2, 5].map(on).iter().all(|many| *many == one), "{method:?}");
    }
}

/// Black walls scatter nothing, and only what the camera sees directly is left.
#[test]
fn black_walls_show_their_emission_only() {
    let mut black = etendue::scene::description::Description::default();
    etendue_testing::studio::add_room(&mut black, &matte(0.0, 0.5));
    black.cameras.push(camera(DVec3::new(0.1, 0.0, 0.2), DVec3::X));
    let black = scene(black);
    for method in [Method::Light, Method::Bdpt, Method::Mlt] {
        let image = image(&black, 0, &How::new(method, 8, 4), 1);
        assert!(image.iter().all(|&v| (v - 0.5).abs() < 1e-6), "{method:?}");
    }
}
