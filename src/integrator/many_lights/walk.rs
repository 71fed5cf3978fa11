//! A camera walk that gathers light at its vertices.

use super::gather::{Gather, Indirect, Receiver};
use super::limit::Limited;
use super::virtual_lights::{EMITTING_PEAK, peak};
use crate::bsdf::{Lobes, Shading};
use crate::camera::CameraSample;
use crate::geometry::SurfacePoint;
use crate::integrator::IntegratorConfig;
use crate::integrator::camera_pass::Radiance;
use crate::light::{Cut, Light, LightSampleContext};
use crate::path::{RandomWalk, TraceStats};
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
    /// the direction in its light samples.
    fn mis_weight_bsdf(
        &self,
        departure: Option<&Departure>,
        light: usize,
        pdf: impl FnOnce(&LightSampleContext) -> f32,
        tally: &mut TraceStats,
    ) -> f32 {
        let Some(Departure { at, cut, pdf: scattering, .. }) = departure else { return 1.0 };
        let pmf = tally.selection.time(|| self.gather.lights.pmf(cut, at, light)) as f32;
        power(scattering.value(), pmf * pdf(at))
    }

    /// Returns the weighted emission at `point` toward the walk.
    fn emitted(
        &self,
        walk: &RandomWalk,
        departure: Option<&Departure>,
        point: &SurfacePoint,
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
                self.walk_share(departure, point, wi, EMITTING_PEAK)
            }
            _ => self.mis_weight_bsdf(departure, index, pdf, tally),
        };
        walk.beta * radiance * weight
    }

    /// Returns the weighted radiance of the environment.
    fn background(&self, walk: &RandomWalk, departure: Option<&Departure>, tally: &mut TraceStats) -> Spectrum {
        let Some((index, environment)) = self.gather.scene.lights().environment() else { return Spectrum::ZERO };
        if self.transparent && walk.depth == 0 {
            return Spectrum::ZERO;
        }
        let (radiance, pdf) = environment.along(walk.ray.direction);
        walk.beta * radiance * self.mis_weight_bsdf(departure, index, |_| pdf.value(), tally)
    }

    /// Returns whether the walk has a share in the paths that scatter smoothly at `shading`, where the edge from
    /// `departure` ends: virtual lights there have the other share.
    fn goes_beyond(
        &self,
        departure: Option<&Departure>,
        walk: &RandomWalk,
        shading: &Shading,
        sampler: &mut impl Sampler,
    ) -> bool {
        let Some(departure) = departure else { return true };
        let share = self.walk_share(departure, shading.point, walk.ray.direction, peak(shading.surface));
        share > 0.0 && sampler.u1(BEYOND + walk.bounce, Slot::Roulette) < share
    }

    /// Returns the share of the walk in paths with an edge from `departure` along `w` to `point`, where a virtual light
    /// of this `peak` has the rest.
    fn walk_share(&self, departure: &Departure, point: &SurfacePoint, w: Vec3, peak: f32) -> f32 {
        let (limit, d2) = (&self.gather.limit, point.p.distance_squared(departure.at.p));
        let share = limit.share(departure.f_cos, point.cos(w), d2, peak);
        if limit.is_compensated { 1.0 - share } else { 0.0 }
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
            let Some(mut point) = walk.arrive(sampler, tally) else {
                return total + self.background(&walk, departure.as_ref(), tally);
            };
            total += self.emitted(&walk, departure.as_ref(), &point, tally);
            if walk.depth >= self.max_depth {
                return total;
            }
            let surface = scene.surface(&mut point, walk.ray.state.bodies);
            let wo = -walk.ray.direction;
            let Some(shading) = &Shading::new(&point, &surface, wo, TransportMode::Radiance) else { return total };
            let context = LightSampleContext::from(shading);
            let is_smooth = shading.lobes().intersects(Lobes::SMOOTH);
            let gathers = is_smooth && self.goes_beyond(departure.as_ref(), &walk, shading, sampler);
            let mut cut = Cut::default();
            if gathers {
                let events_left = self.max_depth - walk.depth - 1;
                let receiver = Receiver { shading, context, state: walk.ray.state, bounce: walk.bounce, events_left };
                let direct;
                (direct, cut) = self.gather.direct(&receiver, sampler, tally);
                let Limited { light, excess } = self.gather.indirect(&receiver, sampler, tally);
                if !self.gather.limit.is_compensated {
                    tally.limited(walk.beta * excess);
                }
                total += walk.beta * (direct + light);
            }
            let Some(scatter) = &shading.sample(walk.scattering_numbers(&surface, sampler)) else { return total };
            departure = match scatter.density {
                Density::Delta(_) => None,
                Density::Smooth(_) if !gathers => return total,
                Density::Smooth(pdf) => Some(Departure { at: context, cut, pdf, f_cos: scatter.weight * pdf.value() }),
            };
            walk.depart(&point, context, scatter);
            if !walk.survives(sampler, tally) {
                return total;
            }
        }
    }
}
