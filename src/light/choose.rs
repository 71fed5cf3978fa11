//! Which light to sample: by power.

use super::{Light, Receiver};
use crate::sampling::{Discrete, Distribution, Pdf};

/// All lights of a scene, and the choice among them.
#[derive(Debug, Default)]
pub struct Lights {
    lights: Vec<Light>,
    by_power: Option<Distribution>,
    sky: Option<usize>,
}

impl Lights {
    /// The choice among `lights` of a scene with bounding radius `radius`. Lights without power are never chosen.
    pub fn new(lights: Vec<Light>, radius: f32) -> Self {
        let by_power = Distribution::new(lights.iter().map(|l| l.power(radius)));
        let sky = lights.iter().position(|l| matches!(l, Light::Sky(_)));
        Lights { lights, by_power, sky }
    }

    /// Every light, in the order they were given.
    pub fn all(&self) -> &[Light] {
        &self.lights
    }

    /// Index of the uniform environment, if there is one.
    #[inline]
    pub fn sky(&self) -> Option<usize> {
        self.sky
    }

    /// A light for the point `at`, and the probability of having chosen it; `None` if there is no light.
    #[inline]
    pub fn choose(&self, _at: &Receiver, u: f32) -> Option<(&Light, Pdf<Discrete>)> {
        let (i, pmf) = self.by_power.as_ref()?.sample(u);
        Some((&self.lights[i], pmf))
    }

    /// The probability that [`Lights::choose`] takes light `i` for the point `at`.
    #[inline]
    pub fn pmf(&self, _at: &Receiver, i: usize) -> Pdf<Discrete> {
        self.by_power.as_ref().map_or(Pdf::new(0.0), |d| d.pmf(i))
    }
}
