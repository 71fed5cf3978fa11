//! Prior knowledge of a method's failures in a scene, before any sample is taken: light that it cannot sample, and
//! light that it samples only rarely.
//!
//! Consider a path that leaves the last surface before a lamp by a lobe of slope deviation α. Light sampling is
//! effective for lobes wider than the lamp. A narrower lobe reaches the lamp only by BSDF sampling, with a contribution
//! of the lamp's radiance L. In between, a sample contributes min(L, E / (π α²)), with E the irradiance from the lamps
//! on a surface at the scene radius. This bounds a single sample of a caustic that the path tracer hits by chance, or
//! that bidirectional path tracing sees through a mirror. Light tracing connects the lobes to the camera, and
//! contributes E / (π α²) for any L.
//!
//! Limits: an estimate of magnitude, from material factors without textures. It does not test whether such a path is
//! visible. Chain methods are exempt: they explore such paths, and report on themselves.

use super::Method;
use super::blind_spots;
use crate::film::Prior;
use crate::scene::Scene;
use std::f64::consts::PI;

/// Estimates the light of `scene` that `method` may miss.
pub fn prior(method: Method, scene: &Scene) -> Prior {
    Prior { blind: !blind_spots(method, scene).is_empty(), rare_radiance: rare_radiance(method, scene) }
}

fn rare_radiance(method: Method, scene: &Scene) -> f64 {
    let Some(alpha) = scene.least_slope().filter(|_| scene.has_wide_lobes()) else { return 0.0 };
    let radius = f64::from(scene.radius());
    let lights = scene.lights().all();
    let brightest = lights.iter().filter_map(|light| light.largest_radiance()).fold(0.0, f64::max);
    let lamps = lights.iter().filter(|light| light.largest_radiance().is_none_or(|radiance| radiance > 0.0));
    let irradiance = lamps.map(|light| light.power(scene.radius())).sum::<f64>() / (PI * radius * radius);
    let sampled = irradiance / (PI * alpha * alpha);
    let without_extent = lights.iter().all(|light| light.is_dirac());
    match method {
        Method::PathNaive => brightest,
        Method::PathNee | Method::Light => sampled,
        Method::Path | Method::Bdpt | Method::Vpl | Method::Lightcuts | Method::DeterministicLightcuts => {
            if without_extent {
                sampled
            } else {
                sampled.min(brightest)
            }
        }
        Method::Pssmlt | Method::Mmlt | Method::Mlt => 0.0,
    }
}
