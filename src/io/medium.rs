//! Media as tables of options, in materials of glTF files (`extras.etendue`) and in `render.toml` (`[media.NAME]`).
//!
//! `scattering` and `absorption` are coefficients per unit of length, a number or one for each of red, green and blue.
//! In their place `albedo`, a colour, and `mean_free_path`, a length or three, tell what a deep body of the medium
//! looks like under diffuse light: see [`crate::medium::inversion`]. `emission` is the emitted radiance per unit of
//! length; with a `temperature` in kelvins it is the luminance, and the colour is that of a black body. `phase` tells
//! how the medium scatters: `"isotropic"` (the default), `"rayleigh"`, the mean cosine g of Henyey and Greenstein, or
//! `[g, g, share of the first]`. `density` names a grid that multiplies the coefficients: see [`super::volume`].
//! `albedo_grid` names one of one or three channels, which multiplies scattering; what it takes away is absorbed.
//! `emission_grid` names one that multiplies emission, `temperature_grid` one of kelvins: emission is then the
//! luminance of the hottest cell, and the others are as much dimmer as black bodies are.

use super::blackbody;
use super::volume::VolumeGrid;
use crate::error::{Error, Result};
use crate::medium::Phase;
use crate::medium::inversion::invert;
use crate::scene::description::{ColorGrid, DensityGrid, Volume};
use crate::spectrum::Spectrum;
use serde_json::{Map, Value};
use std::ops::RangeInclusive;

/// Greatest coefficient per unit of length: the mean free path is then above the rounding of a room.
const MOST_COEFFICIENT: f64 = 1e6;

/// Greatest magnitude of a mean cosine: at 1 light goes straight on.
pub(crate) const MOST_G: f64 = 0.999;

/// A medium as a table tells it.
#[derive(Debug, Default, PartialEq)]
pub(crate) struct MediumOptions {
    scattering: Option<Spectrum>,
    absorption: Option<Spectrum>,
    emission: Option<Spectrum>,
    phase: Option<Phase>,
    /// URI or path of its density.
    pub(crate) density: Option<String>,
    /// The same of its albedo.
    pub(crate) albedo_grid: Option<String>,
    /// The same of what multiplies its emission.
    pub(crate) emission_grid: Option<String>,
    /// The same of its temperature, in place of that.
    pub(crate) temperature_grid: Option<String>,
}

impl MediumOptions {
    /// Keys of the options; a table may have others, which are not read.
    pub(crate) const KEYS: [&str; 11] = [
        "albedo_grid",
        "emission_grid",
        "temperature_grid",
        "scattering",
        "absorption",
        "albedo",
        "mean_free_path",
        "emission",
        "temperature",
        "phase",
        "density",
    ];

    /// Reads the options in `table`, which errors call `place`.
    ///
    /// # Errors
    /// A scene error for the first value that is out of range or contradicts another.
    pub(crate) fn read(table: &Map<String, Value>, place: &str) -> Result<MediumOptions> {
        let read = |key: &str| table.get(key);
        let numbers = |key: &str, range: RangeInclusive<f64>| {
            read(key).map(|value| numbers(value, range).map_err(|what| Error::scene(format!("{place}.{key} {what}"))))
        };
        let coefficient = |key: &str| numbers(key, 0.0..=MOST_COEFFICIENT).transpose();
        let text = |key: &str| {
            let wrong = || Error::scene(format!("{place}.{key} is not the name of a file"));
            read(key).map(|value| value.as_str().map(str::to_owned).ok_or_else(wrong)).transpose()
        };
        let color = read("temperature").map_or(Ok(Spectrum::ONE), |value| temperature(value, place))?;
        let phase = read("phase").map(|value| phase(value, place)).transpose()?;
        let surface = (
            numbers("albedo", 0.0..=1.0).transpose()?,
            numbers("mean_free_path", MOST_COEFFICIENT.recip()..=f64::from(f32::MAX)).transpose()?,
        );
        let [mut scattering, mut absorption] = [coefficient("scattering")?, coefficient("absorption")?];
        match surface {
            (None, None) => {}
            (Some(albedo), Some(mean_free_path)) if scattering.is_none() && absorption.is_none() => {
                let g = phase.as_ref().map_or(0.0, Phase::mean_cosine);
                let found = invert(albedo, mean_free_path, g);
                (scattering, absorption) = (Some(found.scattering), Some(found.absorption));
            }
            _ => {
                let what = "tells albedo and mean_free_path, or scattering and absorption, but not parts of both";
                return Err(Error::scene(format!("{place} {what}")));
            }
        }
        let options = MediumOptions {
            scattering,
            absorption,
            emission: coefficient("emission")?.map(|emission| emission * color),
            phase,
            density: text("density")?,
            albedo_grid: text("albedo_grid")?,
            emission_grid: text("emission_grid")?,
            temperature_grid: text("temperature_grid")?,
        };
        let colors = ["temperature", "temperature_grid", "emission_grid"];
        let given: Vec<&str> = colors.into_iter().filter(|key| read(key).is_some()).collect();
        if let (&[key, ..], None) = (given.as_slice(), options.emission) {
            return Err(Error::scene(format!("{place} has the key {key}, but no emission")));
        }
        if given.len() > 1 {
            return Err(Error::scene(format!("{place} has more than one of {}", colors.join(", "))));
        }
        if options.phase.is_some() && options.scattering.is_none() {
            return Err(Error::scene(format!("{place} has a phase, but no scattering")));
        }
        Ok(options)
    }

