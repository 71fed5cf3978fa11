//! Mesh primitives: their vertices and triangles.

use super::accessor::Wanted;
use super::document::Document;
use super::notes::Notes;
use super::{topology, vertex};
use crate::error::{Error, Result};
use crate::scene::description::Primitive;
use ::gltf::json;
use glam::{Vec2, Vec3, Vec4};
use json::accessor::{Accessor, ComponentType, Type};
use json::mesh::Semantic;
use json::validation::Checked;

/// Bytes of one index during triangulation: itself, and up to three in a strip.
const BYTES_AN_INDEX: usize = 4 * size_of::<u32>();

/// Loads one primitive of `mesh`, with material 0 and only the vertices that its triangles use, since exporters let
/// many primitives share one long accessor. `None`, and a note, if it shows nothing.
///
/// # Errors
/// A scene error if an accessor is not valid, an index is out of range, or a value is not finite.
pub(super) fn load(
    document: &Document,
    source: &json::mesh::Primitive,
    mesh: &str,
    notes: &mut Notes,
) -> Result<Option<Primitive>> {
    let Some(positions) = find(source, Semantic::Positions) else {
        notes.add(format!("mesh '{mesh}' has a part without positions, which is left out"));
        return Ok(None);
    };
    let vertices = document.elements_of::<3>(positions)?;
    let indices = indices(document, source, vertices)?;
    let Checked::Valid(mode) = source.mode else {
        notes.add(format!("mesh '{mesh}' has a part of a mode that does not exist, which is left out"));
        return Ok(None);
    };
    let Some(mut triangles) = topology::triangles(mode, &indices) else {
        notes.add(format!("mesh '{mesh}' has points or lines, which are left out"));
        return Ok(None);
    };
    note_unread(source, notes);
    if triangles.is_empty() {
        notes.add(format!("mesh '{mesh}' has a part without triangles, which is left out"));
        return Ok(None);
    }
    let used = renumber(&mut triangles, vertices);
    Attributes { document, source, vertices, used }.assemble(triangles, mesh, notes).map(Some)
}

/// Returns the accessor of an attribute.
fn find(source: &json::mesh::Primitive, semantic: Semantic) -> Option<usize> {
    source.attributes.get(&Checked::Valid(semantic)).map(|a| a.value())
}

/// Returns the vertex indices in the order in which they form triangles, each below `vertices`.
fn indices(document: &Document, source: &json::mesh::Primitive, vertices: usize) -> Result<Vec<u32>> {
    let count = u32::try_from(vertices).map_err(|_| Error::scene("there are more than 2^32 vertices"))?;
    let indices = match source.indices {
        Some(accessor) => document.indices(accessor.value())?,
        None => {
            document.budget.spend(vertices, BYTES_AN_INDEX)?;
            (0..count).collect()
        }
    };
    document.budget.spend(indices.len(), BYTES_AN_INDEX)?;
    match indices.iter().find(|&&i| i >= count) {
        Some(bad) => Err(Error::scene(format!("index {bad} is out of range, there are {count} vertices"))),
        None => Ok(indices),
    }
}

/// Returns the vertices that `triangles` use, in ascending order. The triangles are renumbered to positions in that
/// list.
fn renumber(triangles: &mut [[u32; 3]], vertices: usize) -> Vec<u32> {
    // Marking costs a byte per vertex, used or not. Sorting costs in proportion to the used vertices.
    const SPARSE: usize = 32;
    let few = triangles.len().saturating_mul(SPARSE) < vertices;
    let used = if few { sorted(triangles) } else { marked(triangles, vertices) };
    if used.len() < vertices {
        for index in triangles.iter_mut().flatten() {
            *index = used.partition_point(|&u| u < *index) as u32;
        }
    }
    used
}

fn sorted(triangles: &[[u32; 3]]) -> Vec<u32> {
    let mut used: Vec<u32> = triangles.iter().flatten().copied().collect();
    used.sort_unstable();
    used.dedup();
    used
}

fn marked(triangles: &[[u32; 3]], vertices: usize) -> Vec<u32> {
    let mut marks = vec![false; vertices];
    triangles.iter().flatten().for_each(|&i| marks[i as usize] = true);
    (0..).zip(marks).filter_map(|(i, used)| used.then_some(i)).collect()
}

struct Attributes<'a> {
    document: &'a Document,
    source: &'a json::mesh::Primitive,
    /// Required number of vertices of every attribute.
    vertices: usize,
    /// Vertices that are read, in ascending order.
    used: Vec<u32>,
}

