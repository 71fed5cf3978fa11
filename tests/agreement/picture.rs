//! Rendered pictures with their errors, and tests of them.

use etendue::accel::Backend;
use etendue::film::{Filter, Layout, Plane};
use etendue::integrator::{FilmRenderer, Guards, IntegratorConfig, MethodConfig};
use etendue::light::LightChoice;
use etendue::sampling::SamplerKind;
use etendue::scene::description::Description;
use etendue::scene::{BuildOptions, Scene};
use etendue_testing::levels::sidak_level;
use statrs::distribution::{ContinuousCDF, Normal};

/// Family-wise level of every test in this binary: with fixed seeds it is the chance that a right renderer is convicted
/// by the seeds that happen to be written here.
pub(crate) const LEVEL: f64 = 1e-4;

/// Replicates: enough for a standard error of blocks whose pixels are pooled.
const REPLICATES: u32 = 4;

/// Family-wise level of the blocks of pictures that must be equal but for rounding (the figure).
pub(crate) const BLOCK_LEVEL: f64 = 1e-3;

/// A square picture: mean and squared standard error of each lane of each pixel.
#[derive(Clone)]
pub(crate) struct Picture {
    pub(crate) side: usize,
    pub(crate) mean: Vec<f64>,
    pub(crate) variance: Vec<f64>,
}

/// What of [`IntegratorConfig`] the tests vary.
#[derive(Clone, Copy)]
pub(crate) struct Shot {
    pub(crate) method: MethodConfig,
    pub(crate) side: u32,
    pub(crate) spp: u64,
    pub(crate) seed: u64,
    pub(crate) depth: Option<u32>,
    pub(crate) sampler: SamplerKind,
    pub(crate) filter: Filter,
}

impl Shot {
    pub(crate) fn new(method: impl Into<MethodConfig>, side: u32, spp: u64) -> Self {
        Shot {
            method: method.into(),
            side,
            spp,
            seed: 1,
            depth: None,
            sampler: SamplerKind::Sobol,
            filter: Filter::Box,
        }
    }
}

/// Builds a scene for tests.
pub(crate) fn scene(description: Description) -> Scene {
    scene_under(Backend::default(), description)
}

/// Builds a scene whose rays `backend` answers.
pub(crate) fn scene_under(backend: Backend, description: Description) -> Scene {
    Scene::build(description, &BuildOptions { backend, threads: 1, ..BuildOptions::default() }).expect("a valid scene")
}

/// Builds a scene whose lights are selected by `choice`.
pub(crate) fn scene_choosing(light_choice: LightChoice, description: Description) -> Scene {
    let options = BuildOptions { light_choice, threads: 1, ..BuildOptions::default() };
    Scene::build(description, &options).expect("a valid scene")
}

/// Renders the first camera's view, unless told otherwise with a box filter; no guard may fire.
pub(crate) fn render(scene: &Scene, shot: Shot) -> Picture {
    let (picture, guards) = render_guarded(scene, shot);
    assert_eq!(guards, Guards::default(), "a guard fired");
    picture
}

/// As [`render`], and how often each guard fired.
pub(crate) fn render_guarded(scene: &Scene, shot: Shot) -> (Picture, Guards) {
    let layout = Layout::new(shot.side, shot.side, None, &[]);
    let options = IntegratorConfig {
        seed: shot.seed,
        sampler: shot.sampler,
        filter: shot.filter,
        max_depth: shot.depth,
        replicates: REPLICATES,
        ..IntegratorConfig::new(shot.method, &layout)
    };
    let camera = scene.camera(None, shot.side, shot.side).expect("a camera");
    let mut renderer = FilmRenderer::begin(scene, camera, &options, &layout);
    let total = renderer.passes(shot.spp);
    let film = renderer.film();
    let mean = film.mean(Plane::Color).into_iter().map(f64::from).collect();
    let error = film.standard_error().expect("replicates");
    let variance = error.into_iter().map(|e| f64::from(e).powi(2)).collect();
    (Picture { side: shot.side as usize, mean, variance }, total.guards)
}

/// Mean over some pixels and the variance of that mean.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Block {
    pub(crate) mean: f64,
    pub(crate) variance: f64,
}

impl Block {
    /// Standard errors between this and `other`.
    pub(crate) fn z(self, other: Block) -> f64 {
        (self.mean - other.mean) / (self.variance + other.variance).sqrt().max(f64::MIN_POSITIVE)
    }
}

