//! Metropolis methods against bidirectional path tracing and exact answers. Passes are groups of chains: all that is
//! compared are whole renders of seeds of their own.

use crate::bidirectional::{How, agree, expect_crop, runs, some_runs, spp, times};
use crate::equilibrium::{KINDS, Kind, equilibrium};
use crate::picture::{LEVEL, Shot, scene};
use crate::references::load;
use etendue::film::Filter;
use etendue::integrator::Method;
use etendue::path::Technique;
use etendue::stats::t_test;
use etendue_testing::deep;
use etendue_testing::levels::sidak_level;
use etendue_testing::methods::ChainOptions;
use etendue_testing::worlds::{World, all};

const METHODS: [Method; 3] = [Method::Pssmlt, Method::Mmlt, Method::Mlt];

/// With everything left to chains, or what is above so many times the usual.
fn how(method: Method, samples: u64, limit: f64) -> How {
    let chains = ChainOptions { threshold: Some(limit), depths: Some(5), ..ChainOptions::default() };
    How { chains, ..How::new(method, 16, spp(samples)) }
}

/// Rough and Dirac surfaces, mixtures, bent normals, absorption, lights of all kinds under a map.
#[test]
fn metropolis_methods_match_bdpt() {
    for World { name, scene, .. } in all() {
        let bdpt = runs(&scene, &How::new(Method::Bdpt, 16, spp(16)));
        // Lamps behind bodies and panes are found by few.
        let samples = if name == "nested" { 128 } else { 16 };
        for method in METHODS {
            let found = runs(&scene, &how(method, samples, 0.0));
            agree(&bdpt, &found).unwrap_or_else(|e| panic!("{name}, {method:?}: {e}"));
            assert!(agree(&bdpt, &found.scaled(1.2)).is_err(), "{name}, {method:?}: 20 % more is not convicted");
        }
    }
}

/// The part below the limit and the part above it are the whole.
#[test]
fn bdpt_below_and_mlt_above_threshold_sum_to_bdpt() {
    for World { name, scene, .. } in all().into_iter().filter(|w| deep() || w.name == "dirac") {
        let bdpt = runs(&scene, &How::new(Method::Bdpt, 16, spp(16)));
        for (method, limit) in METHODS.into_iter().zip([0.5, 1.0, 1.0]) {
            let found = runs(&scene, &how(method, 16, limit));
            agree(&bdpt, &found).unwrap_or_else(|e| panic!("{name}, {method:?}, limit {limit}: {e}"));
            assert!(agree(&bdpt, &found.scaled(1.1)).is_err(), "{name}, {method:?}: 10 % more is not convicted");
        }
    }
}

/// The same for light tracing, whose contributions are all splats.
#[test]
fn light_below_and_mmlt_above_threshold_sum_to_light() {
    let World { scene, .. } = all().into_iter().next().expect("rough");
    let light = some_runs(&scene, &How::new(Method::Light, 16, spp(128)), 8);
    let found = some_runs(
        &scene,
        &how(Method::Mmlt, 16, 0.5).without(&[Technique::Hit, Technique::NextEvent, Technique::Connect]),
        8,
    );
    agree(&light, &found).unwrap_or_else(|e| panic!("{e}"));
    assert!(agree(&light, &found.scaled(1.2)).is_err(), "20 % more is not convicted");
}

/// Deep: the scenes that renderers are compared on, with what is usual and with everything left to chains.
#[test]
fn metropolis_methods_match_bdpt_on_stock_scenes() {
    if !deep() {
        return;
    }
    for name in ["cornell-box", "modified-cornell", "glass-caustic", "ajar-door"] {
        let scene = load(name).expect("make scenes");
        let of = |how: How| runs(&scene, &How { shot: Shot { filter: Filter::Box, ..how.shot }, ..how });
        let bdpt = of(How::new(Method::Bdpt, 64, 64));
        for method in METHODS {
            for limit in [None, Some(0.0)] {
                let chains = ChainOptions { threshold: limit, ..ChainOptions::default() };
                let found = of(How { chains, ..How::new(method, 64, 64) });
                agree(&bdpt, &found).unwrap_or_else(|e| panic!("{name}, {method:?}, {limit:?}: {e}"));
                assert!(
                    agree(&bdpt, &found.scaled(1.1)).is_err(),
                    "{name}, {method:?}, {limit:?}: 10 % more is not convicted"
                );
            }
        }
    }
}

