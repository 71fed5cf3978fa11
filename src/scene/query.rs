//! Scene queries of integrators: intersection, scattering and emission.

use super::description::AlphaMode;
use super::material::{Coordinates, Material};
use super::{ObjectInfo, Scene, TexturedSurface};
use crate::accel::{Coherence, Intersector};
use crate::bsdf::Surface;
use crate::geometry::{AnyHit, Bodies, Frame, Hit, Hits, Opaque, Ray, Rays, SurfacePoint};
use crate::light::Light;
use crate::texture::Texture;
use glam::Vec3;
use std::borrow::Cow;

/// Alpha masks: a candidate is a hit where the alpha of its material reaches the cutoff.
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
    pub(super) fn material_of(&self, hit: Hit) -> (&ObjectInfo, &Material) {
        let object = &self.objects[hit.object as usize];
        (object, &self.materials[object.material as usize])
    }

    fn coordinates(&self, object: &ObjectInfo, hit: Hit, barycentric: [f32; 2]) -> Coordinates {
        // Written out, since `std::array::map` is not always inlined.
        let uvs = [self.geometry.uv(hit, barycentric, 0), self.geometry.uv(hit, barycentric, 1)];
        let color = if object.colors { self.geometry.color(hit, barycentric) } else { glam::Vec4::ONE };
        Coordinates { uvs, color }
    }

    /// Returns the first surface hit by `ray`. Alpha masks are geometry; blended surfaces are hit whatever their alpha.
    #[inline(always)] // see Walk::arrive
    pub fn intersect(&self, ray: &Ray) -> Option<SurfacePoint> {
        if let Some(contacts) = &self.contacts {
            return self.intersect_touching(contacts, ray);
        }
        let hit =
            if self.features.masks { self.accel.closest(ray, &Mask(self)) } else { self.accel.closest(ray, &Opaque) };
        SurfacePoint::new(&self.geometry, hit?, ray)
    }

    /// Returns whether the surface hit at `point` is culled for a camera ray in `direction`: the back of a single-sided
    /// material, unless it emits or transmits light. glTF wants such faces culled [glTF20 §3.9.5]. All other rays hit
    /// both sides, so that rooms stay closed and shadows complete. Connections to the camera follow the same rule.
    #[inline]
    pub fn culled(&self, point: &SurfacePoint, direction: Vec3) -> bool {
        self.features.culled && direction.dot(point.ng) > 0.0 && self.material_of(point.hit).1.is_culled()
    }

    /// Returns the first surface on a camera ray that is not [`Scene::culled`]; blended surfaces are hit whatever their
    /// alpha.
    pub fn seen(&self, mut ray: Ray) -> Option<SurfacePoint> {
        loop {
            let point = self.intersect(&ray)?;
            if !self.culled(&point, ray.direction) {
                return Some(point);
            }
            ray = point.spawn(ray.direction);
        }
    }

    /// Returns the fraction of light stopped by the surface at `point`: 1 unless its material blends by alpha.
    #[inline]
    pub fn coverage(&self, point: &SurfacePoint) -> f32 {
        let (object, material) = self.material_of(point.hit);
        match material.source.alpha_mode {
            AlphaMode::Blend => material.alpha(&self.coordinates(object, point.hit, point.barycentric)).clamp(0.0, 1.0),
            AlphaMode::Opaque | AlphaMode::Mask { .. } => 1.0,
        }
    }

    #[inline]
    pub(super) fn is_occluded(&self, ray: &Ray, rays: &mut u64) -> bool {
        *rays += 1;
        if let Some(contacts) = self.contacts.as_deref().filter(|_| ray.touches()) {
            return self.is_occluded_touching(contacts, ray);
        }
        if self.features.masks { self.accel.occluded(ray, &Mask(self)) } else { self.accel.occluded(ray, &Opaque) }
    }

    /// Returns the scattering of the surface at `point`, reached in `bodies`, and sets its shading frame, perturbed by
    /// a normal map if it has one. Straight transmission is excluded: see [`Scene::passage`].
    #[inline]
    pub fn surface(&self, point: &mut SurfacePoint, bodies: Bodies) -> Cow<'_, Surface> {
        let (object, material) = self.material_of(point.hit);
        match material.constant() {
            Some([_, rest]) if object.plain => Cow::Borrowed(rest),
            _ => self.resolved(point, bodies),
        }
    }

    /// [`Scene::surface`] for surfaces that vary with position.
    #[inline(never)] // in its callers it costs simple scenes 3 % of their time
    fn resolved(&self, point: &mut SurfacePoint, bodies: Bodies) -> Cow<'_, Surface> {
        let (object, material) = self.material_of(point.hit);
        let outside = self.outer_index(object, bodies);
        if let (Some([whole, rest]), false, None, true) =
            (material.constant(), object.colors, &material.source.normal_texture, is_vacuum(outside))
        {
            if whole.refracts() {
                point.frame = eased(point);
            }
            return Cow::Borrowed(rest);
        }
        let whole = self.whole_surface(point, outside);
        Cow::Owned(if object.first_light.is_some() { whole } else { whole.rest() })
    }

    /// Returns the full surface at `point`, including straight transmission, with the outside index `outside`.
    pub(super) fn whole_surface(&self, point: &mut SurfacePoint, outside: f32) -> Surface {
        let (object, material) = self.material_of(point.hit);
        let at = self.coordinates(object, point.hit, point.barycentric);
        if let Some((texture, _)) = &material.source.normal_texture {
            self.bend(point, texture.at(at.uvs[texture.uv_set]));
        }
        let whole = match material.constant() {
            Some([whole, _]) if !object.colors && is_vacuum(outside) => *whole,
            _ => material.resolve(&at, outside),
        };
        if whole.refracts() {
            point.frame = eased(point);
        }
        whole
    }

    /// Perturbs the shading frame of `point` by `value` of the normal map of its surface.
    pub fn bend(&self, point: &mut SurfacePoint, value: [f32; 4]) {
        if let Some((texture, scale)) = &self.material_of(point.hit).1.source.normal_texture {
            point.frame = self.mapped_frame(texture, *scale, point, value).unwrap_or(point.frame);
        }
    }

    /// Returns the frame at `point` around the normal `value` of the normal map `texture` times `scale`; `None` without
    /// usable tangents.
    fn mapped_frame(&self, texture: &Texture, scale: f32, point: &SurfacePoint, value: [f32; 4]) -> Option<Frame> {
        let ([x, y, z, _], ns) = (value, point.frame.n);
        let (tangent, handedness) =
            self.geometry.tangent(point.hit, point.barycentric).or_else(|| self.uv_tangent(point, texture))?;
        let s = (tangent - ns * ns.dot(tangent)).try_normalize()?;
        let t = ns.cross(s) * handedness;
        let bent = s * ((2.0 * x - 1.0) * scale) + t * ((2.0 * y - 1.0) * scale) + ns * (2.0 * z - 1.0);
        let n = bent.try_normalize()?;
        (n.dot(point.ng) > 0.0).then(|| Frame::around(n))
    }

    /// Returns a tangent along u and its handedness, from the triangle's texture coordinates as transformed by
    /// `texture`, for meshes without tangents. Tangents of a mesh are used unchanged: glTF defines them for the map
    /// after the transform.
    fn uv_tangent(&self, point: &SurfacePoint, texture: &Texture) -> Option<(Vec3, f32)> {
        let uvs = self.geometry.corner_uvs(point.hit, texture.uv_set)?;
        let [a, b, c] = uvs.map(|uv| texture.transform.transform_point2(uv));
        let [pa, pb, pc] = self.geometry.triangle(point.hit).vertices;
        let (e1, e2, d1, d2) = (pb - pa, pc - pa, b - a, c - a);
        let det = d1.perp_dot(d2);
        // In glTF v runs downward: with (u, v) as given the frame (∂u, −∂v, n) is right-handed where det < 0.
        let handedness = if det < 0.0 { 1.0 } else { -1.0 };
        let tangent = (e1 * d2.y - e2 * d1.y) * det.signum();
        Some((tangent, handedness * self.geometry.winding(point.hit.object) as f32)).filter(|_| det != 0.0)
    }

    /// Returns the light on the primitive at `point` and its index, if it emits.
    #[inline]
    pub fn light_at(&self, point: &SurfacePoint) -> Option<(usize, &Light)> {
        self.light_of(point.hit)
    }

    /// Returns the light on the primitive `hit` and its index, if it emits.
    #[inline]
    pub fn light_of(&self, hit: Hit) -> Option<(usize, &Light)> {
        let first = self.objects[hit.object as usize].first_light?;
        let index = (first + hit.primitive) as usize;
        Some((index, &self.lights.all()[index]))
    }

    /// Returns whether the triangles of object number `object` emit.
    pub fn emits(&self, object: usize) -> bool {
        self.objects[object].first_light.is_some()
    }

    /// Returns whether the camera does not see the back of object number `object`: see [`Scene::culled`].
    pub fn may_be_culled(&self, object: usize) -> bool {
        self.materials[self.objects[object].material as usize].is_culled()
    }

    /// Returns the surface of object number `object` if it is the same everywhere and in every medium, apart from the
    /// normals of its mesh.
    pub fn constant_surface(&self, object: usize) -> Option<&Surface> {
        let object = &self.objects[object];
        let [_, rest] = self.materials[object.material as usize].constant()?;
        object.plain.then_some(rest)
    }

    /// Returns the surface of object number `object` if textures alone make it vary, those of a [`TexturedSurface`].
    pub fn textured_surface(&self, object: usize) -> Option<TexturedSurface<'_>> {
        let object = &self.objects[object];
        let source = &self.materials[object.material as usize].source;
        let normal = source.normal_texture.as_ref().map(|(texture, _)| texture);
        source.model.textured(normal).filter(|_| !object.colors)
    }

    /// Returns whether light may pass object number `object`.
    pub fn transmits(&self, object: usize) -> bool {
        self.materials[self.objects[object].material as usize].source.model.transmits()
    }

    /// Finds the first hits of `rays` in a scene without contacts: see [`Scene::intersect`].
    pub fn intersect_all(&self, rays: &Rays, coherence: Coherence, hits: &mut Hits) {
        if self.features.masks {
            self.accel.closest_all(rays, coherence, &Mask(self), hits);
        } else {
            self.accel.closest_all(rays, coherence, &Opaque, hits);
        }
    }

    /// Finds which of `rays` hit anything in a scene without contacts, and without surfaces that light may pass.
    pub fn occluded_all(&self, rays: &Rays, coherence: Coherence, occluded: &mut [bool]) {
        if self.features.masks {
            self.accel.occluded_all(rays, coherence, &Mask(self), occluded);
        } else {
            self.accel.occluded_all(rays, coherence, &Opaque, occluded);
        }
    }

    /// Returns the instance index in file order and the material index at `point`.
    pub fn ids(&self, point: &SurfacePoint) -> [u32; 2] {
        let object = &self.objects[point.hit.object as usize];
        [object.instance, object.material]
    }
}

/// Returns whether an index is that of empty space.
#[inline]
fn is_vacuum(index: f32) -> bool {
    (index - 1.0).abs() <= 0.0
}

/// Weight of the geometric normal in the shading normal of refracting solids. Where both sides of an edge have the same
/// normals, reflections at either face are those of one plane: total internal reflection traps light in the edge, 3.5 %
/// of what hits a cube with corner normals. Any weight separates the faces. A tenth changes a tenth of the normal's
/// deviation, under a degree on a sphere of 16 segments.
const EASE: f32 = 0.1;

/// Returns the frame at `point` with its normal moved toward the geometric one by [`EASE`]. It depends on position
/// only, so that camera and light subpaths agree.
#[inline]
fn eased(point: &SurfacePoint) -> Frame {
    let (ns, ng) = (point.frame.n, point.ng);
    if ns == ng { point.frame } else { Frame::around((ns + (ng - ns) * EASE).normalize()) }
}
