//! What integrators ask a scene: what does a ray meet, what scatters and emits there, how much light passes between points.

use super::description::AlphaMode;
use super::material::{Coordinates, Material};
use super::{ObjectInfo, Scene};
use crate::accel::{Intersector, RayClass};
use crate::bsdf::Surface;
use crate::defects::{Defect, planted};
use crate::geometry::{AnyHit, Frame, Hit, MediumId, Opaque, Ray, SurfacePoint};
use crate::light::Light;
use crate::spectrum::Spectrum;
use glam::Vec3;
use std::borrow::Cow;

/// Alpha masks: a hit counts where the alpha of its material reaches the cutoff.
pub(super) struct Mask<'a>(pub(super) &'a Scene);

impl AnyHit for Mask<'_> {
    fn accepts(&self, ray: &Ray, hit: Hit) -> bool {
        let scene = self.0;
        let (object, material) = scene.material_of(hit);
        let AlphaMode::Mask { cutoff } = material.source.alpha_mode else { return true };
        let Some(meet) = scene.geometry.triangle(hit).meet(ray) else { return false };
        material.alpha(&scene.coordinates(object, hit, meet.barycentric)) >= cutoff
    }
}

impl Scene {
    #[inline]
    fn material_of(&self, hit: Hit) -> (&ObjectInfo, &Material) {
        let object = &self.objects[hit.object as usize];
        (object, &self.materials[object.material as usize])
    }

    fn coordinates(&self, object: &ObjectInfo, hit: Hit, barycentric: [f32; 2]) -> Coordinates {
        let uvs = [0, 1].map(|set| self.geometry.uv(hit, barycentric, set));
        let color = if object.colors { self.geometry.color(hit, barycentric) } else { glam::Vec4::ONE };
        Coordinates { uvs, color }
    }

    /// The first surface that `ray` meets. Alpha masks are geometry; blended surfaces are met whatever their alpha.
    #[inline(always)] // see Walk::arrive
    pub fn intersect(&self, ray: &Ray) -> Option<SurfacePoint> {
        if let Some(contacts) = &self.contacts {
            return self.intersect_touching(contacts, ray);
        }
        let hit = if self.features.masks { self.accel.closest(ray, &Mask(self)) } else { self.accel.closest(ray, &Opaque) };
        SurfacePoint::new(&self.geometry, hit?, ray)
    }

    /// Whether the camera does not see the surface that a ray of its own in `direction` meets at `point`: the back of a
    /// single-sided material, unless it emits or transmits light. glTF wants such faces culled [glTF20 §3.9.5]; all other
    /// rays meet both sides, so that rooms stay closed and shadows whole. Connections to the camera obey the same rule.
    #[inline]
    pub fn culled(&self, point: &SurfacePoint, direction: Vec3) -> bool {
        self.features.culled && direction.dot(point.ng) > 0.0 && self.material_of(point.hit).1.is_culled()
    }

    /// The first surface that a ray of the camera meets and is not [`Scene::culled`]; blended ones whatever their alpha.
    pub fn seen(&self, mut ray: Ray) -> Option<SurfacePoint> {
        loop {
            let point = self.intersect(&ray)?;
            if !self.culled(&point, ray.direction) {
                return Some(point);
            }
            ray = point.spawn(ray.direction);
        }
    }

    /// Share of light that the surface at `point` stops: 1 unless its material blends by alpha.
    #[inline]
    pub fn coverage(&self, point: &SurfacePoint) -> f32 {
        let (object, material) = self.material_of(point.hit);
        match material.source.alpha_mode {
            AlphaMode::Blend => material.alpha(&self.coordinates(object, point.hit, point.barycentric)).clamp(0.0, 1.0),
            AlphaMode::Opaque | AlphaMode::Mask { .. } => 1.0,
        }
    }

    /// Share of light that passes along the segment `ray` (`t_max` finite, or free space to infinity). Adds to `rays` how many
    /// were traced to know it.
    #[inline]
    pub fn transmittance(&self, ray: &Ray, rays: &mut u64) -> Spectrum {
        self.accel.announce(RayClass::Shadow);
        let through = if self.features.blends && !planted(Defect::ShadowsIgnoreBlend) {
            Spectrum::splat(self.passed(*ray, rays, |point| self.coverage(point)))
        } else if self.is_occluded(ray, rays) {
            Spectrum::ZERO
        } else {
            Spectrum::ONE
        };
        if ray.medium == MediumId::VACUUM { through } else { through * self.absorption(ray.medium, segment_length(ray)) }
    }

    #[inline]
    fn is_occluded(&self, ray: &Ray, rays: &mut u64) -> bool {
        *rays += 1;
        if let Some(contacts) = self.contacts.as_deref().filter(|_| ray.touches()) {
            return self.is_occluded_touching(contacts, ray);
        }
        if self.features.masks && !planted(Defect::ShadowsIgnoreMask) {
            self.accel.occluded(ray, &Mask(self))
        } else {
            self.accel.occluded(ray, &Opaque)
        }
    }

    /// [`Scene::transmittance`] of a segment that ends at the camera, for which [`Scene::culled`] surfaces are not there.
    #[inline]
    pub fn transmittance_to_camera(&self, ray: &Ray, rays: &mut u64) -> Spectrum {
        if !self.features.culled {
            return self.transmittance(ray, rays);
        }
        self.accel.announce(RayClass::Shadow);
        let covers = |point: &SurfacePoint| if self.culled(point, -ray.direction) { 0.0 } else { self.coverage(point) };
        let through = Spectrum::splat(self.passed(*ray, rays, covers));
        if ray.medium == MediumId::VACUUM { through } else { through * self.absorption(ray.medium, segment_length(ray)) }
    }

