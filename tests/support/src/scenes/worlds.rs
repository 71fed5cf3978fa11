//! Scenes that together have every kind of vertex and edge that a path can have.

use super::studio::{Ball, add_box, add_room, add_square, camera, glass, matte, metal, point_light, with_model};
use etendue::accel::Backend;
use etendue::medium::Phase;
use etendue::scene::description::{
    CameraDescription, ColorGrid, DensityGrid, Description, EnvironmentDescription, Lens, Material, MaterialModel,
    PunctualKind, PunctualLight, Volume,
};
use etendue::scene::{BuildOptions, Scene};
use etendue::spectrum::Spectrum;
use etendue::texture::{Bitmap, Encoding, RadianceMap, Texels, Texture, TextureFilter, Wrap};
use glam::{Affine2, DAffine3, DVec3, Vec2, Vec3};
use std::sync::Arc;

/// Radiance of all lamps with an area.
pub const LAMP: Spectrum = Spectrum([8.0, 6.0, 4.0]);

const EYE: DVec3 = DVec3::new(0.1, 0.2, 0.9);

/// A scene with a camera.
pub struct World {
    /// Name in messages.
    pub name: &'static str,
    /// The scene, built for the Rust backend.
    pub scene: Scene,
    /// The smallest roughness α of its smooth lobes; 1 if it has none.
    pub alpha: f64,
    /// The greatest extinction of its media that scatter, per radius of the scene, over 1 − |g| of their phase
    /// functions.
    pub fog: f64,
}

fn build(name: &'static str, alpha: f64, mut description: Description) -> World {
    description.cameras.push(camera(EYE, DVec3::new(-0.05, -0.2, -0.3)));
    let options = BuildOptions { backend: Backend::Obvhs, threads: 1, ..BuildOptions::default() };
    World { name, scene: Scene::build(description, &options).expect("a valid scene"), alpha, fog: 0.0 }
}

/// A lamp at the ceiling that shines down, or up as well.
fn lamp(scene: &mut Description, double_sided: bool) {
    let material = Material { emission: LAMP, double_sided, ..matte(0.0, 0.0) };
    add_square(scene, Vec3::new(0.2, 0.95, 0.1), Vec3::X * 0.3, Vec3::Z * 0.2, material);
}

fn room() -> Description {
    let mut scene = Description::default();
    add_room(&mut scene, &with_model(matte(0.7, 0.0), |m| m.base_color = Spectrum([0.7, 0.5, 0.8])));
    lamp(&mut scene, false);
    scene
}

/// A ball with the normals of a sphere.
fn smooth_ball(scene: &mut Description, centre: DVec3, radius: f32, material: Material) {
    let ball = Ball::new(2, radius);
    let normals = ball.positions.iter().map(|p| p.normalize()).collect();
    ball.add(scene, centre, material);
    scene.meshes.last_mut().expect("just added").primitives[0].normals = Some(normals);
}

/// Gloss over a diffuse base, of perceptual roughness `roughness`.
fn lacquer(roughness: f32) -> Material {
    with_model(matte(0.5, 0.0), |m| {
        m.base_color = Spectrum([0.2, 0.5, 0.7]);
        m.specular = 1.0;
        m.roughness = roughness;
    })
}

/// Everything smooth.
fn rough() -> World {
    let mut scene = room();
    Ball::new(2, 0.35).add(&mut scene, DVec3::new(-0.4, -0.6, -0.2), metal(0.9, 0.4));
    Ball::new(2, 0.3).add(&mut scene, DVec3::new(0.4, -0.65, 0.1), glass(0.5));
    Ball::new(1, 0.25).add(&mut scene, DVec3::new(0.1, -0.1, -0.5), lacquer(0.5));
    build("rough", 0.16, scene)
}

