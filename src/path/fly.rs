//! Walks in scenes with media that scatter: an edge ends on a surface or at a collision.

use super::walk::{LONGEST, PreviousVertex, RandomWalk, TraceStats};
use crate::geometry::{Ray, RayState, SurfacePoint};
use crate::light::LightSampleContext;
use crate::medium::{Collision, Flight, Homogeneous, Medium, Phase, density};
use crate::sampling::{Density, Sampler, Slot};
use crate::spectrum::Spectrum;
use glam::Vec3;

/// Where an edge ends.
#[allow(clippy::large_enum_variant)] // nearly all edges end on surfaces
pub enum FlightEnd {
    /// On a surface.
    Surface(SurfacePoint),
    /// At a collision.
    Medium(MediumPoint),
}

/// A collision in a medium.
#[derive(Debug, Clone, Copy)]
pub struct MediumPoint {
    /// Position.
    pub p: Vec3,
    /// How the medium scatters.
    pub phase: Phase,
    /// σt there, per unit of length.
    pub extinction: Spectrum,
    /// σs there, per unit of length.
    pub scattering: Spectrum,
    /// State of rays there.
    pub state: RayState,
}

/// An edge that a walk has flown along.
pub struct Flown {
    /// Its end; `None` outside the scene.
    pub end: Option<FlightEnd>,
    /// Transmittance of the scattering media on it.
    pub through: Spectrum,
    /// What the media on it emit toward its start, times the throughput of the walk there.
    pub emitted: Spectrum,
}

impl From<&MediumPoint> for LightSampleContext {
    #[inline]
    fn from(point: &MediumPoint) -> Self {
        LightSampleContext::new(point.p, Vec3::ZERO)
    }
}

/// A part of an edge in one medium, which a flight has reached.
#[derive(Debug, Clone, Copy)]
pub struct Stretch<'a> {
    /// The medium.
    pub medium: &'a Medium,
    /// The ray from its start.
    pub ray: Ray,
    /// Its length, up to a surface; infinite without one.
    pub length: f32,
    /// Throughput of the walk at its start.
    pub beta: Spectrum,
    /// Density of the walk so far by each lane over the mean of all.
    lanes: Spectrum,
    /// See [`Flight::rest`].
    u: f32,
}

impl Stretch<'_> {
    /// Returns the transmittance up to the distance `t` from its start.
    pub fn through(&self, t: f32) -> Spectrum {
        self.medium.transmittance(self.ray.origin, self.ray.direction, t)
    }

    /// Returns the density per length with which the flight collides after media of the transmittance `through`, where
    /// the medium has this `extinction`. With `through` of the edge that follows as well, it is that density times the
    /// probability of getting to the end of it.
    pub fn density(&self, through: Spectrum, extinction: Spectrum) -> f32 {
        density(self.lanes * through, extinction)
    }

    /// Returns the place at the distance `t` as a collision.
    pub fn point(&self, t: f32) -> MediumPoint {
        let p = self.ray.at(t);
        let here = [Spectrum::splat(self.medium.density(p)), self.medium.albedo(p)];
        MediumPoint::new(self.medium, p, here, self.ray.state)
    }

    /// Returns what it emits toward its start, times the throughput there.
    fn emitted(&self) -> Spectrum {
        if !self.medium.unit.emits() {
            return Spectrum::ZERO;
        }
        self.beta * self.medium.emitted(self.ray.origin, self.ray.direction, self.length, self.u)
    }
}

impl MediumPoint {
    /// Returns the collision at `p` in `medium`, where it has this density and albedo.
    fn new(medium: &Medium, p: Vec3, [density, albedo]: [Spectrum; 2], state: RayState) -> Self {
        let &Homogeneous { extinction, scattering, phase, .. } = &medium.unit;
        MediumPoint { p, phase, extinction: extinction * density, scattering: scattering * density * albedo, state }
    }
}

impl<'a> RandomWalk<'a> {
    /// Does [`RandomWalk::arrive`] in a scene with media that scatter.
    pub fn fly(&mut self, sampler: &mut impl Sampler, tally: &mut TraceStats) -> Flown {
        self.fly_over(sampler, tally, |_, _, _, _| {})
    }

    /// Does [`RandomWalk::fly`] and shows `over` each stretch of the edge when the flight has reached it.
    pub fn fly_over<S: Sampler>(
        &mut self,
        sampler: &mut S,
        tally: &mut TraceStats,
        mut over: impl FnMut(&Self, &Stretch<'a>, &mut S, &mut TraceStats),
    ) -> Flown {
        let mut flight = Flight::new(self.lanes, sampler.u2(self.bounce, Slot::MediumDistance));
        let (mut u, mut emitted) = (None, Spectrum::ZERO);
        for _ in 0..LONGEST {
            let point = self.trace(tally);
            tally.bad_hits += u64::from(point.as_ref().is_some_and(|p| !p.consistent));
            let length = point.as_ref().map_or(f32::INFINITY, |point| point.t);
            if let Some(stretch) = self.stretch(&flight, length) {
                emitted += stretch.emitted();
                over(self, &stretch, sampler, tally);
            }
            if let Some(collided) = self.collide(&mut flight, length) {
                return Flown { end: Some(FlightEnd::Medium(collided)), through: flight.through(), emitted };
            }
            let met = point.filter(|point| {
                !self.may_pass(point) || {
                    let u = u.get_or_insert_with(|| sampler.u1(self.bounce, Slot::Event));
                    !self.passes(point, u)
                }
            });
            if point.is_none() || met.is_some() {
                self.beta *= flight.factor();
                self.lanes = flight.posterior(Spectrum::ONE);
                return Flown { end: met.map(FlightEnd::Surface), through: flight.through(), emitted };
            }
        }
        tally.overlong += 1;
        self.beta = Spectrum::ZERO;
        Flown { end: None, through: Spectrum::ONE, emitted }
    }

    /// Returns the stretch of `length` that `flight` has reached, if it is in a medium and of interest to anybody.
    #[inline]
    fn stretch(&self, flight: &Flight, length: f32) -> Option<Stretch<'a>> {
        let features = self.scene.features();
        if !(features.emission || features.small_lights) {
            return None;
        }
        let medium = self.scene.medium(self.ray.state.bodies)?;
        let (beta, lanes) = (self.beta * flight.factor(), flight.posterior(Spectrum::ONE));
        Some(Stretch { medium, ray: self.ray, length, beta, lanes, u: flight.rest() })
    }

    /// Takes `flight` through `length` of the medium of the current edge.
    fn collide(&mut self, flight: &mut Flight, length: f32) -> Option<MediumPoint> {
        let state = self.ray.state;
        let medium = self.scene.medium(state.bodies)?;
        let Collision { distance, at, factor } = flight.cross(medium, self.ray.origin, self.ray.direction, length)?;
        let p = self.ray.at(distance);
        let albedo = medium.albedo(p);
        self.beta *= factor * albedo;
        self.lanes = flight.posterior(medium.unit.extinction);
        Some(MediumPoint::new(medium, p, [Spectrum::splat(at), albedo], state))
    }

    /// Leaves a collision along the unit vector `w`, sampled by its value, which is `density`.
    pub fn scatter_in_medium(&mut self, point: &MediumPoint, w: Vec3, density: Density) {
        self.straight = false;
        self.depth += 1;
        self.bounce += 1;
        self.departure = PreviousVertex::Scattered(LightSampleContext::from(point), density);
        self.ray = Ray::new(point.p, w).carrying(point.state);
    }
}
