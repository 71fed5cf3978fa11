//! What each technique of bidirectional path tracing finds on its own: an image for every number of vertices s from the light and t
//! from the camera, weighted and unweighted [Veach97 figure 10.4].
//!
//! Use them to see what techniques are good at and whether they are right. The weighted images sum to the picture of the same passes
//! (samples are at the same addresses), in the mean where that plays roulette on connections; without weights all of one path length show the same light, each with its own noise.
//! Every connection is traced: roulette by what it is worth in the picture would spoil what it is worth without weights.
//! Limits: [`Options::clamp`] is not applied; a value that is not finite is left out by itself and not with its whole sample; what
//! no technique of a length can find is in none of its images.

use super::bidirectional::{Bidirectional, Found, Sink};
use super::camera_pass::{CHUNK, gather};
use super::samples::{Sample, Samples, Work};
use super::{InvalidSample, Options, PassReport, Prelude, prelude};
use crate::camera::Camera;
use crate::film::{Film, Filter, Layout, PassFilm};
use crate::parallel::Cancel;
use crate::path::Tally;
use crate::sampling::{Address, Sampler};
use crate::scene::Scene;
use crate::spectrum::Spectrum;
use rayon::prelude::*;

/// What one technique found.
#[derive(Debug, Clone)]
pub struct TechniqueImage {
    /// Vertices from the light.
    pub s: usize,
    /// Vertices from the camera.
    pub t: usize,
    /// Its share of the picture.
    pub weighted: Film,
    /// What it finds without the others.
    pub unweighted: Film,
}

impl TechniqueImage {
    /// Scattering events of its paths.
    pub fn events(&self) -> usize {
        self.s + self.t - 2
    }
}

/// What the techniques found.
#[derive(Debug, Clone)]
pub struct TechniqueImages {
    /// Shorter paths first, then by s.
    pub images: Vec<TechniqueImage>,
    /// Rays traced and guards that fired.
    pub report: PassReport,
}

impl TechniqueImages {
    /// The image of `s` vertices from the light and `t` from the camera, if its technique takes part.
    pub fn get(&self, s: usize, t: usize) -> Option<&TechniqueImage> {
        self.images.iter().find(|image| (image.s, image.t) == (s, t))
    }

    /// Memory that it takes to make the images of [`technique_images`], in bytes per pixel.
    pub fn bytes_per_pixel(options: &Options, deepest: u32) -> usize {
        let layout = Layout::new(1, 1, None, &[]);
        let pass = layout.channels() * (size_of::<f32>() + size_of::<i64>());
        let images = 2 * techniques(options, deepest).count();
        images * (Film::bytes_per_pixel(&layout, options.replicates) + pass)
    }
}

/// The techniques of paths of at most `deepest` scattering events that take part.
fn techniques(options: &Options, deepest: u32) -> impl Iterator<Item = (usize, usize)> {
    let (techniques, deepest) = (options.techniques, options.max_depth.map_or(deepest, |most| most.min(deepest)));
    let all = (0..=deepest as usize).flat_map(|events| (0..=events + 1).map(move |s| (s, events + 2 - s)));
    all.filter(move |&(s, t)| techniques.has(s, t))
}

/// The images of all techniques of bidirectional path tracing over `passes` of the picture that `camera` takes of `scene`, for paths of at
/// most `deepest` scattering events; `None` if it was cancelled. As a film's, sums are kept by replicate (pass mod
/// [`Options::replicates`]) and do not depend on order or threads.
pub fn technique_images(
    scene: &Scene,
    camera: &Camera,
    options: &Options,
    layout: &Layout,
    passes: impl IntoIterator<Item = u64>,
    deepest: u32,
    cancel: &Cancel,
) -> Option<TechniqueImages> {
    let options = Options { max_depth: Some(options.max_depth.map_or(deepest, |most| most.min(deepest))), ..*options };
    let units = prelude(scene, camera, &options, layout).units;
    let layout = Layout::new(layout.width, layout.height, Some(layout.crop), &[]);
    let recorder = Recorder {
        samples: Samples::new(camera.clone(), &options),
        method: Bidirectional::new(scene, camera, &options, &Prelude::default()),
        layout: layout.clone(),
        options,
    };
    let mut shelf = Shelf::new(&techniques(&options, deepest).collect::<Vec<_>>(), &layout, units.radiance);
    let film = Film::new(layout, options.replicates, options.seed, units);
    let image = |&(s, t): &(usize, usize)| TechniqueImage { s, t, weighted: film.clone(), unweighted: film.clone() };
    let mut found = TechniqueImages { images: shelf.names.iter().map(image).collect(), report: PassReport::default() };
    for pass in passes {
        found.report.absorb(recorder.samples.of_pass(pass, Pass { all: &recorder, pass, cancel, shelf: &shelf })?);
        shelf.commit(pass, &mut found.images);
    }
    Some(found)
}

