use super::*;
use crate::stats::test_random::Random;
use crate::texture::{Encoding, Texels};
use glam::Affine2;
use std::sync::Arc;

fn random_texture(random: &mut Random) -> Texture {
    let pick = |random: &mut Random, n: u64| (random.bits() % n) as usize;
    let (w, h) = (1 + pick(random, 90), 1 + pick(random, 70));
    let deep = pick(random, 2) == 1;
    let texel = |random: &mut Random| std::array::from_fn(|_| random.bits() as u16);
    let texels: Vec<[u16; 4]> = (0..w * h).map(|_| texel(random)).collect();
    let texels = if deep {
        Texels::Rgba16(texels.into())
    } else {
        Texels::Rgba8(texels.iter().map(|t| t.map(|c| c as u8)).collect::<Vec<_>>().into())
    };
    let wraps = [Wrap::Repeat, Wrap::Mirror, Wrap::Clamp];
    Texture {
        image: Arc::new(Bitmap::new(w as u32, h as u32, texels)),
        encoding: [Encoding::Srgb, Encoding::Linear][pick(random, 2)],
        wrap: [wraps[pick(random, 3)], wraps[pick(random, 3)]],
        filter: [TextureFilter::Nearest, TextureFilter::Linear][pick(random, 2)],
        uv_set: 0,
        transform: Affine2::from_scale_angle_translation(Vec2::new(0.9, 1.1), 0.3, Vec2::new(-0.2, 0.4)),
    }
}

/// Every lookup within a triangle lies between the extremes of the bounding box of its corners.
#[test]
fn texture_lookups_lie_within_the_extremes() {
    let mut random = Random::new(5);
    let mut unit = || (random.bits() >> 11) as f32 / (1u64 << 53) as f32;
    let mut numbers: Vec<f32> = (0..4096).map(|_| unit()).collect();
    let mut next = || numbers.pop().unwrap_or(0.5);
    let mut random = Random::new(6);
    for _ in 0..200 {
        let texture = random_texture(&mut random);
        let (origin, size) = (next() * 6.0 - 3.0, next() * next() * 2.0);
        let mut corner = || Vec2::new(origin + size * next(), size * next() - origin);
        let uvs = [corner(), corner(), corner()];
        let extremes = texture.extremes(uvs.into_iter());
        for i in 0..400 {
            let (u, v) = (((i % 20) as f32 + 0.5) / 20.0, ((i / 20) as f32 + 0.5) / 20.0);
            let uv = uvs[0] * (1.0 - u.min(1.0 - v) - v) + uvs[1] * u.min(1.0 - v) + uvs[2] * v;
            let seen = texture.at(uv);
            #[allow(clippy::needless_range_loop)] // four arrays are indexed alike
            for c in 0..4 {
                // Two blends, each within a few roundings of numbers up to 1.
                let rounding = 8.0 * f32::EPSILON;
                assert!(
                    (extremes.min[c] - rounding..=extremes.max[c] + rounding).contains(&seen[c]),
                    "{texture:?} at {uv}"
                );
            }
        }
    }
}

/// One exceptional texel affects exactly the extremes of coordinates that touch it.
#[test]
fn untouched_texels_do_not_widen_the_extremes() {
    let (w, h) = (100u32, 80u32);
    for wrap in [Wrap::Repeat, Wrap::Mirror, Wrap::Clamp] {
        let mut texels = vec![[200u8; 4]; (w * h) as usize];
        texels[(40 * w + 70) as usize] = [0; 4];
        let image = Arc::new(Bitmap::new(w, h, Texels::Rgba8(texels.into())));
        for (filter, reach) in [(TextureFilter::Nearest, 0.6), (TextureFilter::Linear, 1.1)] {
            let (encoding, transform) = (Encoding::Linear, Affine2::IDENTITY);
            let texture =
                Texture { image: Arc::clone(&image), encoding, wrap: [wrap; 2], filter, uv_set: 0, transform };
            let least = |from: [f32; 2], to: [f32; 2]| {
                let at = |[x, y]: [f32; 2]| Vec2::new(x / w as f32, y / h as f32);
                texture.extremes([at(from), at(to)].into_iter()).min[0]
            };
            assert_eq!(least([70.5, 40.5], [70.5, 40.5]), 0.0);
            assert_eq!(least([0.5, 0.5], [70.5, 40.5]), 0.0);
            assert_eq!(least([0.5, 0.5], [70.5 - reach, 79.5]), 200.0 / 255.0);
            assert_eq!(least([70.5 + reach, 0.5], [99.0, 79.5]), 200.0 / 255.0);
            // The same place beyond the border.
            let beyond = match wrap {
                Wrap::Repeat => 170.5,
                Wrap::Mirror => 129.5,
                Wrap::Clamp => continue,
            };
            assert_eq!(least([beyond, 40.5], [beyond, 40.5]), 0.0);
            assert_eq!(least([beyond - 10.0, 40.5], [beyond - reach, 40.5]), 200.0 / 255.0);
        }
    }
}
