//! Connections between two subpaths, and between a subpath and an endpoint: their contribution and MIS weight.
//! Visibility is tested last, since it traces a ray.

use super::Vertex;
use super::mis::MisStrategy;
use crate::bsdf::{Scattering, Shading};
use crate::camera::Camera;
use crate::geometry::{Bodies, Hit, Ray, SurfacePoint};
use crate::light::{EmitterPoint, LightSample, LightSampleContext};
use crate::sampling::{Density, Sampler, Slot};
use crate::scene::Scene;
use crate::spectrum::Spectrum;
use glam::Vec3;

/// Contribution of a technique before the visibility test.
#[derive(Debug, Clone, Copy)]
pub struct Connection {
    /// f(x̄) divided by the density of the technique, without the transmittance of the segment.
    pub value: Spectrum,
    /// MIS weight of the technique.
    pub weight: f64,
    /// Probability that both subpaths survived roulette. `value` is already divided by it.
    pub survival: f32,
    /// Segment to test for visibility.
    pub segment: Ray,
}

/// A connection to the camera.
#[derive(Debug, Clone, Copy)]
pub struct Splat {
    /// Contribution per pixel of film area and light subpath.
    pub connection: Connection,
    /// Raster position, in pixels.
    pub film: [f32; 2],
}

/// Next-event estimation at the vertex `z` of a camera subpath.
pub fn next_event(
    scene: &Scene,
    weights: &MisStrategy,
    z: &Vertex,
    shading: &Shading,
    sampler: &mut impl Sampler,
) -> Option<Connection> {
    let bounce = z.sums.index - 1;
    let receiver = LightSampleContext::from(&z.point);
    let (index, pmf) = scene.lights().choose(&receiver, sampler.u1(bounce, Slot::LightPick))?;
    let light = &scene.lights().all()[index];
    let sample = light.sample_li(&receiver, sampler.u2(bounce, Slot::LightPoint))?;
    let Scattering { f_cos, pdf } = shading.scattering(sample.wi)?;
    let pmf = f64::from(pmf.value());
    let emission = light.ray_density(scene.ball(), -sample.wi);
    let ratio = f64::from(scene.lights().emitter_pmf(index).value()) / pmf;
    let d2 = match sample.end {
        EmitterPoint::Surface { p, .. } | EmitterPoint::Point(p) => f64::from(p.distance_squared(z.point.p)),
        EmitterPoint::Distant => 1.0,
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

/// Returns the shadow ray from `point` to the light `sample`; `bodies` are those in which the walk arrived.
#[inline]
pub fn toward_light(scene: &Scene, point: &SurfacePoint, bodies: Bodies, sample: &LightSample) -> Ray {
    Ray { bodies: scene.bodies_toward(point, bodies, sample.wi), ..toward_end(point, &sample.end, sample.wi) }
}

/// Returns the segment from `point` to the endpoint `end` in the direction `wi`.
#[inline]
pub fn toward_end(point: &SurfacePoint, end: &EmitterPoint, wi: Vec3) -> Ray {
    match *end {
        EmitterPoint::Surface { p, error, ng, touched } => point.segment(p, error, ng, touched),
        EmitterPoint::Point(p) => point.segment(p, 0.0, point.ng, Hit::NONE),
        EmitterPoint::Distant => point.spawn(wi),
    }
}

/// Connects the vertex `y` of a light subpath to the vertex `z` of a camera subpath.
#[inline]
pub fn connect(
    scene: &Scene,
    weights: &MisStrategy,
    y: &Vertex,
    z: &Vertex,
    z_shading: &Shading,
) -> Option<Connection> {
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

/// Connects the vertex `y` of a light subpath to the camera; `None` if `y` is outside the field of view or culled.
pub fn splat(scene: &Scene, weights: &MisStrategy, camera: &Camera, y: &Vertex) -> Option<Splat> {
    let seen = camera.sample_wi(y.point.p)?;
    if scene.culled(&y.point, -seen.wi) {
        return None;
    }
    let shading = y.shading()?;
    let at_y = shading.scattering(seen.wi)?;
    let density = f64::from(seen.importance) * f64::from(seen.wi.dot(y.point.ng).abs());
    let reverse = f64::from(shading.reverse_pdf(seen.wi).value());
    let segment =
        Ray { bodies: y.bodies_toward(scene, seen.wi), ..y.point.segment(seen.eye, 0.0, y.point.ng, Hit::NONE) };
    let value = y.beta * at_y.f_cos * seen.importance;
    let connection =
        Connection { value, weight: weights.splat(&y.sums, density, reverse), survival: y.survival, segment };
    Some(Splat { connection, film: seen.film })
}
