//! Selection of lights: by what they contribute to a receiver, or by power with a uniform floor.

use super::by_receiver::ByReceiver;
use super::{EmitterPoint, Environment, Light, LightSampleContext};
use crate::sampling::{Discrete, Distribution, Pdf, mix64};
use crate::transport::ScatteringOutline;
use etendue_lanes::{Float, Int, MOST_LANES, Mask, for_each_bit};
use glam::Vec3;

/// Uniform share of the selection among lights with nonzero power. It keeps a nearby weak lamp sampled beside a strong
/// one, and above rounding in the table.
const FLOOR: f64 = 0.05;

/// How a light is selected for a receiver.
#[derive(
    Debug,
    Clone,
    Copy,
    PartialEq,
    Eq,
    Default,
    serde::Serialize,
    serde::Deserialize,
    strum::VariantArray,
    strum::IntoStaticStr,
    strum::EnumMessage,
)]
#[serde(rename_all = "kebab-case")]
#[strum(serialize_all = "kebab-case")]
pub enum LightChoice {
    /// By the light tree if there are more than a few lights, else by power.
    #[default]
    Auto,
    /// By the light tree: distance, orientation and power.
    Tree,
    /// By power.
    Power,
    /// Equally often.
    Uniform,
}

/// All lights of a scene, with their selection probabilities.
#[derive(Debug, Default)]
pub struct Lights {
    lights: Vec<Light>,
    by_power: Option<Distribution>,
    by_receiver: Option<ByReceiver>,
    environment: Option<usize>,
}

/// A light that was selected for a receiver.
#[derive(Debug, Clone, Copy)]
pub struct ChosenLight {
    /// Its index.
    pub index: usize,
    /// The probability of its selection.
    pub pmf: Pdf<Discrete>,
    /// Random numbers for [`Light::sample_li`].
    pub u: [f32; 2],
}

/// A [`LightSampleContext`] in each lane.
pub struct Receivers<'o, F: Float> {
    /// Positions.
    pub p: etendue_lanes::Vec3<F>,
    /// Geometric normals.
    pub ng: etendue_lanes::Vec3<F>,
    /// How they scatter, if known.
    pub outlines: Option<&'o [ScatteringOutline; MOST_LANES]>,
}

