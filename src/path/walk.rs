//! A random walk from the camera toward the lights or from a light toward the camera: the state carried from vertex to
//! vertex.
//!
//! Usage: `arrive`, process the vertex, `depart`, `survives`, repeat. Alpha-blended surfaces, straight transmission,
//! boundaries hidden inside bodies of higher precedence, and absorbing media belong to the edge between two vertices
//! and are never vertices themselves.

use super::SelectionStats;
use crate::accel::RayClass;
use crate::bsdf::{Shading, ShadingSample, Surface};
use crate::camera::CameraSample;
use crate::geometry::{Ray, SurfacePoint};
use crate::light::{AreaLight, LightSampleContext};
use crate::numeric::BELOW_ONE;
use crate::sampling::{Density, Sampler, Slot};
use crate::scene::{Passage, Scene};
use crate::spectrum::Spectrum;
use crate::transport::TransportMode;
use etendue_lanes::Float;

/// Limit of scattering and null events of a path. Longer paths are cut and reported as a defect of the scene.
pub const LONGEST: u32 = 1 << 14;

/// Number of scattering events before roulette by depth begins. Only paths trapped by total reflection still carry
/// significant light at this depth.
const LASTING_FROM: u32 = 256;

/// Number of scattering events before Russian roulette begins.
pub const ROULETTE_FROM: u32 = 2;

/// Gain on the throughput in the survival probability of roulette. relMSE × rays on the Cornell box at 1, 2, 3, 4, 6,
/// 10 is .95, .68, .66, .66, .68, .71: terminating paths as soon as their throughput falls adds more noise than it
/// saves cost.
const ROULETTE_GAIN: f32 = 3.0;

/// Counters of random walks.
#[derive(Debug, Clone, Copy, Default)]
pub struct TraceStats {
    /// Rays from the camera, including continuations behind culled or blended surfaces.
    pub cameras: u64,
    /// Rays from a scattering event or a light, counted when traced.
    pub bounces: u64,
    /// Shadow rays, including continuations behind blended surfaces.
    pub shadows: u64,
    /// Hits that are inconsistent with their triangle.
    pub bad_hits: u64,
    /// Paths that reached the emergency length limit.
    pub overlong: u64,
    /// Contributions that were limited without compensation.
    pub clamped: u64,
    /// Sum over lanes of the excess, in radiance × samples.
    pub clamped_energy: f64,
    /// The selection of lights by receiver.
    pub selection: SelectionStats,
}

impl TraceStats {
    /// Adds the counters of other walks.
    pub fn absorb(&mut self, other: &TraceStats) {
        self.cameras += other.cameras;
        self.bounces += other.bounces;
        self.shadows += other.shadows;
        self.bad_hits += other.bad_hits;
        self.overlong += other.overlong;
        self.clamped += other.clamped;
        self.clamped_energy += other.clamped_energy;
        self.selection.absorb(&other.selection);
    }

    /// Counts a contribution that was limited without compensation, if its `excess` is not black.
    pub fn limited(&mut self, excess: Spectrum) {
        self.clamped += u64::from(!excess.is_black());
        self.clamped_energy += excess.0.iter().map(|&x| f64::from(x)).sum::<f64>();
    }
}

impl From<&Shading<'_>> for LightSampleContext {
    #[inline]
    fn from(shading: &Shading) -> Self {
        LightSampleContext::from(shading.point).scattering(shading.outline())
    }
}

/// Origin of the current edge of a walk.
#[derive(Debug, Clone, Copy)]
pub enum PreviousVertex {
    /// The camera.
    Camera,
    /// A light.
    Light,
    /// A point that scatters, with the density of the sampled direction.
    Scattered(LightSampleContext, Density),
}

/// State of a random walk.
pub struct RandomWalk<'a> {
    pub(super) scene: &'a Scene,
    /// Transport mode.
    pub mode: TransportMode,
    /// Current edge, with a unit direction.
    pub ray: Ray,
    /// Throughput: product of all scattering values and transmittances over their densities.
    pub beta: Spectrum,
    /// Origin of the current edge.
    pub departure: PreviousVertex,
    /// Number of scattering events so far.
    pub depth: u32,
    /// Address of random numbers: index of the departure vertex, from 0. A light has index 0 in its own subpath.
    pub bounce: u32,
    /// Probability of having survived roulette and all null-event decisions so far. The throughput is already divided
    /// by it.
    pub survival: f32,
    /// Density of the walk so far by the free flights of each lane over the mean of all lanes.
    pub lanes: Spectrum,
    /// Whether all vertices so far scattered by Dirac components.
    pub straight: bool,
    /// Factor that normalises the throughput for roulette. It removes the emitted power, or the squared ratio of
    /// refractive indices between the camera and here, by which radiance is scaled temporarily.
    scale: f32,
}

