//! All geometry of a scene, as passed to backends.

use crate::geometry::{Bounds, Hit, Triangle, TriangleMesh};
use glam::{Affine3A, Vec2, Vec3, Vec4};
use std::sync::Arc;

/// A placed mesh.
#[derive(Debug, Clone)]
pub struct Object {
    /// Index into [`Geometry::meshes`].
    pub mesh: u32,
    /// Object-to-world transform of an instance (invertible); `None` if the mesh is in world space.
    pub placement: Option<Affine3A>,
    /// Whether the [`super::AnyHit`] filter applies to it.
    pub filtered: bool,
}

/// Meshes and the objects that place them. A [`Hit`] refers to an object by its index.
#[derive(Debug, Clone, Default)]
pub struct Geometry {
    /// The distinct meshes.
    pub meshes: Vec<Arc<TriangleMesh>>,
    /// The objects of the world.
    pub objects: Vec<Object>,
}

impl Geometry {
    /// Returns the mesh of object `object`.
    #[inline]
    pub fn mesh_of(&self, object: u32) -> &TriangleMesh {
        &self.meshes[self.objects[object as usize].mesh as usize]
    }

    /// Returns the world-space triangle of `hit`.
    #[inline]
    pub fn triangle(&self, hit: Hit) -> Triangle {
        let object = &self.objects[hit.object as usize];
        let mesh = &self.meshes[object.mesh as usize];
        let [a, b, c] = mesh.corners(hit.primitive);
        match &object.placement {
            None => Triangle::new(a, b, c),
            Some(m) => Triangle::placed(m, a, b, c),
        }
    }

    /// Returns the world-space bounding box of object `object`.
    pub fn bounds(&self, object: u32) -> Bounds {
        let placement = self.objects[object as usize].placement;
        let world = |p: &Vec3| placement.map_or(*p, |m| m.transform_point3(*p));
        Bounds::around(self.mesh_of(object).positions().iter().map(world))
    }

    /// Returns +1 where the object's winding is that of the mesh, −1 where its placement mirrors. In glTF a node with a
    /// negative determinant flips the winding, so that fronts stay fronts [glTF20 §3.7.4].
    #[inline]
    pub fn winding(&self, object: u32) -> f64 {
        match &self.objects[object as usize].placement {
            Some(m) if m.matrix3.determinant() < 0.0 => -1.0,
            _ => 1.0,
        }
    }

    /// Returns the interpolated shading normal at a hit, of unit length; `None` if the mesh has none or the
    /// interpolated normal vanishes.
    #[inline]
    pub fn shading_normal(&self, hit: Hit, barycentric: [f32; 2]) -> Option<Vec3> {
        self.interpolated(hit.object, self.corner_normals(hit)?, barycentric)
    }

    /// Returns the shading normals at the corners of the triangle of `hit`, as its mesh has them; `None` if it has none.
    #[inline]
    pub fn corner_normals(&self, hit: Hit) -> Option<[Vec3; 3]> {
        let mesh = self.mesh_of(hit.object);
        let normals = mesh.attributes().normals.as_ref()?;
        let [a, b, c] = mesh.triangles()[hit.primitive as usize];
        Some([normals[a as usize], normals[b as usize], normals[c as usize]])
    }

    /// Does [`Geometry::shading_normal`] with the [`Geometry::corner_normals`] of a triangle of `object`.
    #[inline]
    pub fn interpolated(&self, object: u32, normals: [Vec3; 3], barycentric: [f32; 2]) -> Option<Vec3> {
        let n = between(normals, barycentric);
        match &self.objects[object as usize].placement {
            None => n.try_normalize(),
            Some(m) => (m.matrix3.inverse().transpose() * n).try_normalize(),
        }
    }

    /// Returns the interpolated tangent at a hit in world space (not orthonormalised), with its handedness.
    pub fn tangent(&self, hit: Hit, barycentric: [f32; 2]) -> Option<(Vec3, f32)> {
        let object = &self.objects[hit.object as usize];
        let mesh = &self.meshes[object.mesh as usize];
        let tangents = mesh.attributes().tangents.as_ref()?;
        let corners = mesh.triangles()[hit.primitive as usize];
        let t: Vec4 = mix(tangents, corners, barycentric);
        let handedness = tangents[corners[0] as usize].w;
        Some(match &object.placement {
            None => (t.truncate(), handedness),
            Some(m) => (m.matrix3 * t.truncate(), handedness * self.winding(hit.object) as f32),
        })
    }