impl Lights {
    /// Creates the distributions over `lights` of a scene with bounding radius `radius`. Lights without power are never
    /// chosen.
    pub fn new(lights: Vec<Light>, radius: f32, choice: LightChoice) -> Self {
        let powers: Vec<f64> = lights.iter().map(|l| l.power(radius)).collect();
        let shining = powers.iter().filter(|&&p| p > 0.0).count();
        let floor = FLOOR * powers.iter().sum::<f64>() / shining.max(1) as f64;
        let weight = |&p: &f64| match choice {
            _ if p <= 0.0 => 0.0,
            LightChoice::Uniform => 1.0,
            LightChoice::Auto | LightChoice::Tree | LightChoice::Power => p + floor,
        };
        let by_power = Distribution::new(powers.iter().map(weight));
        let is_short = by_power.as_ref().is_none_or(Distribution::is_short);
        let by_receiver = match choice {
            LightChoice::Tree => ByReceiver::new(&lights),
            LightChoice::Auto if !is_short => ByReceiver::new(&lights),
            LightChoice::Auto | LightChoice::Power | LightChoice::Uniform => None,
        };
        let environment = lights.iter().position(|l| matches!(l, Light::Environment(_)));
        Lights { lights, by_power, by_receiver, environment }
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

    /// Selects a light for the receiver `at` with the random numbers of [`Slot::LightPoint`] and [`Slot::LightPick`];
    /// `None` if there is no light.
    ///
    /// Of few lights the first number of the point also selects one, and the other number is not drawn. All lights are
    /// then stratified together: relMSE on the Cornell box falls by 2 to 3 %.
    ///
    /// [`Slot::LightPoint`]: crate::sampling::Slot::LightPoint
    /// [`Slot::LightPick`]: crate::sampling::Slot::LightPick
    #[inline]
    pub fn choose(&self, at: &LightSampleContext, point: [f32; 2], pick: impl FnOnce() -> f32) -> Option<ChosenLight> {
        let [p, ng] = [at.p, at.ng].map(etendue_lanes::Vec3::from);
        let outlines = self.is_by_receiver().then_some([at.scattering; MOST_LANES]);
        let at = Receivers { p, ng, outlines: outlines.as_ref() };
        let (index, pmf, u) = self.choose_lanes::<f32>(&at, true, point, pick)?;
        (pmf > 0.0).then_some(ChosenLight { index: index as usize, pmf: Pdf::new(pmf), u })
    }

    /// Does [`Lights::choose`] in the `wanted` lanes for the receivers `at`. Returns indices, probabilities, which are 0
    /// where there is no light, and numbers for points.
    #[inline(always)]
    pub fn choose_lanes<F: Float>(
        &self,
        at: &Receivers<F>,
        wanted: F::Mask,
        [u, v]: [F; 2],
        pick: impl FnOnce() -> F,
    ) -> Option<(F::Int, F, [F; 2])> {
        if let Some(by_receiver) = &self.by_receiver {
            let (index, pmf) = each_chosen(by_receiver, at, wanted, [pick(), u, v]);
            return Some((index, pmf, [u, v]));
        }
        let by_power = self.by_power.as_ref()?;
        if by_power.is_short() {
            let (index, pmf, u) = by_power.sample_lanes(u);
            return Some((index, pmf, [u, v]));
        }
        let (index, pmf, _) = by_power.sample_lanes(pick());
        Some((index, pmf, [u, v]))
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
    pub fn pmf(&self, at: &LightSampleContext, i: usize) -> Pdf<Discrete> {
        match &self.by_receiver {
            Some(by_receiver) => Pdf::new(by_receiver.pmf(at, i) as f32),
            None => self.emitter_pmf(i),
        }
    }

    /// Does [`Lights::pmf`] in the `wanted` lanes for the receivers `at`.
    #[inline(always)]
    pub fn pmf_lanes<F: Float>(&self, at: &Receivers<F>, wanted: F::Mask, i: usize) -> F {
        let Some(by_receiver) = &self.by_receiver else { return F::splat(self.emitter_pmf(i).value()) };
        let mut pmf = [0.0; MOST_LANES];
        for_each_bit(wanted.bits(), |lane| pmf[lane] = by_receiver.pmf(&at.lane(lane), i) as f32);
        F::load(&pmf, 0)
    }

    /// Whether the selection depends on the receiver: on its place and normal, and on how it scatters.
    #[inline]
    pub fn is_by_receiver(&self) -> bool {
        self.by_receiver.is_some()
    }

    /// Returns the memory of the light tree in bytes, 0 without one.
    pub fn tree_bytes(&self) -> usize {
        self.by_receiver.as_ref().map_or(0, ByReceiver::bytes)
    }
}

/// Selects a light for each of the `wanted` receivers by the numbers of the selection and of the point.
#[inline(never)]
fn each_chosen<F: Float>(by_receiver: &ByReceiver, at: &Receivers<F>, wanted: F::Mask, numbers: [F; 3]) -> (F::Int, F) {
    let (mut indices, mut pmf) = ([0; MOST_LANES], [0.0; MOST_LANES]);
    let (mut receivers, mut u) = ([LightSampleContext::NOWHERE; MOST_LANES], [0.0; MOST_LANES]);
    for_each_bit(wanted.bits(), |lane| {
        receivers[lane] = at.lane(lane);
        u[lane] = finer(numbers.map(|number| number.lane(lane)));
    });
    let found = |lane: usize, light, probability| (indices[lane], pmf[lane]) = (light, probability as f32);
    by_receiver.sample_all(wanted.bits(), &receivers, &u, found);
    (F::Int::load(&indices, 0), F::load(&pmf, 0))
}

impl<F: Float> Receivers<'_, F> {
    /// Returns the receiver in `lane`.
    #[inline]
    fn lane(&self, lane: usize) -> LightSampleContext {
        let at = LightSampleContext::new(self.p.lane(lane).into(), self.ng.lane(lane).into());
        self.outlines.map_or(at, |outlines| at.scattering(outlines[lane]))
    }
}

/// Returns `u`, of 24 bits, with more bits, which are a hash of the numbers `v` and `w`: a tree of a million lights needs
/// more than 24.
fn finer([u, v, w]: [f32; 3]) -> f64 {
    let rest = mix64(u64::from(v.to_bits()) << 32 | u64::from(w.to_bits()));
    f64::from(u) + (rest >> 40) as f64 * (2.0f64).powi(-48)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::light::PointLight;
    use crate::spectrum::Spectrum;
    use glam::Vec3;

    fn lamps(intensities: &[f32]) -> Lights {
        let lamp = |&i: &f32| Light::Point(PointLight { position: Vec3::ZERO, intensity: Spectrum::splat(i) });
        Lights::new(intensities.iter().map(lamp).collect(), 1.0, LightChoice::Auto)
    }

    #[test]
    fn weak_lights_keep_a_probability_and_dark_ones_none() {
        let at = LightSampleContext::new(Vec3::ZERO, Vec3::Z);
        let lights = lamps(&[1e6, 1e-6, 0.0]);
        let pmf: Vec<f32> = (0..3).map(|i| lights.pmf(&at, i).value()).collect();
        assert!(pmf[0] > 0.9 && pmf[1] > 0.02, "{pmf:?}");
        assert_eq!(pmf[2], 0.0);
        assert!((pmf.iter().sum::<f32>() - 1.0).abs() <= f32::EPSILON);
        assert!(lamps(&[0.0]).choose(&at, [0.5; 2], || 0.5).is_none());
    }
}