impl<'a> RandomWalk<'a> {
    /// Starts a walk at the camera, in the bodies that contain its origin.
    #[inline]
    pub fn from_camera(scene: &'a Scene, &CameraSample { ray, medium, .. }: &CameraSample) -> Self {
        let ray = ray.carrying(ray.state.within(medium.unwrap_or_else(|| scene.bodies_at(ray.origin))));
        let (beta, departure) = (Spectrum::ONE, PreviousVertex::Camera);
        RandomWalk {
            scene,
            mode: TransportMode::Radiance,
            ray,
            beta,
            departure,
            depth: 0,
            bounce: 0,
            survival: 1.0,
            lanes: Spectrum::ONE,
            straight: true,
            scale: 1.0,
        }
    }

    /// Continues a camera walk along `ray`, after `depth` scattering events, with the fields of an earlier
    /// [`RandomWalk`] as given.
    #[inline]
    pub fn resumed(
        scene: &'a Scene,
        ray: Ray,
        beta: Spectrum,
        departure: PreviousVertex,
        depth: u32,
        (straight, scale): (bool, f32),
    ) -> Self {
        let mode = TransportMode::Radiance;
        let (survival, lanes) = (1.0, Spectrum::ONE);
        RandomWalk { scene, mode, ray, beta, departure, depth, bounce: depth, survival, lanes, straight, scale }
    }

    /// Returns the factor that normalises the throughput for roulette.
    #[inline]
    pub fn scale(&self) -> f32 {
        self.scale
    }

    /// Starts a walk along a ray emitted with `power`, which is not black, in the bodies given by the ray.
    pub fn from_light(scene: &'a Scene, ray: Ray, power: Spectrum) -> Self {
        let (departure, scale) = (PreviousVertex::Light, power.max_lane().recip());
        RandomWalk {
            scene,
            mode: TransportMode::Importance,
            ray,
            beta: power,
            departure,
            depth: 0,
            bounce: 1,
            survival: 1.0,
            lanes: Spectrum::ONE,
            straight: true,
            scale,
        }
    }

    /// Traces the current edge to the surface at its end; `None` if it leaves the scene. Surfaces with straight
    /// transmission (see [`Passage`]) are hit with a probability and passed otherwise. Camera rays pass surfaces that
    /// the camera culls.
    #[inline(always)] // a call would copy the point through memory: a tenth of the time of a simple scene
    pub fn arrive(&mut self, sampler: &mut impl Sampler, tally: &mut TraceStats) -> Option<SurfacePoint> {
        let point = self.trace(tally);
        self.arrived(point, sampler, tally)
    }

    /// [`RandomWalk::arrive`] after the first surface on the edge was found.
    #[inline(always)] // see `arrive`
    pub fn arrived(
        &mut self,
        mut point: Option<SurfacePoint>,
        sampler: &mut impl Sampler,
        tally: &mut TraceStats,
    ) -> Option<SurfacePoint> {
        if let Some(first) = &point {
            if self.may_pass(first) {
                point = self.past(*first, sampler, tally);
            }
        }
        let ray = self.ray;
        self.absorb(&ray, point.as_ref().map_or(f32::INFINITY, |p| p.t));
        tally.bad_hits += u64::from(point.as_ref().is_some_and(|p| !p.consistent));
        point
    }

    /// Whether [`RandomWalk::passes`] may be true at `point`; a cheap test.
    #[inline]
    pub(super) fn may_pass(&self, point: &SurfacePoint) -> bool {
        self.scene.features().content() && self.scene.may_pass(point, self.ray.state.bodies) || self.unseen(point)
    }

    /// Traces the current edge to the first hit.
    #[inline(always)] // see `arrive`
    pub(super) fn trace(&self, tally: &mut TraceStats) -> Option<SurfacePoint> {
        let class = match self.departure {
            PreviousVertex::Camera => RayClass::Camera,
            PreviousVertex::Light | PreviousVertex::Scattered(..) => RayClass::Bounce(self.depth),
        };
        match class {
            RayClass::Camera => tally.cameras += 1,
            _ => tally.bounces += 1,
        }
        self.scene.accel().announce(class);
        self.scene.intersect(&self.ray)
    }

    /// Whether the current edge starts at the camera and culls the surface at `point`.
    #[inline]
    fn unseen(&self, point: &SurfacePoint) -> bool {
        matches!(self.departure, PreviousVertex::Camera) && self.scene.culled(point, self.ray.direction)
    }

    /// Returns the first surface at or behind `point` that the edge does not pass. The edge is moved to start behind
    /// the passed surfaces.
    #[cold]
    fn past(
        &mut self,
        mut point: SurfacePoint,
        sampler: &mut impl Sampler,
        tally: &mut TraceStats,
    ) -> Option<SurfacePoint> {
        let mut u = sampler.u1(self.bounce, Slot::Event);
        for _ in 0..LONGEST {
            let ray = self.ray;
            if !self.passes(&point, &mut u) {
                return Some(point);
            }
            self.absorb(&ray, point.t);
            point = self.trace(tally)?;
        }
        tally.overlong += 1;
        self.beta = Spectrum::ZERO;
        None
    }

