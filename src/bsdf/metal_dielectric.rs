//! A mixture of metal and dielectric, for parameters of [`super::MetallicRoughness`] that no plain model covers: one
//! GGX reflection, a diffuse base under its dielectric share, and a transmitted share.
//!
//! Schlick's Fresnel is linear in f0 and f90, so that metal and dielectric mixed by `metallic` form a single
//! reflection. The base is coupled to the layer by base (1 − E(wi)) (1 − E(wo)) / (π (1 − Ē)), with E the directional
//! albedo of the layer [Kelemen01]. The example in the specification, base (1 − F(V·H)) / π, is not used: it ignores
//! facets, differs from the transmittance of the layer, and lets a white base gain energy at grazing angles. The
//! coupled base receives exactly what the layer does not reflect, so that a white base under a white layer conserves
//! energy up to [`super::albedo::ERROR`]. Transmission takes the share `transmission` (1 − `metallic`). A thin wall
//! keeps Schlick's layer and transmits 1 − F. In a solid the exact Fresnel governs that share, and `specular` does not.
//! References: [glTF20], [Kelemen01].

use super::albedo::{Albedo, AlbedoMoments};
use super::conductor::invert_reflection;
use super::fresnel::schlick;
use super::ggx::{Ggx, facing, half, reflect, through};
use super::lambert::{cosine_direction, cosine_pdf, invert_cosine};
use super::{Bsdf, BsdfSample, Dielectric, Lobes, ScatteringBound, Shares, within};
use crate::geometry::Local;
use crate::numeric::Scalar;
use crate::sampling::warp::into_unit;
use crate::sampling::{Density, Pdf};
use crate::spectrum::Spectrum;
use crate::transport::TransportMode;
use etendue_lanes::ROW;
use std::f32::consts::FRAC_1_PI;

/// A metallic-roughness surface, created by [`super::MetallicRoughness::surface`].
#[derive(Debug, Clone, Copy)]
pub struct MetalDielectric {
    pub(super) ggx: Ggx,
    pub(super) base: Spectrum,
    /// Fresnel parameters of the whole reflection.
    pub(super) specular: Schlick,
    /// Fresnel parameters of the dielectric layer.
    pub(super) layer: Schlick,
    pub(super) albedo: Albedo,
    /// Base colour times its share, and 1 / (1 − Ē) of the layer above it.
    pub(super) diffuse: Spectrum,
    pub(super) coupling: Spectrum,
    pub(super) transmission: Transmission,
}

/// Reflectance at normal and at grazing incidence.
#[derive(Debug, Clone, Copy)]
pub(super) struct Schlick {
    pub(super) f0: Spectrum,
    pub(super) f90: Spectrum,
}

/// Transmission model; weights include its share.
#[derive(Debug, Clone, Copy)]
pub(super) enum Transmission {
    None,
    Thin(Spectrum),
    Solid(Dielectric),
}

/// Selection probabilities of the three parts.
struct Choice<T> {
    specular: T,
    diffuse: T,
    transmission: T,
}

/// Terms that depend on one direction alone.
struct DirectionTerms<T> {
    choice: Choice<T>,
    /// See [`MetalDielectric::below`].
    below: Spectrum<T>,
}

impl MetalDielectric {
    /// See [`super::Surface::refracts`].
    #[inline]
    pub(super) fn refracts(&self) -> bool {
        matches!(self.transmission, Transmission::Solid(_))
    }

    /// See [`super::Surface::transmission`].
    pub(super) fn refracted(&self) -> Spectrum {
        match self.transmission {
            Transmission::Solid(glass) => glass.transmit,
            Transmission::None | Transmission::Thin(_) => Spectrum::ZERO,
        }
    }

    /// See [`super::Surface::bound`].
    pub(super) fn bound(&self, known: Local) -> ScatteringBound {
        let scatters = !self.ggx.is_dirac();
        if scatters && !matches!(self.transmission, Transmission::None) {
            return ScatteringBound::NONE;
        }
        let facets = self.specular.f0.max_lane().max(self.specular.f90.max_lane());
        let glossy = if scatters { facets * self.ggx.most_reflection(known) } else { 0.0 };
        // The layer transmits at most all light, in both directions.
        ScatteringBound { diffuse: (self.diffuse * self.coupling).max_lane() * FRAC_1_PI, glossy }
    }

    /// Whether light crosses it.
    #[inline]
    pub(super) fn transmits(&self) -> bool {
        !matches!(self.transmission, Transmission::None)
    }

