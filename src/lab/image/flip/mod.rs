//! ꟻLIP: the perceived difference of two images when alternated on a screen, per pixel from 0 to 1 [Andersson20]. Its
//! HDR extension is the largest such difference over a range of exposures [Andersson21]. Written from the papers and
//! validated against the authors' tool (tests below; `tests/support/flip_golden.py` generates the expected values).
//!
//! It measures the visibility of errors. It is not an estimator's error: it does not decrease as 1/n, and it ignores
//! invisible errors. Images are linear Rec. 709, `RGBRGB…`, row by row. Negative values and NaN count as black.

mod color;
mod filter;

use color::{Lab, YCxCz};
use filter::Plane;
use rayon::prelude::*;

/// Standard viewing condition: 0.7 m from a screen 0.7 m and 3840 pixels wide, 67.02 pixels per degree [Andersson20].
pub const PIXELS_PER_DEGREE: f32 = 3840.0 * std::f32::consts::PI / 180.0;

/// Exponents and ranges of the two differences [Andersson20 §4].
const COLOR_EXPONENT: f32 = 0.7;
const COLOR_KNEE: f32 = 0.4;
const BELOW_KNEE: f32 = 0.95;
const FEATURE_EXPONENT: f32 = 0.5;
/// Display value of the brightest and of the median pixel at the exposure limits [Andersson21].
const EXPOSED: f64 = 0.85;

/// A map of perceived differences.
#[derive(Debug, Clone, PartialEq)]
pub struct Flip {
    /// The difference at each pixel, 0 to 1, row by row.
    pub map: Vec<f32>,
    /// Mean of the map.
    pub mean: f64,
}

/// A map of the largest perceived differences over exposures.
#[derive(Debug, Clone, PartialEq)]
pub struct HdrFlip {
    /// The differences.
    pub flip: Flip,
    /// The lowest and highest exposure in stops, from the reference's brightest and median luminance.
    pub exposures: [f32; 2],
    /// Number of exposures, evenly spaced.
    pub steps: u32,
}

/// Computes the difference of images as displayed; values above 1 are clipped.
///
/// # Panics
/// Unless both images have 3 × width × height values and `pixels_per_degree` is positive.
pub fn ldr(image: &[f32], reference: &[f32], size: [usize; 2], pixels_per_degree: f32) -> Flip {
    let observer = Observer::new(image, reference, size, pixels_per_degree);
    let clip = |v: f32| v.clamp(0.0, 1.0);
    Flip::of(observer.differences(image, reference, clip))
}

/// Computes the largest difference over exposures. Tone mapping is Narkowicz's fit of ACES without its pre-exposure
/// [Narkowicz15]. The exposures range from the brightest reference pixel displayed at 0.85 to the median pixel at 0.85
/// (the median of non-black pixels, if more than half of the image is black). Steps are at most two stops, usually one
/// [Andersson21].
///
/// # Panics
/// As [`ldr`].
pub fn hdr(image: &[f32], reference: &[f32], size: [usize; 2], pixels_per_degree: f32) -> HdrFlip {
    let observer = Observer::new(image, reference, size, pixels_per_degree);
    let [start, stop] = exposures(reference);
    let steps = (stop - start).ceil().max(2.0) as u32;
    let stride = (stop - start) / (steps - 1) as f32;
    let mut map = vec![0.0; size[0] * size[1]];
    for step in 0..steps {
        let gain = (start + step as f32 * stride).exp2();
        let at_exposure = observer.differences(image, reference, |v| tone(v, gain));
        map.par_iter_mut().zip(at_exposure).for_each(|(most, seen)| *most = seen.max(*most));
    }
    HdrFlip { flip: Flip::of(map), exposures: [start, stop], steps }
}

impl Flip {
    fn of(map: Vec<f32>) -> Flip {
        let mean = map.iter().copied().map(f64::from).sum::<f64>() / map.len() as f64;
        Flip { map, mean }
    }
}

/// Coefficients of the tone mapping curve (a x² + b x) / (c x² + d x + e), with the factor 0.6 of its input multiplied
/// in.
const TONE: [f64; 5] = [0.36 * 2.51, 0.6 * 0.03, 0.36 * 2.43, 0.6 * 0.59, 0.14];

/// The display value, 0 to 1, of a linear value.
fn tone(value: f32, gain: f32) -> f32 {
    let [a, b, c, d, e] = TONE.map(|c| c as f32);
    // Beyond 1e6 the curve is clipped at 1, and its squares would overflow. The minimum also replaces NaN.
    let x = (value.max(0.0) * gain).min(1e6);
    ((x * (a * x + b)) / (x * (c * x + d) + e)).min(1.0)
}

