//! Emitting triangles: constant radiance, or a texture, over each.

use super::{EmissionNumbers, Emitted, End, LightSample};
use crate::defects::{Defect, planted};
use crate::geometry::{Frame, Hit, Local, Triangle, leave};
use crate::sampling::{Area, Density, Pdf, SolidAngle, warp};
use crate::spectrum::Spectrum;
use crate::texture::Texture;
use glam::{Vec2, Vec3};
use std::f64::consts::PI;
use std::sync::Arc;

/// Radiance over a triangle.
#[derive(Debug, Clone)]
pub struct Emission {
    /// Radiance, or the factor of the texture.
    pub radiance: Spectrum,
    /// A texture and its coordinates at the corners.
    pub texture: Option<Box<(Arc<Texture>, [Vec2; 3])>>,
    /// Factors at the corners, if they differ.
    pub corners: Option<Box<[Spectrum; 3]>>,
    /// Whether the back emits as the front does.
    pub two_sided: bool,
    /// Whether it is seen and lights nothing (KHR_materials_unlit): it is never sampled, and found only from the camera, directly and by
    /// mirrors and clear glass.
    pub only_seen: bool,
    /// Where alpha leaves something to emit, if not everywhere.
    pub coverage: Option<Box<Coverage>>,
}

/// Alpha over a triangle. A ray that hits the triangle has passed the test of alpha already; a point that is sampled on it has
/// not.
#[derive(Debug, Clone)]
pub struct Coverage {
    /// Alpha factor at the corners.
    pub corners: [f32; 3],
    /// A texture whose alpha multiplies it, and its coordinates at the corners.
    pub texture: Option<(Arc<Texture>, [Vec2; 3])>,
    /// Alpha below this is 0 and from it on 1 (mask); `None` for blending.
    pub cutoff: Option<f32>,
}

impl Coverage {
    /// Whether alpha leaves nothing anywhere.
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

/// The value between those of three corners.
fn mix<V: Copy + std::ops::Mul<f32, Output = V> + std::ops::Add<Output = V>>(corners: &[V; 3], [u, v]: [f32; 2]) -> V {
    corners[0] * (1.0 - u - v) + corners[1] * u + corners[2] * v
}

impl Emission {
    /// No light at all.
    pub const NONE: Emission =
        Emission { radiance: Spectrum::ZERO, texture: None, corners: None, two_sided: false, only_seen: false, coverage: None };

    /// Whether it sends out nothing anywhere on its triangle: the factor or all texels that it touches are black, or alpha leaves
    /// nothing.
    pub fn is_black(&self) -> bool {
        let dark = |textured: &(Arc<Texture>, [Vec2; 3])| {
            let [r, g, b, _] = textured.0.extremes(textured.1.into_iter()).max;
            (self.radiance * Spectrum::from_rgb([r, g, b])).is_black()
        };
        let dark = self.radiance.is_black() || self.texture.as_deref().is_some_and(dark);
        dark || self.coverage.as_ref().is_some_and(|c| c.is_nothing())
    }

