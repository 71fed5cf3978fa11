//! Equiangular sampling of collisions with light of points, spots and small lamps [KullaFajardo12].
//!
//! Flights find the air around a lamp by chance, where its light is strongest: 1/d² has no finite variance there. Here
//! a collision is placed on a stretch of an edge in one medium with a density proportional to 1/d² from the middle of
//! one light, as if the angle seen from it were uniform. From there the light is sampled as at any collision. The same
//! path has up to two other techniques: a flight and a light sample, and a flight and a direction that hits the lamp.
//! All three are weighted by the power heuristic. Large lamps are left to flights: their 1/d² is bounded.

use super::{PathTracer, Strategy};
use crate::geometry::SurfacePoint;
use crate::light::{Light, LightSample, LightSampleContext};
use crate::path::{MediumPoint, PhaseAt, PreviousVertex, RandomWalk, Stretch, TraceStats};
use crate::sampling::{Density, Sampler, Slot, power};
use crate::scene::EdgeEnd;
use crate::spectrum::Spectrum;
use glam::Vec3;

/// First address of the random numbers: of the light, of the place, and of the point on the light.
const EQUIANGULAR: u32 = 1 << 26;

/// A stretch seen from a light: angles from the perpendicular.
#[derive(Debug, Clone, Copy)]
struct Seen {
    /// Distance from the start of the stretch to the foot of the perpendicular.
    foot: f32,
    /// Distance of the light.
    height: f32,
    /// Angles of the ends.
    angles: [f32; 2],
}

impl Seen {
    /// Returns the stretch of `length` from `origin` along the unit vector `w` as seen from `light`; `None` if the
    /// light is on its line, or it has no length.
    fn new(origin: Vec3, w: Vec3, length: f32, light: Vec3) -> Option<Self> {
        let to = light - origin;
        let foot = to.dot(w);
        // The cross product keeps the digits of a small height.
        let height = to.cross(w).length();
        let angles = [(-foot / height).atan(), ((length - foot) / height).atan()];
        (height > 0.0 && angles[1] > angles[0]).then_some(Seen { foot, height, angles })
    }

    /// Returns the distance at `u` in [0, 1) from the start.
    fn sample(&self, u: f32) -> f32 {
        let [a, b] = self.angles;
        self.foot + self.height * (a + u * (b - a)).tan()
    }

    /// Returns the density of the distance `t`, per length.
    fn pdf(&self, t: f32) -> f32 {
        let [a, b] = self.angles;
        let along = t - self.foot;
        self.height / ((b - a) * (self.height * self.height + along * along))
    }
}

/// A collision of a flight, and the stretch that it was on.
pub(super) type Collided<'a> = (Stretch<'a>, MediumPoint);

/// Densities of the three techniques for one path, in one measure.
struct Densities {
    equiangular: f32,
    /// Flight and light sample.
    sampled: f32,
    /// Flight and direction that hits the light.
    hit: f32,
}

impl Densities {
    fn weight_of_equiangular(&self) -> f32 {
        power(self.equiangular, self.sampled.hypot(self.hit))
    }

    /// Returns the weight of both other techniques, as a factor of their weights beside each other.
    fn share_of_flights(&self) -> f32 {
        power(self.sampled.hypot(self.hit), self.equiangular)
    }
}

