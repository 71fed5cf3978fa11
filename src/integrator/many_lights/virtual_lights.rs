//! Virtual point lights: the vertices of light subpaths, which all pixels of a pass share [Keller97], and points on the
//! lights of the scene.

use crate::bsdf::{Bsdf, Lobes, ScatteringBound, Shading, Surface};
use crate::camera::Camera;
use crate::geometry::{Bounds, Local, SurfacePoint};
use crate::integrator::samples::PassNumbers;
use crate::light::{Cone, EmitterPoint, LeRandom, Light, LightSampleContext, LightTree, Reach};
use crate::medium::Phase;
use crate::parallel::Cancel;
use crate::path::{
    Arrival, Emitter, MisStrategy, PhaseAt, Scatterer, Subpath, SubpathVertex, SurfaceVertex, Techniques, TraceStats,
    Vertex,
};
use crate::sampling::{Heuristic, Sampler, Slot};
use crate::scene::Scene;
use crate::spectrum::{LANES, Spectrum};
use crate::transport::TransportMode;
use glam::Vec3;
use rayon::prelude::*;
use std::borrow::Cow;
use std::f32::consts::FRAC_1_PI;
use std::f64::consts::{FRAC_PI_2, PI};

/// Light subpaths per task.
const CHUNK: usize = 64;

/// Reflectance that is added to that of a surface in the estimate of its intensity, for lobes that it does not cover.
const LEAST_REFLECTANCE: f32 = 0.04;

/// A point from which light leaves.
pub(super) struct VirtualLight<'a> {
    pub(super) p: Vec3,
    pub(super) end: EmitterPoint,
    source: Source<'a>,
    /// Factor of [`VirtualLight::leaving`].
    pub(super) flux: Spectrum,
    /// Number of scattering events of a path to here, including one at this point.
    pub(super) events: u32,
    /// See [`peak`].
    pub(super) peak: f32,
}

