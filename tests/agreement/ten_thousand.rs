//! Every method on a scene of ten thousand lights, of which a place sees a few.

use crate::bidirectional::{How, agree, some_runs};
use crate::picture::scene_choosing;
use etendue::integrator::Method;
use etendue::light::LightChoice;
use etendue::scene::description::{Description, Material};
use etendue_testing::deep;
use etendue_testing::methods::ChainOptions;
use etendue_testing::random::Random;
use etendue_testing::studio::{add, add_box, camera, matte};
use glam::{DVec3, Vec2, Vec3};

const LIGHTS: usize = 10_000;
/// Radiances by the thousand; powers of lights differ by a factor of 30.
const RADIANCES: [f32; 5] = [60.0, 30.0, 100.0, 15.0, 400.0];
/// Circumradius of a light.
const SIZE: f32 = 0.004;

/// Height of the hills.
fn height(x: f32, z: f32) -> f32 {
    0.1 * (3.5 * x).sin() * (3.0 * z).cos()
}

fn add_hills(scene: &mut Description) {
    const CELLS: u32 = 24;
    let place = |i: u32| 2.0 * i as f32 / CELLS as f32 - 1.0;
    let corner = |i: u32| Vec2::new(place(i % (CELLS + 1)), place(i / (CELLS + 1)));
    let positions = (0..(CELLS + 1).pow(2)).map(corner).map(|p| Vec3::new(p.x, height(p.x, p.y), p.y)).collect();
    let cell = |i: u32| {
        let a = i / CELLS * (CELLS + 1) + i % CELLS;
        [[a, a + CELLS + 1, a + 1], [a + 1, a + CELLS + 1, a + CELLS + 2]]
    };
    add(scene, positions, (0..CELLS * CELLS).flat_map(cell).collect(), matte(0.5, 0.0));
}

/// One-sided triangles above the hills, each turned in a direction of its own.
fn add_lights(scene: &mut Description, random: &mut Random) {
    for radiance in RADIANCES {
        let count = LIGHTS / RADIANCES.len();
        let mut corners = Vec::new();
        for _ in 0..count {
            let [x, y, z] = random.cube::<3>();
            let (x, z) = (1.9 * x - 0.95, 1.9 * z - 0.95);
            let centre = Vec3::new(x, height(x, z) + 0.03 + 0.3 * y, z);
            let [a, b] = [(); 2].map(|()| Vec3::from(random.cube::<3>()) - 0.5);
            let a = a.normalize();
            let b = a.cross(b).normalize();
            corners.extend([a, b * 0.866 - a * 0.5, b * -0.866 - a * 0.5].map(|corner| centre + corner * SIZE));
        }
        let triangles = (0..count as u32).map(|i| [3 * i, 3 * i + 1, 3 * i + 2]).collect();
        add(scene, corners, triangles, Material { double_sided: false, ..matte(0.0, radiance) });
    }
}

fn night() -> Description {
    let (mut scene, mut random) = (Description::default(), Random::new(10_000));
    add_hills(&mut scene);
    for _ in 0..12 {
        let [x, y, z] = random.cube::<3>().map(|u| 1.6 * u - 0.8);
        let half = Vec3::new(0.03, 0.05 + 0.04 * y, 0.03);
        add_box(&mut scene, Vec3::new(x, height(x, z) + 0.02, z), half, matte(0.6, 0.0));
    }
    add_lights(&mut scene, &mut random);
    scene.cameras.push(camera(DVec3::new(0.0, 0.7, 1.3), DVec3::ZERO));
    scene
}

/// Selection by the tree and by power, samples of one method and of the other: one picture.
#[test]
fn all_methods_agree_on_ten_thousand_lights() {
    let [tree, power] = [LightChoice::Auto, LightChoice::Power].map(|choice| scene_choosing(choice, night()));
    assert_eq!(tree.info().lights, LIGHTS);
    assert!(tree.info().light_tree_bytes > 0 && power.info().light_tree_bytes == 0);
    let samples = |spp: u64| if deep() { 32 * spp } else { spp };
    let of = |scene, method, spp| {
        let chains = ChainOptions { depths: Some(4), ..ChainOptions::all() };
        some_runs(scene, &How { chains, ..How::new(method, 24, samples(spp)) }, 16)
    };
    let reference = of(&tree, Method::Path, 256);
    for (scene, method, spp, planted) in [
        (&power, Method::Path, 128, 1.1),
        (&tree, Method::PathNee, 128, 1.1),
        (&tree, Method::Light, 256, 1.1),
        (&tree, Method::Bdpt, 64, 1.1),
        (&power, Method::Bdpt, 64, 1.1),
        (&tree, Method::Pssmlt, 16, 1.2),
        (&tree, Method::Mmlt, 16, 1.2),
        (&tree, Method::Mlt, 16, 1.2),
    ] {
        let start = std::time::Instant::now();
        let found = of(scene, method, spp);
        println!("{method:?}, tree {}: {:.1?}", scene.info().light_tree_bytes > 0, start.elapsed());
        agree(&reference, &found).unwrap_or_else(|e| panic!("{method:?}: {e}"));
        assert!(agree(&reference, &found.scaled(planted)).is_err(), "{method:?}: {planted} as bright is not convicted");
    }
}
