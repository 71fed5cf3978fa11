//! Pictures whose every pixel is known: what is seen scatters nothing, or is lit by a point.

use crate::picture::{Picture, Shot, about, expect, render, scene};
use etendue::integrator::Method;
use etendue::scene::description::{AlphaMode, Description, Material, PunctualKind, PunctualLight, Volume};
use etendue::spectrum::Spectrum;
use etendue_testing::studio::{add_square, camera, glass, matte, narrow, point_light, with_model};
use glam::{DAffine3, DVec3, Vec3, Vec4};
use std::f64::consts::PI;

const LIGHT_SAMPLING: [Method; 2] = [Method::PathNee, Method::Path];

/// Roundings of a few dozen operations, and of the film.
const ROUNDING: f64 = 64.0 * f32::EPSILON as f64;

/// Every pixel and lane against `expected`, but for `relative`.
fn shows(picture: &Picture, expected: f64, relative: f64, what: &str) {
    for &seen in &picture.mean {
        assert!((seen - expected).abs() <= relative * expected, "{what}: {seen}, not {expected}");
    }
}

/// A lamp over the quadrant to the right and above of the view's middle: under a box filter the pixels of that quarter
/// of the picture are it and nothing else, and no other pixel has any of it.
#[test]
fn pixels_lie_where_the_camera_looks() {
    let mut quadrant = Description::default();
    add_square(&mut quadrant, Vec3::new(4.0, 4.0, -5.0), Vec3::X * 4.0, Vec3::Y * 4.0, matte(0.0, 1.0));
    quadrant.cameras.push(camera(DVec3::ZERO, DVec3::NEG_Z));
    let side = 8;
    let picture = render(&scene(quadrant), Shot::new(Method::Path, side as u32, 16));
    for (i, &seen) in picture.mean.iter().enumerate() {
        let (x, y) = (i / 3 % side, i / 3 / side);
        let expected = if x >= side / 2 && y < side / 2 { 1.0 } else { 0.0 };
        assert!((seen - expected).abs() < 1e-6, "pixel {x}, {y}: {seen}"); // film quantum
    }
}

/// A matte floor under a lamp without extent at height 2 above its middle, seen from near by.
fn lit_floor(kind: PunctualKind) -> Description {
    let mut floor = Description::default();
    add_square(&mut floor, Vec3::ZERO, Vec3::X * 5.0, Vec3::NEG_Z * 5.0, matte(0.5, 0.0));
    let transform = DAffine3::from_translation(DVec3::Y * 2.0) * DAffine3::from_rotation_x(-PI / 2.0); // −z is down
    floor.lights.push(PunctualLight { kind, transform, ..point_light(DVec3::ZERO, 3.0) });
    floor
}

/// Halfway, in the cosine, through the edge of a spot a quarter of its intensity is left.
#[test]
fn the_edge_of_a_spot_is_the_square_of_a_ramp() {
    let (inner, outer) = (0.3f32, 0.9f32);
    let middle = 0.5 * (f64::from(inner).cos() + f64::from(outer).cos());
    for (cos, share) in [(f64::from(inner).cos().midpoint(1.0), 1.0), (middle, 0.25)] {
        let mut floor = lit_floor(PunctualKind::Spot { inner, outer });
        let foot = DVec3::X * 2.0 * (1.0 - cos * cos).sqrt() / cos;
        // so narrow a view that the edge's slope, 10 a radian, stays below rounding
        floor.cameras.push(narrow(camera(foot + DVec3::new(0.2, 1.0, 0.0), foot), 1e-8));
        let expected = share * 0.5 * 3.0 * cos.powi(3) / (PI * 4.0);
        let picture = render(&scene(floor), Shot::new(Method::Path, 4, 4));
        shows(&picture, expected, 64.0 * ROUNDING, "spot"); // the eye is 1 away, the edge 0.2 wide
    }
}

