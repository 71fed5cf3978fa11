//! Scenes made for tests.

use etendue::scene::description::{
    Camera, Description, Instance, Material, Mesh, Primitive, Projection, PunctualKind, PunctualLight,
};
use etendue::spectrum::Spectrum;
use glam::{DAffine3, DVec3, Vec3};

/// A Lambertian material.
pub(crate) fn matte(reflectance: f32, emission: f32) -> Material {
    Material {
        base_color: Spectrum::splat(reflectance),
        emission: Spectrum::splat(emission),
        metallic: 0.0,
        specular: 0.0,
        double_sided: true,
        ..Material::default()
    }
}

/// Adds a mesh of one material.
pub(crate) fn add(scene: &mut Description, positions: Vec<Vec3>, triangles: Vec<[u32; 3]>, material: Material) {
    let (mesh, id) = (scene.meshes.len(), scene.materials.len());
    let primitive = Primitive { positions, triangles, material: id, ..Primitive::default() };
    scene.meshes.push(Mesh { name: format!("mesh {mesh}"), primitives: vec![primitive] });
    scene.instances.push(Instance { name: format!("node {mesh}"), mesh, transform: DAffine3::IDENTITY });
    scene.materials.push(material);
}

/// Adds the square with centre `c` spanned by the half edges `u` and `v`; its front is the side of u × v.
pub(crate) fn add_square(scene: &mut Description, c: Vec3, u: Vec3, v: Vec3, material: Material) {
    let corners = vec![c - u - v, c + u - v, c + u + v, c - u + v];
    add(scene, corners, vec![[0, 1, 2], [0, 2, 3]], material);
}

/// Adds the six inner walls of the cube from −1 to 1, all of one material.
pub(crate) fn add_room(scene: &mut Description, material: &Material) {
    for axis in 0..3 {
        for side in [-1.0, 1.0] {
            let mut n = [0.0; 3];
            n[axis] = side;
            let (n, u) = (Vec3::from(n), Vec3::from([n[2].abs(), n[0].abs(), n[1].abs()]));
            add_square(scene, n, u, n.cross(u) * -1.0, material.clone());
        }
    }
}

/// A pinhole camera at `eye` that looks at `target`, with a field of view of 60 degrees.
pub(crate) fn camera(eye: DVec3, target: DVec3) -> Camera {
    let backward = (eye - target).normalize();
    let up = if backward.y.abs() > 0.9 { DVec3::Z } else { DVec3::Y };
    let right = up.cross(backward).normalize();
    let transform = DAffine3::from_cols(right, backward.cross(right), backward, eye);
    let projection = Projection::Perspective { yfov: 60f64.to_radians(), aspect: None };
    Camera { name: "camera".into(), projection, transform }
}

/// A point light.
pub(crate) fn point_light(position: DVec3, intensity: f32) -> PunctualLight {
    PunctualLight {
        name: "point".into(),
        kind: PunctualKind::Point,
        intensity: Spectrum::splat(intensity),
        transform: DAffine3::from_translation(position),
    }
}
