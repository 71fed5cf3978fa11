//! Arithmetic with known rounding error.

/// Upper bound of the relative error of `n` successive f32 roundings, n ε / (1 − n ε) with ε = 2⁻²⁴ [PBRT4 §6.8.1].
pub const fn gamma(n: u32) -> f32 {
    let ne = n as f32 * (f32::EPSILON * 0.5);
    ne / (1.0 - ne)
}

/// a b − c d with an error below 1.5 ulp of the result, by one fused multiply-add and its remainder (Kahan).
#[inline]
pub fn difference_of_products(a: f32, b: f32, c: f32, d: f32) -> f32 {
    let cd = c * d;
    let difference = a.mul_add(b, -cd);
    let remainder = (-c).mul_add(d, cd);
    difference + remainder
}
