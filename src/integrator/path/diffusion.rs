//! Subsurface scattering by a diffusion model in place of a random walk. Pictures made with it are approximate.
//!
//! A walk that enters a body leaves it again in one step. A radius is drawn from the profile of the body's medium, and
//! a probe ray at this distance from the entry finds where the light could leave: through the surface along its normal,
//! or along a tangent, for parts of the body that turn away. What any of the three axes and any lane could have found
//! counts by the balance heuristic [King13]. One of the places found is selected by its contribution. There the light
//! leaves in all directions, as diffuse light from inside through a smooth boundary does.
//!
//! Limits: see [`crate::subsurface`]. A body is known if it is closed, full of one medium that scatters, surrounded by
//! an index of 1 and not matched to it, and at least [`THICK`] mean free paths thick. All others are walked.

use super::{PathTracer, Strategy};
use crate::accel::RayClass;
use crate::bsdf::fresnel::dielectric;
use crate::bsdf::{Lambert, Scattering, Shading, ShadingSample, Surface};
use crate::geometry::{Frame, Ray, SurfacePoint};
use crate::path::{RandomWalk, TraceStats};
use crate::sampling::{Sampler, Slot};
use crate::scene::{Edge, EdgeEnd, Scene, Solid};
use crate::spectrum::{LANES, Spectrum};
use crate::subsurface::{DiffusionModel, MediumLane, ProfileLanes, exit_share};
use crate::transport::TransportMode;
use glam::Vec3;
use std::collections::HashMap;
use std::f32::consts::TAU;
use std::sync::Arc;

/// First address of the random numbers of probes.
const PROBE: u32 = 1 << 27;

/// Share of a lane's light beyond the farthest point that probes reach.
const LOST: f32 = 1e-4;

/// Least thickness of a body, in reduced mean free paths of each lane.
const THICK: f32 = 10.0;

/// Largest number of surfaces on a probe ray.
const MOST_CROSSED: u32 = 256;

/// Probabilities of the axes: the normal, and two tangents.
const AXES: [f32; 3] = [0.5, 0.25, 0.25];

/// The bodies that a model knows, by rank. Bodies of one medium share a profile.
pub(super) struct DiffusionBodies(Vec<Option<Arc<DiffusionBody>>>);

/// A body with a profile.
pub(super) struct DiffusionBody {
    profiles: ProfileLanes,
    total: Spectrum,
    /// Radius of the ball around an entry that probes search.
    reach: f32,
    /// Index inside over outside.
    eta: f32,
    /// Share of diffuse light that passes the boundary from outside.
    passing: f32,
}

/// Returns the solids of `scene` that models know.
pub(in crate::integrator) fn known_solids(scene: &Scene) -> impl Iterator<Item = Solid> {
    scene.solids().filter(|solid| {
        let reduced = media_of(solid).map(|medium| medium.reduced().extinction());
        reduced.into_iter().all(|extinction| extinction * f64::from(solid.thickness) >= f64::from(THICK))
    })
}

/// Returns the medium of a solid by lane.
fn media_of(solid: &Solid) -> [MediumLane; LANES] {
    let Solid { medium, ior, .. } = solid;
    std::array::from_fn(|lane| {
        let scattering = f64::from(medium.scattering.0[lane]);
        let absorption = (f64::from(medium.extinction.0[lane]) - scattering).max(0.0);
        MediumLane { absorption, scattering, mean_cosine: f64::from(medium.phase.mean_cosine()), eta: f64::from(*ior) }
    })
}

impl DiffusionBodies {
    /// Makes the profiles of the solids in `scene`.
    pub(super) fn new(scene: &Scene, model: DiffusionModel) -> Self {
        let (mut bodies, mut known) = (Vec::new(), HashMap::new());
        for solid in known_solids(scene) {
            let key = (solid.medium.numbers().map(f32::to_bits), solid.ior.to_bits());
            let body = known.entry(key).or_insert_with(|| Arc::new(DiffusionBody::new(&solid, model)));
            let rank = solid.body as usize;
            bodies.resize_with(bodies.len().max(rank + 1), || None);
            bodies[rank] = Some(Arc::clone(body));
        }
        DiffusionBodies(bodies)
    }
}

