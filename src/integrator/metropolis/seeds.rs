//! Chain seeding: samples of bidirectional path tracing, and resampling among them.

use super::contribution::{ImageImportance, Region, RegionMap};
use super::{ChainContext, MarkovMethod};
use crate::integrator::bidirectional::{Sink, TechniqueSample};
use crate::mcmc::stratified;
use crate::parallel::Cancel;
use crate::path::TraceStats;
use crate::sampling::{Address, IndependentSampler};
use crate::spectrum::Spectrum;
use rayon::prelude::*;

/// Samples per task.
const CHUNK: usize = 64;
/// Separates the random numbers of seeds from those of chains.
const SEED_STREAM: u64 = 1 << 61;

/// Returns the address of seed sample `sample` of a pass.
pub(super) fn address(pass: Address, sample: u32) -> Address {
    pass.with(SEED_STREAM | u64::from(sample))
}

/// Contribution of a sample by the technique of `s` light and `t` camera vertices; the whole sample if both are 0.
#[derive(Debug, Clone, Copy)]
pub(super) struct Candidate {
    pub(super) sample: u32,
    pub(super) s: u16,
    pub(super) t: u16,
    pub(super) scalar: f64,
}

impl Candidate {
    /// Appends the contribution of each technique of bidirectional path tracing for the random numbers at `address`.
    pub(super) fn of_techniques(
        common: &ChainContext,
        address: Address,
        found: &mut Vec<Candidate>,
        tally: &mut TraceStats,
    ) {
        let mut add = |s: usize, t: usize, film: [f32; 2], color: Spectrum| {
            if common.region.contains(film) && !color.is_black() {
                found.push(Candidate {
                    sample: 0,
                    s: s as u16,
                    t: t as u16,
                    scalar: common.importance.scalar(film, color),
                });
            }
        };
        bidirectional(common, address, &mut add, tally);
    }

    /// Number of scattering events of its paths.
    pub(super) fn events(&self) -> usize {
        usize::from(self.s + self.t).saturating_sub(2)
    }
}

/// Seed samples of a pass.
pub(super) struct Seeds {
    samples: usize,
    candidates: Vec<Candidate>,
    /// Ray counters.
    pub(super) tally: TraceStats,
    /// Dropped nonfinite candidates.
    pub(super) nonfinite: u64,
}

impl Seeds {
    /// Traces `samples` samples; `None` if it was cancelled.
    pub(super) fn trace(chains: &impl MarkovMethod, pass: Address, samples: usize, cancel: &Cancel) -> Option<Self> {
        let chunk = |chunk: usize| {
            let (mut found, mut tally) = (Vec::new(), TraceStats::default());
            for sample in chunk * CHUNK..samples.min((chunk + 1) * CHUNK) {
                let from = found.len();
                chains.candidates(address(pass, sample as u32), &mut found, &mut tally);
                found[from..].iter_mut().for_each(|candidate| candidate.sample = sample as u32);
            }
            (!cancel.requested()).then_some((found, tally))
        };
        let chunks: Vec<_> = (0..samples.div_ceil(CHUNK)).into_par_iter().map(chunk).collect::<Option<_>>()?;
        let mut seeds = Seeds { samples, candidates: Vec::new(), tally: TraceStats::default(), nonfinite: 0 };
        for (found, tally) in chunks {
            seeds.nonfinite += found.iter().filter(|c| !c.scalar.is_finite()).count() as u64;
            seeds.candidates.extend(found.into_iter().filter(|c| c.scalar.is_finite()));
            seeds.tally.absorb(&tally);
        }
        Some(seeds)
    }

    /// Returns the mean contribution of a sample.
    pub(super) fn mean(&self) -> f64 {
        self.candidates.iter().map(|c| c.scalar).sum::<f64>() / self.samples as f64
    }

    /// Returns the mean contribution of each class.
    pub(super) fn means(&self, classes: usize, class_of: impl Fn(&Candidate) -> usize) -> Vec<f64> {
        let mut means = vec![0.0; classes];
        self.candidates.iter().for_each(|c| means[class_of(c)] += c.scalar / self.samples as f64);
        means
    }

    /// Resamples `count` candidates of a class and returns them with the mean contribution of the class; `None` if it
    /// has no light.
    pub(super) fn choose(
        &self,
        class: usize,
        class_of: impl Fn(&Candidate) -> usize,
        count: usize,
        offset: f64,
    ) -> Option<(Vec<Candidate>, f64)> {
        let of_class: Vec<&Candidate> = self.candidates.iter().filter(|c| class_of(c) == class).collect();
        let weights: Vec<f64> = of_class.iter().map(|c| c.scalar).collect();
        let chosen = stratified(&weights, count, offset)?;
        Some((chosen.into_iter().map(|i| *of_class[i]).collect(), weights.iter().sum::<f64>() / self.samples as f64))
    }
}

