//! TEMP stand-in until the integrators are merged: noise that depends on pass and pixel alone.
#![allow(missing_docs)]
use super::{Method, PassReport};
use crate::camera::Camera;
use crate::film::{Filter, Layout, PassFilm, Units};
use crate::parallel::Cancel;
use crate::sampling::SamplerKind;
use crate::scene::Scene;
use rayon::prelude::*;

#[derive(Debug, Clone, Copy)]
pub struct Options {
    pub seed: u64,
    pub sampler: SamplerKind,
    pub filter: Filter,
    pub max_depth: Option<u32>,
    pub clamp: Option<f32>,
    pub replicates: u32,
}
#[derive(Debug)]
pub struct Prelude {
    pub units: Units,
}
pub trait Integrator: Send + Sync {
    fn run_pass(&self, pass: u64, cancel: &Cancel, out: &mut PassFilm) -> Option<PassReport>;
}
struct Noise(u64, usize);
impl Integrator for Noise {
    fn run_pass(&self, pass: u64, cancel: &Cancel, out: &mut PassFilm) -> Option<PassReport> {
        out.values.par_iter_mut().enumerate().for_each(|(i, v)| {
            if cancel.requested() {
                return;
            }
            let mut z = self.0 ^ (pass << 32) ^ i as u64;
            for _ in 0..200 {
                z = (z ^ (z >> 31)).wrapping_mul(0x94d0_49bb_1331_11eb).wrapping_add(0x9e37_79b9_7f4a_7c15);
            }
            *v = (z >> 48) as i64;
        });
        let mut report = PassReport::default();
        report.rays.camera = self.1 as u64;
        (!cancel.requested()).then_some(report)
    }
}
pub fn prelude(_: &Scene, _: &Camera, _: &Options, _: &Layout) -> Prelude {
    Prelude { units: Units { radiance: 1.0, length: 1.0 } }
}
pub fn build<'a>(_: Method, _: &'a Scene, _: Camera, options: &Options, layout: &Layout) -> Box<dyn Integrator + 'a> {
    Box::new(Noise(options.seed, layout.pixels()))
}
pub fn ids(_: &Scene, _: &Camera, layout: &Layout) -> [Vec<f32>; 2] {
    [vec![1.0; layout.pixels()], vec![2.0; layout.pixels()]]
}
