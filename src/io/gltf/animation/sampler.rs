//! Animation samplers: keys, each a time with its value. Only the keys around the wanted time are read.

use super::super::accessor::Wanted;
use super::super::document::Document;
use super::super::quaternion::unit_quaternion;
use super::curve::Piece;
use crate::error::{Error, Result};
use ::gltf::json::accessor::ComponentType;
use ::gltf::json::validation::Checked;
use glam::{DQuat, DVec3, DVec4};
use serde::Deserialize;
use std::collections::HashMap;

/// An animation curve as stored in the file.
#[derive(Deserialize)]
pub(super) struct Sampler {
    /// Accessor of the key times.
    pub(super) input: usize,
    /// Accessor of the key values.
    output: usize,
    #[serde(default)]
    interpolation: Interpolation,
}

#[derive(Clone, Copy, Default, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "UPPERCASE")]
enum Interpolation {
    #[default]
    Linear,
    Step,
    /// Each key has three values: the left tangent, the value, and the right tangent.
    CubicSpline,
}

/// Position of a time among the keys.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Moment {
    /// Number of keys.
    keys: usize,
    /// The last key at or before the time, else the first.
    key: usize,
    /// The interval to the next key; `None` before the first key and from the last one on.
    gap: Option<Gap>,
    /// Time of the last key in seconds.
    pub(super) end: f64,
}

/// The interval between two keys.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Gap {
    /// Relative time in the interval, 0 to 1.
    way: f64,
    /// Length of the interval in seconds.
    length: f64,
}

/// One time, located among the keys of all samplers. Samplers often share their key times.
pub(super) struct Moments {
    /// Rounded to f32 like the keys in files, so that a frame coincides with its own key and does not precede it.
    seconds: f32,
    known: HashMap<usize, Moment>,
}

impl Moments {
    /// Sets the time in seconds. NaN precedes all keys.
    pub(super) fn at(seconds: f64) -> Self {
        Moments { seconds: seconds as f32, known: HashMap::new() }
    }

    /// Locates the time among the keys in accessor `input`.
    ///
    /// # Errors
    /// A scene error that names the accessor if its elements are not times, or do not ascend.
    pub(super) fn of(&mut self, document: &Document, input: usize) -> Result<Moment> {
        if let Some(known) = self.known.get(&input) {
            return Ok(*known);
        }
        check_kind(document, input, false)?;
        let times: Vec<f32> = document.floats::<1>(input, Wanted::All)?.into_iter().map(|[t]| t).collect();
        let moment = moment(&times, self.seconds).map_err(|e| e.context(format!("accessor {input}")))?;
        self.known.insert(input, moment);
        Ok(moment)
    }
}

fn moment(times: &[f32], seconds: f32) -> Result<Moment> {
    let Some(&end) = times.last() else { return Err(Error::scene("it has no times")) };
    if let Some(at) = times.iter().position(|t| !t.is_finite()) {
        return Err(Error::scene(format!("time {at} is not finite")));
    }
    if let Some(at) = times.windows(2).position(|t| t[0] >= t[1]) {
        return Err(Error::scene(format!("time {} is not later than the one before it", at + 1)));
    }
    let later = times.partition_point(|&t| t <= seconds);
    let key = later.saturating_sub(1);
    let since_key = |time: f32| f64::from(time) - f64::from(times[key]);
    let next = times.get(later).filter(|_| later > 0);
    let gap = next.map(|&next| Gap { way: since_key(seconds) / since_key(next), length: since_key(next) });
    Ok(Moment { keys: times.len(), key, gap, end: f64::from(end) })
}

impl Sampler {
    /// Evaluates a translation or scale.
    ///
    /// # Errors
    /// A scene error if the values have another type, do not match the number of keys, or are not finite.
    pub(super) fn vector(&self, document: &Document, moment: Moment) -> Result<DVec3> {
        check_kind(document, self.output, false)?;
        Ok(self.piece(document, moment)?.map(DVec3::from).blend(|a, b, way| Some(a.lerp(b, way))).unwrap_or_default())
    }

    /// Evaluates a rotation along the shorter arc.
    ///
    /// # Errors
    /// As [`Sampler::vector`], or if the rotation is not normalisable.
    pub(super) fn rotation(&self, document: &Document, moment: Moment) -> Result<DQuat> {
        check_kind(document, self.output, true)?;
        let turn = |a: DVec4, b: DVec4, way| {
            let (a, b) = (unit_quaternion(a.to_array())?, unit_quaternion(b.to_array())?);
            Some(a.slerp(b, way).into())
        };
        let blended = self.piece(document, moment)?.map(DVec4::from).blend(turn);
        let unit = blended.and_then(|q| unit_quaternion(q.to_array()));
        unit.ok_or_else(|| Error::scene(format!("accessor {}: it is not a unit quaternion", self.output)))
    }

