//! Cameras of a scene: the file's, or one that frames everything.

use super::Scene;
use super::description::{self, Projection};
use super::rebase::Rebase;
use crate::camera::{Camera, Orthographic, Pinhole, Pose};
use crate::error::{Error, Result};
use glam::{DAffine3, DVec3};

/// The cameras to choose from; never empty.
#[derive(Debug)]
pub(super) struct Views {
    cameras: Vec<description::Camera>,
    /// Whether the file has none, and this one was made up.
    automatic: bool,
}

/// Vertical field of view of the automatic camera: what a 50 mm lens shows on full-frame film, rounded.
const AUTOMATIC_FOV_DEGREES: f64 = 40.0;

impl Views {
    /// The file's `cameras`, or one that frames the box `min`..`max` of the file's world.
    pub(super) fn new(cameras: Vec<description::Camera>, min: DVec3, max: DVec3) -> Self {
        let automatic = cameras.is_empty();
        Views { cameras: if automatic { vec![framing(min, max)] } else { cameras }, automatic }
    }

    fn find(&self, selector: Option<&str>) -> Result<&description::Camera> {
        let Some(wanted) = selector else { return Ok(&self.cameras[0]) };
        let by_index = || wanted.parse::<usize>().ok().and_then(|i| self.cameras.get(i));
        self.cameras.iter().find(|c| c.name == wanted).or_else(by_index).ok_or_else(|| {
            let names: Vec<_> = self.cameras.iter().enumerate().map(|(i, c)| format!("{i} '{}'", c.name)).collect();
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

/// What the height of a view whose width is `aspect` times it is multiplied by so that all of it is in an image.
fn widened(aspect: f64, width: u32, height: u32) -> f64 {
    (aspect * f64::from(height) / f64::from(width)).max(1.0)
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
        self.views.cameras.iter().map(|c| c.name.clone()).collect()
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
    /// Nothing of the file's view is cropped: of an image of another shape the other angle is wider [glTF20 §3.10.3]. A camera without
    /// an aspect ratio has its vertical field of view; the automatic one at least that much in both directions.
    ///
    /// # Errors
    /// A usage error that lists the cameras if there is no such one.
    pub fn camera(&self, selector: Option<&str>, width: u32, height: u32) -> Result<Camera> {
        let view = self.views.find(selector)?;
        let pose = pose(&view.transform, &self.rebase);
        Ok(match view.projection {
            Projection::Perspective { yfov, aspect } => {
                let widest = aspect.or(self.views.automatic.then_some(1.0));
                let tall = (yfov * 0.5).tan() * widest.map_or(1.0, |widest| widened(widest, width, height));
                Camera::Pinhole(Pinhole::new(pose, 2.0 * tall.atan(), width, height))
            }
            Projection::Orthographic { xmag, ymag } => {
                let tall = ymag * widened(xmag / ymag, width, height);
                Camera::Orthographic(Orthographic::new(pose, tall * self.rebase.scale, width, height))
            }
        })
    }

    /// What a `width` × `height` image shows beyond the view of the selected camera, in a sentence; `None` if it has the camera's shape but
    /// for rounding to pixels.
    ///
    /// # Errors
    /// As [`Scene::camera`].
    pub fn beyond_view(&self, selector: Option<&str>, width: u32, height: u32) -> Result<Option<String>> {
        let Some(aspect) = self.aspect(selector)? else { return Ok(None) };
        let name = &self.views.find(selector)?.name;
        let (width, height) = (f64::from(width), f64::from(height));
        // Within half a pixel of either side.
        let fits = (width - aspect * height).abs() <= 0.5 * aspect.max(1.0);
        let side = if width > aspect * height { "right and left" } else { "above and below" };
        Ok((!fits).then(|| format!("the image is not of the shape of camera '{name}', {aspect:.4} to 1: it shows more {side}")))
    }
}
