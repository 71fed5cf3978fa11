//! Immutable, validated triangle meshes.

use crate::error::{Error, Result};
use crate::geometry::Bounds;
use crate::huge_vec::HugeVec;
use glam::{Vec2, Vec3, Vec4};

/// Optional per-vertex data besides positions. Each array is as long as the positions.
#[derive(Debug, Clone, Default)]
pub struct Attributes {
    /// Shading normals of unit length.
    pub normals: Option<HugeVec<Vec3>>,
    /// Tangents; w is the handedness of the bitangent, ±1.
    pub tangents: Option<HugeVec<Vec4>>,
    /// Texture coordinates of set 0 and set 1.
    pub uvs: [Option<HugeVec<Vec2>>; 2],
    /// Linear vertex colours with alpha.
    pub colors: Option<HugeVec<Vec4>>,
}

impl Attributes {
    fn lengths(&self) -> impl Iterator<Item = (&'static str, usize)> {
        [
            ("normals", self.normals.as_ref().map(|a| a.len())),
            ("tangents", self.tangents.as_ref().map(|a| a.len())),
            ("texture coordinates 0", self.uvs[0].as_ref().map(|a| a.len())),
            ("texture coordinates 1", self.uvs[1].as_ref().map(|a| a.len())),
            ("colours", self.colors.as_ref().map(|a| a.len())),
        ]
        .into_iter()
        .filter_map(|(name, length)| Some((name, length?)))
    }
}

/// A triangle mesh: not empty, every index in range, every position finite. It is immutable, so that backends may keep
/// pointers into it for as long as they hold it.
#[derive(Debug)]
pub struct TriangleMesh {
    name: String,
    /// Padded by one element: backends read 16 bytes at the last 12-byte position.
    padded_positions: HugeVec<Vec3>,
    triangles: HugeVec<[u32; 3]>,
    /// Vertices of each triangle side by side: a hit reads one or two cache lines in place of four.
    corners: HugeVec<[Vec3; 3]>,
    attributes: Attributes,
}

impl TriangleMesh {
    /// Returns a mesh of `triangles` (counter-clockwise seen from the front) over `positions`.
    ///
    /// # Errors
    /// A scene error with the name of the mesh if it is empty, an index is out of range, a position is not finite, or
    /// the length of an attribute differs from that of the positions.
    pub fn new(
        name: impl Into<String>,
        mut positions: Vec<Vec3>,
        triangles: Vec<[u32; 3]>,
        attributes: Attributes,
    ) -> Result<Self> {
        let name = name.into();
        let fail = |what: String| Err(Error::scene(format!("mesh '{name}' {what}")));
        if triangles.is_empty() || positions.is_empty() {
            return fail("has no triangles".into());
        }
        if u32::try_from(positions.len()).is_err() || u32::try_from(triangles.len()).is_err() {
            return fail("has more than 2^32 vertices or triangles".into());
        }
        if let Some(i) = positions.iter().position(|p| !p.is_finite()) {
            return fail(format!("has a position that is not finite (vertex {i})"));
        }
        let count = positions.len();
        if let Some(i) = triangles.iter().position(|t| t.iter().any(|&v| v as usize >= count)) {
            return fail(format!(
                "has an index out of range (triangle {i} is {:?}, there are {count} vertices)",
                triangles[i]
            ));
        }
        if let Some((what, length)) = attributes.lengths().find(|&(_, length)| length != count) {
            return fail(format!("has {length} {what} for {count} vertices"));
        }
        let corners: Vec<_> = triangles.iter().map(|t| t.map(|i| positions[i as usize])).collect();
        positions.push(Vec3::ZERO);
        Ok(TriangleMesh {
            name,
            padded_positions: positions.into(),
            triangles: triangles.into(),
            corners: corners.into(),
            attributes,
        })
    }

    /// Returns its name in the scene file.
    pub fn name(&self) -> &str {
        &self.name
    }

    /// Returns the vertex positions.
    #[inline]
    pub fn positions(&self) -> &[Vec3] {
        &self.padded_positions[..self.padded_positions.len() - 1]
    }

    /// Returns the vertex positions and one element of padding.
    pub fn padded_positions(&self) -> &[Vec3] {
        &self.padded_positions
    }

    /// Returns the vertex indices of each triangle.
    #[inline]
    pub fn triangles(&self) -> &[[u32; 3]] {
        &self.triangles
    }

    /// Returns the vertices of triangle `primitive`.
    #[inline]
    pub fn corners(&self, primitive: u32) -> [Vec3; 3] {
        self.corners[primitive as usize]
    }

    /// Returns the coordinates of the vertices of all triangles, nine a triangle.
    #[inline]
    pub fn corner_rows(&self) -> &[[f32; 9]] {
        bytemuck::cast_slice(&self.corners)
    }

    /// Returns the per-vertex data besides positions.
    #[inline]
    pub fn attributes(&self) -> &Attributes {
        &self.attributes
    }

    /// Returns the bounding box of all vertices.
    pub fn bounds(&self) -> Bounds {
        Bounds::around(self.positions().iter().copied())
    }

    /// Returns the memory in bytes, attributes included.
    pub fn bytes(&self) -> usize {
        let a = &self.attributes;
        size_of_val(self.padded_positions())
            + size_of_val(self.triangles())
            + size_of_val(&*self.corners)
            + a.normals.as_deref().map_or(0, size_of_val)
            + a.tangents.as_deref().map_or(0, size_of_val)
            + a.uvs.iter().map(|uv| uv.as_deref().map_or(0, size_of_val)).sum::<usize>()
            + a.colors.as_deref().map_or(0, size_of_val)
    }
}