/// Mirrors, clear glass, a window, and mixtures with Dirac parts.
fn dirac() -> World {
    let mut scene = room();
    Ball::new(3, 0.35).add(&mut scene, DVec3::new(-0.4, -0.6, -0.2), metal(0.9, 0.0));
    Ball::new(3, 0.3).add(&mut scene, DVec3::new(0.4, -0.65, 0.1), glass(0.0));
    Ball::new(1, 0.25).add(&mut scene, DVec3::new(0.1, -0.1, -0.5), lacquer(0.0));
    Ball::new(2, 0.2).add(&mut scene, DVec3::new(-0.6, 0.2, 0.1), with_model(glass(0.0), |m| m.transmission = 0.5));
    let window = with_model(matte(0.8, 0.0), |m| {
        m.specular = 1.0;
        m.transmission = 1.0;
        m.roughness = 0.0;
    });
    add_square(&mut scene, Vec3::new(0.6, 0.3, 0.2), Vec3::new(0.2, 0.0, 0.1), Vec3::Y * 0.3, window);
    let pane = with_model(matte(0.8, 0.0), |m| {
        m.specular = 1.0;
        m.transmission = 0.4;
        m.roughness = 0.0;
    });
    add_square(&mut scene, Vec3::new(-0.1, 0.5, -0.2), Vec3::X * 0.2, Vec3::Z * 0.3, pane);
    build("dirac", 1.0, scene)
}

/// A map of normals that lean up to 25 degrees.
fn ripples() -> Texture {
    let lean = |i: u8| [128 + 9 * (i % 7), 110 + 6 * (i % 5), 245, 255];
    Texture {
        image: Arc::new(Bitmap::new(4, 4, Texels::Rgba8((0..16).map(lean).collect::<Vec<_>>().into()))),
        encoding: Encoding::Linear,
        wrap: [Wrap::Repeat; 2],
        filter: TextureFilter::Linear,
        uv_set: 0,
        transform: Affine2::from_scale(Vec2::splat(3.0)),
    }
}

/// Interpolated normals on everything that scatters by chance or in one direction, and a panel with a map of normals.
fn bent() -> World {
    let mut scene = room();
    smooth_ball(&mut scene, DVec3::new(-0.4, -0.6, -0.2), 0.35, lacquer(0.4));
    smooth_ball(&mut scene, DVec3::new(0.4, -0.65, 0.1), 0.3, glass(0.0));
    smooth_ball(&mut scene, DVec3::new(0.1, -0.1, -0.5), 0.25, metal(0.8, 0.0));
    smooth_ball(&mut scene, DVec3::new(-0.5, 0.3, 0.1), 0.2, glass(0.5));
    let panel = Material { normal_texture: Some((ripples(), 1.0)), ..lacquer(0.5) };
    add_square(&mut scene, Vec3::new(0.5, 0.2, -0.6), Vec3::new(0.3, 0.0, 0.1), Vec3::Y * 0.4, panel);
    scene.meshes.last_mut().expect("just added").primitives[0].uvs[0] =
        Some(vec![Vec2::ZERO, Vec2::X, Vec2::ONE, Vec2::Y]);
    build("bent", 0.16, scene)
}

