//! Coverage of error bars. Many renders of one scene that differ in the seed alone; the truth is what
//! they agree on. A stated 95 % interval fails where the number of renders that it covers in rejects every rate from 93
//! to 97 %.

use crate::references::load;
use etendue::film::{Film, Filter, ImageError, Layout, PassFilm, Plane};
use etendue::integrator::{self, IntegratorConfig, Method};
use etendue::parallel::Cancel;
use etendue::path::Techniques;
use etendue::sampling::SamplerKind;
use etendue::scene::Scene;
use etendue::session::target::{self, Check};
use etendue::stats::student_quantile;
use etendue_testing::deep;
use etendue_testing::levels::sidak_level;
use etendue_testing::methods::ChainOptions;
use rayon::prelude::*;
use statrs::distribution::{Binomial, ContinuousCDF, DiscreteCDF, Normal};

const SIDE: u32 = 16;
/// The rates that a count must reject, all of them, to convict, and the level of either side.
const RATES: [f64; 2] = [0.93, 0.97];
const LEVEL: f64 = 1e-3;
/// A t interval assumes that the four replicate means are normal. Where their skewness is above this it does not hold
/// its level: such pixels are named and left out. Bins of [`judge_pixels`] below it count.
const SKEWED: f64 = 1.0;
/// So are pixels whose replicate means take few values, which one replicate often agrees on with another: those of a
/// quasi-random replicate on the edge of a lamp. They are recognised by the Kolmogorov distance of their distribution
/// from a normal one. A skewness of 1 makes it 0.07, and the noise of 2,000 runs 0.02.
const LUMPY: f64 = 0.1;

/// Whether `hits` of `runs` convict an interval that says 95 %, at `level` on either side, and of what.
pub(crate) fn conviction(hits: u64, runs: u64, level: f64) -> Option<&'static str> {
    let tail = |rate: f64| Binomial::new(rate, runs).expect("a rate");
    if tail(RATES[0]).cdf(hits) < level {
        return Some("too narrow");
    }
    let too_many = hits > 0 && tail(RATES[1]).sf(hits - 1) < level;
    too_many.then_some("too wide")
}

/// One render: the film at the end, and the looks at its error on the way with what was seen.
struct Run {
    film: Film,
    /// Means by replicate, pixel and channel.
    replicates: Vec<Vec<f64>>,
    looks: Vec<(Check, Vec<f64>)>,
}

/// A target that any trusted error is below.
const ANY: f64 = f64::INFINITY;

fn image(film: &Film) -> Vec<f64> {
    film.mean(Plane::Color).into_iter().map(f64::from).collect()
}

/// What is rendered over and over.
#[derive(Debug, Clone, Copy)]
struct Subject {
    scene: &'static str,
    method: Method,
    filter: Filter,
    spp: u64,
    /// See [`ChainOptions::threshold`].
    limit: Option<f64>,
}

/// A subject by path tracing, whose pixels have their own samples with any filter.
const fn path(scene: &'static str, spp: u64) -> Subject {
    Subject { scene, method: Method::Path, filter: Filter::Box, spp, limit: None }
}

/// The view of a scene that is rendered over and over.
struct Study<'a> {
    scene: &'a Scene,
    subject: Subject,
    sampler: SamplerKind,
}

impl Study<'_> {
    fn run(&self, seed: u64) -> Run {
        let Subject { method, filter, spp, .. } = self.subject;
        let replicates = method.replicates();
        let chains = ChainOptions { threshold: self.subject.limit, ..ChainOptions::default() };
        let layout = Layout::new(SIDE, SIDE, None, &[]);
        let options = IntegratorConfig {
            seed,
            sampler: self.sampler,
            filter,
            ..IntegratorConfig::new(chains.config(method, Techniques::ALL), &layout)
        };
        let camera = self.scene.camera(None, SIDE, SIDE).expect("a camera");
        let pilot = integrator::pilot(self.scene, &camera, &options, &layout);
        let mut film = Film::new(layout.clone(), replicates, seed, pilot.units);
        let integrator = integrator::build(self.scene, camera, &options, &pilot);
        let (mut values, mut looks) = (PassFilm::new(&layout), Vec::new());
        let mut means = vec![vec![0.0; layout.pixels() * 3]; replicates as usize];
        for pass in 0..spp {
            values.clear();
            integrator.run_pass(pass, &Cancel::new(), &mut values).expect("not cancelled");
            film.commit(pass, &values);
            let colors = values.values().chunks_exact(layout.channels()).flat_map(|pixel| &pixel[..3]);
            let mean = &mut means[(pass % u64::from(replicates)) as usize];
            mean.iter_mut()
                .zip(colors)
                .for_each(|(mean, &c)| *mean += f64::from(c) * f64::from(replicates) / spp as f64);
            looks.extend(target::check(&film, method.independent(), ANY).map(|check| (check, image(&film))));
        }
        Run { film, replicates: means, looks }
    }

    fn runs(&self, count: u64) -> Vec<Run> {
        (0..count).into_par_iter().map(|seed| self.run(0x5eed_0000 + seed)).collect()
    }
}

