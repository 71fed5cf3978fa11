//! PNG and JPEG images, decoded in parallel, each once.

use super::document::{Document, name_or};
use super::resource;
use crate::error::{Error, Kind, Result};
use crate::texture::{Image, Texels};
use ::image::{DynamicImage, ImageDecoder, ImageFormat, ImageReader, Limits, Rgba};
use rayon::prelude::*;
use std::borrow::Cow;
use std::io::Cursor;

/// The longest side that is decoded, in texels.
const LARGEST_SIDE: u32 = 1 << 15;
/// The most memory that decoding one image may take, in bytes: 16k × 16k texels of 16 bits.
const LARGEST_IMAGE: u64 = 1 << 31;
/// The most memory that all images of a file may take, in bytes.
const LARGEST_TOTAL: u64 = 1 << 34;

/// Decodes the images with these indices, in this order.
///
/// # Errors
/// An error that names the image if one cannot be read or is not PNG or JPEG, or if they are too large.
pub(super) fn decode(document: &Document, indices: &[usize]) -> Result<Vec<Image>> {
    let named =
        |index: usize, e: Error| e.context(format!("image '{}'", name_or(&document.root.images[index].name, "image", index)));
    let mut encoded = Vec::with_capacity(indices.len());
    let mut total = 0;
    for &index in indices {
        let bytes = encoded_bytes(document, index).map_err(|e| named(index, e))?;
        total += decoded_size(&bytes).map_err(|e| named(index, e))?;
        if total > LARGEST_TOTAL {
            return Err(Error::new(Kind::Memory, format!("the images take more than {LARGEST_TOTAL} bytes of memory")));
        }
        encoded.push((index, bytes));
    }
    let decoded: Vec<Result<Image>> = encoded.par_iter().map(|(i, b)| decode_one(b).map_err(|e| named(*i, e))).collect();
    decoded.into_iter().collect()
}

fn encoded_bytes(document: &Document, index: usize) -> Result<Cow<'_, [u8]>> {
    let image = &document.root.images[index];
    match (&image.uri, image.buffer_view) {
        (Some(uri), _) => resource::read_uri(&document.base, uri, LARGEST_IMAGE).map(Cow::Owned),
        (None, Some(view)) => document.view(view.value()).map(Cow::Borrowed),
        (None, None) => Err(Error::scene("it has neither a URI nor a buffer view")),
    }
}

fn decoder(bytes: &[u8]) -> Result<impl ImageDecoder + '_> {
    let format = ::image::guess_format(bytes).ok();
    let Some(format @ (ImageFormat::Png | ImageFormat::Jpeg)) = format else {
        return Err(Error::scene("it is neither PNG nor JPEG"));
    };
    let mut reader = ImageReader::with_format(Cursor::new(bytes), format);
    let mut limits = Limits::default();
    limits.max_image_width = Some(LARGEST_SIDE);
    limits.max_image_height = Some(LARGEST_SIDE);
    limits.max_alloc = Some(LARGEST_IMAGE);
    reader.limits(limits);
    reader.into_decoder().map_err(undecodable)
}

fn undecodable(cause: ::image::ImageError) -> Error {
    Error::scene("it cannot be decoded").because(cause)
}

/// Bytes that [`Image`] will hold, from the header alone.
fn decoded_size(bytes: &[u8]) -> Result<u64> {
    let decoder = decoder(bytes)?;
    let (width, height) = decoder.dimensions();
    let texel = if is_deep(decoder.color_type()) { 8 } else { 4 };
    if width == 0 || height == 0 {
        return Err(Error::scene("it has no texels"));
    }
    Ok(u64::from(width) * u64::from(height) * texel)
}

fn is_deep(color: ::image::ColorType) -> bool {
    color.bytes_per_pixel() > color.channel_count()
}

fn decode_one(bytes: &[u8]) -> Result<Image> {
    let decoded = DynamicImage::from_decoder(decoder(bytes)?).map_err(undecodable)?;
    let (width, height) = (decoded.width(), decoded.height());
    let texels = if is_deep(decoded.color()) {
        Texels::Rgba16(decoded.into_rgba16().pixels().map(|&Rgba(p)| p).collect())
    } else {
        Texels::Rgba8(decoded.into_rgba8().pixels().map(|&Rgba(p)| p).collect())
    };
    Ok(Image::new(width, height, texels))
}
