//! Integrators: what one pass of a method does. An integrator has no hidden state: a pass is a pure function of
//! (scene, settings, seed, pass). To add one, write its file, implement [`Integrator`] and give it a name in [`Method`].

mod bidirectional;
mod camera_pass;
mod features;
mod ids;
mod method;
mod metropolis;
mod path;
mod prelude;
mod prior;
mod samples;
mod technique_images;

pub use ids::ids;
pub use method::Method;
pub use metropolis::{ChainDigest, ChainReport, MetropolisOptions, Mutations, Normalisation, Tiles};
pub use prelude::Prelude;
pub use prior::prior;
pub use technique_images::{TechniqueImage, TechniqueImages, technique_images};

use crate::camera::Camera;
use crate::film::{Crop, Filter, Layout, PassFilm};
use crate::parallel::Cancel;
use crate::path::Techniques;
use crate::sampling::{Heuristic, SamplerKind};
use crate::scene::Scene;
use bidirectional::Bidirectional;
use camera_pass::CameraPass;
use path::{Combined, Naive, NextEvent, PathTracer};

/// What every method is told. All of it changes pixels, so all of it belongs to the settings hash.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Options {
    /// Seed of all random numbers.
    pub seed: u64,
    /// Where they come from.
    pub sampler: SamplerKind,
    /// Pixel filter, importance sampled.
    pub filter: Filter,
    /// Most scattering events of a path; `None` for no limit.
    pub max_depth: Option<u32>,
    /// Limit of each lane of a sample, which biases; `None` for none.
    pub clamp: Option<f32>,
    /// Number of independent replicates; pass k belongs to replicate k mod this.
    pub replicates: u32,
    /// Whether the environment is hidden where the camera sees it directly.
    pub transparent: bool,
    /// Which techniques bidirectional path tracing has.
    pub techniques: Techniques,
    /// How they share a path.
    pub heuristic: Heuristic,
    /// What is rendered of the image.
    pub crop: Crop,
    /// What chains of Metropolis methods are like.
    pub metropolis: MetropolisOptions,
}

impl Options {
    /// What is usual for an image of `layout`: 4 replicates, seed 0, no limits.
    pub fn new(layout: &Layout) -> Self {
        Options {
            seed: 0,
            sampler: SamplerKind::default(),
            filter: Filter::default(),
            max_depth: None,
            clamp: None,
            replicates: 4,
            transparent: false,
            techniques: Techniques::ALL,
            heuristic: Heuristic::default(),
            crop: layout.crop,
            metropolis: MetropolisOptions::default(),
        }
    }

    /// Pixels that a pass renders: as many walks start from lights.
    pub fn pixels(&self) -> usize {
        self.crop.pixels()
    }
}

/// The integrator of `method` for an image that `camera` takes of `scene`, whose passes share `prelude`.
pub fn build<'a>(
    method: Method,
    scene: &'a Scene,
    camera: Camera,
    options: &Options,
    prelude: &Prelude,
) -> Box<dyn Integrator + 'a> {
    let (depth, transparent) = (options.max_depth, options.transparent);
    match method {
        Method::PathNaive => {
            let tracer = PathTracer::<Naive>::new(scene, depth, transparent);
            Box::new(CameraPass::new(tracer, scene, camera, options))
        }
        Method::PathNee => {
            let tracer = PathTracer::<NextEvent>::new(scene, depth, transparent);
            Box::new(CameraPass::new(tracer, scene, camera, options))
        }
        Method::Path => {
            let tracer = PathTracer::<Combined>::new(scene, depth, transparent);
            Box::new(CameraPass::new(tracer, scene, camera, options))
        }
        Method::Light => {
            let tracer = Bidirectional::new(scene, &camera, &Options { techniques: Techniques::LIGHT, ..*options }, prelude);
            Box::new(CameraPass::new(tracer, scene, camera, options))
        }
        Method::Bdpt => {
            let tracer = Bidirectional::new(scene, &camera, options, prelude);
            Box::new(CameraPass::new(tracer, scene, camera, options))
        }
        Method::Pssmlt => metropolis::pssmlt(scene, camera, options, prelude),
        Method::Mmlt => metropolis::mmlt(scene, camera, options, prelude),
        Method::Mlt => metropolis::mlt(scene, camera, options, prelude),
    }
}

/// What is fixed before the first pass over an image of `layout`.
pub fn prelude(scene: &Scene, camera: &Camera, options: &Options, layout: &Layout) -> Prelude {
    // The naive tracer is blind to some lights; a pilot that sees all fixes the same unit for every method.
    Prelude::new(scene, layout, options, camera, |camera, options| {
        build(Method::Path, scene, camera, options, &Prelude::default())
    })
}

