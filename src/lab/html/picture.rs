//! Pictures embedded in a page, for side-by-side viewing.

use crate::error::Result;
use crate::io::png::{self, ToneCurve};
use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use maud::{Markup, html};

/// Maximum side of embedded pictures, in pixels. Larger ones are reduced by an integer factor.
pub const MOST_SIDE: u32 = 512;

/// A named picture.
#[derive(Clone)]
pub struct FigurePicture {
    name: String,
    width: u32,
    height: u32,
    uri: String,
}

impl FigurePicture {
    /// Creates a picture from linear Rec. 709 values, row by row; `exposure` is in stops.
    ///
    /// # Errors
    /// An internal error unless there are width × height pixels.
    pub fn of_values(
        name: &str,
        width: u32,
        height: u32,
        rgb: &[f32],
        exposure: f32,
        curve: ToneCurve,
    ) -> Result<FigurePicture> {
        let (width, height, rgb) = reduced(width, height, rgb, MOST_SIDE);
        Ok(FigurePicture::of_png(name, width, height, &png::bytes(width, height, &rgb, exposure, curve)?))
    }

    /// Creates a picture from 8-bit display values, row by row.
    ///
    /// # Errors
    /// An internal error unless there are width × height pixels.
    pub fn of_bytes(name: &str, width: u32, height: u32, rgb: &[u8]) -> Result<FigurePicture> {
        Ok(FigurePicture::of_png(name, width, height, &png::display_bytes(width, height, rgb)?))
    }

    /// Creates a map of `shares` (0 to 1), one per pixel, in the colours of [`ramp`].
    ///
    /// # Errors
    /// An internal error unless there are width × height values.
    pub fn of_shares(name: &str, width: u32, height: u32, shares: &[f32]) -> Result<FigurePicture> {
        let gray: Vec<f32> = shares.iter().flat_map(|&s| [s; 3]).collect();
        let (width, height, gray) = reduced(width, height, &gray, MOST_SIDE);
        let colors: Vec<u8> = gray.iter().step_by(3).flat_map(|&s| heat(s)).collect();
        FigurePicture::of_bytes(name, width, height, &colors)
    }

    fn of_png(name: &str, width: u32, height: u32, png: &[u8]) -> FigurePicture {
        FigurePicture {
            name: name.into(),
            width,
            height,
            uri: format!("data:image/png;base64,{}", STANDARD.encode(png)),
        }
    }
}

/// Reduces the picture by averaging blocks of pixels, until no side exceeds `most`. Columns and rows beyond the last
/// whole block are dropped.
///
/// # Panics
/// If `most` is 0.
pub fn reduced(width: u32, height: u32, rgb: &[f32], most: u32) -> (u32, u32, Vec<f32>) {
    let factor = width.max(height).div_ceil(most).max(1);
    if factor == 1 || rgb.len() != 3 * width as usize * height as usize {
        return (width, height, rgb.to_vec());
    }
    let (w, h) = ((width / factor).max(1), (height / factor).max(1));
    let span = |at: u32, end: u32| at * factor..((at + 1) * factor).min(end);
    let mean = |x: u32, y: u32, c: usize| {
        let at = |x: u32, y: u32| rgb[3 * (y as usize * width as usize + x as usize) + c];
        let sum: f32 = span(y, height).flat_map(|y| span(x, width).map(move |x| (x, y))).map(|(x, y)| at(x, y)).sum();
        sum / (span(x, width).len() * span(y, height).len()) as f32
    };
    let means = (0..h).flat_map(|y| (0..w).flat_map(move |x| (0..3).map(move |c| (x, y, c))));
    (w, h, means.map(|(x, y, c)| mean(x, y, c)).collect())
}

/// Number of steps of the colour map. It is small, so that maps compress well.
const STEPS: f32 = 24.0;
/// Colours of the map from low to high, with increasing brightness, so that it is legible in grey too.
const HEAT: [[f32; 3]; 5] =
    [[8.0, 8.0, 32.0], [76.0, 20.0, 110.0], [190.0, 50.0, 80.0], [248.0, 140.0, 30.0], [252.0, 250.0, 190.0]];

