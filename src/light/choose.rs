//! Selection of lights: by power, with a uniform floor.

use super::{EmitterPoint, Environment, Light, LightSampleContext};
use crate::sampling::{Discrete, Distribution, Pdf};
use etendue_lanes::Float;
use glam::Vec3;

/// Uniform share of the selection among lights with nonzero power. It keeps a nearby weak lamp sampled beside a strong
/// one, and above rounding in the table.
const FLOOR: f64 = 0.05;

/// All lights of a scene, with their selection probabilities.
#[derive(Debug, Default)]
pub struct Lights {
    lights: Vec<Light>,
    by_power: Option<Distribution>,
    environment: Option<usize>,
}

impl Lights {
    /// Creates the distribution over `lights` of a scene with bounding radius `radius`. Lights without power are never
    /// chosen.
    pub fn new(lights: Vec<Light>, radius: f32) -> Self {
        let powers: Vec<f64> = lights.iter().map(|l| l.power(radius)).collect();
        let shining = powers.iter().filter(|&&p| p > 0.0).count();
        let floor = FLOOR * powers.iter().sum::<f64>() / shining.max(1) as f64;
        let by_power = Distribution::new(powers.iter().map(|&p| if p > 0.0 { p + floor } else { 0.0 }));
        let environment = lights.iter().position(|l| matches!(l, Light::Environment(_)));
        Lights { lights, by_power, environment }
    }

    /// Returns all lights in their original order.
    pub fn all(&self) -> &[Light] {
        &self.lights
    }

    /// Returns the environment light and its index; `None` if there is none.
    #[inline]
    pub fn environment(&self) -> Option<(usize, &Environment)> {
        let index = self.environment?;
        let Light::Environment(environment) = &self.lights[index] else { return None };
        Some((index, environment))
    }

    /// Selects a light for the receiver `at`. Returns its index and selection probability; `None` if there is no light.
    #[inline]
    pub fn choose(&self, _at: &LightSampleContext, u: f32) -> Option<(usize, Pdf<Discrete>)> {
        Some(self.by_power.as_ref()?.sample(u))
    }

    /// Does [`Lights::choose`] in every lane.
    #[inline(always)]
    pub fn choose_lanes<F: Float>(&self, u: F) -> Option<(F::Int, F)> {
        Some(self.by_power.as_ref()?.sample_lanes(u))
    }

    /// Selects a light for emission. Returns its index and selection probability; `None` if there is no light.
    #[inline]
    pub fn choose_emitter(&self, u: f32) -> Option<(usize, Pdf<Discrete>)> {
        Some(self.by_power.as_ref()?.sample(u))
    }

    /// Returns the probability that [`Lights::choose_emitter`] selects light `i`.
    #[inline]
    pub fn emitter_pmf(&self, i: usize) -> Pdf<Discrete> {
        self.by_power.as_ref().map_or(Pdf::new(0.0), |d| d.pmf(i))
    }

    /// Returns the density with which a light sample for the receiver `at` is the endpoint `end` of light `i` in the
    /// direction `wi`, including the selection of the light. `position` is the endpoint's
    /// [`LePdf::position`](super::LePdf::position).
    #[inline]
    pub fn end_pdf_li(&self, at: &LightSampleContext, i: usize, end: &EmitterPoint, wi: Vec3, position: f64) -> f64 {
        f64::from(self.pmf(at, i).value()) * position * self.lights[i].end_pdf_ratio(at, end, wi)
    }

    /// Returns the probability that [`Lights::choose`] selects light `i` for the receiver `at`.
    #[inline]
    pub fn pmf(&self, _at: &LightSampleContext, i: usize) -> Pdf<Discrete> {
        self.by_power.as_ref().map_or(Pdf::new(0.0), |d| d.pmf(i))
    }

    /// Does [`Lights::pmf`] in every lane.
    #[inline(always)]
    pub fn pmf_lanes<F: Float>(&self, i: usize) -> F {
        F::splat(self.emitter_pmf(i).value())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::light::PointLight;
    use crate::spectrum::Spectrum;
    use glam::Vec3;

    fn lamps(intensities: &[f32]) -> Lights {
        let lamp = |&i: &f32| Light::Point(PointLight { position: Vec3::ZERO, intensity: Spectrum::splat(i) });
        Lights::new(intensities.iter().map(lamp).collect(), 1.0)
    }

    #[test]
    fn weak_lights_keep_a_probability_and_dark_ones_none() {
        let at = LightSampleContext { p: Vec3::ZERO, ng: Vec3::Z };
        let lights = lamps(&[1e6, 1e-6, 0.0]);
        let pmf: Vec<f32> = (0..3).map(|i| lights.pmf(&at, i).value()).collect();
        assert!(pmf[0] > 0.9 && pmf[1] > 0.02, "{pmf:?}");
        assert_eq!(pmf[2], 0.0);
        assert!((pmf.iter().sum::<f32>() - 1.0).abs() <= f32::EPSILON);
        assert!(lamps(&[0.0]).choose(&at, 0.5).is_none());
    }
}