impl DiffusionBody {
    fn new(solid: &Solid, model: DiffusionModel) -> Self {
        let profiles = ProfileLanes(media_of(solid).map(|medium| model.profile(&medium)));
        let total = profiles.total();
        let reach = profiles.max_radius(LOST);
        DiffusionBody { profiles, total, reach, eta: solid.ior, passing: exit_share(f64::from(solid.ior)) as f32 }
    }

    /// Returns the density per area with which probes around an entry with the axes `frame` find the place at `offset`
    /// from it, where the normal is `ng`.
    fn density(&self, frame: &Frame, shares: Spectrum, offset: Vec3, ng: Vec3) -> f32 {
        let along = |(axis, probability): (Vec3, f32)| {
            let radius = offset.cross(axis).length();
            probability * axis.dot(ng).abs() * self.profiles.density(shares, radius)
        };
        [frame.n, frame.s, frame.t].into_iter().zip(AXES).map(along).sum()
    }
}

/// A place where light leaves a body, and the factor of its throughput.
struct Exit {
    point: SurfacePoint,
    factor: Spectrum,
}

/// What leaves the boundary of a body after diffusion: cosine times transmittance, over the share of diffuse light that
/// passes.
struct DiffuseExit<'a> {
    /// The same without the transmittance.
    lobe: Shading<'a>,
    eta: f32,
}

impl DiffuseExit<'_> {
    fn transmittance(&self, w: Vec3) -> f32 {
        1.0 - dielectric(w.dot(self.lobe.point.frame.n).abs(), self.eta)
    }

    fn scattering(&self, other: Vec3) -> Option<Scattering> {
        let Scattering { f_cos, pdf } = self.lobe.scattering(other)?;
        Some(Scattering { f_cos: f_cos * self.transmittance(other), pdf })
    }

    fn sample(&self, u: [f32; 3]) -> Option<ShadingSample> {
        let sample = self.lobe.sample(u)?;
        Some(ShadingSample { weight: sample.weight * self.transmittance(sample.direction), ..sample })
    }
}