    /// Returns the piece of the curve that contains the moment.
    fn piece<const N: usize>(&self, document: &Document, moment: Moment) -> Result<Piece<[f64; N]>> {
        let named = |e: Error| e.context(format!("accessor {}", self.output));
        let (has, keys) = (document.elements_of::<N>(self.output)?, moment.keys);
        let each = if self.interpolation == Interpolation::CubicSpline { 3 } else { 1 };
        if Some(has) != keys.checked_mul(each) {
            let what = if each == 1 { "" } else { ", of which each has three on a cubic spline" };
            return Err(named(Error::scene(format!("it has {has} elements for {keys} keys{what}"))));
        }
        let gap = moment.gap.filter(|_| self.interpolation != Interpolation::Step);
        let first = each * moment.key + each / 2;
        let last = if gap.is_some() { first + each } else { first };
        let index = |i: usize| u32::try_from(i).map_err(|_| named(Error::scene("it has more than 2^32 elements")));
        let wanted: Vec<u32> = (index(first)?..=index(last)?).collect();
        let read = document.floats::<N>(self.output, Wanted::These(&wanted))?;
        if read.as_flattened().iter().any(|c| !c.is_finite()) {
            return Err(named(Error::scene("it has a value that is not finite")));
        }
        let read: Vec<[f64; N]> = read.into_iter().map(|v| v.map(f64::from)).collect();
        Ok(match (&read[..], gap) {
            (&[from, to], Some(Gap { way, .. })) => Piece::Line { from, to, way },
            (&[from, leaving, arriving, to], Some(Gap { way, length })) => {
                Piece::Cubic { from, leaving, arriving, to, way, length }
            }
            (&[value, ..], _) => Piece::Constant(value),
            (&[], _) => return Err(named(Error::scene("it has no values"))),
        })
    }
}

/// Times, translations and scales must be floats; rotations may be normalised integers [glTF20 §3.11].
fn check_kind(document: &Document, index: usize, rotation: bool) -> Result<()> {
    let named = |e: Error| e.context(format!("accessor {index}"));
    let accessor = document.accessor(index).map_err(named)?;
    let right = match &accessor.component_type {
        Checked::Valid(kind) if rotation && accessor.normalized => kind.0 != ComponentType::U32,
        Checked::Valid(kind) => kind.0 == ComponentType::F32,
        Checked::Invalid => false,
    };
    if right { Ok(()) } else { Err(named(Error::scene("its component type is not for that"))) }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn at(times: &[f32], seconds: f64) -> (usize, Option<f64>) {
        let moment = moment(times, Moments::at(seconds).seconds).unwrap();
        (moment.key, moment.gap.map(|gap| gap.way))
    }

    #[test]
    fn times_outside_the_keys_clamp_to_first_and_last() {
        let times = [1.0, 2.0, 4.0];
        for early in [f64::NEG_INFINITY, -1.0, 0.999, f64::NAN] {
            assert_eq!(at(&times, early), (0, None), "{early}");
        }
        for late in [4.0, 5.0, f64::MAX, f64::INFINITY] {
            assert_eq!(at(&times, late), (2, None), "{late}");
        }
        assert_eq!((at(&times, 1.0), at(&times, 2.0)), ((0, Some(0.0)), (1, Some(0.0))));
        assert_eq!((at(&times, 1.25), at(&times, 3.5)), ((0, Some(0.25)), (1, Some(0.75))));
        assert_eq!((at(&[0.5], 0.0), at(&[0.5], 1.0)), ((0, None), (0, None)));
    }

    #[test]
    fn frame_time_hits_its_key() {
        for fps in [24.0, 25.0, 30.0, 60.0, 30_000.0 / 1001.0] {
            let times: Vec<f32> = (0..2000).map(|frame| (f64::from(frame) / fps) as f32).collect();
            for frame in 0..1999 {
                assert_eq!(at(&times, f64::from(frame) / fps), (frame as usize, Some(0.0)), "{fps}");
            }
        }
    }

    #[test]
    fn times_must_be_finite_and_ascend() {
        for (times, what) in [
            (&[][..], "it has no times"),
            (&[0.0, f32::NAN], "time 1 is not finite"),
            (&[f32::NEG_INFINITY], "time 0 is not finite"),
            (&[0.0, 2.0, 1.0], "time 2 is not later than the one before it"),
            (&[0.0, 0.0], "time 1 is not later than the one before it"),
        ] {
            assert_eq!(moment(times, 0.5).unwrap_err().to_string(), what);
        }
    }
}
