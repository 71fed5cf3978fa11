//! Extras read from a material's `extras.etendue`: `"fresnel": "schlick"` (glTF's, the default) or `"constant"`, and
//! `"priority"`, an integer (default 0). Where bodies overlap, the one of the highest priority takes the volume. The
//! medium inside has the keys of [`crate::io::medium`]; its density is in the coordinates of the mesh.

use crate::error::{Error, Result};
use crate::io::medium::MediumOptions;
use crate::scene::description::MetalFresnel;
use ::gltf::json::Extras;
use serde_json::Value;

/// Options in a material's extras.
#[derive(Debug, Default, PartialEq)]
pub(super) struct Asked {
    pub(super) metal_fresnel: MetalFresnel,
    pub(super) priority: i32,
    /// The medium inside.
    pub(super) medium: MediumOptions,
}

/// Reads the options in a material's extras.
///
/// # Errors
/// A scene error if `etendue` has an unknown key or value, so that misspellings are not silently ignored.
pub(super) fn of_material(extras: &Extras) -> Result<Asked> {
    let parsed: Option<Value> = extras.as_ref().and_then(|raw| serde_json::from_str(raw.get()).ok());
    let Some(ours) = parsed.as_ref().and_then(|v| v.get("etendue")) else { return Ok(Asked::default()) };
    let keys = ours.as_object().ok_or_else(|| Error::scene("extras.etendue is not an object"))?;
    let is_known = |key: &str| ["fresnel", "priority"].contains(&key) || MediumOptions::KEYS.contains(&key);
    if let Some(unknown) = keys.keys().find(|key| !is_known(key)) {
        return Err(Error::scene(format!("extras.etendue has the unknown key '{unknown}'")));
    }
    let metal_fresnel = match keys.get("fresnel").map(Value::as_str) {
        None | Some(Some("schlick")) => MetalFresnel::Schlick,
        Some(Some("constant")) => MetalFresnel::Constant,
        Some(_) => return Err(Error::scene("extras.etendue.fresnel is neither \"schlick\" nor \"constant\"")),
    };
    let whole = |v: &Value| v.as_i64().and_then(|i| i32::try_from(i).ok());
    let priority = keys
        .get("priority")
        .map(|v| whole(v).ok_or_else(|| Error::scene("extras.etendue.priority is no integer of 32 bits")));
    let medium = MediumOptions::read(keys, "extras.etendue")?;
    Ok(Asked { metal_fresnel, priority: priority.transpose()?.unwrap_or(0), medium })
}