/// Evaluates the chains' share of each technique of bidirectional path tracing for the random numbers at `address`.
fn bidirectional(
    common: &ChainContext,
    address: Address,
    found: &mut impl FnMut(usize, usize, [f32; 2], Spectrum),
    tally: &mut TraceStats,
) {
    let [mut camera, light] = [0, 1].map(|stream| IndependentSampler::new(address.with(stream)));
    let sample = common.camera_sample(&mut camera);
    let mut sink = ByTechnique { common, film: sample.film, found };
    common.tracer.sample(&sample, &mut camera, || light, &mut sink, tally);
}

/// A sink that forwards the chains' share of each technique, scaled to the whole film.
pub(super) struct ByTechnique<'f, F> {
    pub(super) common: &'f ChainContext<'f>,
    /// Raster position of the camera subpath.
    pub(super) film: [f32; 2],
    pub(super) found: &'f mut F,
}

impl<F: FnMut(usize, usize, [f32; 2], Spectrum)> Sink for ByTechnique<'_, F> {
    fn add(&mut self, found: TechniqueSample) {
        let share = self.common.limit.share_of_chains(self.film, &found, 1.0);
        // A camera subpath samples the whole film area.
        let scale = found.weight as f32 * self.common.region.area() * share;
        (self.found)(found.s, found.t, self.film, found.value * scale);
    }

    fn splat(&mut self, film: [f32; 2], found: TechniqueSample) {
        let share = self.common.limit.share_of_chains(film, &found, self.common.options.pixels() as f32);
        (self.found)(found.s, 1, film, found.value * (found.weight as f32 * share));
    }
}

/// Columns and rows of the pilot image.
const PICTURE: usize = 16;
/// Samples of the pilot image.
const PICTURE_SAMPLES: u64 = 64 * (PICTURE * PICTURE) as u64;
/// Lower bound of the squared cell mean, as a share of the mean over cells, so that dark cells do not dominate.
const DARK: f64 = 0.1;
/// Sample limit as a multiple of the image mean: a single bright sample in a dim cell would hide its typical radiance.
const MOST_OF_MEAN: f64 = 8.0;

/// Pilot estimate of the light shared with chains.
pub(super) struct Pilot {
    /// Rough typical radiance of each part of the image.
    pub(super) usual: RegionMap,
    /// Relative variance of one sample per pixel, averaged over the cells.
    pub(super) noise: f64,
}

/// Contributions in one cell of the pilot image.
#[derive(Default, Clone, Copy)]
struct Fallen {
    sum: f64,
    square: f64,
    limited: f64,
}

impl Pilot {
    /// Traces the pilot samples.
    pub(super) fn trace(common: &ChainContext) -> Self {
        let flat = ImageImportance::uniform(common.region);
        let address = Address::new(!common.options.seed).with(SEED_STREAM);
        let trace = |i: u64| {
            let mut light = Vec::new();
            let mut found = |_, _, film, color: Spectrum| {
                if common.region.contains(film) && color.is_finite() {
                    light.push((common.region.cell(film, [PICTURE; 2]), flat.scalar(film, color)));
                }
            };
            bidirectional(common, address.with(i), &mut found, &mut TraceStats::default());
            light
        };
        let all: Vec<Vec<(usize, f64)>> = (0..PICTURE_SAMPLES).into_par_iter().map(trace).collect();
        Pilot::of(all.into_iter().flatten().collect(), common.region)
    }

    /// Computes the statistics of film contributions by cell.
    fn of(contributions: Vec<(usize, f64)>, region: Region) -> Self {
        let (cells, area) = ((PICTURE * PICTURE) as f64, f64::from(region.area()));
        let mean = contributions.iter().map(|(_, light)| light).sum::<f64>() / PICTURE_SAMPLES as f64;
        let mut fallen = [Fallen::default(); PICTURE * PICTURE];
        for (cell, light) in contributions {
            let Fallen { sum, square, limited } = &mut fallen[cell];
            *sum += light / PICTURE_SAMPLES as f64;
            *square += light * light / PICTURE_SAMPLES as f64;
            *limited += light.min(MOST_OF_MEAN * mean) / PICTURE_SAMPLES as f64;
        }
        // A cell covers area / cells pixels, and a pass has as many samples as pixels.
        let usual = fallen.iter().map(|f| f.limited * cells / area).collect();
        let usual = RegionMap { region, cells: usual, columns: PICTURE };
        let floor = (DARK * mean / cells).powi(2);
        let noise = fallen.iter().map(|f| f.square / (cells * (f.sum * f.sum + floor))).sum::<f64>() / cells;
        Pilot { usual, noise }
    }
}
