//! Geometry of a description: meshes used once are baked into scene space, those used more often are instanced.

use super::ObjectInfo;
use super::description::{AlphaMode, Description, Instance, Primitive};
use super::material::Material;
use super::rebase::Rebase;
use crate::error::{Error, Result};
use crate::geometry::{Attributes, Bodies, Geometry, Object, TriangleMesh, is_placement};
use crate::huge_vec::HugeVec;
use glam::{Affine3A, DAffine3, DMat3, Mat3, Vec3};
use std::collections::HashMap;
use std::sync::Arc;

/// Returns all objects of `description` in scene space, with their shading data.
pub(super) fn assemble(
    description: &Description,
    rebase: &Rebase,
    materials: &[Material],
) -> Result<(Geometry, Vec<ObjectInfo>)> {
    let mut uses = vec![0usize; description.meshes.len()];
    description.instances.iter().for_each(|i| uses[i.mesh] += 1);
    let mut geometry = Geometry::default();
    let mut objects = Vec::new();
    let mut flat = 0;
    let mut shared: HashMap<(usize, usize), u32> = HashMap::new();
    for (index, instance) in description.instances.iter().enumerate() {
        let to_scene = rebase.transform(&instance.transform);
        for (part, primitive) in description.meshes[instance.mesh].primitives.iter().enumerate() {
            let name = part_name(description, instance, part);
            let placement = (uses[instance.mesh] > 1).then(|| placement(&to_scene)).flatten();
            let (mesh, placement) = if placement.is_none() {
                flat += if uses[instance.mesh] > 1 { primitive.triangles.len() } else { 0 };
                if flat > MOST_FLAT {
                    return Err(Error::scene(format!("'{name}': {FLAT_COPIES} of more than {MOST_FLAT} triangles")));
                }
                (add(&mut geometry, bake(name, primitive, &to_scene)?), None)
            } else {
                let key = (instance.mesh, part);
                let mesh = match shared.get(&key) {
                    Some(&mesh) => mesh,
                    None => add(&mut geometry, keep(name.clone(), primitive)?),
                };
                shared.insert(key, mesh);
                (mesh, placement)
            };
            let material = &materials[primitive.material];
            let colors = primitive.colors.is_some();
            let filtered = matches!(material.source.alpha_mode, AlphaMode::Mask { .. });
            geometry.objects.push(Object { mesh, placement, filtered });
            let (material, instance) = (primitive.material as u32, index as u32);
            objects.push(ObjectInfo {
                material,
                first_light: None,
                instance,
                colors,
                body: Bodies::NOBODY,
                passes: false,
                plain: false,
            });
        }
    }
    Ok((geometry, objects))
}

fn part_name(description: &Description, instance: &Instance, part: usize) -> String {
    let mesh = &description.meshes[instance.mesh];
    let suffix = if mesh.primitives.len() > 1 { format!(" part {part}") } else { String::new() };
    format!("{} ({}{suffix})", instance.name, mesh.name)
}

fn add(geometry: &mut Geometry, mesh: TriangleMesh) -> u32 {
    geometry.meshes.push(Arc::new(mesh));
    (geometry.meshes.len() - 1) as u32
}

/// Largest number of triangles of copies with a singular transform. Each copy is a mesh of its own.
const MOST_FLAT: usize = 1 << 22;
const FLAT_COPIES: &str = "the scene has flat or tiny copies of one mesh, which cannot be instances,";

/// Returns the transform of an instance in f32; `None` if it is singular.
fn placement(to_scene: &DAffine3) -> Option<Affine3A> {
    let m = to_scene.matrix3;
    let placement = Affine3A::from_mat3_translation(
        Mat3::from_cols(m.x_axis.as_vec3(), m.y_axis.as_vec3(), m.z_axis.as_vec3()),
        to_scene.translation.as_vec3(),
    );
    is_placement(&placement).then_some(placement)
}

/// Returns the primitive as stored in the file.
fn keep(name: String, primitive: &Primitive) -> Result<TriangleMesh> {
    TriangleMesh::new(name, primitive.positions.clone(), primitive.triangles.clone(), attributes(primitive))
}

fn attributes(primitive: &Primitive) -> Attributes {
    Attributes {
        normals: primitive.normals.as_deref().map(HugeVec::from),
        tangents: primitive.tangents.as_deref().map(HugeVec::from),
        uvs: primitive.uvs.each_ref().map(|uvs| uvs.as_deref().map(HugeVec::from)),
        colors: primitive.colors.as_deref().map(HugeVec::from),
    }
}

/// Returns the primitive in scene space. A mirroring transform flips the winding, so that fronts stay fronts.
fn bake(name: String, primitive: &Primitive, to_scene: &DAffine3) -> Result<TriangleMesh> {
    let positions = primitive.positions.iter().map(|p| to_scene.transform_point3(p.as_dvec3()).as_vec3()).collect();
    let mirrored = to_scene.matrix3.determinant() < 0.0;
    let turned = |&[a, b, c]: &[u32; 3]| if mirrored { [a, c, b] } else { [a, b, c] };
    let triangles = primitive.triangles.iter().map(turned).collect();
    let mut attributes = attributes(primitive);
    let cofactors = normal_matrix(&to_scene.matrix3);
    let direction = |m: &DMat3, v: Vec3| (*m * v.as_dvec3()).normalize_or_zero().as_vec3();
    if let Some(normals) = &mut attributes.normals {
        // Of a flattened mesh only normals along the flat direction remain; the others belong to triangles without
        // area.
        let any = |n: Vec3| if n == Vec3::ZERO { Vec3::Z } else { n };
        normals.iter_mut().for_each(|n| *n = any(direction(&cofactors, *n)));
    }
    if let Some(tangents) = &mut attributes.tangents {
        let sign = if mirrored { -1.0 } else { 1.0 };
        tangents.iter_mut().for_each(|t| *t = direction(&to_scene.matrix3, t.truncate()).extend(t.w * sign));
    }
    TriangleMesh::new(name, positions, triangles, attributes)
}

/// Returns the transform of normals: the inverse transpose up to a positive factor, also defined for singular matrices.
fn normal_matrix(m: &DMat3) -> DMat3 {
    let sign = if m.determinant() < 0.0 { -1.0 } else { 1.0 };
    let [x, y, z] = [m.x_axis, m.y_axis, m.z_axis];
    DMat3::from_cols(y.cross(z), z.cross(x), x.cross(y)) * sign
}
