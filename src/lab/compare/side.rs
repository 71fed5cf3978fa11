//! One of the two images of a comparison: its colours, their standard errors, and its header.

use crate::error::{Error, Result};
use crate::film::pyramid::RECORD;
use crate::film::{Crop, Independent};
use crate::integrator::Method;
use crate::io::exr::{self, Attribute, ExrImage};
use crate::named::Named;
use serde::Serialize;
use std::path::Path;

/// Provenance of an image, as far as its header tells it.
#[derive(Debug, Clone, Serialize)]
pub struct Origin {
    /// Its file.
    pub path: String,
    /// The method that rendered it.
    pub method: Option<String>,
    /// Samples per pixel.
    pub spp: Option<u64>,
    /// The seed of its random numbers.
    pub seed: Option<u64>,
    /// Independent replicates behind its standard errors.
    pub replicates: Option<u64>,
    /// Hash of the scene.
    pub scene: Option<String>,
    /// Hash of the settings.
    pub settings: Option<String>,
    /// Its own estimate of relMSE with a 95 % interval: value, lower end, upper end.
    pub relmse: Option<[f32; 3]>,
    /// Hash of its pixels and layers as read.
    pub pixel_hash: String,
    /// Whether this hash matches the one in the header: `false` if pixels or layers were changed after rendering.
    pub hash_matches: Option<bool>,
}

/// An image in memory.
#[derive(Debug)]
pub(super) struct Side {
    pub(super) origin: Origin,
    pub(super) size: [u32; 2],
    pub(super) crop: Crop,
    /// Colours within the crop, `RGBRGB…`.
    pub(super) colors: Vec<f32>,
    /// Their standard errors.
    pub(super) errors: Option<Vec<f32>>,
    /// The record of its tiles: see [`RECORD`].
    pub(super) record: Option<String>,
}

impl Side {
    pub(super) fn read(path: &Path) -> Result<Side> {
        let image = exr::read(path)?;
        let missing = || Error::usage(format!("{} has no channels R, G and B", path.display()));
        let colors = image.rgb("").ok_or_else(missing)?;
        Ok(Side {
            origin: Origin::of(path, &image),
            size: [image.width, image.height],
            crop: image.crop,
            errors: image.rgb("stderr."),
            record: Header(&image).text(RECORD),
            colors,
        })
    }
}

impl Origin {
    /// Units of the image that are independent; `None` for an unknown method.
    pub(super) fn independent(&self) -> Option<Independent> {
        let method = Method::of_name(self.method.as_deref()?)?;
        Some(method.independent())
    }

    fn of(path: &Path, image: &ExrImage) -> Origin {
        let header = Header(image);
        let pixel_hash = image.hash_pixels();
        let relmse = ["value", "low", "high"].map(|end| header.float(&format!("etendue.error.relmse.{end}")));
        Origin {
            path: path.display().to_string(),
            method: header.text("etendue.settings.method"),
            spp: header.whole("etendue.render.spp"),
            seed: header.whole("etendue.settings.seed"),
            replicates: header.whole("etendue.error.replicates"),
            scene: header.text("etendue.scene.hash"),
            settings: header.text("etendue.settings_hash"),
            relmse: match relmse {
                [Some(value), Some(low), high] => Some([value, low, high.unwrap_or(f32::INFINITY)]),
                _ => None,
            },
            hash_matches: header.text("etendue.pixel_hash").map(|hash| hash == pixel_hash),
            pixel_hash,
        }
    }
}

/// Attributes that the report left in an image.
struct Header<'a>(&'a ExrImage);

impl Header<'_> {
    fn text(&self, name: &str) -> Option<String> {
        match self.0.attributes.get(name)? {
            Attribute::Text(text) => Some(text.clone()),
            _ => None,
        }
    }

    fn float(&self, name: &str) -> Option<f32> {
        match self.0.attributes.get(name)? {
            Attribute::Float(x) => Some(*x),
            Attribute::Int(i) => Some(*i as f32),
            Attribute::Text(_) => None,
        }
    }

    /// Returns an integer attribute. Integers that an attribute cannot hold are stored as text.
    fn whole(&self, name: &str) -> Option<u64> {
        match self.0.attributes.get(name)? {
            Attribute::Int(i) => u64::try_from(*i).ok(),
            Attribute::Text(text) => text.parse().ok(),
            Attribute::Float(_) => None,
        }
    }
}
