//! Light samples over lanes: by kernels where all lights are of one kind that has one, else light by light.

use crate::geometry::Hit;
use crate::geometry::lanes::offset;
use crate::light::{
    AreaLightRow, AreaLightSamples, ConstantEnvironment, EmitterPoint, Environment, Light, LightSample,
    LightSampleContext, Lights,
};
use crate::numeric::BELOW_ONE;
use crate::sampling::Density;
use crate::sampling::lanes::uniform_sphere;
use crate::spectrum::Spectrum;
use etendue_lanes::{Float, Int, MOST_LANES, Mask, Vec3, for_each_bit};

/// The lights of a scene, as kernels want them.
pub(super) enum LightRows {
    /// Triangles of constant emission from their front alone.
    Areas(Vec<AreaLightRow>),
    /// A uniform sky alone.
    Sky(ConstantEnvironment),
    /// Any others.
    Any,
}

impl LightRows {
    pub(super) fn new(lights: &Lights) -> Self {
        let rows = lights.all().iter().map(|light| match light {
            Light::Area(area) => area.row(),
            _ => None,
        });
        match (lights.all(), rows.collect::<Option<Vec<_>>>()) {
            ([Light::Environment(Environment::Uniform(sky))], _) => LightRows::Sky(*sky),
            (_, Some(rows)) => LightRows::Areas(rows),
            _ => LightRows::Any,
        }
    }
}

/// A light sample for each lane.
pub(super) struct LightSamples<F: Float> {
    /// Unit direction from the receiver to the light.
    pub(super) wi: Vec3<F>,
    /// See [`LightSample::radiance`].
    pub(super) radiance: Spectrum<F>,
    /// Density of the direction, or probability of the light if it has no extent, with the selection of the light.
    pub(super) density: F,
    /// Lanes with a light without extent.
    pub(super) dirac: F::Mask,
    /// Lanes with a sample.
    pub(super) valid: F::Mask,
    end: End<F>,
}

/// Where shadow rays end.
enum End<F: Float> {
    /// On triangles.
    Surface { p: Vec3<F>, error: F, ng: Vec3<F> },
    /// At infinity.
    Distant,
    /// Either, or in space where the error is 0.
    Any { p: Vec3<F>, error: F, ng: Vec3<F>, distant: F::Mask },
}

/// A shadow ray for each lane.
pub(super) struct ShadowRays<F> {
    pub(super) origin: Vec3<F>,
    pub(super) direction: Vec3<F>,
    pub(super) t_max: F,
}

impl<F: Float> LightSamples<F> {
    /// Samples a light for the receivers at `p` with normals `ng` in the lanes of `wanted`, with the numbers `pick` and
    /// `u`.
    #[inline(always)]
    pub(super) fn new(
        lights: &Lights,
        rows: &LightRows,
        [p, ng]: [Vec3<F>; 2],
        wanted: F::Mask,
        (pick, u): (F, [F; 2]),
    ) -> Self {
        match rows {
            LightRows::Areas(rows) => Self::of_areas(lights, rows, p, pick, u),
            LightRows::Sky(sky) => Self::of_sky(lights, *sky, pick, u),
            LightRows::Any => Self::of_any(lights, [p, ng], wanted, pick, u),
        }
    }

    #[inline(always)]
    fn of_areas(lights: &Lights, rows: &[AreaLightRow], p: Vec3<F>, pick: F, u: [F; 2]) -> Self {
        let Some((index, pmf)) = lights.choose_lanes(pick) else { return Self::none() };
        let sample = AreaLightSamples::new(|lane| &rows[index.lane(lane) as usize], p, u);
        LightSamples {
            wi: sample.wi,
            radiance: sample.radiance,
            density: sample.pdf * pmf,
            dirac: F::first(0),
            valid: sample.valid,
            end: End::Surface { p: sample.p, error: sample.error, ng: sample.ng },
        }
    }

    #[inline(always)]
    fn of_sky(lights: &Lights, sky: ConstantEnvironment, pick: F, u: [F; 2]) -> Self {
        let Some((_, pmf)) = lights.choose_lanes(pick) else { return Self::none() };
        LightSamples {
            wi: uniform_sphere(u),
            radiance: Spectrum::in_lanes(sky.radiance),
            density: F::splat(sky.pdf().value()) * pmf,
            dirac: F::first(0),
            valid: F::first(F::LANES),
            end: End::Distant,
        }
    }

