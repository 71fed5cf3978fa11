use super::*;
use crate::lab::same_mean::{Outcome, PairJudgement, Worst};

fn labels(methods: &[Method], backends: &[Backend]) -> Vec<Label> {
    let all = backends.iter().flat_map(|&b| methods.iter().map(move |&m| (m, b)));
    all.map(|(m, b)| (m, b, format!("{}/{}", m.name(), b.name()))).collect()
}

/// A judgement in which exactly the pairs selected by `differ` differ.
fn judgement(count: usize, differ: impl Fn(usize, usize) -> bool) -> Judgement {
    let area = crate::film::Crop { x0: 0, y0: 0, x1: 8, y1: 8 };
    let image = Worst { area, channel: 0, a: 1.0, b: 1.0, relative: 0.0, interval: [0.0; 2], t: 0.0, p_value: 1.0 };
    let pair = |a, b| PairJudgement {
        a,
        b,
        outcome: if differ(a, b) { Outcome::Differ } else { Outcome::Agree },
        image,
        tile: None,
        tiles_different: 0,
        tiles: 0,
        tiles_undecided: 0,
        detectable: None,
        detectable_tile: None,
        detectable_side: None,
    };
    let pairs = (0..count).flat_map(|a| (a + 1..count).map(move |b| (a, b))).map(|(a, b)| pair(a, b)).collect();
    Judgement { level: 1e-3, tests: 0, pairs }
}

const METHODS: [Method; 3] = [Method::PathNaive, Method::PathNee, Method::Path];
const BACKENDS: [Backend; 2] = [Backend::Embree, Backend::Obvhs];

fn odd(differ: impl Fn(usize, usize) -> bool) -> Option<(String, bool)> {
    let labels = labels(&METHODS, &BACKENDS);
    Outlier::of(&labels, &judgement(6, differ)).map(|o| (o.who, o.from_all))
}

#[test]
fn outlier_is_a_candidate_a_method_or_a_backend() {
    assert_eq!(odd(|_, _| false), None);
    assert_eq!(odd(|a, b| a == 4 || b == 4), Some(("path-nee/obvhs".into(), true)));
    assert_eq!(odd(|a, b| (a % 3 == 1) != (b % 3 == 1)), Some(("path-nee with every backend".into(), true)));
    assert_eq!(odd(|a, b| (a < 3) != (b < 3)), Some(("one backend or the other".into(), true)));
}

#[test]
fn noisy_pairs_leave_one_suspect_or_none() {
    // Two of three pairs differ. All involve candidate 2, but also its method.
    assert_eq!(odd(|a, b| b == 2 && a < 2), None);
    let three = labels(&METHODS, &BACKENDS[1..]);
    assert_eq!(Outlier::of(&three, &judgement(3, |a, b| a == 0 && b == 1)), None);
    assert_eq!(Outlier::of(&three, &judgement(3, |_, b| b == 2)).map(|o| o.who), Some("path/obvhs".into()));
    assert_eq!(Outlier::of(&three, &judgement(3, |_, _| true)), None);
    assert_eq!(Outlier::of(&three[..2], &judgement(2, |_, _| true)), None);
}
