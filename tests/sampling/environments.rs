//! Lat-long maps: what is sampled against its density, the density against the lookup, both against the texels in f64.

use etendue::light::EnvironmentMap;
use etendue::sampling::Density;
use etendue::spectrum::{LANES, Spectrum};
use etendue::texture::RadianceMap;
use etendue_lanes::{Array, Float, Mask, Native};
use etendue_testing::chi_square::{p_value, sidak};
use etendue_testing::random::{Random, samples};
use glam::{DVec3, Vec3};
use statrs::distribution::{ContinuousCDF, Normal};
use std::f64::consts::{PI, TAU};
use std::sync::Arc;

/// A map with what the tests know about it.
struct Case {
    name: &'static str,
    width: usize,
    height: usize,
    texels: Vec<[f32; LANES]>,
    degrees: f64,
    light: EnvironmentMap,
}

impl Case {
    fn new(
        name: &'static str,
        [width, height]: [usize; 2],
        degrees: f64,
        texel: impl Fn(usize, usize) -> [f32; LANES],
    ) -> Self {
        let texels: Vec<_> = (0..width * height).map(|i| texel(i % width, i / width)).collect();
        let map = Arc::new(RadianceMap::new(width as u32, height as u32, texels.clone()));
        let light = EnvironmentMap::new(map, 1.0, degrees).expect("light");
        Case { name, width, height, texels, degrees, light }
    }

    /// Relative error of a density or radiance at a place that f32 directions and angles give: 16 roundings of a
    /// coordinate, seen in texels.
    fn rounding(&self) -> f64 {
        16.0 * f64::from(f32::EPSILON) * (self.width + self.height) as f64
    }

    fn mean(&self, x: usize, y: usize) -> f64 {
        self.texels[y * self.width + x % self.width].iter().map(|&c| f64::from(c)).sum::<f64>() / LANES as f64
    }

    /// What the density follows of a texel: the mean over lanes less 0.7 of the map's, but at least 0.1 of it.
    fn share(&self, x: usize, y: usize) -> f64 {
        let mean = self.mean(x, y);
        (mean - 0.7 * self.by_height(Case::mean) / (4.0 * PI)).max(0.1 * mean)
    }

    /// ∫ over the sphere of `texels`, interpolated linearly in height.
    fn by_height(&self, texels: impl Fn(&Case, usize, usize) -> f64) -> f64 {
        let strip = |j: usize| {
            let row = |y: usize| (0..self.width).map(|x| texels(self, x, y)).sum::<f64>() / self.width as f64;
            let [above, below] = self.rows(j).map(row);
            (self.edge(j).cos() - self.edge(j + 1).cos()) * (above + below) / 2.0
        };
        TAU * (0..=self.height).map(strip).sum::<f64>()
    }

    /// The angle from the zenith where strip `j` of cells begins.
    fn edge(&self, j: usize) -> f64 {
        ((j as f64 - 0.5) / self.height as f64).clamp(0.0, 1.0) * PI
    }

    fn rows(&self, strip: usize) -> [usize; 2] {
        [strip.saturating_sub(1), strip.min(self.height - 1)]
    }

    /// The direction that column `u` shows at the cosine `cos` to the zenith.
    fn direction(&self, u: f64, cos: f64) -> DVec3 {
        let phi = TAU * (0.5 - u) + self.degrees.to_radians();
        let sin = (1.0 - cos * cos).max(0.0).sqrt();
        DVec3::new(sin * phi.cos(), cos, -sin * phi.sin())
    }

    /// The quarter of a cell in which `w` lies: strips, columns from centre to centre, halves in height and azimuth.
    fn quarter(&self, w: DVec3) -> usize {
        let phi = (-w.z).atan2(w.x) - self.degrees.to_radians();
        let x = ((0.5 - phi / TAU) * self.width as f64 - 0.5).rem_euclid(self.width as f64) * 2.0;
        let theta = w.x.hypot(w.z).atan2(w.y);
        let strip = (0..=self.height).rfind(|&j| self.edge(j) <= theta).unwrap_or(0);
        let (top, bottom) = (self.edge(strip).cos(), self.edge(strip + 1).cos());
        let half = usize::from((top - w.y) / (top - bottom) >= 0.5);
        (2 * strip + half) * 2 * self.width + (x as usize).min(2 * self.width - 1)
    }

