//! Light samples over lanes: by the kernels of the lights' kinds, and light by light for those without one.

use super::points::in_lanes;
use crate::geometry::Hit;
use crate::geometry::lanes::offset;
use crate::light::{
    AreaLightRow, AreaLightSamples, EmitterPoint, EnvironmentSamples, Light, LightSample, LightSampleContext, Lights,
};
use crate::numeric::BELOW_ONE;
use crate::spectrum::Spectrum;
use etendue_lanes::{Float, Int, MOST_LANES, Mask, Vec3, for_each_bit};

/// The lights of a scene, as kernels want them.
pub(super) struct LightRows {
    /// Kinds of all lights.
    kinds: Vec<Kind>,
    /// The kind, if there is no other.
    only: Option<Kind>,
    /// Rows of the lights that have them.
    areas: Vec<AreaLightRow>,
}

/// What samples a light.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Kind {
    /// The kernel of triangles of constant emission from their front.
    Area,
    /// The kernel of the environment.
    Environment,
    /// The code of single paths.
    Single,
}

impl LightRows {
    pub(super) fn new(lights: &Lights) -> Self {
        let (kinds, areas): (Vec<Kind>, Vec<AreaLightRow>) = lights.all().iter().map(row).unzip();
        let only = kinds.first().copied().filter(|first| kinds.iter().all(|kind| kind == first));
        LightRows { kinds, only, areas }
    }
}

fn row(light: &Light) -> (Kind, AreaLightRow) {
    let area = if let Light::Area(area) = light { area.row() } else { None };
    match (light, area) {
        (_, Some(row)) => (Kind::Area, row),
        (Light::Environment(_), _) => (Kind::Environment, AreaLightRow::default()),
        _ => (Kind::Single, AreaLightRow::default()),
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
    /// Samples the lights of [`Lights::choose_lanes`] for the receivers at `p` with normals `ng` in the lanes of `wanted`.
    #[inline(always)]
    pub(super) fn new(
        (lights, rows): (&Lights, &LightRows),
        [p, ng]: [Vec3<F>; 2],
        wanted: F::Mask,
        chosen: Option<(F::Int, F, [F; 2])>,
    ) -> Self {
        let Some((index, pmf, u)) = chosen else { return Self::none() };
        let mut samples = match rows.only {
            Some(Kind::Area) => Self::of_areas(&rows.areas, index, F::first(F::LANES).bits(), p, u),
            Some(Kind::Environment) => Self::of_environment(lights, u),
            Some(Kind::Single) => Self::of_any(lights, index, [p, ng], wanted, u),
            None => Self::of_several((lights, rows), index, [p, ng], wanted, u),
        };
        samples.density = samples.density * pmf;
        samples.valid = samples.valid & pmf.above(F::splat(0.0));
        samples
    }

    #[inline(always)]
    fn of_areas(rows: &[AreaLightRow], index: F::Int, lanes: u32, p: Vec3<F>, u: [F; 2]) -> Self {
        let rows = in_lanes(lanes, |lane| &rows[index.lane(lane) as usize]);
        let sample = AreaLightSamples::new(|lane| rows[lane], p, u);
        LightSamples {
            wi: sample.wi,
            radiance: sample.radiance,
            density: sample.pdf,
            dirac: F::first(0),
            valid: sample.valid,
            end: End::Surface { p: sample.p, error: sample.error, ng: sample.ng },
        }
    }

    #[inline(always)]
    fn of_environment(lights: &Lights, u: [F; 2]) -> Self {
        let Some((_, environment)) = lights.environment() else { return Self::none() };
        let EnvironmentSamples { wi, radiance, pdf, valid } = environment.sample_lanes(u);
        LightSamples { wi, radiance, density: pdf, dirac: F::first(0), valid, end: End::Distant }
    }

    /// Samples lights of several kinds, each by its kernel.
    #[inline(never)]
    fn of_several(
        (lights, rows): (&Lights, &LightRows),
        index: F::Int,
        at: [Vec3<F>; 2],
        wanted: F::Mask,
        u: [F; 2],
    ) -> Self {
        let mut lanes = [0; 3];
        for_each_bit(wanted.bits(), |lane| lanes[rows.kinds[index.lane(lane) as usize] as usize] |= 1 << lane);
        let [areas, environment, single] = lanes;
        let mut all = Self::none();
        if single != 0 {
            all = Self::of_any(lights, index, at, F::Mask::from_bits(single), u);
        }
        if areas != 0 {
            all = all.merged(F::Mask::from_bits(areas), Self::of_areas(&rows.areas, index, areas, at[0], u));
        }
        if environment != 0 {
            all = all.merged(F::Mask::from_bits(environment), Self::of_environment(lights, u));
        }
        all
    }

    /// Returns `other` in the lanes of `mask`, else these.
    #[inline(always)]
    fn merged(self, mask: F::Mask, other: Self) -> Self {
        let ((p, error, ng, distant), other_end) = (self.end.parts(), other.end.parts());
        LightSamples {
            wi: Vec3::select(mask, other.wi, self.wi),
            radiance: Spectrum::select(mask, other.radiance, self.radiance),
            density: F::select(mask, other.density, self.density),
            dirac: mask.select(other.dirac, self.dirac),
            valid: mask.select(other.valid, self.valid),
            end: End::Any {
                p: Vec3::select(mask, other_end.0, p),
                error: F::select(mask, other_end.1, error),
                ng: Vec3::select(mask, other_end.2, ng),
                distant: mask.select(other_end.3, distant),
            },
        }
    }

    /// Asks the lights number `index` one by one.
    fn of_any(lights: &Lights, index: F::Int, [p, ng]: [Vec3<F>; 2], wanted: F::Mask, u: [F; 2]) -> Self {
        let mut samples = [None; MOST_LANES];
        for_each_bit(wanted.bits(), |lane| {
            let at = LightSampleContext::new(p.lane(lane).into(), ng.lane(lane).into());
            let light = &lights.all()[index.lane(lane) as usize];
            samples[lane] = one(light, &at, u.map(|u| u.lane(lane)));
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
            density: column(&|s| s.sample.density.value()),
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

impl<F: Float> End<F> {
    /// Returns points, errors, normals and the lanes at infinity, as [`End::Any`] has them.
    #[inline(always)]
    fn parts(self) -> (Vec3<F>, F, Vec3<F>, F::Mask) {
        let zero = F::splat(0.0);
        let nothing = Vec3::new(zero, zero, zero);
        match self {
            End::Surface { p, error, ng } => (p, error, ng, F::first(0)),
            End::Distant => (nothing, zero, nothing, F::first(F::LANES)),
            End::Any { p, error, ng, distant } => (p, error, ng, distant),
        }
    }
}

/// A light sample with its end as [`End::Any`] has it.
#[derive(Clone, Copy)]
struct Sampled {
    sample: LightSample,
    end: (glam::Vec3, f32, glam::Vec3),
}

/// Samples `light` for one receiver.
fn one(light: &Light, at: &LightSampleContext, u: [f32; 2]) -> Option<Sampled> {
    let sample = light.sample_li(at, u)?;
    let end = match sample.end {
        EmitterPoint::Surface { p, error, ng, touched } => {
            debug_assert_eq!(touched, Hit::NONE, "batches know no contacts");
            (p, error, ng)
        }
        EmitterPoint::Point(p) => (p, 0.0, at.ng),
        EmitterPoint::Distant => (at.p, 0.0, at.ng),
    };
    Some(Sampled { sample, end })
}
