//! Selection of lights for a receiver: by the light tree, and beside it the lights at infinity. A small share of the
//! selection is uniform: a weak lamp in a room stays sampled beside strong ones behind its walls, which the tree does
//! not know.

use super::tree::{BELOW_ONE_F64, Descent};
use super::{Light, LightSampleContext, LightTree, Reach};
use etendue_lanes::{MOST_LANES, for_each_bit};

/// Share of the selection that is uniform among the lights that shine.
const UNIFORM: f64 = 0.02;

/// Least share of the lights with a place, and of those at infinity, where both exist: the tree does not know what
/// stands before a light.
const LEAST_SHARE: f64 = 0.1;

/// Importance of a light at infinity that grazes the receiver, as a share of the greatest.
const GRAZING: f32 = 1e-3;

/// The lights of a scene, ordered for receivers.
#[derive(Debug)]
pub(super) struct ByReceiver {
    tree: Option<LightTree>,
    /// Sum of the intensities in the tree.
    unit: f64,
    distant: Vec<Distant>,
    /// All of both kinds.
    shining: Vec<u32>,
}

/// The selection of a light.
enum Begun {
    /// In the tree.
    InTree(Descent),
    /// A light, with its probability.
    Selected(u32, f64),
}

/// A light at infinity.
#[derive(Debug)]
struct Distant {
    light: u32,
    irradiance: f64,
    /// Where it comes from, if from one direction.
    toward: Option<glam::Vec3>,
}

impl ByReceiver {
    /// Returns the selection of `lights`; `None` without a light that shines.
    pub(super) fn new(lights: &[Light]) -> Option<Self> {
        let reaches: Vec<Option<Reach>> = lights.iter().map(Light::reach).collect();
        let unit = reaches.iter().flatten().map(|reach| reach.intensity).sum();
        let distant = lights.iter().enumerate().filter_map(|(i, light)| {
            let toward = if let Light::Directional(light) = light { Some(light.toward) } else { None };
            let irradiance = light.distant_irradiance().filter(|&irradiance| irradiance > 0.0)?;
            Some(Distant { light: i as u32, irradiance, toward })
        });
        let (tree, distant) = (LightTree::new(&reaches), distant.collect::<Vec<_>>());
        let near =
            reaches.iter().zip(0..).filter(|(reach, _)| tree.is_some() && reach.is_some()).map(|(_, light)| light);
        let shining: Vec<u32> = near.chain(distant.iter().map(|light| light.light)).collect();
        (!shining.is_empty()).then_some(ByReceiver { tree, unit, distant, shining })
    }

    /// Returns the memory in bytes.
    pub(super) fn bytes(&self) -> usize {
        self.tree.as_ref().map_or(0, LightTree::bytes) + size_of_val(&*self.shining)
    }

    /// Selects lights for the receivers `at` in the given `lanes` by numbers `u` in [0, 1). Calls `found` with each lane,
    /// its light and its probability. The receivers go down the tree side by side, so that waiting times of different
    /// ones overlap.
    #[inline]
    pub(super) fn sample_all(
        &self,
        lanes: u32,
        at: &[LightSampleContext; MOST_LANES],
        u: &[f64; MOST_LANES],
        mut found: impl FnMut(usize, u32, f64),
    ) {
        let mut descents = [Descent::new(0.0, 0.0); MOST_LANES];
        let mut active = 0;
        for_each_bit(lanes, |lane| match self.begin(&at[lane], u[lane]) {
            Begun::InTree(descent) => {
                descents[lane] = descent;
                active |= 1 << lane;
            }
            Begun::Selected(light, pmf) => found(lane, light, pmf),
        });
        let Some(tree) = &self.tree else { return };
        while active != 0 {
            let mut rest = active;
            for_each_bit(active, |lane| {
                let descent = &mut descents[lane];
                tree.step(&at[lane], descent);
                if let Some(light) = descent.light() {
                    found(lane, light, self.with_uniform(descent.pmf));
                    rest &= !(1 << lane);
                }
            });
            active = rest;
        }
    }

    /// Returns the probability of a light that is selected for the receiver with probability `pmf`, where the selection
    /// is not uniform.
    #[inline]
    fn with_uniform(&self, pmf: f64) -> f64 {
        UNIFORM / self.shining.len() as f64 + (1.0 - UNIFORM) * pmf
    }

    /// Selects between the tree, the lights at infinity, and all of them.
    #[inline]
    fn begin(&self, at: &LightSampleContext, u: f64) -> Begun {
        if u < UNIFORM {
            let count = self.shining.len();
            let light = self.shining[((u / UNIFORM * count as f64) as usize).min(count - 1)];
            return Begun::Selected(light, self.pmf(at, light as usize));
        }
        let u = ((u - UNIFORM) / (1.0 - UNIFORM)).min(BELOW_ONE_F64);
        let (near, distant) = self.shares(at);
        if u < near {
            return Begun::InTree(Descent::new(u / near, near));
        }
        let mut rest = (u - near) / (1.0 - near) * distant;
        let pmf = |light: &Distant| (1.0 - near) * (light.importance(at) / distant);
        let last = self.distant.len().saturating_sub(1);
        let chosen = self.distant.iter().enumerate().find(|(i, light)| {
            rest -= light.importance(at);
            rest < 0.0 || *i == last
        });
        chosen.map_or(Begun::Selected(0, 0.0), |(_, light)| Begun::Selected(light.light, self.with_uniform(pmf(light))))
    }

