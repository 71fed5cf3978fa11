//! Feature planes of the first visible surface, for denoisers and compositors. Random numbers are addressed, so that a
//! second walk along the path, from the same point of the lens, hits the same surfaces. Renders without these planes
//! pay nothing.

use crate::bsdf::{Bsdf, Lobes, Shading};
use crate::camera::CameraSample;
use crate::film::{Layout, Plane};
use crate::geometry::SurfacePoint;
use crate::light::LightSampleContext;
use crate::path::{RandomWalk, TraceStats};
use crate::sampling::Sampler;
use crate::scene::Scene;
use crate::spectrum::Spectrum;
use crate::transport::TransportMode;
use glam::Vec3;

/// Maximum number of Dirac vertices that albedo and normal look through.
const DEEPEST: u32 = 8;

/// Writes coverage, depth and position of the first surface, and albedo and normal of the first surface that is not a
/// mirror or clear glass, into the planes of `layout`. All are 0 if nothing is hit. Only the ray counts enter `tally`,
/// since the guards have fired on the same surfaces before.
pub(super) fn record(
    scene: &Scene,
    camera: &CameraSample,
    sampler: &mut impl Sampler,
    layout: &Layout,
    values: &mut [f32],
    tally: &mut TraceStats,
) {
    let mut own = TraceStats::default();
    look(scene, camera, sampler, layout, values, &mut own);
    tally.cameras += own.cameras;
    tally.bounces += own.bounces;
}

fn look(
    scene: &Scene,
    camera: &CameraSample,
    sampler: &mut impl Sampler,
    layout: &Layout,
    values: &mut [f32],
    tally: &mut TraceStats,
) {
    let mut put = |plane: Plane, what: &[f32]| {
        if let Some(at) = layout.offset(plane) {
            values[at..at + what.len()].copy_from_slice(what);
        }
    };
    let mut walk = RandomWalk::from_camera(scene, camera);
    let Some(first) = walk.arrive(sampler, tally) else { return };
    put(Plane::Alpha, &[1.0]);
    let depth = (first.p - camera.ray.origin).length();
    put(Plane::Depth, &[(f64::from(depth) / scene.rebase().scale) as f32]);
    put(Plane::Position, &scene.rebase().point_in_file(first.p.as_dvec3()).as_vec3().to_array());
    if layout.offset(Plane::Albedo).is_none() && layout.offset(Plane::Normal).is_none() {
        return;
    }
    let (albedo, normal) = first_diffuse(scene, walk, first, sampler, tally);
    put(Plane::Albedo, &albedo.to_rgb());
    put(Plane::Normal, &normal.to_array());
}

/// Returns reflectance and shading normal of the first surface with a smooth lobe, tinted by the throughput before it.
fn first_diffuse(
    scene: &Scene,
    mut walk: RandomWalk,
    mut point: SurfacePoint,
    sampler: &mut impl Sampler,
    tally: &mut TraceStats,
) -> (Spectrum, Vec3) {
    loop {
        let surface = scene.surface(&mut point, walk.ray.state.bodies);
        let wo = -walk.ray.direction;
        let normal = if wo.dot(point.frame.n) < 0.0 { -point.frame.n } else { point.frame.n };
        let here = (walk.beta.map(|b: f32| b.min(1.0)) * surface.reflectance(), normal);
        if surface.lobes().intersects(Lobes::SMOOTH) || walk.depth >= DEEPEST {
            return here;
        }
        let Some(shading) = Shading::new(&point, &surface, wo, TransportMode::Radiance) else { return here };
        let Some(scatter) = shading.sample(walk.scattering_numbers(&surface, sampler)) else { return here };
        walk.depart(&point, LightSampleContext::from(&point), &scatter);
        match walk.arrive(sampler, tally) {
            Some(next) => point = next,
            None => return here,
        }
    }
}
