//! Metropolis light transport: chains of paths that stay where light is [Veach97 §11]. What a state is and how it changes is a method's
//! own ([`Chains`]); seeds, normalisation and the passes are the same for all.
//!
//! A pass is a group of chains that is independent of every other. It traces its own samples of bidirectional path tracing, chooses the
//! first states of its chains among them with probabilities proportional to their contributions, and gives what the chains deposit the mean
//! contribution of the same samples. So its expectation is the image, exactly, for any number of samples and any length of chains
//! [Veach97 §11.3.1]. What a chain itself knows better of that mean is not used: the ratio would bias every pass alike.
//!
//! Light that is seen directly or after one scattering event is not left to chains: one sample a pixel of the path tracer has it,
//! stratified over the image as chains are not. Use these methods where most of the light comes by few paths that are hard to find: through
//! gaps, as caustics of caustics. Elsewhere bidirectional path tracing has less noise in the same time.

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

pub use options::{MetropolisOptions, Mutations};
pub use report::{ChainDigest, ChainReport, Normalisation, Tiles};

use super::bidirectional::Bidirectional;
use super::camera_pass::CameraPass;
use super::path::{Combined, PathTracer};
use super::{Integrator, Options, PassReport, Prelude};
use crate::camera::Camera;
use crate::defects::{Defect, planted};
use crate::film::{Layout, PassFilm, Splats};
use crate::mcmc::{Chain, Mixture, Numbers, State};
use crate::parallel::Cancel;
use crate::path::Tally;
use crate::sampling::Address;
use crate::scene::Scene;
use contribution::{Contribution, Importance, Region};
use limit::{Limit, Limited};
use mlt::PathSpace;
use mmlt::Multiplexed;
use pssmlt::PrimarySpace;
use rayon::prelude::*;
use report::ChainLight;
use seeds::{Candidate, Pilot, Seeds};
use std::ops::RangeInclusive;

/// Scattering events of the shortest paths that chains have.
const FEWEST_EVENTS: usize = 2;
/// Steps of a chain, where nothing is said about the number of chains.
const STEPS: usize = 500;
/// Most chains of a pass, where nothing is said.
const MOST_CHAINS: usize = 1024;
/// Samples of bidirectional path tracing for each chain that begins at one of them.
const SEEDS_PER_CHAIN: usize = 100;
/// Variance of a sample relative to its pixel's square from which on bidirectional path tracing is not worth its time, and chains have
/// everything. For the scenes that decided it see docs/measurements.md.
const NOISY: f64 = 3.5;
/// Times what is usual that a sample may count for elsewhere.
const LIMIT: f64 = 10.0;
/// Sets the numbers of chains apart from those of samples.
const CHAIN_STREAM: u64 = 1 << 62;
/// No class of paths has fewer than this share of the steps.
const LEAST_SHARE: f64 = 0.01;
/// Samples that tell how much of the light each class of paths has.
const PILOT: usize = 4096;

/// Chains in primary sample space.
pub(super) fn pssmlt<'a>(scene: &'a Scene, camera: Camera, options: &Options, prelude: &Prelude) -> Box<dyn Integrator + 'a> {
    let chains = PrimarySpace { common: Common::new(scene, camera.clone(), options) };
    Box::new(Metropolis::new(scene, camera, chains, prelude))
}

/// Multiplexed chains.
pub(super) fn mmlt<'a>(scene: &'a Scene, camera: Camera, options: &Options, prelude: &Prelude) -> Box<dyn Integrator + 'a> {
    let chains = Multiplexed::new(Common::new(scene, camera.clone(), options));
    Box::new(Metropolis::new(scene, camera, chains, prelude))
}

/// Chains of paths.
pub(super) fn mlt<'a>(scene: &'a Scene, camera: Camera, options: &Options, prelude: &Prelude) -> Box<dyn Integrator + 'a> {
    let chains = PathSpace { common: Common::new(scene, camera.clone(), options) };
    Box::new(Metropolis::new(scene, camera, chains, prelude))
}

/// States that are worth something to an image.
trait Lit: State {
    /// What the state adds to the image.
    fn contribution(&self) -> &Contribution;
    /// Counts of the rays that states held here have traced.
    fn tally(&mut self) -> &mut Tally;
}

