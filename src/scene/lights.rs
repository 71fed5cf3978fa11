//! Lights of a description in scene space, and the bounds of their numbers.

use super::ObjectInfo;
use super::contact::Contacts;
use super::description::{self, PunctualKind};
use super::material::Material;
use super::rebase::{MOST, Rebase};
use crate::error::{Error, Result};
use crate::geometry::{Geometry, Hit};
use crate::light::{AreaLight, DirectionalLight, Emission, Light, PointLight, SpotLight};
use crate::spectrum::Spectrum;

/// Checks that the emission of `materials` is in range.
///
/// # Errors
/// A scene error that names the first one that is not.
pub(super) fn check_emission(materials: &[description::Material]) -> Result<()> {
    match materials.iter().position(|m| !is_strength(m.emission)) {
        Some(i) => Err(Error::scene(format!("material {i}: the emission is out of range"))),
        None => Ok(()),
    }
}

/// Whether all lanes and their sum are finite, and none is negative.
fn is_strength(light: Spectrum) -> bool {
    light.min_lane() >= 0.0 && light.is_finite() && light.mean().is_finite()
}

/// Makes each emitting triangle a light, and stores in `objects` the first light of each object.
pub(super) fn area_lights(
    geometry: &Geometry,
    objects: &mut [ObjectInfo],
    materials: &[Material],
    contacts: Option<&Contacts>,
) -> Vec<Light> {
    let mut lights = Vec::new();
    for (index, info) in objects.iter_mut().enumerate() {
        let material = &materials[info.material as usize];
        if material.emission().is_black() {
            continue;
        }
        info.first_light = Some(lights.len() as u32);
        let object = index as u32;
        let winding = geometry.winding(object);
        lights.extend((0..geometry.mesh_of(object).triangles().len() as u32).map(|primitive| {
            let hit = Hit { object, primitive };
            let emission = material.emission_of(|set| geometry.corner_uvs(hit, set), geometry.corner_colors(hit));
            let touched = if contacts.is_some_and(|c| c.flags(hit)) { hit } else { Hit::NONE };
            let emission = emission.unwrap_or(Emission::NONE);
            Light::Area(AreaLight::touched(geometry.triangle(hit), touched, winding, emission))
        }));
    }
    lights
}

/// Returns the punctual lights in scene space.
///
/// # Errors
/// A scene error that names the first one that is out of range.
pub(super) fn punctual_lights(lights: &[description::PunctualLight], rebase: &Rebase) -> Result<Vec<Light>> {
    lights.iter().map(|light| punctual(light, rebase)).collect()
}

/// Returns a punctual light in scene space. Distances scale linearly, so intensities scale quadratically.
fn punctual(light: &description::PunctualLight, rebase: &Rebase) -> Result<Light> {
    let error = |what: String| Error::scene(format!("light '{}' {what}", light.name));
    let backward = light.transform.matrix3.z_axis.normalize_or_zero().as_vec3();
    if !is_strength(light.intensity) {
        return Err(error("has an intensity out of range".to_owned()));
    }
    if light.kind == PunctualKind::Directional {
        return Ok(Light::Directional(DirectionalLight { toward: backward, irradiance: light.intensity }));
    }
    let position = rebase.point(light.transform.translation);
    // The square of a distance must be in the range of f32, as for geometry.
    let within = position.length() <= MOST;
    if !within {
        return Err(error(format!("is farther than {MOST:e} times the size of the scene")));
    }
    let intensity = light.intensity * (rebase.scale * rebase.scale) as f32;
    if !is_strength(intensity) {
        return Err(error("is too strong for single precision in a scene as small as this".to_owned()));
    }
    let point = PointLight { position: position.as_vec3(), intensity };
    Ok(match light.kind {
        PunctualKind::Spot { inner, outer } => Light::Spot(SpotLight::new(point, -backward, inner, outer)),
        PunctualKind::Point | PunctualKind::Directional => Light::Point(point),
    })
}
