//! What denoisers and compositors want to know of the first thing a camera ray meets. Numbers are addressed, so walking the
//! path a second time for it meets the same surfaces; renders without these planes pay nothing.

use crate::bsdf::{Bsdf, Lobes, Shading};
use crate::defects::{Defect, planted};
use crate::film::{Layout, Plane};
use crate::geometry::{Ray, SurfacePoint};
use crate::path::{Tally, Walk};
use crate::sampling::Sampler;
use crate::scene::Scene;
use crate::spectrum::Spectrum;
use crate::transport::Transport;
use glam::Vec3;

/// How many mirrors and panes are looked through for albedo and normal.
const DEEPEST: u32 = 8;

/// Writes coverage, depth and position of the first surface, and albedo and normal of the first that is not a mirror or
/// clear glass, into the planes that `layout` has. Where nothing is met all are 0. Of what it does only rays enter `tally`:
/// guards have fired on the same surfaces before.
pub(super) fn record(
    scene: &Scene,
    ray: Ray,
    sampler: &mut impl Sampler,
    layout: &Layout,
    values: &mut [f32],
    tally: &mut Tally,
) {
    let mut own = Tally::default();
    look(scene, ray, sampler, layout, values, &mut own);
    tally.cameras += own.cameras;
    tally.bounces += own.bounces;
}

fn look(scene: &Scene, ray: Ray, sampler: &mut impl Sampler, layout: &Layout, values: &mut [f32], tally: &mut Tally) {
    let mut put = |plane: Plane, what: &[f32]| {
        if let Some(at) = layout.offset(plane) {
            values[at..at + what.len()].copy_from_slice(what);
        }
    };
    let mut walk = Walk::new(scene, ray);
    let Some(first) = walk.arrive(sampler, tally) else { return };
    put(Plane::Alpha, &[1.0]);
    let depth = if planted(Defect::DepthFromLastPane) { first.t } else { (first.p - ray.origin).length() };
    put(Plane::Depth, &[(f64::from(depth) / scene.rebase().scale) as f32]);
    put(Plane::Position, &scene.rebase().point_in_file(first.p.as_dvec3()).as_vec3().to_array());
    if layout.offset(Plane::Albedo).is_none() && layout.offset(Plane::Normal).is_none() {
        return;
    }
    let (albedo, normal) = first_diffuse(scene, walk, first, sampler, tally);
    put(Plane::Albedo, &albedo.to_rgb());
    put(Plane::Normal, &normal.to_array());
}

/// Reflectance and shading normal of the first surface without Dirac lobes only; tinted by what lies before it.
fn first_diffuse(
    scene: &Scene,
    mut walk: Walk,
    mut point: SurfacePoint,
    sampler: &mut impl Sampler,
    tally: &mut Tally,
) -> (Spectrum, Vec3) {
    loop {
        let surface = scene.surface(&mut point, walk.ray.bodies);
        let wo = -walk.ray.direction;
        let normal = if wo.dot(point.frame.n) < 0.0 { -point.frame.n } else { point.frame.n };
        let here = (walk.beta.map(|b: f32| b.min(1.0)) * surface.reflectance(), normal);
        if surface.lobes().intersects(Lobes::SMOOTH) || walk.depth >= DEEPEST {
            return here;
        }
        let Some(shading) = Shading::new(&point, &surface, wo, Transport::Light) else { return here };
        let Some(scatter) = shading.sample(walk.scattering_numbers(&surface, sampler)) else { return here };
        walk.depart(&point, &scatter);
        match walk.arrive(sampler, tally) {
            Some(next) => point = next,
            None => return here,
        }
    }
}
