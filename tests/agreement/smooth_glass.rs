//! Bodies whose normals are averaged over their edges in a white surrounding: what is clear or white shows 1 there,
//! however far the shading normals are from the faces.

use crate::bidirectional::{How, agree, runs, spp};
use crate::picture::{Shot, about, expect, render, scene, scene_under};
use etendue::accel::Backend;
use etendue::integrator::Method;
use etendue::scene::description::{Description, EnvironmentDescription, Material};
use etendue::spectrum::Spectrum;
use etendue_testing::studio::{add_box, camera, glass, metal};
use glam::{DVec3, Vec3};

/// A cube with corner normals, 55 degrees from its faces, that fills most of the view.
fn cube(material: Material) -> Description {
    let mut description =
        Description { environment: Some(EnvironmentDescription::Uniform(Spectrum::ONE)), ..Description::default() };
    add_box(&mut description, Vec3::ZERO, Vec3::splat(0.45), material);
    let primitive = &mut description.meshes.last_mut().expect("just added").primitives[0];
    primitive.normals = Some(primitive.positions.iter().map(|p| p.normalize()).collect());
    description.cameras.push(camera(DVec3::new(0.6, 0.5, 1.1), DVec3::ZERO));
    description
}

/// No path is lost, and none is trapped: then every sample is 1 but for roundings, a few to each of some hundred
/// events.
#[test]
fn a_clear_cube_with_corner_normals_shows_what_surrounds_it() {
    const ROUNDING: f64 = 1024.0 * f32::EPSILON as f64;
    for backend in Backend::AVAILABLE.iter().copied() {
        for (name, material) in [("glass", glass(0.0)), ("mirror", metal(1.0, 0.0))] {
            let picture = render(&scene_under(backend, cube(material)), Shot::new(Method::Path, 16, 64));
            expect(&picture, about(1.0, ROUNDING), 0.01, &format!("{name}, {backend:?}"));
        }
    }
}

/// Walks from both ends have one scattering function where the normals disagree.
#[test]
fn walks_from_both_ends_agree_on_corner_normals() {
    for (name, material) in [("rough metal", metal(0.9, 0.4)), ("rough glass", glass(0.5))] {
        let scene = scene(cube(material));
        let path = runs(&scene, &How::new(Method::Path, 16, spp(16)));
        let bdpt = runs(&scene, &How::new(Method::Bdpt, 16, spp(16)));
        agree(&path, &bdpt).unwrap_or_else(|e| panic!("{name}: {e}"));
    }
}