    /// ∫ of `f` over each quarter, exact to rounding where `f` is bilinear in azimuth and height: the product of
    /// two-point Gauss rules.
    fn integrate_quarters(&self, f: impl Fn(Vec3) -> f64) -> Vec<f64> {
        let nodes = [0.5 - 0.5 / 3f64.sqrt(), 0.5 + 0.5 / 3f64.sqrt()];
        let quarter = |i: usize| {
            let (row, column) = (i / (2 * self.width), i % (2 * self.width));
            let (top, bottom) = (self.edge(row / 2).cos(), self.edge(row / 2 + 1).cos());
            let at = |s: f64, x: f64| {
                let cos = top + (bottom - top) * ((row % 2) as f64 + s) / 2.0;
                f(self.direction((1.0 + column as f64 + x) / (2 * self.width) as f64, cos).as_vec3())
            };
            let sum: f64 = nodes.iter().flat_map(|&s| nodes.iter().map(move |&x| (s, x))).map(|(s, x)| at(s, x)).sum();
            sum / 4.0 * (top - bottom) / 2.0 * TAU / (2 * self.width) as f64
        };
        (0..4 * self.width * (self.height + 1)).map(quarter).collect()
    }

    /// ∫ of the bilinear lookup, lane by lane: columns give their mean, strips the mean of their rows with the weights
    /// ∫ (1 − t) sin θ dθ and ∫ t sin θ dθ.
    fn exact_integral(&self) -> [f64; LANES] {
        let lane_mean = |y: usize, lane: usize| {
            self.texels[y * self.width..][..self.width].iter().map(|t| f64::from(t[lane])).sum::<f64>()
                / self.width as f64
        };
        std::array::from_fn(|lane| {
            let strip = |j: usize| {
                let (a, b) = (self.edge(j), self.edge(j + 1));
                let [above, below] = self.rows(j).map(|y| lane_mean(y, lane));
                let all = a.cos() - b.cos();
                if above.to_bits() == below.to_bits() {
                    return above * all;
                }
                // ∫ (θ − a) sin θ dθ over the strip
                let moment = (b.sin() - a.sin()) - (b - a) * b.cos();
                let lower = moment / (b - a);
                above * (all - lower) + below * lower
            };
            TAU * (0..=self.height).map(strip).sum::<f64>()
        })
    }

    /// The bilinear lookup of `texels`, and with `by_height` of heights in place of angles.
    fn lookup(&self, w: DVec3, by_height: bool, texels: impl Fn(&Case, usize, usize) -> f64) -> f64 {
        let phi = (-w.z).atan2(w.x) - self.degrees.to_radians();
        let x = ((0.5 - phi / TAU) * self.width as f64 - 0.5).rem_euclid(self.width as f64);
        let theta = w.x.hypot(w.z).atan2(w.y);
        let strip = (0..=self.height).rfind(|&j| self.edge(j) <= theta).unwrap_or(0);
        let (a, b) = (self.edge(strip), self.edge(strip + 1));
        let t = if by_height { (a.cos() - theta.cos()) / (a.cos() - b.cos()) } else { (theta - a) / (b - a) };
        let column = x as usize % self.width;
        let [above, below] = self.rows(strip).map(|y| {
            let (left, right) = (texels(self, column, y), texels(self, column + 1, y));
            left + (right - left) * x.fract()
        });
        above + (below - above) * t
    }
}

/// A texel of 1e5 among dim ones; black texels beside bright ones; light across the seam; light at the poles; colours;
/// one texel, two texels, odd sizes; turned.
fn cases() -> Vec<Case> {
    let grey = |v: f32| [v; LANES];
    let noise = |x: usize, y: usize| ((x * 7 + y * 13 + x * y) % 11) as f32;
    vec![
        Case::new(
            "sun",
            [33, 17],
            0.0,
            |x, y| if (x, y) == (11, 5) { grey(1e5) } else { [0.5, 1.0, 1.5 + x as f32 * 0.1] },
        ),
        Case::new("sun, turned", [32, 16], 77.7, |x, y| if (x, y) == (20, 4) { grey(1e5) } else { grey(1.0) }),
        Case::new(
            "black beside bright",
            [16, 8],
            30.0,
            |x, y| if (x + y) % 3 == 0 { [4.0, 2.0, 1.0] } else { grey(0.0) },
        ),
        Case::new("one texel lit", [16, 8], -200.0, |x, y| if (x, y) == (7, 4) { grey(3.0) } else { grey(0.0) }),
        Case::new("across the seam", [12, 6], 0.0, |x, _| if x == 11 { grey(50.0) } else { grey(0.0) }),
        Case::new("zenith", [8, 8], 10.0, |x, y| if y == 0 { grey(x as f32) } else { grey(0.01) }),
        Case::new("nadir", [8, 8], 10.0, |x, y| if y == 7 { grey(x as f32) } else { grey(0.0) }),
        Case::new("colours", [15, 9], 123.0, |x, y| [noise(x, y), noise(y, x + 1), noise(x + 2, y)]),
        Case::new("1x1", [1, 1], 45.0, |_, _| [1.0, 2.0, 3.0]),
        Case::new("2x1", [2, 1], 45.0, |x, _| grey(x as f32)),
        Case::new("1x2", [1, 2], 45.0, |_, y| grey(y as f32)),
        Case::new("3x5", [3, 5], 400.0, |x, y| grey(noise(x, y) + 0.1)),
    ]
}

