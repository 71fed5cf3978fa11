//! What an edge between two points carries, and what surfaces on it do: those that blend by alpha, that let light straight through, or
//! that are boundaries of bodies which do not have the place are content of the edge and no vertices.

use super::{ObjectInfo, Scene};
use crate::accel::RayClass;
use crate::defects::{Defect, planted};
use crate::geometry::{Bodies, Hit, Ray, SurfacePoint};
use crate::spectrum::Spectrum;
use glam::Vec3;

/// What a surface lets pass of an edge that meets it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Passage {
    /// Share of light that goes on.
    pub through: Spectrum,
    /// Probability with which a walk scatters there; it goes on with [`Passage::chance`].
    pub met: f32,
    /// The surface's share of what it stops: its scattering counts as often. A walk that meets it is worth this over `met`.
    pub alpha: f32,
}

/// What an edge carries.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Edge {
    /// Share of light.
    pub through: Spectrum,
    /// Probability with which a walk passes all that is on it.
    pub chance: f32,
}

impl Passage {
    /// Where nothing is.
    pub const FREE: Passage = Passage { through: Spectrum::ONE, met: 0.0, alpha: 1.0 };

    /// The probability with which a walk goes on.
    #[inline]
    pub fn chance(&self) -> f32 {
        1.0 - self.met
    }
}

impl Scene {
    /// Whether [`Scene::passage`] may let something pass at `point`, met in `bodies`; cheap to know.
    #[inline]
    pub fn may_pass(&self, point: &SurfacePoint, bodies: Bodies) -> bool {
        let object = &self.objects[point.hit.object as usize];
        object.passes || self.features.nested && object.body != Bodies::NOBODY && bodies.has_more_than(object.body)
    }

    /// What the surface at `point` lets pass straight on along the unit direction `w`, met in `bodies`. It is the same against `w`. What
    /// emits light is met whatever it lets through.
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

    /// Share of light that passes along the segment `ray` (`t_max` finite, or free space to infinity). Adds to `rays` how many
    /// were traced to know it.
    #[inline]
    pub fn transmittance(&self, ray: &Ray, rays: &mut u64) -> Spectrum {
        self.accel.announce(RayClass::Shadow);
        if self.features.content() && !planted(Defect::ShadowsIgnoreBlend) {
            return self.content(*ray, rays, |_| false).through;
        }
        if self.is_occluded(ray, rays) { Spectrum::ZERO } else { self.absorption(ray.bodies, segment_length(ray)) }
    }

    /// [`Scene::transmittance`] of a segment that ends at the camera, for which [`Scene::culled`] surfaces are not there.
    #[inline]
    pub fn transmittance_to_camera(&self, ray: &Ray, rays: &mut u64) -> Spectrum {
        if !self.features.culled {
            return self.transmittance(ray, rays);
        }
        self.accel.announce(RayClass::Shadow);
        self.content(*ray, rays, |point| self.culled(point, -ray.direction)).through
    }

    /// What the segment `ray`, which is known to be free, carries, and the probability with which walks pass it; surfaces are not there
    /// that `unseen` says.
    pub fn edge(&self, ray: &Ray, rays: &mut u64, unseen: impl Fn(&SurfacePoint) -> bool) -> Edge {
        if self.features.content() {
            return self.content(*ray, rays, unseen);
        }
        Edge { through: self.absorption(ray.bodies, segment_length(ray)), chance: 1.0 }
    }

    /// From surface to surface along a segment, whose end is at parameter 1 if it is finite.
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
            // What is left is aimed at the end again: the origin was moved, and a parallel to the old ray may meet the end's own surface.
            let rest = end - next.origin;
            let (direction, t_max) = if !ray.t_max.is_finite() {
                (ray.direction, ray.t_max)
            } else if rest.dot(ray.direction) > 0.0 {
                (rest, ray.t_max)
            } else if ray.end != Hit::NONE {
                // The rest of the way is less than rounding: its heading is that of the whole.
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
