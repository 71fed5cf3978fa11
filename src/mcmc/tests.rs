//! Chains on targets with known moments.

use super::primary::{PrimaryPoint, PrimaryStream, Source, Step};
use super::*;
use crate::sampling::{Address, IndependentSampler, Sampler, Slot};
use crate::stats::Moments;

/// Number of independent chains in each test, and steps of each.
const CHAINS: u64 = 400;
const STEPS: u64 = 2000;
/// Two-sided normal level 6e-7 for each statistic: means of independent chains.
const BOUND: f64 = 5.0;

/// A real number with an unnormalised density.
#[derive(Default)]
struct Number {
    x: f64,
    log_target: f64,
}

impl State for Number {
    fn log_target(&self) -> f64 {
        self.log_target
    }
}

/// Moves by up to `reach` times 1 + |x|: not symmetric.
struct Uneven<F> {
    target: F,
    reach: f64,
}

impl<F: Fn(f64) -> f64> Kernel<Number> for Uneven<F> {
    fn suitability(&self, x: &Number) -> f64 {
        // Selected more often far from the origin.
        1.0 + x.x.abs().min(3.0)
    }

    fn propose(&self, x: &Number, y: &mut Number, numbers: &mut Numbers) -> Option<f64> {
        let width = |x: f64| self.reach * (1.0 + x.abs());
        y.x = x.x + width(x.x) * (2.0 * numbers.uniform() - 1.0);
        y.log_target = (self.target)(y.x);
        ((y.x - x.x).abs() <= width(y.x)).then(|| (width(x.x) / width(y.x)).ln())
    }
}

/// Independence kernel: proposes from a fixed distribution.
struct Anywhere<F> {
    target: F,
    width: f64,
}

impl<F: Fn(f64) -> f64> Kernel<Number> for Anywhere<F> {
    fn suitability(&self, _: &Number) -> f64 {
        0.5
    }

    fn propose(&self, _: &Number, y: &mut Number, numbers: &mut Numbers) -> Option<f64> {
        y.x = self.width * (2.0 * numbers.uniform() - 1.0);
        y.log_target = (self.target)(y.x);
        Some(0.0)
    }
}

/// Returns z of the mean of `statistic` over the steps of all chains against `want`, with expected-value deposits.
fn z_of<F: Fn(f64) -> f64 + Copy + Sync>(target: F, statistic: fn(f64) -> f64, want: f64) -> f64 {
    let mixture =
        Mixture::new(vec![Box::new(Uneven { target, reach: 1.0 }), Box::new(Anywhere { target, width: 12.0 })]);
    let mean_of = |id: u64| {
        let address = Address::new(5).with(id);
        let mut chain = Chain::new(Number { x: 0.3, log_target: target(0.3) }, Number::default());
        let (mut sum, mut weights) = (0.0, 0.0);
        for step in 0..STEPS {
            let warm = step >= STEPS / 4;
            chain.step(&mixture, &mut Numbers::new(address.with(step)), |state, weight| {
                if warm {
                    sum += weight * statistic(state.x);
                    weights += weight;
                }
            });
        }
        sum / weights
    };
    let moments: Moments = (0..CHAINS).map(mean_of).collect();
    let estimate = moments.estimate().expect("many chains");
    (estimate.value - want) / estimate.standard_error
}

type Statistic = (fn(f64) -> f64, f64);

fn assert_moments<F: Fn(f64) -> f64 + Copy + Sync>(target: F, wanted: &[Statistic]) {
    for (i, &(statistic, want)) in wanted.iter().enumerate() {
        let z = z_of(target, statistic, want);
        assert!(z.abs() < BOUND, "statistic {i}: z = {z:.2}");
    }
}

#[test]
fn a_normal_distribution_has_its_moments() {
    let target = |x: f64| -0.5 * (x - 1.0).powi(2);
    let beyond = statrs::function::erf::erfc(1.0 / std::f64::consts::SQRT_2) / 2.0;
    assert_moments(target, &[(|x| x, 1.0), (|x| (x - 1.0).powi(2), 1.0), (|x| f64::from(u8::from(x > 2.0)), beyond)]);
}

