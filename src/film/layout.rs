//! Pixels and planes of a film.

/// Channels of [`Plane::Color`].
pub(super) const COLOR: usize = 3;

/// Rendered rectangle in pixels: x0 ≤ x < x1, y0 ≤ y < y1, with the origin at the top left.
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
    /// Returns the number of pixels.
    pub fn pixels(&self) -> usize {
        (self.x1 - self.x0) as usize * (self.y1 - self.y0) as usize
    }
}

/// A quantity averaged over the samples of each pixel.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord, serde::Serialize, serde::Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Plane {
    /// Radiance: 3 channels, always present and always first.
    Color,
    /// Coverage: 1 for a hit, 0 for a miss.
    Alpha,
    /// Reflectance at the first hit that is neither a mirror nor glass: 3 channels.
    Albedo,
    /// Shading normal at the same hit, in world space: 3 channels.
    Normal,
    /// Distance from the camera along the ray in scene units, times coverage.
    Depth,
    /// Position in the world space of the file, times coverage: 3 channels.
    Position,
    /// Number of non-finite samples; written as a sum, not a mean.
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

/// Image size, rendered rectangle, and planes of each pixel.
#[derive(Debug, Clone, PartialEq, Eq, Hash, serde::Serialize, serde::Deserialize)]
pub struct Layout {
    /// Width of the full image.
    pub width: u32,
    /// Height of the full image.
    pub height: u32,
    /// Rendered rectangle.
    pub crop: Crop,
    planes: Vec<Plane>,
}

impl Layout {
    /// Returns a layout with colour and the `extra` planes. Depth and position add [`Plane::Alpha`].
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

    /// Returns the planes in storage order; colour is first.
    pub fn planes(&self) -> &[Plane] {
        &self.planes
    }

    /// Returns the number of channels of a pixel over all planes.
    pub fn channels(&self) -> usize {
        self.planes.iter().map(|p| p.channels()).sum()
    }

    /// Returns the offset of a plane's first channel within a pixel, or `None` if the layout lacks the plane.
    pub fn offset(&self, plane: Plane) -> Option<usize> {
        let at = self.planes.iter().position(|&p| p == plane)?;
        Some(self.planes[..at].iter().map(|p| p.channels()).sum())
    }

    /// Returns the number of rendered pixels.
    pub fn pixels(&self) -> usize {
        self.crop.pixels()
    }

    /// Enumerates columns and rows in the full image of the rendered pixels from number `first` on.
    pub fn pixels_from(&self, first: usize) -> impl Iterator<Item = [u32; 2]> + '_ {
        let mut next = self.pixel(first);
        std::iter::from_fn(move || {
            let pixel = next;
            next[0] += 1;
            if next[0] == self.crop.x1 {
                next = [self.crop.x0, next[1] + 1];
            }
            (pixel[1] < self.crop.y1).then_some(pixel)
        })
    }

    /// Returns the index in the full image, row by row, of a pixel by its column and row there.
    #[inline]
    pub fn index(&self, [x, y]: [u32; 2]) -> u64 {
        u64::from(y) * u64::from(self.width) + u64::from(x)
    }

    /// Returns column and row in the full image of the rendered pixel `index` (row by row inside the crop).
    #[inline]
    pub fn pixel(&self, index: usize) -> [u32; 2] {
        let w = (self.crop.x1 - self.crop.x0) as usize;
        let [x, y] = [(index % w) as u32, (index / w) as u32];
        [self.crop.x0 + x, self.crop.y0 + y]
    }
}
