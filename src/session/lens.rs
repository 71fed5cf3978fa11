//! The lens of the camera as the user names it, `--aperture`, `--focus` and `--blades`, and what it is for a scene.
//! glTF has no lenses.

use crate::error::{Error, Result};
use crate::scene::Scene;
use crate::scene::description::Lens;
use std::fmt::Display;
use std::str::FromStr;

/// Height of full-frame film in metres, by which an f-stop is that of a camera's angle of view.
const FILM_HEIGHT: f64 = 0.024;

/// Radii and distances of focus in units of the scene's radius, such that squares and inverses are in the range of f32.
const RANGE: std::ops::RangeInclusive<f64> = 1e-18..=1e18;

/// Opening of a lens.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize, serde::Deserialize)]
#[serde(try_from = "Value", into = "String")]
pub enum Aperture {
    /// f-stop N: the radius is the focal length over 2 N. The focal length is that of a lens which has the camera's
    /// vertical angle of view on full-frame film, 24 mm high, with scene units in metres.
    FStop(f64),
    /// Radius in units of the scene file.
    Radius(f64),
}

/// Plane on which a lens is focused.
#[derive(Debug, Clone, PartialEq, serde::Serialize, serde::Deserialize)]
#[serde(try_from = "Value", into = "String")]
pub enum Focus {
    /// Distance along the camera's axis, in units of the scene file.
    Distance(f64),
    /// Through the centre of the bounding box of the node of this name.
    Node(String),
    /// Through what the camera sees at the centre of this pixel, by column and row from the top left.
    Pixel([u32; 2]),
}

/// A lens as chosen.
#[derive(Debug, Clone, PartialEq)]
pub struct LensSettings {
    /// Opening.
    pub aperture: Aperture,
    /// Plane of focus.
    pub focus: Focus,
    /// Number of blades of the aperture, at least 3; 0 for a round one.
    pub blades: u32,
}

/// A number or a text of render.toml.
#[derive(serde::Deserialize)]
#[serde(untagged)]
enum Value {
    Number(f64),
    Text(String),
}

impl LensSettings {
    /// Combines the choices; `None` if there is no lens.
    ///
    /// # Errors
    /// An aperture without a focus, a focus or blades without an aperture, fewer than 3 blades.
    pub fn chosen(aperture: Option<Aperture>, focus: Option<Focus>, blades: Option<u32>) -> Result<Option<Self>> {
        if blades.is_some_and(|blades| blades == 1 || blades == 2 || blades > Lens::MOST_BLADES) {
            let most = Lens::MOST_BLADES;
            return Err(Error::usage(format!("blades must be from 3 to {most}, or 0 for a round aperture")));
        }
        match (aperture, focus) {
            // A pinhole is in focus everywhere.
            (Some(Aperture::Radius(radius)), _) if radius <= 0.0 => Ok(None),
            (Some(aperture), Some(focus)) => Ok(Some(LensSettings { aperture, focus, blades: blades.unwrap_or(0) })),
            (Some(_), None) => {
                Err(Error::usage("an aperture needs a focus: a distance such as 2.5, node:NAME or pixel:X,Y"))
            }
            (None, Some(_)) => Err(Error::usage("a focus needs an aperture, such as f/2.8 or a radius")),
            (None, None) if blades.is_some() => Err(Error::usage("blades need an aperture, such as f/2.8 or a radius")),
            (None, None) => Ok(None),
        }
    }

    /// Resolves the lens for the camera `selector` of `scene` and an image of `width` × `height` pixels.
    ///
    /// # Errors
    /// A usage error if there is no such camera, if it is orthographic, if the plane of focus is not in front of it
    /// (there is no such node, or nothing at that pixel), or if a length is out of range.
    pub fn resolve(&self, scene: &Scene, selector: Option<&str>, width: u32, height: u32) -> Result<Lens> {
        let yfov = scene.yfov(selector)?.ok_or_else(|| Error::usage("an orthographic camera has no lens"))?;
        let radius = self.aperture.radius(yfov);
        let focus = match &self.focus {
            Focus::Distance(distance) => *distance,
            Focus::Node(name) => scene.depth_of_node(selector, name)?,
            &Focus::Pixel(pixel) => scene.depth_of_pixel(selector, [width, height], pixel)?,
        };
        if [radius, focus].iter().any(|length| !RANGE.contains(&(length * scene.rebase().scale))) {
            let sizes = format!("a radius of {radius:e} and a focus at {focus:e}");
            return Err(Error::usage(format!("{sizes} are beyond what single precision tells apart in this scene")));
        }
        Ok(Lens { radius, focus, blades: self.blades, rotation: 0.0 })
    }
}

impl Aperture {
    /// Returns the radius for a camera with the vertical angle of view `yfov` in radians.
    fn radius(self, yfov: f64) -> f64 {
        match self {
            Aperture::Radius(radius) => radius,
            Aperture::FStop(stop) => {
                let focal_length = 0.5 * FILM_HEIGHT / (0.5 * yfov).tan();
                focal_length / (2.0 * stop)
            }
        }
    }
}

/// Parses a positive finite number.
fn positive(text: &str) -> Option<f64> {
    text.trim().parse().ok().filter(|&number: &f64| number > 0.0 && number.is_finite())
}

impl FromStr for Aperture {
    type Err = String;

    fn from_str(text: &str) -> std::result::Result<Self, String> {
        let stop = text.trim().strip_prefix("f/").or_else(|| text.trim().strip_prefix("F/"));
        let found = match stop {
            Some(stop) => positive(stop).map(Aperture::FStop),
            None => positive(text).or((text.trim() == "0").then_some(0.0)).map(Aperture::Radius),
        };
        found.ok_or_else(|| {
            format!("'{text}' is not an aperture: write an f-stop such as f/2.8, or a radius such as 0.05")
        })
    }
}

