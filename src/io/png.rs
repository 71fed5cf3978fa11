//! 8-bit PNG for viewing. The picture of record is the EXR.

use super::atomic::write_atomically;
use crate::error::{Error, Kind, Result};
use ::png::{BitDepth, ColorType, Compression, Decoder, Encoder, EncodingError, Filter};
use std::fs::File;
use std::io::{self, BufReader, BufWriter, Write};
use std::path::Path;

/// Tone curve from linear to display values.
#[derive(
    Debug,
    Clone,
    Copy,
    PartialEq,
    Eq,
    Hash,
    Default,
    serde::Serialize,
    serde::Deserialize,
    strum::VariantArray,
    strum::IntoStaticStr,
    strum::EnumMessage,
)]
#[serde(rename_all = "kebab-case")]
#[strum(serialize_all = "kebab-case")]
pub enum ToneCurve {
    /// The sRGB transfer function of IEC 61966-2-1; values above 1 clip.
    #[default]
    Srgb,
    /// Narkowicz's fit of the ACES curve, then the sRGB transfer function: highlights roll off [Narkowicz15].
    Filmic,
}

impl ToneCurve {
    /// Returns the display value in [0, 1] of a linear value; NaN gives 0.
    pub fn apply(self, linear: f32) -> f32 {
        let x = linear.max(0.0);
        match self {
            ToneCurve::Srgb => srgb(x),
            // From 1e6 on the curve is clipped at 1, and its squares could overflow.
            ToneCurve::Filmic => srgb(filmic(x.min(1e6))),
        }
    }
}

fn filmic(x: f32) -> f32 {
    (x * (2.51 * x + 0.03)) / (x * (2.43 * x + 0.59) + 0.14)
}

fn srgb(x: f32) -> f32 {
    let x = x.min(1.0);
    if x <= 0.003_130_8 { 12.92 * x } else { 1.055 * x.powf(1.0 / 2.4) - 0.055 }
}

/// A picture of linear Rec. 709 values, row by row. With `alpha` the colours are premultiplied (as a film's means are).
/// Writing divides by alpha, since PNG stores straight alpha.
#[derive(Debug, Clone, Copy)]
pub struct PngPicture<'a> {
    /// Width in pixels.
    pub width: u32,
    /// Height in pixels.
    pub height: u32,
    /// Colours, three values per pixel.
    pub rgb: &'a [f32],
    /// Alpha, one value per pixel.
    pub alpha: Option<&'a [f32]>,
}

/// Writes a picture after applying `exposure` in stops. `labels` are keywords with their text, in Latin-1.
///
/// # Errors
/// [`Kind::Output`] with the path if the file cannot be written, [`Kind::Internal`] if there are not width × height
/// pixels.
pub fn write(
    path: &Path,
    picture: PngPicture<'_>,
    exposure: f32,
    curve: ToneCurve,
    labels: &[(&str, &str)],
) -> Result<()> {
    let PngPicture { width, height, rgb, alpha } = picture;
    let pixels = width as usize * height as usize;
    if rgb.len() != 3 * pixels || alpha.is_some_and(|a| a.len() != pixels) {
        return Err(Error::new(Kind::Internal, format!("{} does not have {width}×{height} pixels", path.display())));
    }
    let (bytes, color) = encode(rgb, alpha, exposure.exp2(), curve);
    save(path, [width, height], &bytes, color, labels)
}

/// Writes 8-bit display colours unchanged, one per pixel.
///
/// # Errors
/// As [`write`].
pub fn write_colors(path: &Path, width: u32, height: u32, colors: &[[u8; 3]]) -> Result<()> {
    if colors.len() != width as usize * height as usize {
        return Err(Error::new(Kind::Internal, format!("{} does not have {width}×{height} pixels", path.display())));
    }
    save(path, [width, height], colors.as_flattened(), ColorType::Rgb, &[])
}

fn save(path: &Path, size: [u32; 2], bytes: &[u8], color: ColorType, labels: &[(&str, &str)]) -> Result<()> {
    write_atomically(path, |file| {
        let mut file = BufWriter::new(file);
        pack(&mut file, size, bytes, (color, Compression::Fast), labels).map_err(io::Error::other)?;
        file.flush()
    })
}

fn pack(
    out: impl Write,
    [width, height]: [u32; 2],
    bytes: &[u8],
    (color, compression): (ColorType, Compression),
    labels: &[(&str, &str)],
) -> std::result::Result<(), EncodingError> {
    let mut encoder = Encoder::new(out, width, height);
    encoder.set_color(color);
    encoder.set_depth(BitDepth::Eight);
    encoder.set_compression(compression);
    encoder.set_filter(Filter::Adaptive);
    labels.iter().try_for_each(|&(keyword, text)| encoder.add_text_chunk(keyword.into(), text.into()))?;
    let mut writer = encoder.write_header()?;
    writer.write_image_data(bytes)?;
    writer.finish()
}

/// Reads the label `keyword` of a picture; `None` if it is missing, or if the picture is incomplete.
pub fn label(path: &Path, keyword: &str) -> Option<String> {
    let mut reader = Decoder::new(BufReader::new(File::open(path).ok()?)).read_info().ok()?;
    let labels = &reader.info().uncompressed_latin1_text;
    let text = labels.iter().find(|label| label.keyword == keyword)?.text.clone();
    reader.finish().ok().map(|()| text)
}

