//! Metropolis light transport [Veach97 §11]. Each method defines its states and mutations ([`MarkovMethod`]). Seeding,
//! normalisation and passes are shared.
//!
//! A pass is a group of chains, independent of all other passes. It traces its own samples of bidirectional path
//! tracing and resamples the initial states of its chains from them, with probabilities proportional to their
//! contributions. The mean contribution b of the same samples scales the deposits of the chains. The estimator is
//! unbiased for any number of samples and any chain length [Veach97 §11.3.1]. b is estimated from the seeds only.
//! Reusing the chain's large steps would correlate numerator and denominator: a bias of O(1/N) per pass that does not
//! average out.
//!
//! Chains exclude emission seen directly or after one scattering event. These paths are estimated with one sample per
//! pixel, stratified over the image: by the path tracer, or by bidirectional path tracing where it shares light with
//! the chains (see [`SampleThreshold`]). Metropolis methods suit scenes where most light arrives along few paths that
//! are hard to sample: through gaps, or as caustics of caustics. Elsewhere bidirectional path tracing has less noise at
//! equal time.

mod contribution;
mod limit;
mod mlt;
mod mmlt;
mod options;
mod primary;
mod pssmlt;
mod report;
mod seeds;
#[cfg(test)]
mod stationarity;
#[cfg(test)]
mod tests;

pub use options::Mutations;
pub use report::{ChainDigest, ChainReport, Normalisation, Tiles};

use super::bidirectional::Bidirectional;
use super::camera_pass::CameraPass;
use super::path::{Combined, PathTracer};
use super::samples::camera_sample;
use super::{
    ChainsConfig, Integrator, IntegratorConfig, MltConfig, MmltConfig, PassReport, PilotEstimate, PssmltConfig,
};
use crate::camera::{Camera, CameraSample};
use crate::film::{Layout, PassFilm, Splats};
use crate::mcmc::{Chain, Mixture, Numbers, State};
use crate::parallel::Cancel;
use crate::path::TraceStats;
use crate::sampling::{Address, Sampler, Slot};
use crate::scene::Scene;
use contribution::{Contribution, ImageImportance, Region};
use limit::{Limited, SampleThreshold};
use mlt::PathSpace;
use mmlt::Multiplexed;
use pssmlt::PrimarySpace;
use rayon::prelude::*;
use report::ChainLight;
use seeds::{Candidate, Pilot, Seeds};
use std::ops::RangeInclusive;

/// Minimum number of scattering events of paths in chains.
const FEWEST_EVENTS: usize = 2;
/// Default number of steps per chain.
const STEPS: usize = 500;
/// Default maximum of chains per pass.
const MOST_CHAINS: usize = 1024;
/// Bidirectional samples per chain for seeding.
const SEEDS_PER_CHAIN: usize = 100;
/// Threshold of the relative variance, of one sample per pixel, above which bidirectional path tracing is inefficient
/// and chains estimate everything. For the scenes that decided it see docs/measurements.md.
const NOISY: f64 = 3.5;
/// Sample threshold elsewhere, as a multiple of the typical radiance.
const LIMIT: f64 = 10.0;
/// Separates the random numbers of chains from those of samples.
const CHAIN_STREAM: u64 = 1 << 62;
/// Minimum share of the steps for each class of paths.
const LEAST_SHARE: f64 = 0.01;
/// Pilot samples for the share of light of each class.
const PILOT: usize = 4096;

/// Builds Metropolis light transport in primary sample space.
pub(super) fn pssmlt<'a>(
    scene: &'a Scene,
    camera: Camera,
    options: &IntegratorConfig,
    config: PssmltConfig,
    pilot: &PilotEstimate,
) -> Box<dyn Integrator + 'a> {
    let chains =
        PrimarySpace { common: ChainContext::new(scene, camera.clone(), options), large_step: config.large_step };
    Box::new(Metropolis::new(scene, camera, chains, pilot))
}