/// Where the light of one pass is collected, by technique: weighted and not.
struct Shelf {
    names: Vec<(usize, usize)>,
    films: Vec<[PassFilm; 2]>,
}

impl Shelf {
    fn new(names: &[(usize, usize)], layout: &Layout, unit: f64) -> Self {
        let film = || PassFilm::new(layout).with_unit(unit);
        Shelf { names: names.to_vec(), films: names.iter().map(|_| [film(), film()]).collect() }
    }

    /// Where the light of a technique goes.
    #[inline]
    fn of(&self, s: usize, t: usize) -> Option<&[PassFilm; 2]> {
        let at = self.names.iter().position(|&name| name == (s, t))?;
        Some(&self.films[at])
    }

    /// Moves what was collected to the images.
    fn commit(&mut self, pass: u64, images: &mut [TechniqueImage]) {
        for (films, image) in self.films.iter_mut().zip(images) {
            for (film, sum) in films.iter_mut().zip([&mut image.weighted, &mut image.unweighted]) {
                film.fold_splats();
                sum.commit(pass, film);
                film.clear();
            }
        }
    }
}

/// What all passes share.
struct Recorder<'a> {
    samples: Samples,
    method: Bidirectional<'a>,
    layout: Layout,
    options: Options,
}

/// One pass in work.
struct Pass<'p, 'a> {
    all: &'p Recorder<'a>,
    pass: u64,
    cancel: &'p Cancel,
    shelf: &'p Shelf,
}

impl Work for Pass<'_, '_> {
    type Output = Option<PassReport>;

    fn run<P: Sampler>(self, source: impl Fn(u64) -> P + Sync) -> Option<PassReport> {
        let pixels = self.all.layout.pixels();
        let chunk = |chunk: usize| chunk * CHUNK..((chunk + 1) * CHUNK).min(pixels);
        let chunks = (0..pixels.div_ceil(CHUNK)).into_par_iter();
        gather(chunks.map(|at| (!self.cancel.requested()).then(|| self.chunk(chunk(at), &source))))
    }
}

impl Pass<'_, '_> {
    /// Renders the pixels of a range.
    fn chunk<P: Sampler>(&self, pixels: std::ops::Range<usize>, source: &impl Fn(u64) -> P) -> PassReport {
        let Recorder { samples, method, layout, options } = self.all;
        let (mut report, mut tally) = (PassReport::default(), Tally::default());
        let address = Address::new(options.seed).with(self.pass);
        for at in pixels {
            let Sample { pixel, index, ray, mut numbers } = samples.of_pixel(layout, at, source);
            let centre = pixel.map(|x| x as f32 + 0.5);
            let mut sink = Recording { shelf: self.shelf, options, centre, key: address.with(index), valid: true };
            method.sample(ray, &mut numbers, || Samples::of_light(index, source), &mut sink, &mut tally);
            if !sink.valid {
                report.drop_sample(InvalidSample { pass: self.pass, x: pixel[0], y: pixel[1] });
            }
        }
        report.add_tally(&tally);
        report
    }
}

/// A sample whose light is told apart by technique.
struct Recording<'a> {
    shelf: &'a Shelf,
    options: &'a Options,
    /// Of the pixel, on the film.
    centre: [f32; 2],
    /// Address of the rounding.
    key: Address,
    /// Whether all that was found was finite.
    valid: bool,
}

impl Recording<'_> {
    /// Adds to the images of a technique: a box around the centre of a pixel is the pixel.
    #[inline]
    fn record(&mut self, [s, t]: [usize; 2], filter: Filter, film: [f32; 2], [weighted, unweighted]: [Spectrum; 2]) {
        let Some(films) = self.shelf.of(s, t) else { return };
        self.key = self.key.with(0);
        for (i, (film_of, value)) in films.iter().zip([weighted, unweighted]).enumerate() {
            if !value.is_finite() {
                self.valid = false;
            } else if !value.is_black() {
                film_of.splats().add(filter, film, value, self.key.bits(i as u64));
            }
        }
    }
}

impl Sink for Recording<'_> {
    #[inline]
    fn add(&mut self, Found { s, t, value, weight, .. }: Found) {
        self.record([s, t], Filter::Box, self.centre, [value * weight as f32, value]);
    }

    #[inline]
    fn splat(&mut self, film: [f32; 2], Found { s, value, weight, .. }: Found) {
        // Splats are per walk from a light, and a pass has as many as pixels.
        let per_walk = (self.options.pixels() as f32).recip();
        self.record([s, 1], self.options.filter, film, [value * weight as f32 * per_walk, value * per_walk]);
    }
}