    /// Product over the surfaces on a segment of 1 minus what each `covers`.
    fn passed(&self, mut ray: Ray, rays: &mut u64, covers: impl Fn(&SurfacePoint) -> f32) -> f32 {
        let (end, mut through) = (ray.at(ray.t_max), 1.0);
        while through > 0.0 {
            *rays += 1;
            let Some(point) = self.intersect(&ray) else { return through };
            through *= 1.0 - covers(&point);
            let next = point.spawn(ray.direction);
            let t_max = if ray.t_max.is_finite() {
                (end - next.origin).dot(ray.direction) / ray.direction.length_squared()
            } else {
                f32::INFINITY
            };
            if t_max <= 0.0 && ray.end == Hit::NONE {
                return through;
            }
            ray = Ray { t_max, end: ray.end, ..next };
        }
        through
    }

    /// What is left of light after `length` scene units in `medium` (Beer and Lambert).
    #[inline]
    pub fn absorption(&self, medium: MediumId, length: f32) -> Spectrum {
        let sigma = self.media[usize::from(medium.0)].0;
        // 0 · ∞ at a lane that does not absorb is no absorption.
        sigma.map(|s: f32| if s > 0.0 { (-s * length).exp() } else { 1.0 })
    }

    /// The medium on the side of `point` to which the unit direction `w` leads, for a ray that goes through the surface.
    #[inline]
    pub(crate) fn medium_beyond(&self, point: &SurfacePoint, w: Vec3) -> MediumId {
        if w.dot(point.ng) < 0.0 { self.material_of(point.hit).1.interior } else { MediumId::VACUUM }
    }

    /// The medium of an edge from `point` along the unit direction `w`, for a walk that came there from the direction `known` through
    /// `medium`.
    #[inline]
    pub fn medium_toward(&self, point: &SurfacePoint, known: Vec3, medium: MediumId, w: Vec3) -> MediumId {
        if !self.features.media {
            return MediumId::VACUUM;
        }
        let crosses = (w.dot(point.ng) > 0.0) != (known.dot(point.ng) > 0.0);
        if crosses { self.medium_beyond(point, w) } else { medium }
    }

    /// How the surface at `point` scatters, and its shading frame, bent by a normal map if it has one.
    #[inline]
    pub fn surface(&self, point: &mut SurfacePoint) -> Cow<'_, Surface> {
        let (object, material) = self.material_of(point.hit);
        if let (Some(surface), false, None) = (material.constant(), object.colors, &material.source.normal_texture) {
            return Cow::Borrowed(surface);
        }
        let at = self.coordinates(object, point.hit, point.barycentric);
        if let Some(frame) = self.normal_map_frame(material, point, &at) {
            point.frame = frame;
        }
        Cow::Owned(material.resolve(&at))
    }

    /// The frame around a normal map's normal; `None` without a map or usable tangents.
    fn normal_map_frame(&self, material: &Material, point: &SurfacePoint, at: &Coordinates) -> Option<Frame> {
        let (texture, scale) = material.source.normal_texture.as_ref()?;
        let [x, y, z, _] = texture.at(at.uvs[texture.uv_set]);
        let ns = point.frame.n;
        let (tangent, handedness) =
            self.geometry.tangent(point.hit, point.barycentric).or_else(|| self.uv_tangent(point, texture.uv_set))?;
        let s = (tangent - ns * ns.dot(tangent)).try_normalize()?;
        let t = ns.cross(s) * if planted(Defect::NormalMapGreen) { -handedness } else { handedness };
        let bent = s * ((2.0 * x - 1.0) * scale) + t * ((2.0 * y - 1.0) * scale) + ns * (2.0 * z - 1.0);
        let n = bent.try_normalize()?;
        (n.dot(point.ng) > 0.0).then(|| Frame::around(n))
    }

    /// A tangent along u from the triangle's texture coordinates, for meshes without tangents, and the handedness.
    fn uv_tangent(&self, point: &SurfacePoint, set: usize) -> Option<(Vec3, f32)> {
        let [a, b, c] = self.geometry.corner_uvs(point.hit, set)?;
        let [pa, pb, pc] = self.geometry.triangle(point.hit).vertices;
        let (e1, e2, d1, d2) = (pb - pa, pc - pa, b - a, c - a);
        let det = d1.perp_dot(d2);
        // glTF's v runs downward: with (u, v) as given the frame (∂u, −∂v, n) is right-handed where det < 0.
        let handedness = if det < 0.0 { 1.0 } else { -1.0 };
        let tangent = (e1 * d2.y - e2 * d1.y) * det.signum();
        Some((tangent, handedness * self.geometry.winding(point.hit.object) as f32)).filter(|_| det != 0.0)
    }

    /// The light on the primitive at `point` and its index, if it is one.
    #[inline]
    pub fn light_at(&self, point: &SurfacePoint) -> Option<(usize, &Light)> {
        let first = self.objects[point.hit.object as usize].first_light?;
        let index = (first + point.hit.primitive) as usize;
        Some((index, &self.lights.all()[index]))
    }

    /// Instance index in the file's order and material index of what is at `point`.
    pub fn ids(&self, point: &SurfacePoint) -> [u32; 2] {
        let object = &self.objects[point.hit.object as usize];
        [object.instance, object.material]
    }
}

fn segment_length(ray: &Ray) -> f32 {
    ray.direction.length() * ray.t_max
}
