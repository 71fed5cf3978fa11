//! A camera walk that gathers light at its vertices.

use super::gather::{Gather, Indirect, Receiver};
use super::limit::Limited;
use super::virtual_lights::{EMITTING_PEAK, peak, peak_in_medium};
use crate::bsdf::{Lobes, Shading};
use crate::camera::CameraSample;
use crate::geometry::SurfacePoint;
use crate::integrator::IntegratorConfig;
use crate::integrator::camera_pass::Radiance;
use crate::light::{Cut, Light, LightSampleContext};
use crate::medium::{PhaseSample, density};
use crate::path::{FlightEnd, Flown, MediumPoint, PhaseAt, RandomWalk, Scatterer, TraceStats};
use crate::sampling::{Density, Pdf, Sampler, Slot, SolidAngle, power};
use crate::spectrum::Spectrum;
use crate::transport::TransportMode;
use glam::Vec3;

/// First address of the random numbers that decide whether a walk goes on beyond a possible virtual light.
const BEYOND: u32 = 1 << 27;

/// The estimator.
pub(super) struct GatherWalk<'p, 'a> {
    gather: Gather<'p, 'a>,
    max_depth: u32,
    /// Whether the directly visible environment is left out.
    transparent: bool,
}

/// The smooth scattering event with which the current edge began.
struct Departure {
    at: LightSampleContext,
    /// The cut through the lights that was sampled there.
    cut: Cut,
    pdf: Pdf<SolidAngle>,
    f_cos: Spectrum,
}

impl<'p, 'a> GatherWalk<'p, 'a> {
    pub(super) fn new(gather: Gather<'p, 'a>, options: &IntegratorConfig) -> Self {
        GatherWalk { gather, max_depth: options.max_depth.unwrap_or(u32::MAX), transparent: options.transparent }
    }

    /// Returns the MIS weight of emission of light number `light`, hit after `departure`, where `pdf` is the density of
    /// the direction in its light samples and `chance` the probability of getting through media.
    fn mis_weight_bsdf(
        &self,
        departure: Option<&Departure>,
        light: usize,
        pdf: impl FnOnce(&LightSampleContext) -> f32,
        chance: f32,
        tally: &mut TraceStats,
    ) -> f32 {
        let Some(Departure { at, cut, pdf: scattering, .. }) = departure else { return 1.0 };
        let pmf = tally.selection.time(|| self.gather.lights.pmf(cut, at, light)) as f32;
        power(scattering.value() * chance, pmf * pdf(at))
    }

    /// Returns the weighted emission at `point` toward the walk.
    fn emitted(
        &self,
        walk: &RandomWalk,
        departure: Option<&Departure>,
        point: &SurfacePoint,
        chance: f32,
        tally: &mut TraceStats,
    ) -> Spectrum {
        let Some((index, Light::Area(light))) = self.gather.scene.light_at(point) else { return Spectrum::ZERO };
        let wi = walk.ray.direction;
        let radiance = light.radiance(point.barycentric, -wi);
        if radiance.is_black() || !walk.sees(light) {
            return Spectrum::ZERO;
        }
        let pdf = |from: &LightSampleContext| light.pdf_li(from.p, point.p, wi).value();
        let weight = match departure {
            Some(departure) if matches!(self.gather.indirect, Indirect::Bounded(_)) => {
                self.walk_share(departure, point.p, point.cos(wi), EMITTING_PEAK)
            }
            _ => self.mis_weight_bsdf(departure, index, pdf, chance, tally),
        };
        walk.beta * radiance * weight
    }

    /// Returns the weighted radiance of the environment.
    fn background(
        &self,
        walk: &RandomWalk,
        departure: Option<&Departure>,
        chance: f32,
        tally: &mut TraceStats,
    ) -> Spectrum {
        let Some((index, environment)) = self.gather.scene.lights().environment() else { return Spectrum::ZERO };
        if self.transparent && walk.depth == 0 {
            return Spectrum::ZERO;
        }
        let (radiance, pdf) = environment.along(walk.ray.direction);
        walk.beta * radiance * self.mis_weight_bsdf(departure, index, |_| pdf.value(), chance, tally)
    }

    /// Returns whether the walk has a share in the paths that scatter smoothly by `scatterer` at `p`, where the edge from
    /// `departure` ends: virtual lights there have the other share.
    fn goes_beyond(
        &self,
        departure: Option<&Departure>,
        walk: &RandomWalk,
        (p, scatterer): (Vec3, &Scatterer),
        sampler: &mut impl Sampler,
    ) -> bool {
        let Some(departure) = departure else { return true };
        let (cos, peak) = match scatterer {
            Scatterer::Surface(shading) => (shading.point.cos(walk.ray.direction), peak(shading.surface)),
            Scatterer::Medium(phase) => (1.0, peak_in_medium(phase.phase())),
        };
        let share = self.walk_share(departure, p, cos, peak);
        share > 0.0 && sampler.u1(BEYOND + walk.bounce, Slot::Roulette) < share
    }

    /// Returns the share of the walk in paths with an edge from `departure` to `p`, where a virtual light of this cosine
    /// and `peak` has the rest.
    fn walk_share(&self, departure: &Departure, p: Vec3, cos: f32, peak: f32) -> f32 {
        let (limit, d2) = (&self.gather.limit, p.distance_squared(departure.at.p));
        let share = limit.share(departure.f_cos, cos, d2, peak);
        if limit.is_compensated { 1.0 - share } else { 0.0 }
    }
}

