//! Radiance pictures (`.hdr`): shared-exponent colours, run-length encoded per component or, in old files, per colour.
//!
//! This is our own decoder. The one of the `image` crate rejects files that begin with `#?RGBE`, and overflows on
//! consecutive runs of length 0. All eight scanline orientations are supported. Colours may be XYZ or RGB, the latter
//! with Rec. 709 primaries unless `PRIMARIES` says otherwise. Limits: `EXPOSURE` and `COLORCORR` are not undone, as in
//! other readers. Reference: the file formats page of Radiance's manual.

use super::primaries::{Primaries, xyz_to_rec_709};
use crate::error::{Error, Kind, Result};
use glam::DMat3;
use std::fs;
use std::path::Path;

/// Maximum number of texels per byte of the file: 127 in four runs of two bytes each, one run per component.
const TEXELS_A_BYTE: u64 = 16;
/// Limit of texels accepted regardless of the file's size, since runs of old files have no such bound.
const BELIEVED_TEXELS: u64 = 1 << 24;
/// Scanline lengths for which the newer encoding is used.
const ENCODED_WIDTHS: std::ops::Range<usize> = 8..0x8000;

/// A decoded picture.
#[derive(Debug, Clone, PartialEq)]
pub struct HdrImage {
    /// Width in texels.
    pub width: u32,
    /// Height in texels.
    pub height: u32,
    /// Linear colours, row by row from the top, in the primaries of the file.
    pub texels: Vec<[f32; 3]>,
    /// Matrix from the file's primaries to linear Rec. 709.
    pub to_rec_709: DMat3,
}

/// Reads a picture.
///
/// # Errors
/// [`Kind::Scene`] with the path if the file cannot be read, is damaged, or is of an unsupported kind.
pub fn read(path: &Path) -> Result<HdrImage> {
    let bytes = fs::read(path).map_err(|cause| Error::read(path, cause))?;
    decode(&bytes).map_err(|what| Error::new(Kind::Scene, format!("cannot read {}: {what}", path.display())))
}

type Decoded<T> = std::result::Result<T, String>;

fn decode(bytes: &[u8]) -> Decoded<HdrImage> {
    let mut input = Input(bytes);
    if !bytes.starts_with(b"#?") {
        return Err("it is not a Radiance picture".into());
    }
    let to_rec_709 = header(&mut input)?;
    let order = Order::parse(&input.line()?)?;
    let [width, height] = order.size();
    let (claimed, held) = (u64::from(width) * u64::from(height), bytes.len() as u64);
    if claimed > (held * TEXELS_A_BYTE).max(BELIEVED_TEXELS) {
        return Err(format!("it claims {width}×{height} texels, more than {held} bytes can hold"));
    }
    let mut texels = Vec::new();
    let mut scanline = vec![[0; 4]; order.length as usize];
    for _ in 0..order.scanlines {
        input.scanline(&mut scanline)?;
        texels.extend(scanline.iter().map(color));
    }
    Ok(HdrImage { width, height, texels: order.upright(texels), to_rec_709 })
}

/// Reads the header up to its empty line. Returns the matrix from the file's colours to linear Rec. 709.
fn header(input: &mut Input<'_>) -> Decoded<DMat3> {
    let (mut xyz, mut primaries) = (false, Primaries::REC_709);
    loop {
        let line = input.line()?;
        if line.is_empty() {
            break;
        }
        if let Some(format) = line.strip_prefix("FORMAT=") {
            xyz = match format.trim() {
                "32-bit_rle_rgbe" => false,
                "32-bit_rle_xyze" => true,
                _ => return Err(format!("'{line}' is not supported")),
            };
        }
        if let Some(numbers) = line.strip_prefix("PRIMARIES=") {
            let numbers: Option<Vec<f64>> = numbers.split_ascii_whitespace().map(|n| n.parse().ok()).collect();
            let eight = numbers.and_then(|numbers| numbers.try_into().ok());
            let eight: [f64; 8] = eight.ok_or_else(|| format!("'{line}' are no eight chromaticities"))?;
            // Photoshop writes zeros for none.
            if eight.iter().any(|&number| number != 0.0) {
                primaries = Primaries(eight);
            }
        }
    }
    let of_rgb = || primaries.to_rec_709().ok_or("its PRIMARIES make no colours");
    if xyz { Ok(xyz_to_rec_709()) } else { Ok(of_rgb()?) }
}

