//! Where a camera may be focused: distances along its axis to what the scene has by name or shows in a pixel.

use super::Scene;
use crate::camera::Camera;
use crate::error::{Error, Result};
use crate::geometry::Bounds;
use glam::{DVec3, Vec3};

impl Scene {
    /// Returns the distance along the axis of the camera `selector` to the centre of the bounding box of the nodes
    /// named `name`, in units of the file.
    ///
    /// # Errors
    /// A usage error if there is no such camera or node, or if it is not in front of the camera.
    pub fn depth_of_node(&self, selector: Option<&str>, name: &str) -> Result<f64> {
        let named = |object: &u32| self.names[self.objects[*object as usize].instance as usize] == name;
        let objects = (0..self.objects.len() as u32).filter(named);
        let bounds = objects.fold(Bounds::EMPTY, |all, object| all.union(self.geometry.bounds(object)));
        if bounds.is_empty() {
            return Err(Error::usage(format!("the focus is on '{name}', and no node with a mesh has this name")));
        }
        self.depth_of(selector, bounds.center(), &format!("the node '{name}'"))
    }

    /// Returns the distance along the axis of the camera `selector` to what it shows at the centre of `pixel` of a
    /// `size[0]` × `size[1]` image, in units of the file.
    ///
    /// # Errors
    /// A usage error if there is no such camera or pixel, or if nothing is seen there.
    pub fn depth_of_pixel(&self, selector: Option<&str>, size: [u32; 2], pixel: [u32; 2]) -> Result<f64> {
        let ([width, height], [x, y]) = (size, pixel);
        if x >= width || y >= height {
            return Err(Error::usage(format!("the focus is on pixel {x},{y}, outside the image of {width}x{height}")));
        }
        let camera: Camera = self.camera(selector, width, height)?;
        let seen = self.seen(camera.ray(pixel.map(|x| x as f32 + 0.5)));
        let seen =
            seen.ok_or_else(|| Error::usage(format!("the focus is on pixel {x},{y}, which shows no surface")))?;
        self.depth_of(selector, seen.p, &format!("what pixel {x},{y} shows"))
    }

    /// Returns the distance along the camera's axis to the point `p` of `what`.
    fn depth_of(&self, selector: Option<&str>, p: Vec3, what: &str) -> Result<f64> {
        let transform = self.view(selector)?.transform;
        let backward = transform.matrix3.z_axis.normalize_or_zero();
        let depth = (transform.translation - self.rebase.point_in_file(DVec3::from(p))).dot(backward);
        if depth > 0.0 { Ok(depth) } else { Err(Error::usage(format!("{what} is not in front of the camera"))) }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::accel::Backend;
    use crate::scene::BuildOptions;
    use crate::scene::description::{CameraDescription, Description, Instance, Material, Mesh, Primitive, Projection};
    use glam::DAffine3;

    /// Squares of half side 1 that face +z, at z = −4 around the axis and at (3, 0, −8), seen from z = 2 with 90
    /// degrees. All of it is moved and turned far away.
    fn scene() -> Scene {
        let by = DAffine3::from_rotation_translation(glam::DQuat::from_rotation_y(0.7), DVec3::new(50.0, -20.0, 9.0));
        let mut description = Description::default();
        let corners = [[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]].map(|[x, y]| Vec3::new(x, y, 0.0));
        let (positions, triangles) = (corners.to_vec(), vec![[0, 1, 2], [0, 2, 3]]);
        let primitives = vec![Primitive { positions, triangles, ..Primitive::default() }];
        description.meshes.push(Mesh { name: "square".into(), primitives });
        description.materials.push(Material { double_sided: true, ..Material::default() });
        for (name, place) in [("near", DVec3::new(0.0, 0.0, -4.0)), ("far", DVec3::new(3.0, 0.0, -8.0))] {
            let transform = by * DAffine3::from_translation(place);
            description.instances.push(Instance { name: name.into(), mesh: 0, transform });
        }
        let transform = by * DAffine3::from_translation(DVec3::new(0.0, 0.0, 2.0));
        let perspective = Projection::Perspective { yfov: std::f64::consts::FRAC_PI_2, aspect: None };
        for (name, projection) in [("eye", perspective), ("flat", Projection::Orthographic { xmag: 4.0, ymag: 4.0 })] {
            description.cameras.push(CameraDescription { name: name.into(), projection, transform, lens: None });
        }
        let options = BuildOptions { backend: Backend::Obvhs, threads: 1, ..BuildOptions::default() };
        Scene::build(description, &options).expect("a valid scene")
    }

    /// Roundings of coordinates of 60 in a scene that is rebased to radius 1, a dozen.
    const ROUNDING: f64 = 12.0 * 60.0 * f32::EPSILON as f64;

    #[test]
    fn depths_are_along_the_axis() {
        let scene = scene();
        let of_node = |name: &str| scene.depth_of_node(None, name).expect("there");
        assert!((of_node("near") - 6.0).abs() < ROUNDING, "{}", of_node("near"));
        assert!((of_node("far") - 10.0).abs() < ROUNDING, "{}", of_node("far"));
        // (3, 0) at depth 10 is 0.3 to the right on a view plane of half height 1: pixel 65 of 100. Its neighbour's
        // distance along the ray would be 10.4.
        let far = scene.depth_of_pixel(None, [100, 100], [65, 50]).expect("seen");
        assert!((far - 10.0).abs() < ROUNDING, "{far}");
        assert!((scene.depth_of_pixel(Some("flat"), [8, 8], [4, 4]).expect("seen") - 6.0).abs() < ROUNDING);
    }

    #[test]
    fn what_is_not_there_is_named() {
        let scene = scene();
        let says = |found: Result<f64>, what: &str| {
            let text = found.expect_err(what).to_string();
            assert!(text.contains(what), "{text}");
        };
        says(scene.depth_of_node(None, "nobody"), "'nobody'");
        says(scene.depth_of_node(Some("who"), "near"), "no camera 'who'");
        says(scene.depth_of_pixel(None, [100, 100], [100, 5]), "outside the image");
        says(scene.depth_of_pixel(None, [100, 100], [5, 5]), "shows no surface");
    }

    #[test]
    fn the_angle_of_view_is_that_of_the_camera() {
        let scene = scene();
        let yfov = scene.yfov(None).expect("a camera").expect("perspective");
        assert!((yfov - std::f64::consts::FRAC_PI_2).abs() < f64::EPSILON);
        assert!(scene.yfov(Some("flat")).expect("a camera").is_none());
    }
}
