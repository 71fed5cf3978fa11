//! Do intervals that claim trust deserve it, where luck hides the tail? Many renders of a world that differ in the seed
//! alone: the truth is what they agree on. Of all intervals by one method that claim trust 93 to 97 % must hold (as in
//! coverage.rs, a count convicts that rejects all of these rates), and on plain worlds most must claim it.

use crate::coverage::conviction;
use crate::hidden_tails::{HARD, PLAIN, lit_by, world};
use etendue::film::{ImageError, Known, Layout, Plane, Reason};
use etendue::integrator::{self, FilmRenderer, IntegratorConfig, Method};
use etendue::scene::Scene;
use etendue_testing::deep;
use rayon::prelude::*;

const SIDE: u32 = 16;
/// Level of each judgement.
const LEVEL: f64 = 1e-3;
const METHODS: [Method; 3] = [Method::Path, Method::Bdpt, Method::Light];

/// A render's mean and error at one number of samples.
struct Observation {
    image: Vec<f64>,
    error: ImageError,
}

/// The looks at a render of `seed` when it has so many samples as `counts` says, in rising order.
fn looks(scene: &Scene, method: Method, counts: &[u64], seed: u64) -> Vec<Observation> {
    let layout = Layout::new(SIDE, SIDE, None, &[]);
    let options = IntegratorConfig { seed, ..IntegratorConfig::new(method, &layout) };
    let camera = scene.camera(None, SIDE, SIDE).expect("a camera");
    let mut renderer = FilmRenderer::begin(scene, camera, &options, &layout);
    let known = Known { independent: method.independent(), prior: integrator::prior(method, scene) };
    let mut found = Vec::new();
    for pass in 1..=*counts.last().expect("a count") {
        renderer.passes(1);
        if counts.contains(&pass) {
            let image = renderer.film().mean(Plane::Color).into_iter().map(f64::from).collect();
            found.push(Observation { image, error: renderer.film().image_error(known).expect("replicates") });
        }
    }
    found
}

/// What renders of one world by one method came to.
struct Study {
    /// By number of samples: the true relMSE, how many claim trust, how many of these hold, and the mean stated.
    rows: Vec<(f64, usize, usize, f64)>,
    runs: usize,
}

impl Study {
    fn of(scene: &Scene, method: Method, counts: &[u64], runs: u64) -> Self {
        let all: Vec<Vec<Observation>> =
            (0..runs).into_par_iter().map(|seed| looks(scene, method, counts, 0x7e57_0000 + seed)).collect();
        let (n, last) = (runs as f64, counts.len() - 1);
        let values = all[0][last].image.len();
        let means: Vec<f64> = (0..values).map(|v| all.iter().map(|run| run[last].image[v]).sum::<f64>() / n).collect();
        let epsilon = (0.1 * means.iter().sum::<f64>() / values as f64).powi(2);
        let relative = |(x, m): (&f64, &f64)| (x - m).powi(2) / (m * m + epsilon);
        let error = |look: &Observation| look.image.iter().zip(&means).map(relative).sum::<f64>() / values as f64;
        let found = |i: usize| all.iter().map(|run| error(&run[i])).sum::<f64>() / n;
        // Images are part of the mean that they are held against, each with the samples of its earlier looks.
        let of_mean = found(last) / (n - 1.0);
        let row = |i: usize| {
            let truth = found(i) + of_mean;
            let trusted: Vec<_> = all.iter().map(|run| &run[i].error).filter(|error| error.trust.trusted).collect();
            let holds = trusted.iter().filter(|e| (e.relmse.low..=e.relmse.high).contains(&truth)).count();
            let stated = all.iter().map(|run| run[i].error.relmse.value).sum::<f64>() / n;
            (truth, trusted.len(), holds, stated)
        };
        Study { rows: (0..counts.len()).map(row).collect(), runs: runs as usize }
    }
}