/// Order of the texels in the file.
#[derive(Clone, Copy)]
struct Order {
    /// Number of scanlines; `length` is the number of texels in each.
    scanlines: u32,
    length: u32,
    /// Whether scanlines are columns.
    columns: bool,
    /// Whether scanlines start from the far end (right or bottom), and whether their texels do.
    from_end: [bool; 2],
}

impl Order {
    /// Parses the resolution line: an axis with its direction for the scanlines, and one for their texels.
    fn parse(line: &str) -> Decoded<Self> {
        let words: Vec<&str> = line.split_ascii_whitespace().collect();
        let side = |text: &str| text.parse().ok().filter(|&side: &u32| side > 0);
        let axis = |text: &str| match text {
            "-Y" => Some((false, false)),
            "+Y" => Some((false, true)),
            "+X" => Some((true, false)),
            "-X" => Some((true, true)),
            _ => None,
        };
        let parse = || {
            let &[first, scanlines, second, length] = &words[..] else { return None };
            let ((columns, first_end), (texels_along_x, second_end)) = (axis(first)?, axis(second)?);
            let (scanlines, length) = (side(scanlines)?, side(length)?);
            let order = Order { scanlines, length, columns, from_end: [first_end, second_end] };
            (columns != texels_along_x).then_some(order)
        };
        parse().ok_or_else(|| format!("'{line}' is not a size such as -Y HEIGHT +X WIDTH"))
    }

    /// Width and height.
    fn size(self) -> [u32; 2] {
        if self.columns { [self.scanlines, self.length] } else { [self.length, self.scanlines] }
    }

    /// Reorders the texels row by row from the top.
    fn upright(self, texels: Vec<[f32; 3]>) -> Vec<[f32; 3]> {
        if !self.columns && self.from_end == [false; 2] {
            return texels;
        }
        let [width, height] = self.size().map(|side| side as usize);
        let (scanlines, length) = (self.scanlines as usize, self.length as usize);
        let place = |i: usize, count: usize, from_end: bool| if from_end { count - 1 - i } else { i };
        let texel = |x: usize, y: usize| {
            let (scanline, at) = if self.columns { (x, y) } else { (y, x) };
            texels[place(scanline, scanlines, self.from_end[0]) * length + place(at, length, self.from_end[1])]
        };
        (0..height).flat_map(|y| (0..width).map(move |x| (x, y))).map(|(x, y)| texel(x, y)).collect()
    }
}

/// The mantissas times 2^(exponent − 136); exponent 0 is black.
fn color(&[r, g, b, exponent]: &[u8; 4]) -> [f32; 3] {
    let unit = if exponent == 0 { 0.0 } else { (f32::from(exponent) - 136.0).exp2() };
    [r, g, b].map(|mantissa| f32::from(mantissa) * unit)
}

/// The rest of the file.
struct Input<'a>(&'a [u8]);

