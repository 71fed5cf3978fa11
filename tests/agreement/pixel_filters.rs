//! Pixel filters: the edge of a bright half-plane is blurred by the filter's
//! integral, around the pixel's centre, across and down.

use crate::picture::{Picture, Shot, limit, render, scene};
use etendue::film::Filter;
use etendue::integrator::Method;
use etendue::sampling::SamplerKind;
use etendue::scene::description::{CameraDescription, Description, Projection};
use etendue_testing::studio::{add_square, camera, matte};
use glam::{DVec3, Vec3};

/// Pixels along a side, each a scene unit wide.
const SIDE: usize = 8;
/// Where the edge is, in pixels from the left or the top.
const EDGE: f64 = 4.3;
const SPP: u64 = 1024;

fn half_plane(toward: Vec3, filter: Filter) -> Picture {
    let mut room = Description::default();
    let (edge, along) = ((EDGE - 0.5 * SIDE as f64) as f32, toward.cross(Vec3::Z));
    add_square(&mut room, toward * (50.0 - edge), toward * 50.0, along * 50.0, matte(0.0, 1.0));
    let half = 0.5 * SIDE as f64;
    let projection = Projection::Orthographic { xmag: half, ymag: half };
    room.cameras.push(CameraDescription { projection, ..camera(DVec3::Z * 5.0, DVec3::ZERO) });
    let shot = Shot::new(Method::Path, SIDE as u32, SPP);
    render(&scene(room), Shot { filter, sampler: SamplerKind::Independent, depth: Some(0), ..shot })
}

/// Largest |z| of the lines of pixels along the edge; each is a mean of 8 × 1024 zeros and ones.
fn worst(picture: &Picture, down: bool, filter: Filter) -> f64 {
    let line = |k: usize| {
        let pixel = |i: usize| if down { k * SIDE + i } else { i * SIDE + k };
        let mean = (0..SIDE).map(|i| picture.mean[3 * pixel(i)]).sum::<f64>() / SIDE as f64;
        let from_centre = EDGE - (k as f64 + 0.5);
        let lit = 0.5 + 0.5 * filter.half_cdf(from_centre.abs()).copysign(from_centre);
        let deviation = (lit * (1.0 - lit) / (SIDE as f64 * SPP as f64)).sqrt();
        ((mean - lit).abs() - 1e-6).max(0.0) / deviation.max(1e-9) // film quantum, and cdf of f64 beside 1
    };
    (0..SIDE).map(line).fold(0.0, f64::max)
}

#[test]
fn an_edge_is_blurred_by_the_filter() {
    let all = [Filter::Box, Filter::Tent, Filter::Gaussian, Filter::BlackmanHarris];
    let limit = limit(all.len() * 2 * SIDE);
    for (i, filter) in all.into_iter().enumerate() {
        for (toward, down) in [(Vec3::NEG_X, false), (Vec3::Y, true)] {
            let picture = half_plane(toward, filter);
            let z = worst(&picture, down, filter);
            assert!(z < limit, "{filter:?}, down {down}: z {z:.2}");
            // Planted: another filter.
            assert!(worst(&picture, down, all[(i + 1) % all.len()]) > limit, "{filter:?}, down {down}");
        }
    }
}
