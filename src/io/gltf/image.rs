//! PNG and JPEG images, decoded in parallel, each once.
//!
//! The memory needed for decoding follows from the image headers. It is compared with the available memory before any
//! image is decoded.

use super::document::{Document, name_or};
use super::resource;
use crate::error::{Error, Kind, Result};
use crate::texture::{Bitmap, Texels};
use ::image::{DynamicImage, ImageDecoder, ImageFormat, ImageReader, Limits, Rgba};
use rayon::prelude::*;
use std::borrow::Cow;
use std::collections::HashMap;
use std::io::Cursor;
use std::sync::Arc;

/// Maximum side of an image, in texels.
const LARGEST_SIDE: u32 = 1 << 15;
/// Memory limit of decoding one image, in bytes: 16k × 16k texels of 16 bits.
const LARGEST_IMAGE: u64 = 1 << 31;
/// Decodes the images with these indices, in this order. Entries that refer to the same bytes share one image.
///
/// # Errors
/// An error that names the image if it cannot be read or is neither PNG nor JPEG. An error of class memory that names
/// the largest image if all together exceed the available memory.
pub(super) fn decode(document: &Document, indices: &[usize]) -> Result<Vec<Arc<Bitmap>>> {
    let mut distinct: Vec<Encoded> = Vec::new();
    let mut known = HashMap::new();
    let mut places = Vec::with_capacity(indices.len());
    for &index in indices {
        let image = &document.root.images[index];
        let place = *known.entry((&image.uri, image.buffer_view.map(|v| v.value()))).or_insert(distinct.len());
        places.push(place);
        if place == distinct.len() {
            distinct.push(Encoded::read(document, index)?);
        }
    }
    afford(&distinct, document.memory)?;
    let decoded: Vec<Result<Bitmap>> =
        distinct.par_iter().map(|e| e.decode().map_err(|error| e.named(error))).collect();
    let decoded = decoded.into_iter().map(|image| image.map(Arc::new)).collect::<Result<Vec<_>>>()?;
    Ok(places.into_iter().map(|place| Arc::clone(&decoded[place])).collect())
}

/// An encoded image, as stored in the file.
struct Encoded<'a> {
    name: String,
    bytes: Cow<'a, [u8]>,
}

impl<'a> Encoded<'a> {
    fn read(document: &'a Document, index: usize) -> Result<Self> {
        let image = &document.root.images[index];
        let name = name_or(&image.name, "image", index);
        let bytes = match (&image.uri, image.buffer_view) {
            (Some(uri), _) => resource::read_uri(&document.base, uri, LARGEST_IMAGE).map(Cow::Owned),
            (None, Some(view)) => document.view(view.value()).map(Cow::Borrowed),
            (None, None) => Err(Error::scene("it has neither a URI nor a buffer view")),
        };
        match bytes {
            Ok(bytes) => Ok(Encoded { name, bytes }),
            Err(error) => Err(error.context(format!("image '{name}'"))),
        }
    }

    fn named(&self, error: Error) -> Error {
        error.context(format!("image '{}'", self.name))
    }

    fn format(&self) -> Result<ImageFormat> {
        let format = ::image::guess_format(&self.bytes).ok();
        let known = format.filter(|f| matches!(f, ImageFormat::Png | ImageFormat::Jpeg));
        known.ok_or_else(|| Error::scene("it is neither PNG nor JPEG"))
    }

    fn decoder(&self) -> Result<impl ImageDecoder + '_> {
        let mut reader = ImageReader::with_format(Cursor::new(&*self.bytes), self.format()?);
        let mut limits = Limits::default();
        limits.max_image_width = Some(LARGEST_SIDE);
        limits.max_image_height = Some(LARGEST_SIDE);
        limits.max_alloc = Some(LARGEST_IMAGE);
        reader.limits(limits);
        reader.into_decoder().map_err(undecodable)
    }

    /// Returns the size, and the bytes needed for decoding, from the header alone: the decoder's output and the
    /// [`Image`].
    fn claims(&self) -> Result<Claims> {
        let decoder = self.decoder()?;
        let (width, height) = decoder.dimensions();
        let texels = u64::from(width) * u64::from(height);
        if texels == 0 {
            return Err(Error::scene("it has no texels"));
        }
        let held = texels * if is_deep(decoder.color_type()) { 8 } else { 4 };
        Ok(Claims { width, height, bytes: held.saturating_add(decoder.total_bytes()) })
    }

    fn decode(&self) -> Result<Bitmap> {
        let decoded = DynamicImage::from_decoder(self.decoder()?).map_err(undecodable)?;
        let (width, height) = (decoded.width(), decoded.height());
        let texels = if is_deep(decoded.color()) {
            Texels::Rgba16(decoded.into_rgba16().pixels().map(|&Rgba(p)| p).collect::<Vec<_>>().into())
        } else {
            Texels::Rgba8(decoded.into_rgba8().pixels().map(|&Rgba(p)| p).collect::<Vec<_>>().into())
        };
        Ok(Bitmap::new(width, height, texels))
    }
}

/// Claims of an image header.
struct Claims {
    width: u32,
    height: u32,
    bytes: u64,
}

/// Rejects images that exceed `memory` bytes when decoded.
fn afford(images: &[Encoded], memory: u64) -> Result<()> {
    let claims =
        images.iter().map(|image| image.claims().map_err(|e| image.named(e))).collect::<Result<Vec<Claims>>>()?;
    let need = claims
        .iter()
        .zip(images)
        .fold(0u64, |sum, (c, i)| sum.saturating_add(c.bytes).saturating_add(i.bytes.len() as u64));
    let largest = claims.iter().zip(images).max_by_key(|(claims, _)| claims.bytes);
    let Some((claims, image)) = largest.filter(|_| need > memory) else { return Ok(()) };
    let (Claims { width, height, .. }, name) = (claims, &image.name);
    let (need, have) = (need as f64 / 1e9, memory as f64 / 1e9);
    let what = format!("decoding the images would take {need:.2} GB and {have:.2} GB are available");
    let cure = "give it more with --memory, or make it smaller";
    Err(Error::new(Kind::Memory, format!("{what}: the largest is '{name}' with {width}×{height} texels; {cure}")))
}

fn undecodable(cause: ::image::ImageError) -> Error {
    Error::scene("it cannot be decoded").because(cause)
}

fn is_deep(color: ::image::ColorType) -> bool {
    color.bytes_per_pixel() > color.channel_count()
}
