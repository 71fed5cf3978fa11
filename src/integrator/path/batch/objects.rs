//! What kernels know of the objects of a scene: a row for each.

use crate::bsdf::Surface;
use crate::bsdf::lanes::{LaneModel, SurfaceRow};
use crate::scene::Scene;
use etendue_lanes::ROW;

/// An object.
#[derive(Debug, Clone, Copy)]
pub(super) struct ObjectRow<'a> {
    /// How its hits are shaded.
    pub(super) shader: Shader,
    /// Parameters of the surface for its kernel.
    pub(super) parameters: [f32; ROW],
    /// Coordinates of its triangles.
    pub(super) corners: &'a [[f32; 9]],
    /// Whether its triangles emit.
    pub(super) emits: bool,
    /// Whether the camera does not see its back.
    pub(super) may_be_culled: bool,
}

/// How the hits of an object are shaded.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Shader {
    /// By the kernel of a model.
    Kernel(LaneModel),
    /// Nothing scatters: the path ends.
    Black,
    /// By the code of single paths.
    Single,
}

/// Returns the rows of all objects.
pub(super) fn object_rows(scene: &Scene) -> Vec<ObjectRow<'_>> {
    (0..scene.geometry().objects.len()).map(|object| row(scene, object)).collect()
}

fn row(scene: &Scene, object: usize) -> ObjectRow<'_> {
    let surface = scene.flat_surface(object);
    let kernel = surface.and_then(SurfaceRow::new);
    ObjectRow {
        shader: match (surface, &kernel) {
            (_, Some(row)) => Shader::Kernel(row.model),
            (Some(Surface::Black), _) => Shader::Black,
            _ => Shader::Single,
        },
        parameters: kernel.map_or([0.0; ROW], |row| row.parameters),
        corners: scene.geometry().mesh_of(object as u32).corner_rows(),
        emits: scene.emits(object),
        may_be_culled: scene.may_be_culled(object),
    }
}