    /// See [`super::Surface::shares`]. A mirror has no lobe that light samples could meet.
    #[inline]
    pub(super) fn shares(&self, known: Local) -> Shares {
        let Some(DirectionTerms { choice, .. }) = self.end(known) else { return Shares::DIFFUSE };
        let (diffuse, alpha2) = (choice.diffuse + choice.transmission, self.ggx.alpha_squared());
        let glossy = if self.ggx.is_dirac() { 0.0 } else { choice.specular };
        Shares { diffuse, glossy, alpha2 }
    }

    /// Whether its transmission is unscattered.
    pub(super) fn passes_straight(&self) -> bool {
        match &self.transmission {
            Transmission::None => false,
            Transmission::Thin(_) => self.ggx.is_dirac(),
            Transmission::Solid(glass) => glass.is_matched(),
        }
    }

    /// Returns the parameters of [`LaneMetalDielectric`](super::lanes::LaneMetalDielectric); `None` for transmission
    /// and mirrors.
    pub(super) fn parameters(&self) -> Option<[[f32; ROW]; 3]> {
        if self.ggx.is_dirac() || !matches!(self.transmission, Transmission::None) {
            return None;
        }
        let Schlick { f0: Spectrum([a, b, c]), f90: Spectrum([d, e, f]) } = self.specular;
        let Schlick { f0: Spectrum([g, h, i]), f90: Spectrum([j, k, l]) } = self.layer;
        let ([row, weight, alpha], Spectrum([m, n, o])) = (self.albedo.place(), self.diffuse);
        let Spectrum([p, q, r]) = self.diffuse * self.coupling * FRAC_1_PI;
        Some([[a, b, c, d, e, f, alpha, row], [g, h, i, j, k, l, weight, 0.0], [m, n, o, p, q, r, 0.0, 0.0]])
    }

    /// Returns the surface without transmission.
    pub(super) fn opaque(&self) -> Self {
        MetalDielectric { transmission: Transmission::None, ..*self }
    }

    /// Returns the selection probabilities for `known`, by the albedo of each part; `None` for a black surface.
    #[inline]
    fn end<T: Scalar>(&self, known: Local<T>) -> Option<DirectionTerms<T>> {
        let moments = self.albedo.at(known.z.abs());
        let below = self.passed(&moments);
        let specular = moments.albedo(self.specular.f0, self.specular.f90).mean();
        let diffuse = (self.diffuse.cast::<T>() * below).mean();
        let transmission = match &self.transmission {
            Transmission::None => T::ZERO,
            Transmission::Thin(transmit) => (transmit.cast::<T>() * below).mean(),
            Transmission::Solid(glass) => glass.throughput(known),
        };
        let total = specular + diffuse + transmission;
        (total.value() > 0.0).then(|| {
            let k = total.recip();
            let choice = Choice { specular: specular * k, diffuse: diffuse * k, transmission: transmission * k };
            DirectionTerms { choice, below }
        })
    }

    /// Returns the transmittance of the layer for a direction of cosine `cos`.
    #[inline]
    fn below<T: Scalar>(&self, cos: T) -> Spectrum<T> {
        self.passed(&self.albedo.at(cos.abs()))
    }

    #[inline]
    fn passed<T: Scalar>(&self, moments: &AlbedoMoments<T>) -> Spectrum<T> {
        (Spectrum::ONE - moments.albedo(self.layer.f0, self.layer.f90)).map(|x| x.max(T::ZERO))
    }

    #[inline]
    fn reflected<T: Scalar>(&self, wi: Local<T>, wo: Local<T>, below: Spectrum<T>) -> Spectrum<T> {
        let diffuse = (self.diffuse * self.coupling * FRAC_1_PI).cast::<T>() * below;
        if self.ggx.is_dirac() {
            return diffuse;
        }
        let h = half(wi, wo);
        diffuse + schlick(self.specular.f0, self.specular.f90, wi.dot(h)) * self.ggx.reflection(wi, wo, h)
    }

    #[inline]
    fn transmitted_thin<T: Scalar>(&self, transmit: Spectrum, wi: Local<T>, wo: Local<T>) -> Spectrum<T> {
        let lit = through(wi);
        let h = half(lit, wo);
        let passed = Spectrum::ONE - schlick(self.layer.f0, self.layer.f90, wo.dot(h));
        transmit.cast::<T>() * passed * self.ggx.reflection(lit, wo, h)
    }

