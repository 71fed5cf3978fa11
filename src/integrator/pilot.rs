//! The pilot estimate, computed before the first pass. It is a pure function of scene, camera and settings, identical
//! in all shards and for all seeds.
//!
//! Pilot decisions (units, connection roulette) affect the error of an image but never its expectation. The pilot has
//! its own seed: all seeds of an image share the same decisions, so that their errors follow the same distribution.
//! Pilot samples enter no estimate.

use super::{Integrator, IntegratorConfig};
use crate::camera::Camera;
use crate::film::{Layout, PassFilm, Units};
use crate::numeric;
use crate::parallel::Cancel;
use crate::scene::Scene;

/// Maximum side of the pilot image, in pixels.
const PILOT_SIDE: u32 = 32;

/// Seed of all pilots.
const PILOT_SEED: u64 = 0x9109_a7e5_0f00_d1ce;

/// Film units per pilot mean, as a power of two: 24 bits below the mean leave 39 above it.
const BITS_BELOW_MEAN: i32 = 24;

/// Parameters shared by all passes. The default assumes radiances of about 1.
#[derive(Debug, Clone, Copy)]
pub struct PilotEstimate {
    /// Quantisation of the film.
    pub units: Units,
    /// Typical pixel radiance: the pilot mean, rounded down to a power of two; 0 if unknown.
    pub typical: f32,
}

impl Default for PilotEstimate {
    fn default() -> Self {
        PilotEstimate { units: Units::for_typical(1.0, 1.0), typical: 0.0 }
    }
}

impl PilotEstimate {
    /// Creates the estimate with the given units.
    pub fn with(units: Units) -> Self {
        PilotEstimate { units, typical: (units.radiance * f64::from(BITS_BELOW_MEAN).exp2()) as f32 }
    }

    /// Estimates for an image of `layout`. `integrator` is built for a camera of the pilot's size.
    pub(super) fn new<'a>(
        scene: &Scene,
        layout: &Layout,
        options: &IntegratorConfig,
        camera: &Camera,
        integrator: impl FnOnce(Camera, &IntegratorConfig) -> Box<dyn Integrator + 'a>,
    ) -> Self {
        let size = [layout.width.min(PILOT_SIDE), layout.height.min(PILOT_SIDE)];
        let pilot = Layout::new(size[0], size[1], None, &[]);
        let camera = camera.resized([layout.width, layout.height], size);
        let mut film = PassFilm::new(&pilot);
        // The pilot is never cancelled, so that it always reports.
        let options = IntegratorConfig { seed: PILOT_SEED, ..*options };
        integrator(camera, &options).run_pass(0, &Cancel::new(), &mut film);
        let mean = numeric::mean(film.values());
        let exponent = if mean > 0.0 { mean.log2().floor() as i32 } else { 0 };
        let extent = f64::from(scene.radius()) / scene.rebase().scale;
        let length = if extent > 0.0 { extent.log2().floor() as i32 } else { 0 };
        let unit = |exponent: i32| f64::from(exponent - BITS_BELOW_MEAN).exp2();
        PilotEstimate::with(Units { radiance: unit(exponent), length: unit(length) })
    }
}