/// What sends the light.
#[allow(clippy::large_enum_variant)] // nearly all are vertices on surfaces
enum Source<'a> {
    /// A surface, which scatters light from the unit direction `known`.
    Scattering { point: SurfacePoint, surface: Cow<'a, Surface>, known: Vec3 },
    /// A point on an emitting surface.
    Emitting { ng: Vec3, two_sided: bool },
    /// A light without extent.
    Point(&'a Light),
    /// A medium, which scatters light from a direction.
    Medium(PhaseAt),
}

/// A measure of the highest value of the BSDF of `surface`, whatever the directions: its value for light that arrives
/// and leaves along the normal. [`VirtualLight`]s of peaked lobes count for little and paths by these for much.
pub(super) fn peak(surface: &Surface) -> f32 {
    let normal = Local::new(0.0, 0.0, 1.0);
    let value = |wo: Local| surface.eval(normal, wo, Lobes::SMOOTH).max_lane();
    value(normal).max(value(Local::new(0.0, 0.0, -1.0)))
}

/// The same for a phase function, whose peak is ahead or back.
pub(super) fn peak_in_medium(phase: &Phase) -> f32 {
    phase.eval(Vec3::X, Vec3::NEG_X).max(phase.eval(Vec3::X, Vec3::X))
}

/// The same for emission.
pub(super) const EMITTING_PEAK: f32 = FRAC_1_PI;

impl VirtualLight<'_> {
    /// Returns F |cos| of the light that leaves along the unit direction `w`, or its like for emission; `None` if there
    /// is none.
    pub(super) fn leaving(&self, w: Vec3, at: &LightSampleContext) -> Option<Spectrum> {
        match &self.source {
            Source::Scattering { point, surface, known } => {
                let shading = &Shading::new(point, surface, *known, TransportMode::Importance)?;
                shading.scattering(w).map(|scattering| scattering.f_cos)
            }
            Source::Emitting { ng, two_sided } => {
                let cos = w.dot(*ng);
                let cos = if *two_sided { cos.abs() } else { cos };
                (cos > 0.0).then(|| Spectrum::splat(cos * FRAC_1_PI))
            }
            Source::Point(light) => {
                let sample = light.sample_li(at, [0.5; 2])?;
                Some(sample.radiance * self.p.distance_squared(at.p))
            }
            Source::Medium(phase) => Some(phase.scattering(w).f_cos),
        }
    }

    /// Returns the cosine of the unit direction `w` to the normal, 1 in media; 0 for lights without extent, which have no
    /// limit.
    #[inline]
    pub(super) fn cos(&self, w: Vec3) -> f32 {
        match &self.source {
            Source::Scattering { point, .. } => point.cos(w),
            Source::Emitting { ng, .. } => ng.dot(w).abs(),
            Source::Point(_) => 0.0,
            Source::Medium(_) => 1.0,
        }
    }

    /// Returns upper bounds of what leaves it, over all directions: of the light, and of the light over the cosine and
    /// [`VirtualLight::peak`].
    pub(super) fn most(&self) -> [f64; 2] {
        let flux = f64::from(self.flux.max_lane());
        let [leaving, per_cos] = match &self.source {
            Source::Scattering { point, surface, known } => match bound(point, surface, *known) {
                ScatteringBound { diffuse, glossy: 0.0 } => [diffuse, diffuse / self.peak],
                ScatteringBound { diffuse, glossy } => [diffuse + glossy, f32::INFINITY],
            },
            Source::Emitting { .. } => [FRAC_1_PI, FRAC_1_PI / self.peak],
            // The intensity is the mean over lanes.
            Source::Point(light) => {
                [LANES as f32 * light.reach().map_or(0.0, |reach| reach.intensity as f32), f32::INFINITY]
            }
            Source::Medium(_) => [self.peak, 1.0],
        };
        [leaving, per_cos].map(|most| if flux > 0.0 { f64::from(most) * flux } else { 0.0 })
    }

    /// Returns where it shines, for the light tree.
    pub(super) fn reach(&self) -> Option<Reach> {
        let (side, spread, two_sided, reflectance) = match &self.source {
            Source::Scattering { point, surface, known } => {
                let side = if point.ng.dot(*known) < 0.0 { -point.ng } else { point.ng };
                let reflectance = surface.reflectance() + Spectrum::splat(LEAST_REFLECTANCE);
                (side, FRAC_PI_2, surface.lobes().intersects(Lobes::TRANSMIT), reflectance)
            }
            Source::Emitting { ng, two_sided } => (*ng, FRAC_PI_2, *two_sided, Spectrum::ONE),
            Source::Point(light) => return light.reach(),
            Source::Medium(_) => {
                let intensity = f64::from(self.flux.mean()) / (4.0 * PI);
                let bounds = Bounds::around([self.p]);
                let reach = Reach { bounds, normals: Cone::ALL, spread: PI, two_sided: false, intensity };
                return (intensity > 0.0).then_some(reach);
            }
        };
        let intensity = f64::from((self.flux * reflectance).mean()) / PI;
        let (bounds, normals) = (Bounds::around([self.p]), Cone { axis: side.as_dvec3(), angle: 0.0 });
        (intensity > 0.0).then_some(Reach { bounds, normals, spread, two_sided, intensity })
    }
}

/// Returns a bound of the light that `scatterer` scatters.
pub(super) fn bound_of(scatterer: &Scatterer) -> ScatteringBound {
    match scatterer {
        Scatterer::Surface(shading) => bound(shading.point, shading.surface, shading.known()),
        Scatterer::Medium(phase) => ScatteringBound { diffuse: 0.0, glossy: peak_in_medium(phase.phase()) },
    }
}

/// Returns a bound of the light that `surface` at `point` scatters for the direction `known`. None is known where the
/// normals differ.
fn bound(point: &SurfacePoint, surface: &Surface, known: Vec3) -> ScatteringBound {
    let is_flat = point.frame.n == point.ng || point.frame.n == -point.ng;
    if is_flat { surface.bound(point.frame.to_local(known)) } else { ScatteringBound::NONE }
}

impl<'a> VirtualLight<'a> {
    /// Returns the light at `vertex`; `None` if no light leaves it but by Dirac components.
    fn scattering(vertex: SubpathVertex<'a>, events: u32, share: f32) -> Option<Self> {
        let SubpathVertex { vertex, known, beta, .. } = vertex;
        if !vertex.is_connectible() {
            return None;
        }
        let (p, end, peak, source) = match vertex {
            Vertex::Surface(SurfaceVertex { point, surface, .. }) => {
                let (p, end, peak) = (point.p, EmitterPoint::from(&point), peak(&surface));
                (p, end, peak, Source::Scattering { point, surface, known })
            }
            Vertex::Medium(point) => {
                let (p, peak) = (point.p, peak_in_medium(&point.phase));
                (p, EmitterPoint::Point(p), peak, Source::Medium(PhaseAt::new(&point, known)))
            }
            Vertex::Camera(_) | Vertex::Light(_) => return None,
        };
        Some(VirtualLight { p, end, source, flux: beta * share, events, peak })
    }

