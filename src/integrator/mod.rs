//! Integrators. An integrator has no hidden state: a pass is a pure function of (scene, settings, seed, pass). To add
//! one, write its file, implement [`Integrator`] and name it in [`Method`].

mod bidirectional;
mod camera_pass;
mod execution;
mod features;
mod film_renderer;
mod ids;
mod many_lights;
mod method;
mod method_config;
mod metropolis;
mod path;
mod pilot;
mod prior;
mod samples;
mod technique_images;

// Compiled here once more: the scenes of `etendue_testing` are of types of another compilation of this library.
#[cfg(test)]
#[allow(dead_code, unreachable_pub)]
#[path = "../../tests/support/src/scenes/mod.rs"]
mod scenes;

pub use execution::Execution;
pub use film_renderer::FilmRenderer;
pub use ids::ids;
pub use many_lights::MOST_GROUPS;
pub use method::Method;
pub use method_config::{
    BdptConfig, ChainsConfig, DeterministicLightcutsConfig, LightcutsConfig, MethodConfig, MltConfig, MmltConfig,
    PathConfig, PssmltConfig, VirtualLightsConfig,
};
pub use metropolis::{ChainDigest, ChainReport, Mutations, Normalisation, Tiles};
pub use pilot::PilotEstimate;
pub use prior::prior;
pub use technique_images::{TechniqueImage, TechniqueImages, technique_images};

use crate::camera::Camera;
use crate::film::{Crop, Filter, Layout, PassFilm};
use crate::parallel::Cancel;
use crate::sampling::SamplerKind;
use crate::scene::Scene;
use bidirectional::Bidirectional;
use camera_pass::CameraPass;
use etendue_lanes::Native;
use path::{BatchedPath, Combined, Naive, NextEvent, PathTracer};

/// Parameters of an integrator. All of them but the execution change pixels, so that they are part of the settings
/// hash.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct IntegratorConfig {
    /// The method with its own parameters.
    pub method: MethodConfig,
    /// Seed of all random numbers.
    pub seed: u64,
    /// Generator of random numbers.
    pub sampler: SamplerKind,
    /// Pixel filter, importance sampled.
    pub filter: Filter,
    /// Maximum number of scattering events of a path; `None` for no limit.
    pub max_depth: Option<u32>,
    /// Clamp for each lane of a sample, which introduces bias; `None` for none.
    pub clamp: Option<f32>,
    /// Number of independent replicates; pass k belongs to replicate k mod this number.
    pub replicates: u32,
    /// Whether the directly visible environment is hidden.
    pub transparent: bool,
    /// Rendered part of the image.
    pub crop: Crop,
    /// Execution of `path`; `None` for the faster one. It changes no pixel.
    pub execution: Option<Execution>,
}

impl IntegratorConfig {
    /// Returns the defaults of `method` for an image of `layout`: the method's replicates, seed 0, no limits.
    pub fn new(method: impl Into<MethodConfig>, layout: &Layout) -> Self {
        let method = method.into();
        IntegratorConfig {
            method,
            seed: 0,
            sampler: SamplerKind::default(),
            filter: Filter::default(),
            max_depth: None,
            clamp: None,
            replicates: method.kind().replicates(),
            transparent: false,
            crop: layout.crop,
            execution: None,
        }
    }

    /// Number of pixels rendered in a pass, which is also the number of light subpaths.
    pub fn pixels(&self) -> usize {
        self.crop.pixels()
    }
}

