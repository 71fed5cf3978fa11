//! Filters of ꟻLIP, all separable: Gaussian contrast sensitivity functions for each opponent channel, and derivatives
//! of Gaussians for edge and point detection. Border pixels are replicated outwards.

use rayon::prelude::*;
use std::f64::consts::PI;

/// One channel of an image.
pub(super) struct Plane {
    size: [usize; 2],
    values: Vec<f32>,
}

impl Plane {
    pub(super) fn new(size: [usize; 2], values: Vec<f32>) -> Self {
        Plane { size, values }
    }

    /// Filters along both axes.
    fn filtered(&self, across: &Kernel, down: &Kernel) -> Plane {
        self.across(across).down(down)
    }

    /// Filters along rows.
    fn across(&self, kernel: &Kernel) -> Plane {
        let (width, radius) = (self.size[0], kernel.radius());
        let mut values = vec![0.0; self.values.len()];
        let rows = values.par_chunks_exact_mut(width).zip(self.values.par_chunks_exact(width));
        rows.for_each_init(
            || vec![0.0; width + 2 * radius],
            |padded, (out, row)| {
                padded[..radius].fill(row[0]);
                padded[radius..radius + width].copy_from_slice(row);
                padded[radius + width..].fill(row[width - 1]);
                for (tap, weight) in kernel.0.iter().enumerate() {
                    add(out, *weight, &padded[tap..tap + width]);
                }
            },
        );
        Plane { size: self.size, values }
    }

    /// Filters along columns.
    fn down(&self, kernel: &Kernel) -> Plane {
        let [width, height] = self.size;
        let radius = kernel.radius();
        let mut values = vec![0.0; self.values.len()];
        values.par_chunks_exact_mut(width).enumerate().for_each(|(y, out)| {
            for (tap, weight) in kernel.0.iter().enumerate() {
                let row = (y + tap).saturating_sub(radius).min(height - 1);
                add(out, *weight, &self.values[row * width..(row + 1) * width]);
            }
        });
        Plane { size: self.size, values }
    }
}

fn add(out: &mut [f32], weight: f32, row: &[f32]) {
    out.iter_mut().zip(row).for_each(|(sum, v)| *sum += weight * v);
}

/// Weights at −radius ..= radius, applied by correlation.
pub(super) struct Kernel(Vec<f32>);

impl Kernel {
    /// Tabulates `weight` at every offset, scaled so that the positive weights sum to 1 and the negative ones to −1.
    fn new(radius: usize, weight: impl Fn(f64) -> f64) -> Self {
        let weights: Vec<f64> = (0..=2 * radius).map(|tap| weight(tap as f64 - radius as f64)).collect();
        let positive: f64 = weights.iter().filter(|w| **w > 0.0).sum();
        let negative: f64 = -weights.iter().filter(|w| **w < 0.0).sum::<f64>();
        Kernel(
            weights
                .iter()
                .map(|&w| if w > 0.0 { w / positive } else { w / negative.max(f64::MIN_POSITIVE) } as f32)
                .collect(),
        )
    }

    fn radius(&self) -> usize {
        self.0.len() / 2
    }
}

/// Gaussian of the contrast sensitivity fit with amplitude a and width b: a √(π/b) exp(−π² x²/b), x in degrees
/// [Andersson20 §4.1].
#[derive(Clone, Copy)]
struct Sensitivity {
    a: f64,
    b: f64,
}

const LUMINANCE: Sensitivity = Sensitivity { a: 1.0, b: 0.0047 };
const RED_GREEN: Sensitivity = Sensitivity { a: 1.0, b: 0.0053 };
const BLUE_YELLOW: [Sensitivity; 2] = [Sensitivity { a: 34.1, b: 0.04 }, Sensitivity { a: 13.5, b: 0.025 }];

/// Contrast sensitivity filter of each channel.
pub(super) struct Spatial {
    luminance: Kernel,
    red_green: Kernel,
    /// A sum of two Gaussians, which is not separable: two filters with their weights.
    blue_yellow: [(Kernel, f32); 2],
}

impl Spatial {
    pub(super) fn new(pixels_per_degree: f32) -> Self {
        let density = f64::from(pixels_per_degree);
        // Three standard deviations of the widest Gaussian, for all channels.
        let radius = (3.0 * (BLUE_YELLOW[0].b / (2.0 * PI * PI)).sqrt() * density).ceil() as usize;
        let value = |s: Sensitivity, x: f64| (-PI * PI * (x / density).powi(2) / s.b).exp();
        let kernel = |s: Sensitivity| Kernel::new(radius, |x| value(s, x));
        let volume = |s: Sensitivity| {
            let line: f64 = (0..=2 * radius).map(|tap| value(s, tap as f64 - radius as f64)).sum();
            s.a * (PI / s.b).sqrt() * line * line
        };
        let volumes = BLUE_YELLOW.map(volume);
        let share = |i: usize| (volumes[i] / (volumes[0] + volumes[1])) as f32;
        Spatial {
            luminance: kernel(LUMINANCE),
            red_green: kernel(RED_GREEN),
            blue_yellow: [0, 1].map(|i| (kernel(BLUE_YELLOW[i]), share(i))),
        }
    }

