//! Throughput of edges between two points. Surfaces that blend by alpha, transmit light straight through, or bound a
//! body without precedence belong to the edge and are not vertices.

use super::{ObjectInfo, Scene};
use crate::accel::RayClass;
use crate::camera::CameraPoint;
use crate::geometry::{Bodies, Hit, Ray, RayState, SurfacePoint, spawn_segment};
use crate::light::EmitterPoint;
use crate::medium::Medium;
use crate::numeric::BELOW_ONE;
use crate::spectrum::Spectrum;
use glam::Vec3;

/// Straight transmission of a surface on an edge.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Passage {
    /// Transmittance.
    pub through: Spectrum,
    /// Probability that a walk scatters at the surface; it continues with probability [`Passage::chance`].
    pub met: f32,
    /// Coverage α of the surface, which is the weight of its scattering. A walk that scatters there is weighted by α /
    /// `met`.
    pub alpha: f32,
}

/// Straight connection of a surface point to another vertex. It makes all segments, so that each carries the state of
/// its path.
#[derive(Debug, Clone, Copy)]
pub struct Edge {
    ray: Ray,
    /// Whether it ends at the camera, which does not see surfaces that are [`Scene::culled`].
    to_camera: bool,
}

/// Far end of an [`Edge`].
#[derive(Debug, Clone, Copy)]
pub enum EdgeEnd<'e> {
    /// The camera.
    Camera(CameraPoint),
    /// A light.
    Light(EmitterPoint),
    /// A surface.
    Surface(&'e SurfacePoint),
    /// A point in a medium, and σt there.
    Medium(Vec3, Spectrum),
}

/// Throughput of an edge.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct EdgeThroughput {
    /// Transmittance.
    pub through: Spectrum,
    /// Transmittance of the media that scatter alone: what free flights along the edge depend on.
    pub flight: Spectrum,
    /// Probability that a walk passes all surfaces on the edge.
    pub chance: f32,
}

impl EdgeThroughput {
    /// A free edge through empty space.
    const CLEAR: EdgeThroughput = EdgeThroughput { through: Spectrum::ONE, flight: Spectrum::ONE, chance: 1.0 };
    /// An edge that no light passes.
    const BLOCKED: EdgeThroughput = EdgeThroughput { through: Spectrum::ZERO, ..EdgeThroughput::CLEAR };

    /// Adds the part of `ray` up to its parameter `t` in `medium`.
    #[inline]
    fn cross(&mut self, medium: Option<&Medium>, ray: &Ray, t: f32) {
        let Some(medium) = medium else { return };
        let length = ray.direction.length();
        let through = medium.transmittance(ray.origin, ray.direction / length, length * t);
        self.through *= through;
        if medium.unit.scatters() {
            self.flight *= through;
        }
    }
}

impl Passage {
    /// Free passage, without a surface.
    pub const FREE: Passage = Passage { through: Spectrum::ONE, met: 0.0, alpha: 1.0 };

    /// Returns the probability that a walk continues.
    #[inline]
    pub fn chance(&self) -> f32 {
        1.0 - self.met
    }
}

impl Edge {
    /// Creates the edge from `point`, reached in `state` from either side, in the unit direction `w` to `end`.
    #[inline]
    pub fn new(scene: &Scene, point: &SurfacePoint, state: RayState, w: Vec3, end: EdgeEnd) -> Self {
        let state = scene.state_toward(point, state, w);
        let (p, error, ng, touched) = match end {
            EdgeEnd::Light(EmitterPoint::Surface { p, error, ng, touched }) => (p, error, ng, touched),
            EdgeEnd::Camera(CameraPoint { p, .. }) | EdgeEnd::Light(EmitterPoint::Point(p)) | EdgeEnd::Medium(p, _) => {
                (p, 0.0, point.ng, Hit::NONE)
            }
            EdgeEnd::Light(EmitterPoint::Distant) => {
                return Edge { ray: point.spawn(w).carrying(state), to_camera: false };
            }
            EdgeEnd::Surface(other) => (other.p, other.error, other.ng, other.touched()),
        };
        let ray = point.segment(p, error, ng, touched, state);
        Edge { ray, to_camera: matches!(end, EdgeEnd::Camera(_)) }
    }

    /// Creates the edge from the point `p` in a medium, where rays have this `state`, in the unit direction `w` to
    /// `end`.
    #[inline]
    pub fn from_medium(p: Vec3, state: RayState, w: Vec3, end: EdgeEnd) -> Self {
        let surface = |to, error, ng, touched| match touched {
            Hit::NONE => spawn_segment(p, 0.0, w, to, error, ng),
            end => Ray { t_max: BELOW_ONE, end, ..Ray::new(p, to - p) },
        };
        let ray = match end {
            EdgeEnd::Light(EmitterPoint::Surface { p, error, ng, touched }) => surface(p, error, ng, touched),
            EdgeEnd::Surface(other) => surface(other.p, other.error, other.ng, other.touched()),
            EdgeEnd::Light(EmitterPoint::Distant) => Ray::new(p, w),
            EdgeEnd::Camera(CameraPoint { p: to, .. })
            | EdgeEnd::Light(EmitterPoint::Point(to))
            | EdgeEnd::Medium(to, _) => Ray { t_max: BELOW_ONE, ..Ray::new(p, to - p) },
        };
        Edge { ray: ray.carrying(state), to_camera: matches!(end, EdgeEnd::Camera(_)) }
    }