    /// Returns a random point of light number `index` of `scene`; `None` at infinity or if it does not shine.
    fn emitting(scene: &'a Scene, index: usize, sampler: &mut impl Sampler) -> Option<Self> {
        let light = &scene.lights().all()[index];
        let reach = light.reach()?;
        let light_with = |p, end, source, flux, peak| Some(VirtualLight { p, end, source, flux, events: 0, peak });
        if light.is_dirac() {
            let p = light.bounds()?.center();
            return light_with(p, EmitterPoint::Point(p), Source::Point(light), Spectrum::ONE, 0.0);
        }
        let direction = sampler.u2(0, Slot::Direction);
        let numbers = LeRandom { side: 0.0, position: sampler.u2(0, Slot::LightPoint), direction };
        let (_, density, Emitter { end, radiance, .. }) = Emitter::emitting(scene, index, &numbers)?;
        let EmitterPoint::Surface { p, ng, .. } = end else { return None };
        let source = Source::Emitting { ng, two_sided: reach.two_sided };
        light_with(p, end, source, radiance * (PI / density.position) as f32, EMITTING_PEAK)
    }
}

/// The virtual lights of a pass.
pub(super) struct VirtualLights<'a> {
    pub(super) all: Vec<VirtualLight<'a>>,
    /// Counters of the light subpaths.
    pub(super) tally: TraceStats,
}

impl<'a> VirtualLights<'a> {
    /// Traces `subpaths` light subpaths of at most `longest` scattering events; `None` if it was cancelled.
    pub(super) fn trace(
        scene: &'a Scene,
        camera: &Camera,
        (subpaths, longest): (usize, u32),
        numbers: impl PassNumbers,
        cancel: &Cancel,
    ) -> Option<Self> {
        // Its weights are not used.
        let (techniques, light_walks) = (Techniques::LIGHT, subpaths as f64);
        let weights = MisStrategy { techniques, heuristic: Heuristic::default(), light_walks };
        let share = (subpaths as f32).recip();
        let chunk = |chunk: usize| {
            let (mut found, mut tally) = (Vec::new(), TraceStats::default());
            for subpath in chunk * CHUNK..subpaths.min((chunk + 1) * CHUNK) {
                let mut sampler = numbers.of_light(subpath as u64);
                let Some((mut path, _)) = Subpath::from_light(scene, &weights, &mut sampler) else { continue };
                while let Arrival::Vertex(vertex) = path.arrive(camera, &mut sampler, &mut tally) {
                    let events = vertex.sums.index;
                    let goes_on = events < longest
                        && vertex
                            .scatterer()
                            .is_some_and(|shading| path.go_on(&vertex, &shading, &mut sampler, &mut tally).is_some());
                    found.extend(VirtualLight::scattering(vertex, events, share));
                    if !goes_on {
                        break;
                    }
                }
            }
            (!cancel.requested()).then_some((found, tally))
        };
        let chunks: Vec<_> = (0..subpaths.div_ceil(CHUNK)).into_par_iter().map(chunk).collect::<Option<_>>()?;
        let mut lights = VirtualLights { all: Vec::new(), tally: TraceStats::default() };
        for (found, tally) in chunks {
            lights.all.extend(found);
            lights.tally.absorb(&tally);
        }
        Some(lights)
    }

    /// Adds a random point of each light of `scene` with a place.
    pub(super) fn add_emitters(&mut self, scene: &'a Scene, numbers: impl PassNumbers) {
        // Light subpaths have the numbers from 0.
        let emitters = (0..scene.lights().all().len()).filter_map(|index| {
            let mut sampler = numbers.of_light(EMITTERS | index as u64);
            VirtualLight::emitting(scene, index, &mut sampler)
        });
        self.all.extend(emitters);
    }

    /// Returns the light tree over all of them; `None` if there are none.
    pub(super) fn tree(&self) -> Option<LightTree> {
        LightTree::new(&self.all.iter().map(VirtualLight::reach).collect::<Vec<_>>())
    }
}

/// Separates the random numbers of emitters from those of light subpaths.
const EMITTERS: u64 = 1 << 40;
