//! Random numbers at the edges of the unit cube, one in millions: a walk that they begin is one that weights can count, or is
//! none.

use etendue::path::{Arrival, MisStrategy, Subpath, Techniques, TraceStats};
use etendue::sampling::{Heuristic, Sampler, Slot};
use etendue_testing::worlds::all;

/// The same random numbers for every bounce.
struct Edge {
    light: f32,
    direction: [f32; 2],
}

impl Sampler for Edge {
    fn u1(&mut self, _: u32, slot: Slot) -> f32 {
        if slot == Slot::LightPick { self.light } else { 0.5 }
    }

    fn u2(&mut self, _: u32, slot: Slot) -> [f32; 2] {
        if slot == Slot::Direction { self.direction } else { [0.5; 2] }
    }
}

#[test]
fn light_subpaths_along_the_surface_of_the_light_are_rejected() {
    const LAST: f32 = 1.0 - f32::EPSILON / 2.0;
    let weights = MisStrategy { techniques: Techniques::ALL, heuristic: Heuristic::Balance, light_walks: 1.0 };
    for world in all() {
        let camera = world.scene.camera(None, 8, 8).expect("a camera");
        for light in [0.0, 0.2, 0.4, 0.6, 0.8, LAST] {
            for direction in [[0.0, 0.0], [0.0, 0.3], [0.3, 0.0], [0.5, 0.5], [LAST, 0.3], [LAST, LAST]] {
                let mut numbers = Edge { light, direction };
                let Some((mut path, _)) = Subpath::from_light(&world.scene, &weights, &mut numbers) else { continue };
                let Arrival::Vertex(found) = path.arrive(&camera, &mut numbers, &mut TraceStats::default()) else {
                    continue;
                };
                let (a, b) = (found.sums.vc, found.sums.vc_prev);
                assert!(a.is_finite() && b.is_finite(), "{}: {light} {direction:?}: {a} {b}", world.name);
            }
        }
    }
}
