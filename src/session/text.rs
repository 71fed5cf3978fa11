//! Parsers for values on the command line and in `render.toml`: `640x480`, `0,0,64,64`, `5m`.

use crate::film::Crop;
use std::str::FromStr;
use std::time::Duration;

/// The largest width or height of an image, in pixels.
const MAX_SIDE: u32 = 1 << 16;

/// Image size; without a height it follows from the camera's aspect ratio.
#[derive(Debug, Clone, Copy, PartialEq, Eq, serde::Deserialize)]
#[serde(try_from = "String")]
pub struct Size {
    /// Width in pixels.
    pub width: u32,
    /// Height in pixels.
    pub height: Option<u32>,
}

/// A rectangle of pixels `x0,y0,x1,y1` from the top left; x1 and y1 are exclusive.
#[derive(Debug, Clone, Copy, PartialEq, Eq, serde::Deserialize)]
#[serde(try_from = "String")]
pub struct Window(pub Crop);

/// A duration such as `30s`, `5m` or `1h 30m`.
#[derive(Debug, Clone, Copy, PartialEq, Eq, serde::Deserialize)]
#[serde(try_from = "String")]
pub struct Budget(pub Duration);

/// A memory size such as `512M`, `4G` or `1.5T`, in powers of 1,000, or of 1,024 with an `i` (`4Gi`).
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Bytes(pub u64);

impl FromStr for Bytes {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let wrong = || format!("'{text}' is not an amount of memory such as 512M or 4G");
        let digits = text.find(|c: char| !c.is_ascii_digit() && c != '.').unwrap_or(text.len());
        let number: f64 = text[..digits].parse().map_err(|_| wrong())?;
        let (unit, base) = match text[digits..].trim().trim_end_matches('B') {
            unit if unit.ends_with('i') => (&unit[..unit.len() - 1], 1024.0_f64),
            unit => (unit, 1000.0),
        };
        let power = ["", "K", "M", "G", "T"].iter().position(|u| u.eq_ignore_ascii_case(unit)).ok_or_else(wrong)?;
        let bytes = number * base.powi(power as i32);
        if (1.0..1e18).contains(&bytes) { Ok(Bytes(bytes as u64)) } else { Err(wrong()) }
    }
}

/// Parses a TOML text.
///
/// # Errors
/// A usage error with the line if it is not TOML or has an unknown key or value.
pub(crate) fn toml<T: serde::de::DeserializeOwned>(text: &str) -> crate::error::Result<T> {
    ::toml::from_str(text).map_err(|e| {
        let line = e.span().map_or(1, |span| 1 + text[..span.start].matches('\n').count());
        crate::error::Error::usage(format!("line {line}: {}", e.message().replace('\n', " ")))
    })
}

/// Formats `bytes` in megabytes with one decimal.
pub fn megabytes(bytes: u64) -> String {
    format!("{:.1} MB", bytes as f64 / 1e6)
}

impl FromStr for Size {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let side = |s: &str| {
            let side = s.trim().parse().ok().filter(|side| (1..=MAX_SIDE).contains(side));
            side.ok_or_else(|| {
                format!("'{text}' is not a size: write WIDTHxHEIGHT or WIDTH, each from 1 to {MAX_SIDE}")
            })
        };
        Ok(match text.split_once('x') {
            Some((width, height)) => Size { width: side(width)?, height: Some(side(height)?) },
            None => Size { width: side(text)?, height: None },
        })
    }
}

impl FromStr for Window {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        match numbers::<u32>(text).as_deref() {
            Some(&[x0, y0, x1, y1]) if x0 < x1 && y0 < y1 => Ok(Window(Crop { x0, y0, x1, y1 })),
            _ => Err(format!("'{text}' is not a rectangle: write X0,Y0,X1,Y1 with X0 < X1 and Y0 < Y1")),
        }
    }
}

impl FromStr for Budget {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let length =
            humantime::parse_duration(text).map_err(|e| format!("'{text}' is not a time such as 30s or 5m: {e}"))?;
        if length.is_zero() { Err("a time budget must be above zero".into()) } else { Ok(Budget(length)) }
    }
}

impl TryFrom<String> for Size {
    type Error = String;

    fn try_from(text: String) -> Result<Self, String> {
        text.parse()
    }
}

impl TryFrom<String> for Window {
    type Error = String;

    fn try_from(text: String) -> Result<Self, String> {
        text.parse()
    }
}

impl TryFrom<String> for Budget {
    type Error = String;

    fn try_from(text: String) -> Result<Self, String> {
        text.parse()
    }
}

/// Parses a comma-separated list of numbers; `None` if an item is not a number.
fn numbers<T: FromStr>(text: &str) -> Option<Vec<T>> {
    text.split(',').map(|n| n.trim().parse().ok()).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn amounts_of_memory_are_read() {
        for (text, bytes) in [
            ("512M", 512_000_000),
            ("4G", 4_000_000_000),
            ("1.5Ki", 1536),
            ("4GiB", 4 << 30),
            ("100", 100),
            ("2 GB", 2_000_000_000),
        ] {
            assert_eq!(text.parse(), Ok(Bytes(bytes)), "{text}");
        }
        for wrong in ["", "G", "-4G", "4X", "4G5", "nan", "1e3", "0", "9999999T"] {
            assert!(wrong.parse::<Bytes>().is_err(), "{wrong}");
        }
    }

    #[test]
    fn sizes_are_read_with_and_without_height() {
        assert_eq!("640x480".parse(), Ok(Size { width: 640, height: Some(480) }));
        assert_eq!("640".parse(), Ok(Size { width: 640, height: None }));
        for wrong in ["", "x", "0x4", "4x0", "640x", "70000", "-1x2", "4x4x4"] {
            assert!(wrong.parse::<Size>().is_err(), "{wrong}");
        }
    }

    #[test]
    fn windows_must_hold_a_pixel() {
        assert_eq!("1,2,3,4".parse(), Ok(Window(Crop { x0: 1, y0: 2, x1: 3, y1: 4 })));
        for wrong in ["1,2,3", "1,2,1,4", "3,2,1,4", "1,2,3,4,5", "a,b,c,d"] {
            assert!(wrong.parse::<Window>().is_err(), "{wrong}");
        }
    }

    #[test]
    fn times_are_read_in_the_usual_units() {
        assert_eq!("30s".parse(), Ok(Budget(Duration::from_secs(30))));
        assert_eq!("1h 30m".parse(), Ok(Budget(Duration::from_secs(5400))));
        for wrong in ["", "0s", "30", "fast"] {
            assert!(wrong.parse::<Budget>().is_err(), "{wrong}");
        }
    }
}
