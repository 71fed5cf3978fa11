//! Any-hit filters: which candidates they receive, and that their answers decide.

use crate::brute_force::{BruteForce, fault};
use crate::scenes::{Random, built, each, placed_cube, scene_of, setups, triangle};
use etendue::accel::{Backend, Build, Intersector};
use etendue::geometry::{AnyHit, Geometry, Hit, Opaque, Ray};
use etendue::lab::equivalence::{Agreement, agreement};
use etendue::lab::hard_cases::{self, HardCase};
use glam::{Affine3A, Vec3};
use std::collections::HashMap;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::Mutex;

/// A filter made of a function.
pub(crate) struct Accept<F>(pub(crate) F);

impl<F: Fn(&Ray, Hit) -> bool + Sync> AnyHit for Accept<F> {
    fn accepts(&self, ray: &Ray, hit: Hit) -> bool {
        (self.0)(ray, hit)
    }
}

/// Rejects every second primitive.
pub(crate) fn is_even(hit: Hit) -> bool {
    hit.primitive % 2 == 0
}

#[test]
fn a_filter_decides_as_it_does_in_brute_force() {
    let geometry = placed_cube();
    let brute = BruteForce::new(&geometry);
    let rules: [fn(Hit) -> bool; 2] = [is_even, |_| false];
    for (setup, rule) in setups().into_iter().flat_map(|setup| rules.map(|rule| (setup, rule))) {
        let scene = built(&geometry, setup);
        let mut random = Random(4);
        for _ in 0..10_000 {
            let ray = random.ray(4.0);
            let counts = |hit: Hit| !geometry.objects[hit.object as usize].filtered || rule(hit);
            let filter = Accept(|asked: &Ray, hit: Hit| {
                let object = &geometry.objects[hit.object as usize];
                assert!(object.filtered, "asked about an object that is not filtered");
                assert_eq!((asked.origin, asked.direction), (ray.origin, ray.direction), "the world-space ray");
                rule(hit)
            });
            let candidates = brute.candidates(&ray, counts);
            assert_eq!(fault(scene.closest(&ray, &filter), &candidates), None, "{setup:?} {ray:?}");
            let occluded = scene.occluded(&ray, &filter);
            let certain = candidates.iter().any(|candidate| candidate.clear);
            assert!(occluded || !certain, "{setup:?}: nothing in the way of {ray:?}");
            assert!(!occluded || !candidates.is_empty(), "{setup:?}: something in the way of {ray:?}");
        }
    }
}

#[test]
fn every_named_candidate_lies_on_the_ray() {
    let geometry = placed_cube();
    let brute = BruteForce::new(&geometry);
    for &backend in Backend::AVAILABLE {
        let scene = built(&geometry, (backend, Build::High));
        let mut random = Random(5);
        for _ in 0..10_000 {
            let ray = random.ray(4.0);
            let candidates = brute.candidates(&ray, |_| true);
            // Rejecting all makes the traversal visit all; spatial splits make it visit some twice.
            let on_the_ray = |hit: Hit| candidates.iter().any(|candidate| candidate.hit == hit);
            scene.closest(
                &ray,
                &Accept(|_: &Ray, hit: Hit| !std::hint::black_box(on_the_ray(hit)) && panic!("{hit:?} is not on it")),
            );
        }
    }
}

#[test]
fn a_filter_that_cannot_reject_is_not_asked() {
    struct Never;
    impl AnyHit for Never {
        const FILTERS: bool = false;
        fn accepts(&self, _: &Ray, _: Hit) -> bool {
            panic!("asked")
        }
    }
    let ray = Ray::new(Vec3::new(0.2, 0.2, 1.0), -Vec3::Z);
    for scene in each(&scene_of(vec![triangle()], vec![(0, None, true)])) {
        assert!(scene.closest(&ray, &Never).is_some() && scene.occluded(&ray, &Never));
    }
}

#[test]
fn a_shared_mesh_is_filtered_only_where_its_object_is() {
    let behind = |z: f32| Some(Affine3A::from_translation(Vec3::Z * z));
    let objects = vec![(0, behind(3.0), true), (0, behind(2.0), false), (0, behind(1.0), true), (0, None, false)];
    let reject = Accept(|_: &Ray, _: Hit| false);
    let at = |z: f32| Ray::new(Vec3::new(0.2, 0.2, z), -Vec3::Z);
    for scene in each(&scene_of(vec![triangle()], objects)) {
        assert_eq!(scene.closest(&at(4.0), &reject), Some(Hit { object: 1, primitive: 0 }));
        assert_eq!(scene.closest(&at(1.5), &reject), Some(Hit { object: 3, primitive: 0 }));
        assert_eq!(scene.closest(&at(4.0), &Opaque), Some(Hit { object: 0, primitive: 0 }));
    }
}

