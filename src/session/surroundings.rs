//! An environment that replaces the scene's own one. It belongs to the scene and not to the settings: the content of
//! its file enters the scene's hash, the file's path does not.

use crate::error::{Error, Result};
use crate::io::environment;
use crate::scene::description::{self, Description};
use crate::spectrum::Spectrum;
use crate::texture::RadianceMap;
use std::path::{Path, PathBuf};
use std::str::FromStr;
use std::sync::Arc;

/// Largest scale: [`RadianceMap::BRIGHTEST`] times this stays well inside the range of f32.
const LARGEST_SCALE: f32 = 1e6;

/// Environment radiance: a constant (one number, or linear red, green, blue), or a file with a map.
#[derive(Debug, Clone, PartialEq, serde::Serialize, serde::Deserialize)]
#[serde(try_from = "EnvironmentText")]
pub enum EnvironmentChoice {
    /// The same radiance from every direction.
    Radiance([f32; 3]),
    /// An .exr or .hdr file in latitude-longitude layout.
    File(PathBuf),
}

/// Textual forms of an environment in a file.
#[derive(serde::Deserialize)]
#[serde(untagged)]
enum EnvironmentText {
    Grey(f32),
    Rgb([f32; 3]),
    Text(String),
    Recorded(Recorded),
}

/// Serialised form of [`EnvironmentChoice`].
#[derive(serde::Deserialize)]
enum Recorded {
    Radiance([f32; 3]),
    File(PathBuf),
}

impl EnvironmentChoice {
    fn checked(rgb: [f32; 3]) -> std::result::Result<Self, String> {
        if rgb.iter().all(|v| (0.0..=RadianceMap::BRIGHTEST).contains(v)) {
            Ok(EnvironmentChoice::Radiance(rgb))
        } else {
            Err(format!("an environment's radiance must be from 0 to {:e}", RadianceMap::BRIGHTEST))
        }
    }

    /// Resolves a relative path against `folder`.
    pub(crate) fn seen_from(self, folder: &Path) -> Self {
        match self {
            EnvironmentChoice::File(path) => EnvironmentChoice::File(folder.join(path)),
            radiance => radiance,
        }
    }
}

impl FromStr for EnvironmentChoice {
    type Err = String;

    fn from_str(text: &str) -> std::result::Result<Self, String> {
        let numbers: Option<Vec<f32>> = text.split(',').map(|n| n.trim().parse().ok()).collect();
        match numbers.as_deref() {
            Some(&[grey]) => EnvironmentChoice::checked([grey; 3]),
            Some(&[r, g, b]) => EnvironmentChoice::checked([r, g, b]),
            _ if environment::is_supported(Path::new(text)) => Ok(EnvironmentChoice::File(text.into())),
            _ => Err(format!(
                "'{text}' is not an environment: write one number, R,G,B, or the name of an .exr or .hdr file"
            )),
        }
    }
}

impl TryFrom<EnvironmentText> for EnvironmentChoice {
    type Error = String;

    fn try_from(text: EnvironmentText) -> std::result::Result<Self, String> {
        match text {
            EnvironmentText::Grey(v) => EnvironmentChoice::checked([v; 3]),
            EnvironmentText::Rgb(rgb) | EnvironmentText::Recorded(Recorded::Radiance(rgb)) => {
                EnvironmentChoice::checked(rgb)
            }
            EnvironmentText::Text(text) => text.parse(),
            EnvironmentText::Recorded(Recorded::File(path)) => Ok(EnvironmentChoice::File(path)),
        }
    }
}

/// An environment with its placement.
#[derive(Debug, Clone, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct Surroundings {
    /// The environment.
    pub environment: EnvironmentChoice,
    /// Rotation of a map about the up axis, in degrees, counter-clockwise seen from above.
    pub rotation: f64,
    /// Factor of its radiance.
    pub scale: f32,
    /// Layer or part of the file, if one was named.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub layer: Option<String>,
}

