//! Rays, hits, triangles and surface points. A backend determines *which* primitive a ray hits. `triangle` recomputes
//! the hit point, identically for every backend. `spawn` is the only place where ray origins are offset.

mod any_hit;
mod bodies;
mod bounds;
mod box_tree;
mod exact;
mod frame;
mod mesh;
mod ray;
mod rays;
mod spawn;
mod surface_point;
mod triangle;
mod world;

pub use any_hit::{AnyHit, Opaque};
pub use bodies::Bodies;
pub use bounds::Bounds;
pub use box_tree::{Bounded, BoxTree, Leaf};
pub use exact::{Crossing, Line};
pub use frame::{Frame, Local};
pub use mesh::{Attributes, TriangleMesh};
pub use ray::{Hit, Ray, RayState};
pub use rays::{Hits, PADDING, Rays};
pub use spawn::{clear_of, leave, spawn_ray, spawn_segment};
pub use surface_point::SurfacePoint;
pub use triangle::{Triangle, TriangleHit, is_placement, placement_error};
pub use world::{Geometry, Object};

/// The computations of rays, triangles and frames over lanes. Those for glam's types are these at one lane.
pub mod lanes {
    pub use super::frame::tangents;
    pub use super::spawn::{offset, segment};
    pub use super::triangle::{Meeting, clamped, point_at, rounding_at};
}
