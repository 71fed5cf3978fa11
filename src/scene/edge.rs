//! Throughput of edges between two points. Surfaces that blend by alpha, transmit light straight through, or bound a
//! body without precedence belong to the edge and are not vertices.

use super::{ObjectInfo, Scene};
use crate::accel::RayClass;
use crate::geometry::{Bodies, Hit, Ray, SurfacePoint};
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

/// Throughput of an edge.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Edge {
    /// Transmittance.
    pub through: Spectrum,
    /// Probability that a walk passes all surfaces on the edge.
    pub chance: f32,
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

    /// Returns the transmittance along the segment `ray` (`t_max` finite, or free space to infinity). Adds the number
    /// of traced rays to `rays`.
    #[inline]
    pub fn transmittance(&self, ray: &Ray, rays: &mut u64) -> Spectrum {
        self.accel.announce(RayClass::Shadow);
        if self.features.content() {
            return self.content(*ray, rays, |_| false).through;
        }
        if self.is_occluded(ray, rays) { Spectrum::ZERO } else { self.absorption(ray.bodies, segment_length(ray)) }
    }

    /// Returns [`Scene::transmittance`] of a segment that ends at the camera, for which [`Scene::culled`] surfaces are
    /// ignored.
    #[inline]
    pub fn transmittance_to_camera(&self, ray: &Ray, rays: &mut u64) -> Spectrum {
        if !self.features.culled {
            return self.transmittance(ray, rays);
        }
        self.accel.announce(RayClass::Shadow);
        self.content(*ray, rays, |point| self.culled(point, -ray.direction)).through
    }

    /// Returns the throughput of the unoccluded segment `ray`, and the probability that walks pass it. Surfaces for
    /// which `unseen` is true are ignored.
    pub fn edge(&self, ray: &Ray, rays: &mut u64, unseen: impl Fn(&SurfacePoint) -> bool) -> Edge {
        if self.features.content() {
            return self.content(*ray, rays, unseen);
        }
        Edge { through: self.absorption(ray.bodies, segment_length(ray)), chance: 1.0 }
    }

    /// Steps from surface to surface along a segment, whose end is at parameter 1 if it is finite.
    fn content(&self, mut ray: Ray, rays: &mut u64, unseen: impl Fn(&SurfacePoint) -> bool) -> Edge {
        let (end, unit) = (ray.at(1.0), ray.direction.normalize());
        let mut edge = Edge { through: Spectrum::ONE, chance: 1.0 };
        while !edge.through.is_black() {
            *rays += 1;
            let Some(point) = self.intersect(&ray) else {
                edge.through *= self.absorption(ray.bodies, segment_length(&ray));
                break;
            };
            edge.through *= self.absorption(ray.bodies, ray.direction.length() * point.t);
            if !unseen(&point) {
                let passage = self.passage(&point, unit, ray.bodies);
                edge.through *= passage.through;
                edge.chance *= passage.chance();
            }
            let bodies = self.bodies_toward(&point, ray.bodies, ray.direction);
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
            ray = Ray { direction, t_max, bodies, end: ray.end, ..next };
        }
        edge
    }
}

fn segment_length(ray: &Ray) -> f32 {
    ray.direction.length() * ray.t_max.max(0.0)
}