/// Builds multiplexed Metropolis light transport.
pub(super) fn mmlt<'a>(
    scene: &'a Scene,
    camera: Camera,
    options: &IntegratorConfig,
    config: MmltConfig,
    pilot: &PilotEstimate,
) -> Box<dyn Integrator + 'a> {
    let chains = Multiplexed::new(ChainContext::new(scene, camera.clone(), options), config);
    Box::new(Metropolis::new(scene, camera, chains, pilot))
}

/// Builds Metropolis light transport in path space.
pub(super) fn mlt<'a>(
    scene: &'a Scene,
    camera: Camera,
    options: &IntegratorConfig,
    config: MltConfig,
    pilot: &PilotEstimate,
) -> Box<dyn Integrator + 'a> {
    let chains = PathSpace { common: ChainContext::new(scene, camera.clone(), options), mutations: config.mutations };
    Box::new(Metropolis::new(scene, camera, chains, pilot))
}

/// States that contribute to an image.
trait ImageState: State {
    /// Image contribution of the state.
    fn contribution(&self) -> &Contribution;
    /// Counters of the rays traced for states stored in this object.
    fn tally(&mut self) -> &mut TraceStats;
}

/// A Metropolis method: its states and kernels. Paths may be divided into classes, each with its own chains and
/// normalisation.
trait MarkovMethod: Send + Sync {
    /// State type.
    type State: ImageState + Default + Send;
    /// Context shared with other methods.
    fn common(&self) -> &ChainContext<'_>;
    /// Number of classes.
    fn classes(&self) -> usize;
    /// Class of paths with `events` scattering events.
    fn class_of(&self, events: usize) -> usize;
    /// Appends the contributions of the sample at `address`, one candidate per part.
    fn candidates(&self, address: Address, found: &mut Vec<Candidate>, tally: &mut TraceStats);
    /// Sets `x` to the state of the sample at `address` that `seed` refers to. Returns whether its contribution is
    /// nonzero.
    fn start(&self, seed: &Candidate, address: Address, x: &mut Self::State) -> bool;
    /// Kernels for the states of a class.
    fn kernels(&self, class: usize) -> Mixture<'_, Self::State>;
    /// Names of the kernels.
    fn names(&self) -> &'static [&'static str];
}

/// Context shared by the Metropolis methods.
#[derive(Clone)]
struct ChainContext<'a> {
    scene: &'a Scene,
    camera: Camera,
    options: IntegratorConfig,
    /// Bidirectional path tracing of the paths assigned to chains.
    tracer: Bidirectional<'a>,
    region: Region,
    /// Threshold up to which samples, not chains, account for contributions.
    limit: SampleThreshold,
    importance: ImageImportance,
}

impl<'a> ChainContext<'a> {
    fn new(scene: &'a Scene, camera: Camera, options: &IntegratorConfig) -> Self {
        let region = Region::new(options.crop, options.filter);
        let tracer =
            Bidirectional::new(scene, &camera, options, &PilotEstimate::default()).with_fewest_events(FEWEST_EVENTS);
        let (limit, importance) = (SampleThreshold::NONE, ImageImportance::uniform(region));
        let mut common = ChainContext { scene, camera, options: *options, tracer, region, limit, importance };
        let ChainsConfig { chain_threshold, two_stage, .. } = options.method.chains();
        if chain_threshold != Some(0.0) {
            let pilot = Pilot::trace(&common);
            let usual = if pilot.noise > NOISY { 0.0 } else { LIMIT };
            let times = chain_threshold.unwrap_or(usual);
            common.limit = if times > 0.0 { SampleThreshold::new(&pilot.usual, times) } else { SampleThreshold::NONE };
        }
        if two_stage {
            common.importance = ImageImportance::new(&Pilot::trace(&common).usual);
        }
        common
    }

    /// Enumerates the enabled techniques for paths of `events` events, by number of light vertices.
    fn techniques(&self, events: usize) -> impl Iterator<Item = usize> + '_ {
        (0..=events + 1).filter(move |s| self.tracer.is_enabled(*s, events + 2 - s))
    }

    /// Samples the raster position uniformly over the region, and the lens.
    fn camera_sample(&self, sampler: &mut impl Sampler) -> CameraSample {
        let film = self.region.at(sampler.u2(0, Slot::Film));
        camera_sample(&self.camera, film, sampler)
    }

    /// Number of edges of the paths assigned to chains.
    fn edges(&self) -> RangeInclusive<usize> {
        FEWEST_EVENTS + 1..=self.options.max_depth.map_or(usize::MAX, |most| most as usize + 1)
    }
}