    /// Returns the Dirac component `lobe`, combined over all parts; `end` belongs to `known`.
    fn dirac_of(
        &self,
        known: Local,
        end: &DirectionTerms<f32>,
        mode: TransportMode,
        lobe: Lobes,
    ) -> Option<BsdfSample> {
        let (mirrored, cos) = (Local::new(-known.x, -known.y, known.z), known.z.abs());
        let mut sample =
            BsdfSample { direction: mirrored, value: Spectrum::ZERO, density: Density::Delta(0.0), lobe, eta: 1.0 };
        let mut probability = 0.0;
        if lobe == Lobes::DIRAC_REFLECT && self.ggx.is_dirac() {
            probability = end.choice.specular;
            sample.value = schlick(self.specular.f0, self.specular.f90, cos);
        }
        match &self.transmission {
            Transmission::Thin(transmit) if lobe == Lobes::DIRAC_TRANSMIT && self.ggx.is_dirac() => {
                probability = end.choice.transmission;
                sample.direction = through(mirrored);
                sample.value = *transmit * (Spectrum::ONE - schlick(self.layer.f0, self.layer.f90, cos));
            }
            Transmission::Solid(glass) => {
                if let Some(through) = glass.dirac(known, mode, lobe) {
                    probability += end.choice.transmission * through.density.value();
                    sample = BsdfSample { value: sample.value + through.value, ..through };
                }
            }
            _ => {}
        }
        (probability > 0.0).then_some(BsdfSample { density: Density::Delta(probability), ..sample })
    }

    /// Returns value and density of all smooth lobes in a direction sampled from one of them.
    fn smooth(
        &self,
        known: Local,
        end: &DirectionTerms<f32>,
        mode: TransportMode,
        direction: Local,
        eta: f32,
    ) -> Option<BsdfSample> {
        let lobe = if known.same_side(direction) { Lobes::REFLECT } else { Lobes::TRANSMIT };
        let (value, density) = self.value_and_pdf(known, end, direction, mode);
        (density > 0.0).then(|| BsdfSample { direction, value, density: Density::Smooth(Pdf::new(density)), lobe, eta })
    }

    /// Returns value and density of all smooth lobes; `end` belongs to `known`.
    #[inline]
    fn value_and_pdf<T: Scalar>(
        &self,
        known: Local<T>,
        end: &DirectionTerms<T>,
        other: Local<T>,
        mode: TransportMode,
    ) -> (Spectrum<T>, T) {
        let (wi, wo) = mode.flow(known, other);
        let value = self.value(wi, wo, || end.below * self.below(other.z));
        let [a, b, c] = self.densities(known, other, mode, &end.choice);
        (value, a + b + c)
    }

    /// Returns f(wi, wo) of all smooth lobes; `below` is the transmittance of the layer for both directions.
    #[inline]
    fn value<T: Scalar>(&self, wi: Local<T>, wo: Local<T>, below: impl FnOnce() -> Spectrum<T>) -> Spectrum<T> {
        let same = wi.same_side(wo);
        let own = if same { self.reflected(wi, wo, below()) } else { Spectrum::ZERO };
        match &self.transmission {
            Transmission::Solid(glass) => own + glass.eval(wi, wo, Lobes::SMOOTH),
            Transmission::Thin(t) if !same && !self.ggx.is_dirac() => self.transmitted_thin(*t, wi, wo),
            _ => own,
        }
    }

    fn reflect_in_facet(&self, known: Local, u: [f32; 3]) -> Option<Local> {
        let above = facing(known, known);
        let other = reflect(above, self.ggx.sample_normal(above, [u[1], u[2]]));
        above.same_side(other).then(|| facing(other, known))
    }

    fn sample_transmission(
        &self,
        known: Local,
        end: &DirectionTerms<f32>,
        mode: TransportMode,
        u: [f32; 3],
    ) -> Option<BsdfSample> {
        match &self.transmission {
            Transmission::None => None,
            Transmission::Thin(_) if self.ggx.is_dirac() => self.dirac_of(known, end, mode, Lobes::DIRAC_TRANSMIT),
            Transmission::Thin(_) => self.smooth(known, end, mode, through(self.reflect_in_facet(known, u)?), 1.0),
            Transmission::Solid(glass) => {
                let sample = glass.sample(known, mode, u)?;
                match sample.density {
                    Density::Delta(_) => self.dirac_of(known, end, mode, sample.lobe),
                    Density::Smooth(_) => self.smooth(known, end, mode, sample.direction, sample.eta),
                }
            }
        }
    }

    /// Returns the densities of `other` in the three parts, each times its selection probability.
    #[inline]
    fn densities<T: Scalar>(
        &self,
        known: Local<T>,
        other: Local<T>,
        mode: TransportMode,
        choice: &Choice<T>,
    ) -> [T; 3] {
        let facets = |other: Local<T>| {
            if self.ggx.is_dirac() { T::ZERO } else { self.ggx.reflection_pdf(known, half(known, other)) }
        };
        let same = known.same_side(other);
        let transmitted = match &self.transmission {
            Transmission::Solid(glass) => glass.pdf(known, other, mode, Lobes::SMOOTH),
            Transmission::Thin(_) if !same => facets(through(other)),
            _ => T::ZERO,
        };
        let specular = if same { facets(other) } else { T::ZERO };
        [choice.specular * specular, choice.diffuse * cosine_pdf(known, other), choice.transmission * transmitted]
    }
}