/// A Metropolis method: its states and what changes them. Paths may be divided into classes that have chains and a normalisation of
/// their own.
trait Chains: Send + Sync {
    /// A state.
    type State: Lit + Default + Send;
    /// What it shares with other methods.
    fn common(&self) -> &Common<'_>;
    /// How many classes there are.
    fn classes(&self) -> usize;
    /// The class of paths of `events` scattering events.
    fn class_of(&self, events: usize) -> usize;
    /// What the sample of the numbers at `address` contributes, part by part.
    fn candidates(&self, address: Address, found: &mut Vec<Candidate>, tally: &mut Tally);
    /// Makes `x` the state that the sample at `address` had for `seed`; whether it is lit.
    fn start(&self, seed: &Candidate, address: Address, x: &mut Self::State) -> bool;
    /// The kernels for the states of a class.
    fn kernels(&self, class: usize) -> Mixture<'_, Self::State>;
    /// Their names.
    fn names(&self) -> &'static [&'static str];
}

/// What methods of this kind share.
#[derive(Clone)]
struct Common<'a> {
    scene: &'a Scene,
    camera: Camera,
    options: Options,
    /// Bidirectional path tracing of the paths that are left to chains.
    tracer: Bidirectional<'a>,
    region: Region,
    /// What samples have of the light before chains do.
    limit: Limit,
    importance: Importance,
}

impl<'a> Common<'a> {
    fn new(scene: &'a Scene, camera: Camera, options: &Options) -> Self {
        let region = Region::new(options.crop, options.filter);
        let tracer = Bidirectional::new(scene, &camera, options, &Prelude::default()).with_fewest_events(FEWEST_EVENTS);
        let (limit, importance) = (Limit::NONE, Importance::uniform(region));
        let mut common = Common { scene, camera, options: *options, tracer, region, limit, importance };
        if options.metropolis.limit != Some(0.0) {
            let pilot = Pilot::trace(&common);
            let usual = if pilot.noise > NOISY { 0.0 } else { LIMIT };
            let times = options.metropolis.limit.unwrap_or(usual);
            common.limit = if times > 0.0 { Limit::new(&pilot.usual, times) } else { Limit::NONE };
        }
        if options.metropolis.two_stage {
            common.importance = Importance::new(&Pilot::trace(&common).usual);
        }
        common
    }

    /// The techniques that make paths of `events` events, by their vertices from the light.
    fn techniques(&self, events: usize) -> impl Iterator<Item = usize> + '_ {
        (0..=events + 1).filter(move |s| self.tracer.wants(*s, events + 2 - s))
    }

    /// Edges of the paths that are left to chains.
    fn edges(&self) -> RangeInclusive<usize> {
        FEWEST_EVENTS + 1..=self.options.max_depth.map_or(usize::MAX, |most| most as usize + 1)
    }
}

/// An integrator whose passes are groups of chains.
struct Metropolis<'a, C> {
    chains: C,
    /// What is not left to chains.
    samples: Box<dyn Integrator + 'a>,
    options: Options,
    /// Of the steps that each class gets, the same in every pass.
    shares: Vec<f64>,
}

/// What a class gets in a pass.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Allotment {
    chains: usize,
    steps: usize,
}

/// What a chain did.
struct Ran {
    report: ChainReport,
    tally: Tally,
    light: ChainLight,
}

/// A chain to be run.
struct Task {
    class: usize,
    steps: usize,
    seed: Candidate,
    /// What a weight of 1 deposits, over the state's scalar.
    scale: f64,
}

