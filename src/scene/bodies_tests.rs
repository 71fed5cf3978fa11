use super::*;
use crate::medium::{Homogeneous, Phase};

/// Boxes of that half-size around points of the x axis.
fn boxes(places: &[(f32, f32)]) -> AllBodies {
    let interior = Interior {
        medium: Homogeneous::new(Spectrum::ZERO, Spectrum::ZERO, Phase::Isotropic),
        density: None,
        albedo: None,
        emission_grid: None,
        ior: 1.5,
        priority: 0,
    };
    let body = |&(x, half): &(f32, f32)| {
        let (centre, half) = (Vec3::X * x, Vec3::splat(half));
        Body { interior, instance: 0, bounds: Bounds { min: centre - half, max: centre + half }, is_open: false }
    };
    AllBodies::ranked(places.iter().map(body).collect())
}

fn set(bodies: &AllBodies, entered: &[u32]) -> Bodies {
    entered.iter().fold(Bodies::NONE, |set, &body| bodies.with(set, body))
}

#[test]
fn body_set_is_independent_of_order_and_repetition_of_crossings() {
    let bodies = boxes(&(1..=8).map(|i| (0.0, i as f32)).collect::<Vec<_>>());
    let a = set(&bodies, &[7, 2, 5, 2]);
    assert_eq!(a, set(&bodies, &[5, 7, 2]));
    assert_eq!(bodies.members(a)[..], [2, 5, 7]);
    assert_eq!(bodies.first_without(a, 2), Some(5));
    assert_eq!(bodies.first_without(a, 7), Some(2));
    assert_eq!(bodies.without(bodies.without(a, 2), 1).first(), Some(5));
    assert_eq!([5, 2, 7].iter().fold(a, |set, &body| bodies.without(set, body)), Bodies::NONE);
    assert!(a.has_more_than(2) && !set(&bodies, &[2]).has_more_than(2) && set(&bodies, &[3]).has_more_than(2));
}

#[test]
fn entering_a_body_leaves_all_disjoint_ones() {
    let bodies = boxes(&[(0.0, 1.0), (5.0, 1.0), (2.0, 8.0)]);
    assert_eq!(bodies.members(set(&bodies, &[0, 2, 1]))[..], [1, 2]);
    let apart = boxes(&[(0.0, 1.0), (5.0, 1.0)]);
    assert!(bodies.overlap() && !apart.overlap());
    assert_eq!(set(&apart, &[0, 1]), Bodies::new(1, 0));
}

/// A flat water surface contains everything below it; bodies inside it have precedence.
#[test]
fn open_bodies_rank_last_and_overlap_all_others() {
    let mut list = boxes(&[(0.0, 1.0), (50.0, 1.0), (0.0, 20.0)]).list;
    list[2].is_open = true;
    list[2].bounds.max.y = -20.0;
    assert!(list[0].precedes(&list[2]).is_lt());
    let bodies = AllBodies::ranked(list);
    for ball in [0, 1] {
        assert_eq!(bodies.members(set(&bodies, &[2, ball]))[..], [ball, 2]);
    }
}

#[test]
fn lowest_precedence_is_dropped_beyond_capacity() {
    let bodies = boxes(&[(0.0, 1.0); 40]);
    let all = set(&bodies, &(0..40).collect::<Vec<_>>());
    assert_eq!(bodies.members(all)[..], (0..=32).collect::<Vec<u32>>()[..]);
}
