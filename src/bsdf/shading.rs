//! Scattering at a point of a surface, in world directions: the one place that knows both normals.
//!
//! Where the shading normal ns and the geometric normal ng have wi and wo on the same sides, the scattering function of transport
//! is F(wi, wo) = f(wi, wo) |wi·ns| / |wi·ng| [Veach97 §5.3]. It is not symmetric even where f is, which is why the cosines below
//! differ by the way of the walk. Only products that stay finite at grazing angles are offered; |wi·ng| → 0 remains in the light
//! walk's, where the model itself is unbounded.
//!
//! Veach's F is zero elsewhere, and the light is lost: of clear glass with corner normals a half. Here ng alone says on which side
//! of the surface a direction is, and the model is told a direction where ns agrees:
//! - light *leaves* along wo as if along φ(wo), which is wo, or its mirror image in the plane of ns where the normals disagree;
//! - light that the model wants *from* w comes from ψ(w), which is w, or its mirror image in the plane of ng where they disagree.
//!
//! So F(wi, wo) |wi·ng| = Σ f(w, φ(wo)) |w·ns| over the w with ψ(w) = wi: one or two, or none where the normals disagree about wi.
//! - It is one function of (wi, wo), whichever is known: φ asks for wo alone and ψ for wi alone. Walks from the light choose among
//!   the w of wi, and between the two wo of a φ(wo).
//! - Mirror images are isometries, so that ∫ F |wi·ng| dwi = ∫ f |w·ns| dw for every wo: the albedo is the model's, and what is
//!   clear or white is 1 in a white surrounding. This holds for Dirac components, mirrors, glass, rough ones and mixtures.
//! - Nothing leaks through a surface: the model's reflection stays on the side of wo, its transmission on the other.
//! - F is continuous across w·ng = 0 and wo·ns = 0, for f is in its own.
//!
//! What is biased is appearance, as with any shading normal: reflections that would dive below the surface are mirrored up, and
//! silhouettes show the model from the wrong side of ns as from the right one. F is not reciprocal, as Veach's is not, and the flux
//! of a walk from the light is not conserved.

use super::sides::{Sided, Sources};
use super::{Bsdf, BsdfSample, Lobes, Surface};
use crate::defects::{Defect, planted};
use crate::geometry::{Local, SurfacePoint};
use crate::numeric::BELOW_ONE;
use crate::sampling::{Density, Pdf, SolidAngle};
use crate::spectrum::Spectrum;
use crate::transport::Transport;
use glam::Vec3;

/// A walk's arrival at a surface: the point, its scattering model and the direction that is known. All directions have unit
/// length and point away from the surface.
#[derive(Debug, Clone, Copy)]
pub struct Shading<'a> {
    /// Where.
    pub point: &'a SurfacePoint,
    /// What scatters there.
    pub surface: &'a Surface,
    known: Vec3,
    /// How the model sees the direction that is known; one way in a walk from the camera.
    seen: Sources,
    toward: Transport,
}

/// What scatters into a direction that the walk did not choose.
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
    /// Away from the surface, in the world.
    pub direction: Vec3,
    /// What the throughput is multiplied by: F |cos| / density in the sampled direction.
    pub weight: Spectrum,
    /// Density of all smooth lobes together, or the probability of the Dirac direction.
    pub density: Density,
    /// The component that was taken.
    pub lobe: Lobes,
    /// Refractive index on the sampled side over the one on the known side; 1 for reflection. Roulette divides it out.
    pub eta: f32,
}

/// By which mirror images a Dirac component joins its two directions: see the head of this module.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Folds {
    /// ψ is not the identity.
    pub source: bool,
    /// φ is not the identity.
    pub view: bool,
}

impl<'a> Shading<'a> {
    /// `surface` at `point`, met along the reverse of `known` by a walk that goes `toward` an end of the path. `None` if nothing
    /// scatters: light from where the two normals disagree, and directions in the surface.
    #[inline]
    pub fn new(point: &'a SurfacePoint, surface: &'a Surface, known: Vec3, toward: Transport) -> Option<Self> {
        let seen = seen(point, known, toward)?;
        Some(Shading { point, surface, known, seen, toward })
    }