impl Attributes<'_> {
    fn assemble(&self, triangles: Vec<[u32; 3]>, mesh: &str, notes: &mut Notes) -> Result<Primitive> {
        let positions = self.finite(Semantic::Positions)?.unwrap_or_default();
        let positions: Vec<Vec3> = positions.into_iter().map(Vec3::from).collect();
        let normals = self.floats(Semantic::Normals)?.map(|n| vertex::unit_normals(&n, &positions, &triangles));
        // Without normals the specification requires flat ones, and tangents to be ignored.
        let tangents = match &normals {
            Some(normals) => self.floats(Semantic::Tangents)?.map(|t| vertex::unit_tangents(&t, normals)),
            None => None,
        };
        let uvs = [self.uvs(0)?, self.uvs(1)?];
        let colors = self.colors()?.map(|c| within_unit(c, mesh, notes));
        Ok(Primitive { positions, triangles, normals, tangents, uvs, colors, material: 0 })
    }

    /// Reads an attribute at the used vertices. The file must have one element per vertex.
    fn floats<const N: usize>(&self, semantic: Semantic) -> Result<Option<Vec<[f32; N]>>> {
        let Some(index) = find(self.source, semantic.clone()) else { return Ok(None) };
        let accessor = self.document.accessor(index)?;
        if accessor.count.0 != self.vertices as u64 {
            let (has, vertices) = (accessor.count.0, self.vertices);
            return Err(Error::scene(format!("accessor {index} has {has} elements for {vertices} vertices")));
        }
        check_type(&semantic, accessor).map_err(|e| e.context(format!("accessor {index}")))?;
        self.document.floats(index, Wanted::These(&self.used)).map(Some)
    }

    fn finite<const N: usize>(&self, semantic: Semantic) -> Result<Option<Vec<[f32; N]>>> {
        let elements = self.floats(semantic.clone())?;
        if elements.as_ref().is_none_or(|e| vertex::all_finite(e)) {
            return Ok(elements);
        }
        let accessor = find(self.source, semantic).unwrap_or_default();
        Err(Error::scene(format!("accessor {accessor} has a value that is not finite")))
    }

    fn uvs(&self, set: u32) -> Result<Option<Vec<Vec2>>> {
        Ok(self.finite(Semantic::TexCoords(set))?.map(|uvs| uvs.into_iter().map(Vec2::from).collect()))
    }

    fn colors(&self) -> Result<Option<Vec<Vec4>>> {
        let semantic = Semantic::Colors(0);
        let accessor = find(self.source, semantic.clone()).and_then(|index| self.document.accessor(index).ok());
        if accessor.is_some_and(|a| a.type_ == Checked::Valid(Type::Vec3)) {
            let colors = self.finite(semantic)?;
            return Ok(colors.map(|c| c.into_iter().map(|c| Vec3::from(c).extend(1.0)).collect()));
        }
        Ok(self.finite(semantic)?.map(|c| c.into_iter().map(Vec4::from).collect()))
    }
}

/// Checks the component type of an attribute [glTF20 §3.7.2.1 and KHR_mesh_quantization].
fn check_type(semantic: &Semantic, accessor: &Accessor) -> Result<()> {
    use ComponentType::{F32, I8, I16, U8, U16, U32};
    let Checked::Valid(kind) = accessor.component_type else { return Ok(()) };
    let allowed = match (semantic, kind.0) {
        (_, F32) => true,
        (_, U32) => false,
        (Semantic::Normals | Semantic::Tangents, I8 | I16) | (Semantic::Colors(_), U8 | U16) => accessor.normalized,
        (Semantic::Normals | Semantic::Tangents, U8 | U16) | (Semantic::Colors(_), I8 | I16) => false,
        _ => true,
    };
    if allowed {
        return Ok(());
    }
    let (kind, how) = (kind.0, if accessor.normalized { "normalised" } else { "not normalised" });
    Err(Error::scene(format!("component type {kind:?}, {how}, is not for {}", semantic.to_string())))
}

fn note_unread(source: &json::mesh::Primitive, notes: &mut Notes) {
    for semantic in source.attributes.keys() {
        match semantic {
            Checked::Valid(Semantic::TexCoords(set @ 2..)) => {
                notes.add(format!("texture coordinate set {set} is not read"))
            }
            Checked::Valid(Semantic::Colors(set @ 1..)) => notes.add(format!("vertex colour set {set} is not read")),
            Checked::Valid(Semantic::Joints(_)) => notes.add("skins are not posed: the meshes are shown as modelled"),
            _ => {}
        }
    }
    if source.targets.as_ref().is_some_and(|t| !t.is_empty()) {
        notes.add("morph targets are not read: the meshes are shown as modelled");
    }
}

fn within_unit(colors: Vec<Vec4>, mesh: &str, notes: &mut Notes) -> Vec<Vec4> {
    let clamped: Vec<Vec4> = colors.iter().map(|c| c.clamp(Vec4::ZERO, Vec4::ONE)).collect();
    if clamped != colors {
        notes.add(format!("mesh '{mesh}' has vertex colours outside 0 to 1, which are clamped"));
    }
    clamped
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bitmap_and_sort_find_the_same_used_vertices() {
        let triangles = [[7, 3, 3], [0, 9, 7]];
        assert_eq!(marked(&triangles, 12), [0, 3, 7, 9]);
        assert_eq!(sorted(&triangles), [0, 3, 7, 9]);
        let mut renamed = triangles;
        assert_eq!(renumber(&mut renamed, 12), [0, 3, 7, 9]);
        assert_eq!(renamed, [[2, 1, 1], [0, 3, 2]]);
    }
}
