//! Cameras of a scene: the file's, or one that frames everything.

use super::Scene;
use super::description::{self, Projection};
use super::rebase::Rebase;
use crate::camera::{Camera, Orthographic, Pinhole, Pose};
use crate::error::{Error, Result};
use glam::{DAffine3, DVec3};

/// The cameras to choose from; never empty.
#[derive(Debug)]
pub(super) struct Views(Vec<description::Camera>);

/// Vertical field of view of the automatic camera: what a 50 mm lens shows on full-frame film, rounded.
const AUTOMATIC_FOV_DEGREES: f64 = 40.0;

impl Views {
    /// The file's `cameras`, or one that frames the box `min`..`max` of the file's world.
    pub(super) fn new(cameras: Vec<description::Camera>, min: DVec3, max: DVec3) -> Self {
        if cameras.is_empty() { Views(vec![framing(min, max)]) } else { Views(cameras) }
    }

    fn find(&self, selector: Option<&str>) -> Result<&description::Camera> {
        let Some(wanted) = selector else { return Ok(&self.0[0]) };
        let by_index = || wanted.parse::<usize>().ok().and_then(|i| self.0.get(i));
        self.0.iter().find(|c| c.name == wanted).or_else(by_index).ok_or_else(|| {
            let names: Vec<_> = self.0.iter().enumerate().map(|(i, c)| format!("{i} '{}'", c.name)).collect();
            Error::usage(format!("no camera '{wanted}' in the scene, which has {}", names.join(", ")))
        })
    }
}

/// A camera that looks at the middle of the box from the front, a little from the right and above.
fn framing(min: DVec3, max: DVec3) -> description::Camera {
    let yfov = AUTOMATIC_FOV_DEGREES.to_radians();
    let radius = ((max - min).length() * 0.5).max(f64::MIN_POSITIVE);
    let centre = (min + max) * 0.5;
    let eye = centre + DVec3::new(0.5, 0.35, 1.0).normalize() * (radius / (yfov * 0.5).sin());
    let backward = (eye - centre).normalize();
    let right = DVec3::Y.cross(backward).normalize();
    let transform = DAffine3::from_cols(right, backward.cross(right), backward, eye);
    let projection = Projection::Perspective { yfov, aspect: None };
    description::Camera { name: "automatic".into(), projection, transform }
}

/// Position and unit axes in scene space.
fn pose(transform: &DAffine3, rebase: &Rebase) -> Pose {
    let m = transform.matrix3;
    let unit = |axis: DVec3| axis.normalize_or_zero().as_vec3();
    Pose {
        position: rebase.point(transform.translation).as_vec3(),
        right: unit(m.x_axis),
        up: unit(m.y_axis),
        backward: unit(m.z_axis),
    }
}

impl Scene {
    /// Names of the cameras, in the order of their indices.
    pub fn cameras(&self) -> Vec<String> {
        self.views.0.iter().map(|c| c.name.clone()).collect()
    }

    /// Width over height that the selected camera asks for, if it does.
    ///
    /// # Errors
    /// As [`Scene::camera`].
    pub fn aspect(&self, selector: Option<&str>) -> Result<Option<f64>> {
        Ok(match self.views.find(selector)?.projection {
            Projection::Perspective { aspect, .. } => aspect,
            Projection::Orthographic { xmag, ymag } => Some(xmag / ymag),
        })
    }

    /// The camera with the name or index `selector` (the first without one) for a `width` × `height` image of square pixels.
    /// The vertical field of view is the file's; the automatic camera's is at least that much in both directions.
    ///
    /// # Errors
    /// A usage error that lists the cameras if there is no such one.
    pub fn camera(&self, selector: Option<&str>, width: u32, height: u32) -> Result<Camera> {
        let view = self.views.find(selector)?;
        let pose = pose(&view.transform, &self.rebase);
        Ok(match view.projection {
            Projection::Perspective { yfov, aspect: None } if width < height => {
                let tall = (yfov * 0.5).tan() * f64::from(height) / f64::from(width);
                Camera::Pinhole(Pinhole::new(pose, 2.0 * tall.atan(), width, height))
            }
            Projection::Perspective { yfov, .. } => Camera::Pinhole(Pinhole::new(pose, yfov, width, height)),
            Projection::Orthographic { ymag, .. } => {
                Camera::Orthographic(Orthographic::new(pose, ymag * self.rebase.scale, width, height))
            }
        })
    }
}
