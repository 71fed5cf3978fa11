//! Repairs vertex attributes: unit normals, unit tangents, colours between 0 and 1.

use glam::{Vec3, Vec4};

/// Normalises the normals. One without a direction (zero or not finite) becomes the area-weighted normal of the
/// adjacent triangles, or an arbitrary unit vector if they have none either.
pub(super) fn unit_normals(normals: &[[f32; 3]], positions: &[Vec3], triangles: &[[u32; 3]]) -> Vec<Vec3> {
    let given: Vec<Option<Vec3>> = normals.iter().map(|&n| Vec3::from(n).try_normalize()).collect();
    let mut around = vec![Vec3::ZERO; if given.contains(&None) { given.len() } else { 0 }];
    if !around.is_empty() {
        for &[a, b, c] in triangles {
            let [p, q, r] = [a, b, c].map(|i| positions[i as usize]);
            let normal = (q - p).cross(r - p);
            [a, b, c].into_iter().for_each(|i| around[i as usize] += normal);
        }
    }
    let or_around = |(i, n): (usize, Option<Vec3>)| n.or_else(|| around[i].try_normalize()).unwrap_or(Vec3::Z);
    given.into_iter().enumerate().map(or_around).collect()
}

/// Normalises the tangents, with handedness ±1. One without a direction becomes an arbitrary vector perpendicular to
/// its normal.
pub(super) fn unit_tangents(tangents: &[[f32; 4]], normals: &[Vec3]) -> Vec<Vec4> {
    let repair = |(&[x, y, z, w], normal): (&[f32; 4], &Vec3)| {
        let tangent = Vec3::new(x, y, z).try_normalize().unwrap_or_else(|| normal.any_orthonormal_vector());
        tangent.extend(if w < 0.0 { -1.0 } else { 1.0 })
    };
    tangents.iter().zip(normals).map(repair).collect()
}

/// Whether every component is finite.
pub(super) fn all_finite<const N: usize>(elements: &[[f32; N]]) -> bool {
    elements.iter().flatten().all(|c| c.is_finite())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn zero_normal_becomes_the_geometric_normal() {
        let positions = [Vec3::ZERO, Vec3::X, Vec3::Y];
        let normals = unit_normals(&[[0.0; 3], [0.0, 0.0, 9.0], [f32::NAN, 0.0, 0.0]], &positions, &[[0, 1, 2]]);
        assert_eq!(normals, [Vec3::Z; 3]);
        let alone = unit_normals(&[[0.0; 3]; 3], &positions, &[]);
        assert!(alone.iter().all(|n| n.is_normalized()));
    }

    #[test]
    fn tangents_are_unit_with_a_sign() {
        let tangents = unit_tangents(&[[2.0, 0.0, 0.0, -0.5], [0.0; 4]], &[Vec3::Z, Vec3::Z]);
        assert_eq!(tangents[0], Vec4::new(1.0, 0.0, 0.0, -1.0));
        assert!(tangents[1].truncate().is_normalized() && tangents[1].truncate().dot(Vec3::Z) == 0.0);
        assert_eq!(tangents[1].w.to_bits(), 1.0f32.to_bits());
    }
}
