//! Quantisation units of the film's integer sums: powers of two, fixed before the first pass.

use super::Plane;

/// Unit of albedo, alpha and normal: the spacing of f32 just below 1.
const UNIT_INTERVAL: f64 = 1.0 / 16_777_216.0;

/// Quantisation steps of radiance and of length. Colour uses `radiance`; depth and position use `length`. Alpha, albedo
/// and normal use 2⁻²⁴, and counts use 1.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize, serde::Deserialize)]
#[serde(try_from = "[i32; 2]", into = "[i32; 2]")]
pub struct Units {
    /// Unit of colour; a power of two.
    pub radiance: f64,
    /// Unit of depth and position, in scene units; a power of two.
    pub length: f64,
}

impl Units {
    /// Largest magnitude of the binary exponents.
    pub const MAX_EXPONENT: i32 = 256;

    /// Returns the units 2^`radiance` and 2^`length`, or `None` beyond [`Units::MAX_EXPONENT`].
    pub fn from_exponents(radiance: i32, length: i32) -> Option<Self> {
        let is_allowed = |e: i32| e.unsigned_abs() <= Self::MAX_EXPONENT.unsigned_abs();
        let unit = |e: i32| f64::from_bits(((1023 + i64::from(e)) as u64) << 52);
        (is_allowed(radiance) && is_allowed(length)).then(|| Units { radiance: unit(radiance), length: unit(length) })
    }

    /// Returns the exponents [radiance, length], or `None` if a unit is not a power of two within
    /// [`Units::MAX_EXPONENT`].
    pub fn exponents(&self) -> Option<[i32; 2]> {
        let exponent = |unit: f64| ((unit.to_bits() >> 52) as i64 - 1023) as i32;
        let found = [exponent(self.radiance), exponent(self.length)];
        (Self::from_exponents(found[0], found[1]).as_ref() == Some(self)).then_some(found)
    }

    /// Returns units of 2⁻²⁴ times a typical radiance and a typical length, both rounded down to powers of two.
    /// Rounding adds a standard deviation of at most 3e-8 of the typical value to each sample. An i64 holds the sum of
    /// 2³⁸ typical samples. Without a usable typical value the unit is 2⁻²⁴.
    pub fn for_typical(radiance: f64, length: f64) -> Self {
        let exponent =
            |x: f64| if x.is_normal() && x > 0.0 { (x.log2().floor() as i32).clamp(-200, 200) - 24 } else { -24 };
        Units::from_exponents(exponent(radiance), exponent(length))
            .unwrap_or(Units { radiance: UNIT_INTERVAL, length: UNIT_INTERVAL })
    }

    /// Returns the unit of a plane's channels.
    pub fn of(&self, plane: Plane) -> f64 {
        match plane {
            Plane::Color => self.radiance,
            Plane::Depth | Plane::Position => self.length,
            Plane::Alpha | Plane::Albedo | Plane::Normal => UNIT_INTERVAL,
            Plane::Invalid => 1.0,
        }
    }
}

/// Serialised as exponents, since JSON may round a float.
impl From<Units> for [i32; 2] {
    fn from(units: Units) -> Self {
        units.exponents().unwrap_or_default()
    }
}

impl TryFrom<[i32; 2]> for Units {
    type Error = String;

    fn try_from([radiance, length]: [i32; 2]) -> Result<Self, String> {
        Units::from_exponents(radiance, length)
            .ok_or_else(|| format!("units of 2^{radiance} and 2^{length} are out of range"))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn exponents_round_trip_and_refuse_other_numbers() {
        for e in [-256, -24, 0, 17, 256] {
            let units = Units::from_exponents(e, -e).unwrap();
            assert_eq!(units.exponents(), Some([e, -e]));
            assert!((units.radiance.log2() - f64::from(e)).abs() < f64::EPSILON);
        }
        assert_eq!(Units::from_exponents(257, 0), None);
        assert_eq!(Units::from_exponents(0, i32::MIN), None);
        for bad in [0.0, -1.0, 3.0, f64::NAN, f64::INFINITY] {
            assert_eq!(Units { radiance: bad, length: 1.0 }.exponents(), None, "{bad}");
        }
    }

    #[test]
    fn typical_values_set_the_scale() {
        let units = Units::for_typical(5.0, 1e-3);
        assert_eq!(units.exponents(), Some([2 - 24, -10 - 24]));
        assert_eq!(Units::for_typical(0.0, f64::NAN).exponents(), Some([-24, -24]));
    }
}