/// What many runs agree on.
struct Truth {
    /// Means by pixel and channel.
    means: Vec<f64>,
    /// ε of relMSE.
    epsilon: f64,
    images: Vec<Vec<f64>>,
}

impl Truth {
    fn of(runs: &[Run]) -> Self {
        let images: Vec<Vec<f64>> = runs.iter().map(|run| image(&run.film)).collect();
        let values = images[0].len();
        let means: Vec<f64> =
            (0..values).map(|i| images.iter().map(|m| m[i]).sum::<f64>() / images.len() as f64).collect();
        let mean = means.iter().sum::<f64>() / values as f64;
        Truth { means, epsilon: (0.1 * mean).powi(2), images }
    }

    /// The relative squared error of one image.
    fn error_of(&self, image: &[f64]) -> f64 {
        let relative = |(x, m): (&f64, &f64)| (x - m).powi(2) / (m * m + self.epsilon);
        image.iter().zip(&self.means).map(relative).sum::<f64>() / image.len() as f64
    }

    /// The expectation of relMSE, n / (n − 1) for having the mean of the same n images as the truth.
    fn relmse(&self) -> f64 {
        let n = self.images.len() as f64;
        self.images.iter().map(|image| self.error_of(image)).sum::<f64>() / (n - 1.0)
    }
}

/// How far a distribution is from a normal one.
struct Shape {
    skewness: f64,
    /// Kolmogorov's.
    distance: f64,
}

impl Shape {
    /// That of the replicate means of a pixel and channel; `None` if they are all the same.
    fn of(runs: &[Run], value: usize) -> Option<Self> {
        let mut means: Vec<f64> = runs.iter().flat_map(|run| &run.replicates).map(|means| means[value]).collect();
        means.sort_by(f64::total_cmp);
        let n = means.len() as f64;
        let mean = means.iter().sum::<f64>() / n;
        let moment = |k: i32| means.iter().map(|m| (m - mean).powi(k)).sum::<f64>() / n;
        let deviation = moment(2).sqrt();
        let normal = Normal::new(mean, deviation).ok().filter(|_| deviation > 0.0)?;
        let gap = |(i, &m): (usize, &f64)| (normal.cdf(m) - i as f64 / n).max((i as f64 + 1.0) / n - normal.cdf(m));
        let distance = means.iter().enumerate().map(gap).fold(0.0, f64::max);
        Some(Shape { skewness: moment(3) / deviation.powi(3), distance })
    }
}

/// How a study came out.
#[derive(Debug, Default)]
struct Outcome {
    convicted: Vec<String>,
}

impl Outcome {
    fn judge(&mut self, what: &str, hits: u64, runs: u64) {
        println!("  {what}: {hits} of {runs} ({:.2} %)", 100.0 * hits as f64 / runs as f64);
        self.convicted.extend(conviction(hits, runs, LEVEL).map(|how| format!("{what} is {how}: {hits} of {runs}")));
    }
}

