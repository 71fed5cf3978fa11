//! What is fixed before the first pass: a pure function of scene, camera and settings, the same in every shard and for every seed.
//!
//! What the pilot decides (units, roulette on connections) moves the error of a picture and never its expectation. All seeds of a
//! picture decide alike, so that their errors are one and the same: the pilot has its own seed. What it found is in no estimate.

use super::{Integrator, Options};
use crate::camera::Camera;
use crate::defects::{Defect, planted};
use crate::film::{Layout, PassFilm, Units};
use crate::parallel::Cancel;
use crate::scene::Scene;

/// Side of the pilot image at most, in pixels.
const PILOT_SIDE: u32 = 32;

/// The seed of all pilots.
const PILOT_SEED: u64 = 0x9109_a7e5_0f00_d1ce;

/// Film units per pilot mean, as a power of two: 24 bits below the mean leave 39 above it.
const BITS_BELOW_MEAN: i32 = 24;

/// What all passes share. By default nothing is known of the image but that its radiances may be about 1.
#[derive(Debug, Clone, Copy)]
pub struct Prelude {
    /// Quantisation of the film.
    pub units: Units,
    /// The radiance of a usual pixel, as far as the pilot knows: its mean, down to a power of two; 0 if it does not.
    pub typical: f32,
}

impl Default for Prelude {
    fn default() -> Self {
        Prelude { units: Units::for_typical(1.0, 1.0), typical: 0.0 }
    }
}

impl Prelude {
    /// The prelude whose units these are.
    pub fn with(units: Units) -> Self {
        Prelude { units, typical: (units.radiance * f64::from(BITS_BELOW_MEAN).exp2()) as f32 }
    }

    /// The prelude for an image of `layout` that `integrator` renders, given a camera for the pilot's size.
    pub(super) fn new<'a>(
        scene: &Scene,
        layout: &Layout,
        options: &Options,
        camera: &Camera,
        integrator: impl FnOnce(Camera, &Options) -> Box<dyn Integrator + 'a>,
    ) -> Self {
        let size = [layout.width.min(PILOT_SIDE), layout.height.min(PILOT_SIDE)];
        let pilot = Layout::new(size[0], size[1], None, &[]);
        let camera = camera.resized([layout.width, layout.height], size);
        let mut film = PassFilm::new(&pilot);
        // Nobody cancels the pilot, so it always reports.
        let seed = if planted(Defect::PilotFollowsSeed) { !options.seed } else { PILOT_SEED };
        let options = Options { seed, ..*options };
        integrator(camera, &options).run_pass(0, &Cancel::new(), &mut film);
        let mean = mean(&mut film);
        let exponent = if mean > 0.0 { mean.log2().floor() as i32 } else { 0 };
        let extent = f64::from(scene.radius()) / scene.rebase().scale;
        let length = if extent > 0.0 { extent.log2().floor() as i32 } else { 0 };
        let unit = |exponent: i32| f64::from(exponent - BITS_BELOW_MEAN).exp2();
        Prelude::with(Units { radiance: unit(exponent), length: unit(length) })
    }
}

/// Mean over all pixels and lanes, summed in pixel order.
fn mean(film: &mut PassFilm) -> f64 {
    let values = film.values();
    values.iter().map(|&v| f64::from(v)).sum::<f64>() / values.len().max(1) as f64
}
