//! Paths through media that scatter, one after the other.

use super::equiangular::Collided;
use super::{PathTracer, Strategy, light_weight};
use crate::bsdf::{Lobes, Scattering, Shading};
use crate::camera::CameraSample;
use crate::geometry::SurfacePoint;
use crate::light::{ChosenLight, EmitterPoint, LightSample, LightSampleContext};
use crate::medium::density;
use crate::path::{FlightEnd, Flown, MediumPoint, PhaseAt, RandomWalk, Stretch, TraceStats};
use crate::sampling::{Density, Pdf, Sampler, Slot};
use crate::scene::{Edge, EdgeEnd};
use crate::spectrum::Spectrum;
use crate::transport::TransportMode;
use glam::Vec3;

impl<'a, S: Strategy> PathTracer<'a, S> {
    /// Returns the radiance along the ray of `camera`.
    pub(super) fn radiance_in_media<P: Sampler>(
        &self,
        camera: &CameraSample,
        sampler: &mut P,
        tally: &mut TraceStats,
    ) -> Spectrum {
        let mut walk = RandomWalk::from_camera(self.scene, camera);
        let (mut total, mut collided) = (Spectrum::ZERO, None::<Collided>);
        loop {
            let lanes = walk.lanes;
            let (mut last, mut scattered) = (None, Spectrum::ZERO);
            let over = |walk: &RandomWalk, stretch: &Stretch<'a>, sampler: &mut P, tally: &mut TraceStats| {
                scattered += self.equiangular(walk, stretch, sampler, tally);
                last = Some(*stretch);
            };
            let Flown { end, through, emitted } = walk.fly_over(sampler, tally, over);
            total += emitted + scattered;
            let chance = density(lanes * through, Spectrum::ONE);
            let Some(end) = end else { return total + self.background(&walk, chance, tally) };
            if let FlightEnd::Surface(point) = &end {
                let light = self.emitted(&walk, point.hit, point.p, point.barycentric, chance, tally);
                total += match &collided {
                    Some(collided) if !light.is_black() => {
                        light * self.share_of_hit(&walk, collided, point, chance, tally)
                    }
                    _ => light,
                };
            }
            if walk.depth >= self.max_depth {
                return total;
            }
            collided = None;
            let left = match end {
                FlightEnd::Surface(mut point) => self.leave_surface(&mut walk, &mut point, sampler, tally),
                FlightEnd::Medium(point) => {
                    collided = last.map(|stretch| (stretch, point));
                    Some(self.leave_medium(&mut walk, &point, collided.as_ref(), sampler, tally))
                }
            };
            let Some(light) = left else { return total };
            total += light;
            if !walk.survives(sampler, tally) {
                return total;
            }
        }
    }

    /// Leaves the surface at `point`, at which `walk` has arrived. Returns the light sampled there; `None` if nothing
    /// scatters.
    fn leave_surface(
        &self,
        walk: &mut RandomWalk,
        point: &mut SurfacePoint,
        sampler: &mut impl Sampler,
        tally: &mut TraceStats,
    ) -> Option<Spectrum> {
        let surface = self.scene.surface(point, walk.ray.state.bodies);
        let shading = Shading::new(point, &surface, -walk.ray.direction, TransportMode::Radiance)?;
        let (receiver, state) = (self.receiver(&shading), walk.ray.state);
        let edge = |w: Vec3, end| Edge::new(self.scene, point, state, w, EdgeEnd::Light(end));
        let mut light = Spectrum::ZERO;
        if shading.lobes().intersects(Lobes::SMOOTH) {
            light = self.direct(walk, |w| shading.scattering(w), &receiver, edge, |_, _, _| 1.0, sampler, tally);
        }
        // Light that was sampled counts, also where the walk ends.
        match S::scatter(&shading, walk.scattering_numbers(&surface, sampler)) {
            Some(scatter) => match self.entered(walk, point, &scatter) {
                Some(body) => light += self.diffuse(walk, body, (point, &scatter), sampler, tally),
                None => walk.depart(point, receiver, &scatter),
            },
            None => walk.beta = Spectrum::ZERO,
        }
        Some(light)
    }

    /// Leaves a collision in a medium, on a stretch that equiangular sampling has seen. Returns the light sampled
    /// there.
    fn leave_medium(
        &self,
        walk: &mut RandomWalk,
        point: &MediumPoint,
        collided: Option<&Collided>,
        sampler: &mut impl Sampler,
        tally: &mut TraceStats,
    ) -> Spectrum {
        let phase = PhaseAt::new(point, -walk.ray.direction);
        let share = |light, sample: &LightSample, scattering| {
            collided.map_or(1.0, |collided| self.share_of_sample(collided, light, sample, scattering))
        };
        let edge = |w: Vec3, end| Edge::from_medium(point.p, point.state, w, EdgeEnd::Light(end));
        let (receiver, scattering) = (LightSampleContext::from(point), |w| Some(phase.scattering(w)));
        let light = self.direct(walk, scattering, &receiver, edge, share, sampler, tally);
        let sample = phase.sample(sampler.u2(walk.bounce, Slot::Direction));
        walk.scatter_in_medium(point, sample.direction, Density::Smooth(sample.pdf));
        light
    }

    /// Next-event estimation at `receiver`, where light is scattered by `scattering`. The probability that a walk in
    /// the direction of the light gets there is known when the edge is traced. `share` is the weight of this light
    /// sample among the techniques that place the receiver.
    #[allow(clippy::too_many_arguments)]
    pub(super) fn direct(
        &self,
        walk: &RandomWalk,
        scattering: impl FnOnce(Vec3) -> Option<Scattering>,
        receiver: &LightSampleContext,
        edge: impl FnOnce(Vec3, EmitterPoint) -> Edge,
        share: impl FnOnce((usize, f32), &LightSample, f32) -> f32,
        sampler: &mut impl Sampler,
        tally: &mut TraceStats,
    ) -> Spectrum {
        if !S::SAMPLES_LIGHTS {
            return Spectrum::ZERO;
        }
        let (lights, bounce) = (self.scene.lights(), walk.bounce);
        let u = sampler.u2(bounce, Slot::LightPoint);
        let choose = || lights.choose(receiver, u, || sampler.u1(bounce, Slot::LightPick));
        let Some(ChosenLight { index, pmf, u }) = tally.selection.time_of(lights, choose) else {
            return Spectrum::ZERO;
        };
        let Some(sample) = lights.all()[index].sample_li(receiver, u) else { return Spectrum::ZERO };
        let Some(mut scattering) = scattering(sample.wi) else { return Spectrum::ZERO };
        let clear = self.scene.clearance(&edge(sample.wi, sample.end), &mut tally.shadows);
        scattering.pdf = scattering.pdf.choose(Pdf::new(density(walk.lanes * clear.flight, Spectrum::ONE)));
        let weight = light_weight::<S>(&scattering, &sample, pmf);
        let share = share((index, pmf.value()), &sample, scattering.pdf.value());
        walk.beta * scattering.f_cos * sample.radiance * clear.through * weight * share
    }
}
