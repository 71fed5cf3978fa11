//! Which pixels and which planes a film holds.

use crate::defects::{Defect, planted};

/// The rectangle of pixels that is rendered: x0 ≤ x < x1, y0 ≤ y < y1, from the top left.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, serde::Serialize, serde::Deserialize)]
pub struct Crop {
    /// First column.
    pub x0: u32,
    /// First row.
    pub y0: u32,
    /// Column past the last.
    pub x1: u32,
    /// Row past the last.
    pub y1: u32,
}

impl Crop {
    /// How many pixels it has.
    pub fn pixels(&self) -> usize {
        (self.x1 - self.x0) as usize * (self.y1 - self.y0) as usize
    }
}

/// A quantity averaged over the samples of each pixel.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord, serde::Serialize, serde::Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Plane {
    /// Radiance: 3 channels, always there and always first.
    Color,
    /// Coverage: 1 where something was hit, 0 where nothing was.
    Alpha,
    /// Reflectance at the first hit that is not a mirror or glass: 3 channels.
    Albedo,
    /// Shading normal there, world space: 3 channels.
    Normal,
    /// Distance from the camera along the ray in scene units, times coverage.
    Depth,
    /// Position in the file's world space, times coverage: 3 channels.
    Position,
    /// How many samples were not finite (a sum and not a mean when written).
    Invalid,
}

impl Plane {
    /// The number of channels.
    pub fn channels(self) -> usize {
        match self {
            Plane::Color | Plane::Albedo | Plane::Normal | Plane::Position => 3,
            Plane::Alpha | Plane::Depth | Plane::Invalid => 1,
        }
    }
}

/// Image size, the rectangle that is rendered, and the planes of each pixel.
#[derive(Debug, Clone, PartialEq, Eq, Hash, serde::Serialize, serde::Deserialize)]
pub struct Layout {
    /// Width of the full image.
    pub width: u32,
    /// Height of the full image.
    pub height: u32,
    /// What of it is rendered.
    pub crop: Crop,
    planes: Vec<Plane>,
}

impl Layout {
    /// A layout with colour and the `extra` planes. A plane that needs coverage brings [`Plane::Alpha`] along.
    pub fn new(width: u32, height: u32, crop: Option<Crop>, extra: &[Plane]) -> Self {
        let mut planes = vec![Plane::Color];
        planes.extend_from_slice(extra);
        if planes.iter().any(|p| matches!(p, Plane::Depth | Plane::Position)) {
            planes.push(Plane::Alpha);
        }
        planes.sort_unstable();
        planes.dedup();
        Layout { width, height, crop: crop.unwrap_or(Crop { x0: 0, y0: 0, x1: width, y1: height }), planes }
    }

    /// The planes in storage order; colour is first.
    pub fn planes(&self) -> &[Plane] {
        &self.planes
    }

    /// Channels of one pixel over all planes.
    pub fn channels(&self) -> usize {
        self.planes.iter().map(|p| p.channels()).sum()
    }

    /// Where a plane's first channel is within a pixel, if the plane is there.
    pub fn offset(&self, plane: Plane) -> Option<usize> {
        let at = self.planes.iter().position(|&p| p == plane)?;
        Some(self.planes[..at].iter().map(|p| p.channels()).sum())
    }

    /// How many pixels are rendered.
    pub fn pixels(&self) -> usize {
        self.crop.pixels()
    }

    /// Column and row in the full image of the rendered pixel `index` (row by row inside the crop).
    #[inline]
    pub fn pixel(&self, index: usize) -> [u32; 2] {
        let w = (self.crop.x1 - self.crop.x0) as usize;
        let [x, y] = [(index % w) as u32, (index / w) as u32];
        if planted(Defect::CropAtOrigin) { [x, y] } else { [self.crop.x0 + x, self.crop.y0 + y] }
    }
}
