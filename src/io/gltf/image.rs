//! PNG and JPEG images, decoded in parallel, each once.
//!
//! An image takes memory only if its bytes can hold what its header claims: neither format can expand beyond a factor.

use super::document::{Document, name_or};
use super::resource;
use crate::error::{Error, Kind, Result};
use crate::texture::{Image, Texels};
use ::image::{DynamicImage, ImageDecoder, ImageFormat, ImageReader, Limits, Rgba};
use rayon::prelude::*;
use std::borrow::Cow;
use std::collections::HashMap;
use std::io::Cursor;
use std::sync::Arc;

/// The longest side that is decoded, in texels.
const LARGEST_SIDE: u32 = 1 << 15;
/// The most memory that decoding one image may take, in bytes: 16k × 16k texels of 16 bits.
const LARGEST_IMAGE: u64 = 1 << 31;
/// The most memory that all images of a file may take, as stored and decoded, in bytes.
const LARGEST_TOTAL: u64 = 1 << 34;
/// Deflate makes at most 258 bytes of two bits [RFC1951 §3.2.5].
const MOST_DEFLATE: u64 = 1032;
/// JPEG takes a bit at least for the DC coefficient of a block of 8 × 8 texels, even if progressive [T81 §G.1.2.1].
const MOST_TEXELS_A_BYTE: u64 = 8 * 64;

/// Decodes the images with these indices, in this order. Entries that mean the same bytes share one image.
///
/// # Errors
/// An error that names the image if one cannot be read, is not PNG or JPEG, or claims more texels than its bytes can hold,
/// or if all are too large together.
pub(super) fn decode(document: &Document, indices: &[usize]) -> Result<Vec<Arc<Image>>> {
    let mut distinct: Vec<Encoded> = Vec::new();
    let mut known = HashMap::new();
    let mut places = Vec::with_capacity(indices.len());
    let mut total = 0;
    for &index in indices {
        let image = &document.root.images[index];
        let place = *known.entry((&image.uri, image.buffer_view.map(|v| v.value()))).or_insert(distinct.len());
        places.push(place);
        if place == distinct.len() {
            let encoded = Encoded::read(document, index)?;
            total += encoded.bytes.len() as u64 + encoded.decoded_size().map_err(|e| encoded.named(e))?;
            if total > LARGEST_TOTAL {
                return Err(Error::new(Kind::Memory, format!("the images take more than {LARGEST_TOTAL} bytes of memory")));
            }
            distinct.push(encoded);
        }
    }
    let decoded: Vec<Result<Image>> = distinct.par_iter().map(|e| e.decode().map_err(|error| e.named(error))).collect();
    let decoded = decoded.into_iter().map(|image| image.map(Arc::new)).collect::<Result<Vec<_>>>()?;
    Ok(places.into_iter().map(|place| Arc::clone(&decoded[place])).collect())
}

/// An image as the file stores it.
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

    /// Bytes that [`Image`] will hold, from the header alone, if the rest can be as much.
    fn decoded_size(&self) -> Result<u64> {
        let decoder = self.decoder()?;
        let (width, height) = decoder.dimensions();
        let texels = u64::from(width) * u64::from(height);
        if texels == 0 {
            return Err(Error::scene("it has no texels"));
        }
        let length = self.bytes.len() as u64;
        let fits = match self.format()? {
            ImageFormat::Png => {
                let bits = u64::from(decoder.original_color_type().bits_per_pixel());
                texels * bits / 8 <= length * MOST_DEFLATE
            }
            _ => texels <= length * MOST_TEXELS_A_BYTE,
        };
        if !fits {
            return Err(Error::scene(format!("it claims {width}×{height} texels, more than its {length} bytes can hold")));
        }
        Ok(texels * if is_deep(decoder.color_type()) { 8 } else { 4 })
    }

    fn decode(&self) -> Result<Image> {
        let decoded = DynamicImage::from_decoder(self.decoder()?).map_err(undecodable)?;
        let (width, height) = (decoded.width(), decoded.height());
        let texels = if is_deep(decoded.color()) {
            Texels::Rgba16(decoded.into_rgba16().pixels().map(|&Rgba(p)| p).collect::<Vec<_>>().into())
        } else {
            Texels::Rgba8(decoded.into_rgba8().pixels().map(|&Rgba(p)| p).collect::<Vec<_>>().into())
        };
        Ok(Image::new(width, height, texels))
    }
}

fn undecodable(cause: ::image::ImageError) -> Error {
    Error::scene("it cannot be decoded").because(cause)
}

fn is_deep(color: ::image::ColorType) -> bool {
    color.bytes_per_pixel() > color.channel_count()
}
