//! A walk from the camera toward the lights or the other way: the state that is carried from vertex to vertex.
//!
//! Use it as `arrive`, look at the vertex, `depart`, `survives`, and again. Blended surfaces, what lets light straight
//! through, boundaries that are not there and absorbing media are content of the edge between two vertices and never vertices themselves.

use crate::accel::RayClass;
use crate::bsdf::{ShadingSample, Surface};
use crate::defects::{Defect, planted};
use crate::geometry::{Bodies, Ray, SurfacePoint};
use crate::light::{AreaLight, Receiver};
use crate::numeric::BELOW_ONE;
use crate::sampling::{Density, Sampler, Slot};
use crate::scene::{Passage, Scene};
use crate::spectrum::Spectrum;
use crate::transport::Transport;

/// How many scattering and null events a path may have before it is taken for a defect of the scene and cut.
const LONGEST: u32 = 1 << 14;

/// Scattering events before roulette by depth begins: more than a path has that carries light anywhere but in a trap.
const LASTING_FROM: u32 = 256;

/// Scattering events before Russian roulette begins.
const ROULETTE_FROM: u32 = 2;

/// A path survives roulette with this times its throughput. relMSE × rays on the Cornell box at 1, 2, 3, 4, 6, 10 is .95, .68,
/// .66, .66, .68, .71: paths that are cut as soon as their throughput falls leave noise that costs more than it saves.
const ROULETTE_GAIN: f32 = 3.0;

/// Counts of what walks did.
#[derive(Debug, Clone, Copy, Default)]
pub struct Tally {
    /// Rays from the camera, those beyond surfaces that it does not see or sees through included.
    pub cameras: u64,
    /// Rays from a scattering event or a light, counted where they are traced.
    pub bounces: u64,
    /// Rays toward lights, those beyond blended surfaces included.
    pub shadows: u64,
    /// Hits that disagree with their triangle.
    pub bad_hits: u64,
    /// Paths that reached the emergency limit.
    pub overlong: u64,
}

impl Tally {
    /// Adds what other walks did.
    pub fn absorb(&mut self, other: &Tally) {
        self.cameras += other.cameras;
        self.bounces += other.bounces;
        self.shadows += other.shadows;
        self.bad_hits += other.bad_hits;
        self.overlong += other.overlong;
    }
}

/// Where the last edge of a walk began.
#[derive(Debug, Clone, Copy)]
pub enum Departure {
    /// At the camera.
    Camera,
    /// At a light.
    Light,
    /// At a surface point, in a direction of this density.
    Surface(Receiver, Density),
}

/// The state of a walk.
pub struct Walk<'a> {
    scene: &'a Scene,
    /// The end that it goes to.
    pub toward: Transport,
    /// The current edge, in a unit direction.
    pub ray: Ray,
    /// Product of all scattering values and transmittances over their densities.
    pub beta: Spectrum,
    /// Where the current edge began.
    pub departure: Departure,
    /// Number of scattering events so far.
    pub depth: u32,
    /// What numbers are addressed by: the vertex that is left, counted from 0; a light has the 0 of its own walk.
    pub bounce: u32,
    /// Probability of having survived roulette, and of having met or passed what lets light straight through, so far: the throughput is
    /// over it.
    pub survival: f32,
    /// Whether it came from its beginning by Dirac components alone.
    pub straight: bool,
    /// What takes out of the throughput that which roulette must not see: the emitted power, or the square of the refractive index
    /// at the camera over the one here, since radiance is scaled by it and will be scaled back.
    scale: f32,
}

impl<'a> Walk<'a> {
    /// A walk along the camera ray `ray`, from within whatever contains its origin.
    #[inline]
    pub fn new(scene: &'a Scene, ray: Ray) -> Self {
        let bodies = if planted(Defect::CameraInVacuum) { Bodies::NONE } else { scene.bodies_at(ray.origin) };
        let ray = Ray { bodies, ..ray };
        let (beta, departure) = (Spectrum::ONE, Departure::Camera);
        Walk {
            scene,
            toward: Transport::Light,
            ray,
            beta,
            departure,
            depth: 0,
            bounce: 0,
            survival: 1.0,
            straight: true,
            scale: 1.0,
        }
    }

    /// A walk along a ray of light that stands for `power`, which is not black, in the bodies that the ray says.
    pub fn from_light(scene: &'a Scene, ray: Ray, power: Spectrum) -> Self {
        let (departure, scale) = (Departure::Light, power.max_lane().recip());
        Walk {
            scene,
            toward: Transport::Camera,
            ray,
            beta: power,
            departure,
            depth: 0,
            bounce: 1,
            survival: 1.0,
            straight: true,
            scale,
        }
    }

    /// Follows the current edge to the surface at its end; `None` where it leaves the scene. What lets light straight on (see
    /// [`Passage`]) is met with a probability and passed otherwise; what the camera does not see is passed by its rays.
    #[inline(always)] // a call would copy the point through memory: a tenth of the time of a simple scene
    pub fn arrive(&mut self, sampler: &mut impl Sampler, tally: &mut Tally) -> Option<SurfacePoint> {
        let mut point = self.trace(tally);
        if let Some(first) = &point {
            if self.scene.features().content() && self.scene.may_pass(first, self.ray.bodies) || self.unseen(first) {
                point = self.past(*first, sampler, tally);
            }
        }
        self.absorb(point.as_ref().map_or(f32::INFINITY, |p| p.t));
        tally.bad_hits += u64::from(point.as_ref().is_some_and(|p| !p.consistent));
        point
    }