#[test]
fn a_mixture_keeps_the_shares_of_its_parts() {
    let normal = |x: f64, m: f64, s: f64| (-0.5 * ((x - m) / s).powi(2)).exp() / s;
    let target = move |x: f64| (0.3 * normal(x, -3.0, 0.5) + 0.7 * normal(x, 4.0, 1.0)).ln();
    assert_moments(target, &[(|x| f64::from(u8::from(x < 0.5)), 0.3), (|x| x, 1.9)]);
}

#[test]
fn states_of_zero_target_are_not_visited() {
    let target = |x: f64| if (0.0..1.0).contains(&x) { 0.0 } else { f64::NEG_INFINITY };
    assert_moments(
        target,
        &[(|x| x, 0.5), (|x| x * x, 1.0 / 3.0), (|x| f64::from(u8::from(!(0.0..1.0).contains(&x))) + x, 0.5)],
    );
}

/// Every address has a coordinate, equal to the one of independent sampling. Those of connection roulette lie beyond
/// all bounces, and 16 slots per bounce must not wrap around at 2³².
#[test]
fn coordinates_of_the_highest_bounces_are_distinct() {
    let (mut point, address) = (PrimaryPoint::default(), Address::new(3));
    point.clear();
    let bounces = [0, 1, 4_095, 4_096, 16_384, 1 << 28, 1 << 30, (1 << 30) + (3 << 16) + 2, u32::MAX];
    let mut expected = IndependentSampler::new(address.with(PrimaryStream::Camera as u64));
    let [mut camera, ..] = point.draw(address);
    for bounce in bounces {
        let (found, wanted) = (camera.u2(bounce, Slot::Direction), expected.u2(bounce, Slot::Direction));
        assert_eq!(found.map(f32::to_bits), wanted.map(f32::to_bits), "bounce {bounce}");
        assert_eq!(camera.u1(bounce, Slot::Roulette).to_bits(), expected.u1(bounce, Slot::Roulette).to_bits());
    }
    assert_eq!(point.dimension(), 3 * bounces.len());
    point.clear();
    assert_eq!(point.dimension(), 0);
}

/// Primary sample whose evaluation uses more random numbers in half of the space.
#[derive(Default)]
struct Branching {
    point: PrimaryPoint,
    log_target: f64,
    values: [f64; 2],
}

impl State for Branching {
    fn log_target(&self) -> f64 {
        self.log_target
    }
}

struct Branches(Step);

/// f = a where a < 1/2, and b a otherwise; both are 0 without the second random number.
fn evaluate([mut first, mut second, _]: [Source; 3]) -> [f64; 2] {
    let a = f64::from(first.u1(0, Slot::Lobe));
    let b = if a < 0.5 { 0.0 } else { f64::from(second.u2(3, Slot::Direction)[1]) };
    [a, b]
}

impl Branching {
    fn set(&mut self, values: [f64; 2]) {
        let [a, b] = values;
        self.values = values;
        self.log_target = (if a < 0.5 { a } else { a * b }).ln();
    }
}

impl Kernel<Branching> for Branches {
    fn suitability(&self, _: &Branching) -> f64 {
        if self.0 == Step::Large { 0.1 } else { 0.9 }
    }

    fn propose(&self, x: &Branching, y: &mut Branching, numbers: &mut Numbers) -> Option<f64> {
        let values = evaluate(y.point.propose(&x.point, self.0, numbers.address()));
        y.set(values);
        Some(0.0)
    }
}

