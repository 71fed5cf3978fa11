//! Colour primaries of a picture, and the conversion to linear Rec. 709 with its D65 white.
//!
//! There is no chromatic adaptation. Radiance of one spectrum has one tristimulus value, in whichever primaries a file
//! stores it. A colour that is neutral relative to a white of 6000 K is therefore slightly red relative to D65.

use glam::{DMat3, DVec3};

/// CIE x, y chromaticities of red, green, blue and white.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Primaries(pub [f64; 8]);

/// Rounding of chromaticities with four decimals.
const HALF_A_DIGIT: f64 = 0.5e-4;

impl Primaries {
    /// Primaries of Rec. 709 and sRGB.
    pub const REC_709: Primaries = Primaries([0.64, 0.33, 0.30, 0.60, 0.15, 0.06, 0.3127, 0.3290]);

    /// Returns the matrix from these primaries to linear Rec. 709: exactly the identity if they are the same. `None` if
    /// the primaries are degenerate: a white luminance of 0 or less, or three collinear primaries.
    pub fn to_rec_709(self) -> Option<DMat3> {
        if self.0.iter().zip(Self::REC_709.0).all(|(a, b)| (a - b).abs() <= HALF_A_DIGIT) {
            return Some(DMat3::IDENTITY);
        }
        Some(xyz_to_rec_709() * self.to_xyz()?)
    }

    /// Returns the matrix from these primaries to XYZ; white has luminance 1.
    fn to_xyz(self) -> Option<DMat3> {
        let at = |i: usize| DVec3::new(self.0[i], self.0[i + 1], 1.0 - self.0[i] - self.0[i + 1]);
        let primaries = DMat3::from_cols(at(0), at(2), at(4));
        let shares = primaries.inverse() * (at(6) / self.0[7]);
        let matrix = primaries * DMat3::from_diagonal(shares);
        (self.0[7] > 0.0 && matrix.is_finite() && matrix.determinant() != 0.0).then_some(matrix)
    }
}

/// Returns the matrix from XYZ to linear Rec. 709.
pub fn xyz_to_rec_709() -> DMat3 {
    Primaries::REC_709.to_xyz().map_or(DMat3::IDENTITY, |m| m.inverse())
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Matrix from Rec. 709 to XYZ as printed in IEC 61966-2-1, with four decimals.
    #[test]
    fn white_and_primaries_are_those_of_the_standard() {
        let matrix = Primaries::REC_709.to_xyz().unwrap();
        let printed = [[0.4124, 0.2126, 0.0193], [0.3576, 0.7152, 0.1192], [0.1805, 0.0722, 0.9505]];
        for (column, printed) in [matrix.x_axis, matrix.y_axis, matrix.z_axis].into_iter().zip(printed) {
            assert!((column - DVec3::from(printed)).abs().max_element() <= HALF_A_DIGIT, "{column} {printed:?}");
        }
    }

    #[test]
    fn degenerate_primaries_are_refused() {
        let with = |change: fn(&mut [f64; 8])| {
            let mut numbers = Primaries::REC_709.0;
            change(&mut numbers);
            Primaries(numbers).to_rec_709()
        };
        assert_eq!(with(|_| ()), Some(DMat3::IDENTITY));
        assert_eq!(with(|n| n[7] = 0.0), None);
        assert_eq!(with(|n| (n[0], n[1]) = (n[2], n[3])), None);
        assert_eq!(with(|n| n[4] = f64::NAN), None);
    }
}
