//! The n² equal parts of a triangle with n of them along a side. Points are barycentric weights of the second and third
//! vertex. Parts are in columns of equal first weight, from 0 up. In a column, parts with the orientation of the triangle
//! come first, and then those turned by half a turn, which lie between them.

/// Returns the point of a part whose weights within the part are `inside`.
pub(super) fn in_part(n: u32, part: u32, inside: [f32; 2]) -> [f32; 2] {
    let i = n - 1 - (n * n - 1 - part).isqrt();
    let j = part - before(n, i);
    let is_upright = j < n - i;
    let (corner, sign) = if is_upright { ([i, j], 1.0) } else { ([i + 1, j + i + 1 - n], -1.0) };
    [0, 1].map(|axis| (corner[axis] as f32 + sign * inside[axis]) / n as f32)
}

/// Returns the number of parts in the columns before column `i`.
fn before(n: u32, i: u32) -> u32 {
    n * n - (n - i).pow(2)
}

/// Returns the centroids of all parts.
pub(super) fn centroids(n: u32) -> Vec<[f32; 2]> {
    (0..n * n).map(|part| in_part(n, part, [1.0 / 3.0; 2])).collect()
}
