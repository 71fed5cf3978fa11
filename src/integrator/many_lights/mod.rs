//! Methods that light all pixels of a pass by the same virtual lights.
//!
//! A pass traces light subpaths; their vertices are virtual lights. A camera walk gathers at each vertex the direct
//! light, by samples of the scene's lights, and the indirect light from the virtual lights:
//!
//! - `vpl` (instant radiosity [Keller97]) from all of them. A reference for the others.
//! - `lightcuts` (stochastic lightcuts [Yuksel19]) from one of each group of a cut through the light tree over them,
//!   and likewise from one light of each group of a cut through the scene's lights. For indirect light in diffuse rooms.
//! - `deterministic-lightcuts` [Walter05] from one of each group of a cut whose error is bounded, where points on the
//!   scene's lights are virtual lights, too. Biased within the bound. For the record and for previews.
//!
//! A virtual light close to the receiver would be a bright spot. Its contribution is limited, and the walk goes on with
//! the probability of the light that the limit takes away, so that the image is unbiased [KolligKeller06 §3]: see
//! [`Limit`]. `--clamp-vpl` leaves the compensation out, which is bias. Virtual lights are common to all pixels, so that
//! only replicates measure their noise.
//!
//! Limits: what is seen in mirrors is lit, but caustics from lights without extent are missing, as in `path`.

mod bounded;
mod gather;
mod limit;
mod virtual_lights;
mod walk;

use super::camera_pass::CameraPass;
use super::samples::{PassNumbers, Samples, Work};
use super::{
    DeterministicLightcutsConfig, Integrator, IntegratorConfig, LightcutsConfig, PassReport, PilotEstimate,
    VirtualLightsConfig,
};
use crate::camera::Camera;
use crate::film::PassFilm;
use crate::light::LightCuts;
use crate::parallel::Cancel;
use crate::scene::Scene;
use bounded::BoundedGroups;
pub use gather::MOST_GROUPS;
use gather::{Gather, Indirect};
use limit::Limit;
use virtual_lights::VirtualLights;
use walk::GatherWalk;

/// Pixels per light subpath of a pass of `lightcuts`, by default.
const PIXELS_PER_SUBPATH: usize = 16;

/// Light subpaths per pass of the other methods, by default.
const FEW_SUBPATHS: usize = 64;

/// An integrator with virtual lights.
struct ManyLights<'a> {
    scene: &'a Scene,
    camera: Camera,
    options: IntegratorConfig,
    samples: Samples,
    lights: LightCuts,
    /// Light subpaths of a pass.
    subpaths: usize,
    selection: Selection,
    limit: Limit,
}

/// From which virtual lights a vertex gathers.
#[derive(Clone, Copy)]
enum Selection {
    All,
    /// One of each group of a cut of this size.
    Cut(usize),
    /// One of each group of a cut whose error is below this share.
    Bounded(f64),
}

/// Builds the integrator of `vpl`.
pub(super) fn vpl<'a>(
    scene: &'a Scene,
    camera: Camera,
    options: &IntegratorConfig,
    config: VirtualLightsConfig,
    pilot: &PilotEstimate,
) -> Box<dyn Integrator + 'a> {
    Box::new(ManyLights::new(scene, camera, options, (Selection::All, config), pilot))
}

/// Builds the integrator of `lightcuts`.
pub(super) fn lightcuts<'a>(
    scene: &'a Scene,
    camera: Camera,
    options: &IntegratorConfig,
    config: LightcutsConfig,
    pilot: &PilotEstimate,
) -> Box<dyn Integrator + 'a> {
    let selection = Selection::Cut(config.cut_size as usize);
    Box::new(ManyLights::new(scene, camera, options, (selection, config.virtual_lights), pilot))
}

/// Builds the integrator of `deterministic-lightcuts`.
pub(super) fn deterministic_lightcuts<'a>(
    scene: &'a Scene,
    camera: Camera,
    options: &IntegratorConfig,
    config: DeterministicLightcutsConfig,
    pilot: &PilotEstimate,
) -> Box<dyn Integrator + 'a> {
    let selection = Selection::Bounded(config.cut_error);
    Box::new(ManyLights::new(scene, camera, options, (selection, config.virtual_lights), pilot))
}

impl<'a> ManyLights<'a> {
    fn new(
        scene: &'a Scene,
        camera: Camera,
        options: &IntegratorConfig,
        (selection, config): (Selection, VirtualLightsConfig),
        pilot: &PilotEstimate,
    ) -> Self {
        let lights = match selection {
            Selection::All | Selection::Cut(_) => LightCuts::new(scene.lights()),
            Selection::Bounded(_) => LightCuts::of_distant(scene.lights()),
        };
        let usual = match selection {
            Selection::All | Selection::Bounded(_) => FEW_SUBPATHS,
            Selection::Cut(_) => options.pixels().div_ceil(PIXELS_PER_SUBPATH),
        };
        let subpaths = config.virtual_lights.map_or(usual, |subpaths| subpaths as usize);
        let gathered = if let Selection::Cut(size) = selection { size.min(subpaths) } else { subpaths };
        let limit = Limit::new(scene, pilot, gathered, config.clamp_vpl);
        let (options, samples) = (*options, Samples::new(camera.clone(), options));
        ManyLights { scene, camera, options, samples, lights, subpaths, selection, limit }
    }
}

impl Integrator for ManyLights<'_> {
    fn run_pass(&self, pass: u64, cancel: &Cancel, out: &mut PassFilm) -> Option<PassReport> {
        let &ManyLights { scene, ref camera, ref options, limit, .. } = self;
        let lights = self.samples.of_pass(pass, Tracing { all: self, cancel })?;
        let indirect = match self.selection {
            Selection::All => Indirect::All,
            Selection::Cut(size) => Indirect::Cut(size, lights.tree()),
            Selection::Bounded(error) => Indirect::Bounded(BoundedGroups::new(&lights.all, lights.tree(), error)),
        };
        let gather = Gather { scene, lights: &self.lights, virtual_lights: &lights.all, indirect, limit };
        let walk = GatherWalk::new(gather, options);
        let mut report = CameraPass::new(walk, scene, camera.clone(), options).run_pass(pass, cancel, out)?;
        report.add_tally(&lights.tally);
        Some(report)
    }
}

/// The light subpaths of a pass.
struct Tracing<'p, 'a> {
    all: &'p ManyLights<'a>,
    cancel: &'p Cancel,
}

impl<'a> Work for Tracing<'_, 'a> {
    type Output = Option<VirtualLights<'a>>;

    fn run(self, numbers: impl PassNumbers) -> Self::Output {
        let &ManyLights { scene, ref camera, ref options, subpaths, selection, .. } = self.all;
        let longest = options.max_depth.unwrap_or(u32::MAX);
        let mut lights = VirtualLights::trace(scene, camera, (subpaths, longest), numbers, self.cancel)?;
        if matches!(selection, Selection::Bounded(_)) {
            lights.add_emitters(scene, numbers);
        }
        Some(lights)
    }
}
