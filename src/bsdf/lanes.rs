//! Scattering over lanes, toward the light, of surfaces whose shading normal is the geometric one and whose model has
//! one smooth lobe. Each returns the bits of [`super::Shading`] with the same model.
//!
//! A lane in which rounding moves a sampled direction to the wrong side of the surface is not answered: see
//! [`LaneSample::doubtful`].

use super::{Conductor, Fresnel, Lambert, Surface};
use crate::geometry::lanes::tangents;
use crate::sampling::lanes::{circle, cosine_hemisphere};
use crate::spectrum::Spectrum;
use etendue_lanes::{Float, ROW, Vec3};
use std::f32::consts::{FRAC_1_PI, PI};

/// Parameters of a surface as a row of a table, and the model that they belong to.
#[derive(Debug, Clone, Copy)]
pub struct SurfaceRow {
    /// The model.
    pub model: LaneModel,
    /// Its parameters, as [`LaneScatter::of`] reads them.
    pub parameters: [f32; ROW],
}

/// Models that have a kernel.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum LaneModel {
    /// See [`LaneLambert`].
    Lambert,
    /// See [`LaneConductor`].
    Conductor,
}

impl SurfaceRow {
    /// Returns the row of `surface`; `None` if its model has no kernel.
    pub fn new(surface: &Surface) -> Option<Self> {
        match surface {
            Surface::Lambert(Lambert { albedo: Spectrum([r, g, b]) }) => {
                Some(SurfaceRow { model: LaneModel::Lambert, parameters: [*r, *g, *b, 0.0, 0.0, 0.0, 0.0, 0.0] })
            }
            Surface::Conductor(Conductor { ggx, fresnel: Fresnel::Schlick { f0, f90 } }) if !ggx.is_dirac() => {
                let ([a, b, c], [d, e, f]) = (f0.0, f90.0);
                Some(SurfaceRow { model: LaneModel::Conductor, parameters: [a, b, c, d, e, f, ggx.alpha(), 0.0] })
            }
            _ => None,
        }
    }
}

/// Surface points at which light leaves along `known`, a unit direction away from the surface.
#[derive(Debug, Clone, Copy)]
pub struct LanePoint<F> {
    /// Geometric normal, which is also the shading normal.
    pub n: Vec3<F>,
    /// Tangents, which make a frame with `n`.
    tangents: [Vec3<F>; 2],
    /// The known direction in the frame.
    known: Vec3<F>,
}

/// Value and density of a direction.
#[derive(Debug, Clone, Copy)]
pub struct LaneScattering<F: Float> {
    /// F |cos|.
    pub f_cos: Spectrum<F>,
    /// Density under sampling.
    pub pdf: F,
    /// Lanes in which anything is scattered.
    pub valid: F::Mask,
}

/// A sampled direction.
#[derive(Debug, Clone, Copy)]
pub struct LaneSample<F: Float> {
    /// Unit direction away from the surface.
    pub direction: Vec3<F>,
    /// F |cos| over the density.
    pub weight: Spectrum<F>,
    /// Density of the direction.
    pub pdf: F,
    /// Lanes in which a direction was found.
    pub valid: F::Mask,
    /// Lanes in which the direction lies on the wrong side of the surface after rounding, so that its mirror image
    /// counts. Their other fields mean nothing.
    pub doubtful: F::Mask,
}

impl<F: Float> LanePoint<F> {
    /// Returns the points with normals `n` and known directions `wo`.
    #[inline(always)]
    pub fn new(n: Vec3<F>, wo: Vec3<F>) -> Self {
        let tangents = tangents(n);
        LanePoint { n, tangents, known: local(n, tangents, wo) }
    }

    /// Returns the lanes in which light may leave along the known direction: it is not in the plane of the surface.
    #[inline(always)]
    pub fn scatters(&self) -> F::Mask {
        (self.known.z * self.known.z).above(F::splat(0.0))
    }

    /// Returns the direction along the known side whose local coordinates are `w`.
    #[inline(always)]
    fn world(&self, w: Vec3<F>) -> Vec3<F> {
        let [s, t] = self.tangents;
        s * w.x + t * w.y + self.n * w.z
    }
}

#[inline(always)]
fn local<F: Float>(n: Vec3<F>, [s, t]: [Vec3<F>; 2], w: Vec3<F>) -> Vec3<F> {
    Vec3::new(w.dot(s), w.dot(t), w.dot(n))
}