    /// Returns the probability that [`ByReceiver::sample_all`] selects light `i` for the receiver `at`.
    #[inline]
    pub(super) fn pmf(&self, at: &LightSampleContext, i: usize) -> f64 {
        let (near, distant) = self.shares(at);
        let selected = match (self.distant.iter().find(|light| light.light as usize == i), &self.tree) {
            (Some(light), _) => (1.0 - near) * (light.importance(at) / distant),
            (None, Some(tree)) if tree.has(i) => tree.pmf(at, i, near),
            (None, _) => return 0.0,
        };
        self.with_uniform(selected)
    }

    /// Returns the share of the lights with a place, and the sum of the importance of the others.
    #[inline]
    fn shares(&self, at: &LightSampleContext) -> (f64, f64) {
        let Some(tree) = &self.tree else { return (0.0, self.sum(at)) };
        if self.distant.is_empty() {
            return (1.0, 0.0);
        }
        let (near, distant) = (tree.importance(at) * self.unit, self.sum(at));
        if near <= 0.0 {
            return (0.0, distant);
        }
        ((near / (near + distant)).clamp(LEAST_SHARE, 1.0 - LEAST_SHARE), distant)
    }

    fn sum(&self, at: &LightSampleContext) -> f64 {
        self.distant.iter().map(|light| light.importance(at)).sum()
    }
}

impl Distant {
    /// Returns an estimate of what the receiver scatters of its light, of its irradiance if nothing is known of that.
    #[inline]
    fn importance(&self, at: &LightSampleContext) -> f64 {
        let outline = &at.scattering;
        let Some(toward) = self.toward else { return self.irradiance * f64::from(outline.diffuse + outline.glossy) };
        let cos = if at.ng == glam::Vec3::ZERO { 1.0 } else { toward.dot(at.ng).abs() };
        let mut scattered = outline.diffuse * cos;
        if outline.glossy > 0.0 {
            scattered += outline.glossy * outline.reflected(toward.into(), 0.0f32);
        }
        self.irradiance * f64::from(scattered.max(GRAZING))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::light::{ConstantEnvironment, DirectionalLight, Environment, PointLight};
    use crate::sampling::lanes::uniform_sphere;
    use crate::sampling::{Address, IndependentSampler, Sampler, Slot};
    use crate::spectrum::Spectrum;
    use glam::Vec3;

    fn lights(near: usize, suns: usize, sky: bool) -> Vec<Light> {
        let point =
            |i| PointLight { position: Vec3::new(i as f32, 1.0, 0.5), intensity: Spectrum::splat(1.0 + i as f32) };
        let sun = |i| DirectionalLight {
            toward: Vec3::new(i as f32, 1.0, 0.0).normalize(),
            irradiance: Spectrum::splat(0.5 + i as f32),
        };
        let sky =
            sky.then(|| Light::Environment(Environment::Uniform(ConstantEnvironment { radiance: Spectrum::ONE })));
        let near = (0..near).map(|i| Light::Point(point(i)));
        near.chain((0..suns).map(|i| Light::Directional(sun(i)))).chain(sky).collect()
    }

    /// Probabilities of every mixture of lights sum to 1, and a light is selected with the bits of its probability.
    #[test]
    fn lights_with_a_place_and_at_infinity_share_the_selection() {
        let mut sampler = IndependentSampler::new(Address::new(7));
        for (near, suns, sky) in
            [(0, 1, false), (0, 3, true), (1, 0, true), (20, 2, true), (20, 0, false), (20, 5, false)]
        {
            let lights = lights(near, suns, sky);
            let choice = ByReceiver::new(&lights).expect("lights");
            let mut seen = vec![false; lights.len()];
            for i in 0..500 {
                let p: Vec3 = uniform_sphere(sampler.u2(i, Slot::Film)).into();
                let ng = if i % 7 == 0 { Vec3::ZERO } else { uniform_sphere(sampler.u2(i, Slot::Lens)).into() };
                let at = LightSampleContext::new(p * 3.0, ng);
                let sum: f64 = (0..lights.len()).map(|light| choice.pmf(&at, light)).sum();
                // Rounding of a few dozen sums of numbers below 1.
                assert!((sum - 1.0).abs() < 1e-12, "{near} {suns} {sky}: {sum}");
                // No light vanishes beside others.
                let least = 0.999 * UNIFORM / lights.len() as f64;
                assert!((0..lights.len()).all(|light| choice.pmf(&at, light) >= least), "{near} {suns} {sky}");
                let found = |_: usize, light: u32, pmf: f64| {
                    seen[light as usize] = true;
                    assert_eq!(pmf.to_bits(), choice.pmf(&at, light as usize).to_bits());
                };
                choice.sample_all(
                    1,
                    &[at; MOST_LANES],
                    &[f64::from(sampler.u1(i, Slot::LightPick)); MOST_LANES],
                    found,
                );
            }
            assert!(seen.iter().filter(|seen| **seen).count() * 2 > lights.len(), "{seen:?}");
        }
    }
}
