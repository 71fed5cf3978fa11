//! Layout of the sheet. The left half shows the weighted contribution of each technique, the right half the unweighted
//! one. There is a row for each number of scattering events and a column for each number s of light vertices. Each cell
//! is labelled (s,t). All cells have the exposure of the picture, so that the left half sums to it.

use super::canvas::{Canvas, TEXT_HEIGHT, text_width};
use crate::film::{Film, Layout, Plane};
use crate::integrator::{TechniqueImage, TechniqueImages};
use crate::io::png;
use crate::lab::html::reduced;
use crate::session::ToneMapping;

/// Larger images are reduced by a whole factor until no side is longer, in pixels.
const MOST_SIDE: u32 = 256;

/// Space between cells, in pixels.
const GAP: usize = 6;

/// Space between the two halves, in pixels.
const GUTTER: usize = 24;

/// Geometry of the sheet.
struct Grid {
    columns: usize,
    rows: usize,
    /// Size of an image with its caption.
    cell: [usize; 2],
}

impl Grid {
    fn of(images: &[TechniqueImage], [width, height]: [usize; 2]) -> Self {
        let columns = images.iter().map(|image| image.s + 1).max().unwrap_or(0);
        let rows = images.iter().map(|image| image.events() + 1).max().unwrap_or(0);
        let widest = images.iter().map(|image| text_width(&caption(image))).max().unwrap_or(0);
        Grid { columns, rows, cell: [width.max(widest), height + TEXT_HEIGHT] }
    }

    /// Width of one half: of its columns or of its title, whichever is larger.
    fn half(&self) -> usize {
        (self.columns * (self.cell[0] + GAP)).max(text_width(TITLES[1]))
    }

    fn size(&self) -> [usize; 2] {
        [GAP + self.half() + GUTTER + self.half(), GAP + TEXT_HEIGHT + GAP + self.rows * (self.cell[1] + GAP)]
    }

    /// The left edge of a half.
    fn left(&self, half: usize) -> usize {
        GAP + half * (self.half() + GUTTER)
    }

    /// The upper left corner of a cell.
    fn corner(&self, half: usize, image: &TechniqueImage) -> [usize; 2] {
        let [width, height] = self.cell;
        [self.left(half) + image.s * (width + GAP), GAP + TEXT_HEIGHT + GAP + image.events() * (height + GAP)]
    }
}

const TITLES: [&str; 2] = ["weighted", "unweighted"];

fn caption(image: &TechniqueImage) -> String {
    format!("({},{})", image.s, image.t)
}

/// Draws the sheet.
pub(super) fn draw(images: &TechniqueImages, look: ToneMapping) -> Canvas {
    let images = &images.images;
    let size = images.first().map_or([0; 2], |image| cell_size(image.weighted.layout()));
    let grid = Grid::of(images, size);
    let [width, height] = grid.size();
    let mut canvas = Canvas::new(width, height);
    for (half, title) in TITLES.iter().enumerate() {
        canvas.write([grid.left(half), GAP], title);
        for image in images {
            let [x, y] = grid.corner(half, image);
            canvas.write([x, y], &caption(image));
            let film = if half == 0 { &image.weighted } else { &image.unweighted };
            canvas.paste([x, y + TEXT_HEIGHT], size[0], &colors(film, look));
        }
    }
    canvas
}

/// Size of an image on the sheet.
fn cell_size(layout: &Layout) -> [usize; 2] {
    let [width, height] = extent(layout);
    let factor = width.max(height).div_ceil(MOST_SIDE).max(1);
    [width, height].map(|side| (side / factor).max(1) as usize)
}

fn extent(layout: &Layout) -> [u32; 2] {
    [layout.crop.x1 - layout.crop.x0, layout.crop.y1 - layout.crop.y0]
}

fn colors(film: &Film, look: ToneMapping) -> Vec<[u8; 3]> {
    let [width, height] = extent(film.layout());
    let (_, _, rgb) = reduced(width, height, &film.mean(Plane::Color), MOST_SIDE);
    png::colors(&rgb, look.exposure, look.curve)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::film::{PassFilm, Units};
    use crate::integrator::PassReport;

    /// An image of constant radiance.
    fn image(s: usize, t: usize, side: u32, weighted: f32) -> TechniqueImage {
        let layout = Layout::new(side, side, None, &[]);
        let film = |value: f32| {
            let mut film = Film::new(layout.clone(), 1, 0, Units { radiance: 2f64.powi(-24), length: 1.0 });
            let mut pass = PassFilm::new(&layout);
            for x in 0..side * side {
                let at = [(x % side) as f32 + 0.5, (x / side) as f32 + 0.5];
                pass.splats().queue(crate::film::Filter::Box).add(at, crate::spectrum::Spectrum::splat(value), 0);
            }
            pass.fold_splats();
            film.commit(0, &pass);
            film
        };
        TechniqueImage { s, t, weighted: film(weighted), unweighted: film(1.0) }
    }

    /// Each image has a cell by s and by s + t. Cells do not overlap, and large images are reduced.
    #[test]
    fn every_image_has_its_cell() {
        for side in [4, 600] {
            let names = [(0, 2), (0, 3), (1, 2), (2, 1)];
            let images: Vec<_> = names.iter().map(|&(s, t)| image(s, t, side, 0.0)).collect();
            let sheet = draw(
                &TechniqueImages { images: images.clone(), report: PassReport::default() },
                ToneMapping::default(),
            );
            let size = cell_size(images[0].weighted.layout());
            let grid = Grid::of(&images, size);
            assert_eq!((grid.columns, grid.rows, [sheet.width, sheet.height]), (3, 2, grid.size()));
            assert!(size[0] <= MOST_SIDE as usize);
            for (half, shade) in [(0, 0), (1, 255)] {
                let count = sheet.colors.chunks(sheet.width).flat_map(|row| &row[grid.left(half)..][..grid.half()]);
                assert_eq!(count.filter(|&&color| color == [shade; 3]).count(), names.len() * size[0] * size[1]);
                let [x, y] = grid.corner(half, &images[3]);
                assert_eq!(sheet.colors[(y + TEXT_HEIGHT) * sheet.width + x], [shade; 3]);
            }
        }
    }
}
