//! Rays of light as they leave their lights, for walks that begin there.
//!
//! Positions are uniform over a light's area and directions follow the cosine, so that rays carry the same but for textures and the
//! falloff of spots. Light from infinity enters through a disk as wide as the scene, which touches it on the side that the light
//! comes from.

use super::{End, Light};
use crate::geometry::{Frame, Ray};
use crate::sampling::warp;
use crate::spectrum::Spectrum;
use glam::Vec3;
use std::f32::consts::PI;

/// A ball around everything that light may fall on.
#[derive(Debug, Clone, Copy)]
pub struct Ball {
    /// Its centre.
    pub centre: Vec3,
    /// Its radius.
    pub radius: f32,
}

/// What chooses a ray; each number uniform.
#[derive(Debug, Clone, Copy)]
pub struct EmissionNumbers {
    /// Front or back.
    pub side: f32,
    /// Where it leaves.
    pub position: [f32; 2],
    /// Where to.
    pub direction: [f32; 2],
}

/// A ray of light.
#[derive(Debug, Clone, Copy)]
pub struct Emitted {
    /// What it leaves.
    pub end: End,
    /// The ray, with a unit direction.
    pub ray: Ray,
    /// Watts that it stands for: radiance times cosine over the density of position and direction.
    pub power: Spectrum,
}

impl Light {
    /// A ray of this light into `ball`; `None` where it is dark.
    #[inline]
    pub fn emit(&self, ball: &Ball, u: &EmissionNumbers) -> Option<Emitted> {
        let emitted = match self {
            Light::Point(light) => Some(light.emit(u.direction)),
            Light::Spot(light) => light.emit(u.direction),
            Light::Directional(light) => Some(light.emit(ball, u.position)),
            Light::Area(light) => light.emit(u),
            Light::Environment(light) => light.emit(ball, u),
        };
        emitted.filter(|emitted| !emitted.power.is_black())
    }
}

impl Ball {
    /// Light of `irradiance` on a surface perpendicular to it, from infinity along the unit vector `toward`.
    pub(super) fn lit(&self, toward: Vec3, irradiance: Spectrum, position: [f32; 2]) -> Emitted {
        let frame = Frame::around(toward);
        let disk = warp::concentric_disk(position);
        let origin = self.centre + (frame.s * disk.x + frame.t * disk.y + toward) * self.radius;
        let power = irradiance * (PI * self.radius * self.radius);
        Emitted { end: End::Infinity, ray: Ray::new(origin, -toward), power }
    }
}