    /// Returns the filtered colour of each pixel.
    pub(super) fn apply(&self, [y, cx, cz]: &[Plane; 3]) -> impl ParallelIterator<Item = [f32; 3]> + use<> {
        let y = y.filtered(&self.luminance, &self.luminance).values;
        let cx = cx.filtered(&self.red_green, &self.red_green).values;
        let [(wide, wide_share), (narrow, narrow_share)] = &self.blue_yellow;
        let (wide_share, narrow_share) = (*wide_share, *narrow_share);
        let cz = cz.filtered(wide, wide).values.into_par_iter().zip(cz.filtered(narrow, narrow).values);
        let cz = cz.map(move |(wide, narrow)| wide_share * wide + narrow_share * narrow);
        y.into_par_iter().zip(cx).zip(cz).map(|((y, cx), cz)| [y, cx, cz])
    }
}

/// Width of the detected features, in degrees [Andersson20 §4.2].
const FEATURE_WIDTH: f64 = 0.082;

/// Detectors of edges and points.
pub(super) struct Feature {
    gaussian: Kernel,
    first: Kernel,
    second: Kernel,
}

impl Feature {
    pub(super) fn new(pixels_per_degree: f32) -> Self {
        let deviation = 0.5 * FEATURE_WIDTH * f64::from(pixels_per_degree);
        let radius = (3.0 * deviation).ceil() as usize;
        let gaussian = |x: f64| (-x * x / (2.0 * deviation * deviation)).exp();
        Feature {
            gaussian: Kernel::new(radius, gaussian),
            first: Kernel::new(radius, |x| -x * gaussian(x)),
            second: Kernel::new(radius, |x| (x * x / (deviation * deviation) - 1.0) * gaussian(x)),
        }
    }

    /// Returns the magnitudes of the first and second derivative at each pixel of a luminance plane.
    pub(super) fn apply(&self, luminance: &Plane) -> Vec<[f32; 2]> {
        let values = luminance.values.iter().map(|y| (y + 16.0) / 116.0).collect();
        let plane = Plane::new(luminance.size, values);
        let across = |kernel| plane.filtered(kernel, &self.gaussian).values;
        let down = |kernel| plane.filtered(&self.gaussian, kernel).values;
        let size =
            |kernel| -> Vec<f32> { across(kernel).into_iter().zip(down(kernel)).map(|(x, y)| x.hypot(y)).collect() };
        size(&self.first).into_iter().zip(size(&self.second)).map(|(edge, point)| [edge, point]).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn ramp(size: [usize; 2], value: impl Fn(usize, usize) -> f32) -> Plane {
        let values = (0..size[0] * size[1]).map(|i| value(i % size[0], i / size[0])).collect();
        Plane::new(size, values)
    }

    /// Sums of some 20 products in f32: 20 × 2⁻²⁴ of the largest value.
    const ROUNDING: f32 = 2e-6;

    #[test]
    fn blur_keeps_constants_and_derivatives_remove_them() {
        let plane = ramp([5, 3], |_, _| 0.5);
        let eye = Spatial::new(67.0);
        let planes = [ramp([5, 3], |_, _| 0.5), ramp([5, 3], |_, _| 0.5), ramp([5, 3], |_, _| 0.5)];
        let blurred: Vec<_> = eye.apply(&planes).collect();
        assert!(blurred.iter().flatten().all(|v| (v - 0.5).abs() < ROUNDING), "{blurred:?}");
        let features = Feature::new(67.0).apply(&plane);
        assert!(features.iter().flatten().all(|v| v.abs() < ROUNDING), "{features:?}");
    }

    /// A filter of three weights at a corner: what lies outside is the border's value.
    #[test]
    fn filters_extend_border_pixels() {
        let plane = ramp([3, 2], |x, y| (x + 10 * y) as f32);
        let kernel = Kernel(vec![1.0, 2.0, 4.0]);
        assert_eq!(plane.across(&kernel).values, [4.0, 10.0, 13.0, 74.0, 80.0, 83.0]);
        assert_eq!(plane.down(&kernel).values, [40.0, 47.0, 54.0, 60.0, 67.0, 74.0]);
    }

    /// Away from borders both derivatives' directions and the ramp's are alike, and a ramp has no second derivative.
    #[test]
    fn a_ramp_is_an_edge_in_both_directions() {
        let size = [41, 41];
        let feature = Feature::new(67.0);
        // The detector sees (Y + 16)/116.
        let across = feature.apply(&ramp(size, |x, _| 116.0 * 0.01 * x as f32 - 16.0));
        let down = feature.apply(&ramp(size, |_, y| 116.0 * 0.01 * y as f32 - 16.0));
        let middle = 20 * 41 + 20;
        assert!((across[middle][0] - down[middle][0]).abs() < ROUNDING && across[middle][0] > 0.01);
        assert!(across[middle][1] < ROUNDING && down[middle][1] < ROUNDING);
    }
}
