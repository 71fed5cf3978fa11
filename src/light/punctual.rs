//! Punctual lights: point, spot, directional (KHR_lights_punctual). Only light sampling reaches them.

use super::{BoundingSphere, Cone, EmitterPoint, LeSample, LightSample, Reach};
use crate::geometry::{Bounds, Frame, Local, Ray};
use crate::sampling::{Density, Pdf, SolidAngle, warp};
use crate::spectrum::Spectrum;
use glam::Vec3;
use std::f64::consts::PI;

/// Point light of equal `intensity` in every direction.
#[derive(Debug, Clone, Copy)]
pub struct PointLight {
    /// Position.
    pub position: Vec3,
    /// Intensity in watts per steradian and lane, in scene units (scaled with the square of the scene's scale).
    pub intensity: Spectrum,
}

impl PointLight {
    /// Returns the direction from `p` to the light; `None` if `p` is at the light.
    #[inline]
    pub fn sample_li(&self, p: Vec3) -> Option<LightSample> {
        let to = self.position - p;
        let d2 = to.length_squared();
        if d2 == 0.0 {
            return None;
        }
        let (wi, radiance) = (to / d2.sqrt(), self.intensity / d2);
        Some(LightSample { wi, radiance, density: Density::Delta(1.0), end: EmitterPoint::Point(self.position) })
    }

    /// See [`super::Light::sample_le`].
    pub(super) fn sample_le(&self, u: [f32; 2]) -> LeSample {
        self.emit_along(warp::uniform_sphere(u), warp::uniform_sphere_pdf())
    }

    /// Returns a ray in a direction sampled with density `pdf`.
    fn emit_along(&self, direction: Vec3, pdf: Pdf<SolidAngle>) -> LeSample {
        let ray = Ray::new(self.position, direction);
        LeSample { end: EmitterPoint::Point(self.position), ray, power: self.intensity / pdf.value() }
    }

    /// Returns where it shines, for the light tree.
    pub(super) fn reach(&self) -> Option<Reach> {
        let intensity = f64::from(self.intensity.mean());
        let bounds = Bounds::around([self.position]);
        (intensity > 0.0).then_some(Reach { bounds, normals: Cone::ALL, spread: PI, two_sided: false, intensity })
    }

    /// Returns 4π times the mean intensity.
    pub fn power(&self) -> f64 {
        4.0 * PI * f64::from(self.intensity.mean())
    }
}

/// A point light limited to a cone: full intensity inside the inner angle, none outside the outer one.
#[derive(Debug, Clone, Copy)]
pub struct SpotLight {
    point: PointLight,
    axis: Vec3,
    cos_outer: f32,
    /// 1 / (cos inner − cos outer).
    slope: f32,
}

impl SpotLight {
    /// Creates a spot at `point` along the unit `axis`, angles in radians with `inner` < `outer` ≤ π/2.
    pub fn new(point: PointLight, axis: Vec3, inner: f32, outer: f32) -> Self {
        // glTF's own lower bound of the difference: equal angles give a sharp edge instead of a division by zero.
        const LEAST_DIFFERENCE: f32 = 1e-3;
        let (cos_inner, cos_outer) = (inner.cos(), outer.cos());
        SpotLight { point, axis, cos_outer, slope: (cos_inner - cos_outer).max(LEAST_DIFFERENCE).recip() }
    }

    /// Returns its position.
    pub(super) fn position(&self) -> Vec3 {
        self.point.position
    }

    /// Returns the square of a linear ramp in the cosine, as KHR_lights_punctual recommends [glTF20].
    #[inline]
    fn falloff(&self, cos: f32) -> f32 {
        let x = ((cos - self.cos_outer) * self.slope).clamp(0.0, 1.0);
        x * x
    }

    /// Returns the direction from `p` to the light; `None` outside the cone.
    #[inline]
    pub fn sample_li(&self, p: Vec3) -> Option<LightSample> {
        let mut sample = self.point.sample_li(p)?;
        let falloff = self.falloff(-sample.wi.dot(self.axis));
        sample.radiance *= falloff;
        (falloff > 0.0).then_some(sample)
    }

