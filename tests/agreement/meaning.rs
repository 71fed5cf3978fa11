//! What glTF says of unlit materials, flat nodes and views, in pictures: by every method, on every backend.

use crate::picture::{Shot, render, scene_under};
use etendue::accel::Backend;
use etendue::integrator::Method;
use etendue::scene::Scene;
use etendue::scene::description::PunctualLight;
use etendue::scene::description::{
    CameraDescription, Description, EnvironmentDescription, Instance, Material, MaterialModel, MetalFresnel,
    Projection, PunctualKind,
};
use etendue::spectrum::Spectrum;
use etendue::texture::{Bitmap, Encoding, Texels, Texture, TextureFilter, Wrap};
use etendue_testing::studio::{add_square, matte, with_model};
use glam::{Affine2, DAffine3, DMat3, DVec3, Vec2, Vec3, Vec4};
use std::sync::Arc;

const METHODS: [Method; 7] =
    [Method::PathNee, Method::Path, Method::Light, Method::Bdpt, Method::Pssmlt, Method::Mmlt, Method::Mlt];

/// Means of few samples of one value: a film quantum is 2⁻²⁴ of the pilot's mean, and a mean of f32 rounds once.
const QUANTA: f64 = 4.0 * f32::EPSILON as f64;

fn unlit(rgb: [f32; 3]) -> Material {
    Material { model: MaterialModel::Unlit, emission: Spectrum::from_rgb(rgb), ..Material::default() }
}

fn mirror() -> Material {
    let fresnel = MetalFresnel::Constant;
    Material {
        double_sided: true,
        ..with_model(Material::default(), |m| {
            m.metallic = 1.0;
            m.roughness = 0.0;
            m.metal_fresnel = fresnel;
        })
    }
}

/// Straight down at `y`, over a square of half side .1, from a height of .5 above it.
fn from_above(y: f64) -> CameraDescription {
    let axes = DMat3::from_cols(DVec3::X, DVec3::NEG_Z, DVec3::Y);
    let transform = DAffine3 { matrix3: axes, translation: DVec3::Y * (y + 0.5) };
    CameraDescription {
        name: "above".into(),
        projection: Projection::Orthographic { xmag: 0.1, ymag: 0.1 },
        transform,
        lens: None,
    }
}

fn surrounded(radiance: [f32; 3], camera: CameraDescription) -> Description {
    let environment = Some(EnvironmentDescription::Uniform(Spectrum::from_rgb(radiance)));
    Description { environment, cameras: vec![camera], ..Description::default() }
}

/// Every pixel of what every method makes of it under every backend.
fn expect(make: &dyn Fn() -> Description, methods: &[Method], want: [f64; 3], tolerance: f64) {
    for &backend in Backend::AVAILABLE {
        let scene: Scene = scene_under(backend, make());
        for &method in methods {
            let picture = render(&scene, Shot::new(method, 4, 4));
            for pixel in picture.mean.chunks_exact(3) {
                let off = pixel.iter().zip(want).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
                assert!(off <= tolerance, "{method:?} {backend:?}: {pixel:?} is not {want:?}");
            }
        }
    }
}

/// A horizontal square at height `y` that faces up or down.
fn add_floor(scene: &mut Description, y: f32, half: f32, up: bool, material: Material) {
    let v = if up { Vec3::NEG_Z } else { Vec3::Z };
    add_square(scene, Vec3::Y * y, Vec3::X * half, v * half, material);
}

#[test]
fn unlit_surfaces_show_their_base_and_vertex_colours() {
    let make = || {
        let mut scene = surrounded([0.0; 3], from_above(0.0));
        add_floor(&mut scene, 0.0, 1.0, true, unlit([0.5, 1.0, 1.0]));
        scene.meshes[0].primitives[0].colors = Some(vec![Vec4::new(0.5, 0.25, 0.125, 0.5); 4]);
        scene
    };
    expect(&make, &METHODS, [0.25, 0.25, 0.125], QUANTA);
}

#[test]
fn the_back_of_an_unlit_surface_is_not_there_for_the_camera() {
    let make = || {
        let mut scene = surrounded([0.0, 0.0, 1.0], from_above(0.0));
        add_floor(&mut scene, 0.0, 1.0, false, unlit([1.0, 0.0, 0.0]));
        scene
    };
    expect(&make, &METHODS, [0.0, 0.0, 1.0], QUANTA);
    let both = || {
        let mut scene = make();
        scene.materials[0].double_sided = true;
        scene
    };
    expect(&both, &METHODS, [1.0, 0.0, 0.0], QUANTA);
}

/// A white ceiling without light over a floor, seen from between them.
fn under_a_sign(floor: Material) -> Description {
    let mut scene = surrounded([0.0; 3], from_above(0.0));
    add_floor(&mut scene, 0.0, 1.0, true, floor);
    add_floor(&mut scene, 1.0, 1.0, false, unlit([0.75, 0.5, 0.25]));
    scene
}

