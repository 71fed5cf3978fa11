//! Batches of rays against the same rays one by one: every packet width, both values of the coherence hint, with and
//! without filters.

use crate::brute_force::{BruteForce, Candidate};
use crate::filters::{Accept, is_even};
use crate::scenes::{Random, built, mesh, placed_cube, scene_of, setups, triangle};
use etendue::accel::{Accel, Build, Coherence, Intersector, Packet};
use etendue::geometry::{AnyHit, Geometry, Hit, Hits, Opaque, PADDING, Ray, Rays};
use etendue::lab::equivalence::{Agreement, agreement};
use glam::{Affine3A, Vec3};
use std::panic::{AssertUnwindSafe, catch_unwind};

/// Batches of up to 40 rays: up to two full packets of 16, and one with any number of rays.
const LARGEST: usize = 40;

/// Hints to try with every batch.
pub(crate) const HINTS: [Coherence; 2] = [Coherence::Coherent, Coherence::Incoherent];

/// Calls `test` with the backend under every width of packets, those included for which the processor has no
/// registers; once for a backend without packets.
pub(crate) fn each_width(mut accel: Accel, mut test: impl FnMut(&Accel, &str)) {
    if accel.packets().is_empty() {
        return test(&accel, "batch");
    }
    for packet in [Packet::One, Packet::Eight, Packet::Sixteen] {
        accel.set_packet(packet);
        test(&accel, &format!("packets of {}", packet.rays()));
    }
}

/// The answers to a batch. Places that are not written are not mistaken for answers.
fn asked(accel: &Accel, rays: &Rays, hint: Coherence, any: &impl AnyHit) -> (Hits, Vec<bool>) {
    let mut hits = Hits::new(rays.len());
    (0..rays.len()).for_each(|at| hits.set(at, Some(Hit { object: 0, primitive: u32::MAX - 1 })));
    accel.closest_all(rays, hint, any, &mut hits);
    // Half of the places hold the wrong answer whatever it is.
    let mut occluded: Vec<bool> = (0..rays.len() + PADDING).map(|at| at % 2 == 0).collect();
    accel.occluded_all(rays, hint, any, &mut occluded);
    (hits, occluded)
}

/// Whether rounding alone may separate the answers.
fn agree(geometry: &Geometry, ray: &Ray, a: Option<Hit>, b: Option<Hit>) -> bool {
    agreement(geometry, ray, a, b) != Agreement::Different
}

/// Compares a batch with single rays; returns how many rays are hit, and how many answers differ by rounding.
fn compared(geometry: &Geometry, accel: &Accel, rays: &Rays, hint: Coherence, any: &impl AnyHit) -> [usize; 2] {
    let (hits, occluded) = asked(accel, rays, hint, any);
    let (mut found, mut near) = (0, 0);
    for (at, &occluded) in occluded.iter().enumerate().take(rays.len()) {
        let (ray, hit) = (rays.ray(at), hits.get(at));
        let (alone, alone_occluded) = (accel.closest(&ray, any), accel.occluded(&ray, any));
        let what = || format!("{:?} ray {at} of {} {hint:?}: {ray:?}", accel.backend(), rays.len());
        assert!(hit.is_none_or(|hit| hit.primitive < u32::MAX - 1), "not written: {}", what());
        assert!(agree(geometry, &ray, hit, alone), "{hit:?} and alone {alone:?}: {}", what());
        // The other query names no triangle: that of the first must be one that rounding may pass.
        let passed = || hit.or(alone).is_some_and(|hit| agree(geometry, &ray, Some(hit), None));
        assert!(occluded == alone_occluded || passed(), "occluded {occluded}, alone not: {}", what());
        found += usize::from(hit.is_some());
        near += usize::from(hit != alone || occluded != alone_occluded);
    }
    [found, near]
}

/// `len` rays: a bundle from one place, or rays in all directions with short, invalid and missing ones between them.
fn batch(random: &mut Random, len: usize) -> Rays {
    let mut rays = Rays::new(len);
    let (origin, target, is_bundle) = (random.in_cube(5.0), random.in_cube(2.0), random.below(2) == 0);
    for _ in 0..len {
        rays.push(&if is_bundle { Ray::new(origin, target + random.in_cube(0.3) - origin) } else { any_ray(random) });
    }
    rays
}

