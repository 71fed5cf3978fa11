//! Warps over lanes. Those of [`super::warp`] for glam's types are these at one lane.

use crate::numeric::BELOW_ONE;
use etendue_lanes::{Float, Int, Vec3};
use std::f32::consts::{FRAC_1_SQRT_2, FRAC_PI_4};

/// Maps `u` to the unit disk by the concentric map: signed radius and unit direction [Shirley97].
#[inline(always)]
pub fn concentric_polar<F: Float>(u: [F; 2]) -> (F, [F; 2]) {
    let centred = |x: F| F::splat(2.0) * x - F::splat(1.0);
    let (a, b) = (centred(u[0]), centred(u[1]));
    let wide = a.abs().above(b.abs());
    let (radius, other) = (F::select(wide, a, b), F::select(wide, b, a));
    let ratio = F::select(radius.abs().above(F::splat(0.0)), other / radius, F::splat(0.0));
    let (sin, cos) = sin_cos_eighth(ratio);
    (radius, [F::select(wide, cos, sin), F::select(wide, sin, cos)])
}

/// Samples a direction around +z with density proportional to its cosine.
#[inline(always)]
pub fn cosine_hemisphere<F: Float>(u: [F; 2]) -> Vec3<F> {
    let (radius, [x, y]) = concentric_polar(u);
    let one = F::splat(1.0);
    let z = ((one - radius) * (one + radius)).max(F::splat(0.0)).sqrt();
    Vec3::new(x * radius, y * radius, z)
}

/// Samples the sphere uniformly: the cosine to z from `u[0]`, the azimuth from `u[1]`.
#[inline(always)]
pub fn uniform_sphere<F: Float>(u: [F; 2]) -> Vec3<F> {
    cap(F::splat(2.0) * u[0], u[1])
}

/// Returns the direction at azimuth `turn` (in turns, 0 to 1) around +z with cosine 1 − `height`; the sine is computed
/// without cancellation.
#[inline(always)]
pub fn cap<F: Float>(height: F, turn: F) -> Vec3<F> {
    let sine = (height * (F::splat(2.0) - height)).max(F::splat(0.0)).sqrt();
    let [cos, sin] = circle(turn);
    Vec3::new(cos * sine, sin * sine, F::splat(1.0) - height)
}

/// Samples a triangle uniformly; returns the barycentric weights of its second and third vertex [Heitz19].
#[inline(always)]
pub fn uniform_triangle<F: Float>([u, v]: [F; 2]) -> [F; 2] {
    let below = u.below(v);
    let half = F::splat(0.5) * F::select(below, u, v);
    [F::select(below, half, u - half), F::select(below, v - half, half)]
}

/// See [`super::warp::linear`].
#[inline(always)]
pub fn linear<F: Float>(u: F, [a, b]: [F; 2]) -> F {
    let (zero, sum) = (F::splat(0.0), a + b);
    let (a, b) = (a / sum, b / sum);
    // The root of the quadratic that does not cancel; 0 / 0 where the density and u are both 0 at the beginning.
    let denominator = a + (a * a + u * (b * b - a * a)).max(zero).sqrt();
    F::select(denominator.above(zero), into_unit(u / denominator), zero)
}

/// Clamps `u` to [0, 1) after rounding.
#[inline(always)]
pub fn into_unit<F: Float>(u: F) -> F {
    u.max(F::splat(0.0)).min(F::splat(BELOW_ONE))
}

/// Returns the angle of (x, y) in turns, in [−½, ½], within 1.5 ulp; 0 for the zero vector. The arc tangent of up to
/// an eighth of a turn is a polynomial, interpolated at Chebyshev points with a relative error of 2e-8.
#[inline(always)]
pub fn signed_turn<F: Float>(y: F, x: F) -> F {
    const ATAN: [f32; 9] = [
        4.402_677e-4,
        -2.503_706_1e-3,
        6.706_411e-3,
        -1.186_795_3e-2,
        1.689_966_2e-2,
        -2.259_649_7e-2,
        3.181_805e-2,
        -5.305_117_7e-2,
        0.159_154_94,
    ];
    let (zero, width, height) = (F::splat(0.0), x.abs(), y.abs());
    let is_steep = height.above(width);
    let (long, short) = (F::select(is_steep, height, width), F::select(is_steep, width, height));
    let ratio = F::select(long.above(zero), short / long, zero);
    let z = ratio * ratio;
    let eighth = ratio * ATAN.iter().fold(zero, |sum, &c| sum * z + F::splat(c));
    let quarter = F::select(is_steep, F::splat(0.25) - eighth, eighth);
    F::select(x.below(zero), F::splat(0.5) - quarter, quarter).copysign(y)
}

/// Returns the point of the unit circle at the angle of `turn` turns, 0 to 1, within 3e-7.
#[inline(always)]
pub fn circle<F: Float>(turn: F) -> [F; 2] {
    let quarters = turn * F::splat(4.0);
    let quadrant = quarters.to_int();
    // From the middle of the quadrant, in eighths of a turn.
    let eighths = (quarters - F::from_int(quadrant)) * F::splat(2.0) - F::splat(1.0);
    let (sin, cos) = sin_cos_eighth(eighths);
    let diagonal = F::splat(FRAC_1_SQRT_2);
    let (x, y) = ((cos - sin) * diagonal, (cos + sin) * diagonal);
    let set = |bit: u32| (quadrant & F::Int::splat(bit)).equals(F::Int::splat(bit));
    let (odd, far) = (set(1), set(2));
    let (x, y) = (F::select(odd, -y, x), F::select(odd, x, y));
    [F::select(far, -x, x), F::select(far, -y, y)]
}