    /// See [`super::Light::sample_le`]. Uniform over the cone; `None` if it is too narrow for random numbers of 24
    /// bits.
    pub(super) fn sample_le(&self, u: [f32; 2]) -> Option<LeSample> {
        let widest = 1.0 - self.cos_outer;
        let height = u[0] * widest;
        let w = Frame::around(self.axis).to_world(Local::from(warp::cap(height, u[1])));
        (widest > 0.0).then(|| {
            let emitted = self.point.emit_along(w, warp::cap_pdf(widest));
            LeSample { power: emitted.power * self.falloff(1.0 - height), ..emitted }
        })
    }

    /// Returns the density per solid angle of [`SpotLight::sample_le`].
    pub(super) fn emission_pdf(&self, w: Vec3) -> f64 {
        if w.dot(self.axis) >= self.cos_outer { f64::from(warp::cap_pdf(1.0 - self.cos_outer).value()) } else { 0.0 }
    }

    /// Returns where it shines, for the light tree: with full intensity up to the inner angle.
    pub(super) fn reach(&self) -> Option<Reach> {
        let outer = f64::from(self.cos_outer).acos();
        let inner = f64::from(self.cos_outer + self.slope.recip()).min(1.0).acos();
        let normals = Cone { axis: self.axis.as_dvec3(), angle: inner };
        self.point.reach().map(|reach| Reach { normals, spread: outer - inner, ..reach })
    }

    /// Returns the intensity integrated over the cone: 2π (1 − cos inner) plus a third of the ramp's share. A cone
    /// narrower than the ramp has only the part of the ramp's square that lies within it.
    pub fn power(&self) -> f64 {
        let (cone, ramp) = (1.0 - f64::from(self.cos_outer), f64::from(self.slope.recip()));
        let (inner, within) = ((cone - ramp).max(0.0), cone.min(ramp));
        2.0 * PI * f64::from(self.point.intensity.mean()) * (inner + within.powi(3) / (3.0 * ramp * ramp))
    }
}

/// Parallel light.
#[derive(Debug, Clone, Copy)]
pub struct DirectionalLight {
    /// Unit direction toward the light.
    pub toward: Vec3,
    /// Irradiance in watts per square metre and lane on a perpendicular surface.
    pub irradiance: Spectrum,
}

impl DirectionalLight {
    /// Returns the single direction toward the light.
    #[inline]
    pub fn sample(&self) -> LightSample {
        LightSample {
            wi: self.toward,
            radiance: self.irradiance,
            density: Density::Delta(1.0),
            end: EmitterPoint::Distant,
        }
    }

    /// See [`super::Light::sample_le`].
    pub(super) fn sample_le(&self, ball: &BoundingSphere, position: [f32; 2]) -> LeSample {
        ball.lit(self.toward, self.irradiance, position)
    }

    /// Returns the power through a disk of the scene's `radius`.
    pub fn power(&self, radius: f32) -> f64 {
        PI * f64::from(radius).powi(2) * f64::from(self.irradiance.mean())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_power_of_a_spot_is_its_intensity_integrated_over_directions() {
        let point = PointLight { position: Vec3::ZERO, intensity: Spectrum::splat(3.0) };
        for (inner, outer) in [(0.0, 0.7), (0.3, 0.5), (0.4, 0.4), (0.0, 1.5), (0.02, 0.03)] {
            let spot = SpotLight::new(point, Vec3::NEG_Z, inner, outer);
            let n = 200_000;
            let integral: f64 = (0..n)
                .map(|i| spot.falloff(((f64::from(i) + 0.5) / f64::from(n)) as f32))
                .map(|f| f64::from(f) * 2.0 * PI * 3.0 / f64::from(n))
                .sum();
            // f32 cosines limit the agreement to a few ulp of 1 over the width of the cone; the midpoint rule to 1/n.
            assert!(spot.power() > 0.0, "{inner} {outer}");
            assert!((integral - spot.power()).abs() < 1e-4 * integral.max(0.1), "{integral} {}", spot.power());
        }
    }
}
