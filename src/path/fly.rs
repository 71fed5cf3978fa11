//! Walks in scenes with media that scatter: an edge ends on a surface or at a collision.

use super::walk::{LONGEST, PreviousVertex, RandomWalk, TraceStats};
use crate::geometry::{Ray, RayState, SurfacePoint};
use crate::light::LightSampleContext;
use crate::medium::{Collision, Flight, Homogeneous, Phase};
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

impl RandomWalk<'_> {
    /// Does [`RandomWalk::arrive`] in a scene with media that scatter.
    pub fn fly(&mut self, sampler: &mut impl Sampler, tally: &mut TraceStats) -> Flown {
        let mut flight = Flight::new(self.lanes, sampler.u2(self.bounce, Slot::MediumDistance));
        let (mut u, mut emitted) = (None, Spectrum::ZERO);
        for _ in 0..LONGEST {
            let point = self.trace(tally);
            tally.bad_hits += u64::from(point.as_ref().is_some_and(|p| !p.consistent));
            let length = point.as_ref().map_or(f32::INFINITY, |point| point.t);
            if self.scene.features().emission {
                emitted += self.emission(&flight, length);
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

    /// Returns what `length` of the medium of the current edge emits toward its start, as far as `flight` has got,
    /// times the throughput of the walk. The integral is over the whole length, wherever the flight ends.
    #[cold]
    fn emission(&self, flight: &Flight, length: f32) -> Spectrum {
        let Some(medium) = self.scene.medium(self.ray.state.bodies) else { return Spectrum::ZERO };
        if !medium.unit.emits() {
            return Spectrum::ZERO;
        }
        self.beta * flight.factor() * medium.emitted(self.ray.origin, self.ray.direction, length)
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
        let &Homogeneous { extinction, scattering, phase, .. } = &medium.unit;
        let (extinction, scattering) = (extinction * at, scattering * at * albedo);
        Some(MediumPoint { p, phase, extinction, scattering, state })
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
