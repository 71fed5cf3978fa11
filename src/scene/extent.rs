//! Position and size of a scene, and its centre of detail, in the world space of the file.

use super::description::{Description, Instance, Primitive};
use super::rebase::MOST;
use crate::error::{Error, Result};
use glam::DVec3;

/// Approximate number of triangles used for the centre of detail; larger scenes are sampled evenly.
const SAMPLE: usize = 1 << 20;

/// A triangle is degraded if rounding to f32 moves its vertices by more than this fraction of its longest edge.
const SPOILT: f64 = 0.01;

/// Bounding box of a scene and its centre of detail.
#[derive(Debug, Clone, Copy)]
pub(super) struct Extent {
    pub(super) min: DVec3,
    pub(super) max: DVec3,
    /// Minimiser of the sum over triangles of (distance / size)², with the longest edge as size: the relative precision
    /// loss of a triangle in f32 is proportional to that ratio. It is the mean of the triangles' centres, weighted by 1
    /// / size².
    pub(super) detail: DVec3,
    /// Approximate number of triangles that remain degraded: see [`SPOILT`].
    pub(super) spoilt: usize,
}

impl Extent {
    /// Returns the extent of `description`.
    ///
    /// # Errors
    /// A scene error if there is no triangle or a position is not finite.
    pub(super) fn of(description: &Description) -> Result<Extent> {
        let (min, max) = world_box(description);
        if min.cmple(max).all() && min.is_finite() && max.is_finite() {
            let detail = centre_of_detail(description, (min + max) * 0.5);
            Ok(Extent { min, max, detail, spoilt: spoilt(description, detail) })
        } else if min.x > max.x {
            if description.hides {
                Ok(Extent::nothing(description))
            } else {
                Err(Error::scene("the scene has no triangles"))
            }
        } else {
            Err(Error::scene("the scene has positions that are not finite"))
        }
    }

    /// Returns the extent of a scene with everything hidden: the position of its camera.
    fn nothing(description: &Description) -> Extent {
        let at = description.cameras.first().map_or(DVec3::ZERO, |c| c.transform.translation);
        Extent { min: at, max: at, detail: at, spoilt: 0 }
    }

    /// Checks that single precision can represent squares and inverses of lengths of the scene.
    ///
    /// # Errors
    /// A scene error that states its size.
    pub(super) fn check(&self) -> Result<()> {
        let radius = self.radius();
        if radius == 0.0 || (MOST.recip()..=MOST).contains(&radius) {
            return Ok(());
        }
        let least = MOST.recip();
        Err(Error::scene(format!(
            "the scene has a radius of {radius:.3e} m, and only radii of {least:e} to {MOST:e} m can be rendered in \
             single precision"
        )))
    }

    /// Returns half the diagonal of the box.
    pub(super) fn radius(&self) -> f64 {
        (self.max - self.min).length() * 0.5
    }
}

/// Returns a box around all placed positions. It is the smallest box if no mesh has several instances. Otherwise it
/// encloses the boxes of instanced meshes, so that the time does not grow with instances × vertices.
pub(super) fn world_box(description: &Description) -> (DVec3, DVec3) {
    let (mut min, mut max) = (DVec3::INFINITY, DVec3::NEG_INFINITY);
    let mut uses = vec![0usize; description.meshes.len()];
    description.instances.iter().for_each(|i| uses[i.mesh] += 1);
    let mut boxes: Vec<Option<Vec<DVec3>>> = vec![None; description.meshes.len()];
    for instance in &description.instances {
        let positions =
            description.meshes[instance.mesh].primitives.iter().flat_map(|p| &p.positions).map(|p| p.as_dvec3());
        let mut include = |p: DVec3| {
            let placed = instance.transform.transform_point3(p);
            min = min.min(placed);
            max = max.max(placed);
        };
        if uses[instance.mesh] == 1 {
            positions.for_each(include);
        } else {
            boxes[instance.mesh].get_or_insert_with(|| corners(positions)).iter().for_each(|&p| include(p));
        }
    }
    (min, max)
}

/// Returns the corners of the bounding box of `positions`; none for no positions.
fn corners(positions: impl Iterator<Item = DVec3>) -> Vec<DVec3> {
    let (mut min, mut max) = (DVec3::INFINITY, DVec3::NEG_INFINITY);
    positions.for_each(|p| (min, max) = (min.min(p), max.max(p)));
    let corner = |i: u32| DVec3::select(glam::BVec3::new(i & 1 != 0, i & 2 != 0, i & 4 != 0), max, min);
    if min.x <= max.x { (0..8).map(corner).collect() } else { Vec::new() }
}

