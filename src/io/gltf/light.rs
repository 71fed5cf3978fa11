//! KHR_lights_punctual. Candela become W/sr and lux W/m², number for number.

use super::document::{Document, name_or};
use super::notes::Notes;
use crate::error::{Error, Result};
use crate::scene::description::{PunctualKind, PunctualLight};
use crate::spectrum::Spectrum;
use ::gltf::json::extensions::scene::khr_lights_punctual::{Light, Type};
use ::gltf::json::{Index, validation::Checked};
use glam::DAffine3;
use std::f32::consts::FRAC_PI_2;

/// The light that a node at `transform` refers to.
///
/// # Errors
/// A scene error that names the light if its intensity or its angles are out of range.
pub(super) fn load(document: &Document, index: Index<Light>, transform: DAffine3, notes: &mut Notes) -> Result<PunctualLight> {
    let source = document.root.get(index).ok_or_else(|| Error::scene(format!("light {index} does not exist")))?;
    let name = name_or(&source.name, "light", index.value());
    let intensity = Spectrum::from_rgb(source.color) * source.intensity;
    if !intensity.is_finite() || intensity.min_lane() < 0.0 {
        return Err(Error::scene(format!("light '{name}' has an intensity that is negative or not finite")));
    }
    if source.range.is_some() {
        notes.add("the range of lights is not modelled: they fall off with the squared distance for ever");
    }
    let kind = kind(source).ok_or_else(|| Error::scene(format!("light '{name}' has cone angles out of range")))?;
    Ok(PunctualLight { name, kind, intensity, transform })
}

fn kind(source: &Light) -> Option<PunctualKind> {
    match source.type_ {
        Checked::Valid(Type::Point) => Some(PunctualKind::Point),
        Checked::Valid(Type::Directional) => Some(PunctualKind::Directional),
        Checked::Valid(Type::Spot) => {
            let spot = source.spot.as_ref()?;
            let (inner, outer) = (spot.inner_cone_angle, spot.outer_cone_angle);
            (inner >= 0.0 && inner < outer && outer <= FRAC_PI_2).then_some(PunctualKind::Spot { inner, outer })
        }
        Checked::Invalid => None,
    }
}
