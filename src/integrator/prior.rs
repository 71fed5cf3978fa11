//! What is known of a method in a scene before a sample is taken: light that it does not see, and light that it meets by luck.
//!
//! Let a walk leave the last surface before a lamp by a lobe of slope deviation α. Light sampling serves lobes wider than the lamp;
//! a lobe that is narrower finds the lamp by scattering only, and brings its radiance L where it does. Between the two a sample is
//! worth min(L, E / (π α²)), E being what the lamps send onto a surface at a radius of the scene: so much can one sample bring of a caustic that
//! the path tracer meets by luck, and bidirectional path tracing where a mirror shows it. Light tracing
//! connects lobes with the camera, and brings E / (π α²) whatever L is.
//!
//! Limits: an estimate by magnitude, by the factors of materials without their textures; it does not ask whether the camera sees such a
//! path. Chains are not judged by it: they look for such paths, and report on themselves.

use super::Method;
use super::blind_spots;
use crate::defects::{Defect, planted};
use crate::film::Prior;
use crate::scene::Scene;
use std::f64::consts::PI;

/// What light of `scene` the method may miss.
pub fn prior(method: Method, scene: &Scene) -> Prior {
    if planted(Defect::PriorForgotten) {
        return Prior::default();
    }
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
    match method {
        Method::PathNaive => brightest,
        Method::PathNee | Method::Light => sampled,
        Method::Path | Method::Bdpt if lights.iter().all(|light| light.is_dirac()) => sampled,
        Method::Path | Method::Bdpt => sampled.min(brightest),
        Method::Pssmlt | Method::Mmlt | Method::Mlt => 0.0,
    }
}
