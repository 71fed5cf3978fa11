//! Warps against their densities and inverses.

use etendue::sampling::warp::*;
use etendue_testing::chi_square::{SphereCells, p_value, sidak};
use etendue_testing::random::{Random, samples};
use glam::{Vec2, Vec3};
use std::f32::consts::FRAC_1_PI;

/// p-value of the counts of `cell` over random squares against equal probabilities of `cells`.
fn uniform(seed: u64, cells: usize, cell: impl Fn([f32; 2]) -> usize) -> f64 {
    let (mut random, n) = (Random::new(seed), samples(200_000));
    let mut observed = vec![0.0; cells];
    (0..n).for_each(|_| observed[cell(random.cube())] += 1.0);
    p_value(&observed, &vec![f64::from(n) / cells as f64; cells])
}

/// p-value of directions against their density.
fn follows(seed: u64, warp: impl Fn([f32; 2]) -> Vec3, pdf: impl Fn(Vec3) -> f32) -> f64 {
    let cells = SphereCells::new([0.6, 0.0, 0.8], 1.0);
    let (mut random, n) = (Random::new(seed), samples(200_000));
    let mut observed = vec![0.0; cells.count()];
    (0..n).for_each(|_| observed[cells.index(warp(random.cube()).to_array().map(f64::from))] += 1.0);
    let density = |w: [f64; 3]| f64::from(pdf(Vec3::from_array(w.map(|x| x as f32))));
    let expected: Vec<f64> = cells.integrate(1e-7, &density).iter().map(|p| p * f64::from(n)).collect();
    p_value(&observed, &expected)
}

fn upper(w: Vec3, pdf: f32) -> f32 {
    if w.z > 0.0 { pdf } else { 0.0 }
}

#[test]
fn warps_follow_their_densities() {
    let disk = |u| {
        let p: Vec2 = concentric_disk(u);
        let ring = ((p.length_squared() * 20.0) as usize).min(19);
        ring * 20 + (turn(p.y, p.x) * 20.0) as usize
    };
    let triangle = |u| {
        let [b, c] = uniform_triangle(u);
        let (i, j) = ((b * 16.0) as usize, (c * 16.0) as usize);
        // the 256 congruent small triangles: two in each cell of the grid but one along the long side
        let upper = usize::from(b * 16.0 - i as f32 + c * 16.0 - j as f32 > 1.0);
        let row_start: usize = (0..i).map(|k| 31 - 2 * k).sum();
        row_start + 2 * j + upper
    };
    let results = [
        ("disk", uniform(31, 400, disk)),
        ("triangle", uniform(32, 256, triangle)),
        ("cosine hemisphere", follows(33, cosine_hemisphere, |w| w.z.max(0.0) * FRAC_1_PI)),
        ("uniform hemisphere", follows(34, uniform_hemisphere, |w| upper(w, uniform_hemisphere_pdf().value()))),
        ("uniform sphere", follows(35, uniform_sphere, |_| uniform_sphere_pdf().value())),
    ];
    let level = sidak(results.len());
    assert!(results.iter().all(|(_, p)| *p > level), "p-values below {level:e}: {results:?}");
}

#[test]
fn inverses_undo_warps() {
    // sines and cosines of angles below 2π, square roots and quotients: ten roundings of numbers up to 2π
    const ERROR: f32 = 64.0 * f32::EPSILON;
    let mut random = Random::new(36);
    for _ in 0..samples(20_000) {
        let u: [f32; 2] = random.cube();
        let disk = concentric_disk(u);
        assert!(concentric_disk(concentric_disk_inverse(disk)).distance(disk) < ERROR, "disk {u:?}");
        let b = uniform_triangle(u);
        let again = uniform_triangle(uniform_triangle_inverse(b));
        assert!((b[0] - again[0]).abs().max((b[1] - again[1]).abs()) < ERROR, "triangle {u:?}");
        assert!(b[0] >= 0.0 && b[1] >= 0.0 && b[0] + b[1] <= 1.0, "triangle {u:?}");
        type Warp = fn([f32; 2]) -> Vec3;
        type Inverse = fn(Vec3) -> [f32; 2];
        let spheres: [(Warp, Inverse); 3] = [
            (cosine_hemisphere, cosine_hemisphere_inverse),
            (uniform_hemisphere, uniform_hemisphere_inverse),
            (uniform_sphere, uniform_sphere_inverse),
        ];
        for (i, (warp, inverse)) in spheres.into_iter().enumerate() {
            let w = warp(u);
            assert!((w.length() - 1.0).abs() < ERROR, "length of {i} {u:?}");
            let back = warp(inverse(w));
            // a height above the horizon or next to the pole has the root of its number's rounding
            let slack =
                ERROR + (1.0 - w.truncate().length_squared()).abs().max(f32::EPSILON).sqrt().recip().min(1e4) * ERROR;
            assert!(
                back.distance(w)
                    < slack + 2.0 * f32::EPSILON.sqrt() * f32::from(u8::from(w.truncate().length() < 1e-3)),
                "{i} {u:?}: {w} {back}"
            );
        }
    }
}