fn uniform(random: &mut Random) -> DVec3 {
    let (cos, phi) = (2.0 * random.f64() - 1.0, TAU * random.f64());
    let sin = (1.0 - cos * cos).sqrt();
    DVec3::new(sin * phi.cos(), cos, sin * phi.sin())
}

#[test]
fn directions_follow_the_density_and_it_integrates_to_one() {
    let mut results = Vec::new();
    for (seed, case) in cases().iter().enumerate() {
        let expected = case.integrate_quarters(|w| f64::from(case.light.along(w).1.value()));
        let total: f64 = expected.iter().sum();
        assert!((total - 1.0).abs() < case.rounding(), "{}: the density integrates to {total}", case.name);
        let (mut random, n) = (Random::new(700 + seed as u64), samples(200_000));
        let mut observed = vec![0.0; expected.len()];
        let mut dark = 0;
        for _ in 0..n {
            match case.light.sample(random.cube()) {
                Some(sample) => observed[case.quarter(sample.wi.as_dvec3())] += 1.0,
                None => dark += 1,
            }
        }
        // Rounding may lead across the edge of the light, where the density is nearly zero.
        assert!(f64::from(dark) < f64::from(n) * case.rounding(), "{}: {dark} samples without light", case.name);
        let expected: Vec<f64> = expected.iter().map(|p| p * f64::from(n)).collect();
        results.push((p_value(&observed, &expected), case.name));
    }
    let level = sidak(results.len());
    assert!(results.iter().all(|(p, _)| *p > level), "p-values below {level:e}: {results:?}");
}

/// The lookup is the bilinear one. The density is the bilinear one in height of the texels' shares over its integral. At
/// any direction and hard by the poles and the seam.
#[test]
fn lookup_and_density_are_those_of_the_texels() {
    for (seed, case) in cases().iter().enumerate() {
        let (integral, shares) = (case.by_height(Case::mean), case.by_height(Case::share));
        assert!((case.light.power(3.0) / (9.0 * PI) / integral - 1.0).abs() < 1e-12, "{}: power", case.name); // f64 sums
        let brightest = case.texels.iter().flatten().fold(0f32, |a, &b| a.max(b));
        let tolerance = case.rounding() * f64::from(brightest);
        let mut random = Random::new(800 + seed as u64);
        let near = |axis: DVec3, random: &mut Random| (axis + uniform(random) * 1e-3 * random.f64()).normalize();
        for i in 0..3000 {
            let w = match i % 6 {
                0 => near(DVec3::Y, &mut random),
                1 => near(DVec3::NEG_Y, &mut random),
                2 => near(case.direction(0.0, 0.2), &mut random), // the seam
                _ => uniform(&mut random),
            };
            let (radiance, pdf) = case.light.along(w.as_vec3());
            let (lookup, density) = (case.lookup(w, false, Case::mean), case.lookup(w, true, Case::share));
            assert!(
                (f64::from(radiance.mean()) - lookup).abs() < tolerance,
                "{} {w}: {radiance:?} {lookup}",
                case.name
            );
            let got = f64::from(pdf.value()) * shares;
            assert!((got - density).abs() < tolerance, "{} {w}: {got} {density}", case.name);
        }
    }
}

#[test]
fn the_density_is_positive_exactly_where_the_lookup_is() {
    for (seed, case) in cases().iter().enumerate() {
        let mut random = Random::new(900 + seed as u64);
        for _ in 0..100_000 {
            let w = uniform(&mut random).as_vec3();
            let (radiance, pdf) = case.light.along(w);
            assert_eq!(!radiance.is_black(), pdf.value() > 0.0, "{} {w}", case.name);
        }
        for axis in [Vec3::X, Vec3::NEG_X, Vec3::Y, Vec3::NEG_Y, Vec3::Z, Vec3::NEG_Z] {
            let (radiance, pdf) = case.light.along(axis);
            assert_eq!(!radiance.is_black(), pdf.value() > 0.0, "{} {axis}", case.name);
        }
    }
}