impl Bsdf for MetalDielectric {
    #[inline]
    fn eval<T: Scalar>(&self, wi: Local<T>, wo: Local<T>, lobes: Lobes) -> Spectrum<T> {
        let same = wi.same_side(wo);
        if !lobes.intersects(if same { Lobes::REFLECT } else { Lobes::TRANSMIT }) {
            return Spectrum::ZERO;
        }
        self.value(wi, wo, || self.below(wi.z) * self.below(wo.z))
    }

    #[inline]
    fn sample(&self, known: Local, mode: TransportMode, u: [f32; 3]) -> Option<BsdfSample> {
        let end = self.end(known)?;
        let choice = &end.choice;
        let smooth_end = choice.specular + choice.diffuse;
        if u[0] < choice.specular {
            if self.ggx.is_dirac() {
                return self.dirac_of(known, &end, mode, Lobes::DIRAC_REFLECT);
            }
            return self.smooth(known, &end, mode, self.reflect_in_facet(known, u)?, 1.0);
        }
        if u[0] < smooth_end || choice.transmission <= 0.0 {
            return self.smooth(known, &end, mode, cosine_direction(known, [u[1], u[2]]), 1.0);
        }
        let within_part = into_unit((u[0] - smooth_end) / choice.transmission);
        self.sample_transmission(known, &end, mode, [within_part, u[1], u[2]])
    }

    #[inline]
    fn dirac(&self, known: Local, mode: TransportMode, lobe: Lobes) -> Option<BsdfSample> {
        self.dirac_of(known, &self.end(known)?, mode, lobe)
    }

    #[inline]
    fn pdf<T: Scalar>(&self, known: Local<T>, other: Local<T>, mode: TransportMode, lobes: Lobes) -> T {
        if !lobes.intersects(if known.same_side(other) { Lobes::REFLECT } else { Lobes::TRANSMIT }) {
            return T::ZERO;
        }
        self.end(known).map_or(T::ZERO, |end| {
            let [a, b, c] = self.densities(known, other, mode, &end.choice);
            a + b + c
        })
    }

    #[inline]
    fn eval_and_pdf<T: Scalar>(&self, known: Local<T>, other: Local<T>, mode: TransportMode) -> (Spectrum<T>, T) {
        self.end(known).map_or((Spectrum::ZERO, T::ZERO), |end| self.value_and_pdf(known, &end, other, mode))
    }

    fn invert(&self, known: Local, other: Local, mode: TransportMode, aux: [f32; 2]) -> Option<([f32; 3], f64)> {
        let choice = self.end(known)?.choice;
        let [specular, diffuse, transmitted] = self.densities(known, other, mode, &choice);
        let total = specular + diffuse + transmitted;
        let pick = aux[0] * total;
        let (start, end) = (choice.specular, choice.specular + choice.diffuse);
        let log_share = |part: f32| f64::from(part / total).ln();
        if pick < specular {
            let [a, b] = invert_reflection(self.ggx, known, other);
            return within([0.0, start], aux[1]).map(|(u, log)| ([u, a, b], log + log_share(specular)));
        }
        if pick < specular + diffuse {
            let [a, b] = invert_cosine(other);
            return within([start, end], aux[1]).map(|(u, log)| ([u, a, b], log + log_share(diffuse)));
        }
        let (part, [a, b], log) = match &self.transmission {
            Transmission::Solid(glass) => {
                let ([u, a, b], log) = glass.invert(known, other, mode, aux)?;
                (u, [a, b], log)
            }
            _ if transmitted > 0.0 => (aux[1], invert_reflection(self.ggx, known, through(other)), 0.0),
            _ => return None,
        };
        let u = end + choice.transmission * part;
        let log = log - f64::from(choice.transmission).ln() + log_share(transmitted);
        Some(([into_unit(u), a, b], log))
    }

    fn lobes(&self) -> Lobes {
        let own = if self.ggx.is_dirac() { Lobes::DIRAC_REFLECT } else { Lobes::REFLECT };
        let base = if self.diffuse.is_black() { Lobes::NONE } else { Lobes::REFLECT };
        let transmission = match &self.transmission {
            Transmission::None => Lobes::NONE,
            Transmission::Thin(_) if self.ggx.is_dirac() => Lobes::DIRAC_TRANSMIT,
            Transmission::Thin(_) => Lobes::TRANSMIT,
            Transmission::Solid(glass) => glass.lobes(),
        };
        own.union(base).union(transmission)
    }
}
