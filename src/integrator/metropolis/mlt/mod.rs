//! Metropolis light transport in path space: chains of paths that mutations change, with the density of every change written down by
//! the explicit evaluator [Veach97 §11.4].
//!
//! Densities are in the product area measure of [`crate::path::notation`], in which a chain of Dirac vertices leaves the same factor out of
//! f and of all densities. Acceptances are of f(x̄) and of densities that are functions of the two paths, whatever made them: a
//! mutation that makes a path in several ways sums over them. Blended surfaces are not known to it.

mod bidirectional;
mod caustic;
mod extend;
mod eye;
mod lens_subpath;
mod seed;
mod state;

use super::seeds::Candidate;
use super::{Chains, Common, Mutations};
use crate::mcmc::{Kernel, Mixture};
use crate::path::Tally;
use crate::sampling::Address;
use bidirectional::Bidirectional;
use caustic::Caustic;
use eye::Eye;
use lens_subpath::LensSubpath;
use state::PathState;

/// The chains.
pub(super) struct PathSpace<'a> {
    pub(super) common: Common<'a>,
}

impl<'a> Chains for PathSpace<'a> {
    type State = PathState<'a>;

    fn common(&self) -> &Common<'_> {
        &self.common
    }

    fn classes(&self) -> usize {
        1
    }

    fn class_of(&self, _: usize) -> usize {
        0
    }

    fn candidates(&self, address: Address, found: &mut Vec<Candidate>, tally: &mut Tally) {
        Candidate::of_techniques(&self.common, address, found, tally);
    }

    fn start(&self, seed: &Candidate, address: Address, x: &mut PathState<'a>) -> bool {
        let path = seed::path(&self.common, [seed.s, seed.t].map(usize::from), address, &mut x.tally);
        path.is_some_and(|draft| x.set(&self.common, draft).is_some())
    }

    fn kernels(&self, _: usize) -> Mixture<'_, PathState<'a>> {
        let (common, Mutations { bidirectional, lens, caustic, multi_chain, lens_subpath }) =
            (&self.common, self.common.options.metropolis.mutations);
        let kernels: [Box<dyn Kernel<PathState<'a>> + Sync + '_>; 5] = [
            Box::new(Bidirectional::new(common, bidirectional)),
            Box::new(Eye::lens(common, lens)),
            Box::new(Caustic { common, weight: caustic }),
            Box::new(Eye::multi_chain(common, multi_chain)),
            Box::new(LensSubpath { common, weight: lens_subpath }),
        ];
        Mixture::new(kernels.into())
    }

    fn names(&self) -> &'static [&'static str] {
        &Mutations::NAMES
    }
}