impl<'a> Input<'a> {
    fn take(&mut self, count: usize) -> Decoded<&'a [u8]> {
        let (head, tail) = self.0.split_at_checked(count).ok_or("it ends too early")?;
        self.0 = tail;
        Ok(head)
    }

    fn array<const N: usize>(&mut self) -> Decoded<[u8; N]> {
        let (head, tail) = self.0.split_first_chunk().ok_or("it ends too early")?;
        self.0 = tail;
        Ok(*head)
    }

    fn line(&mut self) -> Decoded<String> {
        let end = self.0.iter().position(|&byte| byte == b'\n').ok_or("it ends within its header")?;
        let line = self.take(end + 1)?;
        Ok(String::from_utf8_lossy(line).trim().to_owned())
    }

    fn scanline(&mut self, out: &mut [[u8; 4]]) -> Decoded<()> {
        let first: [u8; 4] = self.array()?;
        let [two, too, high, low] = first;
        let is_encoded = ENCODED_WIDTHS.contains(&out.len()) && (two, too) == (2, 2) && high < 0x80;
        if !is_encoded {
            return self.colors(first, out);
        }
        if usize::from(u16::from_be_bytes([high, low])) != out.len() {
            return Err("a scanline has another length than the picture".into());
        }
        (0..4).try_for_each(|component| self.component(component, out))
    }

    /// Decodes one component of a scanline. A run is a count and a value, or a smaller count and as many values.
    fn component(&mut self, component: usize, out: &mut [[u8; 4]]) -> Decoded<()> {
        let mut at = 0;
        while at < out.len() {
            let [count] = self.array()?;
            let (length, is_run) = if count > 128 { (count - 128, true) } else { (count, false) };
            let run = out[at..].get_mut(..usize::from(length)).filter(|run| !run.is_empty());
            let run = run.ok_or("a run does not fit into its scanline")?;
            at += run.len();
            if is_run {
                let [value] = self.array()?;
                run.iter_mut().for_each(|texel| texel[component] = value);
            } else {
                let values = self.take(run.len())?;
                run.iter_mut().zip(values).for_each(|(texel, &value)| texel[component] = value);
            }
        }
        Ok(())
    }

    /// Decodes a scanline of colours, beginning with `first`. A colour with mantissas 1, 1, 1 repeats its predecessor,
    /// as often as its exponent says. Each further one in a row counts 256 times as much.
    fn colors(&mut self, first: [u8; 4], out: &mut [[u8; 4]]) -> Decoded<()> {
        let (mut at, mut next, mut shift) = (0, Some(first), 0);
        while at < out.len() {
            let texel = next.take().map_or_else(|| self.array(), Ok)?;
            if let [1, 1, 1, count] = texel {
                let length = usize::from(count).checked_shl(shift).filter(|_| at > 0 && shift < 32);
                let run = length.and_then(|length| out[at..].get_mut(..length).map(|run| run.len()));
                let end = at + run.ok_or("a run does not fit into its scanline")?;
                let last = out[at - 1];
                out[at..end].fill(last);
                (at, shift) = (end, shift + 8);
            } else {
                out[at] = texel;
                (at, shift) = (at + 1, 0);
            }
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::stats::test_random::Random;

    fn picture(size: &str, data: &[u8]) -> Vec<u8> {
        [format!("#?RGBE\nFORMAT=32-bit_rle_rgbe\n# a comment\n\n{size}\n").as_bytes(), data].concat()
    }

    fn texels(size: &str, data: &[u8]) -> Vec<[f32; 3]> {
        decode(&picture(size, data)).unwrap().texels
    }

    /// The unit of a mantissa is 2⁻⁸ times 2^(exponent − 128).
    #[test]
    fn colors_are_mantissas_times_a_shared_power_of_two() {
        let data = [128, 64, 0, 129, 255, 1, 2, 136, 9, 9, 9, 0];
        assert_eq!(texels("-Y 1 +X 3", &data), [[1.0, 0.5, 0.0], [255.0, 1.0, 2.0], [0.0; 3]]);
    }

    #[test]
    fn scanlines_are_decoded_by_component_and_by_color() {
        let mut by_component = vec![2, 2, 0, 9];
        for value in [10, 20, 30] {
            by_component.extend([128 + 6, value, 3, 1, 2, 3]); // six times the value, then 1, 2, 3
        }
        by_component.extend([128 + 9, 136]);
        let row = texels("-Y 1 +X 9", &by_component);
        assert_eq!((row[5], row[8]), ([10.0, 20.0, 30.0], [3.0; 3]));
        // Runs of 2 and of 1 × 256.
        let by_color = [5, 6, 7, 136, 1, 1, 1, 2, 1, 1, 1, 1, 8, 9, 10, 136];
        let row = texels("-Y 1 +X 260", &by_color);
        assert_eq!((row[258], row[259]), ([5.0, 6.0, 7.0], [8.0, 9.0, 10.0]));
    }

    /// The same 2 × 3 picture in every orientation, its texels numbered from the top left.
    #[test]
    fn every_orientation_is_the_same_picture() {
        let numbered = |order: [u8; 6]| order.map(|i| [i, 0, 0, 136]).concat();
        for (size, order) in [
            ("-Y 3 +X 2", [1, 2, 3, 4, 5, 6]),
            ("-Y 3 -X 2", [2, 1, 4, 3, 6, 5]),
            ("+Y 3 +X 2", [5, 6, 3, 4, 1, 2]),
            ("+Y 3 -X 2", [6, 5, 4, 3, 2, 1]),
            ("+X 2 -Y 3", [1, 3, 5, 2, 4, 6]),
            ("+X 2 +Y 3", [5, 3, 1, 6, 4, 2]),
            ("-X 2 -Y 3", [2, 4, 6, 1, 3, 5]),
            ("-X 2 +Y 3", [6, 4, 2, 5, 3, 1]),
        ] {
            let image = decode(&picture(size, &numbered(order))).unwrap();
            assert_eq!((image.width, image.height), (2, 3), "{size}");
            let seen: Vec<f32> = image.texels.iter().map(|texel| texel[0]).collect();
            assert_eq!(seen, [1.0, 2.0, 3.0, 4.0, 5.0, 6.0], "{size}");
        }
    }

    #[test]
    fn hdr_errors_name_the_defect() {
        for (bytes, what) in [
            (b"\x89PNG".to_vec(), "not a Radiance picture"),
            (b"#?RADIANCE\n".to_vec(), "within its header"),
            (b"#?RADIANCE\nFORMAT=64-bit\n\n-Y 1 +X 1\n".to_vec(), "64-bit"),
            (b"#?RADIANCE\nPRIMARIES=1 2 3\n\n-Y 1 +X 1\n".to_vec(), "no eight"),
            (b"#?RADIANCE\nPRIMARIES=1 1 1 1 1 1 1 1\n\n-Y 1 +X 1\n".to_vec(), "no colours"),
            (picture("+Y 1 -Y 1", &[1; 4]), "'+Y 1 -Y 1' is not a size"),
            (picture("-Y 0 +X 1", &[1; 4]), "is not a size"),
            (picture("-Y 60000 +X 60000", &[1; 4]), "more than"),
            (picture("-Y 2 +X 1", &[9; 4]), "ends too early"),
            (picture("-Y 1 +X 8", &[2, 2, 0, 9]), "another length"),
            (picture("-Y 1 +X 8", &[2, 2, 0, 8, 255, 1]), "a run does not fit"),
            (picture("-Y 1 +X 8", &[2, 2, 0, 8, 0, 0]), "a run does not fit"),
            (picture("-Y 1 +X 8", &[1, 1, 1, 8]), "a run does not fit"),
            (picture("-Y 1 +X 8", &[2, 1, 1, 8, 1, 1, 1, 9]), "a run does not fit"),
        ] {
            let error = decode(&bytes).unwrap_err();
            assert!(error.contains(what), "{error}: {what}");
        }
    }

    /// Consecutive runs of length 0 terminate, and damage never panics.
    #[test]
    fn damage_does_not_panic() {
        assert!(decode(&picture("-Y 1 +X 8", &[[9, 9, 9, 9], [1, 1, 1, 0]].concat().repeat(50))).is_ok());
        let zeros = [vec![9; 4], [1, 1, 1, 0].repeat(50)].concat();
        assert!(decode(&picture("-Y 1 +X 8", &zeros)).is_err());
        let mut data = vec![];
        for _ in 0..4 {
            data.extend([2, 2, 0, 20]);
            (0..4).for_each(|value| data.extend([128 + 12, value, 8, 1, 2, 3, 4, 5, 6, 7, 8]));
        }
        let bytes = picture("-Y 4 +X 20", &data);
        assert!(decode(&bytes).is_ok());
        assert!((0..bytes.len()).all(|length| decode(&bytes[..length]).is_err()));
        let mut random = Random::new(4);
        for i in 0..bytes.len() {
            let mut changed = bytes.clone();
            changed[i] ^= 1 << (random.bits() % 8);
            let _ = decode(&changed);
        }
    }
}
