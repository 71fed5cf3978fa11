//! Vertices and rays as integers.

use etendue::geometry::{Geometry, Hit, Ray};
use glam::Vec3;
use num_bigint::BigInt;

/// A vector of integers.
pub(crate) type Whole = [BigInt; 3];

/// A triangle seen from a ray's origin.
pub(crate) struct Integers {
    /// In units of 2⁻¹⁴⁹⁻ᵉˣᵗʳᵃ.
    pub(crate) vertices: [Whole; 3],
    /// In units of 2⁻¹⁴⁹.
    pub(crate) direction: Whole,
    /// 149 for a placed triangle, 0 for others.
    pub(crate) extra: usize,
}

/// `x` in units of 2⁻¹⁴⁹.
///
/// # Panics
/// If it is not finite.
pub(crate) fn units(x: f32) -> BigInt {
    assert!(x.is_finite(), "{x}");
    let (bits, fraction) = (x.to_bits(), x.to_bits() & 0x7f_ffff);
    let magnitude = match (bits >> 23) & 0xff {
        0 => BigInt::from(fraction),
        exponent => BigInt::from(fraction | 0x80_0000) << (exponent - 1),
    };
    if x < 0.0 { -magnitude } else { magnitude }
}

fn whole(v: Vec3) -> Whole {
    v.to_array().map(units)
}

pub(crate) fn difference(a: &Whole, b: &Whole) -> Whole {
    std::array::from_fn(|k| &a[k] - &b[k])
}

/// a · (b × c).
pub(crate) fn triple(a: &Whole, b: &Whole, c: &Whole) -> BigInt {
    let minor = |i: usize, j: usize| &b[i] * &c[j] - &b[j] * &c[i];
    &a[0] * minor(1, 2) + &a[1] * minor(2, 0) + &a[2] * minor(0, 1)
}

impl Integers {
    /// The triangle that `hit` names, seen from the origin of `ray`.
    pub(crate) fn of(geometry: &Geometry, hit: Hit, ray: &Ray) -> Integers {
        let mesh = geometry.mesh_of(hit.object);
        let corners = mesh.triangles()[hit.primitive as usize].map(|i| whole(mesh.positions()[i as usize]));
        let direction = whole(ray.direction);
        let placement = geometry.objects[hit.object as usize].placement;
        let Some(m) = placement else {
            let origin = whole(ray.origin);
            return Integers { vertices: corners.map(|p| difference(&p, &origin)), direction, extra: 0 };
        };
        let extra = 149usize;
        let columns = [m.matrix3.x_axis, m.matrix3.y_axis, m.matrix3.z_axis].map(|axis| whole(axis.into()));
        let shift = difference(&whole(m.translation.into()), &whole(ray.origin)).map(|x| x << extra);
        let place =
            |p: &Whole| std::array::from_fn(|k| (0..3).map(|j| &columns[j][k] * &p[j]).sum::<BigInt>() + &shift[k]);
        Integers { vertices: corners.each_ref().map(place), direction, extra }
    }
}

#[test]
fn floats_are_integer_multiples_of_the_least_subnormal() {
    for (x, expected) in
        [(0.0, 0), (-0.0, 0), (f32::from_bits(1), 1), (-f32::from_bits(7), -7), (f32::MIN_POSITIVE, 1 << 23)]
    {
        assert_eq!(units(x), BigInt::from(expected), "{x}");
    }
    assert_eq!(units(-1.5), BigInt::from(-3) << 148);
    assert_eq!(units(f32::MAX), BigInt::from((1u32 << 24) - 1) << 253);
}
