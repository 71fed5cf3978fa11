//! Methods whose pixels share virtual lights: `vpl`, `lightcuts`, `deterministic-lightcuts`.
//!
//! Only independent runs tell their noise. A test looks at the mean of each image of many seeds.

use crate::equilibrium::{KINDS, ROUNDING, equilibrium};
use crate::picture::{LEVEL, scene};
use crate::references::load;
use etendue::film::{Filter, Layout, Plane};
use etendue::integrator::{
    DeterministicLightcutsConfig, FilmRenderer, IntegratorConfig, LightcutsConfig, Method, MethodConfig, PassReport,
    VirtualLightsConfig,
};
use etendue::scene::Scene;
use etendue_testing::levels::sidak_level;
use etendue_testing::{deep, worlds};
use rayon::prelude::*;
use statrs::distribution::{ContinuousCDF, StudentsT};

/// Columns and rows of the blocks whose means are tested, and all of the image.
const BLOCKS: usize = 2;
const TESTS: usize = BLOCKS * BLOCKS + 1;

/// Means of the blocks and of the image, lanes together.
type Means = [f64; TESTS];

/// Renders `spp` samples a pixel of a square picture.
fn render(scene: &Scene, config: impl Into<MethodConfig>, side: u32, spp: u64, seed: u64) -> (Vec<f32>, PassReport) {
    let layout = Layout::new(side, side, None, &[]);
    let options = IntegratorConfig { seed, filter: Filter::Box, ..IntegratorConfig::new(config, &layout) };
    let camera = scene.camera(None, side, side).expect("a camera");
    let mut renderer = FilmRenderer::begin(scene, camera, &options, &layout);
    let report = renderer.passes(spp);
    (renderer.film().mean(Plane::Color), report)
}

fn means(pixels: &[f32], side: usize) -> Means {
    let (mut means, size) = ([0.0; TESTS], side / BLOCKS);
    let all = (pixels.len() / 3) as f64;
    for (i, lanes) in pixels.chunks_exact(3).enumerate() {
        let mean = lanes.iter().map(|&x| f64::from(x)).sum::<f64>() / 3.0;
        means[i / side / size * BLOCKS + i % side / size] += mean / (all / (BLOCKS * BLOCKS) as f64);
        means[TESTS - 1] += mean / all;
    }
    means
}

/// Block means of `seeds` pictures.
fn pictures(scene: &Scene, config: MethodConfig, side: u32, spp: u64, seeds: u64) -> Vec<Means> {
    let picture = |seed| means(&render(scene, config, side, spp, seed).0, side as usize);
    (1..=seeds).into_par_iter().map(picture).collect()
}

/// The mean and its squared standard error.
fn estimate(values: impl Iterator<Item = f64> + Clone) -> (f64, f64) {
    let n = values.clone().count() as f64;
    let mean = values.clone().sum::<f64>() / n;
    (mean, values.map(|x| (x - mean).powi(2)).sum::<f64>() / (n * (n - 1.0)))
}

/// The largest difference of `a` times `planted` from `b`, in standard errors over the limit of `tests` such tests.
fn excess(a: &[Means], b: &[Means], planted: f64, tests: usize) -> f64 {
    let level = sidak_level(LEVEL, (TESTS * tests) as u64);
    // Fewer degrees of freedom than Welch's number.
    let limit =
        StudentsT::new(0.0, 1.0, (a.len().min(b.len()) - 1) as f64).expect("a law").inverse_cdf(1.0 - level / 2.0);
    let z = |k: usize| {
        let [(a, va), (b, vb)] = [a, b].map(|side| estimate(side.iter().map(|means| means[k])));
        ((a * planted - b).abs() - ROUNDING * b) / (planted * planted * va + vb).sqrt().max(f64::MIN_POSITIVE) / limit
    };
    (0..TESTS).map(z).fold(0.0, f64::max)
}

/// The unbiased methods, with few virtual lights and narrow cuts, so that limits and compensation matter.
fn unbiased() -> [MethodConfig; 3] {
    let lightcuts =
        |count, cut_size| MethodConfig::Lightcuts(LightcutsConfig { virtual_lights: subpaths(count), cut_size });
    [MethodConfig::Vpl(subpaths(16)), lightcuts(64, 1), lightcuts(64, 16)]
}

fn subpaths(count: u32) -> VirtualLightsConfig {
    VirtualLightsConfig { virtual_lights: Some(count), clamp_vpl: None }
}

/// Planted: 10 % more light.
#[test]
fn random_scenes_in_equilibrium_are_one_brightness() {
    let (rounds, seeds) = if deep() { (8, 64) } else { (1, 24) };
    for round in 0..rounds {
        for kind in KINDS.into_iter().filter(|kind| deep() || *kind as u8 % 2 == 0) {
            let (description, expected) = equilibrium(kind, round * 10 + kind as u64);
            let (scene, expected) = (scene(description), vec![[expected; TESTS]; 2]);
            for config in unbiased() {
                let found = pictures(&scene, config, 16, 4, seeds);
                let tests = (rounds as usize) * KINDS.len() * unbiased().len();
                let [right, wrong] = [1.0, 1.1].map(|planted| against(&found, &expected, planted, tests));
                println!("{kind:?} {round}, {config:?}: {right:.2}, planted {wrong:.2}");
                assert!(right < 1.0, "{kind:?} {round}, {config:?}: {right} limits off");
                assert!(wrong > 1.0, "{kind:?} {round}, {config:?}: 10 % more light is not convicted");
            }
        }
    }
}

