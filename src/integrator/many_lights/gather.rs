//! Light at a vertex of a camera walk: from the lights of the scene, and from virtual lights.

use super::bounded::BoundedGroups;
use super::limit::{Limit, Limited};
use super::virtual_lights::{VirtualLight, bound_of};
use crate::bsdf::Scattering;
use crate::geometry::RayState;
use crate::integrator::path::{Combined, light_weight};
use crate::light::{Cut, LightCuts, LightSampleContext, LightTree};
use crate::medium::density;
use crate::path::{Scatterer, TraceStats};
use crate::sampling::{Pdf, Sampler, Slot};
use crate::scene::{Edge, EdgeEnd, Scene};
use crate::spectrum::Spectrum;

/// First addresses of the random numbers of lights and of virtual lights, beyond those of all bounces.
const DIRECT: u32 = 1 << 28;
const INDIRECT: u32 = 1 << 29;

/// Largest number of groups in a cut.
pub const MOST_GROUPS: u32 = 1 << 12;

/// Returns the address of the random numbers of sample `k` at vertex number `bounce`.
fn address(first: u32, bounce: u32, k: usize) -> u32 {
    first + bounce * MOST_GROUPS + k as u32
}

/// From which virtual lights a vertex gathers.
pub(super) enum Indirect {
    /// From all.
    All,
    /// From one of each group of a cut of this size through their tree.
    Cut(usize, Option<LightTree>),
    /// From one of each group of a cut with a bounded error. Points on the lights of the scene are among them.
    Bounded(Option<BoundedGroups>),
}

/// The gathering of light.
pub(super) struct Gather<'p, 'a> {
    pub(super) scene: &'a Scene,
    pub(super) lights: &'p LightCuts,
    pub(super) virtual_lights: &'p [VirtualLight<'a>],
    pub(super) indirect: Indirect,
    pub(super) limit: Limit,
}

/// A vertex of a camera walk that gathers light.
pub(super) struct Receiver<'v, 's> {
    pub(super) scatterer: &'v Scatterer<'s>,
    /// The same for the selection of lights.
    pub(super) context: LightSampleContext,
    /// State in which the walk arrived.
    pub(super) state: RayState,
    /// See [`RandomWalk::lanes`](crate::path::RandomWalk::lanes).
    pub(super) lanes: Spectrum,
    /// Number of the vertex.
    pub(super) bounce: u32,
    /// Number of scattering events that a path may have beyond this vertex.
    pub(super) events_left: u32,
}

impl Receiver<'_, '_> {
    fn edge(&self, scene: &Scene, wi: glam::Vec3, end: EdgeEnd) -> Edge {
        match self.scatterer {
            Scatterer::Surface(shading) => Edge::new(scene, shading.point, self.state, wi, end),
            Scatterer::Medium(phase) => phase.edge_to(wi, end),
        }
    }
}

impl Gather<'_, '_> {
    /// Returns the number of groups in the cut through the lights of the scene.
    fn direct_size(&self) -> usize {
        match self.indirect {
            Indirect::All | Indirect::Bounded(_) => 1,
            Indirect::Cut(size, _) => size,
        }
    }

    /// Returns the weighted direct light at `at`, and the cut that was sampled.
    pub(super) fn direct(&self, at: &Receiver, sampler: &mut impl Sampler, tally: &mut TraceStats) -> (Spectrum, Cut) {
        let receiver = at.context;
        let cut = tally.selection.time(|| self.lights.cut(&receiver, self.direct_size()));
        tally.selection.cut(cut.len());
        let mut sum = Spectrum::ZERO;
        for k in 0..self.lights.len(&cut) {
            let address = address(DIRECT, at.bounce, k);
            let u = f64::from(sampler.u1(address, Slot::LightPick));
            let (light, pmf) = tally.selection.time(|| self.lights.sample(&cut, k, &receiver, u));
            let u = sampler.u2(address, Slot::LightPoint);
            let Some(sample) = &self.scene.lights().all()[light].sample_li(&receiver, u) else { continue };
            let Some(mut scattering) = at.scatterer.scattering(sample.wi) else { continue };
            let edge = at.edge(self.scene, sample.wi, EdgeEnd::Light(sample.end));
            let clear = self.scene.clearance(&edge, &mut tally.shadows);
            let chance = Pdf::new(density(at.lanes * clear.flight, Spectrum::ONE));
            scattering.pdf = scattering.pdf.choose(chance);
            let weight = light_weight::<Combined>(&scattering, sample, Pdf::new(pmf as f32));
            sum += scattering.f_cos * sample.radiance * clear.through * weight;
        }
        (sum, cut)
    }

    /// Returns the light at `at` from virtual lights.
    pub(super) fn indirect(&self, at: &Receiver, sampler: &mut impl Sampler, tally: &mut TraceStats) -> Limited {
        match &self.indirect {
            Indirect::All => {
                let from = |light| self.contribution(light, at, tally);
                self.virtual_lights.iter().map(from).fold(Limited::ZERO, |sum, light| sum.plus(light, 1.0))
            }
            Indirect::Cut(size, tree) => {
                tree.as_ref().map_or(Limited::ZERO, |tree| self.by_cut(tree, *size, at, sampler, tally))
            }
            Indirect::Bounded(groups) => {
                let Some(groups) = groups else { return Limited::ZERO };
                let receiver = (at.context, bound_of(at.scatterer));
                groups.gather(self.virtual_lights, &receiver, self.limit.most, |light| {
                    self.contribution(&self.virtual_lights[light], at, tally)
                })
            }
        }
    }

    /// Returns the light at `at` from one virtual light of each group of a cut of `size` groups.
    fn by_cut(
        &self,
        tree: &LightTree,
        size: usize,
        at: &Receiver,
        sampler: &mut impl Sampler,
        tally: &mut TraceStats,
    ) -> Limited {
        let receiver = at.context;
        let cut = tally.selection.time(|| tree.cut(&receiver, size));
        tally.selection.cut(cut.len());
        let mut sum = Limited::ZERO;
        for k in 0..cut.len() {
            let address = address(INDIRECT, at.bounce, k);
            let u = f64::from(sampler.u1(address, Slot::LightPick));
            let (light, pmf) = tally.selection.time(|| tree.sample_group(&cut, k, &receiver, u));
            let light = self.contribution(&self.virtual_lights[light as usize], at, tally);
            sum = sum.plus(light, pmf.recip() as f32);
        }
        sum
    }

    /// Returns what `light` contributes to `at`.
    pub(super) fn contribution(&self, light: &VirtualLight, at: &Receiver, tally: &mut TraceStats) -> Limited {
        if light.events > at.events_left {
            return Limited::ZERO;
        }
        let receiver = at.context;
        let to = light.p - receiver.p;
        let d2 = to.length_squared();
        let wi = to / d2.sqrt();
        let Some(Scattering { f_cos, .. }) = at.scatterer.scattering(wi).filter(|_| d2 > 0.0) else {
            return Limited::ZERO;
        };
        let Some(leaving) = light.leaving(-wi, &receiver) else { return Limited::ZERO };
        let share = self.limit.share(f_cos, light.cos(wi), d2, light.peak);
        let edge = at.edge(self.scene, wi, EdgeEnd::Light(light.end));
        let through = self.scene.transmittance(&edge, &mut tally.shadows);
        let whole = f_cos * leaving * light.flux * through / d2;
        Limited { light: whole * share, excess: whole * (1.0 - share) }
    }
}