#[test]
fn unlit_surfaces_light_nothing() {
    let all = [&METHODS[..], &[Method::PathNaive]].concat();
    expect(&|| under_a_sign(matte(0.5, 0.0)), &all, [0.0; 3], 0.0);
    let rough = with_model(mirror(), |m| m.roughness = 0.3);
    expect(&|| under_a_sign(rough.clone()), &all, [0.0; 3], 0.0);
    // Nor by way of a mirror: the floor sees the sign in one that stands beside it.
    let beside = || {
        let mut scene = under_a_sign(matte(0.5, 0.0));
        add_square(&mut scene, Vec3::new(1.0, 0.5, 0.0), Vec3::Y * 0.5, Vec3::Z, mirror());
        scene
    };
    expect(&beside, &all, [0.0; 3], 0.0);
}

#[test]
fn unlit_surfaces_are_seen_in_mirrors() {
    let methods = [Method::PathNee, Method::Path, Method::Bdpt];
    expect(&|| under_a_sign(mirror()), &methods, [0.75, 0.5, 0.25], QUANTA);
}

#[test]
fn a_square_scaled_flat_stays_and_so_do_its_copies() {
    for copies in [1, 2] {
        let make = || {
            let mut scene = surrounded([0.0, 0.0, 1.0], from_above(0.0));
            add_floor(&mut scene, 3.0, 1.0, true, matte(0.0, 0.5));
            for i in 0..copies {
                let transform = DAffine3::from_translation(DVec3::X * 2.5 * f64::from(i))
                    * DAffine3::from_scale(DVec3::new(1.0, 0.0, 1.0));
                let flat = Instance { name: format!("flat {i}"), mesh: 0, transform };
                if i == 0 { scene.instances[0] = flat } else { scene.instances.push(flat) }
            }
            scene
        };
        expect(&make, &METHODS, [0.5; 3], QUANTA);
    }
}

#[test]
fn default_light_is_absent_where_the_file_has_lights() {
    let dark = |lit: bool| {
        let mut scene = Description { cameras: vec![from_above(0.0)], ..Description::default() };
        add_floor(&mut scene, 0.0, 1.0, true, matte(0.5, 0.0));
        let light = PunctualLight {
            name: "off".into(),
            kind: PunctualKind::Point,
            intensity: Spectrum::ZERO,
            transform: DAffine3::from_translation(DVec3::Y),
        };
        scene.lights.extend(lit.then_some(light));
        scene
    };
    expect(&|| dark(true), &[Method::Path], [0.0; 3], 0.0);
    let hidden = || Description { has_emission: true, ..dark(false) };
    expect(&hidden, &[Method::Path], [0.0; 3], 0.0);
    assert!(scene_under(Backend::default(), dark(false)).lights().environment().is_some());
}

#[test]
fn a_frame_of_which_everything_is_hidden_shows_its_surroundings() {
    let make = || Description { hides: true, ..surrounded([0.25, 0.5, 1.0], from_above(0.0)) };
    expect(&make, &[Method::Path, Method::Bdpt, Method::Light], [0.25, 0.5, 1.0], QUANTA);
}

/// The slope of a normal map in two ways: turned by the map's transform, and by coordinates that were turned
/// beforehand.
#[test]
fn a_normal_map_is_turned_with_its_transform() {
    for set in [0, 1] {
        for mirrored in [false, true] {
            for angle in [0.5, 2.0, -1.0_f32] {
                let shine = |baked: bool| sloped(set, mirrored, angle, baked);
                for &backend in Backend::AVAILABLE {
                    let [turned, baked] = [false, true]
                        .map(|b| render(&scene_under(backend, shine(b)), Shot::new(Method::Path, 2, 4)).mean[0]);
                    // Some dozen roundings of coordinates, tangents and cosines.
                    assert!(
                        (turned - baked).abs() < 32.0 * f64::from(f32::EPSILON),
                        "{set} {mirrored} {angle}: {turned} {baked}"
                    );
                }
            }
        }
    }
}

/// A floor whose normal map leans along u everywhere, in slanting sunlight.
fn sloped(set: usize, mirrored: bool, angle: f32, baked: bool) -> Description {
    let texel = [[230, 128, 230, 255]];
    let image = Arc::new(Bitmap::new(1, 1, Texels::Rgba8(texel.to_vec().into())));
    let turn = Affine2::from_angle(angle) * Affine2::from_scale(Vec2::new(if mirrored { -2.0 } else { 2.0 }, 0.5));
    let transform = if baked { Affine2::IDENTITY } else { turn };
    let (wrap, filter) = ([Wrap::Repeat; 2], TextureFilter::Nearest);
    let map = Texture { image, encoding: Encoding::Linear, wrap, filter, uv_set: set, transform };
    let mut scene = surrounded([0.0; 3], from_above(0.0));
    add_floor(&mut scene, 0.0, 1.0, true, Material { normal_texture: Some((map, 1.0)), ..matte(0.5, 0.0) });
    let corners =
        [Vec2::ZERO, Vec2::X, Vec2::ONE, Vec2::Y].map(|uv| if baked { turn.transform_point2(uv) } else { uv });
    scene.meshes[0].primitives[0].uvs[set] = Some(corners.to_vec());
    let sun = DAffine3::from_axis_angle(DVec3::new(1.0, 0.5, 0.0).normalize(), -1.2);
    let (kind, intensity) = (PunctualKind::Directional, Spectrum::splat(3.0));
    scene.lights.push(PunctualLight { name: "sun".into(), kind, intensity, transform: sun });
    scene
}
