//! The integrals of the tutorial, their exact values, and estimators made of the renderer's own pieces.

use etendue::sampling::{Address, Heuristic, IndependentSampler, Sampler, Slot, Sobol, power};
use etendue::stats::{Estimate, Moments};
use statrs::distribution::{Continuous, ContinuousCDF, Normal};

/// One unbiased estimate from one set of random numbers.
type Draw = Box<dyn Fn(&mut dyn Sampler) -> f64>;

/// An integral and one way to estimate it.
pub struct Example {
    /// What is estimated.
    pub integral: String,
    /// By which estimator.
    pub estimator: &'static str,
    /// The integral.
    pub exact: f64,
    /// How many samples a draw takes: two for a combination of two densities.
    pub samples: u32,
    draw: Draw,
}

impl Example {
    /// Mean and standard error of `n` draws with independent random numbers.
    pub fn independent(&self, seed: u64, n: u32) -> Estimate {
        let address = Address::new(seed);
        let draw = |i: u32| (self.draw)(&mut IndependentSampler::new(address.with(u64::from(i))));
        (0..n).map(draw).collect::<Moments>().estimate().expect("at least two draws")
    }

    /// Mean of `replicates` Owen-scrambled Sobol' sequences of `n` / `replicates` draws each. Points of one sequence
    /// are not independent: the standard error comes from the scatter between the scramblings.
    pub fn sobol(&self, seed: u64, n: u32, replicates: u32) -> Estimate {
        let length = n / replicates;
        let sequence = |r: u32| {
            let address = Address::new(seed).with(u64::from(r));
            (0..length).map(|i| (self.draw)(&mut Sobol::new(address, i))).collect::<Moments>().mean()
        };
        (0..replicates).map(sequence).collect::<Moments>().estimate().expect("at least two replicates")
    }
}

/// π: four times the share of a square's points that fall in its circle.
pub fn pi() -> Example {
    let inside = |u: [f32; 2]| u.iter().map(|&u| (2.0 * f64::from(u) - 1.0).powi(2)).sum::<f64>() < 1.0;
    let draw = move |sampler: &mut dyn Sampler| if inside(sampler.u2(0, Slot::Direction)) { 4.0 } else { 0.0 };
    let integral = "pi by the circle".into();
    Example { integral, estimator: "uniform", exact: std::f64::consts::PI, samples: 1, draw: Box::new(draw) }
}

/// ∫₀¹ 5x⁴ dx with uniform x.
pub fn power_of_four() -> Example {
    let draw = |sampler: &mut dyn Sampler| 5.0 * f64::from(sampler.u1(0, Slot::Direction)).powi(4);
    Example { integral: "5x^4 on [0, 1]".into(), estimator: "uniform", exact: 1.0, samples: 1, draw: Box::new(draw) }
}

/// The integral of the product of a Gaussian density f of deviation `sigma` and a uniform density g on [a, b). (The
/// tutorial's slide has √(2πσ) where a density needs √(2π) σ.)
#[derive(Clone, Copy)]
pub struct Product {
    gaussian: Normal,
    sigma: f64,
    interval: [f64; 2],
}

/// Which of the two densities a sample comes from.
#[derive(Clone, Copy)]
enum By {
    Gaussian,
    Uniform,
}

impl Product {
    /// The product for these parameters.
    pub fn new(sigma: f64, interval: [f64; 2]) -> Self {
        Product { gaussian: Normal::new(0.0, sigma).expect("a positive deviation"), sigma, interval }
    }

    /// (Φ(b/σ) − Φ(a/σ)) / (b − a).
    fn exact(&self) -> f64 {
        let [a, b] = self.interval;
        (self.gaussian.cdf(b) - self.gaussian.cdf(a)) / (b - a)
    }

    /// f(x) and g(x).
    fn densities(&self, x: f64) -> [f64; 2] {
        let [a, b] = self.interval;
        [self.gaussian.pdf(x), if (a..b).contains(&x) { (b - a).recip() } else { 0.0 }]
    }

    fn sample(&self, by: By, sampler: &mut dyn Sampler) -> f64 {
        /// Half the distance of two numbers: 0 and 1 are never taken, where the inverse is infinite.
        const HALF_STEP: f64 = 1.0 / (1u32 << 25) as f64;
        match by {
            By::Gaussian => self.gaussian.inverse_cdf(f64::from(sampler.u1(0, Slot::Lobe)) + HALF_STEP),
            By::Uniform => {
                let [a, b] = self.interval;
                a + (b - a) * f64::from(sampler.u1(0, Slot::LightPick))
            }
        }
    }

    /// f g over the density of the sample, times the share that `weight` gives it of that density against the other
    /// one.
    fn contribution(&self, by: By, sampler: &mut dyn Sampler, weight: impl Fn(f32, f32) -> f32) -> f64 {
        let [f, g] = self.densities(self.sample(by, sampler));
        let [p, other] = if let By::Gaussian = by { [f, g] } else { [g, f] };
        if p > 0.0 { f * g / p * f64::from(weight(p as f32, other as f32)) } else { 0.0 }
    }

    /// One density alone, the other alone, both by the balance and by the power heuristic [Veach97 §9.2].
    pub fn estimators(self) -> [Example; 4] {
        let [a, b] = self.interval;
        let integral = format!("Gaussian of deviation {} times uniform on [{a:.1}, {b:.1})", self.sigma);
        let example = |estimator, samples, draw| Example {
            integral: integral.clone(),
            estimator,
            exact: self.exact(),
            samples,
            draw,
        };
        let single = move |by| -> Draw { Box::new(move |sampler| self.contribution(by, sampler, |_, _| 1.0)) };
        let both = move |heuristic: Heuristic| -> Draw {
            let weight = move |p, other: f32| match heuristic {
                Heuristic::Balance => 1.0 / (1.0 + other / p),
                Heuristic::Power => power(p, other),
            };
            Box::new(move |s| self.contribution(By::Gaussian, s, weight) + self.contribution(By::Uniform, s, weight))
        };
        [
            example("Gaussian alone", 1, single(By::Gaussian)),
            example("uniform alone", 1, single(By::Uniform)),
            example("balance heuristic", 2, both(Heuristic::Balance)),
            example("power heuristic", 2, both(Heuristic::Power)),
        ]
    }
}

/// Where the uniform density is the good one, and where the Gaussian is.
pub fn products() -> [Product; 2] {
    [Product::new(1.0, [1.9, 2.0]), Product::new(0.05, [-3.0, 3.0])]
}