    /// What scatters between the known direction and `other`; `None` where F is zero.
    #[inline]
    pub fn scattering(&self, other: Vec3) -> Option<Scattering> {
        let others = seen(self.point, other, self.toward.reversed())?;
        let (known, o) = (self.seen.direct, others.direct);
        let (f, pdf) = self.surface.eval_and_pdf(known, o, self.toward);
        let is_plain = self.seen.folded.is_none() && others.folded.is_none();
        let (f_cos, pdf) = if is_plain { (f * self.cosines(known, other, o), pdf) } else { self.folded_sum(other, &others) };
        let pdf = if self.toward == Transport::Camera { pdf * self.share(other) } else { pdf };
        (!f_cos.is_black()).then(|| Scattering { f_cos, pdf: Pdf::new(pdf) })
    }

    /// F |cos| and the density of `other`, of two pairs of directions.
    #[cold]
    fn folded_sum(&self, other: Vec3, others: &Sources) -> (Spectrum, f32) {
        let mut sum = (Spectrum::ZERO, 0.0);
        for (known, chosen) in self.seen.choices() {
            for o in others.choices().map(|(o, _)| o) {
                let (f, pdf) = self.surface.eval_and_pdf(known, o, self.toward);
                sum = (sum.0 + f * self.cosines(known, other, o), sum.1 + chosen * pdf);
            }
        }
        sum
    }

    /// F(wi, wo) of the smooth lobes.
    #[inline]
    pub fn f(&self, other: Vec3) -> Spectrum {
        let Some(others) = seen(self.point, other, self.toward.reversed()) else { return Spectrum::ZERO };
        let ((wi, from), (_, to)) = self.toward.flow((self.known, self.seen), (other, others));
        let f = |w: Local| self.surface.eval(w, to.direct, Lobes::SMOOTH) * w.z.abs();
        from.choices().fold(Spectrum::ZERO, |sum, (w, _)| sum + f(w)) / self.cos(wi)
    }

    /// Continues the walk; u = [lobe, direction, direction]. `None` if nothing scatters.
    #[inline]
    pub fn sample(&self, u: [f32; 3]) -> Option<ShadingSample> {
        match self.toward {
            Transport::Light => self.sample_source(u),
            Transport::Camera => self.sample_view(u),
        }
    }

    /// Toward the light: where the model wants light from, folded where that is on the wrong side of the surface.
    #[inline]
    fn sample_source(&self, u: [f32; 3]) -> Option<ShadingSample> {
        let sample = self.surface.sample(self.seen.direct, self.toward, u)?;
        let (direction, is_folded) = self.source(sample.direction)?;
        let is_met_twice = || Sided { local: sample.direction, cos: direction.dot(self.point.ng) }.is_met_twice(self.slant());
        let cos = match sample.density {
            Density::Smooth(_) if is_folded || is_met_twice() => return self.again(direction, &sample),
            Density::Smooth(pdf) if planted(Defect::CosineDropped) => pdf.value().recip(),
            Density::Smooth(pdf) => sample.direction.z.abs() / pdf.value(),
            Density::Delta(probability) => probability.recip(),
        };
        Some(ShadingSample { direction, weight: sample.value * cos, density: sample.density, lobe: sample.lobe, eta: sample.eta })
    }