impl Picture {
    /// Means of `n` × `n` square blocks, each lane on its own.
    pub(crate) fn blocks(&self, n: usize) -> Vec<Block> {
        let size = self.side / n;
        let count = (size * size) as f64;
        let mut blocks = vec![Block { mean: 0.0, variance: 0.0 }; n * n * 3];
        for (i, (&mean, &variance)) in self.mean.iter().zip(&self.variance).enumerate() {
            let (pixel, lane) = (i / 3, i % 3);
            let (x, y) = (pixel % self.side / size, pixel / self.side / size);
            let block = &mut blocks[(y * n + x) * 3 + lane];
            block.mean += mean / count;
            block.variance += variance / (count * count);
        }
        blocks
    }

    /// The image mean over all pixels and lanes. Lanes of a pixel share its samples: the variance is that of fully
    /// correlated lanes, which no correlation exceeds.
    pub(crate) fn overall(&self) -> Block {
        let lanes = self.blocks(1);
        let mean = |of: fn(&Block) -> f64| lanes.iter().map(of).sum::<f64>() / lanes.len() as f64;
        Block { mean: mean(|lane| lane.mean), variance: mean(|lane| lane.variance.sqrt()).powi(2) }
    }

    /// Multiplied by `k`: a planted error.
    pub(crate) fn times(mut self, k: f64) -> Self {
        self.mean.iter_mut().for_each(|m| *m *= k);
        self
    }
}

/// The two-sided z limit for `tests` tests at the family-wise [`LEVEL`] (Šidák).
pub(crate) fn limit(tests: usize) -> f64 {
    limit_at(LEVEL, tests)
}

/// The two-sided z limit for `tests` tests at the family-wise level `level` (Šidák).
pub(crate) fn limit_at(level: f64, tests: usize) -> f64 {
    let each = sidak_level(level, tests as u64);
    Normal::new(0.0, 1.0).expect("standard").inverse_cdf(1.0 - each / 2.0)
}

/// z scores of equal means over blocks and the image, each lane on its own, and whether all are within [`limit`]. Lanes
/// of a pixel share its samples, so that their mean has a greater variance than independent lanes would give it.
///
/// Blocks pool at least 64 pixels of at least 3 degrees of freedom each, so z stands for t with at least 192.
pub(crate) fn agree(a: &Picture, b: &Picture, n: usize) -> Result<(), String> {
    let mut pairs: Vec<_> = a.blocks(n).into_iter().zip(b.blocks(n)).collect();
    let whole: Vec<_> = a.blocks(1).into_iter().zip(b.blocks(1)).collect();
    pairs.extend(&whole);
    let limit = limit(pairs.len());
    let largest = |pairs: &[(Block, Block)]| pairs.iter().map(|(a, b)| a.z(*b).abs()).fold(0.0, f64::max);
    let (worst, overall) = (largest(&pairs), largest(&whole));
    if worst <= limit { Ok(()) } else { Err(format!("largest |z| {worst:.2} > {limit:.2}; image means: {overall:.2}")) }
}

/// Whether the image mean lies between `range`, which a bound says it must, at [`LEVEL`].
pub(crate) fn verdict(picture: &Picture, range: [f64; 2]) -> Result<(), String> {
    let Block { mean, variance } = picture.overall();
    let slack = limit(1) * variance.sqrt();
    let right = (range[0] - slack..=range[1] + slack).contains(&mean);
    if right { Ok(()) } else { Err(format!("{mean} is not in {range:?} ± {slack:e}")) }
}

/// [`verdict`] must be in favour, and against the picture made brighter or darker by the share `planted`.
pub(crate) fn expect(picture: &Picture, range: [f64; 2], planted: f64, what: &str) {
    println!(
        "{what}: {} in {range:?}, standard error {:.1e}",
        picture.overall().mean,
        picture.overall().variance.sqrt()
    );
    verdict(picture, range).unwrap_or_else(|e| panic!("{what}: {e}"));
    for wrong in [1.0 + planted, 1.0 - planted] {
        assert!(
            verdict(&picture.clone().times(wrong), range).is_err(),
            "{what}: {wrong} times as bright is not convicted"
        );
    }
}

/// The range of numbers within the share `by` of `x`.
pub(crate) fn about(x: f64, by: f64) -> [f64; 2] {
    [x * (1.0 - by), x * (1.0 + by)]
}