/// Builds the integrator of the method that `options` name, for `scene` and `camera`; all passes share `pilot`.
pub fn build<'a>(
    scene: &'a Scene,
    camera: Camera,
    options: &IntegratorConfig,
    pilot: &PilotEstimate,
) -> Box<dyn Integrator + 'a> {
    let (depth, transparent) = (options.max_depth, options.transparent);
    match options.method {
        MethodConfig::PathNaive => {
            let tracer = PathTracer::<Naive>::new(scene, depth, transparent);
            Box::new(CameraPass::new(tracer, scene, camera, options))
        }
        MethodConfig::PathNee(config) => {
            let tracer = PathTracer::<NextEvent>::new(scene, depth, transparent).diffusing(config.subsurface);
            Box::new(CameraPass::new(tracer, scene, camera, options))
        }
        MethodConfig::Path(_) if Execution::chosen(options.execution, scene) == Execution::Batched => {
            Box::new(BatchedPath::<Native>::new(scene, camera, options))
        }
        MethodConfig::Path(config) => {
            let tracer = PathTracer::<Combined>::new(scene, depth, transparent).diffusing(config.subsurface);
            Box::new(CameraPass::new(tracer, scene, camera, options))
        }
        MethodConfig::Light | MethodConfig::Bdpt(_) => {
            let tracer = Bidirectional::new(scene, &camera, options, pilot);
            Box::new(CameraPass::new(tracer, scene, camera, options))
        }
        MethodConfig::Vpl(config) => many_lights::vpl(scene, camera, options, config, pilot),
        MethodConfig::Lightcuts(config) => many_lights::lightcuts(scene, camera, options, config, pilot),
        MethodConfig::DeterministicLightcuts(config) => {
            many_lights::deterministic_lightcuts(scene, camera, options, config, pilot)
        }
        MethodConfig::Pssmlt(config) => metropolis::pssmlt(scene, camera, options, config, pilot),
        MethodConfig::Mmlt(config) => metropolis::mmlt(scene, camera, options, config, pilot),
        MethodConfig::Mlt(config) => metropolis::mlt(scene, camera, options, config, pilot),
    }
}

/// Computes the pilot estimate that all passes over an image of `layout` share.
pub fn pilot(scene: &Scene, camera: &Camera, options: &IntegratorConfig, layout: &Layout) -> PilotEstimate {
    // The naive tracer is blind to some lights. The pilot uses a method without this limit, so that all methods get the
    // same units.
    PilotEstimate::new(scene, layout, options, camera, |camera, options| {
        let options = IntegratorConfig { method: Method::Path.into(), ..*options };
        build(scene, camera, &options, &PilotEstimate::default())
    })
}

/// Describes the light in `scene` that `method` cannot sample, one sentence each: its [`blind_spots`], and light that
/// no method samples.
pub fn missing_light(method: Method, scene: &Scene) -> Vec<String> {
    let mut missing = blind_spots(method, scene);
    let features = scene.features();
    if features.dirac && features.dirac_lights && !matches!(method, Method::PathNaive | Method::Light) {
        missing.push(
            "no method sees light of point, spot and directional lights that mirrors or clear glass throw on surfaces \
             which are seen in mirrors or through clear glass: it is missing there; small lamps in place of these \
             lights can be seen by mlt and bdpt"
                .into(),
        );
    }
    missing
}

/// Describes the light in `scene` that `method` cannot sample and others can, one sentence each.
pub fn blind_spots(method: Method, scene: &Scene) -> Vec<String> {
    let features = scene.features();
    let mut spots = Vec::new();
    if method == Method::PathNaive && features.dirac_lights {
        spots
            .push("path-naive does not see point, spot and directional lights: they are missing from the image".into());
    }
    if method == Method::PathNaive && features.dirac {
        spots.push("path-naive does not see mirrors and clear glass: they are black".into());
    }
    let misses_caustics = match method {
        Method::Path | Method::PathNee | Method::Vpl | Method::Lightcuts | Method::DeterministicLightcuts => true,
        Method::PathNaive | Method::Light | Method::Bdpt | Method::Pssmlt | Method::Mmlt | Method::Mlt => false,
    };
    if misses_caustics && features.dirac && features.dirac_lights {
        let name: &str = method.into();
        spots.push(format!(
            "{name} does not see what mirrors and clear glass throw of point, spot and directional lights: bdpt does"
        ));
    }
    if method == Method::Light && features.dirac {
        spots.push("light does not see what mirrors and clear glass show the camera: they are black".into());
    }
    spots.extend(refusal(method, scene).map(String::from));
    spots
}

/// Returns the number of bodies in `scene` that diffusion models know: see [`MethodConfig::subsurface`].
pub fn diffusing_bodies(scene: &Scene) -> usize {
    path::known_solids(scene).count()
}

