//! Emission of a triangle: constant, or with texture, colours and alpha that vary over it.

use super::parts::centroids;
use crate::spectrum::Spectrum;
use crate::texture::Texture;
use glam::Vec2;
use std::sync::Arc;

/// Emission of a triangle.
#[derive(Debug, Clone)]
pub struct Emission {
    /// Radiance, or the factor of the texture.
    pub radiance: Spectrum,
    /// Texture, and texture coordinates at the corners.
    pub texture: Option<Box<(Arc<Texture>, [Vec2; 3])>>,
    /// Factors at the corners, if they differ.
    pub corners: Option<Box<[Spectrum; 3]>>,
    /// Whether the back emits like the front.
    pub two_sided: bool,
    /// Whether the emission is visible but does not illuminate (KHR_materials_unlit). It is never sampled, and only
    /// camera rays hit it, directly or by mirrors and clear glass.
    pub only_seen: bool,
    /// Alpha over the triangle, unless it is 1 everywhere.
    pub coverage: Option<Box<Coverage>>,
}

/// Alpha over a triangle. A ray hit has already passed the alpha test; a point sampled on the triangle has not.
#[derive(Debug, Clone)]
pub struct Coverage {
    /// Alpha factor at the corners.
    pub corners: [f32; 3],
    /// Texture whose alpha multiplies the factor, and texture coordinates at the corners.
    pub texture: Option<(Arc<Texture>, [Vec2; 3])>,
    /// Alpha below the cutoff is 0 and otherwise 1 (mask); `None` for blending.
    pub cutoff: Option<f32>,
}

impl Coverage {
    /// Whether alpha is 0 everywhere.
    fn is_nothing(&self) -> bool {
        let most = self.corners.into_iter().fold(0.0, f32::max);
        let textured = self.texture.as_ref().map_or(1.0, |(t, uvs)| t.extremes(uvs.iter().copied()).max[3]);
        match self.cutoff {
            Some(cutoff) => most * textured < cutoff,
            None => most * textured <= 0.0,
        }
    }

    fn at(&self, barycentric: [f32; 2]) -> f32 {
        let mut alpha = mix(&self.corners, barycentric);
        if let Some((texture, uvs)) = &self.texture {
            alpha *= texture.at(mix(uvs, barycentric))[3];
        }
        match self.cutoff {
            Some(cutoff) => f32::from(u8::from(alpha >= cutoff)),
            None => alpha.clamp(0.0, 1.0),
        }
    }
}

/// Interpolates between three corners.
fn mix<V: Copy + std::ops::Mul<f32, Output = V> + std::ops::Add<Output = V>>(corners: &[V; 3], [u, v]: [f32; 2]) -> V {
    corners[0] * (1.0 - u - v) + corners[1] * u + corners[2] * v
}

impl Emission {
    /// No emission.
    pub const NONE: Emission = Emission {
        radiance: Spectrum::ZERO,
        texture: None,
        corners: None,
        two_sided: false,
        only_seen: false,
        coverage: None,
    };

    /// Whether the triangle emits nothing: the factor or all texels within it are black, or alpha is 0.
    pub fn is_black(&self) -> bool {
        let dark = |textured: &(Arc<Texture>, [Vec2; 3])| {
            let [r, g, b, _] = textured.0.extremes(textured.1.into_iter()).max;
            (self.radiance * Spectrum::from_rgb([r, g, b])).is_black()
        };
        let dark = self.radiance.is_black() || self.texture.as_deref().is_some_and(dark);
        dark || self.coverage.as_ref().is_some_and(|c| c.is_nothing())
    }

    /// Whether all points emit alike.
    pub(super) fn is_constant(&self) -> bool {
        self.texture.is_none() && self.corners.is_none() && self.coverage.is_none()
    }

    /// Returns the mean radiance over the triangle, from points as dense as its texels as far as these are not too many.
    /// It is positive if it is not black.
    pub(super) fn mean(&self) -> Spectrum {
        if self.is_constant() {
            return self.radiance;
        }
        let points = centroids(self.divisions());
        let value = |&b: &[f32; 2]| self.at(b) * self.covered(b);
        let sum = points.iter().map(value).fold(Spectrum::ZERO, |sum, value| sum + value);
        let (mean, count) = (sum / points.len() as f32, points.len() as f32);
        let missed = mean.is_black() && !self.is_black();
        if missed { self.radiance * (1.0 + count).recip() } else { mean }
    }

    /// Returns the number of parts of a side of the triangle, for its mean.
    pub(super) fn divisions(&self) -> u32 {
        self.points().clamp(LEAST_DIVISIONS, MOST_DIVISIONS)
    }

    /// Returns the number of parts of a side of the triangle that are about as long as two texels.
    pub(super) fn points(&self) -> u32 {
        let span = |textured: Option<&(Arc<Texture>, [Vec2; 3])>| {
            let Some((texture, uvs)) = textured else { return 0.0 };
            let size = Vec2::from(texture.image.size().map(|side| side as f32));
            let [a, b, c] = uvs.map(|uv| texture.transform.transform_point2(uv) * size);
            (a.max(b).max(c) - a.min(b).min(c)).max_element()
        };
        let coverage = self.coverage.as_ref().and_then(|c| c.texture.as_ref());
        (0.5 * span(self.texture.as_deref()).max(span(coverage))).ceil() as u32
    }

    /// Returns the alpha at a point.
    #[inline]
    pub(super) fn covered(&self, barycentric: [f32; 2]) -> f32 {
        self.coverage.as_ref().map_or(1.0, |coverage| coverage.at(barycentric))
    }

    /// Returns the number of emitting sides.
    pub(super) fn sides(&self) -> f64 {
        if self.two_sided { 2.0 } else { 1.0 }
    }

    /// Returns the radiance at a point.
    #[inline]
    pub(super) fn at(&self, barycentric: [f32; 2]) -> Spectrum {
        let mut radiance = self.radiance;
        if let Some(corners) = &self.corners {
            radiance *= mix(corners, barycentric);
        }
        let Some(textured) = &self.texture else { return radiance };
        let (texture, uvs) = &**textured;
        let [red, green, blue, _] = texture.at(mix(uvs, barycentric));
        radiance * Spectrum::from_rgb([red, green, blue])
    }
}

/// Parts of a side of a triangle over which emission varies, for its mean.
const LEAST_DIVISIONS: u32 = 2;
const MOST_DIVISIONS: u32 = 16;