    /// Returns its ray: up to the parameter 1, or free to infinity.
    #[inline]
    pub fn ray(&self) -> &Ray {
        &self.ray
    }
}

impl Scene {
    /// Returns whether [`Scene::passage`] may be nonzero at `point`, reached in `bodies`; a cheap test.
    #[inline]
    pub fn may_pass(&self, point: &SurfacePoint, bodies: Bodies) -> bool {
        let object = &self.objects[point.hit.object as usize];
        object.passes || self.features.nested && object.body != Bodies::NOBODY && bodies.has_more_than(object.body)
    }

    /// Returns the straight transmission of the surface at `point` along the unit direction `w`, reached in `bodies`.
    /// It is symmetric in ±`w`. An emitter is hit with its full coverage, whatever it transmits.
    pub fn passage(&self, point: &SurfacePoint, w: Vec3, bodies: Bodies) -> Passage {
        let alpha = self.coverage(point);
        let (object, _) = self.material_of(point.hit);
        let (through, chance) = if object.first_light.is_some() {
            (Spectrum::ZERO, 0.0)
        } else if self.is_null(object, bodies) {
            (Spectrum::ONE, 1.0)
        } else {
            self.straight(object, point, w, bodies).unwrap_or((Spectrum::ZERO, 0.0))
        };
        let through = Spectrum::splat(1.0 - alpha) + through * alpha;
        Passage { through, met: alpha * (1.0 - chance), alpha }
    }

    /// See [`crate::bsdf::Surface::straight`].
    fn straight(&self, object: &ObjectInfo, point: &SurfacePoint, w: Vec3, bodies: Bodies) -> Option<(Spectrum, f32)> {
        let outside = self.outer_index(object, bodies);
        if !self.materials[object.material as usize].may_pass(outside) {
            return None;
        }
        let mut point = *point;
        let whole = self.whole_surface(&mut point, outside);
        whole.straight(w.dot(point.frame.n).abs().min(1.0))
    }

    /// Returns the transmittance of `edge`, black if a surface blocks it, and adds the number of traced rays to `rays`.
    #[inline]
    pub fn transmittance(&self, edge: &Edge, rays: &mut u64) -> Spectrum {
        self.clearance(edge, rays).through
    }

    /// Returns whether no light passes `edge`, and adds the number of traced rays to `rays`.
    #[inline]
    pub fn is_blocked(&self, edge: &Edge, rays: &mut u64) -> bool {
        self.clearance(edge, rays).through.is_black()
    }

    /// Traces `edge` and returns its throughput, black if a surface blocks it: see [`Scene::transmittance`].
    #[inline]
    pub fn clearance(&self, edge: &Edge, rays: &mut u64) -> EdgeThroughput {
        let Edge { ray, to_camera } = edge;
        self.accel.announce(RayClass::Shadow);
        if self.features.content() || *to_camera && self.features.culled {
            return self.content(edge, rays);
        }
        if self.is_occluded(ray, rays) { EdgeThroughput::BLOCKED } else { self.media_of(ray) }
    }

    /// Returns the throughput of `edge`, on which nothing stops light, and the probability that walks pass it.
    pub fn throughput(&self, edge: &Edge, rays: &mut u64) -> EdgeThroughput {
        if self.features.content() { self.content(edge, rays) } else { self.media_of(&edge.ray) }
    }

    /// Returns the throughput of the medium around `ray`, on which there is no surface.
    #[inline]
    fn media_of(&self, ray: &Ray) -> EdgeThroughput {
        let mut found = EdgeThroughput::CLEAR;
        found.cross(self.medium(ray.state.bodies), ray, ray.t_max.max(0.0));
        found
    }

    /// Returns whether the end of `edge` does not see the surface at `point`.
    #[inline]
    fn is_unseen(&self, edge: &Edge, point: &SurfacePoint) -> bool {
        edge.to_camera && self.culled(point, -edge.ray.direction)
    }

    /// Steps from surface to surface along a segment, whose end is at parameter 1 if it is finite.
    fn content(&self, edge: &Edge, rays: &mut u64) -> EdgeThroughput {
        let mut ray = edge.ray;
        let (end, unit) = (ray.at(1.0), ray.direction.normalize());
        let mut found = EdgeThroughput::CLEAR;
        while !found.through.is_black() {
            *rays += 1;
            let Some(point) = self.intersect(&ray) else {
                found.cross(self.medium(ray.state.bodies), &ray, ray.t_max.max(0.0));
                break;
            };
            found.cross(self.medium(ray.state.bodies), &ray, point.t);
            if !self.is_unseen(edge, &point) {
                let passage = self.passage(&point, unit, ray.state.bodies);
                found.through *= passage.through;
                found.chance *= passage.chance();
            }
            let state = self.state_toward(&point, ray.state, ray.direction);
            let next = point.spawn(ray.direction);
            // The remaining segment is aimed at the end again: the origin was offset, and a parallel to the old ray
            // might hit the surface at the end.
            let rest = end - next.origin;
            let (direction, t_max) = if !ray.t_max.is_finite() {
                (ray.direction, ray.t_max)
            } else if rest.dot(ray.direction) > 0.0 {
                (rest, ray.t_max)
            } else if ray.end != Hit::NONE {
                // The remaining length is below rounding: keep the direction of the whole segment.
                (ray.direction, rest.dot(ray.direction) / ray.direction.length_squared())
            } else {
                break;
            };
            ray = Ray { direction, t_max, state, end: ray.end, ..next };
        }
        found
    }
}
