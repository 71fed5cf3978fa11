//! Cameras, in f64.

use super::document::{Document, name_or};
use crate::error::{Error, Result};
use crate::scene::description::{Camera, Projection};
use ::gltf::json::camera::Type;
use ::gltf::json::validation::Checked;
use glam::DAffine3;
use serde_json::Value;
use std::f64::consts::PI;

/// Camera `index` of the file, standing at `transform`. The clipping planes are not read: a ray tracer has none.
///
/// # Errors
/// A scene error that names the camera if its projection is missing or its numbers are out of range.
pub(super) fn load(document: &Document, index: usize, transform: DAffine3) -> Result<Camera> {
    let source = &document.root.cameras[index];
    let name = name_or(&source.name, "camera", index);
    let raw = &document.raw["cameras"][index];
    let projection = match source.type_ {
        Checked::Valid(Type::Perspective) => perspective(&raw["perspective"]),
        Checked::Valid(Type::Orthographic) => orthographic(&raw["orthographic"]),
        Checked::Invalid => None,
    };
    let projection = projection.ok_or_else(|| Error::scene(format!("camera '{name}' has no valid projection")))?;
    Ok(Camera { name, projection, transform })
}

fn perspective(raw: &Value) -> Option<Projection> {
    let yfov = raw["yfov"].as_f64().filter(|&angle| angle > 0.0 && angle < PI)?;
    let aspect = match raw.get("aspectRatio") {
        Some(ratio) => Some(ratio.as_f64().filter(|&r| r > 0.0)?),
        None => None,
    };
    Some(Projection::Perspective { yfov, aspect })
}

fn orthographic(raw: &Value) -> Option<Projection> {
    let half = |key: &str| raw[key].as_f64().filter(|&x| x > 0.0);
    Some(Projection::Orthographic { xmag: half("xmag")?, ymag: half("ymag")? })
}