/// Sampled radiance over its density has the exact integral of the bilinear lookup for its mean, and without compensation
/// hardly scatters: within the strips beside the polar ones the angle's share is at most twice and at least two thirds of the height's;
/// 1.05 times that, since the integrals of the two differ, too.
#[test]
fn sampled_radiance_has_the_integral_of_the_map_for_its_mean() {
    let maps = cases();
    let limit = Normal::new(0.0, 1.0).expect("standard").inverse_cdf(1.0 - sidak(LANES * maps.len()) / 2.0);
    for (seed, case) in maps.iter().enumerate() {
        let exact = case.exact_integral();
        let per_share = case.by_height(Case::mean) / case.by_height(Case::share);
        let (mut random, n) = (Random::new(1000 + seed as u64), f64::from(samples(100_000)));
        let (mut sums, mut squares) = ([0.0; LANES], [0.0; LANES]);
        for _ in 0..n as u32 {
            let Some(sample) = case.light.sample(random.cube()) else { continue }; // counts as black
            let Density::Smooth(pdf) = sample.density else { panic!("a Dirac sample") };
            let values = sample.radiance.cast::<f64>() / f64::from(pdf.value());
            let w = sample.wi.as_dvec3();
            let compensation = case.lookup(w, true, Case::share) / case.lookup(w, true, Case::mean) * per_share;
            let ratio = values.mean() / Spectrum::<f64>(exact).mean() * compensation;
            assert!(case.height < 3 || (0.63..2.1).contains(&ratio), "{}: {ratio} at {}", case.name, sample.wi);
            (0..LANES).for_each(|lane| sums[lane] += values[lane]);
            (0..LANES).for_each(|lane| squares[lane] += values[lane] * values[lane]);
        }
        for lane in 0..LANES {
            let mean = sums[lane] / n;
            let error = ((squares[lane] / n - mean * mean).max(0.0) / n).sqrt();
            let slack = limit * error + case.rounding() * exact[lane];
            assert!(
                (mean - exact[lane]).abs() < slack,
                "{}: lane {lane}: {mean} ± {error}, not {}",
                case.name,
                exact[lane]
            );
        }
    }
}

/// A sampled direction carries the radiance and the density that a ray in it finds.
#[test]
fn environment_samples_match_lookup_and_density() {
    for case in cases() {
        let mut random = Random::new(31);
        let brightest = case.texels.iter().flatten().fold(0f32, |a, &b| a.max(b));
        let tolerance = case.rounding() as f32 * brightest;
        let shares = case.by_height(Case::share) as f32; // the density's integral
        for _ in 0..1000 {
            let Some(sample) = case.light.sample(random.cube()) else { continue };
            let (radiance, pdf) = case.light.along(sample.wi);
            let off = (sample.density.value() - pdf.value()).abs() * shares;
            assert!(off < tolerance, "{}: density off by {off}", case.name);
            let off = (sample.radiance - radiance).map(f32::abs).max_lane();
            assert!(off < tolerance, "{}: radiance off by {off}", case.name);
            assert!((sample.wi.length() - 1.0).abs() < 4.0 * f32::EPSILON, "{}", case.name);
        }
    }
}

/// Kernels over lanes return the bits of the functions for one direction.
#[test]
fn lanes_are_those_of_single_directions() {
    fn compare<F: Float>(case: &Case, random: &mut Random) {
        let u: [Vec<f32>; 2] = [(); 2].map(|()| (0..F::LANES).map(|_| random.f32()).collect());
        let sampled = case.light.sample_lanes([F::load(&u[0], 0), F::load(&u[1], 0)]);
        let (radiance, pdf) = case.light.along_lanes(sampled.wi);
        for (lane, (&u, &v)) in u[0].iter().zip(&u[1]).enumerate() {
            let valid = sampled.valid.bits() >> lane & 1 == 1;
            let single = case.light.sample([u, v]);
            assert_eq!(single.is_some(), valid, "{}", case.name);
            let Some(single) = single else { continue };
            let wi = Vec3::from(sampled.wi.lane(lane));
            let (sampled, density) = (sampled.radiance.lane(lane), sampled.pdf.lane(lane));
            assert_eq!((wi, sampled, density), (single.wi, single.radiance, single.density.value()), "{}", case.name);
            let along = case.light.along(wi);
            assert_eq!((radiance.lane(lane), pdf.lane(lane)), (along.0, along.1.value()), "{}", case.name);
        }
    }
    for case in cases() {
        let mut random = Random::new(33);
        for _ in 0..1000 {
            compare::<Native>(&case, &mut random);
            compare::<Array<3>>(&case, &mut random);
        }
    }
}

