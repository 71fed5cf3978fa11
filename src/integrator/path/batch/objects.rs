//! What kernels know of the objects of a scene: a row for each.

use crate::bsdf::Surface;
use crate::bsdf::lanes::{LaneModel, LaneSurface, Parameters};
use crate::scene::Scene;

/// An object.
#[derive(Debug, Clone, Copy)]
pub(super) struct ObjectRow<'a> {
    /// How its hits are shaded.
    pub(super) shader: Shader,
    /// Whether it has shading normals.
    pub(super) has_normals: bool,
    /// Parameters of a constant surface.
    pub(super) parameters: Parameters,
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
    /// By the kernel of a model, with constant parameters.
    Constant(LaneModel),
    /// By the kernel of the model that textures and vertex colours make of it at each point.
    Varying,
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
    let surface = scene.constant_surface(object);
    let kernel = surface.and_then(LaneSurface::new);
    let mesh = scene.geometry().mesh_of(object as u32);
    let shader = match (surface, &kernel) {
        _ if scene.geometry().objects[object].placement.is_some() || scene.transmits(object) => Shader::Single,
        (_, Some(row)) => Shader::Constant(row.model),
        (Some(Surface::Black), _) => Shader::Black,
        (Some(_), _) => Shader::Single,
        (None, _) => Shader::Varying,
    };
    ObjectRow {
        shader,
        has_normals: mesh.attributes().normals.is_some(),
        parameters: kernel.map_or(Parameters::default(), |row| row.parameters),
        corners: mesh.corner_rows(),
        emits: scene.emits(object),
        may_be_culled: scene.may_be_culled(object),
    }
}
