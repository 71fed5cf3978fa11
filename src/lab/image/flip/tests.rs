//! Comparison with the authors' tool, flip-evaluator 1.7; `tests/support/flip_golden.py` prints its results and
//! explains the images.

use super::*;

/// Tolerance of means; the tool sums in f32 and stores its constants in f32.
const AGREEMENT: f64 = 1e-5;
/// Tolerance of single pixels: powers of small differences amplify rounding errors.
const PIXEL_AGREEMENT: f32 = 1e-4;

/// Reference and test image of the script.
fn pair([width, height]: [usize; 2]) -> [Vec<f32>; 2] {
    let pixels = (0..height).flat_map(|y| (0..width).map(move |x| [x, y]));
    let values = pixels.flat_map(|[x, y]| [0, 1, 2].map(|c| [x, y, c]));
    let reference = |[x, y, c]: [usize; 3]| ((x * (c + 1) + y * 3) % 32) as f32 / 32.0;
    let test = |[x, y, c]: [usize; 3]| {
        let block = if (x / 8 + y / 6) % 3 == c { 0.25 } else { 0.0 };
        let dot = if (x * 5 + y * 7) % 11 == 0 { 0.125 } else { 0.0 };
        (reference([x, y, c]) + block - dot).clamp(0.0, 1.0)
    };
    [values.clone().map(reference).collect(), values.map(test).collect()]
}

/// The same over 12 stops.
fn high(image: &[f32], [width, _]: [usize; 2]) -> Vec<f32> {
    let gain = |i: usize| ((((i % width) / 4 + (i / width) / 5) % 12) as f32 - 6.0).exp2();
    image.iter().enumerate().map(|(i, v)| v * gain(i / 3)).collect()
}

fn middle(flip: &Flip, [width, height]: [usize; 2]) -> f32 {
    flip.map[height / 2 * width + width / 2]
}

#[test]
fn ldr_agrees_with_the_tool() {
    for (size, ppd, mean, at) in [
        ([48, 32], PIXELS_PER_DEGREE, 0.413_061_9, 0.275_566_2),
        ([48, 32], 20.0, 0.495_598_7, 0.342_704_6),
        ([7, 45], PIXELS_PER_DEGREE, 0.459_630_4, 0.466_9),
        ([7, 45], 20.0, 0.510_460_7, 0.479_792_1),
        ([3, 2], PIXELS_PER_DEGREE, 0.524_014_0, 0.516_686_1),
        ([3, 2], 20.0, 0.543_955_9, 0.504_482_9),
        ([160, 90], PIXELS_PER_DEGREE, 0.407_085_0, 0.298_457_9),
        ([160, 90], 20.0, 0.495_156_1, 0.537_699_3),
    ] {
        let [reference, test] = pair(size);
        let flip = ldr(&test, &reference, size, ppd);
        assert!((flip.mean - mean).abs() < AGREEMENT, "{size:?} {ppd}: {} {mean}", flip.mean);
        assert!((middle(&flip, size) - at).abs() < PIXEL_AGREEMENT, "{size:?} {ppd}: {} {at}", middle(&flip, size));
    }
}

#[test]
fn hdr_agrees_with_the_tool() {
    for (size, ppd, mean, at, exposures, steps) in [
        ([48, 32], PIXELS_PER_DEGREE, 0.310_520_1, 0.208_984_4, [-3.781_65, 2.771_18], 7),
        ([48, 32], 20.0, 0.391_990_6, 0.212_295_9, [-3.781_65, 2.771_18], 7),
        ([7, 45], PIXELS_PER_DEGREE, 0.363_591_5, 0.444_057_8, [-0.838_67, 4.030_53], 5),
        ([7, 45], 20.0, 0.424_327_1, 0.549_380_7, [-0.838_67, 4.030_53], 5),
        ([3, 2], PIXELS_PER_DEGREE, 0.583_376_0, 0.520_465_8, [9.335_01, 10.188_3], 2),
        ([3, 2], 20.0, 0.582_077_4, 0.399_92, [9.335_01, 10.188_3], 2),
        ([160, 90], PIXELS_PER_DEGREE, 0.312_864_0, 0.196_608_4, [-3.830_33, 2.891_04], 7),
        ([160, 90], 20.0, 0.396_177_0, 0.687_152_6, [-3.830_33, 2.891_04], 7),
    ] {
        let [reference, test] = pair(size).map(|image| high(&image, size));
        let result = hdr(&test, &reference, size, ppd);
        let flip = &result.flip;
        assert!((flip.mean - mean).abs() < AGREEMENT, "{size:?} {ppd}: {} {mean}", flip.mean);
        assert!((middle(flip, size) - at).abs() < PIXEL_AGREEMENT, "{size:?} {ppd}: {} {at}", middle(flip, size));
        assert!(
            result.exposures.iter().zip(exposures).all(|(a, b): (&f32, f32)| (a - b).abs() < 2e-5),
            "{:?}",
            result.exposures
        );
        assert_eq!(result.steps, steps);
    }
}

#[test]
fn default_pixels_per_degree_matches_the_tool() {
    assert!((PIXELS_PER_DEGREE - 67.0206).abs() < 5e-5);
}

#[test]
fn equal_images_look_alike_and_opposite_ones_do_not() {
    let size = [20, 10];
    let [reference, _] = pair(size);
    assert_eq!(ldr(&reference, &reference, size, PIXELS_PER_DEGREE).mean, 0.0);
    assert_eq!(hdr(&reference, &reference, size, PIXELS_PER_DEGREE).flip.mean, 0.0);
    let [green, blue] = [1, 2].map(|c| (0..600).map(|i| if i % 3 == c { 1.0 } else { 0.0 }).collect::<Vec<f32>>());
    // The colour difference is the largest there is: 1, to rounding.
    assert!((ldr(&green, &blue, size, PIXELS_PER_DEGREE).mean - 1.0).abs() < 1e-5);
}

/// Values that are not finite, negative or huge, and black images, give differences from 0 to 1.
#[test]
fn flip_of_extreme_values_is_between_0_and_1() {
    let size = [4, 2];
    let strange = [f32::NAN, f32::INFINITY, f32::NEG_INFINITY, -1.0, 1e30, f32::MIN_POSITIVE, 0.5, f32::MAX];
    let image: Vec<f32> = strange.iter().cycle().take(24).copied().collect();
    let black = vec![0.0; 24];
    let mut sparse = black.clone();
    sparse[4] = 2.0;
    for (a, b) in
        [(&image, &black), (&black, &image), (&image, &image), (&black, &black), (&image, &sparse), (&black, &sparse)]
    {
        for flip in [ldr(a, b, size, 30.0), hdr(a, b, size, 30.0).flip] {
            assert!(flip.map.iter().all(|v| (0.0..=1.0).contains(v)), "{flip:?}");
        }
    }
    assert_eq!(hdr(&black, &black, size, 30.0).exposures, [0.0; 2]);
    // The median of the non-black pixels: one pixel.
    assert_eq!(hdr(&black, &sparse, size, 30.0).steps, 2);
}
