//! A segment between two surfaces meets neither of them: no light is lost to its own source. Found by a scene scaled by
//! 1e-4, where the pure Rust backend shadowed one sample in 10⁵ with the lamp that it was aimed at.

use crate::scenes::{Random, built, mesh, scene_of, setups};
use etendue::accel::Intersector;
use etendue::geometry::{Geometry, Hit, Opaque, Triangle, spawn_segment};
use glam::{Affine3A, Quat, Vec3};

const PAIRS: usize = 400;
const SEGMENTS: usize = 100;

/// A triangle of edges of 1e-3 to 1 somewhere in a cube from −1 to 1.
fn somewhere(random: &mut Random) -> [Vec3; 3] {
    let (centre, size) = (random.in_cube(1.0), 1e-3f32.powf(random.unit()));
    [0; 3].map(|_| centre + random.in_cube(size))
}

/// Two triangles, baked or placed by a transform that turns, scales and moves.
fn pair(random: &mut Random, placed: bool) -> Geometry {
    let meshes = [0; 2].map(|_| mesh(somewhere(random).to_vec(), vec![[0, 1, 2]]));
    let scale = Vec3::new(0.3, -1.2, 0.7);
    let turn = Quat::from_axis_angle(random.direction(), 1.0);
    let placement = placed.then(|| Affine3A::from_scale_rotation_translation(scale, turn, random.in_cube(0.5)));
    scene_of(meshes.to_vec(), vec![(0, placement, false), (1, placement, false)])
}

/// Whether a segment between random points of the two triangles meets one of them; ends are moved by `share` of the
/// bound. `None` where a triangle is seen so much edge-on that the side on which the segment leaves is a matter of
/// rounding.
fn meets_an_end(geometry: &Geometry, accel: &impl Intersector, random: &mut Random, share: f32) -> Option<bool> {
    let ends = [0, 1].map(|object| {
        let triangle: Triangle = geometry.triangle(Hit { object, primitive: 0 });
        let (u, v) = (random.unit(), random.unit());
        let (p, error) = triangle.point(if u + v < 1.0 { [u, v] } else { [1.0 - u, 1.0 - v] });
        (p, error * share, triangle.scaled_normal().normalize_or_zero().as_vec3())
    });
    let [(p, error, ng), (q, q_error, q_ng)] = ends;
    let away = (q - p).normalize_or_zero();
    // the ends' own bounds over the distance, and more
    let edge_on = 1e-4;
    if away.dot(ng).abs().min(away.dot(q_ng).abs()) < edge_on || (q - p).length() < 0.01 {
        return None;
    }
    Some(accel.occluded(&spawn_segment(p, error, ng, q, q_error, q_ng), &Opaque))
}

fn count(placed: bool, share: f32) -> [usize; 2] {
    let (mut met, mut asked) = (0, 0);
    for setup in setups() {
        let mut random = Random(40 + u64::from(placed));
        for _ in 0..PAIRS {
            let geometry = pair(&mut random, placed);
            let accel = built(&geometry, setup);
            for _ in 0..SEGMENTS {
                let Some(found) = meets_an_end(&geometry, &accel, &mut random, share) else { continue };
                asked += 1;
                met += usize::from(found);
            }
        }
    }
    [met, asked]
}

#[test]
fn a_segment_meets_neither_of_the_surfaces_that_it_joins() {
    for placed in [false, true] {
        let [met, asked] = count(placed, 1.0);
        println!("placed {placed}: {met} of {asked}");
        assert!(met == 0 && asked > 100_000, "placed {placed}: {met} of {asked} meet an end");
    }
}

#[test]
fn without_the_bound_segments_would_meet_their_ends() {
    let [met, asked] = count(false, 0.0);
    assert!(met > asked / 100, "{met} of {asked}");
}
