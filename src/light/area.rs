//! Emitting triangles. Light samples of near triangles are uniform over the solid angle; those of others, and rays, are
//! uniform over the area. Where emission varies much, both are in proportion to it ([`EmissionTable`]).

use super::emission::Emission;
use super::emission_table::EmissionTable;
use super::solid_angle::SeenTriangle;
use super::{Cone, EmitterPoint, LeRandom, LeSample, LightSample, Reach};
use crate::geometry::lanes::{point_at, rounding_at};
use crate::geometry::{Bounds, Frame, Hit, Local, Triangle, leave};
use crate::sampling::{Area, Density, Pdf, SolidAngle, warp};
use crate::spectrum::Spectrum;
use etendue_lanes::{self as lanes, Float, ROW};
use glam::Vec3;
use std::f64::consts::{FRAC_PI_2, PI};

/// Longest edge of a small triangle, in radii of the scene.
const SMALL: f32 = 0.05;

/// An emitting triangle. It emits from the front (counter-clockwise winding), and also
/// from the back if its material is double-sided.
#[derive(Debug)]
pub struct AreaLight {
    triangle: Triangle,
    touched: Hit,
    ng: Vec3,
    /// That of a uniform point.
    density: Pdf<Area>,
    emission: Emission,
    table: Option<EmissionTable>,
    mean_radiance: Spectrum,
}

impl AreaLight {
    /// Creates the light on `triangle`, whose front is the side of its winding times `winding` (±1).
    pub fn new(triangle: Triangle, winding: f64, emission: Emission) -> Self {
        Self::touched(triangle, Hit::NONE, winding, emission)
    }

    /// Like [`AreaLight::new`], on the primitive `touched`, which is in contact with another one.
    pub fn touched(triangle: Triangle, touched: Hit, winding: f64, emission: Emission) -> Self {
        let normal = triangle.scaled_normal() * winding;
        let area = triangle.area() as f32;
        let density = if area.recip().is_finite() { Pdf::new(area.recip()) } else { Pdf::new(0.0) };
        let (mean_radiance, table) = (emission.mean(), EmissionTable::new(&emission));
        let ng = normal.normalize_or_zero().as_vec3();
        AreaLight { triangle, touched, ng, density, emission, table, mean_radiance }
    }

    /// Returns the radiance emitted at `barycentric` along the unit direction `wo`.
    #[inline]
    pub fn radiance(&self, barycentric: [f32; 2], wo: Vec3) -> Spectrum {
        if self.emission.two_sided || wo.dot(self.ng) > 0.0 { self.emission.at(barycentric) } else { Spectrum::ZERO }
    }

    /// Returns the density per solid angle of [`AreaLight::sample_li`] from `p` for the point `q` of the light, in the
    /// unit direction `wi`.
    #[inline]
    pub fn pdf_li(&self, p: Vec3, q: Vec3, wi: Vec3) -> Pdf<SolidAngle> {
        self.pdf_seen(&self.seen(p), q, (q - p).length_squared(), wi)
    }

    /// Returns the density of [`AreaLight::pdf_li`] at the squared distance `d2`: 0 in the plane of the light.
    #[inline]
    fn pdf_seen(&self, seen: &SeenTriangle<f32>, q: Vec3, d2: f32, wi: Vec3) -> Pdf<SolidAngle> {
        let cos = wi.dot(self.ng).abs();
        match &self.table {
            _ if self.density.value() <= 0.0 || cos == 0.0 => Pdf::new(0.0),
            None => Pdf::new(seen.pdf(d2, cos)),
            Some(table) => self.table_density(table, q).to_solid_angle(d2, cos),
        }
    }

    #[inline]
    fn table_density(&self, table: &EmissionTable, q: Vec3) -> Pdf<Area> {
        Pdf::new((self.density.value() * table.factor(self.triangle.barycentric(q))).min(f32::MAX))
    }

    /// See [`super::Light::end_pdf_ratio`]; `q` is the endpoint.
    pub(super) fn end_pdf_ratio(&self, p: Vec3, q: Vec3, wi: Vec3) -> f64 {
        let seen = self.seen(p);
        if self.table.is_some() || !seen.is_by_angle() {
            return 1.0;
        }
        let per_area = f64::from(wi.dot(self.ng).abs()) / f64::from(q.distance_squared(p));
        f64::from(seen.pdf(1.0, 1.0)) * per_area / f64::from(self.density.value())
    }

    #[inline]
    fn seen(&self, p: Vec3) -> SeenTriangle<f32> {
        SeenTriangle::new(self.triangle.vertices.map(Into::into), self.ng.into(), self.density.value(), p.into())
    }