/// Alpha above the cutoff everywhere is a screen that stops the light, below it there is no screen, whatever the
/// method.
#[test]
fn alpha_masked_screen_shadows_where_opaque() {
    for method in LIGHT_SAMPLING {
        let lit = |screen: Option<f32>| {
            let mut floor = lit_floor(PunctualKind::Point);
            if let Some(alpha) = screen {
                let mask = Material { alpha_mode: AlphaMode::Mask { cutoff: 0.5 }, ..matte(0.8, 0.0) };
                add_square(&mut floor, Vec3::Y, Vec3::X * 3.0, Vec3::Z * 3.0, mask);
                floor.meshes[1].primitives[0].colors = Some(vec![Vec4::new(1.0, 1.0, 1.0, alpha); 4]);
            }
            floor.cameras.push(narrow(camera(DVec3::new(0.3, 0.5, 0.0), DVec3::ZERO), 1e-3));
            render(&scene(floor), Shot { depth: Some(1), ..Shot::new(method, 8, 4) })
        };
        let open = lit(None).overall().mean;
        assert!(open > 0.01); // a hundredth of what an intensity of 3 gives at a distance of 2
        shows(&lit(Some(0.4)), open, 1e-6, &format!("{method:?}, open")); // the view's width, 1e-3, squared
        shows(&lit(Some(0.6)), 0.0, 0.0, &format!("{method:?}, shut"));
    }
}

/// A lamp that is single-sided lights nothing behind it, by whatever technique it is found.
#[test]
fn a_single_sided_lamp_is_dark_behind() {
    for method in [Method::PathNaive, Method::PathNee, Method::Path] {
        for facing in [false, true] {
            let mut floor = Description::default();
            add_square(&mut floor, Vec3::ZERO, Vec3::X * 5.0, Vec3::NEG_Z * 5.0, matte(0.5, 0.0));
            let lamp = Material { double_sided: false, ..matte(0.0, 3.0) };
            add_square(&mut floor, Vec3::Y * 2.0, Vec3::X, if facing { Vec3::Z } else { Vec3::NEG_Z }, lamp);
            floor.cameras.push(narrow(camera(DVec3::new(0.3, 0.5, 0.0), DVec3::ZERO), 0.1));
            let mean = render(&scene(floor), Shot::new(method, 8, 64)).overall().mean;
            assert!(if facing { mean > 0.01 } else { mean <= 0.0 }, "{method:?}, facing {facing}: {mean}"); // about 0.2
        }
    }
}

/// A pane before a wall of radiance 1, seen along its normal: of what comes through after 2 k reflections inside the
/// faces' (1 − R)² R²ᵏ is left, and a²ᵏ⁺¹ of the glass, which leaves a on one way (Beer).
#[test]
fn glass_absorption_follows_beer_lambert() {
    const THICKNESS: f64 = 0.5;
    // Rays begin up to 16 roundings of the scene's size behind a face, and the pane is 1/16 of that size thick.
    const WAY: f64 = 16.0 * 16.0 * 0.5 * f32::EPSILON as f64;
    for (ior, reflectance) in [(1.0f32, 0.0), (1.5, 0.04)] {
        let mut view = Description::default();
        let volume = Some(Volume::absorbing(2.0, Spectrum::splat(0.3)));
        let pane = with_model(glass(0.0), |m| {
            m.ior = ior;
            m.volume = volume;
        });
        add_square(&mut view, Vec3::Z * -1.0, Vec3::X * 4.0, Vec3::Y * 4.0, pane.clone());
        add_square(&mut view, Vec3::Z * (-1.0 - THICKNESS as f32), Vec3::Y * 4.0, Vec3::X * 4.0, pane);
        add_square(&mut view, Vec3::Z * -2.0, Vec3::X * 4.0, Vec3::Y * 4.0, matte(0.0, 1.0));
        view.cameras.push(narrow(camera(DVec3::ZERO, DVec3::NEG_Z), 1e-3));
        let left = f64::from(0.3f32).powf(THICKNESS / 2.0);
        let squared = (reflectance * left).powi(2);
        let expected = (1.0 - reflectance).powi(2) * left / (1.0 - squared);
        let picture = render(&scene(view), Shot::new(Method::Path, 16, 256));
        // the way is longer by the view's width squared
        expect(&picture, about(expected, 1e-6 + WAY + ROUNDING), 0.01, &format!("a pane of index {ior}"));
    }
}
