//! The environment that was chosen for a scene, in place of its own. It belongs to the scene and not to the settings: what a
//! file holds enters the scene's hash, where the file lies does not.

use crate::error::{Error, Result};
use crate::io::environment;
use crate::scene::description::{self, Description};
use crate::spectrum::Spectrum;
use crate::texture::RadianceMap;
use std::path::{Path, PathBuf};
use std::str::FromStr;
use std::sync::Arc;

/// The largest scale: with it [`RadianceMap::BRIGHTEST`] is still far inside f32.
const LARGEST_SCALE: f32 = 1e6;

/// What arrives where nothing is hit: a radiance (one number, or linear red, green, blue), or a file with a map of it.
#[derive(Debug, Clone, PartialEq, serde::Serialize, serde::Deserialize)]
#[serde(try_from = "EnvironmentText")]
pub enum Environment {
    /// The same from every direction.
    Radiance([f32; 3]),
    /// An .exr or .hdr file in latitude-longitude layout.
    File(PathBuf),
}

/// The forms an environment takes in a file.
#[derive(serde::Deserialize)]
#[serde(untagged)]
enum EnvironmentText {
    Grey(f32),
    Rgb([f32; 3]),
    Text(String),
    Recorded(Recorded),
}

/// As [`Environment`] is written.
#[derive(serde::Deserialize)]
enum Recorded {
    Radiance([f32; 3]),
    File(PathBuf),
}

impl Environment {
    fn checked(rgb: [f32; 3]) -> std::result::Result<Self, String> {
        if rgb.iter().all(|v| (0.0..=RadianceMap::BRIGHTEST).contains(v)) {
            Ok(Environment::Radiance(rgb))
        } else {
            Err(format!("an environment's radiance must be from 0 to {:e}", RadianceMap::BRIGHTEST))
        }
    }

    /// The same environment, its path seen from `folder` if it is relative.
    pub(super) fn seen_from(self, folder: &Path) -> Self {
        match self {
            Environment::File(path) => Environment::File(folder.join(path)),
            radiance => radiance,
        }
    }
}

impl FromStr for Environment {
    type Err = String;

    fn from_str(text: &str) -> std::result::Result<Self, String> {
        let numbers: Option<Vec<f32>> = text.split(',').map(|n| n.trim().parse().ok()).collect();
        match numbers.as_deref() {
            Some(&[grey]) => Environment::checked([grey; 3]),
            Some(&[r, g, b]) => Environment::checked([r, g, b]),
            _ if environment::is_supported(Path::new(text)) => Ok(Environment::File(text.into())),
            _ => Err(format!("'{text}' is not an environment: write one number, R,G,B, or the name of an .exr or .hdr file")),
        }
    }
}

impl TryFrom<EnvironmentText> for Environment {
    type Error = String;

    fn try_from(text: EnvironmentText) -> std::result::Result<Self, String> {
        match text {
            EnvironmentText::Grey(v) => Environment::checked([v; 3]),
            EnvironmentText::Rgb(rgb) | EnvironmentText::Recorded(Recorded::Radiance(rgb)) => Environment::checked(rgb),
            EnvironmentText::Text(text) => text.parse(),
            EnvironmentText::Recorded(Recorded::File(path)) => Ok(Environment::File(path)),
        }
    }
}

/// An environment and how it is placed.
#[derive(Debug, Clone, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct Surroundings {
    /// What it is.
    pub environment: Environment,
    /// How far a map is turned about the up axis, in degrees, counter-clockwise seen from above.
    pub rotation: f64,
    /// What its radiance is multiplied by.
    pub scale: f32,
    /// The layer or part of a file, if one was named.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub layer: Option<String>,
}

impl Surroundings {
    /// What was chosen: `rotation` is for maps, `scale` for any environment.
    ///
    /// # Errors
    /// A rotation, scale or layer without what it is about, or out of range.
    pub(super) fn chosen(
        environment: Option<&Environment>,
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
        if rotation.is_some() && !matches!(environment, Some(Environment::File(_))) {
            return Err(Error::usage("env-rotation turns a map: give its file as env"));
        }
        if layer.is_some() && !matches!(environment, Some(Environment::File(_))) {
            return Err(Error::usage("env-layer chooses from a map: give its file as env"));
        }
        if scale.is_some() && environment.is_none() {
            return Err(Error::usage("env-scale scales an environment: give one as env"));
        }
        let (rotation, scale) = (rotation.unwrap_or(0.0), scale.unwrap_or(1.0));
        let layer = layer.map(str::to_owned);
        Ok(environment.cloned().map(|environment| Surroundings { environment, rotation, scale, layer }))
    }

    /// The same surroundings, as another process in another folder will find them.
    pub fn absolute(&self) -> Self {
        let environment = match &self.environment {
            Environment::File(path) => Environment::File(std::path::absolute(path).unwrap_or_else(|_| path.clone())),
            radiance => radiance.clone(),
        };
        Surroundings { environment, ..self.clone() }
    }

    /// The same surroundings for reports, a file by its name alone.
    pub(super) fn without_folder(&self) -> Self {
        let environment = match &self.environment {
            Environment::File(path) => Environment::File(path.file_name().unwrap_or_default().into()),
            radiance => radiance.clone(),
        };
        Surroundings { environment, ..self.clone() }
    }

    /// Reads what must be read and puts it around `description`.
    ///
    /// # Errors
    /// A map that cannot be read.
    pub(super) fn surround(&self, description: &mut Description) -> Result<()> {
        let environment = match &self.environment {
            Environment::Radiance(rgb) => description::Environment::Uniform(Spectrum::from_rgb(*rgb) * self.scale),
            Environment::File(path) => {
                let loaded = environment::load(path, self.layer.as_deref())?;
                description.warnings.extend(loaded.warnings);
                description.ignored.extend(loaded.lost);
                description::Environment::Map { map: Arc::new(loaded.map), scale: self.scale, rotation: self.rotation }
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
        assert_eq!("0.5".parse(), Ok(Environment::Radiance([0.5; 3])));
        assert_eq!("1, 2, 3".parse(), Ok(Environment::Radiance([1.0, 2.0, 3.0])));
        assert_eq!("a/b.EXR".parse(), Ok(Environment::File("a/b.EXR".into())));
        for wrong in ["-1", "inf", "NaN", "1,2", "", "sky.png", "exr", ".hdr"] {
            assert!(wrong.parse::<Environment>().is_err(), "{wrong}");
        }
    }

    #[test]
    fn what_is_recorded_is_read_back() {
        for environment in [Environment::Radiance([0.1, 0.2, 0.3]), Environment::File("/a/sky.hdr".into())] {
            let surroundings = Surroundings { environment, rotation: 30.5, scale: 0.1, layer: Some("ViewLayer".into()) };
            let back: Surroundings = serde_json::from_value(serde_json::json!(surroundings)).unwrap();
            assert_eq!(back, surroundings);
        }
    }

    #[test]
    fn rotation_and_scale_want_something_to_act_on() {
        let (file, grey) = (Environment::File("a.hdr".into()), Environment::Radiance([1.0; 3]));
        let choose = |env: Option<&Environment>, rotation, scale| Surroundings::chosen(env, rotation, scale, None);
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
