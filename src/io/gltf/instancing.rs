//! EXT_mesh_gpu_instancing: copies of a node's mesh, each with a translation, rotation and scale relative to the node.

use super::accessor::Wanted;
use super::document::Document;
use super::extensions::INSTANCING as NAME;
use super::quaternion::unit_quaternion;
use crate::error::{Error, Result};
use ::gltf::json::accessor::ComponentType;
use ::gltf::json::validation::Checked;
use glam::{DAffine3, DQuat, DVec3};
use serde_json::Value;

/// Returns the transforms of the copies of the mesh of `node`, relative to it: a single identity without the extension.
///
/// # Errors
/// A scene error if an attribute is not valid, or if their lengths differ.
pub(super) fn places(document: &Document, node: usize) -> Result<Vec<DAffine3>> {
    let attributes = &document.raw["nodes"][node]["extensions"][NAME]["attributes"];
    let translations = read::<3>(document, attributes, "TRANSLATION")?;
    let rotations = read::<4>(document, attributes, "ROTATION")?;
    let scales = read::<3>(document, attributes, "SCALE")?;
    let lengths =
        [translations.as_ref().map(Vec::len), rotations.as_ref().map(Vec::len), scales.as_ref().map(Vec::len)];
    let Some(count) = lengths.into_iter().flatten().next() else { return Ok(vec![DAffine3::IDENTITY]) };
    if let Some(other) = lengths.into_iter().flatten().find(|&length| length != count) {
        return Err(Error::scene(format!("{NAME} has {count} elements of one attribute and {other} of another")));
    }
    document.budget.spend(count, size_of::<DAffine3>())?;
    let place = |i: usize| -> Result<DAffine3> {
        let translation = translations.as_ref().map_or(DVec3::ZERO, |t| DVec3::from(t[i]));
        let scale = scales.as_ref().map_or(DVec3::ONE, |s| DVec3::from(s[i]));
        let rotation = rotations.as_ref().map_or(Some(DQuat::IDENTITY), |r| unit_quaternion(r[i]));
        let rotation =
            rotation.ok_or_else(|| Error::scene(format!("rotation {i} of {NAME} is not a unit quaternion")))?;
        Ok(DAffine3::from_scale_rotation_translation(scale, rotation, translation))
    };
    (0..count).map(place).collect()
}

/// Reads all elements of an attribute. Rotations may be normalised integers, the others must be floats.
fn read<const N: usize>(document: &Document, attributes: &Value, name: &str) -> Result<Option<Vec<[f64; N]>>> {
    let Some(index) = attributes.get(name) else { return Ok(None) };
    let index = index.as_u64().and_then(|i| usize::try_from(i).ok()).unwrap_or(usize::MAX);
    let named = |e: Error| e.context(format!("{name} of {NAME}"));
    let accessor = document.accessor(index).map_err(named)?;
    let kind = if let Checked::Valid(kind) = &accessor.component_type { Some(kind.0) } else { None };
    let right = match kind {
        Some(ComponentType::F32) => true,
        Some(ComponentType::I8 | ComponentType::I16) => name == "ROTATION" && accessor.normalized,
        _ => false,
    };
    if !right {
        return Err(named(Error::scene(format!("accessor {index} has a component type that is not for it"))));
    }
    let elements = document.floats::<N>(index, Wanted::All).map_err(named)?;
    Ok(Some(elements.into_iter().map(|e| e.map(f64::from)).collect()))
}