    /// Whether it says anything of a medium.
    pub(crate) fn is_empty(&self) -> bool {
        *self == MediumOptions::default()
    }

    /// Returns `volume` with the coefficients and the phase function that are given.
    pub(crate) fn fill(&self, volume: Volume) -> Volume {
        Volume {
            scattering: self.scattering.unwrap_or(volume.scattering),
            absorption: self.absorption.unwrap_or(volume.absorption),
            emission: self.emission.unwrap_or(volume.emission),
            phase: self.phase.unwrap_or(volume.phase),
            density: volume.density,
            albedo: volume.albedo,
            emission_grid: volume.emission_grid,
        }
    }
}

/// Returns the cells of a file as a density.
///
/// # Errors
/// A scene error if it has several channels, or values out of range.
pub(crate) fn density(grid: VolumeGrid) -> Result<DensityGrid> {
    if grid.channels != 1 {
        return Err(Error::scene(format!("a density has {} channels and not one", grid.channels)));
    }
    DensityGrid::new(grid.size, grid.values, grid.transform)
}

/// Returns the cells of a file as albedos.
///
/// # Errors
/// A scene error if a value is above 1.
pub(crate) fn albedo(grid: VolumeGrid) -> Result<ColorGrid> {
    ColorGrid::albedos(grid.size, colors(&grid), grid.transform)
}

/// Returns the cells of a file as factors of emission.
///
/// # Errors
/// A scene error if a value is negative.
pub(crate) fn emission(grid: VolumeGrid) -> Result<ColorGrid> {
    ColorGrid::emission(grid.size, colors(&grid), grid.transform)
}

/// Returns the cells of a file, in kelvins, as factors of emission: the colours of black bodies, of which the hottest
/// has the luminance 1.
///
/// # Errors
/// A scene error if it has several channels, or a value is negative or above 1e6.
pub(crate) fn temperatures(grid: VolumeGrid) -> Result<ColorGrid> {
    if grid.channels != 1 {
        return Err(Error::scene(format!("a temperature grid has {} channels and not one", grid.channels)));
    }
    let most = *blackbody::TEMPERATURES.end();
    let is_wrong = |kelvin: &f32| !(0.0..=most).contains(&f64::from(*kelvin));
    if let Some(index) = grid.values.iter().position(is_wrong) {
        let kelvin = grid.values[index];
        return Err(Error::scene(format!("the temperature of cell {index} is {kelvin}, not from 0 to {most:e}")));
    }
    let hottest = grid.values.iter().fold(0.0f32, |most, &kelvin| most.max(kelvin));
    let ramp = blackbody::Ramp::up_to(hottest.into());
    let values = grid.values.iter().map(|&kelvin| ramp.at(kelvin.into()).0).collect();
    ColorGrid::emission(grid.size, values, grid.transform)
}

/// Returns cells of one channel or three as colours.
fn colors(grid: &VolumeGrid) -> Vec<[f32; 3]> {
    let color = |cell: &[f32]| [cell[0], cell[cell.len() / 2], cell[cell.len() - 1]];
    grid.values.chunks_exact(grid.channels).map(color).collect()
}

/// Reads one number for all lanes, or three; or says what they should be.
fn numbers(value: &Value, range: RangeInclusive<f64>) -> std::result::Result<Spectrum, String> {
    let numbers =
        value.as_array().map_or_else(|| vec![value.as_f64(); 3], |list| list.iter().map(Value::as_f64).collect());
    let numbers: Option<Vec<f64>> = numbers.into_iter().collect();
    let valid = |numbers: &Vec<f64>| numbers.len() == 3 && numbers.iter().all(|x| range.contains(x));
    let numbers = numbers.filter(valid);
    let wrong = || format!("is neither a number nor three of them, from {} to {:e}", range.start(), range.end());
    numbers.map(|numbers| Spectrum([0, 1, 2].map(|lane| numbers[lane] as f32))).ok_or_else(wrong)
}

/// Reads a temperature and returns its colour of luminance 1.
fn temperature(value: &Value, place: &str) -> Result<Spectrum> {
    let kelvin = value.as_f64().filter(|kelvin| blackbody::TEMPERATURES.contains(kelvin));
    let (least, most) = (blackbody::TEMPERATURES.start(), blackbody::TEMPERATURES.end());
    let wrong = || Error::scene(format!("{place}.temperature is no number of kelvins from {least} to {most}"));
    Ok(blackbody::color(kelvin.ok_or_else(wrong)?))
}

/// Reads a phase function.
fn phase(value: &Value, place: &str) -> Result<Phase> {
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
        format!("{place}.phase is neither \"isotropic\", \"rayleigh\", a mean cosine, nor two of them and a share");
    found.ok_or_else(|| Error::scene(format!("{what} (mean cosines are from -{MOST_G} to {MOST_G})")))
}
