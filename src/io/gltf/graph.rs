//! The node hierarchy, flattened to nodes with world transforms in f64. The traversal is iterative, so that depth is
//! unlimited.

use super::animation::{Moved, Pose};
use super::document::{Document, name_or, numbers};
use super::quaternion::unit_quaternion;
use crate::error::{Error, Result};
use glam::{DAffine3, DMat3, DMat4, DQuat, DVec3, DVec4};
use serde_json::Value;

/// A node of the scene.
pub(super) struct Placement {
    /// Its index in the file.
    pub(super) node: usize,
    /// Local-to-world transform.
    pub(super) transform: DAffine3,
    /// Frame of its camera or light: orthonormal axes, independent of the scales of the node and its ancestors.
    pub(super) stand: DAffine3,
    /// Whether the scale is zero along every axis, which hides its mesh and light.
    pub(super) hidden: bool,
}

/// Transform of a node from its root, and the same without the signs and zeros of scales.
#[derive(Clone, Copy)]
struct Way {
    transform: DAffine3,
    axes: DMat3,
}

/// Returns the nodes of the scene in that pose, parents before children, in file order.
///
/// # Errors
/// A scene error that names the node if it has two parents or is its own ancestor, or if a transform is not valid.
pub(super) fn placements(document: &Document, pose: &Pose) -> Result<Vec<Placement>> {
    let name = |node: usize| name_or(&document.root.nodes[node].name, "node", node);
    let mut seen = vec![false; document.root.nodes.len()];
    let root = Way { transform: DAffine3::IDENTITY, axes: DMat3::IDENTITY };
    let mut stack: Vec<(usize, Way)> = roots(document)?.into_iter().rev().map(|n| (n, root)).collect();
    let mut placements = Vec::new();
    while let Some((node, parent)) = stack.pop() {
        if std::mem::replace(&mut seen[node], true) {
            return Err(Error::scene(format!(
                "node '{}' is its own ancestor, or a root below another root",
                name(node)
            )));
        }
        let local = local_transform(&document.raw["nodes"][node], pose.of(node));
        let local = local.map_err(|e| e.context(format!("node '{}'", name(node))))?;
        let (transform, axes) = (parent.transform * local.transform, parent.axes * local.axes);
        if !transform.is_finite() {
            return Err(Error::scene(format!("node '{}' has a transform that is not finite", name(node))));
        }
        let children = document.root.nodes[node].children.as_deref().unwrap_or_default();
        stack.extend(children.iter().rev().map(|c| (c.value(), Way { transform, axes })));
        let stand = DAffine3 { matrix3: upright(&axes), translation: transform.translation };
        let hidden = transform.matrix3 == DMat3::ZERO;
        placements.push(Placement { node, transform, stand, hidden });
    }
    Ok(placements)
}

/// Returns the root nodes of the default scene, else of the first scene, else all nodes without a parent.
fn roots(document: &Document) -> Result<Vec<usize>> {
    let parents = parents(document)?;
    let root = &document.root;
    if let Some(scene) = root.scenes.get(root.scene.map_or(0, |s| s.value())) {
        return Ok(scene.nodes.iter().map(|n| n.value()).collect());
    }
    let roots: Vec<usize> = (0..parents.len()).filter(|&n| parents[n].is_none()).collect();
    if roots.is_empty() && !parents.is_empty() {
        return Err(Error::scene("there is no root node: every node is below another one"));
    }
    Ok(roots)
}

fn parents(document: &Document) -> Result<Vec<Option<usize>>> {
    let nodes = &document.root.nodes;
    let name = |node: usize| name_or(&nodes[node].name, "node", node);
    let mut parents: Vec<Option<usize>> = vec![None; nodes.len()];
    for (parent, node) in nodes.iter().enumerate() {
        for child in node.children.iter().flatten().map(|c| c.value()) {
            if let Some(other) = parents[child].replace(parent) {
                let (first, second) = (name(other), name(parent));
                return Err(Error::scene(format!("node '{}' has two parents, '{first}' and '{second}'", name(child))));
            }
        }
    }
    Ok(parents)
}

/// Returns a node's local transform. Animated nodes have no matrix.
fn local_transform(node: &Value, moved: Option<&Moved>) -> Result<Way> {
    if let Some(matrix) = numbers::<16>(&node["matrix"]) {
        let transform = affine(&DMat4::from_cols_array(&matrix))?;
        return Ok(Way { transform, axes: regular(&transform.matrix3) });
    }
    let own = |key: &str, default: DVec3| numbers(&node[key]).map_or(default, DVec3::from);
    let translation = moved.and_then(|m| m.translation).unwrap_or_else(|| own("translation", DVec3::ZERO));
    let scale = moved.and_then(|m| m.scale).unwrap_or_else(|| own("scale", DVec3::ONE));
    let rotation = match moved.and_then(|m| m.rotation) {
        Some(rotation) => Some(rotation),
        None => numbers(&node["rotation"]).map_or(Some(DQuat::IDENTITY), unit_quaternion),
    };
    let rotation = rotation.ok_or_else(|| Error::scene("the rotation is not a unit quaternion"))?;
    let stretch = DVec3::from(scale.to_array().map(|s| if s == 0.0 { 1.0 } else { s.abs() }));
    Ok(Way {
        transform: DAffine3::from_scale_rotation_translation(scale, rotation, translation),
        axes: DMat3::from_quat(rotation) * DMat3::from_diagonal(stretch),
    })
}

/// Axes of a matrix whose scales are unknown. A reflection is taken as one of x, and a singular matrix as no rotation.
fn regular(matrix: &DMat3) -> DMat3 {
    match matrix.determinant() {
        d if d > 0.0 => *matrix,
        d if d < 0.0 => DMat3::from_cols(-matrix.x_axis, matrix.y_axis, matrix.z_axis),
        _ => DMat3::IDENTITY,
    }
}

/// Orthonormal axes: z is kept, since cameras and lights look along it, then y is made orthogonal to it [glTF20
/// §3.10.2].
fn upright(axes: &DMat3) -> DMat3 {
    let z = axes.z_axis.try_normalize().unwrap_or(DVec3::Z);
    let y = (axes.y_axis - z * z.dot(axes.y_axis)).try_normalize().unwrap_or_else(|| z.any_orthonormal_vector());
    DMat3::from_cols(y.cross(z), y, z)
}

fn affine(matrix: &DMat4) -> Result<DAffine3> {
    // Exporters compute in f32, so that the last row may have this error.
    if !(matrix.row(3) - DVec4::W).abs().cmple(DVec4::splat(f64::from(f32::EPSILON))).all() {
        return Err(Error::scene("the matrix is not affine: its last row is not 0 0 0 1"));
    }
    Ok(DAffine3::from_mat4(*matrix))
}

/// Whether the matrix collapses every triangle to zero area.
pub(super) fn is_line(m: &DMat3) -> bool {
    [m.x_axis.cross(m.y_axis), m.y_axis.cross(m.z_axis), m.z_axis.cross(m.x_axis)]
        .iter()
        .all(|area| *area == DVec3::ZERO)
}