/// Image-level relMSE; intervals that say they are not to be trusted are left out.
fn judge_relmse(method: Method, runs: &[Run], truth: &Truth, out: &mut Outcome) {
    let expected = truth.relmse();
    let errors: Vec<_> = runs.iter().filter_map(|run| run.film.image_error(method.independent())).collect();
    let trusted: Vec<_> = errors.iter().filter(|error| error.trust.trusted).collect();
    println!("  relMSE {expected:.4e}; {} of {} intervals say they are to be trusted", trusted.len(), errors.len());
    let mean = |f: &dyn Fn(&ImageError) -> f64| trusted.iter().map(|e| f(e)).sum::<f64>() / trusted.len() as f64;
    let log = |e: &ImageError| (e.relmse.value / expected).ln();
    let spread = (mean(&|e| log(e).powi(2)) - mean(&log).powi(2)).sqrt();
    let stated = mean(&|e| (e.relmse.standard_error / e.relmse.value).powi(2)).sqrt();
    println!("  its logarithm: mean error {:+.4}, deviation {spread:.4}, stated {stated:.4}", mean(&log));
    let [removed, bound] = [mean(&|e| e.relmse.curvature_bias), mean(&|e| e.relmse.bias_bound / e.relmse.value)];
    println!("  bias by curvature, taken out: {removed:.4} of the value; allowed for: {bound:.4}");
    let holds = |low: f64, high: f64| (low..=high).contains(&expected);
    let hits = trusted.iter().filter(|e| holds(e.relmse.low, e.relmse.high)).count() as u64;
    if trusted.len() * 2 >= errors.len() {
        out.judge("the interval of relMSE", hits, trusted.len() as u64);
    } else {
        println!("  mostly not to be trusted, and says so: of the others {hits} hold");
    }
}

/// The t interval of each pixel and channel. Those far from normal are excepted by name.
fn judge_pixels(method: Method, runs: &[Run], truth: &Truth, out: &mut Outcome) {
    let t = student_quantile(0.975, f64::from(method.replicates() - 1));
    let errors: Vec<Vec<f32>> = runs.iter().map(|run| run.film.standard_error().expect("replicates")).collect();
    let each = sidak_level(LEVEL, truth.means.len() as u64);
    let count = runs.len() as u64;
    let mut bins = [[0; 2]; 5];
    let (mut skewed, mut lumpy) = (Vec::new(), Vec::new());
    for value in 0..truth.means.len() {
        let covers =
            |r: &usize| (truth.images[*r][value] - truth.means[value]).abs() <= t * f64::from(errors[*r][value]);
        let hits = (0..runs.len()).filter(covers).count() as u64;
        let Some(shape) = Shape::of(runs, value) else { continue };
        let (pixel, channel, skewness) = (value / 3, ["R", "G", "B"][value % 3], shape.skewness.abs());
        let name = format!("pixel {},{} {channel}", pixel as u32 % SIDE, pixel as u32 / SIDE);
        if skewness <= SKEWED && shape.distance > LUMPY {
            lumpy.push((name, shape.distance, hits));
            continue;
        }
        let bin = &mut bins[[0.25, 0.5, 1.0, 2.0].iter().filter(|&&edge| skewness > edge).count()];
        *bin = [bin[0] + hits, bin[1] + count];
        if skewness > SKEWED {
            skewed.push((name, skewness, hits));
        } else {
            out.convicted.extend(conviction(hits, count, each).map(|how| {
                let Shape { skewness, distance } = shape;
                format!("{name} is {how}: {hits} (skewness {skewness:.2}, distance from normal {distance:.2})")
            }));
        }
    }
    for (what, mut excepted) in [("skewness", skewed), ("distance from normal", lumpy)] {
        excepted.sort_by(|a, b| b.1.total_cmp(&a.1));
        println!(
            "  excepted for their {what}: {} of {} pixels × channels; the most:",
            excepted.len(),
            truth.means.len()
        );
        for (name, figure, hits) in excepted.iter().take(5) {
            println!("    {name}: {figure:.2}, {:.1} %", 100.0 * *hits as f64 / runs.len() as f64);
        }
    }
    for (bin, [hits, counted]) in ["to ¼", "to ½", "to 1", "to 2", "above"].iter().zip(bins).filter(|(_, b)| b[1] > 0)
    {
        println!("    skewness {bin}: {:.2} % of {}", 100.0 * hits as f64 / counted as f64, counted / count);
    }
    let [hits, counted] = bins[..3].iter().fold([0; 2], |a, b| [a[0] + b[0], a[1] + b[1]]);
    out.judge("intervals of the other pixels, together", hits, counted);
}

