//! Mesh primitives: their vertices and triangles.

use super::document::Document;
use super::notes::Notes;
use super::{topology, vertex};
use crate::error::{Error, Result};
use crate::scene::description::Primitive;
use ::gltf::json;
use glam::{Vec2, Vec3, Vec4};
use json::accessor::{ComponentType, Type};
use json::mesh::Semantic;
use json::validation::Checked;

/// Loads one primitive of `mesh`, with material 0; `None` if it shows nothing, and a note says why.
///
/// # Errors
/// A scene error if an accessor is not valid, an index is out of range or a value is not finite.
pub(super) fn load(
    document: &Document,
    source: &json::mesh::Primitive,
    mesh: &str,
    notes: &mut Notes,
) -> Result<Option<Primitive>> {
    let attributes = Attributes { document, source };
    let Some(positions) = attributes.find(Semantic::Positions) else {
        notes.add(format!("mesh '{mesh}' has a part without positions, which is left out"));
        return Ok(None);
    };
    let positions: Vec<Vec3> = attributes.finite(positions)?.into_iter().map(Vec3::from).collect();
    let Some(triangles) = triangles(document, source, positions.len())? else {
        notes.add(format!("mesh '{mesh}' has points or lines, which are left out"));
        return Ok(None);
    };
    attributes.note_unread(notes);
    if triangles.is_empty() {
        notes.add(format!("mesh '{mesh}' has a part without triangles, which is left out"));
        return Ok(None);
    }
    attributes.assemble(positions, triangles, mesh, notes).map(|p| Some(without_unused(p)))
}

/// The triangles, or `None` for points and lines.
fn triangles(document: &Document, source: &json::mesh::Primitive, vertices: usize) -> Result<Option<Vec<[u32; 3]>>> {
    let Checked::Valid(mode) = source.mode else { return Err(Error::scene("the primitive mode is not valid")) };
    let count = u32::try_from(vertices).map_err(|_| Error::scene("there are more than 2^32 vertices"))?;
    let indices = match source.indices {
        Some(accessor) => document.indices(accessor.value())?,
        None => (0..count).collect(),
    };
    if let Some(bad) = indices.iter().find(|&&i| i >= count) {
        return Err(Error::scene(format!("index {bad} is out of range, there are {count} vertices")));
    }
    Ok(topology::triangles(mode, &indices))
}

struct Attributes<'a> {
    document: &'a Document,
    source: &'a json::mesh::Primitive,
}

