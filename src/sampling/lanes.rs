//! Warps over lanes. Those of [`super::warp`] for glam's types are these at one lane.

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