/// Returns the exposures that map the brightest and the median reference pixel to [`EXPOSED`].
fn exposures(reference: &[f32]) -> [f32; 2] {
    let luminance = |c: &[f32]| 0.2126 * c[0].max(0.0) + 0.7152 * c[1].max(0.0) + 0.0722 * c[2].max(0.0);
    let mut luminances: Vec<f32> = reference.chunks_exact(3).map(luminance).filter(|l| l.is_finite()).collect();
    let mut middle = median(&mut luminances);
    if middle <= 0.0 {
        luminances.retain(|&l| l > 0.0);
        middle = median(&mut luminances);
    }
    let most = luminances.iter().copied().fold(0.0, f32::max);
    if most <= 0.0 {
        return [0.0; 2];
    }
    let [a, b, c, d, e] = TONE;
    let [square, linear] = [a - EXPOSED * c, b - EXPOSED * d];
    let half = -0.5 * linear / square;
    let exposed = half + (half * half + EXPOSED * e / square).sqrt();
    [most, middle].map(|l| (exposed / f64::from(l)).log2() as f32)
}

/// Returns the upper median; 0 for no values.
fn median(values: &mut [f32]) -> f32 {
    if values.is_empty() {
        return 0.0;
    }
    let middle = values.len() / 2;
    *values.select_nth_unstable_by(middle, f32::total_cmp).1
}

/// Filters at a viewing distance, for images of one size.
struct Observer {
    size: [usize; 2],
    spatial: filter::Spatial,
    feature: filter::Feature,
}

impl Observer {
    fn new(image: &[f32], reference: &[f32], size: [usize; 2], pixels_per_degree: f32) -> Self {
        let values = 3 * size[0] * size[1];
        assert!(
            image.len() == values && reference.len() == values,
            "{} and {} values of {size:?}",
            image.len(),
            reference.len()
        );
        assert!(pixels_per_degree > 0.0, "{pixels_per_degree} pixels per degree");
        Observer {
            size,
            spatial: filter::Spatial::new(pixels_per_degree),
            feature: filter::Feature::new(pixels_per_degree),
        }
    }

    /// Returns the map of differences between the images after `display` [Andersson20 §4.3]: the colour difference,
    /// amplified by the feature difference.
    fn differences(&self, image: &[f32], reference: &[f32], display: impl Fn(f32) -> f32 + Sync) -> Vec<f32> {
        let (a, b) = (self.see(image, &display), self.see(reference, &display));
        let largest = color::largest_difference().powf(COLOR_EXPONENT);
        let pixels = a.colors.into_par_iter().zip(b.colors).zip(a.features.into_par_iter().zip(b.features));
        let difference = |((a, b), (fa, fb)): ((Lab, Lab), ([f32; 2], [f32; 2]))| {
            let color = compress(a.difference(b).powf(COLOR_EXPONENT), largest);
            let feature = (fa[0] - fb[0]).abs().max((fa[1] - fb[1]).abs());
            color.powf(1.0 - (feature * std::f32::consts::FRAC_1_SQRT_2).powf(FEATURE_EXPONENT))
        };
        pixels.map(difference).collect()
    }

    fn see(&self, image: &[f32], display: &(impl Fn(f32) -> f32 + Sync)) -> Seen {
        let opponent = |c: &[f32]| YCxCz::of([c[0], c[1], c[2]].map(|v| if v.is_nan() { 0.0 } else { display(v) })).0;
        let pixels: Vec<[f32; 3]> = image.par_chunks_exact(3).map(opponent).collect();
        let plane = |channel: usize| Plane::new(self.size, pixels.iter().map(|p| p[channel]).collect());
        let planes = [plane(0), plane(1), plane(2)];
        let colors = self.spatial.apply(&planes).map(|c| Lab::of(YCxCz(c))).collect();
        Seen { colors, features: self.feature.apply(&planes[0]) }
    }
}

/// Filtered image: the colour of each pixel, and its edge and point responses.
struct Seen {
    colors: Vec<Lab>,
    features: Vec<[f32; 2]>,
}

/// Maps colour differences to 0 to 1, with large ones compressed into the last part [Andersson20 §4.1].
fn compress(difference: f32, largest: f32) -> f32 {
    let knee = COLOR_KNEE * largest;
    if difference < knee {
        BELOW_KNEE / knee * difference
    } else {
        BELOW_KNEE + (difference - knee) / (largest - knee) * (1.0 - BELOW_KNEE)
    }
}

#[cfg(test)]
mod tests;