/// A model with parameters in lanes.
pub trait LaneScatter<F: Float>: Copy {
    /// Returns the surfaces with these parameters, columns of [`SurfaceRow::parameters`].
    fn of(parameters: [F; ROW]) -> Self;
    /// Returns value and density of the direction `other` on the side of the known one; both are local.
    fn eval_and_pdf(&self, known: Vec3<F>, other: Vec3<F>) -> (Spectrum<F>, F);
    /// Samples a local direction. Returns it with value and density, and the lanes in which there is one.
    fn sample(&self, known: Vec3<F>, u: [F; 2]) -> (Vec3<F>, Spectrum<F>, F, F::Mask);

    /// See [`super::Shading::scattering`].
    #[inline(always)]
    fn scattering(&self, point: &LanePoint<F>, wi: Vec3<F>) -> LaneScattering<F> {
        let other = local(point.n, point.tangents, wi);
        let (f, pdf) = self.eval_and_pdf(point.known, other);
        let f_cos = f * other.z.abs();
        let zero = F::splat(0.0);
        let same = (point.known.z * other.z).above(zero) & (other.z * other.z).above(zero);
        LaneScattering { f_cos, pdf, valid: same & f_cos.is_lit() }
    }

    /// See [`super::Shading::sample`].
    #[inline(always)]
    fn sampled(&self, point: &LanePoint<F>, u: [F; 2]) -> LaneSample<F> {
        let (w, value, pdf, valid) = self.sample(point.known, u);
        let direction = point.world(w);
        let zero = F::splat(0.0);
        let (cos, slant) = (direction.dot(point.n), point.n.dot(point.n));
        let twin = (w.z - F::splat(2.0) * cos * slant) * cos;
        let doubtful = !(cos * w.z).above(zero) | twin.above(zero);
        LaneSample { direction, weight: value * (w.z.abs() / pdf), pdf, valid, doubtful: valid & doubtful }
    }
}

/// [`Lambert`] over lanes.
#[derive(Debug, Clone, Copy)]
pub struct LaneLambert<F> {
    albedo: Spectrum<F>,
}

impl<F: Float> LaneScatter<F> for LaneLambert<F> {
    #[inline(always)]
    fn of([r, g, b, ..]: [F; ROW]) -> Self {
        LaneLambert { albedo: Spectrum([r, g, b]) }
    }

    #[inline(always)]
    fn eval_and_pdf(&self, _: Vec3<F>, other: Vec3<F>) -> (Spectrum<F>, F) {
        (self.albedo * F::splat(FRAC_1_PI), other.z.abs() * F::splat(FRAC_1_PI))
    }

    #[inline(always)]
    fn sample(&self, known: Vec3<F>, u: [F; 2]) -> (Vec3<F>, Spectrum<F>, F, F::Mask) {
        let w = cosine_hemisphere(u);
        let w = Vec3::new(w.x, w.y, w.z.copysign(known.z));
        let (value, pdf) = self.eval_and_pdf(known, w);
        (w, value, pdf, (known.z * w.z).above(F::splat(0.0)) & pdf.above(F::splat(0.0)))
    }
}

/// [`Conductor`] over lanes, rough and with Schlick's Fresnel.
#[derive(Debug, Clone, Copy)]
pub struct LaneConductor<F> {
    f0: Spectrum<F>,
    f90: Spectrum<F>,
    alpha: F,
}

impl<F: Float> LaneConductor<F> {
    /// See [`super::ggx`]: D(h), Smith's root of two directions, reflection and its density.
    #[inline(always)]
    fn d(&self, h: Vec3<F>) -> F {
        let a2 = self.alpha * self.alpha;
        let k = h.z * h.z + sin2(h) / a2;
        (F::splat(PI) * a2 * (k * k)).recip()
    }

    #[inline(always)]
    fn root(&self, w: Vec3<F>) -> F {
        (w.z * w.z + self.alpha * self.alpha * sin2(w)).sqrt()
    }

    /// Returns value and density of `other` for light that leaves along `known`, by facets of normal `h`, which makes
    /// the cosine `cos` with the light.
    #[inline(always)]
    fn reflected(&self, known: Vec3<F>, other: Vec3<F>, h: Vec3<F>, cos: F) -> (Spectrum<F>, F) {
        let (d, root) = (self.d(h), self.root(known));
        let masking = known.z.abs() * self.root(other) + other.z.abs() * root;
        let pdf = F::splat(0.25) * (F::splat(2.0) / (known.z.abs() + root)) * d;
        (self.fresnel(cos) * (d / (F::splat(2.0) * masking)), pdf)
    }