fn heat(share: f32) -> [u8; 3] {
    let last = (HEAT.len() - 1) as f32;
    let at = ((share.clamp(0.0, 1.0) * STEPS).round() / STEPS * last).min(last);
    let low = (at as usize).min(HEAT.len() - 2);
    let t = at - low as f32;
    std::array::from_fn(|c| (HEAT[low][c] * (1.0 - t) + HEAT[low + 1][c] * t + 0.5) as u8)
}

/// Formats the colour map with labels for its ends and its middle.
pub fn ramp(name: &str, [low, middle, high]: [&str; 3]) -> Markup {
    let stops: Vec<String> = HEAT.iter().map(|c| format!("rgb({} {} {})", c[0], c[1], c[2])).collect();
    html! {
        div.key-of-map {
            div.soft { (name) }
            div.ramp aria-hidden="true" style=(format!("background:linear-gradient(to right,{})", stops.join(","))) {}
            div.ends { span { (low) } span { (middle) } span { (high) } }
        }
    }
}

fn id(group: &str, at: usize) -> String {
    format!("{group}-{at}")
}

/// Formats all pictures of a group as thumbnails. [`compare`] shows them large.
pub fn gallery(group: &str, pictures: &[FigurePicture]) -> Markup {
    html! {
        div.gallery {
            @for (at, picture) in pictures.iter().enumerate() {
                figure {
                    img id=(id(group, at)) src=(picture.uri) alt=(picture.name) width=(picture.width) height=(picture.height);
                    figcaption { (picture.name) }
                }
            }
        }
    }
}

/// Formats a comparison of two pictures of the group's [`gallery`], one over the other, with a slider. It starts with
/// the first two, and is hidden without scripts.
pub fn compare(group: &str, pictures: &[FigurePicture]) -> Markup {
    let Some(first) = pictures.first() else { return html! {} };
    let choice = |label: &str, chosen: usize| {
        html! {
            label { (label)
                select {
                    @for (at, picture) in pictures.iter().enumerate() {
                        option value=(id(group, at)) selected[at == chosen] { (picture.name) }
                    }
                }
            }
        }
    };
    html! {
        div.compare hidden {
            div.ask { (choice("Left", 0)) (choice("Right", 1.min(pictures.len() - 1))) }
            div.stack {
                img alt="" width=(first.width) height=(first.height);
                img alt="" width=(first.width) height=(first.height);
                i {}
            }
            input type="range" min="0" max="100" value="50" step="1" aria-label="How much of the left picture is \
                shown, in per cent";
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn large_images_are_downsampled_by_averaging() {
        let rgb: Vec<f32> = (0..1024 * 2).flat_map(|i| [(i % 2) as f32, 1.0, (i / 1024) as f32]).collect();
        let (width, height, small) = reduced(1024, 2, &rgb, 512);
        assert_eq!((width, height), (512, 1));
        assert!(small.chunks(3).all(|p| p == [0.5, 1.0, 0.5]));
        assert_eq!(reduced(2, 1, &[1.0; 6], 512), (2, 1, vec![1.0; 6]));
        assert_eq!(reduced(1025, 1, &[1.0; 3 * 1025], 512), (341, 1, vec![1.0; 3 * 341]));
    }

    #[test]
    fn the_colour_map_grows_brighter() {
        let brightness = |s: f32| heat(s).iter().zip([2126, 7152, 722]).map(|(&c, w)| u32::from(c) * w).sum::<u32>();
        let mut last = 0;
        for step in 0..=STEPS as u32 {
            let now = brightness(step as f32 / STEPS);
            assert!(now > last, "{step}");
            last = now;
        }
        assert_eq!((heat(-1.0), heat(2.0), heat(f32::NAN)), (heat(0.0), heat(1.0), heat(f32::NAN)));
    }
}