/// How a walk goes on: with the smooth event at which it has departed or after a Dirac one; `None` if it ends.
type Onward = Option<Option<Departure>>;

impl GatherWalk<'_, '_> {
    /// Gathers light at the surface `point` and leaves it. Returns the light, and how the walk goes on.
    fn at_surface(
        &self,
        walk: &mut RandomWalk,
        point: &mut SurfacePoint,
        departure: Option<&Departure>,
        sampler: &mut impl Sampler,
        tally: &mut TraceStats,
    ) -> (Spectrum, Onward) {
        let surface = self.gather.scene.surface(point, walk.ray.state.bodies);
        let wo = -walk.ray.direction;
        let Some(shading) = Shading::new(point, &surface, wo, TransportMode::Radiance) else {
            return (Spectrum::ZERO, None);
        };
        let (context, is_smooth) = (LightSampleContext::from(&shading), shading.lobes().intersects(Lobes::SMOOTH));
        let gathered = if is_smooth {
            self.gathered(walk, (point.p, &Scatterer::Surface(shading)), context, departure, sampler, tally)
        } else {
            None
        };
        let light = gathered.as_ref().map_or(Spectrum::ZERO, |(light, _)| *light);
        let Some(scatter) = shading.sample(walk.scattering_numbers(&surface, sampler)) else { return (light, None) };
        let next = match (scatter.density, gathered) {
            (Density::Delta(_), _) => None,
            (Density::Smooth(_), None) => return (light, None),
            (Density::Smooth(pdf), Some((_, cut))) => {
                Some(Departure { at: context, cut, pdf, f_cos: scatter.weight * pdf.value() })
            }
        };
        walk.depart(point, context, &scatter);
        (light, Some(next))
    }

    /// Does [`GatherWalk::at_surface`] at a collision in a medium.
    fn at_medium(
        &self,
        walk: &mut RandomWalk,
        point: &MediumPoint,
        departure: Option<&Departure>,
        sampler: &mut impl Sampler,
        tally: &mut TraceStats,
    ) -> (Spectrum, Onward) {
        let (phase, context) = (PhaseAt::new(point, -walk.ray.direction), LightSampleContext::from(point));
        let at = (point.p, &Scatterer::Medium(phase));
        let Some((light, cut)) = self.gathered(walk, at, context, departure, sampler, tally) else {
            return (Spectrum::ZERO, None);
        };
        let PhaseSample { direction, pdf } = phase.sample(sampler.u2(walk.bounce, Slot::Direction));
        walk.scatter_in_medium(point, direction, Density::Smooth(pdf));
        (light, Some(Some(Departure { at: context, cut, pdf, f_cos: Spectrum::splat(pdf.value()) })))
    }

    /// Returns the light that is gathered at a place that scatters smoothly, weighted by the walk, and the cut that was
    /// sampled; `None` if virtual lights have the paths beyond it.
    fn gathered(
        &self,
        walk: &RandomWalk,
        at: (Vec3, &Scatterer),
        context: LightSampleContext,
        departure: Option<&Departure>,
        sampler: &mut impl Sampler,
        tally: &mut TraceStats,
    ) -> Option<(Spectrum, Cut)> {
        if !self.goes_beyond(departure, walk, at, sampler) {
            return None;
        }
        let (scatterer, state, lanes) = (at.1, walk.ray.state, walk.lanes);
        let events_left = self.max_depth - walk.depth - 1;
        let receiver = Receiver { scatterer, context, state, lanes, bounce: walk.bounce, events_left };
        let (direct, cut) = self.gather.direct(&receiver, sampler, tally);
        let Limited { light, excess } = self.gather.indirect(&receiver, sampler, tally);
        if !self.gather.limit.is_compensated {
            tally.limited(walk.beta * excess);
        }
        Some((walk.beta * (direct + light), cut))
    }
}

impl Radiance for GatherWalk<'_, '_> {
    fn radiance<S: Sampler>(
        &self,
        camera: &CameraSample,
        sampler: &mut S,
        _: impl FnOnce() -> S,
        _: &mut impl FnMut([f32; 2], Spectrum),
        tally: &mut TraceStats,
    ) -> Spectrum {
        let scene = self.gather.scene;
        let mut walk = RandomWalk::from_camera(scene, camera);
        let mut total = Spectrum::ZERO;
        let mut departure: Option<Departure> = None;
        loop {
            let lanes = walk.lanes;
            let (end, through) = if scene.features().flights() {
                let Flown { end, through, .. } = walk.fly(sampler, tally);
                (end, through)
            } else {
                (walk.arrive(sampler, tally).map(FlightEnd::Surface), Spectrum::ONE)
            };
            let chance = density(lanes * through, Spectrum::ONE);
            let Some(mut end) = end else {
                return total + self.background(&walk, departure.as_ref(), chance, tally);
            };
            if let FlightEnd::Surface(point) = &end {
                total += self.emitted(&walk, departure.as_ref(), point, chance, tally);
            }
            if walk.depth >= self.max_depth {
                return total;
            }
            let gathered = match &mut end {
                FlightEnd::Surface(point) => self.at_surface(&mut walk, point, departure.as_ref(), sampler, tally),
                FlightEnd::Medium(point) => self.at_medium(&mut walk, point, departure.as_ref(), sampler, tally),
            };
            let (light, next) = gathered;
            total += light;
            match next {
                Some(next) => departure = next,
                None => return total,
            }
            if !walk.survives(sampler, tally) {
                return total;
            }
        }
    }
}
