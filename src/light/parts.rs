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

/// Returns the part with a point.
pub(super) fn part_at(n: u32, barycentric: [f64; 2]) -> u32 {
    let [u, v] = barycentric.map(|x| (x * f64::from(n)).max(0.0));
    // Rounded points may lie beyond the last part of a column.
    let i = (u as u32).min(n - 1);
    let j = (v as u32).min(n - 1 - i);
    let is_upright = (u - f64::from(i)) + (v - f64::from(j)) <= 1.0 || i + j == n - 1;
    before(n, i) + if is_upright { j } else { n - i + j }
}

/// Returns the number of parts in the columns before column `i`.
fn before(n: u32, i: u32) -> u32 {
    n * n - (n - i).pow(2)
}

/// Returns the centroids of all parts.
pub(super) fn centroids(n: u32) -> Vec<[f32; 2]> {
    (0..n * n).map(|part| in_part(n, part, [1.0 / 3.0; 2])).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_part_has_its_points() {
        for n in 1..20 {
            for part in 0..n * n {
                for inside in [[0.3; 2], [0.01, 0.98], [0.01; 2], [0.98, 0.01]] {
                    let [u, v] = in_part(n, part, inside).map(f64::from);
                    assert!(u > 0.0 && v > 0.0 && u + v < 1.0, "{n} {part}: {u} {v}");
                    assert_eq!(part_at(n, [u, v]), part, "{n}: {u} {v}");
                }
            }
        }
    }

    #[test]
    fn points_that_rounding_moves_outside_belong_to_a_part() {
        for at in [[-1e-9, 0.5], [1.0 + 1e-9, 0.0], [0.5, 0.5 + 1e-9], [0.0, 1.0 + 1e-9], [1.0, -1e-9]] {
            assert!(part_at(7, at) < 49, "{at:?}");
        }
    }
}