/// Returns the reason why `method` cannot render `scene` at all, as a sentence.
pub fn refusal(method: Method, scene: &Scene) -> Option<&'static str> {
    let features = scene.features();
    if method == Method::Mlt && features.blends {
        return Some("mlt does not know surfaces that blend by alpha: render the scene with mmlt, which does");
    }
    let follows_lights = matches!(method, Method::Light | Method::Mlt) || method.has_virtual_lights();
    (features.emission && follows_lights).then_some(
        "light, mlt and methods with virtual lights do not know media that emit: path, bdpt, pssmlt and mmlt do",
    )
}

/// Numbers of rays traced, by kind.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, serde::Serialize, serde::Deserialize)]
pub struct RayCounts {
    /// Camera rays, including those for extra layers.
    pub camera: u64,
    /// Rays from a scattering event.
    pub bounce: u64,
    /// Shadow rays.
    pub shadow: u64,
}

impl RayCounts {
    /// Returns the number of rays of all kinds.
    pub fn total(&self) -> u64 {
        self.camera + self.bounce + self.shadow
    }
}

/// Counts of guard events that dropped or changed a value. All are zero in a healthy render.
#[derive(Debug, Clone, Copy, Default, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct Guards {
    /// Nonfinite samples, which count as black.
    pub nonfinite: u64,
    /// Hits that could not be recomputed from their triangle (slivers) and were passed through.
    pub bad_hits: u64,
    /// Paths cut at the emergency length limit.
    pub overlong_paths: u64,
    /// Samples that `--clamp` or `--clamp-vpl` reduced: the image is biased.
    pub clamped: u64,
    /// Sum over lanes of the clamped excess, in radiance × samples.
    pub clamped_energy: f64,
}

/// Address of a nonfinite sample, for replay.
#[derive(Debug, Clone, Copy, PartialEq, Eq, serde::Serialize, serde::Deserialize)]
pub struct InvalidSample {
    /// Pass of the sample.
    pub pass: u64,
    /// Column of its pixel.
    pub x: u32,
    /// Row of its pixel.
    pub y: u32,
}

/// Statistics of a pass besides its samples.
#[derive(Debug, Clone, Default, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct PassReport {
    /// Rays traced.
    pub rays: RayCounts,
    /// Guards that fired.
    pub guards: Guards,
    /// The first nonfinite samples, at most [`PassReport::MAX_INVALID`].
    pub invalid: Vec<InvalidSample>,
    /// The selection of lights by receiver.
    #[serde(default)]
    pub selection: LightSelection,
    /// Chain statistics of Metropolis methods.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub chains: Option<ChainReport>,
}

/// Statistics of the selection of lights by receiver, for light samples and for MIS weights, of path tracers and of
/// methods with virtual lights.
#[derive(Debug, Clone, Copy, Default, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct LightSelection {
    /// Its CPU time, estimated from a part of the calls.
    pub seconds: f64,
    /// Number of cuts through light trees.
    pub cuts: u64,
    /// Number of groups in all of them.
    pub groups: u64,
}

impl PassReport {
    /// Maximum number of invalid samples stored with their address.
    pub const MAX_INVALID: usize = 16;

    /// Merges the report of another part or pass. Sums do not depend on order except for the rounding of
    /// `clamped_energy` and of seconds.
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
        let (s, o) = (&mut self.selection, other.selection);
        s.seconds += o.seconds;
        s.cuts += o.cuts;
        s.groups += o.groups;
        self.invalid.extend(other.invalid);
        self.invalid.truncate(Self::MAX_INVALID);
        if let Some(chains) = other.chains {
            self.chains.get_or_insert_default().absorb(chains);
        }
    }
}

/// A method that renders passes.
pub trait Integrator: Send + Sync {
    /// Renders pass `pass` (one sample of every pixel of the film) into `out`. Returns `None` if it was cancelled;
    /// `out` must then not be used.
    fn run_pass(&self, pass: u64, cancel: &Cancel, out: &mut PassFilm) -> Option<PassReport>;
}
