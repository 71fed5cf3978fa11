//! Colour spaces of ꟻLIP: opponent colours for the contrast sensitivity filters, and CIELAB for colour differences.

/// Linear Rec. 709 to CIE XYZ with a white point of D65: chromaticities as in BT.709, to the precision of the authors'
/// tool.
const TO_XYZ: [[f32; 3]; 3] = [
    [0.412_386_56, 0.357_591_48, 0.180_450_49],
    [0.212_636_82, 0.715_182_96, 0.072_180_2],
    [0.019_330_62, 0.119_197_16, 0.950_372_6],
];
/// Its inverse.
const FROM_XYZ: [[f32; 3]; 3] = [
    [3.241_003_3, -1.537_399, -0.498_615_86],
    [-0.969_224_33, 1.875_930_1, 0.041_554_224],
    [0.055_639_423, -0.204_011_2, 1.057_148_9],
];
/// XYZ of white: the sums of the rows.
const WHITE: [f32; 3] = [0.950_428_55, 1.0, 1.088_900_4];

/// Luminance, red against green and blue against yellow, linear in XYZ [Andersson20 §4.1].
#[derive(Debug, Clone, Copy)]
pub(super) struct YCxCz(pub(super) [f32; 3]);

impl YCxCz {
    pub(super) fn of(rgb: [f32; 3]) -> Self {
        let [x, y, z] = relative_xyz(rgb);
        YCxCz([116.0 * y - 16.0, 500.0 * (x - y), 200.0 * (y - z)])
    }

    /// Returns the displayable colour: linear RGB, clipped to the gamut.
    fn displayed(self) -> [f32; 3] {
        let YCxCz([y, cx, cz]) = self;
        let y = (y + 16.0) / 116.0;
        let xyz = [(y + cx / 500.0) * WHITE[0], y * WHITE[1], (y - cz / 200.0) * WHITE[2]];
        apply(&FROM_XYZ, xyz).map(|v| v.clamp(0.0, 1.0))
    }
}

/// CIELAB, its chroma scaled by lightness after Hunt's effect [Andersson20 §4.1].
#[derive(Debug, Clone, Copy)]
pub(super) struct Lab([f32; 3]);

impl Lab {
    /// Converts a colour as displayed.
    pub(super) fn of(color: YCxCz) -> Self {
        Lab::of_rgb(color.displayed())
    }

    fn of_rgb(rgb: [f32; 3]) -> Self {
        let [x, y, z] = relative_xyz(rgb).map(lightness);
        let l = 116.0 * y - 16.0;
        Lab([l, 0.01 * l * 500.0 * (x - y), 0.01 * l * 200.0 * (y - z)])
    }

    /// Returns the HyAB distance: the sum of the lightness and chroma distances [Andersson20 §4.1].
    pub(super) fn difference(self, other: Lab) -> f32 {
        let (Lab([l, a, b]), Lab([m, c, d])) = (self, other);
        (l - m).abs() + (a - c).hypot(b - d)
    }
}

/// Returns the largest displayable difference, that of green and blue [Andersson20 §4.1].
pub(super) fn largest_difference() -> f32 {
    Lab::of_rgb([0.0, 1.0, 0.0]).difference(Lab::of_rgb([0.0, 0.0, 1.0]))
}

/// The CIE lightness function: a cube root, linear near black.
fn lightness(t: f32) -> f32 {
    const DELTA: f32 = 6.0 / 29.0;
    if t > DELTA * DELTA * DELTA { t.cbrt() } else { t / (3.0 * DELTA * DELTA) + 4.0 / 29.0 }
}

fn relative_xyz(rgb: [f32; 3]) -> [f32; 3] {
    let xyz = apply(&TO_XYZ, rgb);
    [xyz[0] / WHITE[0], xyz[1] / WHITE[1], xyz[2] / WHITE[2]]
}

fn apply(matrix: &[[f32; 3]; 3], v: [f32; 3]) -> [f32; 3] {
    matrix.map(|row| row[0] * v[0] + row[1] * v[1] + row[2] * v[2])
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Six-digit constants and f32: 1e-5.
    #[test]
    fn the_matrices_are_inverse_and_white_is_white() {
        for column in 0..3 {
            let unit = [0, 1, 2].map(|i| if i == column { 1.0 } else { 0.0 });
            let back = apply(&FROM_XYZ, apply(&TO_XYZ, unit));
            assert!(back.iter().zip(unit).all(|(b, u)| (b - u).abs() < 1e-5), "{back:?}");
        }
        assert!(relative_xyz([1.0; 3]).iter().all(|v| (v - 1.0).abs() < 1e-5));
        let Lab([l, a, b]) = Lab::of_rgb([1.0; 3]);
        assert!((l - 100.0).abs() < 1e-3 && a.abs() < 1e-2 && b.abs() < 1e-2, "{l} {a} {b}");
    }

    /// CIELAB of sRGB's red, as tables print it: 53.24, 80.09, 67.20; here the chroma is scaled by L/100.
    #[test]
    fn cielab_of_red_matches_tables() {
        let Lab([l, a, b]) = Lab::of_rgb([1.0, 0.0, 0.0]);
        assert!(
            (l - 53.24).abs() < 0.01 && (a / (0.01 * l) - 80.09).abs() < 0.05 && (b / (0.01 * l) - 67.20).abs() < 0.05
        );
    }
}