    /// What the current edge meets first.
    #[inline(always)] // see `arrive`
    fn trace(&self, tally: &mut Tally) -> Option<SurfacePoint> {
        let class = match self.departure {
            Departure::Camera => RayClass::Camera,
            Departure::Light | Departure::Surface(..) => RayClass::Bounce(self.depth),
        };
        match class {
            RayClass::Camera => tally.cameras += 1,
            _ => tally.bounces += 1,
        }
        self.scene.accel().announce(class);
        self.scene.intersect(&self.ray)
    }

    /// Whether the current edge is the camera's and does not see the surface at `point`.
    #[inline]
    fn unseen(&self, point: &SurfacePoint) -> bool {
        matches!(self.departure, Departure::Camera) && self.scene.culled(point, self.ray.direction)
    }

    /// The first surface from `point` on that the edge does not pass; the edge then begins behind those that it did.
    #[cold]
    fn past(&mut self, mut point: SurfacePoint, sampler: &mut impl Sampler, tally: &mut Tally) -> Option<SurfacePoint> {
        let mut u = sampler.u1(self.bounce, Slot::Event);
        for _ in 0..LONGEST {
            let w = self.ray.direction;
            let passage = if self.unseen(&point) { Passage::FREE } else { self.scene.passage(&point, w, self.ray.bodies) };
            let (met, chance) = (passage.met, passage.chance());
            if u < met {
                self.beta *= passage.alpha / met;
                self.survival *= met;
                return Some(point);
            }
            // What is left of u is uniform again: one number serves all surfaces of the edge.
            if !planted(Defect::BlendsShareNumber) {
                u = ((u - met) / chance).min(BELOW_ONE);
            }
            self.absorb(point.t);
            self.beta *= passage.through.map(|t: f32| t / chance);
            self.survival *= chance;
            let bodies = self.scene.bodies_toward(&point, self.ray.bodies, w);
            self.ray = Ray { bodies, time: self.ray.time, ..point.spawn(w) };
            point = self.trace(tally)?;
        }
        tally.overlong += 1;
        self.beta = Spectrum::ZERO;
        None
    }

    #[inline]
    fn absorb(&mut self, length: f32) {
        if !self.ray.bodies.is_empty() && self.scene.features().media && !planted(Defect::GlassClear) {
            self.beta *= self.scene.absorption(self.ray.bodies, length);
        }
    }

    /// Whether the walk sees what `light`, which it found on a surface, emits: what lights nothing is seen by those of the camera that
    /// came by Dirac components alone.
    #[inline]
    pub fn sees(&self, light: &AreaLight) -> bool {
        self.straight || !light.is_only_seen() || planted(Defect::UnlitIsLamp)
    }

    /// The numbers for scattering by `surface`. Models with one lobe do not look at the one that chooses among several.
    #[inline]
    pub fn scattering_numbers(&self, surface: &Surface, sampler: &mut impl Sampler) -> [f32; 3] {
        let lobe = if surface.is_single_lobe() { 0.0 } else { sampler.u1(self.bounce, Slot::Lobe) };
        let [u, v] = sampler.u2(self.bounce, Slot::Direction);
        [lobe, u, v]
    }

    /// Leaves `point` as `scatter` says.
    #[inline]
    pub fn depart(&mut self, point: &SurfacePoint, scatter: &ShadingSample) {
        self.beta *= scatter.weight;
        if self.toward == Transport::Light {
            self.scale *= scatter.eta * scatter.eta;
        }
        self.straight &= scatter.density.is_delta();
        self.depth += 1;
        self.bounce += 1;
        let bodies = self.scene.bodies_toward(point, self.ray.bodies, scatter.direction);
        let density = match self.departure {
            Departure::Surface(_, before @ Density::Delta(_)) if planted(Defect::EmissionTwiceAfterDirac) => before,
            _ => scatter.density,
        };
        self.departure = Departure::Surface(Receiver::from(point), density);
        self.ray = Ray { bodies, time: self.ray.time, ..point.spawn(scatter.direction) };
    }

    /// Russian roulette by the share of light that is left, and by depth. Whoever survives is scaled up.
    #[inline]
    pub fn survives(&mut self, sampler: &mut impl Sampler, tally: &mut Tally) -> bool {
        if self.depth >= LONGEST {
            tally.overlong += 1;
            return false;
        }
        if self.depth < ROULETTE_FROM {
            return !self.beta.is_black();
        }
        let share = (ROULETTE_GAIN * self.beta.max_lane() * self.scale).min(1.0);
        let q = share.min(lasting(self.depth));
        if q < 1.0 {
            if sampler.u1(self.bounce, Slot::Roulette) >= q {
                return false;
            }
            let mut paid = if planted(Defect::RouletteUnpaid) { 1.0 } else { q };
            if planted(Defect::RouletteEta2) {
                paid = (q / self.scale).min(1.0);
            }
            if planted(Defect::DepthRouletteUnpaid) && q < share {
                paid = share;
            }
            self.beta *= paid.recip();
            self.survival *= q;
        }
        true
    }
}

/// Probability with which a path survives event `depth`, whatever it carries: it comes to event n with (N / n)⁴, N the event from which
/// this holds. Paths that total reflection has trapped carry all their light, and only this ends them: after N / 3 more events on
/// average; [`LONGEST`] is reached by one in 16 million of them. A power and not a constant probability q: what leaves a trap at event n
/// is scaled by (n / N)⁴, so that its variance is finite wherever the share that is left falls exponentially, however slowly; scaled by
/// q⁻ⁿ it is infinite in any room of an albedo above √q.
#[inline]
fn lasting(depth: u32) -> f32 {
    if depth <= LASTING_FROM { 1.0 } else { ((depth - 1) as f32 / depth as f32).powi(4) }
}
