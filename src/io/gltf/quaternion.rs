//! Rotations as files have them.

use glam::{DQuat, DVec4};

/// Normalises a quaternion. Files round quaternions to f32, and the error would scale the node.
pub(super) fn unit_quaternion(xyzw: [f64; 4]) -> Option<DQuat> {
    DVec4::from(xyzw).try_normalize().map(DQuat::from_vec4)
}
