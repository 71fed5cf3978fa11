//! Cameras of a scene: those of the file, or one that frames all geometry.

use super::Scene;
use super::description::{self, Projection};
use super::rebase::Rebase;
use crate::camera::{ApertureShape, Camera, Orthographic, Pinhole, Pose, ThinLens};
use crate::error::{Error, Result};
use glam::{DAffine3, DVec3};

/// The selectable cameras; never empty.
#[derive(Debug)]
pub(super) struct Views {
    cameras: Vec<description::CameraDescription>,
    /// Whether the file has no camera, and this one was generated.
    automatic: bool,
}

/// Vertical field of view of the automatic camera: that of a 50 mm lens on full-frame film, rounded.
const AUTOMATIC_FOV_DEGREES: f64 = 40.0;

impl Views {
    /// Returns the file's `cameras`, or one that frames the box `min`..`max` in the file's world space.
    pub(super) fn new(cameras: Vec<description::CameraDescription>, min: DVec3, max: DVec3) -> Self {
        let automatic = cameras.is_empty();
        Views { cameras: if automatic { vec![framing(min, max)] } else { cameras }, automatic }
    }

    fn find(&self, selector: Option<&str>) -> Result<&description::CameraDescription> {
        let Some(wanted) = selector else { return Ok(&self.cameras[0]) };
        let by_index = || wanted.parse::<usize>().ok().and_then(|i| self.cameras.get(i));
        self.cameras.iter().find(|c| c.name == wanted).or_else(by_index).ok_or_else(|| {
            let names: Vec<_> = self.cameras.iter().enumerate().map(|(i, c)| format!("{i} '{}'", c.name)).collect();
            Error::usage(format!("no camera '{wanted}' in the scene, which has {}", names.join(", ")))
        })
    }
}

/// Returns a camera that looks at the centre of the box from the front, slightly from the right and above.
pub(super) fn framing(min: DVec3, max: DVec3) -> description::CameraDescription {
    let yfov = AUTOMATIC_FOV_DEGREES.to_radians();
    let radius = ((max - min).length() * 0.5).max(f64::MIN_POSITIVE);
    let centre = (min + max) * 0.5;
    let eye = centre + DVec3::new(0.5, 0.35, 1.0).normalize() * (radius / (yfov * 0.5).sin());
    let backward = (eye - centre).normalize();
    let right = DVec3::Y.cross(backward).normalize();
    let transform = DAffine3::from_cols(right, backward.cross(right), backward, eye);
    let projection = Projection::Perspective { yfov, aspect: None };
    description::CameraDescription { name: "automatic".into(), projection, transform, lens: None }
}

/// Returns the factor on the height of a view of aspect ratio `aspect` that makes all of it fit the image.
fn widened(aspect: f64, width: u32, height: u32) -> f64 {
    (aspect * f64::from(height) / f64::from(width)).max(1.0)
}

/// Returns position and unit axes in scene space.
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

/// Returns the camera `pinhole` with a lens of file units.
fn thin_lens(pinhole: Pinhole, lens: &description::Lens, rebase: &Rebase) -> ThinLens {
    let radius = (lens.radius * rebase.scale) as f32;
    let aperture = ApertureShape::new(radius, lens.blades, lens.rotation.to_radians() as f32);
    ThinLens::new(pinhole, aperture, (lens.focus * rebase.scale) as f32)
}

impl Scene {
    /// Returns the names of the cameras, by index.
    pub fn cameras(&self) -> Vec<String> {
        self.views.cameras.iter().map(|c| c.name.clone()).collect()
    }

    /// Returns the aspect ratio (width over height) of the selected camera, if it has one.
    ///
    /// # Errors
    /// As [`Scene::camera`].
    pub fn aspect(&self, selector: Option<&str>) -> Result<Option<f64>> {
        Ok(match self.views.find(selector)?.projection {
            Projection::Perspective { aspect, .. } => aspect,
            Projection::Orthographic { xmag, ymag } => Some(xmag / ymag),
        })
    }

    /// Returns the selected camera of the description.
    pub(super) fn view(&self, selector: Option<&str>) -> Result<&description::CameraDescription> {
        self.views.find(selector)
    }

    /// Returns the vertical field of view of the selected camera in radians; `None` if it is orthographic.
    ///
    /// # Errors
    /// As [`Scene::camera`].
    pub fn yfov(&self, selector: Option<&str>) -> Result<Option<f64>> {
        Ok(match self.views.find(selector)?.projection {
            Projection::Perspective { yfov, .. } => Some(yfov),
            Projection::Orthographic { .. } => None,
        })
    }

    /// Returns the camera with the name or index `selector` (the first without one) for a `width` × `height` image of
    /// square pixels. The file's view is never cropped: for another aspect ratio the other angle is widened
    /// [glTF20 §3.10.3]. A camera without an aspect ratio keeps its vertical field of view; the automatic one has at
    /// least that angle in both directions.
    ///
    /// # Errors
    /// A usage error that lists the cameras if there is none of that name or index.
    pub fn camera(&self, selector: Option<&str>, width: u32, height: u32) -> Result<Camera> {
        self.camera_with_lens(selector, width, height, None)
    }

    /// Returns [`Scene::camera`] with `lens` in place of its own, if one is given.
    ///
    /// # Errors
    /// As [`Scene::camera`].
    pub fn camera_with_lens(
        &self,
        selector: Option<&str>,
        width: u32,
        height: u32,
        lens: Option<&description::Lens>,
    ) -> Result<Camera> {
        let view = self.views.find(selector)?;
        let pose = pose(&view.transform, &self.rebase);
        let camera = match view.projection {
            Projection::Perspective { yfov, aspect } => {
                let widest = aspect.or(self.views.automatic.then_some(1.0));
                let tall = (yfov * 0.5).tan() * widest.map_or(1.0, |widest| widened(widest, width, height));
                let pinhole = Pinhole::new(pose, 2.0 * tall.atan(), width, height);
                match lens.or(view.lens.as_ref()).filter(|lens| lens.radius > 0.0 && lens.focus > 0.0) {
                    Some(lens) => Camera::ThinLens(thin_lens(pinhole, lens, &self.rebase)),
                    None => Camera::Pinhole(pinhole),
                }
            }
            Projection::Orthographic { xmag, ymag } => {
                let tall = ymag * widened(xmag / ymag, width, height);
                Camera::Orthographic(Orthographic::new(pose, tall * self.rebase.scale, width, height))
            }
        };
        let medium = camera.bounds().and_then(|bounds| self.bodies_within(&bounds));
        Ok(camera.within(medium))
    }

    /// Returns a sentence on the extra view of a `width` × `height` image beyond that of the selected camera; `None` if
    /// the aspect ratios agree up to rounding to pixels.
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
        Ok((!fits).then(|| {
            format!("the image is not of the shape of camera '{name}', {aspect:.4} to 1: it shows more {side}")
        }))
    }
}
