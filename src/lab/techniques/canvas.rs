//! A canvas for pasting pictures and captions.

use noto_sans_mono_bitmap::{FontWeight, RasterHeight, get_raster, get_raster_width};

/// Height of captions, in pixels.
pub(super) const TEXT_HEIGHT: usize = RasterHeight::Size16.val();

const PAPER: [u8; 3] = [32; 3];
const INK: [u8; 3] = [224; 3];

/// An 8-bit image with display colours, row by row.
pub(super) struct Canvas {
    pub(super) width: usize,
    pub(super) height: usize,
    pub(super) colors: Vec<[u8; 3]>,
}

/// Returns the width of a caption, in pixels.
pub(super) fn text_width(text: &str) -> usize {
    text.chars().count() * get_raster_width(FontWeight::Regular, RasterHeight::Size16)
}

impl Canvas {
    /// Creates an empty canvas.
    pub(super) fn new(width: usize, height: usize) -> Self {
        Canvas { width, height, colors: vec![PAPER; width * height] }
    }

    /// Pastes a picture `width` pixels wide with its upper left corner at (x, y). Parts outside are cut off.
    pub(super) fn paste(&mut self, [x, y]: [usize; 2], width: usize, colors: &[[u8; 3]]) {
        let space = self.width.saturating_sub(x).min(width);
        for (row, line) in colors.chunks_exact(width).enumerate().take(self.height.saturating_sub(y)) {
            let first = (y + row) * self.width + x;
            self.colors[first..first + space].copy_from_slice(&line[..space]);
        }
    }

    /// Writes a caption with its upper left corner at (x, y). Characters outside the font (ASCII) are left blank.
    pub(super) fn write(&mut self, [x, y]: [usize; 2], text: &str) {
        let step = text_width(" ");
        for (i, letter) in text.chars().enumerate() {
            let Some(raster) = get_raster(letter, FontWeight::Regular, RasterHeight::Size16) else { continue };
            let shade = |ink: u8| std::array::from_fn(|c| mix(PAPER[c], INK[c], ink));
            let colors: Vec<[u8; 3]> = raster.rows().flatten().map(|&ink| shade(ink)).collect();
            self.paste([x + i * step, y], raster.width(), &colors);
        }
    }
}

/// Interpolates from `a` at 0 to `b` at 255.
fn mix(a: u8, b: u8, share: u8) -> u8 {
    let [a, b, share] = [a, b, share].map(u32::from);
    ((a * (255 - share) + b * share) / 255) as u8
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn drawing_is_clipped_to_the_canvas() {
        let mut canvas = Canvas::new(3, 2);
        canvas.paste([2, 1], 2, &[[1; 3], [2; 3], [3; 3], [4; 3]]);
        canvas.paste([3, 0], 1, &[[9; 3]]);
        assert_eq!(canvas.colors, [PAPER, PAPER, PAPER, PAPER, PAPER, [1; 3]]);
    }

    #[test]
    fn captions_are_where_they_are_wanted() {
        let text = "(0,12)";
        let mut canvas = Canvas::new(text_width(text) + 2, TEXT_HEIGHT + 2);
        canvas.write([1, 1], text);
        let inked = |i: usize| canvas.colors[i] != PAPER;
        let letter = |at: usize| {
            let columns = 1 + at * text_width(" ")..1 + (at + 1) * text_width(" ");
            (0..canvas.height).any(|y| columns.clone().any(|x| inked(y * canvas.width + x)))
        };
        assert!((0..text.len()).all(letter));
        assert!((0..canvas.width).all(|x| !inked(x)), "the first row is a margin");
        assert_eq!((mix(32, 224, 0), mix(32, 224, 255)), (32, 224));
    }
}
