//! Selection of several lights for a receiver: one of each group of a cut through the light tree, and all lights at
//! infinity [Yuksel19].

use super::tree::{Cut, LightTree};
use super::{Light, LightSampleContext, Lights};

/// The lights of a scene, for cuts.
#[derive(Debug)]
pub struct LightCuts {
    tree: Option<LightTree>,
    /// Lights at infinity.
    distant: Vec<usize>,
}

impl LightCuts {
    /// Returns the selection of `lights`.
    pub fn new(lights: &Lights) -> Self {
        let reaches: Vec<_> = lights.all().iter().map(Light::reach).collect();
        let shines = |light: &Light| light.distant_irradiance().is_some_and(|irradiance| irradiance > 0.0);
        let distant = lights.all().iter().enumerate().filter(|(_, light)| shines(light)).map(|(i, _)| i);
        LightCuts { tree: LightTree::new(&reaches), distant: distant.collect() }
    }

    /// Returns the selection of those at infinity.
    pub fn of_distant(lights: &Lights) -> Self {
        LightCuts { tree: None, ..LightCuts::new(lights) }
    }

    /// Returns the cut for the receiver `at` of about `size` groups: see [`LightTree::cut`].
    pub fn cut(&self, at: &LightSampleContext, size: usize) -> Cut {
        self.tree.as_ref().map_or_else(Cut::default, |tree| tree.cut(at, size))
    }

    /// Returns the number of lights to sample for `cut`.
    pub fn len(&self, cut: &Cut) -> usize {
        self.distant.len() + cut.len()
    }

    /// Selects light number `k`, below [`LightCuts::len`], of `cut` by `u` in [0, 1). Returns it with its probability.
    pub fn sample(&self, cut: &Cut, k: usize, at: &LightSampleContext, u: f64) -> (usize, f64) {
        match (self.distant.get(k), &self.tree) {
            (Some(&light), _) => (light, 1.0),
            (None, Some(tree)) => {
                let (light, pmf) = tree.sample_group(cut, k - self.distant.len(), at, u);
                (light as usize, pmf)
            }
            (None, None) => unreachable!("a cut has groups of a tree"),
        }
    }

    /// Returns the probability with which light `i` is among the samples for `cut`.
    pub fn pmf(&self, cut: &Cut, at: &LightSampleContext, i: usize) -> f64 {
        if self.distant.contains(&i) {
            return 1.0;
        }
        self.tree.as_ref().map_or(0.0, |tree| tree.cut_pmf(cut, at, i))
    }
}
