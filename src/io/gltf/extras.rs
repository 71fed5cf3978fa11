//! Extras read from a material's `extras.etendue`: `"fresnel": "schlick"` (glTF's, the default) or `"constant"`, and
//! `"priority"`, an integer (default 0). Where bodies overlap, the one of the highest priority takes the volume.
//! `"scattering"` is a coefficient per metre of the medium inside, a number or one for each of red, green and blue;
//! `"phase"` tells how it scatters: `"isotropic"` (the default), `"rayleigh"`, the mean cosine g of Henyey and
//! Greenstein, or `[g, g, share of the first]`. `"density"` is the URI of a grid that multiplies the coefficients, in the
//! coordinates of the mesh: see [`crate::io::volume`].

use crate::error::{Error, Result};
use crate::medium::Phase;
use crate::scene::description::MetalFresnel;
use crate::spectrum::Spectrum;
use ::gltf::json::Extras;
use serde_json::Value;

/// Options in a material's extras.
#[derive(Debug, Default, PartialEq)]
pub(super) struct Asked {
    pub(super) metal_fresnel: MetalFresnel,
    pub(super) priority: i32,
    /// Coefficient per metre, and the phase function; `None` without scattering.
    pub(super) scattering: Option<(Spectrum, Phase)>,
    /// URI of the density of the medium.
    pub(super) density: Option<String>,
}

/// Greatest coefficient of scattering per metre: the mean free path is then above the rounding of a room.
const MOST_SCATTERING: f64 = 1e6;

/// Greatest magnitude of a mean cosine: at 1 light goes straight on.
const MOST_G: f64 = 0.999;

/// Reads the options in a material's extras.
///
/// # Errors
/// A scene error if `etendue` has an unknown key or value, so that misspellings are not silently ignored.
pub(super) fn of_material(extras: &Extras) -> Result<Asked> {
    let parsed: Option<Value> = extras.as_ref().and_then(|raw| serde_json::from_str(raw.get()).ok());
    let Some(ours) = parsed.as_ref().and_then(|v| v.get("etendue")) else { return Ok(Asked::default()) };
    let keys = ours.as_object().ok_or_else(|| Error::scene("extras.etendue is not an object"))?;
    let known = ["fresnel", "priority", "scattering", "phase", "density"];
    if let Some(unknown) = keys.keys().find(|k| !known.contains(&k.as_str())) {
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
    let scattering = keys.get("scattering").map(coefficient).transpose()?;
    let phase = keys.get("phase").map(phase).transpose()?;
    if phase.is_some() && scattering.is_none() {
        return Err(Error::scene("extras.etendue has a phase, but no scattering"));
    }
    let scattering = scattering.map(|scattering| (scattering, phase.unwrap_or(Phase::Isotropic)));
    let uri = |value: &Value| {
        value.as_str().map(str::to_owned).ok_or_else(|| Error::scene("extras.etendue.density is not the URI of a file"))
    };
    let density = keys.get("density").map(uri).transpose()?;
    Ok(Asked { metal_fresnel, priority: priority.transpose()?.unwrap_or(0), scattering, density })
}

/// Reads a coefficient: one number, or three.
fn coefficient(value: &Value) -> Result<Spectrum> {
    let numbers =
        value.as_array().map_or_else(|| vec![value.as_f64(); 3], |list| list.iter().map(Value::as_f64).collect());
    let numbers: Option<Vec<f64>> = numbers.into_iter().collect();
    let valid = |numbers: &Vec<f64>| numbers.len() == 3 && numbers.iter().all(|x| (0.0..=MOST_SCATTERING).contains(x));
    let Some(numbers) = numbers.filter(valid) else {
        let what = "extras.etendue.scattering is neither a number nor three of them, from 0 to";
        return Err(Error::scene(format!("{what} {MOST_SCATTERING:e}")));
    };
    Ok(Spectrum([0, 1, 2].map(|lane| numbers[lane] as f32)))
}

/// Reads a phase function.
fn phase(value: &Value) -> Result<Phase> {
    let g = |value: &Value| value.as_f64().filter(|g| g.abs() <= MOST_G).map(|g| g as f32);
    let found = match value {
        Value::String(name) if name == "isotropic" => Some(Phase::Isotropic),
        Value::String(name) if name == "rayleigh" => Some(Phase::Rayleigh),
        Value::Array(list) => match list.as_slice() {
            [a, b, share] => g(a).zip(g(b)).zip(share.as_f64().filter(|share| (0.0..=1.0).contains(share))),
            _ => None,
        }
        .map(|((a, b), share)| Phase::Mixture([a, b], share as f32)),
        _ => g(value).map(Phase::HenyeyGreenstein),
    };
    let what =
        "extras.etendue.phase is neither \"isotropic\", \"rayleigh\", a mean cosine, nor two of them and a share";
    found.ok_or_else(|| Error::scene(format!("{what} (mean cosines are from -{MOST_G} to {MOST_G})")))
}