impl FromStr for Focus {
    type Err = String;

    fn from_str(text: &str) -> std::result::Result<Self, String> {
        let found = if let Some(name) = text.strip_prefix("node:") {
            (!name.is_empty()).then(|| Focus::Node(name.to_owned()))
        } else if let Some(pixel) = text.strip_prefix("pixel:") {
            let number = |n: &str| n.trim().parse().ok();
            pixel.split_once(',').and_then(|(x, y)| Some(Focus::Pixel([number(x)?, number(y)?])))
        } else {
            positive(text).map(Focus::Distance)
        };
        found.ok_or_else(|| format!("'{text}' is not a focus: write a distance such as 2.5, node:NAME, or pixel:X,Y"))
    }
}

impl Display for Aperture {
    fn fmt(&self, f: &mut std::fmt::Formatter) -> std::fmt::Result {
        match self {
            Aperture::FStop(stop) => write!(f, "f/{stop}"),
            Aperture::Radius(radius) => write!(f, "{radius}"),
        }
    }
}

impl Display for Focus {
    fn fmt(&self, f: &mut std::fmt::Formatter) -> std::fmt::Result {
        match self {
            Focus::Distance(distance) => write!(f, "{distance}"),
            Focus::Node(name) => write!(f, "node:{name}"),
            Focus::Pixel([x, y]) => write!(f, "pixel:{x},{y}"),
        }
    }
}

impl From<Aperture> for String {
    fn from(aperture: Aperture) -> String {
        aperture.to_string()
    }
}

impl From<Focus> for String {
    fn from(focus: Focus) -> String {
        focus.to_string()
    }
}

impl TryFrom<Value> for Aperture {
    type Error = String;

    fn try_from(value: Value) -> std::result::Result<Self, String> {
        value.text().parse()
    }
}

impl TryFrom<Value> for Focus {
    type Error = String;

    fn try_from(value: Value) -> std::result::Result<Self, String> {
        value.text().parse()
    }
}

impl Value {
    fn text(self) -> String {
        match self {
            Value::Number(number) => number.to_string(),
            Value::Text(text) => text,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn apertures_and_focuses_survive_their_text() {
        for text in ["f/2.8", "f/16", "0.05", "0"] {
            let aperture: Aperture = text.parse().expect("valid");
            assert_eq!(aperture.to_string(), text);
        }
        for text in ["2.5", "node:Left chair", "node:pixel:1,2", "pixel:3,40"] {
            let focus: Focus = text.parse().expect("valid");
            assert_eq!(focus.to_string(), text);
        }
        assert_eq!("F/2".parse(), Ok(Aperture::FStop(2.0)));
        assert_eq!("pixel: 3, 40".parse(), Ok(Focus::Pixel([3, 40])));
    }

    /// A normal lens: 50 mm at f/2 has an entrance pupil 25 mm wide.
    #[test]
    fn an_f_stop_is_the_focal_length_over_the_diameter() {
        let yfov = 2.0 * (12.0f64 / 50.0).atan();
        assert!((Aperture::FStop(2.0).radius(yfov) - 0.0125).abs() < 1e-15);
        assert!((Aperture::Radius(0.2).radius(yfov) - 0.2).abs() < 1e-15);
    }

    #[test]
    fn numbers_and_text_mean_the_same_in_a_file() {
        #[derive(serde::Deserialize)]
        struct File {
            aperture: Aperture,
            focus: Focus,
        }
        for text in ["aperture = 0.25\nfocus = 3", "aperture = '0.25'\nfocus = '3'"] {
            let File { aperture, focus } = toml::from_str(text).expect("valid");
            assert_eq!((aperture, focus), (Aperture::Radius(0.25), Focus::Distance(3.0)));
        }
    }

    #[test]
    fn nonsense_is_refused_in_one_sentence() {
        for text in ["", "f/", "f/0", "f/-1", "-0.1", "f2.8", "nan", "inf", "f/inf"] {
            let error = text.parse::<Aperture>().expect_err(text);
            assert!(error.contains("is not an aperture: write"), "{error}");
        }
        for text in ["", "0", "-1", "node:", "pixel:", "pixel:1", "pixel:-1,2", "pixel:1,2,3", "inf", "near"] {
            let error = text.parse::<Focus>().expect_err(text);
            assert!(error.contains("is not a focus: write"), "{error}");
        }
    }

    #[test]
    fn a_lens_needs_an_aperture_and_a_focus() {
        let (aperture, focus) = (Some(Aperture::FStop(2.0)), Some(Focus::Distance(1.0)));
        assert!(LensSettings::chosen(None, None, None).expect("no lens").is_none());
        assert!(LensSettings::chosen(Some(Aperture::Radius(0.0)), None, None).expect("a pinhole").is_none());
        assert_eq!(
            LensSettings::chosen(aperture, focus.clone(), None).expect("valid").map(|lens| lens.blades),
            Some(0)
        );
        assert!(LensSettings::chosen(aperture, None, None).is_err());
        assert!(LensSettings::chosen(None, focus.clone(), None).is_err());
        assert!(LensSettings::chosen(None, None, Some(6)).is_err());
        assert!(LensSettings::chosen(aperture, focus.clone(), Some(2)).is_err());
        assert!(LensSettings::chosen(aperture, focus, Some(3)).is_ok());
    }
}