impl<'a, C: Chains> Metropolis<'a, C> {
    fn new(scene: &'a Scene, camera: Camera, chains: C, prelude: &Prelude) -> Self {
        let (options, limit) = (chains.common().options, chains.common().limit.clone());
        let samples: Box<dyn Integrator + 'a> = if limit.is_none() {
            let depth = options.max_depth.map_or(FEWEST_EVENTS as u32 - 1, |most| most.min(FEWEST_EVENTS as u32 - 1));
            let tracer = PathTracer::<Combined>::new(scene, Some(depth), options.transparent);
            Box::new(CameraPass::new(tracer, scene, camera, &options))
        } else {
            let tracer = Bidirectional::new(scene, &camera, &options, prelude);
            let limited = Limited { tracer, camera: camera.clone(), limit, walks: options.pixels() as f32 };
            Box::new(CameraPass::new(limited, scene, camera, &options))
        };
        // A seed that no pass has, so that passes are independent of it.
        let pilot = Seeds::trace(&chains, Address::new(!options.seed).with(CHAIN_STREAM), PILOT, &Cancel::new());
        let class_of = |seed: &Candidate| chains.class_of(seed.events());
        let shares = shares(&pilot.map_or_else(Vec::new, |pilot| pilot.means(chains.classes(), class_of)));
        Metropolis { chains, samples, options, shares }
    }

    /// How many chains of how many steps each class gets of the `steps` of a pass: all chains of a class are of one length, since equally
    /// spaced seeds are fair only together.
    fn allot(&self, steps: usize) -> Vec<Allotment> {
        let usual = (steps / STEPS).clamp(1, MOST_CHAINS);
        let chains = self.options.metropolis.chains.map_or(usual, |chains| chains as usize);
        let part = |share: &f64| {
            let chains = ((chains as f64 * share).round() as usize).max(1);
            Allotment { chains, steps: ((steps as f64 * share / chains as f64).round() as usize).max(1) }
        };
        self.shares.iter().map(part).collect()
    }

    /// The chains of a pass.
    fn tasks(&self, seeds: &Seeds, allotments: &[Allotment], numbers: &mut Numbers) -> Vec<Task> {
        let mut tasks = Vec::new();
        for (class, allotment) in allotments.iter().enumerate() {
            let offset = numbers.uniform();
            let Some((chosen, mean)) = seeds.choose(class, |c| self.chains.class_of(c.events()), allotment.chains, offset) else {
                continue;
            };
            let scale = mean / (allotment.chains * allotment.steps) as f64;
            tasks.extend(chosen.into_iter().map(|seed| Task { class, steps: allotment.steps, seed, scale }));
        }
        tasks
    }

    /// Runs chain number `id` of a pass.
    fn run(&self, task: &Task, id: u64, pass: Address, kernels: &[Mixture<C::State>], layout: &Layout, splats: &Splats) -> Ran {
        let mut light = ChainLight::new(layout, task.steps);
        let (mut x, y) = (C::State::default(), C::State::default());
        if !self.chains.start(&task.seed, seeds::address(pass, task.seed.sample), &mut x) {
            return Ran { report: ChainReport::lost_seed(), tally: *x.tally(), light };
        }
        let stream = if planted(Defect::ChainsShareStream) { 0 } else { id };
        let (address, mut key) = (pass.with(CHAIN_STREAM | stream), pass.with(!id));
        let mut deposit = |state: &C::State, weight: f64| {
            let found = state.contribution();
            let of_light = || -> f64 { found.splats().iter().map(|(_, color)| f64::from(color.mean())).sum() };
            let scalar = if planted(Defect::ImportanceKept) { of_light() } else { found.scalar() };
            let per_scalar = weight * task.scale / scalar;
            for &(film, color) in found.splats() {
                key = key.with(0);
                splats.add(self.options.filter, film, color * per_scalar as f32, key.bits(0));
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
        Ran { report, tally, light }
    }
}

impl<C: Chains> Metropolis<'_, C> {
    /// What all chains of a pass say together, taken in their order: sums of floating-point numbers.
    fn gather(&self, layout: &Layout, tasks: &[Task], ran: Vec<Ran>, mean: f64, report: &mut PassReport) -> ChainReport {
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

/// What part of the steps each class gets: the part of the light that it has, but not almost nothing.
fn shares(means: &[f64]) -> Vec<f64> {
    let total: f64 = means.iter().sum();
    let lifted: Vec<f64> = means.iter().map(|&mean| if total > 0.0 { (mean / total).max(LEAST_SHARE) } else { 1.0 }).collect();
    let sum: f64 = lifted.iter().sum();
    lifted.iter().map(|share| share / sum).collect()
}

impl<C: Chains> Integrator for Metropolis<'_, C> {
    fn run_pass(&self, pass: u64, cancel: &Cancel, out: &mut PassFilm) -> Option<PassReport> {
        let mut report = self.samples.run_pass(pass, cancel, out)?;
        let number = if planted(Defect::PassesAlike) { 0 } else { pass };
        let address = Address::new(self.options.seed).with(CHAIN_STREAM | number);
        let allotments = self.allot(out.layout().pixels());
        let samples = SEEDS_PER_CHAIN * allotments.iter().map(|a| a.chains).sum::<usize>();
        let seeds = Seeds::trace(&self.chains, address, samples, cancel)?;
        let tasks = self.tasks(&seeds, &allotments, &mut Numbers::new(address));
        let kernels: Vec<_> = (0..self.chains.classes()).map(|class| self.chains.kernels(class)).collect();
        let (layout, splats) = (out.layout().clone(), out.splats());
        let run = |(id, task): (usize, &Task)| {
            (!cancel.requested()).then(|| self.run(task, id as u64, address, &kernels, &layout, splats))
        };
        let ran: Vec<Ran> = tasks.par_iter().enumerate().map(run).collect::<Option<_>>()?;
        out.fold_splats();
        report.add_tally(&seeds.tally);
        report.guards.nonfinite += seeds.nonfinite;
        report.chains = Some(self.gather(&layout, &tasks, ran, seeds.mean(), &mut report));
        Some(report)
    }
}
