//! Triangles from lists, strips and fans [glTF20 §3.7.2.1].

use ::gltf::json::mesh::Mode;

/// Triangulates `indices` according to `mode`, counter-clockwise; `None` for points and lines. Degenerate triangles of
/// strips and fans (a repeated index) are dropped, and so are vertices that complete no triangle.
pub(super) fn triangles(mode: Mode, indices: &[u32]) -> Option<Vec<[u32; 3]>> {
    match mode {
        Mode::Triangles => Some(indices.chunks_exact(3).map(|t| [t[0], t[1], t[2]]).collect()),
        Mode::TriangleStrip => Some(strip(indices)),
        Mode::TriangleFan => Some(fan(indices)),
        Mode::Points | Mode::Lines | Mode::LineLoop | Mode::LineStrip => None,
    }
}

fn strip(indices: &[u32]) -> Vec<[u32; 3]> {
    let oriented = |(i, t): (usize, &[u32])| if i % 2 == 0 { [t[0], t[1], t[2]] } else { [t[0], t[2], t[1]] };
    indices.windows(3).enumerate().map(oriented).filter(distinct).collect()
}

fn fan(indices: &[u32]) -> Vec<[u32; 3]> {
    let Some((&centre, rim)) = indices.split_first() else { return Vec::new() };
    rim.windows(2).map(|edge| [edge[0], edge[1], centre]).filter(distinct).collect()
}

fn distinct(&[a, b, c]: &[u32; 3]) -> bool {
    a != b && b != c && c != a
}
