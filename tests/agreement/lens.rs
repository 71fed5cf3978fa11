//! Cameras with a lens: what is out of focus is spread evenly over the image of the aperture, for every method, and
//! layers see through the lens as colours do.

use crate::bidirectional::{How, agree, runs};
use crate::picture::{Block, Picture, Shot, limit, render, scene};
use etendue::film::{Layout, Plane};
use etendue::integrator::{FilmRenderer, IntegratorConfig, Method};
use etendue::scene::Scene;
use etendue::scene::description::{CameraDescription, Description, Lens, Material, PunctualKind, PunctualLight};
use etendue::spectrum::Spectrum;
use etendue_testing::studio::{add_room, add_square, camera, matte, metal, narrow, point_light, with_model};
use etendue_testing::{deep, worlds};
use glam::{DVec3, Vec3};
use std::f64::consts::PI;

const SIDE: u32 = 32;
/// Radius of the lens and distance to the plane of focus.
const RADIUS: f64 = 0.1;
const FOCUS: f64 = 1.0;
/// Side of a pixel at distance 1.
const PIXEL: f64 = 0.005;
/// Distance to the speck and its half side.
const AWAY: f64 = 2.0;
const HALF: f64 = 0.02;

/// A speck of `material` that faces a camera with a lens of `radius` at the origin.
fn speck(material: Material, radius: f64) -> Description {
    let mut description = Description::default();
    let centre = Vec3::new(0.0, 0.0, -AWAY as f32);
    add_square(&mut description, centre, Vec3::X * HALF as f32, Vec3::Y * HALF as f32, material);
    let yfov = 2.0 * (0.5 * PIXEL * f64::from(SIDE)).atan();
    let lens = Some(Lens { radius, focus: FOCUS, blades: 0, rotation: 0.0 });
    description.cameras.push(CameraDescription { lens, ..narrow(camera(DVec3::ZERO, DVec3::NEG_Z), yfov) });
    description
}

/// Radius in pixels of the image of a point at the distance of the speck: half of A |z − f| / z on the plane of focus.
fn image_radius() -> f64 {
    RADIUS * (AWAY - FOCUS).abs() / AWAY / (FOCUS * PIXEL)
}

/// Pixels that the speck covers where it is in focus.
fn image_area() -> f64 {
    (2.0 * HALF / (AWAY * PIXEL)).powi(2)
}

/// Distances from the centre of the image to the nearest and to the farthest corner of a pixel.
fn reach(pixel: usize) -> [f64; 2] {
    let from_centre = |i: usize| (i as f64 - f64::from(SIDE) / 2.0 + 0.5).abs();
    let (x, y) = (from_centre(pixel % SIDE as usize), from_centre(pixel / SIDE as usize));
    [(x - 0.5).hypot(y - 0.5), (x + 0.5).hypot(y + 0.5)]
}

/// Means over four rings of the pixels whose whole square is inside the disk of evenness. The square image of the speck
/// reaches half its diagonal beyond each point of the disk.
fn rings(picture: &Picture) -> Vec<Block> {
    let inside = image_radius() - image_area().sqrt() * 0.5f64.sqrt();
    let mut sums = vec![(0.0, 0.0, 0.0); 4];
    for pixel in (0..picture.mean.len() / 3).filter(|&pixel| reach(pixel)[1] < inside) {
        let (count, mean, variance) = &mut sums[((reach(pixel)[1] / inside).powi(2) * 4.0) as usize];
        *count += 1.0;
        *mean += picture.mean[3 * pixel];
        *variance += picture.variance[3 * pixel];
    }
    sums.into_iter().map(|(n, mean, variance)| Block { mean: mean / n, variance: variance / (n * n) }).collect()
}

/// Checks that `picture` is a disk of the right size, with `value` everywhere in it.
fn expect_disk(picture: &Picture, value: f64, what: &str) {
    let outside = image_radius() + image_area().sqrt() * 0.5f64.sqrt();
    let dark = (0..picture.mean.len() / 3).filter(|&pixel| reach(pixel)[0] > outside);
    assert!(dark.clone().count() > 300, "{}", dark.count());
    assert!(dark.map(|pixel| picture.mean[3 * pixel]).all(|v| v == 0.0), "{what}: light outside the disk");
    let rings = rings(picture);
    let exact = |scale: f64| Block { mean: value * scale, variance: 0.0 };
    let worst = |scale: f64| rings.iter().map(|ring| ring.z(exact(scale)).abs()).fold(0.0, f64::max);
    let found: Vec<f64> = rings.iter().map(|ring| ring.mean / value).collect();
    println!("{what}: rings at {found:.4?} of {value:.5}, largest |z| {:.2} of {:.2}", worst(1.0), limit(rings.len()));
    assert!(worst(1.0) < limit(rings.len()), "{what}: {found:?}, z {:.2}", worst(1.0));
    for planted in [0.9, 1.1] {
        assert!(worst(planted) > limit(rings.len()), "{what}: {planted} times as bright is not convicted");
    }
}