/// What `method` cannot see in `scene`, one sentence each.
pub fn blind_spots(method: Method, scene: &Scene) -> Vec<String> {
    let features = scene.features();
    let mut spots = Vec::new();
    if method == Method::PathNaive && features.dirac_lights {
        spots.push("path-naive does not see point, spot and directional lights: they are missing from the image".into());
    }
    if method == Method::PathNaive && features.dirac {
        spots.push("path-naive does not see mirrors and clear glass: they are black".into());
    }
    if matches!(method, Method::Path | Method::PathNee) && features.dirac && features.dirac_lights {
        spots.push(format!(
            "{} does not see what mirrors and clear glass throw of point, spot and directional lights: bdpt does",
            if method == Method::Path { "path" } else { "path-nee" }
        ));
    }
    if method == Method::Light && features.dirac {
        spots.push("light does not see what mirrors and clear glass show the camera: they are black".into());
    }
    spots.extend(refusal(method, scene).map(String::from));
    spots
}

/// Why `method` does not render `scene` at all, in a sentence.
pub fn refusal(method: Method, scene: &Scene) -> Option<&'static str> {
    let blends = method == Method::Mlt && scene.features().blends;
    blends.then_some("mlt does not know surfaces that blend by alpha: render the scene with mmlt, which does")
}

/// How many rays of each kind were traced.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, serde::Serialize, serde::Deserialize)]
pub struct RayCounts {
    /// From the camera, those for extra layers included.
    pub camera: u64,
    /// From a scattering event.
    pub bounce: u64,
    /// Visibility tests.
    pub shadow: u64,
}

impl RayCounts {
    /// Rays of all kinds.
    pub fn total(&self) -> u64 {
        self.camera + self.bounce + self.shadow
    }
}

/// How often each guard dropped or changed something. All zero in a healthy render.
#[derive(Debug, Clone, Copy, Default, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct Guards {
    /// Samples that were not finite and count as black.
    pub nonfinite: u64,
    /// Hits that could not be recomputed from their triangle (slivers) and were passed through.
    pub bad_hits: u64,
    /// Paths cut at the emergency length limit.
    pub overlong_paths: u64,
    /// Samples that `--clamp` reduced: the image is biased.
    pub clamped: u64,
    /// Sum over lanes of what was clamped away, in radiance × samples.
    pub clamped_energy: f64,
}

/// A sample that was not finite, so that it can be replayed.
#[derive(Debug, Clone, Copy, PartialEq, Eq, serde::Serialize, serde::Deserialize)]
pub struct InvalidSample {
    /// The pass it belongs to.
    pub pass: u64,
    /// Column of its pixel.
    pub x: u32,
    /// Row of its pixel.
    pub y: u32,
}

/// What a pass did besides its samples.
#[derive(Debug, Clone, Default, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct PassReport {
    /// Rays traced.
    pub rays: RayCounts,
    /// Guards that fired.
    pub guards: Guards,
    /// The first samples that were not finite, at most [`PassReport::MAX_INVALID`].
    pub invalid: Vec<InvalidSample>,
    /// What chains say of themselves, where there are any.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub chains: Option<ChainReport>,
}

impl PassReport {
    /// How many invalid samples are kept by address.
    pub const MAX_INVALID: usize = 16;

    /// Adds what another part or pass did. Sums are order-free but for the rounding of `clamped_energy`.
    pub fn absorb(&mut self, other: PassReport) {
        let (r, o) = (&mut self.rays, other.rays);
        r.camera += o.camera;
        r.bounce += o.bounce;
        r.shadow += o.shadow;
        let (g, o) = (&mut self.guards, other.guards);
        g.nonfinite += o.nonfinite;
        g.bad_hits += o.bad_hits;
        g.overlong_paths += o.overlong_paths;
        g.clamped += o.clamped;
        g.clamped_energy += o.clamped_energy;
        self.invalid.extend(other.invalid);
        self.invalid.truncate(Self::MAX_INVALID);
        if let Some(chains) = other.chains {
            self.chains.get_or_insert_default().absorb(chains);
        }
    }
}

/// A method that renders passes.
pub trait Integrator: Send + Sync {
    /// Renders pass `pass` (one sample of every pixel of the film) into `out`; `None` if it was cancelled, in which case
    /// `out` must not be used.
    fn run_pass(&self, pass: u64, cancel: &Cancel, out: &mut PassFilm) -> Option<PassReport>;
}