impl Attributes<'_> {
    /// The accessor of an attribute.
    fn find(&self, semantic: Semantic) -> Option<usize> {
        self.source.attributes.get(&Checked::Valid(semantic)).map(|a| a.value())
    }

    fn finite<const N: usize>(&self, accessor: usize) -> Result<Vec<[f32; N]>> {
        let elements = self.document.floats(accessor)?;
        if vertex::all_finite(&elements) {
            return Ok(elements);
        }
        Err(Error::scene(format!("accessor {accessor} has a value that is not finite")))
    }

    fn assemble(&self, positions: Vec<Vec3>, triangles: Vec<[u32; 3]>, mesh: &str, notes: &mut Notes) -> Result<Primitive> {
        let vertices = positions.len();
        let normals = self.of_each(Semantic::Normals, vertices, |a| self.document.floats(a))?;
        let normals = normals.map(|n| vertex::unit_normals(&n, &positions, &triangles));
        // Without normals the specification wants flat ones, and given tangents ignored.
        let tangents = match &normals {
            Some(normals) => self
                .of_each(Semantic::Tangents, vertices, |a| self.document.floats(a))?
                .map(|t| vertex::unit_tangents(&t, normals)),
            None => None,
        };
        let uvs = [self.uvs(0, vertices)?, self.uvs(1, vertices)?];
        let colors = self.of_each(Semantic::Colors(0), vertices, |a| self.colors(a))?;
        let colors = colors.map(|c| within_unit(c, mesh, notes));
        Ok(Primitive { positions, triangles, normals, tangents, uvs, colors, material: 0 })
    }

    /// An attribute's elements, of which there must be one a vertex.
    fn of_each<T>(&self, semantic: Semantic, vertices: usize, read: impl Fn(usize) -> Result<Vec<T>>) -> Result<Option<Vec<T>>> {
        let Some(accessor) = self.find(semantic) else { return Ok(None) };
        let elements = read(accessor)?;
        if elements.len() != vertices {
            return Err(Error::scene(format!("accessor {accessor} has {} elements for {vertices} vertices", elements.len())));
        }
        Ok(Some(elements))
    }

    fn uvs(&self, set: u32, vertices: usize) -> Result<Option<Vec<Vec2>>> {
        let uvs = self.of_each(Semantic::TexCoords(set), vertices, |a| self.finite(a))?;
        Ok(uvs.map(|uvs| uvs.into_iter().map(Vec2::from).collect()))
    }

    fn colors(&self, index: usize) -> Result<Vec<Vec4>> {
        let accessor = self.document.accessor(index)?;
        if !accessor.normalized && !matches!(&accessor.component_type, Checked::Valid(t) if t.0 == ComponentType::F32) {
            return Err(Error::scene(format!("accessor {index}: integer colours must be normalised")));
        }
        if accessor.type_ == Checked::Valid(Type::Vec3) {
            return Ok(self.finite(index)?.into_iter().map(|c| Vec3::from(c).extend(1.0)).collect());
        }
        Ok(self.finite(index)?.into_iter().map(Vec4::from).collect())
    }

    fn note_unread(&self, notes: &mut Notes) {
        for semantic in self.source.attributes.keys() {
            match semantic {
                Checked::Valid(Semantic::TexCoords(set @ 2..)) => notes.add(format!("texture coordinate set {set} is not read")),
                Checked::Valid(Semantic::Colors(set @ 1..)) => notes.add(format!("vertex colour set {set} is not read")),
                Checked::Valid(Semantic::Joints(_)) => notes.add("skins are not posed: the meshes are shown as modelled"),
                _ => {}
            }
        }
        if self.source.targets.as_ref().is_some_and(|t| !t.is_empty()) {
            notes.add("morph targets are not read: the meshes are shown as modelled");
        }
    }
}

fn within_unit(colors: Vec<Vec4>, mesh: &str, notes: &mut Notes) -> Vec<Vec4> {
    let clamped: Vec<Vec4> = colors.iter().map(|c| c.clamp(Vec4::ZERO, Vec4::ONE)).collect();
    if clamped != colors {
        notes.add(format!("mesh '{mesh}' has vertex colours outside 0 to 1, which are clamped"));
    }
    clamped
}

/// The primitive with only those vertices that its triangles use, in their order: exporters let many primitives share one
/// long accessor, and each would otherwise keep a copy of all of it.
fn without_unused(mut primitive: Primitive) -> Primitive {
    let mut places: Vec<Option<u32>> = vec![None; primitive.positions.len()];
    primitive.triangles.iter().flatten().for_each(|&i| places[i as usize] = Some(0));
    let kept: Vec<usize> = (0..places.len()).filter(|&i| places[i].is_some()).collect();
    if kept.len() == places.len() {
        return primitive;
    }
    kept.iter().zip(0..).for_each(|(&vertex, place)| places[vertex] = Some(place));
    primitive.triangles.iter_mut().flatten().for_each(|i| *i = places[*i as usize].unwrap_or_default());
    Primitive {
        positions: gather(&primitive.positions, &kept),
        triangles: primitive.triangles,
        normals: primitive.normals.map(|a| gather(&a, &kept)),
        tangents: primitive.tangents.map(|a| gather(&a, &kept)),
        uvs: primitive.uvs.map(|set| set.map(|a| gather(&a, &kept))),
        colors: primitive.colors.map(|a| gather(&a, &kept)),
        material: primitive.material,
    }
}

fn gather<T: Copy>(elements: &[T], places: &[usize]) -> Vec<T> {
    places.iter().map(|&i| elements[i]).collect()
}
