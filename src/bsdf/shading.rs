//! Scattering at a surface point in world directions: the only module that handles both normals.
//!
//! Where wi and wo lie on the same sides of the shading normal ns and the geometric normal ng, the effective BSDF is
//! F(wi, wo) = f(wi, wo) |wi·ns| / |wi·ng| [Veach97 §5.3]. It is not symmetric even where f is, so that the cosines
//! below depend on the direction of transport. Only products that stay finite at grazing angles are offered.
//! |wi·ng| → 0 remains in light subpaths, where the model itself is unbounded.
//!
//! Veach's F is zero elsewhere, and light is lost: one half for clear glass with corner normals. Here ng alone defines
//! the side of a direction, and the BSDF receives a direction for which ns agrees:
//! - Light that *leaves* along wo is evaluated along φ(wo). This is wo, or its mirror image in the plane of ns where
//!   the normals disagree.
//! - Light that the BSDF requests *from* w arrives from ψ(w). This is w, or its mirror image in the plane of ng where
//!   the normals disagree.
//!
//! So F(wi, wo) |wi·ng| = Σ f(w, φ(wo)) |w·ns| over the w with ψ(w) = wi: one or two, or none where the normals
//! disagree about wi.
//! - F is a single function of (wi, wo) for either known direction: φ depends on wo alone and ψ on wi alone. Light
//!   subpaths select among the w of wi, and between the two wo of a φ(wo).
//! - Mirror images are isometries, so that ∫ F |wi·ng| dwi = ∫ f |w·ns| dw for every wo. The albedo is that of the
//!   BSDF, and a clear or white surface stays 1 in a white environment. This holds for Dirac components, mirrors,
//!   glass, rough surfaces and mixtures.
//! - Nothing leaks through a surface: reflection stays on the side of wo, and transmission on the other.
//! - F is continuous across w·ng = 0 and wo·ns = 0, since f is continuous in its own arguments.
//!
//! Appearance is biased, as with any shading normal: reflections that would enter the surface are mirrored upward, and
//! silhouettes look the same from the wrong side of ns as from the right one. Like Veach's F, F is not reciprocal, and
//! light subpaths do not conserve flux.

use super::sides::{Sided, Sources};
use super::{Bsdf, BsdfSample, Lobes, Shares, Surface};
use crate::geometry::{Local, SurfacePoint};
use crate::numeric::BELOW_ONE;
use crate::sampling::{Density, Pdf, SolidAngle};
use crate::spectrum::Spectrum;
use crate::transport::{ScatteringOutline, TransportMode};
use glam::Vec3;

/// Scattering context: the surface point, its BSDF and the known direction. All directions have unit length and point
/// away from the surface.
#[derive(Debug, Clone, Copy)]
pub struct Shading<'a> {
    /// Surface point.
    pub point: &'a SurfacePoint,
    /// BSDF.
    pub surface: &'a Surface,
    known: Vec3,
    /// Known direction as passed to the BSDF; a single one in a camera subpath.
    seen: Sources,
    mode: TransportMode,
}

/// BSDF evaluation for a given direction.
#[derive(Debug, Clone, Copy)]
pub struct Scattering {
    /// F |cos| in that direction, all smooth lobes: cos = wi·ng toward the light, wo·ng toward the camera.
    pub f_cos: Spectrum,
    /// Density of the direction under [`Shading::sample`], all smooth lobes together.
    pub pdf: Pdf<SolidAngle>,
}

/// A sampled direction of a walk.
#[derive(Debug, Clone, Copy)]
pub struct ShadingSample {
    /// World direction, pointing away from the surface.
    pub direction: Vec3,
    /// Throughput factor: F |cos| / density in the sampled direction.
    pub weight: Spectrum,
    /// Density of all smooth lobes together, or the probability of the Dirac direction.
    pub density: Density,
    /// Sampled component.
    pub lobe: Lobes,
    /// Refractive index on the sampled side over the one on the known side; 1 for reflection. Roulette divides it out.
    pub eta: f32,
}

/// Mirror images by which a Dirac component maps its two directions: see the head of this module.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Folds {
    /// Whether ψ is not the identity.
    pub source: bool,
    /// Whether φ is not the identity.
    pub view: bool,
}

impl<'a> Shading<'a> {
    /// Creates the context of `surface` at `point` for a walk with transport `mode` that arrives against `known`.
    /// `None` if nothing scatters: for light from directions about which the normals disagree, and for tangential
    /// directions.
    #[inline]
    pub fn new(point: &'a SurfacePoint, surface: &'a Surface, known: Vec3, mode: TransportMode) -> Option<Self> {
        let seen = seen(point, known, mode)?;
        Some(Shading { point, surface, known, seen, mode })
    }