    /// Asks the lights one by one.
    fn of_any(lights: &Lights, [p, ng]: [Vec3<F>; 2], wanted: F::Mask, pick: F, u: [F; 2]) -> Self {
        let mut samples = [None; MOST_LANES];
        for_each_bit(wanted.bits(), |lane| {
            let at = LightSampleContext { p: p.lane(lane).into(), ng: ng.lane(lane).into() };
            samples[lane] = one(lights, &at, pick.lane(lane), u.map(|u| u.lane(lane)));
        });
        let column = |of: &dyn Fn(&Sampled) -> f32| F::from_fn(|lane| samples[lane].as_ref().map_or(0.0, of));
        let vector = |of: &dyn Fn(&Sampled) -> glam::Vec3| {
            Vec3::from_array([0, 1, 2].map(|axis| column(&|sample| of(sample)[axis])))
        };
        let mask = |of: &dyn Fn(&Sampled) -> bool| {
            let bits =
                (0..F::LANES).fold(0, |bits, lane| bits | u32::from(samples[lane].as_ref().is_some_and(of)) << lane);
            F::Mask::from_bits(bits)
        };
        LightSamples {
            wi: vector(&|s| s.sample.wi),
            radiance: Spectrum([0, 1, 2].map(|k| column(&|s| s.sample.radiance[k]))),
            density: column(&|s| s.density),
            dirac: mask(&|s| s.sample.density.is_delta()),
            valid: mask(&|_| true),
            end: End::Any {
                p: vector(&|s| s.end.0),
                error: column(&|s| s.end.1),
                ng: vector(&|s| s.end.2),
                distant: mask(&|s| matches!(s.sample.end, EmitterPoint::Distant)),
            },
        }
    }

    fn none() -> Self {
        let zero = F::splat(0.0);
        let nowhere = Vec3::new(zero, zero, zero);
        let none = F::first(0);
        LightSamples {
            wi: nowhere,
            radiance: Spectrum::splat(zero),
            density: zero,
            dirac: none,
            valid: none,
            end: End::Distant,
        }
    }

    /// Returns the shadow rays from the receivers at `p`, known within `error`, with normals `ng`.
    #[inline(always)]
    pub(super) fn rays(&self, p: Vec3<F>, error: F, ng: Vec3<F>) -> ShadowRays<F> {
        let (below_one, infinity) = (F::splat(BELOW_ONE), F::splat(f32::INFINITY));
        match self.end {
            End::Surface { p: to, error: to_error, ng: to_ng } => {
                let [origin, direction] = crate::geometry::lanes::segment([p, ng], error, [to, to_ng], to_error);
                ShadowRays { origin, direction, t_max: below_one }
            }
            End::Distant => ShadowRays { origin: offset(p, error, ng, self.wi), direction: self.wi, t_max: infinity },
            End::Any { p: to, error: to_error, ng: to_ng, distant } => {
                let [origin, on_surface] = crate::geometry::lanes::segment([p, ng], error, [to, to_ng], to_error);
                let near = Vec3::select(to_error.above(F::splat(0.0)), on_surface, to - origin);
                ShadowRays {
                    origin: Vec3::select(distant, offset(p, error, ng, self.wi), origin),
                    direction: Vec3::select(distant, self.wi, near),
                    t_max: F::select(distant, infinity, below_one),
                }
            }
        }
    }
}

/// A light sample with its density and end as [`LightSamples`] has them.
#[derive(Clone, Copy)]
struct Sampled {
    sample: LightSample,
    density: f32,
    end: (glam::Vec3, f32, glam::Vec3),
}

/// Samples a light for one receiver.
fn one(lights: &Lights, at: &LightSampleContext, pick: f32, u: [f32; 2]) -> Option<Sampled> {
    let (index, pmf) = lights.choose(at, pick)?;
    let sample = lights.all()[index].sample_li(at, u)?;
    let density = match sample.density {
        Density::Delta(probability) => pmf.value() * probability,
        Density::Smooth(pdf) => pdf.choose(pmf).value(),
    };
    let end = match sample.end {
        EmitterPoint::Surface { p, error, ng, touched } => {
            debug_assert_eq!(touched, Hit::NONE, "batches know no contacts");
            (p, error, ng)
        }
        EmitterPoint::Point(p) => (p, 0.0, at.ng),
        EmitterPoint::Distant => (at.p, 0.0, at.ng),
    };
    Some(Sampled { sample, density, end })
}