/// A matte speck lit by a narrow spot at the centre of the lens: paths of one scattering event, found from the camera
/// and by connections of light to points of the lens. The lens sees the whole speck from everywhere alike, since both
/// are parallel: radiance times covered film, divided by the area of the disk.
#[test]
fn a_speck_out_of_focus_is_an_even_disk() {
    const ALBEDO: f64 = 0.8;
    const INTENSITY: f64 = 100.0;
    let mut lit = speck(matte(ALBEDO as f32, 0.0), RADIUS);
    // The corners of the speck are 0.014 off the axis: they are in the inner cone, and light falls off by 4e-4 at most.
    let kind = PunctualKind::Spot { inner: 0.03, outer: 0.06 };
    lit.lights.push(PunctualLight { kind, ..point_light(DVec3::ZERO, INTENSITY as f32) });
    let radiance = ALBEDO / PI * INTENSITY / (AWAY * AWAY);
    let value = radiance * image_area() / (PI * image_radius().powi(2));
    let lit = scene(lit);
    for (method, spp) in [(Method::Path, 2048), (Method::Light, 1024), (Method::Bdpt, 1024)] {
        let spp = if deep() { 16 * spp } else { spp };
        expect_disk(
            &render(&lit, Shot { depth: Some(1), ..Shot::new(method, SIDE, spp) }),
            value,
            &format!("{method:?}"),
        );
    }
}

/// Sums of passes of one seed with the alpha layer.
fn layers(scene: &Scene, spp: u64) -> [Vec<f32>; 2] {
    let layout = Layout::new(SIDE, SIDE, None, &[Plane::Alpha]);
    let options = IntegratorConfig::new(Method::Path, &layout);
    let camera = scene.camera(None, SIDE, SIDE).expect("a camera");
    let mut renderer = FilmRenderer::begin(scene, camera, &options, &layout);
    renderer.passes(spp);
    let film = renderer.film();
    [Plane::Color, Plane::Alpha].map(|plane| film.mean(plane))
}

/// A glowing speck: each sample that sees it has its radiance as colour and 1 as coverage, and no other has either.
#[test]
fn layers_see_through_the_same_points_of_the_lens() {
    const RADIANCE: f32 = 4.0;
    let glowing = scene(speck(with_model(matte(0.0, RADIANCE), |m| m.base_color = Spectrum::ZERO), RADIUS));
    let [color, alpha] = layers(&glowing, 64);
    let lit = alpha.iter().filter(|&&a| a > 0.0 && a < 0.5).count();
    assert!(lit > 100, "{lit} pixels see the speck out of focus");
    for (pixel, &alpha) in alpha.iter().enumerate() {
        // Both are sums of integers over 64 passes, then rounded.
        let off = (color[3 * pixel] / RADIANCE - alpha).abs();
        assert!(off <= 4.0 * f32::EPSILON, "pixel {pixel}: {} and {alpha}", color[3 * pixel]);
    }
}

/// A lens of no size is a pinhole, pixel for pixel.
#[test]
fn a_lens_of_radius_0_is_a_pinhole() {
    let room = |lens: Option<Lens>| {
        let mut description = speck(metal(0.9, 0.3), 0.0);
        add_room(&mut description, &matte(0.5, 0.2));
        description.cameras[0].lens = lens;
        scene(description)
    };
    let scenes = [Some(Lens { radius: 0.0, focus: 1.0, blades: 6, rotation: 0.0 }), None].map(room);
    for method in [Method::Path, Method::Bdpt, Method::Mlt] {
        let [lens, pinhole] = scenes.each_ref().map(|scene| render(scene, Shot::new(method, 8, 4)).mean);
        assert!(lens == pinhole, "{method:?}");
    }
}

/// A room with a wide lens: every method that sees its light agrees with path tracing. Light tracing, which sees
/// nothing in its mirror, has the speck.
#[test]
fn methods_agree_through_a_lens() {
    let lens = worlds::all().into_iter().find(|world| world.name == "lens").expect("a lens").scene;
    let spp = |n: u64| if deep() { 16 * n } else { n };
    let path = runs(&lens, &How::new(Method::Path, 16, spp(32)));
    for (method, n) in [(Method::Bdpt, 8), (Method::Pssmlt, 8), (Method::Mmlt, 8), (Method::Mlt, 8)] {
        let found = runs(&lens, &How::new(method, 16, spp(n)));
        println!("{method:?}: {:?} of {:?}", found.overall(), path.overall());
        agree(&found, &path).unwrap_or_else(|e| panic!("{method:?}: {e}"));
    }
}
