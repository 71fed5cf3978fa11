//! Path space Metropolis light transport: chains of paths under mutations, with transition densities computed by the
//! explicit evaluator [Veach97 §11.4].
//!
//! Densities are in the product area measure of [`crate::path::notation`], in which a chain of Dirac vertices
//! contributes the same factor to f and to all densities; it is left out. Acceptance probabilities depend on f(x̄) and
//! on densities that are functions of the two paths alone: a mutation that can produce a path in several ways sums over
//! them. Alpha-blended surfaces are not supported.

mod bidirectional;
mod caustic;
mod extend;
mod lens_subpath;
mod perturb_camera;
mod seed;
mod state;

use super::seeds::Candidate;
use super::{ChainContext, MarkovMethod, Mutations};
use crate::mcmc::{Kernel, Mixture};
use crate::path::TraceStats;
use crate::sampling::Address;
use bidirectional::Bidirectional;
use caustic::Caustic;
use lens_subpath::LensSubpath;
use perturb_camera::{LensPerturbation, MultiChainPerturbation};
use state::PathState;

/// The method.
pub(super) struct PathSpace<'a> {
    pub(super) common: ChainContext<'a>,
    pub(super) mutations: Mutations,
}

impl<'a> MarkovMethod for PathSpace<'a> {
    type State = PathState<'a>;

    fn common(&self) -> &ChainContext<'_> {
        &self.common
    }

    fn classes(&self) -> usize {
        1
    }

    fn class_of(&self, _: usize) -> usize {
        0
    }

    fn candidates(&self, address: Address, found: &mut Vec<Candidate>, tally: &mut TraceStats) {
        Candidate::of_techniques(&self.common, address, found, tally);
    }

    fn start(&self, seed: &Candidate, address: Address, x: &mut PathState<'a>) -> bool {
        let path = seed::path(&self.common, [seed.s, seed.t].map(usize::from), address, &mut x.tally);
        path.is_some_and(|draft| x.set(&self.common, draft).is_some())
    }

    fn kernels(&self, _: usize) -> Mixture<'_, PathState<'a>> {
        let (common, Mutations { bidirectional, lens, caustic, multi_chain, lens_subpath }) =
            (&self.common, self.mutations);
        let kernels: [Box<dyn Kernel<PathState<'a>> + Sync + '_>; 5] = [
            Box::new(Bidirectional::new(common, bidirectional)),
            Box::new(LensPerturbation { common, weight: lens }),
            Box::new(Caustic { common, weight: caustic }),
            Box::new(MultiChainPerturbation { common, weight: multi_chain }),
            Box::new(LensSubpath { common, weight: lens_subpath }),
        ];
        Mixture::new(kernels.into())
    }

    fn names(&self) -> &'static [&'static str] {
        &Mutations::NAMES
    }
}