    /// Evaluates the BSDF between the known direction and `other`; `None` where F is zero.
    #[inline]
    pub fn scattering(&self, other: Vec3) -> Option<Scattering> {
        let others = seen(self.point, other, self.mode.reversed())?;
        let (known, o) = (self.seen.direct, others.direct);
        let (f, pdf) = self.surface.eval_and_pdf(known, o, self.mode);
        let is_plain = self.seen.folded.is_none() && others.folded.is_none();
        let (f_cos, pdf) =
            if is_plain { (f * self.cosines(known, other, o), pdf) } else { self.folded_sum(other, &others) };
        let pdf = if self.mode == TransportMode::Importance { pdf * self.share(other) } else { pdf };
        (!f_cos.is_black()).then(|| Scattering { f_cos, pdf: Pdf::new(pdf) })
    }

    /// Returns F |cos| and the density of `other`, summed over the mirror images of both directions.
    #[cold]
    fn folded_sum(&self, other: Vec3, others: &Sources) -> (Spectrum, f32) {
        let mut sum = (Spectrum::ZERO, 0.0);
        for (known, chosen) in self.seen.choices() {
            for o in others.choices().map(|(o, _)| o) {
                let (f, pdf) = self.surface.eval_and_pdf(known, o, self.mode);
                sum = (sum.0 + f * self.cosines(known, other, o), sum.1 + chosen * pdf);
            }
        }
        sum
    }

    /// Returns F(wi, wo) of the smooth lobes.
    #[inline]
    pub fn f(&self, other: Vec3) -> Spectrum {
        let Some(others) = seen(self.point, other, self.mode.reversed()) else { return Spectrum::ZERO };
        let ((wi, from), (_, to)) = self.mode.flow((self.known, self.seen), (other, others));
        let f = |w: Local| self.surface.eval(w, to.direct, Lobes::SMOOTH) * w.z.abs();
        from.choices().fold(Spectrum::ZERO, |sum, (w, _)| sum + f(w)) / self.cos(wi)
    }

    /// Samples a direction with the random numbers u = [lobe, direction, direction]; `None` if nothing scatters.
    #[inline]
    pub fn sample(&self, u: [f32; 3]) -> Option<ShadingSample> {
        match self.mode {
            TransportMode::Radiance => self.sample_source(u),
            TransportMode::Importance => self.sample_view(u),
        }
    }

    /// Samples toward the light: the direction from the BSDF, mirrored if it is on the wrong side of the surface.
    #[inline]
    fn sample_source(&self, u: [f32; 3]) -> Option<ShadingSample> {
        let sample = self.surface.sample(self.seen.direct, self.mode, u)?;
        let (direction, is_folded) = self.source(sample.direction)?;
        let is_met_twice =
            || Sided { local: sample.direction, cos: direction.dot(self.point.ng) }.is_met_twice(self.slant());
        let cos = match sample.density {
            Density::Smooth(_) if is_folded || is_met_twice() => return self.again(direction, &sample),
            Density::Smooth(pdf) => sample.direction.z.abs() / pdf.value(),
            Density::Delta(probability) => probability.recip(),
        };
        Some(ShadingSample {
            direction,
            weight: sample.value * cos,
            density: sample.density,
            lobe: sample.lobe,
            eta: sample.eta,
        })
    }

    /// Samples toward the camera: selects a mirror image of the known direction, and a preimage under φ of the sampled
    /// one.
    #[inline]
    fn sample_view(&self, [u, v, w]: [f32; 3]) -> Option<ShadingSample> {
        let bent = self.seen.folded.is_some() || self.point.frame.n != self.point.ng;
        let (folds, v) = if bent { self.choose(v) } else { (Folds { source: false, view: false }, v) };
        let (known, chosen) = self.seen.choice(folds.source)?;
        let sample = self.surface.sample(known, self.mode, [u, v, w])?;
        let direction = self.view(sample.direction, folds.view).or_else(|| self.view(sample.direction, false))?;
        let chosen = if bent { chosen * self.share(direction) } else { chosen };
        let (over, density) = match sample.density {
            Density::Smooth(_) if self.seen.folded.is_some() => return self.again(direction, &sample),
            Density::Smooth(pdf) => {
                let pdf = pdf.value() * chosen;
                (self.cosines(known, direction, sample.direction) / pdf, Density::Smooth(Pdf::new(pdf)))
            }
            Density::Delta(probability) => {
                let cosines = self.cosines(known, direction, sample.direction) / sample.direction.z.abs();
                (cosines / (probability * chosen), Density::Delta(probability * chosen))
            }
        };
        Some(ShadingSample { direction, weight: sample.value * over, density, lobe: sample.lobe, eta: sample.eta })
    }

