//! Deposits of chains on the film.

use super::mlt::PathSpace;
use super::seeds::Seeds;
use super::stationarity::{SIDE, all, common, worlds};
use super::{ChainContext, ChainsConfig, MarkovMethod, Metropolis, MltConfig, Mutations, Task};
use crate::film::{Filter, Layout, PassFilm};
use crate::integrator::{Integrator, IntegratorConfig, MethodConfig, PilotEstimate};
use crate::parallel::Cancel;
use crate::sampling::Address;
use worlds::World;

/// A path space method and a seed for it.
struct Made<'a> {
    metropolis: Metropolis<'a, PathSpace<'a>>,
    task: Task,
}

const STEPS: usize = 50;
/// Address of the pass.
const ADDRESS: u64 = 3;

impl<'a> Made<'a> {
    fn of(world: &'a World, common: ChainContext<'a>) -> Self {
        let camera = common.camera.clone();
        let metropolis = Metropolis::new(
            &world.scene,
            camera,
            PathSpace { common, mutations: Mutations::default() },
            &PilotEstimate::default(),
        );
        let seeds =
            Seeds::trace(&metropolis.chains, Address::new(ADDRESS), 200, &Cancel::new()).expect("not cancelled");
        let (chosen, _) = seeds.choose(0, |_| 0, 1, 0.5).expect("some light");
        let task = Task { class: 0, steps: STEPS, seed: chosen[0], scale: 1.0 };
        Made { metropolis, task }
    }

    /// Renders the deposits of chain number `id`.
    fn picture(&self, id: u64) -> Vec<f32> {
        let layout = Layout::new(SIDE, SIDE, Some(self.metropolis.options.crop), &[]);
        let (mut film, kernels) = (PassFilm::new(&layout), [self.metropolis.chains.kernels(0)]);
        self.metropolis.run(&self.task, id, Address::new(ADDRESS), &kernels, &layout, film.splats());
        film.fold_splats();
        film.values().to_vec()
    }
}

fn largest_difference(a: &[f32], b: &[f32]) -> f32 {
    a.iter().zip(b).map(|(a, b)| (a - b).abs()).fold(0.0, f32::max)
}

/// Splats are rounded stochastically, each to one part in 2²⁴.
const ROUNDING: f32 = 1.0 / 16_777_216.0;

/// Chains with the same seed diverge, since each has its own random numbers.
#[test]
fn chains_of_one_seed_are_independent() {
    let world = worlds::all().into_iter().next().expect("a world");
    let made = Made::of(&world, common(&world, all()));
    assert_eq!(made.picture(1), made.picture(1));
    let off = largest_difference(&made.picture(1), &made.picture(2));
    assert!(off > 1e3 * ROUNDING, "two chains of one seed are the same but for {off}");
}

/// For any importance, each step deposits its share of the target.
#[test]
fn mlt_step_deposits_sum_to_its_target_share() {
    let world = worlds::all().into_iter().next().expect("a world");
    let layout = Layout::new(SIDE, SIDE, None, &[]);
    let chains = ChainsConfig { two_stage: true, ..all() };
    let method = MethodConfig::Mlt(MltConfig { chains, ..MltConfig::default() });
    let options =
        IntegratorConfig { filter: Filter::Box, max_depth: Some(7), ..IntegratorConfig::new(method, &layout) };
    let camera = world.scene.camera(None, SIDE, SIDE).expect("a camera");
    let common = ChainContext::new(&world.scene, camera, &options);
    let importance = common.importance.clone();
    let picture = Made::of(&world, common).picture(1);
    let scalar = |(i, pixel): (usize, &[f32])| {
        let light = crate::spectrum::Spectrum([pixel[0], pixel[1], pixel[2]]);
        importance.scalar(layout.pixel(i).map(|x| x as f32 + 0.5), light)
    };
    let found: f64 = picture.chunks_exact(layout.channels()).enumerate().map(scalar).sum();
    // A step deposits a weight of 1 at no more than two states, each rounded in f32 and for the film.
    let bound = STEPS as f64 * 16.0 * f64::from(ROUNDING);
    assert!((found - STEPS as f64).abs() < bound, "{STEPS} steps deposited {found}");
}

/// Passes must be independent, since replicates are.
#[test]
fn mlt_passes_have_independent_chains() {
    let world = worlds::all().into_iter().next().expect("a world");
    let Made { metropolis, .. } = Made::of(&world, common(&world, all()));
    let layout = Layout::new(SIDE, SIDE, Some(metropolis.options.crop), &[]);
    let chains_of = |pass: u64| {
        let mut film = PassFilm::new(&layout);
        let report = metropolis.run_pass(pass, &Cancel::new(), &mut film).expect("not cancelled");
        report.chains.expect("chains")
    };
    let [first, second] = [0, 1].map(chains_of);
    assert_eq!(first, chains_of(0));
    assert_ne!(first.kernels, second.kernels, "two passes have the same chains");
    assert_ne!(first.normalisation, second.normalisation, "two passes have the same seeds");
}