    /// Samples a point on the light from `p`; `None` if `p` is on its dark side or the light has no area.
    #[inline]
    pub fn sample_li(&self, p: Vec3, u: [f32; 2]) -> Option<LightSample> {
        let seen = self.seen(p);
        let barycentric = self.table.as_ref().map_or_else(|| seen.sample(u), |table| table.sample(u));
        let (q, error) = self.triangle.point(barycentric);
        let (wi, d2) = toward(q.into(), p.into());
        let wi = Vec3::from(wi);
        let coverage = self.emission.covered(barycentric);
        let radiance = self.radiance(barycentric, -wi) * coverage;
        let pdf = self.pdf_seen(&seen, q, d2, wi);
        let shines = !radiance.is_black() && pdf.value() > 0.0 && d2 > 0.0;
        shines.then_some(LightSample {
            wi,
            radiance,
            density: Density::Smooth(pdf),
            end: EmitterPoint::Surface { p: q, error, ng: self.ng, touched: self.touched },
        })
    }

    /// Returns the light as a row of a table for [`AreaLightSamples`]; `None` if its emission varies over the triangle,
    /// does not illuminate or leaves the back, or if another surface touches it.
    pub fn row(&self) -> Option<AreaLightRow> {
        let Emission { radiance, two_sided, only_seen, .. } = self.emission;
        let is_plain = self.emission.is_constant() && !two_sided && !only_seen;
        if !is_plain || self.touched != Hit::NONE || self.density.value() <= 0.0 {
            return None;
        }
        let [a, b, c] = self.triangle.vertices;
        let ng = self.ng;
        let [r, g, b_] = radiance.0;
        Some([[a.x, a.y, a.z, b.x, b.y, b.z, c.x, c.y], [c.z, ng.x, ng.y, ng.z, r, g, b_, self.density.value()]])
    }

    /// See [`super::Light::sample_le`].
    pub(super) fn sample_le(&self, u: &LeRandom) -> Option<LeSample> {
        let barycentric =
            self.table.as_ref().map_or_else(|| warp::uniform_triangle(u.position), |table| table.sample(u.position));
        let (p, error) = self.triangle.point(barycentric);
        let density = self.area_pdf(p);
        let (normal, sides) = match self.emission.two_sided {
            true if u.side >= 0.5 => (-self.ng, 2.0),
            true => (self.ng, 2.0),
            false => (self.ng, 1.0),
        };
        let w = Frame::around(normal).to_world(Local::from(warp::cosine_hemisphere(u.direction)));
        let coverage = self.emission.covered(barycentric);
        // The cosine is in the density of the direction.
        let power = self.emission.at(barycentric) * (coverage * sides * std::f32::consts::PI / density.value());
        let ray = leave(p, error, self.ng, self.touched, w);
        (density.value() > 0.0).then_some(LeSample {
            end: EmitterPoint::Surface { p, error, ng: self.ng, touched: self.touched },
            ray,
            power,
        })
    }

    /// Returns the box around the origins of its rays. They are offset by no more than twice their error in each
    /// coordinate: the normal's coordinates sum to less than √3.
    pub(super) fn bounds(&self) -> Bounds {
        let grow = 2.0 * self.triangle.most_error();
        let Bounds { min, max } = Bounds::around(self.triangle.vertices);
        Bounds { min: min - grow, max: max + grow }
    }

    /// Returns the density per area of the origin `p` in [`AreaLight::sample_le`].
    #[inline]
    pub(super) fn area_pdf(&self, p: Vec3) -> Pdf<Area> {
        self.table.as_ref().map_or(self.density, |table| self.table_density(table, p))
    }

    /// Returns the density per solid angle of the direction in [`AreaLight::sample_le`].
    pub(super) fn emission_pdf(&self, w: Vec3) -> f64 {
        let cos = f64::from(w.dot(self.ng));
        let cos = if self.emission.two_sided { 0.5 * cos.abs() } else { cos.max(0.0) };
        cos / PI
    }

    /// See [`super::Light::pivot`].
    pub fn pivot(&self) -> Option<Vec3> {
        let [a, b, c] = self.triangle.vertices;
        let edge2 = (b - a).length_squared().max((c - b).length_squared()).max((a - c).length_squared());
        (edge2 < SMALL * SMALL && !self.emission.only_seen).then_some((a + b + c) / 3.0)
    }

    /// Returns the radiance factor, mean over lanes. Textures only reduce it.
    pub(super) fn largest_radiance(&self) -> f64 {
        f64::from(self.emission.radiance.mean())
    }

    /// Whether the light is visible but does not illuminate: see [`Emission::only_seen`].
    #[inline]
    pub fn is_only_seen(&self) -> bool {
        self.emission.only_seen
    }

    /// Returns where it shines, for the light tree; `None` if it does not illuminate.
    pub(super) fn reach(&self) -> Option<Reach> {
        (self.power() > 0.0).then(|| Reach {
            bounds: Bounds::around(self.triangle.vertices),
            normals: Cone { axis: self.ng.as_dvec3(), angle: 0.0 },
            spread: FRAC_PI_2,
            two_sided: self.emission.two_sided,
            intensity: self.power() / (self.emission.sides() * PI),
        })
    }