    /// Returns the texture coordinates of `set` at a hit; the origin where the mesh has none.
    #[inline]
    pub fn uv(&self, hit: Hit, barycentric: [f32; 2], set: usize) -> Vec2 {
        let mesh = self.mesh_of(hit.object);
        let uvs = &mesh.attributes().uvs[set];
        uvs.as_ref().map_or(Vec2::ZERO, |uvs| mix(uvs, mesh.triangles()[hit.primitive as usize], barycentric))
    }

    /// Returns the texture coordinates of `set` at the corners of a triangle, if the mesh has them.
    pub fn corner_uvs(&self, hit: Hit, set: usize) -> Option<[Vec2; 3]> {
        let mesh = self.mesh_of(hit.object);
        let uvs = mesh.attributes().uvs[set].as_ref()?;
        Some(mesh.triangles()[hit.primitive as usize].map(|i| uvs[i as usize]))
    }

    /// Returns the vertex colours at the corners of a triangle, if the mesh has them.
    pub fn corner_colors(&self, hit: Hit) -> Option<[Vec4; 3]> {
        let mesh = self.mesh_of(hit.object);
        let colors = mesh.attributes().colors.as_ref()?;
        Some(mesh.triangles()[hit.primitive as usize].map(|i| colors[i as usize]))
    }

    /// Returns the vertex colour at a hit; white where the mesh has none.
    #[inline]
    pub fn color(&self, hit: Hit, barycentric: [f32; 2]) -> Vec4 {
        let mesh = self.mesh_of(hit.object);
        let colors = &mesh.attributes().colors;
        colors.as_ref().map_or(Vec4::ONE, |colors| mix(colors, mesh.triangles()[hit.primitive as usize], barycentric))
    }
}

/// Interpolates `values` at the three `corners` with the weights `barycentric`.
#[inline]
fn mix<V>(values: &[V], corners: [u32; 3], barycentric: [f32; 2]) -> V
where
    V: Copy + std::ops::Mul<f32, Output = V> + std::ops::Add<Output = V>,
{
    let [a, b, c] = corners;
    between([values[a as usize], values[b as usize], values[c as usize]], barycentric)
}

/// Interpolates between the values at three corners.
#[inline]
fn between<V>([a, b, c]: [V; 3], [u, v]: [f32; 2]) -> V
where
    V: Copy + std::ops::Mul<f32, Output = V> + std::ops::Add<Output = V>,
{
    a * (1.0 - u - v) + b * u + c * v
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::Attributes;

    /// Normals of a flat mesh stay perpendicular to it, whatever its placement scales and shears.
    #[test]
    fn placed_normals_stay_perpendicular() {
        let positions = vec![Vec3::new(1.0, 0.0, 0.0), Vec3::new(0.0, 1.0, 0.0), Vec3::new(0.0, 0.0, 1.0)];
        let normals = Some(vec![Vec3::ONE.normalize(); 3].into());
        let mesh =
            TriangleMesh::new("flat", positions, vec![[0, 1, 2]], Attributes { normals, ..Attributes::default() });
        let squeeze = Affine3A::from_scale(Vec3::new(0.2, 1.0, -3.0)) * Affine3A::from_rotation_y(0.7);
        let object = Object { mesh: 0, placement: Some(squeeze), filtered: false };
        let geometry = Geometry { meshes: vec![Arc::new(mesh.expect("a valid mesh"))], objects: vec![object] };
        let hit = Hit { object: 0, primitive: 0 };
        let ns = geometry.shading_normal(hit, [0.3, 0.3]).expect("a normal");
        let cos = ns.as_dvec3().dot(geometry.triangle(hit).scaled_normal().normalize());
        // a matrix inverted in f32, of condition 15: sixteen roundings of it
        assert!((cos.abs() - 1.0).abs() < f64::from(16.0 * 15.0 * f32::EPSILON), "{cos}");
    }
}