    /// Selects mirror images for a light subpath, and returns the rescaled random number.
    #[inline]
    fn choose(&self, v: f32) -> (Folds, f32) {
        let direct = self.seen.choice(false).map_or(1.0, |(_, share)| share);
        let source = v >= direct;
        let v = if source { (v - direct) / (1.0 - direct) } else { v / direct };
        let view = v >= 0.5;
        let v = if view { 2.0 * v - 1.0 } else { 2.0 * v };
        (Folds { source, view }, v.clamp(0.0, BELOW_ONE))
    }

    /// Returns `sample` with the value and density of all mirror images that lead to `direction`.
    #[cold]
    fn again(&self, direction: Vec3, sample: &BsdfSample) -> Option<ShadingSample> {
        let Scattering { f_cos, pdf } = self.scattering(direction)?;
        let (weight, density) = (f_cos / pdf.value(), Density::Smooth(pdf));
        Some(ShadingSample { direction, weight, density, lobe: sample.lobe, eta: sample.eta })
    }

    /// Returns the density of the known direction for the reverse walk that arrives along `other`, all smooth lobes
    /// together.
    #[inline]
    pub fn reverse_pdf(&self, other: Vec3) -> Pdf<SolidAngle> {
        let back = self.mode.reversed();
        let Some(others) = seen(self.point, other, back) else { return Pdf::new(0.0) };
        let pdf = |o, known| self.surface.pdf(o, known, back, Lobes::SMOOTH);
        if self.seen.folded.is_none() && others.folded.is_none() {
            let share = if back == TransportMode::Importance { self.share(self.known) } else { 1.0 };
            return Pdf::new(pdf(others.direct, self.seen.direct) * share);
        }
        let known = || self.seen.choices().map(|(known, _)| known);
        let sum: f32 = others.choices().flat_map(|(o, chosen)| known().map(move |known| chosen * pdf(o, known))).sum();
        Pdf::new(if back == TransportMode::Importance { sum * self.share(self.known) } else { sum })
    }

    /// Returns the forward and reverse densities of `sample` for MIS. A Dirac direction has the probability of its
    /// component times |w·ns| η². Here η is the refractive index on the side of w over that of the known direction.
    /// This is the factor by which a chain of Dirac vertices changes the measure in one direction of transport and not
    /// in the other.
    pub fn densities(&self, sample: &ShadingSample) -> [f64; 2] {
        match sample.density {
            Density::Smooth(pdf) => [pdf, self.reverse_pdf(sample.direction)].map(|p| f64::from(p.value())),
            Density::Delta(probability) => {
                let [known, other, back] = self.dirac_back(sample).unwrap_or([0.0; 3]);
                let eta2 = f64::from(sample.eta).powi(2);
                [f64::from(probability * other) * eta2, f64::from(back * known)]
            }
        }
    }

    /// Returns the cosines to ns of both directions of a Dirac sample, as passed to the BSDF, and the probability of
    /// the component in the reverse walk.
    fn dirac_back(&self, sample: &ShadingSample) -> Option<[f32; 3]> {
        let back = self.mode.reversed();
        let (wi, wo) = self.mode.flow(self.known, sample.direction);
        let is_folded = folds(self.point, self.surface, wo, sample.lobe)?.source;
        let (from, chosen) = seen(self.point, wi, TransportMode::Importance)?.choice(is_folded)?;
        let to = seen(self.point, wo, TransportMode::Radiance)?.direct;
        let (known, other) = self.mode.flow(from, to);
        let probability = self.surface.dirac(other, back, sample.lobe)?.density.value();
        let chosen = if back == TransportMode::Importance { chosen * self.share(wo) } else { 1.0 };
        Some([known.z.abs(), other.z.abs(), probability * chosen])
    }

    /// Returns the direction of the Dirac component `lobe`. In a light subpath `folds` selects the mirror images.
    pub fn dirac(&self, lobe: Lobes, folds: Folds) -> Option<Vec3> {
        if self.mode == TransportMode::Radiance {
            let sample = self.surface.dirac(self.seen.direct, self.mode, lobe)?;
            return Some(self.source(sample.direction)?.0);
        }
        let (known, _) = self.seen.choice(folds.source)?;
        let sample = self.surface.dirac(known, self.mode, lobe)?;
        self.view(sample.direction, folds.view)
    }

    /// Returns the probability of sampling the Dirac component `lobe` in a camera subpath.
    pub fn probability(&self, lobe: Lobes) -> f64 {
        self.surface.dirac(self.seen.direct, self.mode, lobe).map_or(0.0, |d| f64::from(d.density.value()))
    }