impl<S: Strategy> PathTracer<'_, S> {
    /// Returns the density with which equiangular sampling selects light of number `index` and the distance `t` on
    /// `stretch`; 0 if it never does.
    fn equiangular_density(&self, stretch: &Stretch, t: f32, index: usize) -> f32 {
        let lights = self.scene.lights();
        let seen = lights.all()[index]
            .pivot()
            .and_then(|pivot| Seen::new(stretch.ray.origin, stretch.ray.direction, stretch.length, pivot));
        seen.map_or(0.0, |seen| lights.emitter_pmf(index).value() * seen.pdf(t))
    }

    /// Returns the factor of the weights of both techniques with a flight at a collision, for light of number `index`,
    /// selected with the probability `pmf` and sampled with the density `on_light`. `scattering` is the density of a
    /// direction that hits it, or 0.
    fn share_of_flights(
        &self,
        (stretch, point): &Collided,
        (index, pmf): (usize, f32),
        on_light: f32,
        scattering: f32,
    ) -> f32 {
        let t = (point.p - stretch.ray.origin).dot(stretch.ray.direction);
        let equiangular = self.equiangular_density(stretch, t, index);
        if equiangular <= 0.0 {
            return 1.0;
        }
        let flown = stretch.density(stretch.through(t), point.extinction);
        let (equiangular, sampled) = (equiangular * on_light, pmf * on_light * flown);
        Densities { equiangular, sampled, hit: scattering * flown }.share_of_flights()
    }

    /// Returns the factor of the weight of `sample`, of light of number `index`, selected with the probability `pmf`,
    /// at a collision. `scattering` is the density with which its direction is scattered to the light.
    pub(super) fn share_of_sample(
        &self,
        collided: &Collided,
        light: (usize, f32),
        sample: &LightSample,
        scattering: f32,
    ) -> f32 {
        let (on_light, scattering) = densities_on_light::<S>(sample, || scattering);
        self.share_of_flights(collided, light, on_light, scattering)
    }

    /// Returns the factor of the weight of the light at `hit`, which `walk` reaches from a collision through media with
    /// the probability `chance`.
    pub(super) fn share_of_hit(
        &self,
        walk: &RandomWalk,
        collided: &Collided,
        hit: &SurfacePoint,
        chance: f32,
        tally: &mut TraceStats,
    ) -> f32 {
        let (Some((index, Light::Area(light))), PreviousVertex::Scattered(from, Density::Smooth(scattering))) =
            (self.scene.light_at(hit), &walk.departure)
        else {
            return 1.0;
        };
        if !S::SAMPLES_LIGHTS || light.pivot().is_none() {
            return 1.0;
        }
        let lights = self.scene.lights();
        let on_light = light.pdf_li(from.p, hit.p, walk.ray.direction).value();
        let pmf = tally.selection.time_of(lights, || lights.pmf(from, index)).value();
        self.share_of_flights(collided, (index, pmf), on_light, scattering.value() * chance)
    }

    /// Returns the weighted light of a point, spot or small lamp that scatters once on `stretch` toward its start.
    pub(super) fn equiangular(
        &self,
        walk: &RandomWalk,
        stretch: &Stretch,
        sampler: &mut impl Sampler,
        tally: &mut TraceStats,
    ) -> Spectrum {
        let Stretch { medium, ray, length, beta, .. } = *stretch;
        if !S::SAMPLES_LIGHTS || walk.depth >= self.max_depth || !medium.unit.scatters() {
            return Spectrum::ZERO;
        }
        let lights = self.scene.lights();
        let [pick, u] = sampler.u2(EQUIANGULAR + walk.bounce, Slot::MediumDistance);
        let Some((index, chosen)) = lights.choose_emitter(pick) else { return Spectrum::ZERO };
        let light = &lights.all()[index];
        let seen = light.pivot().and_then(|pivot| Seen::new(ray.origin, ray.direction, length, pivot));
        let Some(seen) = seen else { return Spectrum::ZERO };
        let t = seen.sample(u);
        // Rounding may lead out of the stretch.
        if !(t > 0.0 && t < length) {
            return Spectrum::ZERO;
        }
        let point = stretch.point(t);
        let receiver = LightSampleContext::from(&point);
        let on_light = sampler.u2(EQUIANGULAR + walk.bounce, Slot::LightPoint);
        let Some(sample) = light.sample_li(&receiver, on_light) else { return Spectrum::ZERO };
        let phase = PhaseAt::new(&point, -ray.direction);
        let edge = phase.edge_to(sample.wi, EdgeEnd::Light(sample.end));
        let clear = self.scene.clearance(&edge, &mut tally.shadows);
        if clear.through.is_black() {
            return Spectrum::ZERO;
        }
        let scattering = phase.scattering(sample.wi);
        let through = stretch.through(t);
        let beyond = || scattering.pdf.value() * stretch.density(through * clear.flight, point.extinction);
        let (on_light, hit) = densities_on_light::<S>(&sample, beyond);
        let made = chosen.value() * seen.pdf(t) * on_light;
        let pmf = tally.selection.time_of(lights, || lights.pmf(&receiver, index)).value();
        let sampled = pmf * on_light * stretch.density(through, point.extinction);
        let weight = Densities { equiangular: made, sampled, hit }.weight_of_equiangular() / made;
        let scattered = scattering.f_cos * point.scattering;
        beta * through * scattered * sample.radiance * clear.through * weight
    }
}

/// Returns the density of `sample` on its light, and `hit`, that of a direction that hits it, where one may.
fn densities_on_light<S: Strategy>(sample: &LightSample, hit: impl FnOnce() -> f32) -> (f32, f32) {
    match sample.density {
        Density::Delta(probability) => (probability, 0.0),
        Density::Smooth(pdf) => (pdf.value(), if S::HITS_LIGHTS { hit() } else { 0.0 }),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Distances follow their density, which integrates to 1, near and far from the light and on rays without end:
    /// between neighbours of 1000 samples is a thousandth of it. The midpoint rule with 200 steps has errors of 1e-4
    /// where the density falls to a fifth in an interval; positions have roundings of 4e-7 beside distances of 1e-3.
    #[test]
    fn distances_follow_their_density() {
        for (length, light) in [
            (2.0, Vec3::new(0.5, 0.3, 0.0)),
            (2.0, Vec3::new(1.0, 1e-2, 0.0)),
            (5.0, Vec3::new(-3.0, 0.0, 1.0)),
            (f32::INFINITY, Vec3::new(2.0, 1.0, 1.0)),
        ] {
            let seen = Seen::new(Vec3::ZERO, Vec3::X, length, light).expect("beside the line");
            let (n, steps) = (1000, 200);
            let mut last = seen.sample(0.0);
            assert!(last.abs() < 1e-5, "begins at the start: {last}");
            for i in 1..n - 2 {
                let t = seen.sample(i as f32 / n as f32);
                let step = (t - last) / steps as f32;
                let mass: f32 = (0..steps).map(|k| seen.pdf(last + (k as f32 + 0.5) * step) * step).sum();
                assert!((mass * n as f32 - 1.0).abs() < 0.01, "{length} {light}: {mass} at {t}");
                last = t;
            }
            assert!(last <= length);
        }
    }

    #[test]
    fn a_light_on_the_line_is_left_to_flights() {
        assert!(Seen::new(Vec3::ZERO, Vec3::X, 2.0, Vec3::X).is_none());
        assert!(Seen::new(Vec3::ZERO, Vec3::X, 0.0, Vec3::Y).is_none());
    }
}
