//! Upper bounds of scattered light.

use etendue::bsdf::{Bsdf, Lobes, MetallicRoughness, ScatteringBound, Wall};
use etendue::geometry::Local;
use etendue::sampling::lanes::uniform_sphere;
use etendue::sampling::{Address, IndependentSampler, Sampler, Slot};
use etendue::spectrum::Spectrum;
use glam::Vec3;

/// Random surfaces and directions, half of them near the mirror image, where glossy lobes are highest.
#[test]
fn no_light_is_above_the_bound() {
    let mut sampler = IndependentSampler::new(Address::new(5));
    let (mut close, mut bounded) = (0.0f32, 0);
    for i in 0..40_000 {
        let [a, b, c] = [Slot::Lobe, Slot::LightPick, Slot::Roulette].map(|slot| sampler.u1(i, slot));
        let surface = MetallicRoughness {
            base: Spectrum::from_rgb([a, b, c]),
            metallic: [0.0, 1.0, b][i as usize % 3],
            roughness: 0.1 + 0.9 * c,
            specular: [0.0, 1.0, a][i as usize % 3],
            specular_color: Spectrum::ONE,
            ior: 1.0 + a,
            outside: 1.0,
            transmission: if i % 7 == 0 { 0.5 } else { 0.0 },
            wall: Wall::Thin,
            metal_f90: Spectrum::ONE,
        }
        .surface();
        let [known, other] =
            [Slot::Film, Slot::Lens].map(|slot| Local::from(Vec3::from(uniform_sphere(sampler.u2(i, slot)))));
        let spread = if i % 2 == 0 { 0.05 } else { 100.0 };
        let other = Local::new(other.x * spread - known.x, other.y * spread - known.y, other.z * spread + known.z);
        let other = other.scale(other.dot(other).sqrt().recip());
        let value = surface.eval(other, known, Lobes::SMOOTH).max_lane() * other.z.abs();
        let ScatteringBound { diffuse, glossy } = surface.bound(known);
        let bound = diffuse * other.z.abs() + glossy;
        // Rounding of a dozen operations.
        assert!(value <= bound * (1.0 + 1e-5), "{surface:?} {known:?} {other:?}: {value} > {bound}");
        bounded += u32::from(bound.is_finite());
        close = close.max(if glossy > 0.0 { value / bound } else { 0.0 });
    }
    assert!(close > 0.5 && bounded > 20_000, "the bound is far away: {close}, or missing: {bounded}");
}