fn parts(description: &Description) -> impl Iterator<Item = (&Instance, &Primitive)> {
    description.instances.iter().flat_map(|i| description.meshes[i.mesh].primitives.iter().map(move |p| (i, p)))
}

/// Returns the centre, relative to `origin`, and the squared longest edge of every `step`th triangle of each part.
fn sizes(description: &Description, step: usize, origin: DVec3) -> impl Iterator<Item = (DVec3, f64)> {
    parts(description).flat_map(move |(instance, primitive)| {
        primitive.triangles.iter().step_by(step).filter_map(move |corners| {
            // Indices are checked later, at mesh construction.
            let [Some(a), Some(b), Some(c)] = corners.map(|i| primitive.positions.get(i as usize)) else { return None };
            let [a, b, c] = [a, b, c].map(|p| instance.transform.transform_point3(p.as_dvec3()) - origin);
            let size2 = (b - a).length_squared().max((c - b).length_squared()).max((a - c).length_squared());
            Some(((a + b + c) / 3.0, size2))
        })
    })
}

/// Returns the sampling step over triangles.
fn step(description: &Description) -> usize {
    parts(description).map(|(_, p)| p.triangles.len()).sum::<usize>() / SAMPLE + 1
}

/// Computes [`Extent::detail`]; offsets are relative to `middle`, which is the result if no triangle has a size.
fn centre_of_detail(description: &Description, middle: DVec3) -> DVec3 {
    let (mut sum, mut total) = (DVec3::ZERO, 0.0);
    for (centre, size2) in sizes(description, step(description), middle) {
        let weight = size2.recip();
        if weight.is_finite() {
            sum += centre * weight;
            total += weight;
        }
    }
    let offset = sum / total;
    if offset.is_finite() { middle + offset } else { middle }
}

/// Computes [`Extent::spoilt`]. Triangles without size cannot lose precision.
fn spoilt(description: &Description, origin: DVec3) -> usize {
    let half_ulp = 0.5 * f64::from(f32::EPSILON);
    let lost = |(centre, size2): &(DVec3, f64)| {
        let moved = half_ulp * centre.abs().max_element();
        *size2 > 0.0 && moved * moved > SPOILT * SPOILT * size2
    };
    let step = step(description);
    sizes(description, step, origin).filter(lost).count() * step
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::description::Mesh;
    use glam::{DAffine3, Vec3};

    fn triangle(size: f32) -> Mesh {
        let positions = vec![Vec3::ZERO, Vec3::X * size, Vec3::Y * size];
        let primitive = Primitive { positions, triangles: vec![[0, 1, 2]], ..Primitive::default() };
        Mesh { name: String::new(), primitives: vec![primitive] }
    }

    fn extent(placed: &[(f32, f64)]) -> Extent {
        let mut scene = Description::default();
        for (mesh, &(size, x)) in placed.iter().enumerate() {
            scene.meshes.push(triangle(size));
            scene.instances.push(Instance {
                name: String::new(),
                mesh,
                transform: DAffine3::from_translation(DVec3::X * x),
            });
        }
        Extent::of(&scene).expect("triangles")
    }

    #[test]
    fn origin_is_near_the_smallest_detail() {
        let e = extent(&[(1e-3, 3.0), (1.0, 4.0), (1e6, 1e8)]);
        assert!(e.detail.x - 3.0 < 1e-3 && e.radius() > 4e7, "{e:?}");
        assert_eq!(e.spoilt, 0);
        let alike = extent(&[(1.0, -10.0), (1.0, 10.0)]);
        assert!((alike.detail.x - 1.0 / 3.0).abs() < 1e-12, "{alike:?}"); // a third of an edge beside the corner; rounding
    }

    #[test]
    fn small_objects_far_apart_are_counted_as_imprecise() {
        assert_eq!(extent(&[(1e-3, 0.0), (2e-3, 1e8), (1e6, 1e8)]).spoilt, 2);
        assert_eq!(extent(&[(1e-3, 0.0), (2.0, 1e8), (1e6, 1e8)]).spoilt, 1);
        assert_eq!(extent(&[(1e-3, 0.0), (2e-3, 10.0)]).spoilt, 0);
    }

    #[test]
    fn origin_of_a_scene_of_points_is_their_middle() {
        assert!(extent(&[(0.0, 1.0), (0.0, 3.0)]).detail.x == 2.0);
    }
}
