//! The edges between two walks, and between a walk and an end: what they carry, and their weight. Whether they are free is asked
//! last, since that traces a ray.

use super::Vertex;
use super::mis::Weights;
use crate::bsdf::{Scattering, Shading};
use crate::camera::Camera;
use crate::defects::{Defect, planted};
use crate::geometry::{Bodies, Hit, Ray, SurfacePoint};
use crate::light::{End, LightSample, Receiver};
use crate::sampling::{Density, Sampler, Slot};
use crate::scene::Scene;
use crate::spectrum::Spectrum;
use glam::Vec3;

/// What a technique finds, if nothing is in the way.
#[derive(Debug, Clone, Copy)]
pub struct Connection {
    /// f(x̄) over the density of the technique, transmittance of the segment apart.
    pub value: Spectrum,
    /// The technique's share.
    pub weight: f64,
    /// Probability with which roulette let both walks come here: the value is over it.
    pub survival: f32,
    /// What must be free.
    pub segment: Ray,
}

/// A connection with the camera.
#[derive(Debug, Clone, Copy)]
pub struct Splat {
    /// What it finds, per pixel of film area and walk from a light.
    pub connection: Connection,
    /// Where on the film, in pixels.
    pub film: [f32; 2],
}

/// A sampled light for the vertex `z` of a walk from the camera.
pub fn next_event(
    scene: &Scene,
    weights: &Weights,
    z: &Vertex,
    shading: &Shading,
    sampler: &mut impl Sampler,
) -> Option<Connection> {
    let bounce = z.sums.index - 1;
    let receiver = Receiver::from(&z.point);
    let (index, pmf) = scene.lights().choose(&receiver, sampler.u1(bounce, Slot::LightPick))?;
    let light = &scene.lights().all()[index];
    let sample = light.sample_toward(&receiver, sampler.u2(bounce, Slot::LightPoint))?;
    let Scattering { f_cos, pdf } = shading.scattering(sample.wi)?;
    let pmf = f64::from(pmf.value());
    let emission = light.ray_density(scene.ball(), -sample.wi);
    let ratio = f64::from(scene.lights().emitter_pmf(index).value()) / pmf;
    let d2 = match sample.end {
        End::Surface { p, .. } | End::Point(p) => f64::from(p.distance_squared(z.point.p)),
        End::Infinity => 1.0,
    };
    let made = ratio * emission * f64::from(sample.wi.dot(z.point.ng).abs()) / d2;
    let hit = match sample.density {
        Density::Smooth(toward) => f64::from(pdf.value()) / (pmf * f64::from(toward.value())),
        Density::Delta(_) => 0.0,
    };
    let reverse = f64::from(shading.reverse_pdf(sample.wi).value());
    Some(Connection {
        value: z.beta * f_cos * sample.radiance / (pmf as f32 * sample.density.value()),
        weight: weights.next_event(hit, weights.earlier(&z.sums, made, reverse)),
        survival: z.survival,
        segment: toward_light(scene, &z.point, z.bodies, &sample),
    })
}

/// The segment that must be free for `sample` to arrive at `point`, where a walk came in `bodies`.
#[inline]
pub fn toward_light(scene: &Scene, point: &SurfacePoint, bodies: Bodies, sample: &LightSample) -> Ray {
    Ray { bodies: scene.bodies_toward(point, bodies, sample.wi), ..toward_end(point, &sample.end, sample.wi) }
}

/// The segment between `point` and the `end` of a path, which lies in the direction `wi`.
#[inline]
pub fn toward_end(point: &SurfacePoint, end: &End, wi: Vec3) -> Ray {
    match *end {
        End::Surface { p, error, ng, touched } => point.segment(p, error, ng, touched),
        End::Point(p) => point.segment(p, 0.0, point.ng, Hit::NONE),
        End::Infinity => point.spawn(wi),
    }
}

/// The vertex `y` of a walk from a light and `z` of one from the camera.
#[inline]
pub fn connect(scene: &Scene, weights: &Weights, y: &Vertex, z: &Vertex, z_shading: &Shading) -> Option<Connection> {
    let to = y.point.p - z.point.p;
    let d2 = to.length_squared();
    let wi = to / d2.sqrt();
    let at_z = z_shading.scattering(wi)?;
    let y_shading = y.shading()?;
    let at_y = y_shading.scattering(-wi)?;
    if d2 <= 0.0 {
        return None;
    }
    let per_area = |pdf: f32, at: &SurfacePoint| f64::from(pdf) * f64::from(wi.dot(at.ng).abs()) / f64::from(d2);
    let reverse = |shading: &Shading, w: Vec3| f64::from(shading.reverse_pdf(w).value());
    let light = weights.earlier(&y.sums, per_area(at_z.pdf.value(), &y.point), reverse(&y_shading, -wi));
    let camera = weights.earlier(&z.sums, per_area(at_y.pdf.value(), &z.point), reverse(z_shading, wi));
    let value = y.beta * at_y.f_cos * at_z.f_cos * z.beta / d2;
    let segment = Ray { bodies: z.bodies_toward(scene, wi), ..z.point.segment_to(&y.point) };
    Some(Connection { value, weight: weights.connection(light, camera), survival: y.survival * z.survival, segment })
}

/// The vertex `y` of a walk from a light and the camera; `None` where it is not seen.
pub fn splat(scene: &Scene, weights: &Weights, camera: &Camera, y: &Vertex) -> Option<Splat> {
    let seen = camera.seen(y.point.p)?;
    if scene.culled(&y.point, -seen.toward) {
        return None;
    }
    let shading = y.shading()?;
    let at_y = shading.scattering(seen.toward)?;
    let magnification = if planted(Defect::SplatsWithoutMagnification) { 1.0 } else { seen.magnification };
    let density = f64::from(seen.magnification) * f64::from(seen.toward.dot(y.point.ng).abs());
    let reverse = f64::from(shading.reverse_pdf(seen.toward).value());
    let segment = Ray { bodies: y.bodies_toward(scene, seen.toward), ..y.point.segment(seen.eye, 0.0, y.point.ng, Hit::NONE) };
    let value = y.beta * at_y.f_cos * magnification;
    let connection = Connection { value, weight: weights.splat(&y.sums, density, reverse), survival: y.survival, segment };
    Some(Splat { connection, film: seen.film })
}
