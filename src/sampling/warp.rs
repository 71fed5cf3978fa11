//! Warps from the unit square to disks, spheres and triangles, with densities and inverses, and one from the unit
//! interval to a linear density. All are continuous and measure-preserving, so that stratified and Metropolis samples
//! keep their structure. Disks use the concentric map [Shirley97], triangles fold the square [Heitz19].

use super::{Pdf, SolidAngle, lanes};
use glam::{Vec2, Vec3};
use std::f32::consts::{FRAC_PI_4, TAU};

/// Largest f32 below one: the upper limit of samplers.
pub use crate::numeric::BELOW_ONE;

/// Maps `u` to the unit disk by the concentric map. Density per area: 1 / π.
#[inline]
pub fn concentric_disk(u: [f32; 2]) -> Vec2 {
    let (radius, direction) = lanes::concentric_polar(u);
    Vec2::from(direction) * radius
}

/// Inverse of [`concentric_disk`].
#[inline]
pub fn concentric_disk_inverse(p: Vec2) -> [f32; 2] {
    let radius = p.length();
    let (a, b) = if p.x.abs() > p.y.abs() {
        let a = radius.copysign(p.x);
        (a, (p.y / p.x).atan() / FRAC_PI_4 * a)
    } else if radius > 0.0 {
        let b = radius.copysign(p.y);
        ((p.x / p.y).atan() / FRAC_PI_4 * b, b)
    } else {
        (0.0, 0.0)
    };
    [a, b].map(|x| into_unit(0.5 * (x + 1.0)))
}

/// Samples a direction around +z with density proportional to its cosine.
#[inline]
pub fn cosine_hemisphere(u: [f32; 2]) -> Vec3 {
    lanes::cosine_hemisphere(u).into()
}

/// Inverse of [`cosine_hemisphere`].
#[inline]
pub fn cosine_hemisphere_inverse(w: Vec3) -> [f32; 2] {
    concentric_disk_inverse(w.truncate())
}

/// Samples the upper hemisphere uniformly.
#[inline]
pub fn uniform_hemisphere(u: [f32; 2]) -> Vec3 {
    let disk = concentric_disk(u);
    let height = disk.length_squared();
    (disk * (2.0 - height).max(0.0).sqrt()).extend(1.0 - height)
}

/// Returns the density of [`uniform_hemisphere`].
#[inline]
pub fn uniform_hemisphere_pdf() -> Pdf<SolidAngle> {
    Pdf::new(1.0 / TAU)
}

/// Inverse of [`uniform_hemisphere`].
#[inline]
pub fn uniform_hemisphere_inverse(w: Vec3) -> [f32; 2] {
    concentric_disk_inverse(w.truncate() / (1.0 + w.z).sqrt())
}

/// Samples the sphere uniformly: the cosine to z from `u[0]`, the azimuth from `u[1]`.
#[inline]
pub fn uniform_sphere(u: [f32; 2]) -> Vec3 {
    cap(2.0 * u[0], u[1])
}

/// Returns the density of [`uniform_sphere`].
#[inline]
pub fn uniform_sphere_pdf() -> Pdf<SolidAngle> {
    Pdf::new(0.5 / TAU)
}

/// Inverse of [`uniform_sphere`].
#[inline]
pub fn uniform_sphere_inverse(w: Vec3) -> [f32; 2] {
    let height = if w.z > 0.0 { w.truncate().length_squared() / (1.0 + w.z) } else { 1.0 - w.z };
    [into_unit(0.5 * height), turn(w.y, w.x)]
}

/// Samples a triangle uniformly; returns the barycentric weights of its second and third vertex. Density 1 / area
/// [Heitz19].
#[inline]
pub fn uniform_triangle(u: [f32; 2]) -> [f32; 2] {
    lanes::uniform_triangle(u)
}

/// Inverse of [`uniform_triangle`] at the weights `b`.
#[inline]
pub fn uniform_triangle_inverse(b: [f32; 2]) -> [f32; 2] {
    let sum = b[0] + b[1];
    (if b[0] < b[1] { [2.0 * b[0], sum] } else { [sum, 2.0 * b[1]] }).map(into_unit)
}

/// Samples the unit interval with linear density 2 lerp(a, b, x) / (a + b); `a` and `b` are not negative, and not both
/// zero.
#[inline]
pub fn linear(u: f32, densities: [f32; 2]) -> f32 {
    lanes::linear(u, densities)
}

/// Returns the angle of (x, y) in turns, in [0, 1).
#[inline]
pub fn turn(y: f32, x: f32) -> f32 {
    let t = y.atan2(x) / TAU;
    into_unit(if t < 0.0 { t + 1.0 } else { t })
}

/// Clamps `u` to [0, 1) after rounding.
#[inline]
pub fn into_unit(u: f32) -> f32 {
    lanes::into_unit(u)
}

/// Returns the direction at azimuth `turn` (in turns) around +z with cosine 1 − `height`; the sine is computed without
/// cancellation. Uniform over the cap of height h if `height` is uniform in [0, h].
#[inline]
pub fn cap(height: f32, turn: f32) -> Vec3 {
    lanes::cap(height, turn).into()
}

/// Returns the density of uniform directions over a cap of `height`, above 0.
#[inline]
pub fn cap_pdf(height: f32) -> Pdf<SolidAngle> {
    Pdf::new((TAU * height).recip())
}