/// ∫f: 1/8 for a < 1/2, 3/16 above; there E a = 7/9 and E b = 2/3.
#[test]
fn lazily_created_coordinates_preserve_the_target() {
    for small in [SmallStep::KELEMEN, SmallStep::Gaussian { sigma: 0.05 }] {
        let mixture = Mixture::new(vec![
            Box::new(Branches(Step::Large)) as Box<dyn Kernel<Branching> + Sync>,
            Box::new(Branches(Step::Small(small))),
        ]);
        let mut moments = [(); 3].map(|()| Moments::default());
        for id in 0..CHAINS {
            let address = Address::new(11).with(id);
            let mut x = Branching::default();
            x.point.clear();
            x.point.set(PrimaryStream::Camera, 0, Slot::Lobe, 1 << 30);
            let values = evaluate(x.point.draw(address));
            x.set(values);
            assert_eq!(x.values, [0.25, 0.0]);
            let (mut chain, mut sums) = (Chain::new(x, Branching::default()), [0.0; 3]);
            for step in 0..STEPS {
                chain.step(&mixture, &mut Numbers::new(address.with(step)), |state, weight| {
                    let ([a, b], warm) = (state.values, step >= STEPS / 4);
                    let above = f64::from(u8::from(a >= 0.5 && warm));
                    [above, above * a, above * b].iter().zip(&mut sums).for_each(|(value, sum)| *sum += weight * value);
                });
            }
            let kept = (STEPS - STEPS / 4) as f64;
            moments.iter_mut().zip(sums).for_each(|(moments, sum)| moments.push(sum / kept));
        }
        for (moments, want) in moments.iter().zip([0.6, 0.6 * 7.0 / 9.0, 0.6 * 2.0 / 3.0]) {
            let estimate = moments.estimate().expect("many chains");
            // The weight pending at the end of burn-in is counted slightly early: less than one step in a thousand.
            let slack = 1e-3;
            let off = (estimate.value - want).abs();
            assert!(off < BOUND * estimate.standard_error + slack, "{small:?}: {} for {want}", estimate.value);
        }
    }
}

#[test]
fn systematic_resampling_is_unbiased() {
    let weights = [0.0, 1.0, 0.5, 2.5, 0.0, 1.0];
    let (n, count) = (4000, 3);
    let mut chosen = [0.0; 6];
    for i in 0..n {
        let offset = (f64::from(i) + 0.5) / f64::from(n);
        for index in stratified(&weights, count, offset).expect("some weight") {
            chosen[index] += 1.0 / f64::from(n);
        }
    }
    for (found, weight) in chosen.iter().zip(weights) {
        // Each boundary of an interval is crossed at one offset, known to 1/n.
        assert!((found - weight * count as f64 / 5.0).abs() <= 2.0 / f64::from(n), "{chosen:?}");
    }
    assert!(stratified(&[0.0, 0.0], 2, 0.5).is_none());
}

#[test]
fn small_steps_have_the_stated_distribution() {
    let lengths = |small: SmallStep| -> Vec<f64> {
        (0..100_000)
            .map(|i| f64::from(small.apply(7, Address::new(3).bits(i)).wrapping_sub(7) as i32) / 2f64.powi(32))
            .collect()
    };
    let kelemen = lengths(SmallStep::KELEMEN);
    assert!(kelemen.iter().all(|x| (1.0 / 1024.0 - 1e-9..=1.0 / 64.0 + 1e-9).contains(&x.abs())));
    let z = |values: Vec<f64>, want: f64| {
        let estimate = values.into_iter().collect::<Moments>().estimate().expect("many");
        (estimate.value - want) / estimate.standard_error
    };
    assert!(z(kelemen.clone(), 0.0).abs() < BOUND);
    // The mean logarithm of a log-uniform length is the mean of those of its ends.
    assert!(z(kelemen.iter().map(|x| x.abs().log2()).collect(), -8.0).abs() < BOUND);
    let gaussian = lengths(SmallStep::Gaussian { sigma: 0.01 });
    assert!(z(gaussian.clone(), 0.0).abs() < BOUND);
    assert!(z(gaussian.iter().map(|x| x * x).collect(), 1e-4).abs() < BOUND);
    assert!(z(gaussian.iter().map(|x| x.powi(4)).collect(), 3e-8).abs() < BOUND);
}
