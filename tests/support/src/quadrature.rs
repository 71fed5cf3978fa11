//! Adaptive quadrature over rectangles.

/// A rectangle.
#[derive(Clone, Copy)]
pub struct Rectangle {
    /// From and to.
    pub x: [f64; 2],
    /// From and to.
    pub y: [f64; 2],
}

/// How often a rectangle is quartered at most: along a jump, rows of 2⁻¹⁰ of it are right to a third or so.
const DEPTH: u32 = 10;
/// How often it is quartered at least.
const LEAST: u32 = 2;

/// Where corners are looked at: on them an integrand may be zero for itself, as a direction along the horizon is.
const CORNERS: [f64; 2] = [1e-6, 1.0 - 1e-6];

/// What one rule says of a rectangle.
#[derive(Clone, Copy)]
struct Estimate {
    integral: f64,
    /// What it may be off by because an edge of the integrand's support goes through: the whole, if the integrand is
    /// zero in some points, corners included, and not in others. Where a lobe ends at the horizon all points of the
    /// rule may be beyond it although a strip along an edge is not, and both resolutions agree on nothing.
    cut: f64,
}

impl Rectangle {
    /// ∫ f, quartering until both resolutions agree within `tolerance`, or the depth is used up, as it may be along
    /// jumps. Quarters have half the tolerance: as many as are met by a curve have all of it together.
    pub fn integrate(self, tolerance: f64, f: &impl Fn(f64, f64) -> f64) -> f64 {
        self.refine(self.gauss(f), tolerance, DEPTH, f)
    }

    fn refine(self, coarse: Estimate, tolerance: f64, depth: u32, f: &impl Fn(f64, f64) -> f64) -> f64 {
        let quarters = self.quarters();
        let fine = quarters.map(|q| q.gauss(f));
        let sum: f64 = fine.iter().map(|e| e.integral).sum();
        let agrees = (sum - coarse.integral).abs() + coarse.cut <= tolerance;
        if depth == 0 || depth <= DEPTH - LEAST && agrees {
            return sum;
        }
        quarters.into_iter().zip(fine).map(|(q, part)| q.refine(part, 0.5 * tolerance, depth - 1, f)).sum()
    }

    /// The product of three-point Gauss-Legendre rules.
    fn gauss(self, f: &impl Fn(f64, f64) -> f64) -> Estimate {
        let root = 0.6f64.sqrt();
        let points = [(-root, 5.0), (0.0, 8.0), (root, 5.0)].map(|(t, w)| (0.5 + 0.5 * t, w / 18.0));
        let (dx, dy) = (self.x[1] - self.x[0], self.y[1] - self.y[0]);
        let values = points.map(|(u, wu)| points.map(|(v, wv)| (wu * wv, f(self.x[0] + u * dx, self.y[0] + v * dy))));
        let corners = CORNERS.map(|u| CORNERS.map(|v| f(self.x[0] + u * dx, self.y[0] + v * dy)));
        let inside = values.as_flattened().iter().map(|(_, value)| *value);
        let all = inside.chain(corners.as_flattened().iter().copied());
        let (least, most) =
            all.fold((f64::INFINITY, 0.0f64), |(least, most), value| (least.min(value), most.max(value)));
        let integral = values.as_flattened().iter().map(|(weight, value)| weight * value).sum::<f64>() * dx * dy;
        Estimate { integral, cut: if least == 0.0 { most * dx * dy } else { 0.0 } }
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

#[test]
fn a_strip_between_an_edge_and_the_first_points_is_seen() {
    let unit = Rectangle { x: [0.0, 1.0], y: [0.0, 1.0] };
    let strip = unit.integrate(1e-7, &|x, _| if x < 0.01 { 1.0 } else { 0.0 });
    // a third of the last rows
    assert!((strip - 0.01).abs() < 0.5 / 1024.0, "{strip}");
}