/// Returns the point of the unit circle at the angle of `turn` turns, 0 to ½, within 1e-6. The sine of a small angle has
/// a small relative error, unlike that of [`circle`].
#[inline(always)]
pub fn half_turn<F: Float>(turn: F) -> [F; 2] {
    let twice = |(sin, cos): (F, F)| (F::splat(2.0) * sin * cos, (cos - sin) * (cos + sin));
    let (sin, cos) = twice(twice(sin_cos_eighth(turn * F::splat(2.0))));
    [cos, sin]
}

/// Sine and cosine of π/4 `t` for `t` in [−1, 1], by polynomial interpolation at Chebyshev points, with an error of
/// 3e-9. The library functions are calls, which spill all registers and cost a path tracer 2 % of its time.
#[inline(always)]
pub(super) fn sin_cos_eighth<F: Float>(t: F) -> (F, F) {
    const SIN: [f32; 4] = [-3.595_429e-5, 2.490_006_8e-3, -8.074_543_5e-2, FRAC_PI_4];
    const COS: [f32; 5] = [3.529_797e-6, -3.259_386e-4, 1.585_432_5e-2, -0.308_425_14, 1.0];
    let z = t * t;
    let horner = |coefficients: &[f32]| coefficients.iter().fold(F::splat(0.0), |sum, &c| sum * z + F::splat(c));
    (t * horner(&SIN), horner(&COS))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Four roundings of sums near 1, the last coefficients' own, and the 3e-9 of the interpolation.
    #[test]
    fn sine_and_cosine_of_an_eighth_are_as_close_as_f32_can_say() {
        const BOUND: f64 = 2.5 * f32::EPSILON as f64 * 0.5;
        for i in -100_000..=100_000 {
            let t = i as f32 / 100_000.0;
            let ((sin, cos), exact) = (sin_cos_eighth(t), (std::f64::consts::FRAC_PI_4 * f64::from(t)).sin_cos());
            let error = (f64::from(sin) - exact.0).abs().max((f64::from(cos) - exact.1).abs());
            assert!(error < BOUND, "{t}: {error}");
        }
    }

    /// Errors in ulps: .3 of the interpolation, .5 each of the ratio, its product and the sum, .7 of the other roundings,
    /// which the later coefficients shrink; relative to the result, which is at most doubled by the differences.
    #[test]
    fn angles_are_within_their_rounding() {
        for i in 0..100_000u32 {
            let angle = (f64::from(i) / 50_000.0 - 1.0) * std::f64::consts::PI;
            let (x, y) = (angle.cos() as f32, angle.sin() as f32);
            let exact = f64::from(y).atan2(f64::from(x)) / std::f64::consts::TAU;
            let error = (f64::from(signed_turn(y, x)) - exact).abs();
            assert!(error <= 2.5 * f64::from(f32::EPSILON) * exact.abs(), "{x} {y}: {error}");
        }
        assert_eq!([signed_turn(0.0, 0.0f32), signed_turn(0.0, 1.0), signed_turn(0.0, -1.0)], [0.0, 0.0, 0.5]);
        assert_eq!([signed_turn(1.0, 0.0f32), signed_turn(-1.0, 0.0), signed_turn(-0.0, -1.0)], [0.25, -0.25, -0.5]);
    }

    /// Cosine and sine: that of an eighth of the angle, whose error two doublings multiply by four, and three roundings of
    /// each. The sine of a small angle: relatively, the last coefficient's rounding and eight more.
    #[test]
    fn half_a_turn_is_half_a_circle_and_begins_without_loss() {
        let half_ulp = 0.5 * f64::from(f32::EPSILON);
        for i in 0..=100_000u32 {
            let turn = i as f32 / 200_000.0;
            let ([cos, sin], exact) = (half_turn(turn), (std::f64::consts::TAU * f64::from(turn)).sin_cos());
            let error = (f64::from(sin) - exact.0).abs().max((f64::from(cos) - exact.1).abs());
            assert!(error < 16.0 * half_ulp, "{turn}: {error}");
            let small = 1e-3 * turn;
            let (sin, exact) = (f64::from(half_turn(small)[1]), (std::f64::consts::TAU * f64::from(small)).sin());
            assert!((sin - exact).abs() <= 9.0 * half_ulp * exact, "{small}: {sin} for {exact}");
        }
    }

    /// The rounding of a sum near 1 scaled by √½, of the eighth's sine and cosine, and of their difference: 5 half-ulps.
    #[test]
    fn a_circle_is_a_circle() {
        for i in 0..100_000u32 {
            let turn = i as f32 / 100_000.0;
            let ([x, y], exact) = (circle(turn), (std::f64::consts::TAU * f64::from(turn)).sin_cos());
            let error = (f64::from(x) - exact.1).abs().max((f64::from(y) - exact.0).abs());
            assert!(error < 2.5 * f64::from(f32::EPSILON), "{turn}: {error}");
        }
    }
}