    /// Decides by `u` whether the walk passes the surface at `point`, and moves the edge behind it if so. `u` is
    /// uniform again, so that one random number serves all surfaces of an edge.
    pub(super) fn passes(&mut self, point: &SurfacePoint, u: &mut f32) -> bool {
        let w = self.ray.direction;
        let passage =
            if self.unseen(point) { Passage::FREE } else { self.scene.passage(point, w, self.ray.state.bodies) };
        let (met, chance) = (passage.met, passage.chance());
        if *u < met {
            self.beta *= passage.alpha / met;
            self.survival *= met;
            return false;
        }
        *u = ((*u - met) / chance).min(BELOW_ONE);
        self.beta *= passage.through.map(|t: f32| t / chance);
        self.survival *= chance;
        self.ray = point.spawn(w).carrying(self.scene.state_toward(point, self.ray.state, w));
        true
    }

    #[inline]
    fn absorb(&mut self, ray: &Ray, length: f32) {
        let bodies = ray.state.bodies;
        if !bodies.is_empty() && self.scene.features().media {
            self.beta *= self.scene.absorption(bodies, ray, length);
        }
    }

    /// Whether the walk may count the emission of `light`, which it hit. Emitters that do not illuminate are visible
    /// only to camera walks with Dirac vertices alone.
    #[inline]
    pub fn sees(&self, light: &AreaLight) -> bool {
        self.straight || !light.is_only_seen()
    }

    /// Returns the random numbers for BSDF sampling on `surface`. Models with one lobe do not use the lobe selection
    /// number.
    #[inline]
    pub fn scattering_numbers(&self, surface: &Surface, sampler: &mut impl Sampler) -> [f32; 3] {
        let lobe = if surface.is_single_lobe() { 0.0 } else { sampler.u1(self.bounce, Slot::Lobe) };
        let [u, v] = sampler.u2(self.bounce, Slot::Direction);
        [lobe, u, v]
    }

    /// Leaves `point`, for which lights are selected as for the receiver `from`, along the sampled direction of
    /// `scatter`.
    #[inline]
    pub fn depart(&mut self, point: &SurfacePoint, from: LightSampleContext, scatter: &ShadingSample) {
        self.beta *= scatter.weight;
        if self.mode == TransportMode::Radiance {
            self.scale *= scatter.eta * scatter.eta;
        }
        self.straight &= scatter.density.is_delta();
        self.depth += 1;
        self.bounce += 1;
        let state = self.scene.state_toward(point, self.ray.state, scatter.direction);
        self.departure = PreviousVertex::Scattered(from, scatter.density);
        self.ray = point.spawn(scatter.direction).carrying(state);
    }

    /// Enters a body by a factor of the throughput, and leaves it elsewhere in the state of the current edge: two
    /// scattering events, of which the second follows.
    pub fn enter_and_leave(&mut self, factor: Spectrum) {
        self.beta *= factor;
        self.straight = false;
        self.depth += 1;
        self.bounce += 1;
    }

    /// Russian roulette by relative throughput and by depth. Survivors are scaled by 1/q.
    #[inline]
    pub fn survives(&mut self, sampler: &mut impl Sampler, tally: &mut TraceStats) -> bool {
        if self.depth >= LONGEST {
            tally.overlong += 1;
            return false;
        }
        if self.depth < ROULETTE_FROM {
            return !self.beta.is_black();
        }
        let q = survival_probability(self.beta, self.scale, self.depth);
        if q < 1.0 {
            if sampler.u1(self.bounce, Slot::Roulette) >= q {
                return false;
            }
            self.beta *= q.recip();
            self.survival *= q;
        }
        true
    }
}

/// Returns the probabilities with which roulette lets walks of throughput `beta`, normalised by `scale`, survive the
/// event `depth`.
#[inline(always)]
pub fn survival_probability<F: Float>(beta: Spectrum<F>, scale: F, depth: u32) -> F {
    let share = (F::splat(ROULETTE_GAIN) * beta.greatest() * scale).min(F::splat(1.0));
    share.min(F::splat(lasting(depth)))
}

/// Survival probability of event `depth`, independent of the throughput. A path reaches event n with probability
/// (N / n)⁴, with N the event at which this roulette begins. Paths trapped by total reflection keep their throughput,
/// and only this roulette ends them, after N / 3 more events on average. One in 16 million of them reaches [`LONGEST`].
/// We use a power instead of a constant probability q: a path that leaves a trap at event n is scaled by (n / N)⁴, so
/// that its variance is finite wherever the remaining throughput falls exponentially, at any rate. Scaling by q⁻ⁿ gives
/// infinite variance in any room with an albedo above √q.
#[inline]
fn lasting(depth: u32) -> f32 {
    if depth <= LASTING_FROM { 1.0 } else { ((depth - 1) as f32 / depth as f32).powi(4) }
}
