//! Directions on different sides of the two normals, and how a model sees them: what [`super::shading`] says of them, in any
//! scalar type.
//!
//! Both rules are isometries, so that no density needs a Jacobian, and are the identity where the normals agree.

use crate::defects::{Defect, planted};
use crate::geometry::Local;
use crate::numeric::Scalar;

/// A unit direction as the two normals have it.
#[derive(Debug, Clone, Copy)]
pub struct Sided<T = f32> {
    /// In the shading frame.
    pub local: Local<T>,
    /// Cosine to the geometric normal.
    pub cos: T,
}

/// The directions in the shading frame from which a model may be told that light comes in one direction of the world.
#[derive(Debug, Clone, Copy)]
pub struct Sources<T = f32> {
    /// The direction itself.
    pub direct: Local<T>,
    /// The one that leads to the wrong side of the surface and is folded up to this one.
    pub folded: Option<Local<T>>,
}

impl<T: Scalar> Sided<T> {
    /// Whether it is on one side of both normals.
    #[inline]
    pub fn agrees(self) -> bool {
        (self.local.z * self.cos).value() > 0.0
    }

    /// Its mirror image in the plane of the surface, whose normal in the shading frame is `ng`.
    #[inline]
    fn folded(self, ng: Local<T>) -> Local<T> {
        self.local.plus(ng.scale(T::of(-2.0) * self.cos))
    }

    /// Whether the mirror image in the plane of the surface is one of which the normals disagree, where they agree of this direction.
    /// `slant` is the cosine between the normals.
    #[inline]
    pub fn is_met_twice(self, slant: T) -> bool {
        let twin = (self.local.z - T::of(2.0) * self.cos * slant) * self.cos;
        twin.value() > 0.0 && !planted(Defect::NormalsDisagreeBlack)
    }

    /// As the direction that light comes from; `None` where nothing scatters such light. `ng` is the geometric normal in the shading
    /// frame, and `slant` its cosine.
    #[inline]
    pub fn sources(self, slant: T, ng: impl FnOnce() -> Local<T>) -> Option<Sources<T>> {
        let folded = || self.is_met_twice(slant).then(|| self.folded(ng()));
        self.agrees().then(|| Sources { direct: self.local, folded: folded() })
    }

    /// As the direction that light leaves in: on the side of the surface where it is.
    #[inline]
    pub fn seen(self) -> Option<Local<T>> {
        let side = (self.local.z * self.cos).value();
        if side > 0.0 {
            return Some(self.local);
        }
        (side < 0.0 && !planted(Defect::NormalsDisagreeBlack))
            .then(|| Local::new(self.local.x, self.local.y, T::ZERO - self.local.z))
    }

    /// Whether another direction of the world is [`Sided::seen`] as this one is; `slant` is the cosine between the normals. It is
    /// the mirror image in the plane of the shading normal.
    #[inline]
    pub fn has_twin(self, slant: T) -> bool {
        let twin = (self.cos - T::of(2.0) * self.local.z * slant) * self.cos;
        !planted(Defect::NormalsDisagreeBlack) && (!self.agrees() || twin.value() > 0.0)
    }

    /// Probability with which a walk from the light takes it, and not its twin.
    #[inline]
    pub fn share(self, slant: T) -> T {
        if self.has_twin(slant) { T::of(0.5) } else { T::ONE }
    }
}

impl<T: Scalar> Sources<T> {
    /// The direction itself or the other, with the probability of a walk from the light: by their cosines, so that the other one's
    /// cancels in its weight.
    #[inline]
    pub fn choice(&self, is_folded: bool) -> Option<(Local<T>, T)> {
        let Some(folded) = self.folded else { return (!is_folded).then_some((self.direct, T::ONE)) };
        let chosen = if is_folded { folded } else { self.direct };
        Some((chosen, chosen.z.abs() / (self.direct.z.abs() + folded.z.abs())))
    }

    /// Both, with their probabilities.
    #[inline]
    pub fn choices(&self) -> impl Iterator<Item = (Local<T>, T)> + '_ {
        [false, true].into_iter().filter_map(|is_folded| self.choice(is_folded))
    }
}
