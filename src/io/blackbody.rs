//! Colours of black bodies.

use crate::spectrum::Spectrum;
use std::ops::RangeInclusive;

/// Temperatures with a colour, in kelvins: below there is hardly any visible light, above the colour stays the same.
pub(crate) const TEMPERATURES: RangeInclusive<f64> = 500.0..=1e6;

/// Second radiation constant, in nanometre kelvins.
const C2: f64 = 1.438_776_877e7;

/// Returns the colour of a black body at `kelvin` in linear Rec. 709, of luminance 1. Lanes outside the gamut are
/// black.
pub(crate) fn color(kelvin: f64) -> Spectrum {
    let [x, y, z] = tristimulus(kelvin);
    let (x, z) = (x / y, z / y);
    let rgb = [
        3.240_969_9 * x - 1.537_383_2 - 0.498_610_8 * z,
        -0.969_243_6 * x + 1.875_967_5 + 0.041_555_1 * z,
        0.055_630_1 * x - 0.203_977_0 + 1.056_971_5 * z,
    ];
    let rgb = rgb.map(|lane: f64| lane.max(0.0));
    let luminance = 0.212_639 * rgb[0] + 0.715_168_7 * rgb[1] + 0.072_192_3 * rgb[2];
    Spectrum(rgb.map(|lane| (lane / luminance) as f32))
}

/// Colours of black bodies up to a temperature, whose luminance there is 1.
pub(crate) struct Ramp {
    /// Colours at equal ratios of temperatures.
    colors: Vec<Spectrum>,
    /// Steps between two of them for each unit of the logarithm.
    steps: f64,
}

impl Ramp {
    /// Number of colours: their mean error is far below that of the fits of the observer.
    const COLORS: usize = 4096;

    /// Computes the colours up to `hottest` kelvins, or up to the least of [`TEMPERATURES`].
    pub(crate) fn up_to(hottest: f64) -> Ramp {
        let least = *TEMPERATURES.start();
        let range = (hottest / least).ln().max(f64::MIN_POSITIVE);
        // Y is relative to the radiance at 560 nm, by Planck's law.
        let log_luminance = |kelvin: f64| {
            let x = C2 / (560.0 * kelvin);
            tristimulus(kelvin)[1].ln() - x - (-(-x).exp()).ln_1p()
        };
        let last = Ramp::COLORS - 1;
        let hot = log_luminance(least * range.exp());
        let color = |k: usize| {
            let kelvin = least * (range * k as f64 / last as f64).exp();
            color(kelvin) * (log_luminance(kelvin) - hot).exp() as f32
        };
        Ramp { colors: (0..Ramp::COLORS).map(color).collect(), steps: last as f64 / range }
    }

    /// Returns the colour at `kelvin`; black below the least of [`TEMPERATURES`].
    pub(crate) fn at(&self, kelvin: f64) -> Spectrum {
        let place = (kelvin / TEMPERATURES.start()).ln() * self.steps;
        if place.is_nan() || place < 0.0 {
            return Spectrum::ZERO;
        }
        let low = (place as usize).min(self.colors.len() - 2);
        self.colors[low].lerp(self.colors[low + 1], (place - low as f64).min(1.0) as f32)
    }
}

/// Returns X, Y and Z up to a common factor: Planck's law times the fits of the CIE 1931 observer in [Wyman13].
fn tristimulus(kelvin: f64) -> [f64; 3] {
    let mut sums = [0.0; 3];
    for step in 0..=94 {
        let nm = 360.0 + 5.0 * f64::from(step);
        // Relative to 560 nm, so that cold bodies do not underflow.
        let relative = (C2 / (560.0 * kelvin)).exp_m1() / (C2 / (nm * kelvin)).exp_m1();
        let cold = (C2 / kelvin * (1.0 / 560.0 - 1.0 / nm)).exp();
        let radiance = (560.0 / nm).powi(5) * if relative.is_finite() { relative } else { cold };
        sums.iter_mut().zip(observer(nm)).for_each(|(sum, weight)| *sum += radiance * weight);
    }
    sums
}

