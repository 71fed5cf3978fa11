//! KHR_lights_punctual. Candela become W/sr and lux W/m², with the same numerical values.

use super::document::{Document, name_or};
use super::notes::Notes;
use crate::error::{Error, Result};
use crate::scene::description::{PunctualKind, PunctualLight};
use crate::spectrum::Spectrum;
use ::gltf::json::extensions::scene::khr_lights_punctual::{Light, Type};
use ::gltf::json::{Index, validation::Checked};
use glam::DAffine3;
use std::f32::consts::FRAC_PI_2;

/// Loads the light of a node at `transform`; `None`, and a note, if its parameters are not usable.
///
/// # Errors
/// A scene error that names the light if its intensity is not finite.
pub(super) fn load(
    document: &Document,
    index: Index<Light>,
    transform: DAffine3,
    notes: &mut Notes,
) -> Result<Option<PunctualLight>> {
    let Some(source) = document.root.get(index) else {
        notes.add(format!("light {index} does not exist and is left out"));
        return Ok(None);
    };
    let name = name_or(&source.name, "light", index.value());
    let intensity = Spectrum::from_rgb(source.color) * source.intensity;
    if !intensity.is_finite() {
        return Err(Error::scene(format!("light '{name}' has an intensity that is not finite")));
    }
    if intensity.min_lane() < 0.0 {
        notes.add(format!("light '{name}' has a negative intensity, which is taken for 0"));
    }
    let intensity = intensity.map(|x: f32| x.max(0.0));
    if source.range.is_some() {
        notes.add("the range of lights is not modelled: they fall off with the squared distance for ever");
    }
    let kind = kind(source, &name, notes);
    if kind.is_none() {
        notes.add(format!("light '{name}' has a type or a cone that means nothing and is left out"));
    }
    Ok(kind.map(|kind| PunctualLight { name, kind, intensity, transform }))
}

fn kind(source: &Light, name: &str, notes: &mut Notes) -> Option<PunctualKind> {
    match source.type_ {
        Checked::Valid(Type::Point) => Some(PunctualKind::Point),
        Checked::Valid(Type::Directional) => Some(PunctualKind::Directional),
        Checked::Valid(Type::Spot) => cone(source, name, notes),
        Checked::Invalid => None,
    }
}

/// Returns the cone of a spot. Exporters write equal angles for a sharp edge. glTF forbids this, but its formula covers
/// it.
fn cone(source: &Light, name: &str, notes: &mut Notes) -> Option<PunctualKind> {
    /// KHR_lights_punctual's defaults.
    const WHOLE: (f32, f32) = (0.0, std::f32::consts::FRAC_PI_4);
    if source.spot.is_none() {
        notes.add(format!("light '{name}' is a spot without angles: it has the default ones"));
    }
    let (inner, outer) = source.spot.as_ref().map_or(WHOLE, |spot| (spot.inner_cone_angle, spot.outer_cone_angle));
    if !(outer > 0.0 && inner.is_finite()) {
        return None;
    }
    if outer > FRAC_PI_2 {
        notes.add(format!("light '{name}' has a cone wider than a half space, which is taken for one"));
    }
    let outer = outer.min(FRAC_PI_2);
    if inner >= outer {
        notes.add(format!(
            "light '{name}' has an inner cone that is not inside its outer one: its edge is as sharp as it can be"
        ));
    }
    if inner < 0.0 {
        notes.add(format!("light '{name}' has an inner cone below 0, which is taken for 0"));
    }
    Some(PunctualKind::Spot { inner: inner.max(0.0).min(outer), outer })
}