/// One small room for each unbiased method: few samples, for large errors.
#[test]
fn a_room_in_equilibrium_is_one_brightness() {
    let (description, expected) = equilibrium(KINDS[0], 1);
    let (scene, expected) = (scene(description), vec![[expected; TESTS]; 2]);
    for config in unbiased() {
        let found = pictures(&scene, config, 8, 4, 12);
        let [right, wrong] = [1.0, 1.5].map(|planted| against(&found, &expected, planted, unbiased().len()));
        println!("{config:?}: {right:.2}, planted {wrong:.2}");
        assert!(right < 1.0, "{config:?}: {right} limits off");
        assert!(wrong > 1.0, "{config:?}: half more light is not convicted");
    }
}

/// [`excess`] over a number that is known.
fn against(found: &[Means], expected: &[Means], planted: f64, tests: usize) -> f64 {
    let known = vec![expected[0]; found.len()];
    excess(found, &known, planted, tests)
}

/// Glossy plates, mirrors, glass, small lamps, indirect light, thousands of lights, and fog. Planted: 10 % more light, 40 % under thousands
/// of lights, 20 % in fog.
#[test]
fn virtual_lights_agree_with_path_tracing() {
    let seeds = if deep() { 64 } else { 24 };
    let scenes = [
        ("cornell-box", 1.1),
        ("veach-mis", 1.1),
        ("many-lights", 1.4),
        ("modified-cornell", 1.1),
        ("textured-box", 1.1),
    ];
    let foggy = worlds::all().into_iter().find(|world| world.name == "foggy").expect("a world").scene;
    let loaded = scenes[..if deep() { 5 } else { 3 }].iter();
    let loaded = loaded.filter_map(|&(name, planted)| Some((name, load(name)?, planted)));
    for (name, scene, planted) in loaded.chain([("foggy", foggy, 1.2)]) {
        let path = pictures(&scene, Method::Path.into(), 24, 64, seeds);
        for config in unbiased() {
            let found = pictures(&scene, config, 24, 8, seeds);
            let tests = (scenes.len() + 1) * unbiased().len();
            let [right, wrong] = [1.0, planted].map(|planted| excess(&found, &path, planted, tests));
            println!("{name}, {config:?}: {right:.2}, planted {planted} {wrong:.2}");
            assert!(right < 1.0, "{name}, {config:?}: {right} limits off");
            assert!(wrong > 1.0, "{name}, {config:?}: {planted} times the light is not convicted");
        }
    }
}

fn deterministic(cut_error: f64) -> MethodConfig {
    MethodConfig::DeterministicLightcuts(DeterministicLightcutsConfig { virtual_lights: subpaths(64), cut_error })
}

/// The bound holds in every pixel: against the sum over all virtual lights, with the same random numbers.
#[test]
fn cuts_of_bounded_error_keep_the_bound_in_every_pixel() {
    let times = if deep() { 4 } else { 1 };
    for (name, side) in [("cornell-box", 24), ("modified-cornell", 24), ("veach-mis", 24), ("many-lights", 10)] {
        bound_is_kept(name, times * side);
    }
}

/// The same in one small picture.
#[test]
fn a_cut_of_bounded_error_keeps_the_bound() {
    bound_is_kept("veach-mis", 8);
}

fn bound_is_kept(name: &str, side: u32) {
    if let Some(scene) = load(name) {
        let (all, whole) = render(&scene, deterministic(0.0), side, 1, 3);
        for error in [0.02, 0.5] {
            let (cut, report) = render(&scene, deterministic(error), side, 1, 3);
            let mean = |lanes: &[f32]| lanes.iter().map(|&x| f64::from(x)).sum::<f64>() / 3.0;
            // Rounding of sums of thousands of numbers, in f32.
            let above =
                |(cut, all): (&[f32], &[f32])| (mean(cut) - mean(all)).abs() - 1e-4 * mean(all) - error * mean(cut);
            let worst = cut.chunks_exact(3).zip(all.chunks_exact(3)).map(above).fold(f64::NEG_INFINITY, f64::max);
            let rays = report.rays.shadow as f64 / whole.rays.shadow as f64;
            println!("{name}, error {error}: {worst:.2e} above the bound, {rays:.3} of the shadow rays of all lights");
            assert!(worst <= 0.0, "{name}, error {error}: a pixel is {worst} above the bound");
            assert!(rays < 1.0, "{name}, error {error}: every light is in the cut");
        }
    }
}

/// What `--clamp-vpl` says that it took away is what the image lacks.
#[test]
fn the_light_that_a_limit_takes_away_is_reported() {
    let scene = load("cornell-box").expect("committed");
    let clamped = MethodConfig::Vpl(VirtualLightsConfig { clamp_vpl: Some(0.01), ..subpaths(16) });
    let (side, spp, seeds) = (16, 8, 96);
    let rendered = |seed| {
        let (pixels, report) = render(&scene, clamped, side, spp, seed);
        let removed = report.guards.clamped_energy / (3 * u64::from(side * side) * spp) as f64;
        let whole = means(&pixels, side as usize)[TESTS - 1];
        (whole, whole + removed)
    };
    let found: Vec<(f64, f64)> = (1..=seeds).into_par_iter().map(rendered).collect();
    let of = |values: Vec<f64>| values.into_iter().map(|x| [x; TESTS]).collect::<Vec<Means>>();
    let path = pictures(&scene, Method::Path.into(), side, 64, 24);
    let path = of(path.iter().map(|means| means[TESTS - 1]).collect());
    let (clamped, restored) = found.into_iter().unzip();
    let [clamped, restored] = [clamped, restored].map(|values| excess(&of(values), &path, 1.0, 2));
    println!("clamped {clamped:.2}, with what was taken {restored:.2}");
    assert!(clamped > 1.0 && restored < 1.0, "clamped {clamped}, restored {restored} limits off");
}
