//! Directions on different sides of the two normals, and their mapping to BSDF directions as defined in
//! [`super::shading`], in any scalar type.
//!
//! Both mappings are isometries, so that no density needs a Jacobian, and are the identity where the normals agree.

use crate::geometry::Local;
use crate::numeric::Scalar;

/// A unit direction relative to both normals.
#[derive(Debug, Clone, Copy)]
pub struct Sided<T = f32> {
    /// In the shading frame.
    pub local: Local<T>,
    /// Cosine to the geometric normal.
    pub cos: T,
}

/// Directions in the shading frame that ψ maps to one world direction.
#[derive(Debug, Clone, Copy)]
pub struct Sources<T = f32> {
    /// The direction itself.
    pub direct: Local<T>,
    /// The direction on the wrong side of the surface that is mirrored to this one.
    pub folded: Option<Local<T>>,
}

impl<T: Scalar> Sided<T> {
    /// Whether it lies on the same side of both normals.
    #[inline]
    pub fn agrees(self) -> bool {
        (self.local.z * self.cos).value() > 0.0
    }

    /// Returns its mirror image in the plane of the surface, with normal `ng` in the shading frame.
    #[inline]
    fn folded(self, ng: Local<T>) -> Local<T> {
        self.local.plus(ng.scale(T::of(-2.0) * self.cos))
    }

    /// Whether ψ maps two directions to this one: the normals disagree about its mirror image in the plane of the
    /// surface and agree about itself. `slant` is the cosine between the normals.
    #[inline]
    pub fn is_met_twice(self, slant: T) -> bool {
        let twin = (self.local.z - T::of(2.0) * self.cos * slant) * self.cos;
        twin.value() > 0.0
    }

    /// Returns the preimages under ψ for an incident direction; `None` where nothing scatters. `ng` is the geometric
    /// normal in the shading frame, and `slant` its cosine.
    #[inline]
    pub fn sources(self, slant: T, ng: impl FnOnce() -> Local<T>) -> Option<Sources<T>> {
        let folded = || self.is_met_twice(slant).then(|| self.folded(ng()));
        self.agrees().then(|| Sources { direct: self.local, folded: folded() })
    }

    /// Returns φ for an outgoing direction, which is on the side of ng.
    #[inline]
    pub fn seen(self) -> Option<Local<T>> {
        let side = (self.local.z * self.cos).value();
        if side > 0.0 {
            return Some(self.local);
        }
        (side < 0.0).then(|| Local::new(self.local.x, self.local.y, T::ZERO - self.local.z))
    }

    /// Whether another world direction has the same φ ([`Sided::seen`]); `slant` is the cosine between the normals. The
    /// other direction is the mirror image in the plane of the shading normal.
    #[inline]
    pub fn has_twin(self, slant: T) -> bool {
        let twin = (self.cos - T::of(2.0) * self.local.z * slant) * self.cos;
        !self.agrees() || twin.value() > 0.0
    }

    /// Returns the probability that a light subpath selects this direction instead of its twin.
    #[inline]
    pub fn share(self, slant: T) -> T {
        if self.has_twin(slant) { T::of(0.5) } else { T::ONE }
    }
}

impl<T: Scalar> Sources<T> {
    /// Returns the direct or the folded direction with its selection probability in a light subpath. Probabilities are
    /// proportional to the cosines, so that the cosine of the folded one cancels in its weight.
    #[inline]
    pub fn choice(&self, is_folded: bool) -> Option<(Local<T>, T)> {
        let Some(folded) = self.folded else { return (!is_folded).then_some((self.direct, T::ONE)) };
        let chosen = if is_folded { folded } else { self.direct };
        Some((chosen, chosen.z.abs() / (self.direct.z.abs() + folded.z.abs())))
    }

    /// Enumerates both with their probabilities.
    #[inline]
    pub fn choices(&self) -> impl Iterator<Item = (Local<T>, T)> + '_ {
        [false, true].into_iter().filter_map(|is_folded| self.choice(is_folded))
    }
}
