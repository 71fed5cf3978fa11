//! Batches return the bits of single paths, whatever their size and number of lanes.

use super::{BatchedPath, knows};
use crate::camera::Camera;
use crate::film::{Crop, Filter, Layout, PassFilm, Plane};
use crate::integrator::camera_pass::CameraPass;
use crate::integrator::path::{Combined, PathTracer};
use crate::integrator::scenes::studio::{Ball, add_room, add_square, camera, matte, metal, point_light, with_model};
use crate::integrator::scenes::worlds::{self, World};
use crate::integrator::{Integrator, IntegratorConfig, LightSelection, Method, PassReport};
use crate::parallel::Cancel;
use crate::sampling::SamplerKind;
use crate::scene::description::{Description, Material, MetallicRoughnessMaterial};
use crate::scene::{BuildOptions, Scene};
use crate::texture::{Bitmap, Encoding, Texels, Texture, TextureFilter, Wrap};
use etendue_lanes::{Array, Float, Native};
use glam::{Affine2, DVec3, Vec2, Vec3};
use std::sync::Arc;

const SIDE: u32 = 40;

/// Everything that a pass returns: the bits of the film, and the report.
fn pass(integrator: &dyn Integrator, layout: &Layout, pass: u64) -> (Vec<u32>, PassReport) {
    let mut film = PassFilm::new(layout);
    let mut report = integrator.run_pass(pass, &Cancel::new(), &mut film).expect("nobody cancels");
    report.selection = LightSelection::default(); // times
    (film.values().iter().map(|x| x.to_bits()).collect(), report)
}

/// Compares one family and size with single paths, on two passes.
fn compare<F: Float>(what: &str, scene: &Scene, camera: &Camera, options: &IntegratorConfig, size: Option<usize>) {
    let planes = [Plane::Alpha, Plane::Depth, Plane::Normal];
    let layout = Layout::new(SIDE, SIDE, Some(options.crop), &planes);
    let single = PathTracer::<Combined>::new(scene, options.max_depth, options.transparent);
    let single = CameraPass::new(single, scene, camera.clone(), options);
    let batched = BatchedPath::<F> { size, ..BatchedPath::new(scene, camera.clone(), options) };
    for number in [0, 5] {
        let (want, got) = (pass(&single, &layout, number), pass(&batched, &layout, number));
        assert!(want.0.iter().any(|&bits| bits != 0), "{what}: black");
        assert!(want.0 == got.0, "{what}: {} lanes, batches of {size:?}, pass {number}", F::LANES);
        assert_eq!(want.1, got.1, "{what}: reports");
    }
}

fn options(sampler: SamplerKind, max_depth: Option<u32>) -> IntegratorConfig {
    let layout = Layout::new(SIDE, SIDE, None, &[]);
    let crop = Crop { x0: 3, y0: 5, x1: SIDE - 2, y1: SIDE };
    IntegratorConfig { crop, sampler, max_depth, filter: Filter::Tent, ..IntegratorConfig::new(Method::Path, &layout) }
}

/// A room of flat surfaces that all have kernels: matte walls, metals, one that the camera sees from behind, a lamp.
fn kernels_only() -> Description {
    let mut scene = Description::default();
    add_room(&mut scene, &matte(0.7, 0.0));
    add_square(&mut scene, Vec3::new(-0.3, -0.6, 0.0), Vec3::X * 0.3, Vec3::Y * 0.3, metal(0.9, 0.5));
    add_square(&mut scene, Vec3::new(0.4, -0.5, -0.2), Vec3::X * 0.3, Vec3::Y * 0.4, metal(0.7, 0.15));
    let single_sided = Material { double_sided: false, ..matte(0.5, 0.0) };
    add_square(&mut scene, Vec3::new(0.3, 0.3, 0.2), Vec3::Y * 0.2, Vec3::X * 0.2, single_sided);
    add_square(&mut scene, Vec3::new(0.0, 0.9, 0.0), Vec3::X * 0.2, Vec3::Z * 0.2, matte(0.0, 8.0));
    scene.cameras.push(camera(DVec3::new(0.1, 0.0, 0.9), DVec3::new(0.0, -0.2, 0.0)));
    scene
}

/// The same with mirrors and a point light, which have none, and a shining ball of interpolated normals, about which
/// lanes are doubtful.
fn mixed() -> Description {
    let mut scene = kernels_only();
    Ball::new(1, 0.2).add(&mut scene, DVec3::new(-0.5, 0.3, -0.3), matte(0.6, 1.0));
    let shining = &mut scene.meshes.last_mut().expect("just added").primitives[0];
    shining.normals = Some(shining.positions.iter().map(|p| p.normalize()).collect());
    Ball::new(2, 0.3).add(&mut scene, DVec3::new(0.1, -0.6, 0.2), metal(0.8, 0.0));
    scene.lights.push(point_light(DVec3::new(-0.5, 0.5, 0.5), 0.5));
    scene
}

/// A texture of 5 × 4 texels, each `of` its number, transformed by `scale` times the coordinates.
fn texture(of: impl Fn(u8) -> [u8; 4], wrap: Wrap, filter: TextureFilter, scale: f32) -> Texture {
    let texels: Vec<_> = (0..20).map(of).collect();
    Texture {
        image: Arc::new(Bitmap::new(5, 4, Texels::Rgba8(texels.into()))),
        encoding: Encoding::Srgb,
        wrap: [wrap; 2],
        filter,
        uv_set: 0,
        transform: Affine2::from_scale_angle_translation(Vec2::splat(scale), 0.3, Vec2::new(-0.8, 0.4)),
    }
}