/// An integrator whose passes are groups of chains.
struct Metropolis<'a, C> {
    chains: C,
    /// Integrator of the contributions not assigned to chains.
    samples: Box<dyn Integrator + 'a>,
    options: IntegratorConfig,
    /// Share of steps for each class, the same in every pass.
    shares: Vec<f64>,
}

/// Chains of a class in one pass, and steps of each.
#[derive(Debug, Clone, Copy, PartialEq)]
struct StepBudget {
    chains: usize,
    steps: usize,
}

/// Result of a chain.
struct ChainResult {
    report: ChainReport,
    tally: TraceStats,
    light: ChainLight,
}

/// A chain to run.
struct Task {
    class: usize,
    steps: usize,
    seed: Candidate,
    /// Deposit for a weight of 1, to be divided by the scalar contribution of the state.
    scale: f64,
}

impl<'a, C: MarkovMethod> Metropolis<'a, C> {
    fn new(scene: &'a Scene, camera: Camera, chains: C, pilot: &PilotEstimate) -> Self {
        let (options, limit) = (chains.common().options, chains.common().limit.clone());
        let samples: Box<dyn Integrator + 'a> = if limit.is_none() {
            let depth = options.max_depth.map_or(FEWEST_EVENTS as u32 - 1, |most| most.min(FEWEST_EVENTS as u32 - 1));
            let tracer = PathTracer::<Combined>::new(scene, Some(depth), options.transparent);
            Box::new(CameraPass::new(tracer, scene, camera, &options))
        } else {
            let tracer = Bidirectional::new(scene, &camera, &options, pilot);
            let limited = Limited { tracer, limit, walks: options.pixels() as f32 };
            Box::new(CameraPass::new(limited, scene, camera, &options))
        };
        // No pass has this seed, so that passes are independent of the pilot.
        let pilot = Seeds::trace(&chains, Address::new(!options.seed).with(CHAIN_STREAM), PILOT, &Cancel::new());
        let class_of = |seed: &Candidate| chains.class_of(seed.events());
        let shares = shares(&pilot.map_or_else(Vec::new, |pilot| pilot.means(chains.classes(), class_of)));
        Metropolis { chains, samples, options, shares }
    }

    /// Divides the `steps` of a pass among the classes. All chains of a class have the same length, since systematic
    /// resampling is unbiased only for the seeds together.
    fn allot(&self, steps: usize) -> Vec<StepBudget> {
        let usual = (steps / STEPS).clamp(1, MOST_CHAINS);
        let chains = self.options.method.chains().chains.map_or(usual, |chains| chains as usize);
        let part = |share: &f64| {
            let chains = ((chains as f64 * share).round() as usize).max(1);
            StepBudget { chains, steps: ((steps as f64 * share / chains as f64).round() as usize).max(1) }
        };
        self.shares.iter().map(part).collect()
    }

    /// Selects the seeds of all chains of a pass.
    fn tasks(&self, seeds: &Seeds, allotments: &[StepBudget], numbers: &mut Numbers) -> Vec<Task> {
        let mut tasks = Vec::new();
        for (class, allotment) in allotments.iter().enumerate() {
            let offset = numbers.uniform();
            let Some((chosen, mean)) =
                seeds.choose(class, |c| self.chains.class_of(c.events()), allotment.chains, offset)
            else {
                continue;
            };
            let scale = mean / (allotment.chains * allotment.steps) as f64;
            tasks.extend(chosen.into_iter().map(|seed| Task { class, steps: allotment.steps, seed, scale }));
        }
        tasks
    }

    /// Runs chain number `id` of a pass.
    fn run(
        &self,
        task: &Task,
        id: u64,
        pass: Address,
        kernels: &[Mixture<C::State>],
        layout: &Layout,
        splats: &Splats,
    ) -> ChainResult {
        let mut light = ChainLight::new(layout, task.steps);
        let (mut x, y) = (C::State::default(), C::State::default());
        if !self.chains.start(&task.seed, seeds::address(pass, task.seed.sample), &mut x) {
            return ChainResult { report: ChainReport::lost_seed(), tally: *x.tally(), light };
        }
        let (address, mut key) = (pass.with(CHAIN_STREAM | id), pass.with(!id));
        let mut queue = splats.queue(self.options.filter);
        let mut deposit = |state: &C::State, weight: f64| {
            let found = state.contribution();
            let per_scalar = weight * task.scale / found.scalar();
            for &(film, color) in found.splats() {
                key = key.with(0);
                queue.add(film, color * per_scalar as f32, key.bits(0));
                light.add(film, color, weight, task.scale / found.scalar());
            }
            light.pass(weight);
        };
        let mut chain = Chain::new(x, y);
        for step in 0..task.steps as u64 {
            chain.step(&kernels[task.class], &mut Numbers::new(address.with(step)), &mut deposit);
        }
        chain.flush(&mut deposit);
        let report = ChainReport::of_chain(self.chains.names(), chain.counts(), task.steps);
        let (mut x, mut y) = chain.into_states();
        let mut tally = *x.tally();
        tally.absorb(y.tally());
        ChainResult { report, tally, light }
    }
}