/// Returns the colour matching functions at `nm` by the fit of several lobes.
fn observer(nm: f64) -> [f64; 3] {
    let lobe = |height: f64, centre: f64, below: f64, above: f64| {
        let t = (nm - centre) * if nm < centre { below } else { above };
        height * (-0.5 * t * t).exp()
    };
    [
        lobe(0.362, 442.0, 0.0624, 0.0374) + lobe(1.056, 599.8, 0.0264, 0.0323) + lobe(-0.065, 501.1, 0.0490, 0.0382),
        lobe(0.821, 568.8, 0.0213, 0.0247) + lobe(0.286, 530.9, 0.0613, 0.0322),
        lobe(1.217, 437.0, 0.0845, 0.0278) + lobe(0.681, 459.0, 0.0385, 0.0725),
    ]
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Chromaticities of the Planckian locus, from the CIE's tables. The fit of the observer is good to 1 % of its
    /// peaks, which is more of the deep red of cold bodies.
    #[test]
    fn chromaticities_are_those_of_the_locus() {
        let locus = [
            (1000.0, 0.6528, 0.3444, 0.012),
            (2856.0, 0.4476, 0.4074, 0.002),
            (6500.0, 0.3135, 0.3237, 0.002),
            (1e6, 0.240, 0.234, 0.002),
        ];
        for (kelvin, x, y, error) in locus {
            let [a, b, c] = tristimulus(kelvin);
            let (x, y) = (a / (a + b + c) - x, b / (a + b + c) - y);
            assert!(x.abs() < error && y.abs() < error, "{kelvin}: {x} {y}");
        }
    }

    /// Stefan and Boltzmann's law holds for all wavelengths; at 560 nm luminance grows by exp(c₂ / λ (1/T − 1/T'))
    /// where bodies are cold. The eye's mean wavelength is some per cent off, so the bound is loose, but not by the
    /// power of another temperature. At the top luminance is 1, and between two colours they are mixed.
    #[test]
    fn ramps_have_the_luminance_of_black_bodies() {
        let luminance = |Spectrum([r, g, b]): Spectrum| 0.212_639 * r + 0.715_168_7 * g + 0.072_192_3 * b;
        let ramp = Ramp::up_to(2000.0);
        assert!((luminance(ramp.at(2000.0)) - 1.0).abs() < 1e-5);
        assert!(ramp.at(499.0).is_black() && ramp.at(0.0).is_black() && ramp.at(f64::NAN).is_black());
        for kelvin in [800.0, 1000.0, 1500.0] {
            // Cold bodies are seen by their red light.
            let found = f64::from(luminance(ramp.at(kelvin))).ln() / (1.0 / 2000.0 - 1.0 / kelvin);
            let nanometres = C2 / found;
            assert!((570.0..625.0).contains(&nanometres), "{kelvin}: {nanometres}");
        }
        let single = Ramp::up_to(100.0);
        assert!(single.at(100.0).is_black());
    }

    #[test]
    fn colours_are_finite_and_of_luminance_1() {
        for kelvin in [500.0, 1e3, 2e3, 6504.0, 1e5, 1e6] {
            let Spectrum([r, g, b]) = color(kelvin);
            let luminance = 0.212_639 * r + 0.715_168_7 * g + 0.072_192_3 * b;
            assert!(
                (luminance - 1.0).abs() < 1e-5 && [r, g, b].iter().all(|lane| *lane >= 0.0),
                "{kelvin}: {r} {g} {b}"
            );
        }
        let Spectrum([r, g, b]) = color(6504.0);
        assert!((r - b).abs() < 0.1 && (g - 1.0).abs() < 0.05, "nearly white: {r} {g} {b}");
    }
}