/// Everything that textures of colour, roughness, metalness and normals make of a surface: all models, mirrors, and
/// black; alone and together, at equal and at other places.
fn textured() -> Description {
    let mut scene = kernels_only();
    let color = |i: u8| [40 + 11 * i, 255 - 7 * i, 30 * (i % 4), 255];
    let ends = |i: u8| [7, [0, 90, 255][usize::from(i % 3)], [0, 255, 120, 0][usize::from(i / 5)], 9];
    let lean = |i: u8| [128 + 9 * (i % 7), 110 + 6 * (i % 5), 245, 255];
    let (repeat, linear) = (Wrap::Repeat, TextureFilter::Linear);
    let tiles = |of: &dyn Fn(u8) -> [u8; 4], scale| Some(texture(of, repeat, linear, scale));
    let of = |change: &dyn Fn(&mut MetallicRoughnessMaterial)| {
        with_model(matte(1.0, 0.0), |m| {
            (m.metallic, m.specular) = (1.0, 1.0);
            change(m);
        })
    };
    let both = of(&|m| {
        m.base_color_texture = tiles(&color, 2.3);
        m.metallic_roughness_texture = tiles(&ends, 2.3);
    });
    let bent = Material {
        normal_texture: Some((texture(lean, repeat, linear, 0.7), 1.0)),
        ..of(&|m| {
            m.base_color_texture = Some(texture(color, Wrap::Mirror, TextureFilter::Nearest, 4.0));
            m.metallic_roughness_texture = Some(texture(ends, Wrap::Clamp, linear, 0.9));
        })
    };
    let only_bent = Material { normal_texture: Some((texture(lean, repeat, linear, 3.0), 1.0)), ..matte(0.6, 0.0) };
    let matte = of(&|m| {
        (m.metallic, m.specular) = (0.0, 0.0);
        m.base_color_texture = tiles(&|i| if i % 3 == 0 { [0; 4] } else { color(i) }, 1.5);
    });
    for (at, material) in [both, bent, only_bent, matte].into_iter().enumerate() {
        let center = Vec3::new(-0.6 + 0.4 * at as f32, -0.2, -0.1);
        add_square(&mut scene, center, Vec3::X * 0.19, Vec3::Y * 0.5, material);
        scene.meshes.last_mut().expect("just added").primitives[0].uvs[0] =
            Some(vec![Vec2::ZERO, Vec2::X, Vec2::ONE, Vec2::Y]);
    }
    scene
}

fn built(name: &'static str, description: Description) -> World {
    let options = BuildOptions { threads: 1, ..BuildOptions::default() };
    World { name, scene: Scene::build(description, &options).expect("a valid scene"), alpha: 1.0, fog: 0.0 }
}

#[test]
fn batches_have_the_bits_of_single_paths() {
    let own = [built("kernels", kernels_only()), built("mixed", mixed()), built("textured", textured())];
    let mut known = 0;
    for World { name, scene, .. } in own.into_iter().chain(worlds::all()).filter(|world| knows(&world.scene)) {
        known += 1;
        let camera = scene.camera(None, SIDE, SIDE).expect("a camera");
        let sobol = options(SamplerKind::Sobol, None);
        compare::<Native>(name, &scene, &camera, &sobol, None);
        compare::<f32>(name, &scene, &camera, &sobol, Some(100));
        compare::<Array<4>>(name, &scene, &camera, &sobol, Some(33));
        compare::<Native>(name, &scene, &camera, &sobol, Some(1));
        compare::<Native>(name, &scene, &camera, &options(SamplerKind::Independent, Some(2)), None);
        compare::<Native>(name, &scene, &camera, &options(SamplerKind::Sobol, Some(0)), None);
    }
    assert!(known > 4, "{known}");
}

/// Packets of any width, and single rays, hit the same.
#[cfg(feature = "embree")]
#[test]
fn batches_have_the_same_bits_with_packets_of_any_width() {
    use crate::accel::Packet;
    let World { name, scene, .. } = built("mixed", mixed());
    let camera = scene.camera(None, SIDE, SIDE).expect("a camera");
    let mut scene = scene;
    for packet in [Packet::One, Packet::Eight, Packet::Sixteen] {
        (scene, _) = scene.with_accel(|mut accel| {
            accel.set_packet(packet);
            (accel, ())
        });
        compare::<Native>(name, &scene, &camera, &options(SamplerKind::Sobol, None), None);
    }
}

/// Batches are small enough for every thread to have some, and never empty.
#[test]
fn batches_share_a_picture_between_threads() {
    for (pixels, threads) in [(1, 1), (256, 2), (256, 64), (65_536, 2), (8_294_400, 64)] {
        let size = super::batch_size(pixels, threads);
        assert!((super::SMALLEST..=super::LARGEST).contains(&size), "{pixels} on {threads}: {size}");
        assert!(size == super::SMALLEST || pixels.div_ceil(size) >= threads.min(pixels.div_ceil(super::SMALLEST)));
    }
}