impl<C: MarkovMethod> Metropolis<'_, C> {
    /// Merges the results of all chains of a pass in their order, since the sums are in floating point.
    fn gather(
        &self,
        layout: &Layout,
        tasks: &[Task],
        ran: Vec<ChainResult>,
        mean: f64,
        report: &mut PassReport,
    ) -> ChainReport {
        let mut all = ChainReport::of_pass(mean, layout);
        for class in 0..self.chains.classes() {
            let lights: Vec<&ChainLight> =
                tasks.iter().zip(&ran).filter(|(t, _)| t.class == class).map(|(_, r)| &r.light).collect();
            all.tiles.add_class(&lights);
        }
        for chain in ran {
            report.add_tally(&chain.tally);
            all.absorb(chain.report);
        }
        all
    }
}

/// Computes the share of steps of each class: its share of the light, with a lower bound.
fn shares(means: &[f64]) -> Vec<f64> {
    let total: f64 = means.iter().sum();
    let lifted: Vec<f64> =
        means.iter().map(|&mean| if total > 0.0 { (mean / total).max(LEAST_SHARE) } else { 1.0 }).collect();
    let sum: f64 = lifted.iter().sum();
    lifted.iter().map(|share| share / sum).collect()
}

impl<C: MarkovMethod> Integrator for Metropolis<'_, C> {
    fn run_pass(&self, pass: u64, cancel: &Cancel, out: &mut PassFilm) -> Option<PassReport> {
        let mut report = self.samples.run_pass(pass, cancel, out)?;
        let address = Address::new(self.options.seed).with(CHAIN_STREAM | pass);
        let allotments = self.allot(out.layout().pixels());
        let samples = SEEDS_PER_CHAIN * allotments.iter().map(|a| a.chains).sum::<usize>();
        let seeds = Seeds::trace(&self.chains, address, samples, cancel)?;
        let tasks = self.tasks(&seeds, &allotments, &mut Numbers::new(address));
        let kernels: Vec<_> = (0..self.chains.classes()).map(|class| self.chains.kernels(class)).collect();
        let (layout, splats) = (out.layout().clone(), out.splats());
        let run = |(id, task): (usize, &Task)| {
            (!cancel.requested()).then(|| self.run(task, id as u64, address, &kernels, &layout, splats))
        };
        let ran: Vec<ChainResult> = tasks.par_iter().enumerate().map(run).collect::<Option<_>>()?;
        out.fold_splats();
        report.add_tally(&seeds.tally);
        report.guards.nonfinite += seeds.nonfinite;
        report.chains = Some(self.gather(&layout, &tasks, ran, seeds.mean(), &mut report));
        Some(report)
    }
}