/// Runs that stop at the first look whose limit is below the target must have an expected error below it: at least 93
/// %. More than 97 % is no error: doubling the passes overshoots most targets, and looks that share a level are
/// conservative.
fn judge_target(runs: &[Run], truth: &Truth, out: &mut Outcome) {
    let expected =
        |look: usize| runs.iter().map(|run| truth.error_of(&run.looks[look].1)).sum::<f64>() / runs.len() as f64;
    let errors: Vec<f64> = (0..runs[0].looks.len()).map(expected).collect();
    for target in errors.iter().flat_map(|error| [0.98, 1.02, 1.1, 1.5].map(|factor| factor * error)) {
        let stop = |run: &Run| {
            let look = run.looks.iter().position(|(check, _)| check.reached && check.upper_limit <= target)?;
            Some((errors[look], truth.error_of(&run.looks[look].1)))
        };
        let stops: Vec<_> = runs.iter().filter_map(stop).collect();
        let right = stops.iter().filter(|(expected, _)| *expected <= target).count() as u64;
        let lucky = stops.iter().filter(|(_, found)| *found <= target).count();
        println!(
            "  target {target:.3e}: {} of {} stopped, {right} of them below in expectation, {lucky} in fact",
            stops.len(),
            runs.len()
        );
        // Runs that go on are not wrong: the rate is that of all runs.
        let not_wrong = (runs.len() - stops.len()) as u64 + right;
        if conviction(not_wrong, runs.len() as u64, LEVEL) == Some("too narrow") {
            out.convicted.push(format!("target {target:.3e}: {not_wrong} of {} are not wrong", runs.len()));
        }
    }
}

fn study(subject: Subject, sampler: SamplerKind, count: u64) -> Outcome {
    let Some(scene) = load(subject.scene) else { return Outcome::default() };
    let study = Study { scene: &scene, subject, sampler };
    println!("{subject:?}, {sampler:?}, {count} runs:");
    let runs = study.runs(count);
    let (truth, mut out) = (Truth::of(&runs), Outcome::default());
    judge_relmse(subject.method, &runs, &truth, &mut out);
    judge_pixels(subject.method, &runs, &truth, &mut out);
    judge_target(&runs, &truth, &mut out);
    out
}

/// The Cornell box by every way in which pixels share samples, and by path tracing, whose pixels do not.
const CORNELL: &[Subject] = &[
    path("cornell-box", 64),
    Subject { method: Method::Light, ..path("cornell-box", 64) },
    Subject { method: Method::Bdpt, ..path("cornell-box", 64) },
];

/// What the deep study adds. The last two by path tracing are too noisy for their own error and must say so. A splat
/// under a wide filter falls on sixteen pixels at once; no lamp is seen there, whose edge would make most of the error.
const DEEP: &[Subject] = &[
    path("sphere-cap", 64),
    path("sphere-lamp", 64),
    Subject { method: Method::Light, filter: Filter::BlackmanHarris, ..path("modified-cornell", 64) },
    path("modified-cornell", 64),
    path("veach-mis", 64),
];

/// Everything left to chains, which serve the whole picture: replicates alone are independent.
const fn chains(method: Method, scene: &'static str, spp: u64) -> Subject {
    Subject { method, limit: Some(0.0), ..path(scene, spp) }
}

/// The first is too noisy for its own error and must say so; the last has the limit of its pilot.
const CHAINS: &[Subject] = &[
    chains(Method::Pssmlt, "cornell-box", 32),
    chains(Method::Mmlt, "cornell-box", 512),
    chains(Method::Mlt, "cornell-box", 512),
    Subject { method: Method::Mlt, ..path("cornell-box", 64) },
];

fn expect_coverage(subjects: impl IntoIterator<Item = Subject>, samplers: &[SamplerKind], count: u64) {
    let mut convicted = Vec::new();
    for subject in subjects {
        for &sampler in samplers {
            let outcome = study(subject, sampler, count);
            convicted.extend(outcome.convicted.into_iter().map(|c| format!("{subject:?}, {sampler:?}: {c}")));
        }
    }
    assert!(convicted.is_empty(), "{} convicted:\n{}", convicted.len(), convicted.join("\n"));
}

#[test]
fn error_bars_cover_as_stated() {
    let (more, count): (&[Subject], _) = if deep() { (DEEP, 2000) } else { (&[], 60) };
    let samplers = [SamplerKind::Independent, SamplerKind::Sobol];
    expect_coverage(CORNELL.iter().chain(more).copied(), &samplers, count);
}

/// Deep.
#[test]
fn error_bars_of_chains_cover_as_stated() {
    if deep() {
        expect_coverage(CHAINS.iter().copied(), &[SamplerKind::Sobol], 500);
    }
}

/// The rule itself: right rates pass, wrong ones do not.
#[test]
fn binomial_test_rejects_wrong_coverage_only() {
    for right in [1860, 1900, 1940] {
        assert_eq!(conviction(right, 2000, LEVEL), None, "{right}");
    }
    assert_eq!(conviction(1800, 2000, LEVEL), Some("too narrow"));
    assert_eq!(conviction(1975, 2000, LEVEL), Some("too wide"));
}