fn any_ray(random: &mut Random) -> Ray {
    let ray = random.ray(4.0);
    let mut broken = ray;
    match random.below(10) {
        0 => broken.origin[random.below(3)] = f32::NAN,
        1 => broken.direction[random.below(3)] = f32::NAN,
        2 => broken.direction = Vec3::ZERO,
        // Misses: the scene is within 12 of the origin.
        3 => broken.origin = ray.direction.normalize_or(Vec3::X) * 100.0,
        4 | 5 => broken.t_max = random.unit() * 0.3,
        6 => broken.t_max = -1.0,
        _ => {}
    }
    broken
}

#[test]
fn batches_of_any_length_answer_as_single_rays_do() {
    let geometry = placed_cube();
    for setup in setups() {
        each_width(built(&geometry, setup), |accel, width| {
            let mask = Accept(|_: &Ray, hit: Hit| is_even(hit));
            for hint in HINTS {
                let (mut random, mut sum) = (Random(71), [0; 4]);
                for len in (0..5).flat_map(|_| 0..=LARGEST) {
                    let rays = batch(&mut random, len);
                    let [hits, near] = compared(&geometry, accel, &rays, hint, &Opaque);
                    let [masked_hits, masked_near] = compared(&geometry, accel, &rays, hint, &mask);
                    let counts = [hits, near, masked_hits, masked_near];
                    sum.iter_mut().zip(counts).for_each(|(sum, count)| *sum += count);
                }
                println!("{setup:?} {width} {hint:?}: hits, of these by rounding elsewhere, with masks: {sum:?}");
                assert!(sum[2] > 500 && sum[0] > sum[2], "{setup:?} {width}: {sum:?}");
            }
        });
    }
}

/// On the edges of a cube each ray meets two triangles at one distance. Which of them it hits is a matter of the ray
/// alone, and not of the rays that are packed with it.
#[test]
fn ties_do_not_depend_on_the_other_rays_of_a_packet() {
    // Bit k of a corner's number is its side on axis k.
    let positions = (0..8).map(|i| Vec3::new((i & 1) as f32, (i >> 1 & 1) as f32, (i >> 2) as f32)).collect();
    let quads = [[0, 1, 3, 2], [4, 5, 7, 6], [0, 1, 5, 4], [2, 3, 7, 6], [0, 2, 6, 4], [1, 3, 7, 5]];
    let grid = mesh(positions, quads.iter().flat_map(|&[a, b, c, d]| [[a, b, c], [a, c, d]]).collect());
    let corners: Vec<[Vec3; 3]> = (0..grid.triangles().len()).map(|i| grid.corners(i as u32)).collect();
    let geometry = scene_of(vec![grid], vec![(0, None, false)]);
    // The fast build loses hits on edges, as it may.
    for setup in setups().into_iter().filter(|&(_, build)| build != Build::Fast) {
        each_width(built(&geometry, setup), |accel, width| {
            let mut random = Random(76);
            let mut ties = 0;
            for i in 0..1000 {
                let mut rays = Rays::new(LARGEST);
                let from = 0.5 + 0.3 * random.direction();
                for _ in 0..LARGEST {
                    let [a, b, c] = corners[(random.unit() * corners.len() as f32) as usize % corners.len()];
                    let end = if random.unit() < 0.5 { b } else { c };
                    rays.push(&Ray::new(from, (a.lerp(end, random.unit()) - from).normalize()));
                }
                let mut hits = Hits::new(LARGEST);
                accel.closest_all(&rays, HINTS[i % HINTS.len()], &Opaque, &mut hits);
                for at in 0..LARGEST {
                    let alone = accel.closest(&rays.ray(at), &Opaque);
                    assert_eq!(hits.get(at), alone, "{setup:?} {width}: {:?}", rays.ray(at));
                    ties += usize::from(alone.is_some());
                }
            }
            assert!(ties > 800 * LARGEST, "{setup:?} {width}: {ties} hits");
        });
    }
}