/// A map of directions: red, green, blue of a texel are x, y, z of the direction that it shows in a Z-up world, as the
/// peers have it; étendue's is (x, z, −y).
#[test]
fn maps_are_oriented_as_those_of_other_renderers() {
    let [width, height] = [64, 32];
    let shown = |x: usize, y: usize| {
        let (phi, theta) = (TAU * (0.5 - (x as f64 + 0.5) / width as f64), PI * (y as f64 + 0.5) / height as f64);
        DVec3::new(theta.sin() * phi.cos(), theta.sin() * phi.sin(), theta.cos())
    };
    let color = |x, y| (shown(x, y).as_vec3() + 1.0).to_array();
    let case = Case::new("directions", [width, height], 0.0, color);
    let turned = Case::new("directions, turned", [width, height], 90.0, color);
    let tolerance = 2.0 * case.rounding() as f32; // colours up to 2
    for (x, y) in (0..width * height).map(|i| (i % width, i / width)) {
        let d = shown(x, y);
        let w = Vec3::new(d.x as f32, d.z as f32, -d.y as f32);
        let found = |light: &EnvironmentMap, w| Vec3::from(light.along(w).0.0) - 1.0;
        assert!(found(&case.light, w).distance(d.as_vec3()) < tolerance, "{x} {y}");
        // Counter-clockwise seen from above, x goes to −z and z to x.
        let w = Vec3::new(w.z, w.y, -w.x);
        assert!(found(&turned.light, w).distance(d.as_vec3()) < tolerance, "turned: {x} {y}");
    }
}

#[test]
fn whole_turns_change_nothing() {
    let texel = |x, y| [x as f32, y as f32, 1.0];
    let maps = [0.0, 360.0, -720.0].map(|degrees| Case::new("turned", [16, 8], degrees, texel));
    let mut random = Random::new(5);
    for _ in 0..1000 {
        let w = uniform(&mut random).as_vec3();
        let [a, b, c] = [0, 1, 2].map(|i| maps[i].light.along(w));
        assert_eq!((a.0, a.1.value()), (b.0, b.1.value()));
        assert_eq!((a.0, a.1.value()), (c.0, c.1.value()));
    }
}

#[test]
fn a_constant_map_is_the_uniform_sky_and_a_black_one_no_light() {
    let case = Case::new("constant", [16, 8], 20.0, |_, _| [0.5; LANES]);
    let mut random = Random::new(6);
    for _ in 0..1000 {
        let (radiance, pdf) = case.light.along(uniform(&mut random).as_vec3());
        // Weights that sum to 1 within a rounding, twice; the integral within f32.
        assert!((radiance.mean() / 0.5 - 1.0).abs() < 8.0 * f32::EPSILON);
        assert!((f64::from(pdf.value()) * 4.0 * PI - 1.0).abs() < 8.0 * f64::from(f32::EPSILON));
    }
    let map = |v: f32| Arc::new(RadianceMap::new(4, 2, vec![[v; LANES]; 8]));
    assert!(EnvironmentMap::new(map(0.0), 1.0, 0.0).is_none());
    assert!(EnvironmentMap::new(map(1.0), 0.0, 0.0).is_none());
    assert!(
        (EnvironmentMap::new(map(1.0), 3.0, 0.0).expect("light").power(1.0) / (12.0 * PI * PI) - 1.0).abs() < 1e-12
    ); // f64 sums
}

/// The brightest texels there may be, and the dimmest: nothing leaves f32.
#[test]
fn extreme_radiances_stay_finite() {
    for (bright, dim) in [(RadianceMap::BRIGHTEST, 1.0), (RadianceMap::BRIGHTEST, 1e-30), (1e-25, 0.0)] {
        let case = Case::new("extreme", [8, 4], 0.0, |x, _| if x == 3 { [bright; LANES] } else { [dim; LANES] });
        let mut random = Random::new(8);
        for _ in 0..10_000 {
            let Some(sample) = case.light.sample(random.cube()) else { continue };
            assert!(sample.radiance.is_finite() && sample.density.value().is_finite() && sample.wi.is_finite());
            let (radiance, pdf) = case.light.along(uniform(&mut random).as_vec3());
            assert!(radiance.is_finite() && pdf.value().is_finite());
        }
        for u in [[0.0, 0.0], [0.999_999_94, 0.999_999_94], [0.0, 0.999_999_94]] {
            assert!(case.light.sample(u).is_none_or(|sample| sample.wi.is_finite() && sample.density.value() > 0.0));
        }
    }
}
