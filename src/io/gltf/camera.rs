//! Cameras, in f64.

use super::document::{Document, name_or};
use super::notes::Notes;
use crate::scene::description::{CameraDescription, Projection};
use ::gltf::json::camera::Type;
use ::gltf::json::validation::Checked;
use glam::DAffine3;
use serde_json::Value;
use std::f64::consts::PI;

/// Loads camera `index` of the file at `transform`. Clipping planes are ignored. `None`, and a note, if the projection
/// is missing or its parameters are not usable.
pub(super) fn load(
    document: &Document,
    index: usize,
    transform: DAffine3,
    notes: &mut Notes,
) -> Option<CameraDescription> {
    let source = &document.root.cameras[index];
    let name = name_or(&source.name, "camera", index);
    let raw = &document.raw["cameras"][index];
    let projection = match source.type_ {
        Checked::Valid(Type::Perspective) => perspective(&raw["perspective"], &name, notes),
        Checked::Valid(Type::Orthographic) => orthographic(&raw["orthographic"], &name, notes),
        Checked::Invalid => None,
    };
    if projection.is_none() {
        notes.add(format!("camera '{name}' has no valid projection and is left out"));
    }
    Some(CameraDescription { name, projection: projection?, transform, lens: None })
}

fn perspective(raw: &Value, name: &str, notes: &mut Notes) -> Option<Projection> {
    let yfov = raw["yfov"].as_f64().filter(|&angle| angle > 0.0 && angle < PI)?;
    let aspect = raw["aspectRatio"].as_f64().filter(|&ratio| ratio > 0.0);
    if aspect.is_none() && raw.get("aspectRatio").is_some() {
        notes.add(format!("camera '{name}' has an aspect ratio that is not positive: it is taken not to have any"));
    }
    Some(Projection::Perspective { yfov, aspect })
}

fn orthographic(raw: &Value, name: &str, notes: &mut Notes) -> Option<Projection> {
    let half = |key: &str| raw[key].as_f64().filter(|&x| x != 0.0);
    let [xmag, ymag] = [half("xmag")?, half("ymag")?];
    if xmag < 0.0 || ymag < 0.0 {
        notes.add(format!("camera '{name}' has a negative magnification, whose sign is ignored"));
    }
    Some(Projection::Orthographic { xmag: xmag.abs(), ymag: ymag.abs() })
}