/// Lights of every kind under a map, nothing around; so many that the light tree selects them.
fn open() -> World {
    let mut scene = Description::default();
    lamp(&mut scene, true);
    for (x, double_sided) in [(-0.7, false), (0.0, true), (0.7, false)] {
        let material = Material { emission: LAMP, double_sided, ..matte(0.0, 0.0) };
        add_square(&mut scene, Vec3::new(x, 0.1, -0.8), Vec3::X * 0.05, Vec3::Y * 0.05, material);
    }
    add_square(&mut scene, Vec3::new(0.0, -0.9, 0.0), Vec3::X, Vec3::NEG_Z, matte(0.6, 0.0));
    Ball::new(2, 0.35).add(&mut scene, DVec3::new(-0.4, -0.5, -0.2), lacquer(0.5));
    Ball::new(2, 0.3).add(&mut scene, DVec3::new(0.4, -0.5, 0.1), metal(0.9, 0.0));
    Ball::new(2, 0.25).add(&mut scene, DVec3::new(0.1, 0.0, -0.5), glass(0.0));
    scene.lights.push(point_light(DVec3::new(-0.3, 0.6, 0.4), 0.5));
    let aimed = |kind, from: DVec3, intensity| PunctualLight {
        name: "aimed".into(),
        kind,
        intensity: Spectrum::splat(intensity),
        transform: camera(from, DVec3::new(0.0, -0.5, 0.0)).transform,
    };
    scene.lights.push(aimed(PunctualKind::Spot { inner: 0.3, outer: 0.6 }, DVec3::new(0.7, 0.8, 0.3), 2.0));
    scene.lights.push(aimed(PunctualKind::Directional, DVec3::new(-1.0, 2.0, 1.0), 0.5));
    let texels: Vec<[f32; 3]> = (0..32u8).map(|i| [0.1 + f32::from(i % 5), 0.2 + f32::from(i % 3), 0.3]).collect();
    let map = Arc::new(RadianceMap::new(8, 4, texels));
    scene.environment = Some(EnvironmentDescription::Map { map, scale: 0.5, rotation: 20.0 });
    build("open", 0.25, scene)
}

/// Coloured glass, rough and clear, and the same far away and large, as instances.
fn tinted() -> World {
    let mut scene = room();
    let volume = Some(Volume::absorbing(0.3, Spectrum([0.9, 0.4, 0.6])));
    Ball::new(3, 0.35).add(&mut scene, DVec3::new(-0.4, -0.6, -0.2), with_model(glass(0.0), |m| m.volume = volume));
    Ball::new(2, 0.3).add(&mut scene, DVec3::new(0.4, -0.65, 0.1), with_model(glass(0.6), |m| m.volume = volume));
    Ball::new(2, 0.2).add(
        &mut scene,
        DVec3::new(0.0, 0.2, -0.4),
        with_model(glass(0.5), |m| {
            m.volume = volume;
            m.transmission = 0.5;
        }),
    );
    let by = DAffine3::from_scale_rotation_translation(
        DVec3::splat(300.0),
        glam::DQuat::from_rotation_y(0.4),
        DVec3::new(1e4, -2e3, 5e3),
    );
    scene.instances.iter_mut().for_each(|i| i.transform = by * i.transform);
    scene.cameras.push(camera(EYE, DVec3::new(-0.05, -0.2, -0.3)));
    scene.cameras.iter_mut().for_each(|c| c.transform = by * c.transform);
    build("tinted", 0.25, scene)
}

/// Bodies in bodies, a lamp and a camera in different ones, and a window before the lamp.
fn nested() -> World {
    let mut scene = room();
    let inside = |ior, distance, color| {
        with_model(glass(0.0), |m| {
            m.ior = ior;
            m.volume = Some(Volume::absorbing(distance, Spectrum(color)));
        })
    };
    add_box(&mut scene, Vec3::new(0.0, -0.3, 0.0), Vec3::new(0.9, 0.6, 0.9), inside(1.33, 2.0, [0.5, 0.8, 0.9]));
    Ball::new(2, 0.3).add(&mut scene, DVec3::new(-0.3, -0.5, -0.2), inside(1.5, 0.5, [0.9, 0.4, 0.6]));
    Ball::new(2, 0.15).add(&mut scene, DVec3::new(-0.3, -0.5, -0.2), inside(1.0, f64::INFINITY, [1.0; 3]));
    Ball::new(2, 0.25).add(&mut scene, DVec3::new(0.4, -0.5, 0.1), inside(1.33, 1.0, [0.3, 0.9, 0.3]));
    let pane = |transmission| {
        with_model(lacquer(0.0), |m| {
            m.transmission = transmission;
            m.roughness = 0.0;
            m.base_color = Spectrum([0.9, 0.8, 0.5]);
        })
    };
    add_square(&mut scene, Vec3::new(0.0, 0.6, 0.0), Vec3::X * 0.6, Vec3::Z * 0.6, pane(1.0));
    add_square(&mut scene, Vec3::new(0.5, 0.5, -0.5), Vec3::X * 0.3, Vec3::Z * 0.3, pane(0.5));
    scene.cameras.push(camera(DVec3::new(0.1, -0.1, 0.8), DVec3::new(-0.05, -0.2, -0.3)));
    build("nested", 0.25, scene)
}