/// Deep: the table of docs/measurements.md.
#[test]
fn trusted_intervals_cover_at_95_percent() {
    if !deep() {
        return;
    }
    let (counts, mut convicted) = ([16, 64, 128], Vec::new());
    for method in METHODS {
        let mut all = [0; 2];
        for name in PLAIN.iter().chain(HARD) {
            let study = Study::of(&world(name), method, &counts, 100);
            for (spp, (truth, claimed, held, stated)) in counts.iter().zip(&study.rows) {
                println!("| {name} | {method:?} | {spp} | {truth:.2e} | {stated:.2e} | {claimed} | {held} |");
                all = [all[0] + claimed, all[1] + held];
                let is_plain = PLAIN.contains(name) && *spp >= 64;
                if is_plain && claimed * 10 < study.runs * 9 {
                    convicted.push(format!(
                        "{name} by {method:?} at {spp} spp: only {claimed} of {} claim trust",
                        study.runs
                    ));
                }
            }
        }
        println!("{method:?}: {} of {} hold", all[1], all[0]);
        let how = conviction(all[1] as u64, all[0] as u64, LEVEL);
        convicted.extend(how.map(|how| format!("{method:?}: {} of {} hold: {how}", all[1], all[0])));
    }
    assert!(convicted.is_empty(), "{}", convicted.join("\n"));
}

/// The two scenes of the issue, by kind: bdpt where mirrors show caustics of a small lamp. A few renders are enough to
/// see that none claims trust, as luck would have it that most meet nothing rare.
#[test]
fn renders_without_caustic_samples_are_untrusted() {
    for (name, method) in
        [("mirrors-shaded", Method::Bdpt), ("glass-mirror", Method::Bdpt), ("mirror-ball-small", Method::Path)]
    {
        for look in (0..6).flat_map(|seed| looks(&world(name), method, &[16], 0x7e57_0000 + seed)) {
            let trust = look.error.trust();
            assert!(!trust.trusted && trust.reasons.iter().any(|d| d.reason == Reason::RarePaths), "{name}: {trust:?}");
        }
    }
}

/// Where nothing is hidden trust is claimed: at least 5 of 6 renders. Each alone does at 97 % and more, with a point
/// light from 64 samples per pixel on (docs/measurements.md).
#[test]
fn easy_scenes_are_trusted() {
    for name in PLAIN {
        for method in [Method::Path, Method::Bdpt] {
            let spp = if *name == "point" { 64 } else { 16 };
            let found = (0..6).flat_map(|seed| looks(&world(name), method, &[spp], 0x7e57_0000 + seed));
            let trusted = found.filter(|look| look.error.trust.trusted).count();
            assert!(trusted >= 5, "{name} by {method:?}: {trusted} of 6");
        }
    }
}

/// A room with two lamps by path tracing at 16 spp: the mean of what renders state is within 2 % of what they show, and
/// within 4 standard errors of both.
#[test]
fn relmse_of_a_room_with_two_lamps_is_right() {
    let runs = if deep() { 400 } else { 40 };
    let study = Study::of(&world("two-lamps"), Method::Path, &[16], runs);
    let (truth, _, _, stated) = study.rows[0];
    // One render's error is off by 7 % of the mean one, at 256 pixels × a few effective degrees of freedom.
    let noise = 4.0 * 0.1 / (runs as f64).sqrt();
    println!("stated {stated:.4e}, true {truth:.4e}");
    assert!((stated / truth - 1.0).abs() < 0.02 + noise, "{stated} {truth}");
}

/// What the pilot decides is the same for all seeds, also where its mean is next to a power of two: there one seed in
/// two would fall on the other side (twenty alike by chance: P = 2e-6).
#[test]
fn pilot_estimate_is_independent_of_the_seed() {
    let layout = Layout::new(SIDE, SIDE, None, &[]);
    let typical = |power: f32, seed: u64| {
        let scene = lit_by(power);
        let camera = scene.camera(None, SIDE, SIDE).expect("a camera");
        integrator::pilot(
            &scene,
            &camera,
            &IntegratorConfig { seed, ..IntegratorConfig::new(Method::Path, &layout) },
            &layout,
        )
        .typical
    };
    let (mut below, mut above) = (1.0, 2.0);
    let first = typical(below, 0);
    for _ in 0..12 {
        let middle = 0.5 * (below + above);
        let side = if typical(middle, 0) > first { &mut above } else { &mut below };
        *side = middle;
    }
    let found: Vec<f32> = (0..20).map(|seed| typical(below, seed)).collect();
    assert!(found.iter().all(|t| t.to_bits() == first.to_bits()), "{found:?}");
}
