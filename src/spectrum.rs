//! Radiance, reflectance and throughput over a fixed number of wavelength lanes. Linear Rec. 709 RGB is one choice of
//! lanes. Only texture upload and the film may depend on it.

use crate::numeric::Scalar;
use etendue_lanes::Float;
use std::ops::{Add, AddAssign, Div, Index, Mul, MulAssign, Sub};

/// Number of lanes of a spectrum.
pub const LANES: usize = 3;

/// One value per wavelength lane.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize, serde::Deserialize)]
#[serde(transparent)]
pub struct Spectrum<T = f32>(pub [T; LANES]);

impl<T: Copy> Spectrum<T> {
    /// The same value in every lane.
    #[inline]
    pub fn splat(x: T) -> Self {
        Spectrum([x; LANES])
    }

    // Written out, since `std::array::map` is not always inlined.
    /// Applies `f` to each lane.
    #[inline(always)]
    pub fn map<U>(self, mut f: impl FnMut(T) -> U) -> Spectrum<U> {
        let [a, b, c] = self.0;
        Spectrum([f(a), f(b), f(c)])
    }

    /// Applies `f` to the lanes of two spectra.
    #[inline(always)]
    pub fn zip(self, other: Self, mut f: impl FnMut(T, T) -> T) -> Self {
        let ([a, b, c], [x, y, z]) = (self.0, other.0);
        Spectrum([f(a, x), f(b, y), f(c, z)])
    }
}

impl<T: Scalar> Spectrum<T> {
    /// No light.
    pub const ZERO: Self = Spectrum([T::ZERO; LANES]);
    /// One in every lane.
    pub const ONE: Self = Spectrum([T::ONE; LANES]);

    /// Returns the largest lane.
    #[inline]
    pub fn max_lane(self) -> T {
        self.0.into_iter().fold(self.0[0], T::max)
    }

    /// Returns the smallest lane.
    #[inline]
    pub fn min_lane(self) -> T {
        self.0.into_iter().fold(self.0[0], T::min)
    }

    /// Returns the mean over the lanes.
    #[inline]
    pub fn mean(self) -> T {
        self.0.into_iter().fold(T::ZERO, |a, b| a + b) / T::of(LANES as f64)
    }

    /// Whether every lane is zero.
    #[inline]
    pub fn is_black(self) -> bool {
        self.0.into_iter().all(|x| x.value() == 0.0)
    }

    /// Whether every lane is finite.
    #[inline]
    pub fn is_finite(self) -> bool {
        self.0.into_iter().all(|x| x.value().is_finite())
    }

    /// Interpolates linearly from `self` (t = 0) to `other` (t = 1).
    #[inline]
    pub fn lerp(self, other: Self, t: T) -> Self {
        self * (T::ONE - t) + other * t
    }
}

impl Spectrum {
    /// Converts from a linear Rec. 709 colour.
    #[inline]
    pub fn from_rgb(rgb: [f32; 3]) -> Self {
        Spectrum(rgb)
    }

    /// Converts to a linear Rec. 709 colour.
    #[inline]
    pub fn to_rgb(self) -> [f32; 3] {
        self.0
    }

    /// Returns the relative luminance by the Rec. 709 weights.
    #[inline]
    pub fn luminance(self) -> f32 {
        let [r, g, b] = self.to_rgb();
        0.2126 * r + 0.7152 * g + 0.0722 * b
    }

    /// Converts to another scalar type.
    #[inline]
    pub fn cast<U: Scalar>(self) -> Spectrum<U> {
        self.map(|x| U::of(f64::from(x)))
    }
}

/// Spectra over lanes.
impl<F: Float> Spectrum<F> {
    /// The same spectrum in every lane.
    #[inline(always)]
    pub fn in_lanes(of: Spectrum) -> Self {
        of.map(|x| F::splat(x))
    }

    /// Returns the spectrum of `lane`.
    #[inline(always)]
    pub fn lane(self, lane: usize) -> Spectrum {
        self.map(|x| x.lane(lane))
    }

    /// Returns the largest value of each lane.
    #[inline(always)]
    pub fn greatest(self) -> F {
        let [r, g, b] = self.0;
        r.max(g).max(b)
    }

    /// Returns the lanes that are not [`Spectrum::is_black`].
    #[inline(always)]
    pub fn is_lit(self) -> F::Mask {
        let [r, g, b] = self.0;
        let is_zero = |x: F| x.equals(F::splat(0.0));
        !(is_zero(r) & is_zero(g) & is_zero(b))
    }

    /// Returns `yes` in the lanes of `mask`, else `no`.
    #[inline(always)]
    pub fn select(mask: F::Mask, yes: Self, no: Self) -> Self {
        yes.zip(no, |yes, no| F::select(mask, yes, no))
    }

    /// See [`etendue_lanes::Vec3::load`].
    #[inline(always)]
    pub fn load(from: &[Vec<f32>; LANES], at: usize) -> Self {
        let [r, g, b] = from;
        Spectrum([F::load(r, at), F::load(g, at), F::load(b, at)])
    }

    /// See [`etendue_lanes::Int::pack`].
    #[inline(always)]
    pub fn pack(self, mask: F::Mask, to: &mut [Vec<f32>; LANES], at: usize) {
        self.0.into_iter().zip(to).for_each(|(x, to)| x.pack(mask, to, at));
    }
}

impl<T> Index<usize> for Spectrum<T> {
    type Output = T;
    #[inline]
    fn index(&self, lane: usize) -> &T {
        &self.0[lane]
    }
}

impl<T: Copy + Add<Output = T>> Add for Spectrum<T> {
    type Output = Self;
    #[inline]
    fn add(self, other: Self) -> Self {
        self.zip(other, |a, b| a + b)
    }
}

impl<T: Scalar> AddAssign for Spectrum<T> {
    #[inline]
    fn add_assign(&mut self, other: Self) {
        *self = *self + other;
    }
}

impl<T: Copy + Sub<Output = T>> Sub for Spectrum<T> {
    type Output = Self;
    #[inline]
    fn sub(self, other: Self) -> Self {
        self.zip(other, |a, b| a - b)
    }
}

impl<T: Copy + Mul<Output = T>> Mul for Spectrum<T> {
    type Output = Self;
    #[inline]
    fn mul(self, other: Self) -> Self {
        self.zip(other, |a, b| a * b)
    }
}

impl<T: Scalar> MulAssign for Spectrum<T> {
    #[inline]
    fn mul_assign(&mut self, other: Self) {
        *self = *self * other;
    }
}

impl<T: Copy + Mul<Output = T>> Mul<T> for Spectrum<T> {
    type Output = Self;
    #[inline]
    fn mul(self, k: T) -> Self {
        self.map(|a| a * k)
    }
}

impl<T: Scalar> MulAssign<T> for Spectrum<T> {
    #[inline]
    fn mul_assign(&mut self, k: T) {
        *self = *self * k;
    }
}

impl<T: Scalar> Div<T> for Spectrum<T> {
    type Output = Self;
    /// One division and a product per lane: half an ulp more error than a division per lane, at a third of the cost.
    #[inline]
    #[allow(clippy::suspicious_arithmetic_impl)]
    fn div(self, k: T) -> Self {
        self * k.recip()
    }
}