/// A picture so small that a chain is short and its seed matters.
fn expect_small_picture(method: Method, count: u64, chains: ChainOptions) {
    let World { scene, .. } = all().into_iter().find(|w| w.name == "dirac").expect("dirac");
    let [bdpt, found] =
        [Method::Bdpt, method].map(|m| some_runs(&scene, &How { chains, ..How::new(m, 16, 16) }, count));
    agree(&bdpt, &found).unwrap_or_else(|e| panic!("{method:?}: {e}"));
}

#[test]
fn mlt_matches_bdpt_on_a_small_image() {
    expect_small_picture(Method::Mlt, 16, ChainOptions::all());
}

#[test]
fn mmlt_matches_bdpt_on_a_small_image() {
    expect_small_picture(Method::Mmlt, 10, ChainOptions { depths: Some(2), ..ChainOptions::all() });
}

#[test]
fn two_stage_mlt_matches_bdpt_on_a_small_image() {
    let chains = ChainOptions { two_stage: true, ..ChainOptions::all() };
    expect_small_picture(Method::Mlt, 6, chains);
}

#[test]
fn mlt_above_threshold_matches_bdpt_on_a_small_image() {
    expect_small_picture(Method::Mlt, 6, ChainOptions { threshold: Some(0.5), ..ChainOptions::default() });
}

/// Depth counts scattering events, in chains too.
#[test]
fn max_depth_agrees_between_bdpt_and_metropolis() {
    let World { scene, .. } = all().into_iter().next().expect("rough");
    for depth in [0, 1, 2, 3] {
        let of = |how: How| {
            let mut how = how;
            how.shot.depth = Some(depth);
            runs(&scene, &how)
        };
        let path = of(How::new(Method::Path, 16, spp(16)));
        for method in [Method::Mmlt, Method::Mlt] {
            agree(&path, &of(self::how(method, 16, 0.0))).unwrap_or_else(|e| panic!("{method:?}, depth {depth}: {e}"));
        }
    }
}

/// Without techniques that need light subpaths, PSSMLT integrates what path tracing does.
#[test]
fn pssmlt_without_light_subpaths_matches_path() {
    let World { scene, .. } = all().into_iter().next().expect("rough");
    let path = runs(&scene, &How::new(Method::Path, 16, spp(16)));
    for method in [Method::Pssmlt, Method::Mmlt] {
        let found = runs(&scene, &how(method, 32, 0.0).without(&[Technique::Connect, Technique::Splat]));
        agree(&path, &found).unwrap_or_else(|e| panic!("{method:?}: {e}"));
    }
}

/// See `equilibrium.rs`.
#[test]
fn metropolis_keeps_thermal_equilibrium() {
    let rounds = if deep() { 10 } else { 1 };
    let cases: Vec<(Kind, u64)> = (0..rounds).flat_map(|round| KINDS.map(|kind| (kind, round))).collect();
    for &(kind, round) in &cases {
        let (description, expected) = equilibrium(kind, 1000 + round * 10 + kind as u64);
        let scene = scene(description);
        for method in METHODS {
            let found = runs(&scene, &how(method, 8, 0.0)).overall();
            println!("{kind:?} {round} {method:?}: {} ± {:.1e} of {expected}", found.value, found.standard_error);
            let level = sidak_level(LEVEL, (METHODS.len() * cases.len()) as u64);
            // In a scene that loses nothing every sample may be exact but for a few dozen roundings.
            let exact = (found.value - expected).abs() < 64.0 * f64::from(f32::EPSILON) * expected;
            assert!(
                exact || t_test(&found, expected).p_value > level,
                "{kind:?} {round}, {method:?}: {found:?} of {expected}"
            );
            assert!(
                t_test(&times(found, 1.2), expected).p_value < level,
                "{kind:?} {round}, {method:?}: 20 % are not convicted"
            );
        }
    }
}

#[test]
fn metropolis_crop_matches_the_full_image() {
    let World { scene, .. } = all().into_iter().next().expect("rough");
    for (method, filter) in [(Method::Mlt, Filter::BlackmanHarris), (Method::Mmlt, Filter::Box)] {
        expect_crop(&scene, how(method, 16, 0.0), filter);
    }
}
