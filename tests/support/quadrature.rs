//! Adaptive quadrature over rectangles.

/// A rectangle.
#[derive(Clone, Copy)]
pub(crate) struct Rectangle {
    pub(crate) x: [f64; 2],
    pub(crate) y: [f64; 2],
}

/// How often a rectangle is quartered at most.
const DEPTH: u32 = 8;
/// How often it is quartered at least: a corner of an integrand that is zero elsewhere must not be missed.
const LEAST: u32 = 2;

impl Rectangle {
    /// ∫ f, quartering until both resolutions agree within `tolerance`, or the depth is used up, as it is along jumps.
    pub(crate) fn integrate(self, tolerance: f64, f: &impl Fn(f64, f64) -> f64) -> f64 {
        self.refine(self.gauss(f), tolerance, DEPTH, f)
    }

    fn refine(self, coarse: f64, tolerance: f64, depth: u32, f: &impl Fn(f64, f64) -> f64) -> f64 {
        let quarters = self.quarters();
        let fine = quarters.map(|q| q.gauss(f));
        let sum: f64 = fine.iter().sum();
        if depth == 0 || depth <= DEPTH - LEAST && (sum - coarse).abs() <= tolerance {
            return sum;
        }
        quarters.into_iter().zip(fine).map(|(q, part)| q.refine(part, 0.5 * tolerance, depth - 1, f)).sum()
    }

    /// The product of three-point Gauss-Legendre rules.
    fn gauss(self, f: &impl Fn(f64, f64) -> f64) -> f64 {
        let root = 0.6f64.sqrt();
        let points = [(-root, 5.0), (0.0, 8.0), (root, 5.0)].map(|(t, w)| (0.5 + 0.5 * t, w / 18.0));
        let (dx, dy) = (self.x[1] - self.x[0], self.y[1] - self.y[0]);
        let row =
            |(u, wu): (f64, f64)| points.map(|(v, wv)| wu * wv * f(self.x[0] + u * dx, self.y[0] + v * dy)).iter().sum::<f64>();
        points.map(row).iter().sum::<f64>() * dx * dy
    }

    fn quarters(self) -> [Rectangle; 4] {
        let (x, y) = (0.5 * (self.x[0] + self.x[1]), 0.5 * (self.y[0] + self.y[1]));
        let (left, right) = ([self.x[0], x], [x, self.x[1]]);
        let (low, high) = ([self.y[0], y], [y, self.y[1]]);
        [(left, low), (right, low), (left, high), (right, high)].map(|(x, y)| Rectangle { x, y })
    }
}

#[test]
fn smooth_and_cut_integrands_are_integrated_within_tolerance() {
    let unit = Rectangle { x: [0.0, 1.0], y: [0.0, 1.0] };
    let smooth = unit.integrate(1e-10, &|x, y| (x + 2.0 * y).exp());
    assert!((smooth - (1f64.exp() - 1.0) * (2f64.exp() - 1.0) / 2.0).abs() < 1e-9);
    let quarter_disk = unit.integrate(1e-7, &|x, y| if x * x + y * y < 1.0 { 1.0 } else { 0.0 });
    assert!((quarter_disk - std::f64::consts::FRAC_PI_4).abs() < 1e-3);
}
