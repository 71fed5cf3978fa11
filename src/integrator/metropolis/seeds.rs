//! Where chains begin: samples of bidirectional path tracing, and the choice among them.

use super::contribution::{Importance, Picture, Region};
use super::{Chains, Common};
use crate::defects::{Defect, planted};
use crate::integrator::bidirectional::{Found, Sink};
use crate::mcmc::stratified;
use crate::parallel::Cancel;
use crate::path::Tally;
use crate::sampling::{Address, Independent, Sampler, Slot};
use crate::spectrum::Spectrum;
use rayon::prelude::*;

/// Samples that one task traces.
const CHUNK: usize = 64;
/// Sets the numbers of seeds apart from those of chains.
const SEED_STREAM: u64 = 1 << 61;

/// The numbers of seed sample `sample` of a pass.
pub(super) fn address(pass: Address, sample: u32) -> Address {
    pass.with(SEED_STREAM | u64::from(sample))
}

/// What a sample contributes by the technique of `s` vertices from the light and `t` from the camera, or in whole with both 0.
#[derive(Debug, Clone, Copy)]
pub(super) struct Candidate {
    pub(super) sample: u32,
    pub(super) s: u16,
    pub(super) t: u16,
    pub(super) scalar: f64,
}

impl Candidate {
    /// What each technique of bidirectional path tracing finds with the numbers at `address`.
    pub(super) fn of_techniques(common: &Common, address: Address, found: &mut Vec<Candidate>, tally: &mut Tally) {
        let mut add = |s: usize, t: usize, film: [f32; 2], color: Spectrum| {
            if common.region.contains(film) && !color.is_black() {
                found.push(Candidate { sample: 0, s: s as u16, t: t as u16, scalar: common.importance.scalar(film, color) });
            }
        };
        bidirectional(common, address, &mut add, tally);
    }

    /// Scattering events of its paths.
    pub(super) fn events(&self) -> usize {
        usize::from(self.s + self.t).saturating_sub(2)
    }
}

/// The samples of a pass.
pub(super) struct Seeds {
    samples: usize,
    candidates: Vec<Candidate>,
    /// What was traced.
    pub(super) tally: Tally,
    /// Candidates that were dropped.
    pub(super) nonfinite: u64,
}

impl Seeds {
    /// Traces `samples` samples; `None` if it was cancelled.
    pub(super) fn trace(chains: &impl Chains, pass: Address, samples: usize, cancel: &Cancel) -> Option<Self> {
        let chunk = |chunk: usize| {
            let (mut found, mut tally) = (Vec::new(), Tally::default());
            for sample in chunk * CHUNK..samples.min((chunk + 1) * CHUNK) {
                let from = found.len();
                chains.candidates(address(pass, sample as u32), &mut found, &mut tally);
                found[from..].iter_mut().for_each(|candidate| candidate.sample = sample as u32);
            }
            (!cancel.requested()).then_some((found, tally))
        };
        let chunks: Vec<_> = (0..samples.div_ceil(CHUNK)).into_par_iter().map(chunk).collect::<Option<_>>()?;
        let mut seeds = Seeds { samples, candidates: Vec::new(), tally: Tally::default(), nonfinite: 0 };
        for (found, tally) in chunks {
            seeds.nonfinite += found.iter().filter(|c| !c.scalar.is_finite()).count() as u64;
            seeds.candidates.extend(found.into_iter().filter(|c| c.scalar.is_finite()));
            seeds.tally.absorb(&tally);
        }
        Some(seeds)
    }

    /// Mean contribution of a sample.
    pub(super) fn mean(&self) -> f64 {
        self.candidates.iter().map(|c| c.scalar).sum::<f64>() / self.samples as f64
    }

    /// The same for each class.
    pub(super) fn means(&self, classes: usize, class_of: impl Fn(&Candidate) -> usize) -> Vec<f64> {
        let mut means = vec![0.0; classes];
        self.candidates.iter().for_each(|c| means[class_of(c)] += c.scalar / self.samples as f64);
        means
    }