    #[inline(always)]
    fn fresnel(&self, cos: F) -> Spectrum<F> {
        let one = F::splat(1.0);
        let m = (one - cos).max(F::splat(0.0));
        let weight = (m * m) * (m * m) * m;
        self.f0 * (one - weight) + self.f90 * weight
    }

    #[inline(always)]
    fn stretched(&self, w: Vec3<F>) -> Vec3<F> {
        Vec3::new(self.alpha * w.x, self.alpha * w.y, w.z).normalize()
    }
}

#[inline(always)]
fn sin2<F: Float>(w: Vec3<F>) -> F {
    w.x * w.x + w.y * w.y
}

impl<F: Float> LaneScatter<F> for LaneConductor<F> {
    #[inline(always)]
    fn of([r, g, b, r90, g90, b90, alpha, _]: [F; ROW]) -> Self {
        LaneConductor { f0: Spectrum([r, g, b]), f90: Spectrum([r90, g90, b90]), alpha }
    }

    #[inline(always)]
    fn eval_and_pdf(&self, known: Vec3<F>, other: Vec3<F>) -> (Spectrum<F>, F) {
        let h = (other + known).normalize();
        self.reflected(known, other, h, other.dot(h))
    }

    /// See [`super::Ggx::cap_normal`].
    #[inline(always)]
    fn sample(&self, known: Vec3<F>, [u, v]: [F; 2]) -> (Vec3<F>, Spectrum<F>, F, F::Mask) {
        let (zero, one) = (F::splat(0.0), F::splat(1.0));
        let above = Vec3::new(known.x, known.y, known.z.abs());
        let view = self.stretched(above);
        let top = one + view.z;
        let z = (one - v) * top;
        let sine = (top * v * (sin2(view) / top + z)).max(zero).sqrt();
        let [cos, sin] = circle(u);
        let h = Vec3::new(self.alpha * (sine * cos + view.x), self.alpha * (sine * sin + view.y), z).normalize();
        let other = h * (F::splat(2.0) * above.dot(h)) + -above;
        let (value, pdf) = self.reflected(above, other, h, above.dot(h));
        let valid = (above.z * other.z).above(zero);
        (Vec3::new(other.x, other.y, F::select(known.z.below(zero), -other.z, other.z)), value, pdf, valid)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::bsdf::{Ggx, Shading};
    use crate::geometry::{Frame, Hit, SurfacePoint};
    use crate::sampling::{Address, IndependentSampler, Sampler, Slot};
    use crate::transport::TransportMode;
    use etendue_lanes::{Array, Mask, Native};

    const POINTS: usize = 4096;

    /// Directions, normals and numbers of `POINTS` scattering events; a sixteenth of the known directions grazes.
    struct Events {
        normals: Vec<glam::Vec3>,
        known: Vec<glam::Vec3>,
        others: Vec<glam::Vec3>,
        numbers: Vec<[f32; 2]>,
    }

    impl Events {
        fn new() -> Self {
            let mut sampler = IndependentSampler::new(Address::new(3));
            let mut direction = |i: usize, slot| -> glam::Vec3 {
                crate::sampling::lanes::uniform_sphere(sampler.u2(i as u32, slot)).into()
            };
            let normals: Vec<_> = (0..POINTS).map(|i| direction(i, Slot::Film)).collect();
            let others = (0..POINTS).map(|i| direction(i, Slot::Direction)).collect();
            let known = (0..POINTS).map(|i| {
                let (w, n) = (direction(i, Slot::LightPoint), normals[i]);
                if i % 16 == 0 { (w - n * (w.dot(n) * 0.999_999)).normalize() } else { w }
            });
            let known = known.collect();
            let numbers = (0..POINTS).map(|i| sampler.u2(i as u32, Slot::Lens)).collect();
            Events { normals, known, others, numbers }
        }

        fn point(&self, i: usize) -> SurfacePoint {
            let ng = self.normals[i];
            SurfacePoint {
                p: glam::Vec3::ZERO,
                error: 0.0,
                ng,
                frame: Frame::around(ng),
                barycentric: [0.0; 2],
                hit: Hit { object: 0, primitive: 0 },
                t: 1.0,
                touching: false,
                consistent: true,
            }
        }
    }

    fn vectors<F: Float>(of: &[glam::Vec3], at: usize) -> Vec3<F> {
        let column = |axis: usize| F::from_fn(|lane| of[at + lane][axis]);
        Vec3::new(column(0), column(1), column(2))
    }

    fn bits(v: [f32; 3]) -> [u32; 3] {
        v.map(f32::to_bits)
    }

    /// Compares every lane with [`Shading`]; returns the number of doubtful ones.
    fn compare<F: Float, M: LaneScatter<F>>(events: &Events, surface: &Surface) -> usize {
        let row = SurfaceRow::new(surface).expect("a model with a kernel");
        let model = M::of(F::rows(|_| &row.parameters));
        let mut doubtful = 0;
        for at in (0..POINTS).step_by(F::LANES) {
            let point = LanePoint::<F>::new(vectors(&events.normals, at), vectors(&events.known, at));
            let scattering = model.scattering(&point, vectors(&events.others, at));
            let numbers = [0, 1].map(|k| F::from_fn(|lane| events.numbers[at + lane][k]));
            let sample = model.sampled(&point, numbers);
            doubtful += (sample.doubtful & point.scatters()).bits().count_ones() as usize;
            for lane in 0..F::LANES {
                let i = at + lane;
                let set = |mask: F::Mask| mask.bits() >> lane & 1 == 1;
                let surface_point = events.point(i);
                let shading = Shading::new(&surface_point, surface, events.known[i], TransportMode::Radiance);
                assert_eq!(shading.is_some(), set(point.scatters()), "event {i}");
                let Some(shading) = shading else { continue };
                let want = shading.scattering(events.others[i]);
                assert_eq!(want.is_some(), set(scattering.valid), "event {i}");
                if let Some(want) = want {
                    assert_eq!(bits(want.f_cos.0), bits(scattering.f_cos.lane(lane).0), "event {i}");
                    assert_eq!(want.pdf.value().to_bits(), scattering.pdf.lane(lane).to_bits(), "event {i}");
                }
                if set(sample.doubtful) {
                    continue;
                }
                let want = shading.sample([0.0, events.numbers[i][0], events.numbers[i][1]]);
                assert_eq!(want.is_some(), set(sample.valid), "event {i}");
                if let Some(want) = want {
                    assert_eq!(bits(want.direction.to_array()), bits(sample.direction.lane(lane)), "event {i}");
                    assert_eq!(bits(want.weight.0), bits(sample.weight.lane(lane).0), "event {i}");
                    assert_eq!(want.density.value().to_bits(), sample.pdf.lane(lane).to_bits(), "event {i}");
                }
            }
        }
        doubtful
    }

    /// Every family, Lambert and metals of several roughnesses. Few lanes may be left to the other code.
    #[test]
    fn lanes_scatter_as_shading_does() {
        let events = Events::new();
        let lambert = Surface::Lambert(Lambert { albedo: Spectrum([0.8, 0.3, 0.0]) });
        let metal = |alpha: f32| {
            let (f0, f90) = (Spectrum([0.9, 0.5, 0.2]), Spectrum::ONE);
            Surface::Conductor(Conductor { ggx: Ggx::new(alpha), fresnel: Fresnel::Schlick { f0, f90 } })
        };
        let mut doubtful = Vec::new();
        doubtful.push(compare::<f32, LaneLambert<f32>>(&events, &lambert));
        doubtful.push(compare::<Native, LaneLambert<Native>>(&events, &lambert));
        doubtful.push(compare::<Array<4>, LaneLambert<Array<4>>>(&events, &lambert));
        for alpha in [4e-5, 0.01, 0.25, 1.0] {
            doubtful.push(compare::<f32, LaneConductor<f32>>(&events, &metal(alpha)));
            doubtful.push(compare::<Native, LaneConductor<Native>>(&events, &metal(alpha)));
            doubtful.push(compare::<Array<4>, LaneConductor<Array<4>>>(&events, &metal(alpha)));
        }
        assert!(doubtful.iter().all(|&count| count < POINTS / 100), "{doubtful:?}");
    }

    #[test]
    fn models_without_a_kernel_have_no_row() {
        let mirror =
            Conductor { ggx: Ggx::new(0.0), fresnel: Fresnel::Schlick { f0: Spectrum::ONE, f90: Spectrum::ONE } };
        let exact = Conductor { ggx: Ggx::new(0.5), fresnel: Fresnel::Dielectric { eta: 1.5 } };
        for surface in [Surface::Black, Surface::Conductor(mirror), Surface::Conductor(exact)] {
            assert!(SurfaceRow::new(&surface).is_none());
        }
    }
}
