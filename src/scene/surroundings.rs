//! The environment of a scene: as given, or white light if the scene has no other light.

use super::description::{self, Description, Material};
use crate::light::{ConstantEnvironment, Environment, EnvironmentMap, Light};
use crate::spectrum::Spectrum;

/// Returns the default environment: white light if the file has geometry but no light. Media may emit. Hidden and
/// arbitrarily weak lights count as lights, since their author intended the darkness.
pub(super) fn by_default(
    description: &Description,
    lights: &[Light],
    media_emit: bool,
    warnings: &mut Vec<String>,
) -> Option<description::EnvironmentDescription> {
    if !description.lights.is_empty() || description.has_punctual_lights {
        return None;
    }
    if media_emit || description.has_emission || lights.iter().any(|l| !l.is_only_seen()) {
        warnings.push("only what its own materials emit lights the file: --env adds light around it".to_owned());
        return None;
    }
    let placed = description.instances.iter().flat_map(|i| &description.meshes[i.mesh].primitives);
    let mut materials = placed.map(|p| &description.materials[p.material]);
    if !description.instances.is_empty() && materials.all(Material::is_unlit) {
        return None;
    }
    warnings.push("the file has no light: a uniform white environment of radiance 1 is added".to_owned());
    Some(description::EnvironmentDescription::Uniform(Spectrum::ONE))
}

/// Returns the environment light; `None` if it is black.
pub(super) fn light(environment: description::EnvironmentDescription) -> Option<Environment> {
    match environment {
        description::EnvironmentDescription::Uniform(radiance) if radiance.is_black() => None,
        description::EnvironmentDescription::Uniform(radiance) => {
            Some(Environment::Uniform(ConstantEnvironment { radiance }))
        }
        description::EnvironmentDescription::Map { map, scale, rotation } => {
            EnvironmentMap::new(map, scale, rotation).map(|map| Environment::Map(Box::new(map)))
        }
    }
}