/// The same things as seen through a wide lens of five blades, most of them out of focus.
fn lens() -> World {
    let mut scene = room();
    Ball::new(2, 0.35).add(&mut scene, DVec3::new(-0.4, -0.6, -0.2), metal(0.9, 0.4));
    Ball::new(3, 0.3).add(&mut scene, DVec3::new(0.4, -0.65, 0.1), glass(0.0));
    Ball::new(3, 0.25).add(&mut scene, DVec3::new(0.1, -0.1, -0.5), metal(0.8, 0.0));
    let lens = Some(Lens { radius: 0.08, focus: 1.2, blades: 5, rotation: 20.0 });
    scene.cameras.push(CameraDescription { lens, ..camera(EYE, DVec3::new(-0.05, -0.2, -0.3)) });
    build("lens", 0.16, scene)
}

/// Fog around lamp and camera, with smoke, milky glass and a mirror in it, and a lamp of no size.
fn foggy() -> World {
    let mut scene = room();
    let inside = |ior: f32, priority: i32, scattering: [f32; 3], phase: Phase| {
        let (color, scattering) = (Spectrum([0.8, 0.7, 0.5]), Spectrum(scattering));
        let volume = Volume { scattering, phase, ..Volume::absorbing(2.0, color) };
        let model = with_model(glass(0.0), |m| {
            m.ior = ior;
            m.volume = Some(volume);
        });
        Material { priority, ..model }
    };
    let fog = inside(1.0, 0, [0.3, 0.5, 0.8], Phase::HenyeyGreenstein(0.6));
    add_box(&mut scene, Vec3::ZERO, Vec3::splat(0.98), fog);
    let mut smoke = inside(1.0, 1, [2.0, 1.0, 3.0], Phase::Mixture([0.7, -0.3], 0.6));
    // Clouds of up to three times the density around the ball, with holes.
    let densities = (0..60).map(|i: u16| f32::from(i * 7 % 11).max(2.0) * 0.3 - 0.6).collect();
    let place = DAffine3::from_scale_rotation_translation(
        DVec3::splat(0.65),
        glam::DQuat::from_rotation_y(0.5),
        DVec3::new(-0.35, -0.3, -0.25),
    );
    scene.densities.push(DensityGrid::new([3, 4, 5], densities, place).expect("valid"));
    if let MaterialModel::MetallicRoughness(model) = &mut smoke.model {
        model.volume = model.volume.map(|volume| Volume { density: Some(0), albedo: Some(0), ..volume });
    }
    let albedos = (0..12u8).map(|i| [i, 3 * i, 5 * i].map(|k| 0.4 + 0.05 * f32::from(k % 13))).collect();
    scene.albedos.push(ColorGrid::albedos([2, 3, 2], albedos, place).expect("valid"));
    Ball::new(2, 0.3).add(&mut scene, DVec3::new(-0.4, -0.5, -0.2), smoke);
    let milk = inside(1.5, 2, [4.0, 3.0, 2.0], Phase::Rayleigh);
    Ball::new(2, 0.3).add(&mut scene, DVec3::new(0.4, -0.55, 0.1), milk);
    Ball::new(2, 0.2).add(&mut scene, DVec3::new(0.1, 0.0, -0.5), metal(0.8, 0.0));
    scene.lights.push(point_light(DVec3::new(-0.3, 0.4, 0.2), 0.5));
    World { fog: 15.0 / 0.3, ..build("foggy", 1.0, scene) }
}

/// Every world.
pub fn all() -> [World; 8] {
    [rough(), dirac(), bent(), open(), tinted(), nested(), lens(), foggy()]
}
