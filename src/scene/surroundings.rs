//! What surrounds a scene: what it was given, or white light where nothing else lights it.

use super::description::{self, Description, Material};
use crate::light::{Environment, LatLong, Light, Sky};
use crate::spectrum::Spectrum;

/// What surrounds a scene that nobody gave surroundings: white light if its file has no light and something to light. Lights count that
/// are hidden or as weak as can be: who made them meant the dark.
pub(super) fn by_default(
    description: &Description,
    lights: &[Light],
    warnings: &mut Vec<String>,
) -> Option<description::Environment> {
    if !description.lights.is_empty() || description.has_punctual_lights {
        return None;
    }
    if description.has_emission || lights.iter().any(|l| !l.is_only_seen()) {
        warnings.push("only what its own materials emit lights the file: --env adds light around it".to_owned());
        return None;
    }
    let placed = description.instances.iter().flat_map(|i| &description.meshes[i.mesh].primitives);
    let mut materials = placed.map(|p| &description.materials[p.material]);
    if !description.instances.is_empty() && materials.all(|m: &Material| m.unlit) {
        return None;
    }
    warnings.push("the file has no light: a uniform white environment of radiance 1 is added".to_owned());
    Some(description::Environment::Uniform(Spectrum::ONE))
}

/// The light of the environment; `None` if it is black.
pub(super) fn light(environment: description::Environment) -> Option<Environment> {
    match environment {
        description::Environment::Uniform(radiance) if radiance.is_black() => None,
        description::Environment::Uniform(radiance) => Some(Environment::Uniform(Sky { radiance })),
        description::Environment::Map { map, scale, rotation } => {
            LatLong::new(map, scale, rotation).map(|map| Environment::Map(Box::new(map)))
        }
    }
}