    /// Toward the camera: through one of the ways in which the model sees the known direction, to one of those that it would see as
    /// it does the sampled one.
    #[inline]
    fn sample_view(&self, [u, v, w]: [f32; 3]) -> Option<ShadingSample> {
        let bent = self.seen.folded.is_some() || self.point.frame.n != self.point.ng;
        let (folds, v) = if bent { self.choose(v) } else { (Folds { source: false, view: false }, v) };
        let (known, chosen) = self.seen.choice(folds.source)?;
        let sample = self.surface.sample(known, self.toward, [u, v, w])?;
        let direction = self.view(sample.direction, folds.view).or_else(|| self.view(sample.direction, false))?;
        let chosen = if bent { chosen * self.share(direction) } else { chosen };
        let (over, density) = match sample.density {
            Density::Smooth(_) if self.seen.folded.is_some() => return self.again(direction, &sample),
            Density::Smooth(pdf) if planted(Defect::CosineDropped) => (pdf.value().recip(), sample.density),
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

    /// Mirror images for a walk toward the camera, and what is left of the number that chose them.
    #[inline]
    fn choose(&self, v: f32) -> (Folds, f32) {
        let direct = self.seen.choice(false).map_or(1.0, |(_, share)| share);
        let source = v >= direct;
        let v = if source { (v - direct) / (1.0 - direct) } else { v / direct };
        let view = v >= 0.5;
        let v = if view { 2.0 * v - 1.0 } else { 2.0 * v };
        (Folds { source, view }, v.clamp(0.0, BELOW_ONE))
    }

    /// `sample`, which leads to `direction`, with the value and density of all that leads there.
    #[cold]
    fn again(&self, direction: Vec3, sample: &BsdfSample) -> Option<ShadingSample> {
        let Scattering { f_cos, pdf } = self.scattering(direction)?;
        let (weight, density) = (f_cos / pdf.value(), Density::Smooth(pdf));
        Some(ShadingSample { direction, weight, density, lobe: sample.lobe, eta: sample.eta })
    }

    /// Density of the known direction in a walk the other way that has come along `other`, all smooth lobes together.
    #[inline]
    pub fn reverse_pdf(&self, other: Vec3) -> Pdf<SolidAngle> {
        let back = self.toward.reversed();
        let Some(others) = seen(self.point, other, back) else { return Pdf::new(0.0) };
        let pdf = |o, known| self.surface.pdf(o, known, back, Lobes::SMOOTH);
        if self.seen.folded.is_none() && others.folded.is_none() {
            let share = if back == Transport::Camera { self.share(self.known) } else { 1.0 };
            return Pdf::new(pdf(others.direct, self.seen.direct) * share);
        }
        let known = || self.seen.choices().map(|(known, _)| known);
        let sum: f32 = others.choices().flat_map(|(o, chosen)| known().map(move |known| chosen * pdf(o, known))).sum();
        Pdf::new(if back == Transport::Camera { sum * self.share(self.known) } else { sum })
    }

    /// What multiple importance sampling compares of `sample`: the density that made it, and that of the known direction in a walk
    /// the other way. A Dirac direction has the probability of its component times |w·ns| η², η the index on the side that w leads
    /// to over that of the known direction: the factor by which a chain of Dirac vertices stretches one way and not the other.
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

    /// Cosines to ns of both directions of a Dirac sample, as the model sees them, and the probability that a walk the other way takes
    /// it.
    fn dirac_back(&self, sample: &ShadingSample) -> Option<[f32; 3]> {
        let back = self.toward.reversed();
        let (wi, wo) = self.toward.flow(self.known, sample.direction);
        let is_folded = folds(self.point, self.surface, wo, sample.lobe)?.source;
        let (from, chosen) = seen(self.point, wi, Transport::Camera)?.choice(is_folded)?;
        let to = seen(self.point, wo, Transport::Light)?.direct;
        let (known, other) = self.toward.flow(from, to);
        let probability = self.surface.dirac(other, back, sample.lobe)?.density.value();
        let chosen = if back == Transport::Camera { chosen * self.share(wo) } else { 1.0 };
        Some([known.z.abs(), other.z.abs(), probability * chosen])
    }

    /// The direction in which the Dirac component `lobe` leads on; a walk toward the camera says by which mirror images.
    pub fn dirac(&self, lobe: Lobes, folds: Folds) -> Option<Vec3> {
        if self.toward == Transport::Light {
            let sample = self.surface.dirac(self.seen.direct, self.toward, lobe)?;
            return Some(self.source(sample.direction)?.0);
        }
        let (known, _) = self.seen.choice(folds.source)?;
        let sample = self.surface.dirac(known, self.toward, lobe)?;
        self.view(sample.direction, folds.view)
    }

    /// Probability with which a walk from the camera goes on through the Dirac component `lobe`.
    pub fn probability(&self, lobe: Lobes) -> f64 {
        self.surface.dirac(self.seen.direct, self.toward, lobe).map_or(0.0, |d| f64::from(d.density.value()))
    }

    /// Continues the walk along `other`, which was made with density `pdf` by other means than [`Shading::sample`].
    #[inline]
    pub fn along(&self, other: Vec3, pdf: Pdf<SolidAngle>) -> ShadingSample {
        let weight = self.scattering(other).map_or(Spectrum::ZERO, |s| s.f_cos / pdf.value());
        ShadingSample { direction: other, weight, density: Density::Smooth(pdf), lobe: Lobes::SMOOTH, eta: 1.0 }
    }

    /// The direction that is known.
    #[inline]
    pub fn known(&self) -> Vec3 {
        self.known
    }

    /// The components of the surface.
    #[inline]
    pub fn lobes(&self) -> Lobes {
        self.surface.lobes()
    }

    /// ψ of the model's direction `w`, and whether it is not the identity.
    #[inline]
    fn source(&self, w: Local) -> Option<(Vec3, bool)> {
        source(self.point, w)
    }

    /// The direction that the model sees as `w`, by its mirror image or directly; `None` if that is not on the right side.
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

    /// F |cos| over f: |wi·ns| toward the light, |wi·ns| |wo·ng| / |wi·ng| toward the camera [Veach97 (5.19)], the cosines to ns as the
    /// model sees the directions: `known`, and `o` for the direction `other`.
    #[inline]
    fn cosines(&self, known: Local, other: Vec3, o: Local) -> f32 {
        match self.toward {
            _ if planted(Defect::CosineToNg) => self.cos(other),
            Transport::Light => o.z.abs(),
            Transport::Camera if planted(Defect::AdjointForgotten) => o.z.abs(),
            Transport::Camera => (known.z / self.cos(self.known)).abs() * self.cos(other),
        }
    }
}

/// By which mirror images light comes to leave `surface` at `point` along `wo` through the Dirac component `lobe`.
pub fn folds(point: &SurfacePoint, surface: &Surface, wo: Vec3, lobe: Lobes) -> Option<Folds> {
    let sided = sided(point, wo);
    let wanted = surface.dirac(sided.seen()?, Transport::Light, lobe)?.direction;
    Some(Folds { source: source(point, wanted)?.1, view: !sided.agrees() })
}

/// ψ of the model's direction `w`, and whether it is not the identity.
#[inline]
fn source(point: &SurfacePoint, w: Local) -> Option<(Vec3, bool)> {
    let direct = point.frame.to_world(w);
    let cos = direct.dot(point.ng);
    let side = cos * w.z;
    if side > 0.0 {
        return Some((direct, false));
    }
    (side < 0.0 && !planted(Defect::NormalsDisagreeBlack)).then(|| (direct - point.ng * (2.0 * cos), true))
}

/// How the model sees the world's direction `w` of a walk that goes `toward` an end of the path.
#[inline]
fn seen(point: &SurfacePoint, w: Vec3, toward: Transport) -> Option<Sources> {
    let sided = sided(point, w);
    match toward {
        Transport::Light => Some(Sources { direct: sided.seen()?, folded: None }),
        Transport::Camera => sided.sources(point.frame.n.dot(point.ng), || point.frame.to_local(point.ng)),
    }
}

#[inline]
fn sided(point: &SurfacePoint, w: Vec3) -> Sided {
    Sided { local: point.frame.to_local(w), cos: w.dot(point.ng) }
}