impl<S: Strategy> PathTracer<'_, S> {
    /// Returns the body with a profile that `walk` would enter at `point` by `scatter`.
    #[inline]
    pub(super) fn entered(
        &self,
        walk: &RandomWalk,
        point: &SurfacePoint,
        scatter: &ShadingSample,
    ) -> Option<&DiffusionBody> {
        let bodies = self.diffusion.as_ref()?;
        let rank = self.scene.entered(point, walk.ray.state.bodies, scatter.direction)?;
        bodies.0.get(rank as usize)?.as_deref()
    }

    /// Takes `walk` through `body`, which it enters at `point` by `scatter`, and away from where it leaves. Returns the
    /// light sampled there.
    pub(super) fn diffuse(
        &self,
        walk: &mut RandomWalk,
        body: &DiffusionBody,
        (point, scatter): (&SurfacePoint, &ShadingSample),
        sampler: &mut impl Sampler,
        tally: &mut TraceStats,
    ) -> Spectrum {
        // Radiance is scaled by 1 / η² where it enters, and by η² where it leaves.
        walk.enter_and_leave(scatter.weight * (scatter.eta * scatter.eta));
        let Some(Exit { point: mut exit, factor }) = self.probe(walk, body, point, sampler, tally) else {
            walk.beta = Spectrum::ZERO;
            return Spectrum::ZERO;
        };
        let state = walk.ray.state;
        let tint = self.scene.surface(&mut exit, state.bodies).transmission();
        walk.beta *= factor;
        let surface = Surface::Lambert(Lambert { albedo: tint / body.passing });
        let Some(lobe) = Shading::new(&exit, &surface, exit.frame.n, TransportMode::Radiance) else {
            walk.beta = Spectrum::ZERO;
            return Spectrum::ZERO;
        };
        if walk.depth >= self.max_depth {
            walk.beta = Spectrum::ZERO;
            return Spectrum::ZERO;
        }
        let (receiver, leaving) = (self.receiver(&lobe), DiffuseExit { lobe, eta: body.eta });
        let edge = |w: Vec3, end| Edge::new(self.scene, &exit, state, w, EdgeEnd::Light(end));
        let light = self.direct(walk, |w| leaving.scattering(w), &receiver, edge, |_, _, _| 1.0, sampler, tally);
        let [u, v] = sampler.u2(walk.bounce, Slot::Direction);
        match leaving.sample([0.0, u, v]) {
            Some(sample) => walk.depart(&exit, receiver, &sample),
            None => walk.beta = Spectrum::ZERO,
        }
        light
    }

    /// Finds a place where light that entered `body` at `entry` leaves it.
    fn probe(
        &self,
        walk: &RandomWalk,
        body: &DiffusionBody,
        entry: &SurfacePoint,
        sampler: &mut impl Sampler,
        tally: &mut TraceStats,
    ) -> Option<Exit> {
        let weights = walk.beta * body.total;
        let shares = weights / weights.0.into_iter().sum::<f32>();
        if !shares.is_finite() {
            return None;
        }
        let [pick, depth] = sampler.u2(PROBE + walk.bounce, Slot::MediumDistance);
        let [azimuth, mut choice] = sampler.u2(PROBE + walk.bounce, Slot::Direction);
        let frame = Frame::around(entry.ng);
        let (axis, lane) = choose_axis(pick);
        let [across, beside, along] = match axis {
            0 => [frame.s, frame.t, frame.n],
            1 => [frame.t, frame.n, frame.s],
            _ => [frame.n, frame.s, frame.t],
        };
        let radius = body.profiles.sample(shares, lane, depth);
        let half = (body.reach - radius) * (body.reach + radius);
        if half <= 0.0 {
            return None;
        }
        let (half, (sin, cos)) = (half.sqrt(), (TAU * azimuth).sin_cos());
        let start = entry.p + (across * cos + beside * sin) * radius - along * half;
        let (mut found, mut sum) = (None, 0.0);
        let mut visit = |point: SurfacePoint| {
            let offset = point.p - entry.p;
            let factor = body.profiles.value(offset.length()) / body.density(&frame, shares, offset, point.ng);
            let weight = (walk.beta * factor).mean();
            if !(weight > 0.0 && weight.is_finite()) {
                return;
            }
            sum += weight;
            let chance = weight / sum;
            if choice < chance {
                choice /= chance;
                found = Some((point, factor / weight));
            } else {
                choice = (choice - chance) / (1.0 - chance);
            }
        };
        self.scene.accel().announce(RayClass::Bounce(walk.depth));
        self.along_probe(Ray::new(start, along), 2.0 * half, entry, tally, &mut visit);
        found.map(|(point, factor)| Exit { point, factor: factor * sum })
    }

    /// Calls `visit` with each point within `length` along `ray` on the body whose boundary is at `entry`.
    fn along_probe(
        &self,
        mut ray: Ray,
        mut length: f32,
        entry: &SurfacePoint,
        tally: &mut TraceStats,
        visit: &mut impl FnMut(SurfacePoint),
    ) {
        for _ in 0..MOST_CROSSED {
            tally.bounces += 1;
            let Some(point) = self.scene.intersect(&ray) else { return };
            length -= point.t;
            if length < 0.0 {
                return;
            }
            ray = point.spawn(ray.direction);
            if self.scene.is_same_body(&point, entry) {
                visit(point);
            }
        }
        tally.overlong += 1;
    }
}

/// Returns the axis selected by `u` in [0, 1), and the number that is left of it.
fn choose_axis(u: f32) -> (usize, f32) {
    let [normal, tangent, _] = AXES;
    if u < normal {
        (0, u / normal)
    } else if u < normal + tangent {
        (1, (u - normal) / tangent)
    } else {
        (2, (u - normal - tangent) / (1.0 - normal - tangent))
    }
}