impl Surroundings {
    /// Validates the choices: `rotation` applies to maps, `scale` to any environment.
    ///
    /// # Errors
    /// A rotation, scale or layer is out of range, or given without an environment that it applies to.
    pub(super) fn chosen(
        environment: Option<&EnvironmentChoice>,
        rotation: Option<f64>,
        scale: Option<f32>,
        layer: Option<&str>,
    ) -> Result<Option<Surroundings>> {
        if scale.is_some_and(|s| !(0.0..=LARGEST_SCALE).contains(&s)) {
            return Err(Error::usage(format!("env-scale must be from 0 to {LARGEST_SCALE:e}")));
        }
        if rotation.is_some_and(|r| !r.is_finite()) {
            return Err(Error::usage("env-rotation must be finite"));
        }
        if rotation.is_some() && !matches!(environment, Some(EnvironmentChoice::File(_))) {
            return Err(Error::usage("env-rotation turns a map: give its file as env"));
        }
        if layer.is_some() && !matches!(environment, Some(EnvironmentChoice::File(_))) {
            return Err(Error::usage("env-layer chooses from a map: give its file as env"));
        }
        if scale.is_some() && environment.is_none() {
            return Err(Error::usage("env-scale scales an environment: give one as env"));
        }
        let (rotation, scale) = (rotation.unwrap_or(0.0), scale.unwrap_or(1.0));
        let layer = layer.map(str::to_owned);
        Ok(environment.cloned().map(|environment| Surroundings { environment, rotation, scale, layer }))
    }

    /// Returns the surroundings with an absolute path, for another process in another folder.
    pub fn absolute(&self) -> Self {
        let environment = match &self.environment {
            EnvironmentChoice::File(path) => {
                EnvironmentChoice::File(std::path::absolute(path).unwrap_or_else(|_| path.clone()))
            }
            radiance => radiance.clone(),
        };
        Surroundings { environment, ..self.clone() }
    }

    /// Returns the surroundings with the file's name only, for reports.
    pub(super) fn without_folder(&self) -> Self {
        let environment = match &self.environment {
            EnvironmentChoice::File(path) => EnvironmentChoice::File(path.file_name().unwrap_or_default().into()),
            radiance => radiance.clone(),
        };
        Surroundings { environment, ..self.clone() }
    }

    /// Adds the environment to `description`, reading its map if it has one.
    ///
    /// # Errors
    /// The map cannot be read.
    pub(super) fn surround(&self, description: &mut Description) -> Result<()> {
        let environment = match &self.environment {
            EnvironmentChoice::Radiance(rgb) => {
                description::EnvironmentDescription::Uniform(Spectrum::from_rgb(*rgb) * self.scale)
            }
            EnvironmentChoice::File(path) => {
                let loaded = environment::load(path, self.layer.as_deref())?;
                description.warnings.extend(loaded.warnings);
                description.ignored.extend(loaded.lost);
                description::EnvironmentDescription::Map {
                    map: Arc::new(loaded.map),
                    scale: self.scale,
                    rotation: self.rotation,
                }
            }
        };
        description.environment = Some(environment);
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::error::Kind;

    #[test]
    fn environments_are_radiances_or_files() {
        assert_eq!("0.5".parse(), Ok(EnvironmentChoice::Radiance([0.5; 3])));
        assert_eq!("1, 2, 3".parse(), Ok(EnvironmentChoice::Radiance([1.0, 2.0, 3.0])));
        assert_eq!("a/b.EXR".parse(), Ok(EnvironmentChoice::File("a/b.EXR".into())));
        for wrong in ["-1", "inf", "NaN", "1,2", "", "sky.png", "exr", ".hdr"] {
            assert!(wrong.parse::<EnvironmentChoice>().is_err(), "{wrong}");
        }
    }

    #[test]
    fn what_is_recorded_is_read_back() {
        for environment in [EnvironmentChoice::Radiance([0.1, 0.2, 0.3]), EnvironmentChoice::File("/a/sky.hdr".into())]
        {
            let surroundings =
                Surroundings { environment, rotation: 30.5, scale: 0.1, layer: Some("ViewLayer".into()) };
            let back: Surroundings = serde_json::from_value(serde_json::json!(surroundings)).unwrap();
            assert_eq!(back, surroundings);
        }
    }

    #[test]
    fn rotation_and_scale_want_something_to_act_on() {
        let (file, grey) = (EnvironmentChoice::File("a.hdr".into()), EnvironmentChoice::Radiance([1.0; 3]));
        let choose =
            |env: Option<&EnvironmentChoice>, rotation, scale| Surroundings::chosen(env, rotation, scale, None);
        assert!(choose(None, None, None).unwrap().is_none());
        assert_eq!(choose(Some(&grey), None, Some(2.0)).unwrap().unwrap().scale, 2.0);
        assert_eq!(choose(Some(&file), Some(-90.0), None).unwrap().unwrap().rotation, -90.0);
        for (env, rotation, scale) in [
            (None, Some(1.0), None),
            (Some(&grey), Some(1.0), None),
            (None, None, Some(1.0)),
            (Some(&file), Some(f64::NAN), None),
            (Some(&file), None, Some(-1.0)),
            (Some(&file), None, Some(f32::INFINITY)),
        ] {
            assert_eq!(choose(env, rotation, scale).unwrap_err().kind, Kind::Usage);
        }
    }
}