/// Encodes a picture without alpha as the bytes of a PNG file.
///
/// # Errors
/// [`Kind::Internal`] if there are not width × height pixels.
pub fn bytes(width: u32, height: u32, rgb: &[f32], exposure: f32, curve: ToneCurve) -> Result<Vec<u8>> {
    display_bytes(width, height, &encode(rgb, None, exposure.exp2(), curve).0)
}

/// Converts linear Rec. 709 values to display colours, one per pixel; `exposure` is in stops.
pub fn colors(rgb: &[f32], exposure: f32, curve: ToneCurve) -> Vec<[u8; 3]> {
    encode(rgb, None, exposure.exp2(), curve).0.chunks_exact(3).map(|c| [c[0], c[1], c[2]]).collect()
}

/// Encodes 8-bit display values, row by row, as the bytes of a PNG file.
///
/// # Errors
/// [`Kind::Internal`] if there are not width × height pixels.
pub fn display_bytes(width: u32, height: u32, rgb: &[u8]) -> Result<Vec<u8>> {
    let refuse = || Error::new(Kind::Internal, format!("a picture does not have {width}×{height} pixels"));
    if rgb.len() != 3 * width as usize * height as usize {
        return Err(refuse());
    }
    let mut file = Vec::new();
    let how = (ColorType::Rgb, Compression::High);
    pack(&mut file, [width, height], rgb, how, &[]).map_err(|cause| refuse().because(cause))?;
    Ok(file)
}

fn encode(rgb: &[f32], alpha: Option<&[f32]>, gain: f32, curve: ToneCurve) -> (Vec<u8>, ColorType) {
    let byte = |display: f32| (display * 255.0 + 0.5) as u8;
    let Some(alpha) = alpha else {
        return (rgb.iter().map(|&v| byte(curve.apply(v * gain))).collect(), ColorType::Rgb);
    };
    let straight = |a: f32| if a > 0.0 { gain / a } else { 0.0 };
    let pixels = rgb.chunks_exact(3).zip(alpha);
    let bytes = pixels.flat_map(|(c, &a)| {
        let [r, g, b] = [c[0], c[1], c[2]].map(|v| byte(curve.apply(v * straight(a))));
        [r, g, b, byte(a.clamp(0.0, 1.0))]
    });
    (bytes.collect(), ColorType::Rgba)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn round_trips_through_a_reader() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.png");
        let rgb = [0.0, 0.5, 1.0, 0.214_041_14, f32::NAN, f32::INFINITY];
        let picture = PngPicture { width: 2, height: 1, rgb: &rgb, alpha: None };
        write(&path, picture, 0.0, ToneCurve::Srgb, &[]).unwrap();
        let read = image::open(&path).unwrap().into_rgb8();
        assert_eq!(read.as_raw(), &[0, 188, 255, 128, 0, 255]);
        write(&path, PngPicture { alpha: Some(&[0.5, 0.0]), ..picture }, -1.0, ToneCurve::Srgb, &[]).unwrap();
        let read = image::open(&path).unwrap().into_rgba8();
        assert_eq!(read.as_raw(), &[0, 188, 255, 128, 0, 0, 0, 0]);
    }

    #[test]
    fn png_text_is_read_from_complete_files_only() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.png");
        let picture = PngPicture { width: 2, height: 1, rgb: &[0.5; 6], alpha: None };
        write(&path, picture, 0.0, ToneCurve::Srgb, &[("Software", "étendue"), ("key", "0123")]).unwrap();
        assert_eq!(label(&path, "key").as_deref(), Some("0123"));
        assert_eq!(label(&path, "Software").as_deref(), Some("étendue"));
        assert_eq!(label(&path, "other"), None);
        let bytes = std::fs::read(&path).unwrap();
        for length in 0..bytes.len() {
            std::fs::write(&path, &bytes[..length]).unwrap();
            assert_eq!(label(&path, "key"), None, "{length} of {} bytes", bytes.len());
        }
    }

    /// Published values of the fit: 0 → 0, 0.5 → 0.6163 before the transfer function, and 1 from 8 on within a byte.
    #[test]
    fn filmic_is_the_published_curve() {
        assert!((filmic(0.5) - 0.616_307).abs() < 1e-6);
        let (mut last, mut x) = (0.0, 1e-4_f32);
        while x < 1e3 {
            let y = ToneCurve::Filmic.apply(x);
            assert!((last..=1.0).contains(&y), "{x}");
            (last, x) = (y, x * 1.1);
        }
        assert!(
            (ToneCurve::Filmic.apply(f32::INFINITY) - 1.0).abs() < f32::EPSILON
                && ToneCurve::Filmic.apply(f32::NAN).to_bits() == 0
        );
    }

    #[test]
    fn refuses_a_wrong_number_of_pixels() {
        let picture = PngPicture { width: 2, height: 2, rgb: &[0.0; 9], alpha: None };
        assert_eq!(write(Path::new("a.png"), picture, 0.0, ToneCurve::Srgb, &[]).unwrap_err().kind, Kind::Internal);
    }
}