    /// `count` of the candidates of a class, and the mean contribution of that class; `None` if there is no light in it.
    pub(super) fn choose(
        &self,
        class: usize,
        class_of: impl Fn(&Candidate) -> usize,
        count: usize,
        offset: f64,
    ) -> Option<(Vec<Candidate>, f64)> {
        let of_class: Vec<&Candidate> = self.candidates.iter().filter(|c| class_of(c) == class).collect();
        let weights: Vec<f64> = of_class.iter().map(|c| c.scalar).collect();
        let chances = if planted(Defect::SeedsAlike) { vec![1.0; weights.len()] } else { weights.clone() };
        let chosen = stratified(&chances, count, offset)?;
        let samples = if planted(Defect::LitSeedsOnly) { weights.len() } else { self.samples };
        Some((chosen.into_iter().map(|i| *of_class[i]).collect(), weights.iter().sum::<f64>() / samples as f64))
    }
}

/// What bidirectional path tracing finds for chains with the numbers at `address`, technique by technique.
fn bidirectional(common: &Common, address: Address, found: &mut impl FnMut(usize, usize, [f32; 2], Spectrum), tally: &mut Tally) {
    let [mut camera, light] = [0, 1].map(|stream| Independent::new(address.with(stream)));
    let film = common.region.at(camera.u2(0, Slot::Aux));
    let mut sink = ByTechnique { common, film, found };
    common.tracer.sample(common.camera.ray(film), &mut camera, || light, &mut sink, tally);
}

/// Hands over the part of each technique's light that is left to chains, for the whole film.
pub(super) struct ByTechnique<'f, F> {
    pub(super) common: &'f Common<'f>,
    /// Where the walk from the camera began.
    pub(super) film: [f32; 2],
    pub(super) found: &'f mut F,
}

impl<F: FnMut(usize, usize, [f32; 2], Spectrum)> Sink for ByTechnique<'_, F> {
    fn add(&mut self, found: Found) {
        let share = self.common.limit.share_of_chains(self.film, &found, 1.0);
        // A walk from the camera is one for the film's whole area.
        let scale = found.weight as f32 * self.common.region.area() * share;
        (self.found)(found.s, found.t, self.film, found.value * scale);
    }

    fn splat(&mut self, film: [f32; 2], found: Found) {
        let share = self.common.limit.share_of_chains(film, &found, self.common.options.pixels() as f32);
        (self.found)(found.s, 1, film, found.value * (found.weight as f32 * share));
    }
}

/// Columns and rows of the pilot's picture.
const PICTURE: usize = 16;
/// Samples for it.
const PICTURE_SAMPLES: u64 = 64 * (PICTURE * PICTURE) as u64;
/// Squares of cells are lifted by that of this share of the mean, so that dark ones do not dominate.
const DARK: f64 = 0.1;
/// No sample counts for more than this many times the mean of all: one in a dim cell would hide what is usual there.
const MOST_OF_MEAN: f64 = 8.0;

/// What a few samples say of the light that chains have a part in.
pub(super) struct Pilot {
    /// Radiance that each part of the image usually has, roughly.
    pub(super) usual: Picture,
    /// Variance of a sample a pixel relative to the square of the pixel, its mean over the cells.
    pub(super) noise: f64,
}

/// Contributions that fall into one cell of the picture.
#[derive(Default, Clone, Copy)]
struct Fallen {
    sum: f64,
    square: f64,
    limited: f64,
}

impl Pilot {
    /// Traces the samples.
    pub(super) fn trace(common: &Common) -> Self {
        let flat = Importance::uniform(common.region);
        let address = Address::new(!common.options.seed).with(SEED_STREAM);
        let trace = |i: u64| {
            let mut light = Vec::new();
            let mut found = |_, _, film, color: Spectrum| {
                if common.region.contains(film) && color.is_finite() {
                    light.push((common.region.cell(film, [PICTURE; 2]), flat.scalar(film, color)));
                }
            };
            bidirectional(common, address.with(i), &mut found, &mut Tally::default());
            light
        };
        let all: Vec<Vec<(usize, f64)>> = (0..PICTURE_SAMPLES).into_par_iter().map(trace).collect();
        Pilot::of(all.into_iter().flatten().collect(), common.region)
    }

    /// Of contributions to the whole film by cell.
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
        // A cell has area / cells of the pixels, and a pass as many samples as pixels.
        let usual = fallen.iter().map(|f| f.limited * cells / area).collect();
        let usual = Picture { region, cells: usual, columns: PICTURE };
        let floor = (DARK * mean / cells).powi(2);
        let noise = fallen.iter().map(|f| f.square / (cells * (f.sum * f.sum + floor))).sum::<f64>() / cells;
        Pilot { usual, noise }
    }
}