/// The ray of a candidate is the caller's own, in world space inside instances too, and the candidate is on it.
#[test]
fn filters_of_batches_get_their_own_rays() {
    let geometry = placed_cube();
    let brute = BruteForce::new(&geometry);
    for setup in setups() {
        each_width(built(&geometry, setup), |accel, width| {
            let mut random = Random(72);
            for len in [1, 7, 16, 23, LARGEST] {
                let mut rays = Rays::new(len);
                (0..len).for_each(|_| rays.push(&random.ray(4.0)));
                let candidates: Vec<_> = (0..len).map(|at| brute.candidates(&rays.ray(at), |_| true)).collect();
                let reject = Accept(|ray: &Ray, hit: Hit| {
                    assert!(is_on_its_ray(&rays, &candidates, ray, hit), "{setup:?} {width}: {hit:?} {ray:?}");
                    false
                });
                HINTS.iter().for_each(|&hint| _ = asked(accel, &rays, hint, &reject));
            }
        });
    }
}

/// Whether `ray` is one of `rays` and `hit` one of its candidates.
fn is_on_its_ray(rays: &Rays, candidates: &[Vec<Candidate>], ray: &Ray, hit: Hit) -> bool {
    let same = |other: Ray| (other.origin, other.direction) == (ray.origin, ray.direction);
    let at = (0..rays.len()).find(|&at| same(rays.ray(at)));
    at.is_some_and(|at| candidates[at].iter().any(|candidate| candidate.hit == hit))
}

/// The filters of a packet's rays decide apart: what one of them lets through does not end the others.
#[test]
fn a_filter_may_decide_by_the_ray() {
    let behind = Affine3A::from_translation(Vec3::Z * -1.0);
    let geometry = scene_of(vec![triangle()], vec![(0, None, true), (0, Some(behind), true)]);
    let mut rays = Rays::new(LARGEST);
    for at in 0..LARGEST {
        rays.push(&Ray::new(Vec3::new(0.2 + 0.01 * at as f32, 0.2, 1.0), -Vec3::Z));
    }
    // By place: both are let through, none, and the one behind.
    let rule = Accept(|ray: &Ray, hit: Hit| match ((ray.origin.x - 0.2) * 100.0).round() as u32 % 3 {
        0 => true,
        1 => false,
        _ => hit.object == 1,
    });
    for setup in setups() {
        each_width(built(&geometry, setup), |accel, width| {
            for hint in HINTS {
                let (hits, occluded) = asked(accel, &rays, hint, &rule);
                for at in 0..LARGEST {
                    let expected = [Some(0), None, Some(1)][at % 3].map(|object| Hit { object, primitive: 0 });
                    let answer = (hits.get(at), occluded[at]);
                    assert_eq!(answer, (expected, expected.is_some()), "{setup:?} {width} {hint:?} {at}");
                }
            }
        });
    }
}

#[test]
fn a_panic_in_a_filter_of_a_batch_reaches_the_caller() {
    let moved = Affine3A::from_translation(Vec3::Z * -1.0);
    let geometry = scene_of(vec![triangle()], vec![(0, None, false), (0, Some(moved), true)]);
    let mut rays = Rays::new(LARGEST);
    // One ray meets the filtered instance, the others the mesh in front of it.
    for at in 0..LARGEST {
        rays.push(&Ray::new(Vec3::new(0.2, 0.2, if at == 21 { -0.5 } else { 1.0 }), -Vec3::Z));
    }
    let panics = Accept(|ray: &Ray, hit: Hit| ray.origin.z > 0.0 || panic!("object {}", hit.object));
    let message = |query: &mut dyn FnMut()| {
        let panic = catch_unwind(AssertUnwindSafe(query)).expect_err("the filter panics");
        panic.downcast_ref::<String>().cloned().expect("a message")
    };
    for setup in setups() {
        each_width(built(&geometry, setup), |accel, width| {
            for hint in HINTS {
                let (mut hits, mut occluded) = (Hits::new(LARGEST), vec![false; LARGEST + PADDING]);
                let closest = message(&mut || accel.closest_all(&rays, hint, &panics, &mut hits));
                let any = message(&mut || accel.occluded_all(&rays, hint, &panics, &mut occluded));
                assert_eq!([closest, any], ["object 1"; 2], "{setup:?} {width}");
                let (hits, _) = asked(accel, &rays, hint, &Opaque);
                let objects: Vec<u32> = (0..LARGEST).map(|at| hits.hit(at).object).collect();
                let expected: Vec<u32> = (0..LARGEST).map(|at| u32::from(at == 21)).collect();
                assert_eq!(objects, expected, "{setup:?} {width}: the scene goes on");
            }
        });
    }
}