    /// Returns π × area × mean radiance × number of emitting sides. 0 for an emitter that does not illuminate, so that
    /// it is never sampled.
    pub fn power(&self) -> f64 {
        if self.emission.only_seen {
            return 0.0;
        }
        self.emission.sides() * PI * self.triangle.area() * f64::from(self.mean_radiance.mean())
    }
}

/// Vertices, normal, radiance and density of an emitter: see [`AreaLight::row`].
pub type AreaLightRow = [[f32; ROW]; 2];

/// Light samples over lanes.
#[derive(Debug, Clone, Copy)]
pub struct AreaLightSamples<F: Float> {
    /// Unit direction from the receiver to the light.
    pub wi: lanes::Vec3<F>,
    /// Radiance along it.
    pub radiance: Spectrum<F>,
    /// Density of the direction, per solid angle.
    pub pdf: F,
    /// The point on the light.
    pub p: lanes::Vec3<F>,
    /// See [`EmitterPoint::Surface`].
    pub error: F,
    /// Normal at the point.
    pub ng: lanes::Vec3<F>,
    /// Lanes in which the light shines on the receiver.
    pub valid: F::Mask,
}

impl<F: Float> AreaLightSamples<F> {
    /// Does [`AreaLight::sample_li`] for the receivers `at`, with the light of `row(lane)` in each lane.
    #[inline(always)]
    pub fn new<'a>(row: impl Fn(usize) -> &'a AreaLightRow, at: lanes::Vec3<F>, u: [F; 2]) -> Self {
        let [ax, ay, az, bx, by, bz, cx, cy] = F::rows(|lane| &row(lane)[0]);
        let [cz, nx, ny, nz, r, g, b, density] = F::rows(|lane| &row(lane)[1]);
        let vertices = [lanes::Vec3::new(ax, ay, az), lanes::Vec3::new(bx, by, bz), lanes::Vec3::new(cx, cy, cz)];
        let ng = lanes::Vec3::new(nx, ny, nz);
        let seen = SeenTriangle::new(vertices, ng, density, at);
        let p = point_at(vertices, seen.sample(u));
        let (wi, d2) = toward(p, at);
        let cos = -wi.dot(ng);
        let pdf = seen.pdf(d2, cos.abs());
        let valid = cos.above(F::splat(0.0)) & pdf.above(F::splat(0.0)) & d2.above(F::splat(0.0));
        AreaLightSamples { wi, radiance: Spectrum([r, g, b]), pdf, p, error: rounding_at(vertices, p), ng, valid }
    }
}

/// Returns the unit directions to the points `q` from the points `p`, and the squared distances.
#[inline(always)]
fn toward<F: Float>(q: lanes::Vec3<F>, p: lanes::Vec3<F>) -> (lanes::Vec3<F>, F) {
    let to = q - p;
    let d2 = to.length_squared();
    let distance = d2.sqrt();
    (to.map(|x| x / distance), d2)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::texture::{Bitmap, Encoding, Texels, Texture, TextureFilter, Wrap};
    use glam::{Affine2, Vec2};
    use std::sync::Arc;

    /// A light whose texture of 64² texels is `texel`, over a triangle that covers half of it.
    fn textured(texel: impl Fn(u32, u32) -> u8) -> AreaLight {
        let texels: Vec<_> = (0..64 * 64).map(|i| [texel(i % 64, i / 64); 4]).collect();
        let texture = Texture {
            image: Arc::new(Bitmap::new(64, 64, Texels::Rgba8(texels.into()))),
            encoding: Encoding::Linear,
            wrap: [Wrap::Clamp; 2],
            filter: TextureFilter::Linear,
            uv_set: 0,
            transform: Affine2::IDENTITY,
        };
        let triangle = Triangle::new(Vec3::ZERO, Vec3::X, Vec3::Y);
        let texture = Some(Box::new((Arc::new(texture), [Vec2::ZERO, Vec2::X, Vec2::Y])));
        AreaLight::new(triangle, 1.0, Emission { radiance: Spectrum::ONE, texture, ..Emission::NONE })
    }

    #[test]
    fn the_power_of_a_textured_light_is_that_of_its_part_of_the_texture() {
        let white = textured(|_, _| 255).power();
        assert!((white / (0.5 * PI) - 1.0).abs() < 1e-6, "{white}");
        assert!(textured(|x, y| if x + y < 60 { 0 } else { 255 }).power() < 0.2 * white);
        assert!(textured(|x, y| if x + y < 70 { 255 } else { 0 }).power() > 0.99 * white);
        // Texels of the box around it shine, so that it counts as lit, but weakly.
        assert!(textured(|x, y| if x + y < 70 { 0 } else { 255 }).power() < 0.01 * white);
        assert_eq!(textured(|_, _| 0).power(), 0.0);
    }

    /// It may shine between the points at which it is looked at.
    #[test]
    fn a_single_bright_texel_is_power() {
        for at in [[3, 3], [10, 31], [1, 20], [32, 7]] {
            assert!(textured(|x, y| if [x, y] == at { 255 } else { 0 }).power() > 0.0, "{at:?}");
        }
    }
}