#[test]
fn a_panic_in_a_filter_reaches_the_caller_and_the_scene_goes_on() {
    let moved = Affine3A::from_translation(Vec3::Z * -1.0);
    let geometry = scene_of(vec![triangle()], vec![(0, None, true), (0, Some(moved), true)]);
    for scene in each(&geometry) {
        let panics = Accept(|_: &Ray, hit: Hit| panic!("object {}", hit.object));
        let message = |query: &dyn Fn()| {
            let panic = catch_unwind(AssertUnwindSafe(query)).expect_err("the filter panics");
            panic.downcast_ref::<String>().cloned().expect("a message")
        };
        let ray = Ray::new(Vec3::new(0.2, 0.2, 1.0), -Vec3::Z);
        let instance = Ray::new(Vec3::new(0.2, 0.2, -0.5), -Vec3::Z);
        assert!(message(&|| _ = scene.closest(&ray, &panics)).starts_with("object "));
        assert_eq!(message(&|| _ = scene.closest(&instance, &panics)), "object 1");
        assert_eq!(message(&|| _ = scene.occluded(&instance, &panics)), "object 1");
        assert_eq!(scene.closest(&ray, &Opaque), Some(Hit { object: 0, primitive: 0 }));
        assert_eq!(
            scene.closest(&ray, &Accept(|_: &Ray, hit: Hit| hit.object == 1)),
            Some(Hit { object: 1, primitive: 0 })
        );
    }
}

/// The geometry of a hard case, every object filtered.
fn filtered(case: &HardCase) -> Geometry {
    let mut geometry = case.geometry().clone();
    geometry.objects.iter_mut().for_each(|object| object.filtered = true);
    geometry
}

#[test]
fn backends_agree_on_filtered_instances_that_are_mirrored_and_sheared() {
    let geometry = filtered(&hard_cases::by_name("instances-bent").expect("a case"));
    let mirrored = (0..geometry.objects.len()).filter(|&i| geometry.winding(i as u32) < 0.0).count();
    assert!(mirrored > 5 && mirrored + 5 < geometry.objects.len(), "{mirrored} are mirrored");
    let filter = Accept(|_: &Ray, hit: Hit| is_even(hit));
    let scenes = each(&geometry);
    for index in 0..100_000 {
        let ray = Random(900 + index).ray(4.0);
        let answers: Vec<_> = scenes.iter().map(|scene| scene.closest(&ray, &filter)).collect();
        for (scene, &answer) in scenes.iter().zip(&answers) {
            assert!(answer.is_none_or(is_even), "{:?} {ray:?}", scene.backend());
            assert_ne!(
                agreement(&geometry, &ray, answers[0], answer),
                Agreement::Different,
                "{:?} {ray:?}",
                scene.backend()
            );
            let occluded = scene.occluded(&ray, &filter);
            let met =
                answer.filter(|_| !occluded).map_or(Agreement::Same, |hit| agreement(&geometry, &ray, Some(hit), None));
            assert!(met != Agreement::Different && (answer.is_some() || !occluded), "{:?} {ray:?}", scene.backend());
        }
    }
}

/// Spatial splits put one triangle into several leaves, and a ray through both asks about it twice.
#[test]
fn a_filter_that_is_asked_twice_decides_as_if_it_were_asked_once() {
    let case = hard_cases::by_name("slivers").expect("a case");
    let geometry = filtered(&case);
    let mut repeated = 0;
    for &backend in Backend::AVAILABLE {
        let [split, whole] = [Build::High, Build::Robust].map(|build| built(&geometry, (backend, build)));
        for ray in case.rays(0..20_000) {
            let asked = Mutex::new(HashMap::new());
            let counting = Accept(|_: &Ray, hit: Hit| {
                *asked.lock().expect("no panic").entry((hit.object, hit.primitive)).or_insert(0) += 1;
                is_even(hit)
            });
            let answer = split.closest(&ray, &counting);
            let once = whole.closest(&ray, &Accept(|_: &Ray, hit: Hit| is_even(hit)));
            assert_ne!(agreement(&geometry, &ray, answer, once), Agreement::Different, "{backend:?} {ray:?}");
            repeated += asked.into_inner().expect("no panic").values().filter(|&&times| times > 1).count();
        }
    }
    assert!(repeated > 0, "no filter was asked twice");
}
