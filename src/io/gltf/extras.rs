//! What étendue reads from a material's `extras.etendue`: `"fresnel": "schlick"` (glTF's, the default) or `"constant"`.

use crate::error::{Error, Result};
use crate::scene::description::MetalFresnel;
use ::gltf::json::Extras;
use serde_json::Value;

/// The Fresnel reflectance that a material's extras ask for.
///
/// # Errors
/// A scene error if `etendue` has another key or value: a misspelt one must not silently mean nothing.
pub(super) fn metal_fresnel(extras: &Extras) -> Result<MetalFresnel> {
    let parsed: Option<Value> = extras.as_ref().and_then(|raw| serde_json::from_str(raw.get()).ok());
    let Some(ours) = parsed.as_ref().and_then(|v| v.get("etendue")) else { return Ok(MetalFresnel::default()) };
    let keys = ours.as_object().ok_or_else(|| Error::scene("extras.etendue is not an object"))?;
    if let Some(unknown) = keys.keys().find(|k| *k != "fresnel") {
        return Err(Error::scene(format!("extras.etendue has the unknown key '{unknown}'")));
    }
    match keys.get("fresnel").map(Value::as_str) {
        None | Some(Some("schlick")) => Ok(MetalFresnel::Schlick),
        Some(Some("constant")) => Ok(MetalFresnel::Constant),
        Some(_) => Err(Error::scene("extras.etendue.fresnel is neither \"schlick\" nor \"constant\"")),
    }
}