    /// Continues the walk along `other`, which was sampled with density `pdf` by other means than [`Shading::sample`].
    #[inline]
    pub fn along(&self, other: Vec3, pdf: Pdf<SolidAngle>) -> ShadingSample {
        let weight = self.scattering(other).map_or(Spectrum::ZERO, |s| s.f_cos / pdf.value());
        ShadingSample { direction: other, weight, density: Density::Smooth(pdf), lobe: Lobes::SMOOTH, eta: 1.0 }
    }

    /// Known direction.
    #[inline]
    pub fn known(&self) -> Vec3 {
        self.known
    }

    /// Returns the outline of scattering toward the known direction.
    #[inline]
    pub fn outline(&self) -> ScatteringOutline {
        let Shares { diffuse, glossy, alpha2 } = self.surface.shares(self.seen.direct);
        let (n, wo, transmits) = (self.point.frame.n, self.known, self.surface.transmits());
        ScatteringOutline { n, wo, diffuse, glossy, alpha2, transmits }
    }

    /// Components of the surface.
    #[inline]
    pub fn lobes(&self) -> Lobes {
        self.surface.lobes()
    }

    /// Returns ψ of the BSDF direction `w`, and whether it is not the identity.
    #[inline]
    fn source(&self, w: Local) -> Option<(Vec3, bool)> {
        source(self.point, w)
    }

    /// Returns the world direction whose φ is `w`, mirrored or direct; `None` if it is on the wrong side.
    #[inline]
    fn view(&self, w: Local, is_mirrored: bool) -> Option<Vec3> {
        let direct = self.point.frame.to_world(w);
        let cos = direct.dot(self.point.ng);
        if !is_mirrored {
            return (cos * w.z > 0.0).then_some(direct);
        }
        let sided = Sided { local: w, cos };
        let mirrored = || self.point.frame.to_world(Local::new(w.x, w.y, -w.z));
        (sided.agrees() && sided.has_twin(self.slant())).then(mirrored)
    }

    /// See [`Sided::share`].
    #[inline]
    fn share(&self, wo: Vec3) -> f32 {
        sided(self.point, wo).share(self.slant())
    }

    /// ns·ng.
    #[inline]
    fn slant(&self) -> f32 {
        self.point.frame.n.dot(self.point.ng)
    }

    /// |w·ng|.
    #[inline]
    fn cos(&self, w: Vec3) -> f32 {
        w.dot(self.point.ng).abs()
    }

    /// Returns the factor of f in F |cos|: |wi·ns| toward the light, |wi·ns| |wo·ng| / |wi·ng| toward the camera
    /// [Veach97 (5.19)]. Cosines to ns are those passed to the BSDF: `known`, and `o` for the direction `other`.
    #[inline]
    fn cosines(&self, known: Local, other: Vec3, o: Local) -> f32 {
        match self.mode {
            TransportMode::Radiance => o.z.abs(),
            TransportMode::Importance => (known.z / self.cos(self.known)).abs() * self.cos(other),
        }
    }
}

/// Returns the mirror images by which light leaves `surface` at `point` along `wo` through the Dirac component `lobe`.
pub fn folds(point: &SurfacePoint, surface: &Surface, wo: Vec3, lobe: Lobes) -> Option<Folds> {
    let sided = sided(point, wo);
    let wanted = surface.dirac(sided.seen()?, TransportMode::Radiance, lobe)?.direction;
    Some(Folds { source: source(point, wanted)?.1, view: !sided.agrees() })
}

/// Returns ψ of the BSDF direction `w`, and whether it is not the identity.
#[inline]
fn source(point: &SurfacePoint, w: Local) -> Option<(Vec3, bool)> {
    let direct = point.frame.to_world(w);
    let cos = direct.dot(point.ng);
    let side = cos * w.z;
    if side > 0.0 {
        return Some((direct, false));
    }
    (side < 0.0).then(|| (direct - point.ng * (2.0 * cos), true))
}

/// Returns the BSDF directions for the world direction `w` of a walk with transport `mode`.
#[inline]
fn seen(point: &SurfacePoint, w: Vec3, mode: TransportMode) -> Option<Sources> {
    let sided = sided(point, w);
    match mode {
        TransportMode::Radiance => Some(Sources { direct: sided.seen()?, folded: None }),
        TransportMode::Importance => sided.sources(point.frame.n.dot(point.ng), || point.frame.to_local(point.ng)),
    }
}

#[inline]
fn sided(point: &SurfacePoint, w: Vec3) -> Sided {
    Sided { local: point.frame.to_local(w), cos: w.dot(point.ng) }
}
