//! A backend's answers against brute force.

use crate::brute_force::{BruteForce, fault, nearest};
use crate::scenes::{Random, built, each, placed_cube, scene_of, setups, triangle};
use etendue::accel::Intersector;
use etendue::geometry::{Hit, Opaque, Ray};
use glam::{Affine3A, Vec3};

const RAYS: usize = 100_000;

#[cfg(feature = "embree")]
#[test]
fn the_library_is_embree_4_from_its_third_release() {
    let geometry = scene_of(vec![triangle()], vec![(0, None, false)]);
    let build = etendue::accel::Build::Robust;
    let version = etendue::accel::embree::EmbreeScene::build(&geometry, build, 1).expect("builds").version();
    let numbers: Vec<u32> = version.split('.').map(|n| n.parse().expect("a number")).collect();
    assert!(numbers[0] == 4 && numbers[1] >= 3, "{version}");
}

#[test]
fn a_triangle_is_hit_where_it_is() {
    let moved = Affine3A::from_translation(Vec3::Z * -3.0);
    let geometry = scene_of(vec![triangle()], vec![(0, None, false), (0, Some(moved), false)]);
    for accel in each(&geometry) {
        let inside = Ray::new(Vec3::new(0.25, 0.25, 1.0), -Vec3::Z);
        assert_eq!(accel.closest(&inside, &Opaque), Some(Hit { object: 0, primitive: 0 }));
        let below = Ray::new(Vec3::new(0.25, 0.25, -1.0), -Vec3::Z);
        assert_eq!(
            accel.closest(&below, &Opaque),
            Some(Hit { object: 1, primitive: 0 }),
            "an instance of the same mesh"
        );
        let short = Ray { t_max: 0.5, ..inside };
        assert_eq!((accel.closest(&short, &Opaque), accel.occluded(&short, &Opaque)), (None, false));
        let late = Ray { t_min: 1.5, ..inside };
        assert_eq!(accel.closest(&late, &Opaque), Some(Hit { object: 1, primitive: 0 }));
        let outside = Ray::new(Vec3::new(0.75, 0.75, 1.0), -Vec3::Z);
        assert_eq!((accel.closest(&outside, &Opaque), accel.occluded(&outside, &Opaque)), (None, false));
    }
}

#[test]
fn every_build_answers_random_rays_as_brute_force_does() {
    let geometry = placed_cube();
    let brute = BruteForce::new(&geometry);
    for setup in setups() {
        let scene = built(&geometry, setup);
        let mut random = Random(1);
        let mut hits = vec![0; geometry.objects.len()];
        let mut grazes = 0;
        for _ in 0..RAYS / 4 {
            let ray = random.ray(4.0);
            let candidates = brute.candidates(&ray, |_| true);
            let answer = scene.closest(&ray, &Opaque);
            assert_eq!(fault(answer, &candidates), None, "{setup:?} {ray:?}");
            grazes += usize::from(answer != nearest(&candidates));
            if let Some(hit) = answer {
                hits[hit.object as usize] += 1;
            }
        }
        println!("{setup:?}: {grazes} grazes and ties in {} hits", hits.iter().sum::<usize>());
        assert!(hits.iter().all(|&n| n > 20), "each object is hit: {hits:?}");
    }
}

#[test]
fn occlusion_is_a_closest_hit_on_every_segment() {
    let geometry = placed_cube();
    for setup in setups() {
        let scene = built(&geometry, setup);
        let mut random = Random(2);
        let mut occluded = 0;
        for _ in 0..RAYS {
            let ray = Ray { t_max: random.unit(), ..random.ray(4.0) };
            let answer = scene.occluded(&ray, &Opaque);
            assert_eq!(answer, scene.closest(&ray, &Opaque).is_some(), "{setup:?} {ray:?}");
            occluded += usize::from(answer);
        }
        assert!((RAYS / 10..RAYS * 9 / 10).contains(&occluded), "both answers occur: {occluded}");
    }
}