    /// Radiance at a point.
    #[inline]
    fn at(&self, barycentric: [f32; 2]) -> Spectrum {
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

/// A triangle that emits, uniformly sampled over its area. It emits from the front (counter-clockwise winding), and from the
/// back if its material is double-sided.
#[derive(Debug)]
pub struct AreaLight {
    triangle: Triangle,
    touched: Hit,
    ng: Vec3,
    density: Pdf<Area>,
    emission: Emission,
    mean_radiance: Spectrum,
}

impl AreaLight {
    /// The light on `triangle`, whose front is the side of its winding times `winding` (±1). `mean_texture` is the texture's
    /// mean colour, white without one.
    pub fn new(triangle: Triangle, winding: f64, emission: Emission, mean_texture: Spectrum) -> Self {
        Self::touched(triangle, Hit::NONE, winding, emission, mean_texture)
    }

    /// [`AreaLight::new`], on the primitive `touched`, which another one touches.
    pub fn touched(triangle: Triangle, touched: Hit, winding: f64, emission: Emission, mean_texture: Spectrum) -> Self {
        let normal = triangle.scaled_normal() * winding;
        let area = triangle.area() as f32;
        let density = if area.recip().is_finite() { Pdf::new(area.recip()) } else { Pdf::new(0.0) };
        let mean_radiance = emission.radiance * mean_texture;
        AreaLight { triangle, touched, ng: normal.normalize_or_zero().as_vec3(), density, emission, mean_radiance }
    }

    /// Radiance that leaves the point with `barycentric` along the unit direction `wo`.
    #[inline]
    pub fn radiance(&self, barycentric: [f32; 2], wo: Vec3) -> Spectrum {
        if self.emission.two_sided || wo.dot(self.ng) > 0.0 { self.emission.at(barycentric) } else { Spectrum::ZERO }
    }

    /// The density per solid angle, at a point in distance √`d2` along the unit direction `wi`, of what
    /// [`AreaLight::sample_toward`] makes.
    #[inline]
    pub fn pdf_toward(&self, d2: f32, wi: Vec3) -> Pdf<SolidAngle> {
        self.density.to_solid_angle(d2, wi.dot(self.ng).abs())
    }

    /// A point on the light, seen from `p`; `None` if it shows its dark side or has no area.
    #[inline]
    pub fn sample_toward(&self, p: Vec3, u: [f32; 2]) -> Option<LightSample> {
        let barycentric = warp::uniform_triangle(u);
        let (q, error) = self.triangle.point(barycentric);
        let to = q - p;
        let d2 = to.length_squared();
        let wi = to / d2.sqrt();
        let coverage = self.emission.coverage.as_ref().map_or(1.0, |c| c.at(barycentric));
        let toward = if planted(Defect::LampShinesBackward) { self.ng } else { -wi };
        let mut radiance = self.radiance(barycentric, toward) * coverage;
        if planted(Defect::LampMeanInSample) && !radiance.is_black() {
            radiance = self.mean_radiance * coverage;
        }
        let pdf = self.pdf_toward(d2, wi);
        if radiance.is_black() || pdf.value() <= 0.0 || d2 == 0.0 {
            return None;
        }
        Some(LightSample {
            wi,
            radiance,
            density: Density::Smooth(pdf),
            end: End::Surface { p: q, error, ng: self.ng, touched: self.touched },
        })
    }

    /// See [`super::Light::emit`].
    pub(super) fn emit(&self, u: &EmissionNumbers) -> Option<Emitted> {
        let barycentric = warp::uniform_triangle(u.position);
        let (p, error) = self.triangle.point(barycentric);
        let (normal, sides) = match self.emission.two_sided {
            true if u.side >= 0.5 => (-self.ng, 2.0),
            true => (self.ng, 2.0),
            false => (self.ng, 1.0),
        };
        let w = Frame::around(normal).to_world(Local::from(warp::cosine_hemisphere(u.direction)));
        let coverage = self.emission.coverage.as_ref().map_or(1.0, |c| c.at(barycentric));
        // The cosine is in the density of the direction.
        let power = self.emission.at(barycentric) * (coverage * sides * std::f32::consts::PI / self.density.value());
        let ray = leave(p, error, self.ng, self.touched, w);
        (self.density.value() > 0.0).then_some(Emitted {
            end: End::Surface { p, error, ng: self.ng, touched: self.touched },
            ray,
            power,
        })
    }

    /// Density per area of where [`AreaLight::emit`] begins.
    pub(super) fn area_pdf(&self) -> f64 {
        f64::from(self.density.value())
    }

    /// Density per solid angle of the direction of [`AreaLight::emit`].
    pub(super) fn emission_pdf(&self, w: Vec3) -> f64 {
        let cos = f64::from(w.dot(self.ng));
        let half = if planted(Defect::TwoSidedWhole) { 1.0 } else { 0.5 };
        let cos = if self.emission.two_sided { half * cos.abs() } else { cos.max(0.0) };
        (if planted(Defect::EmissionPdfUniform) { 0.5 } else { cos }) / PI
    }

    /// The factor of its radiance, mean over the lanes: textures darken.
    pub(super) fn largest_radiance(&self) -> f64 {
        f64::from(self.emission.radiance.mean())
    }

    /// Whether it is seen and lights nothing: see [`Emission::only_seen`].
    #[inline]
    pub fn is_only_seen(&self) -> bool {
        self.emission.only_seen
    }

    /// π times area times mean radiance, for each emitting side; 0 for what lights nothing, so that nobody samples it.
    pub fn power(&self) -> f64 {
        if self.emission.only_seen && !planted(Defect::UnlitIsLamp) {
            return 0.0;
        }
        let sides = if self.emission.two_sided { 2.0 } else { 1.0 };
        sides * PI * self.triangle.area() * f64::from(self.mean_radiance.mean())
    }
}
