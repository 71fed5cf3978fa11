//! Images of the individual techniques of bidirectional path tracing, for all numbers of vertices s from the light and
//! t from the camera, weighted and unweighted [Veach97 figure 10.4].
//!
//! They show the strengths of techniques and serve to validate them. The weighted images sum to the render of the same
//! passes, since samples use the same addresses; with connection roulette in the render this holds in the mean. All
//! unweighted images of one path length have the same expectation, each with its own noise. Every connection is traced,
//! because roulette by weighted contribution would distort the unweighted images.
//!
//! Limits: [`IntegratorConfig::clamp`] is not applied. A nonfinite value is dropped alone, not with its whole sample.
//! Light that no technique of a length can sample is in none of its images.

use super::bidirectional::{Bidirectional, Sink, TechniqueSample};
use super::camera_pass::{CHUNK, gather};
use super::samples::{PassNumbers, Sample, Samples, Work};
use super::{IntegratorConfig, InvalidSample, PassReport, PilotEstimate, pilot};
use crate::camera::Camera;
use crate::film::{Film, Filter, Layout, PassFilm};
use crate::parallel::Cancel;
use crate::path::TraceStats;
use crate::sampling::Address;
use crate::scene::Scene;
use crate::spectrum::Spectrum;
use rayon::prelude::*;

/// Image of one technique.
#[derive(Debug, Clone)]
pub struct TechniqueImage {
    /// Vertices from the light.
    pub s: usize,
    /// Vertices from the camera.
    pub t: usize,
    /// MIS-weighted contribution to the render.
    pub weighted: Film,
    /// Unweighted estimate of the technique alone.
    pub unweighted: Film,
}

impl TechniqueImage {
    /// Number of scattering events of its paths.
    pub fn events(&self) -> usize {
        self.s + self.t - 2
    }
}

/// Images of all techniques.
#[derive(Debug, Clone)]
pub struct TechniqueImages {
    /// Ordered by path length, then by s.
    pub images: Vec<TechniqueImage>,
    /// Rays traced and guards that fired.
    pub report: PassReport,
}

impl TechniqueImages {
    /// Returns the image of `s` light vertices and `t` camera vertices, if the technique is enabled.
    pub fn get(&self, s: usize, t: usize) -> Option<&TechniqueImage> {
        self.images.iter().find(|image| (image.s, image.t) == (s, t))
    }

    /// Returns the memory required by [`technique_images`], in bytes per pixel.
    pub fn bytes_per_pixel(options: &IntegratorConfig, deepest: u32) -> usize {
        let layout = Layout::new(1, 1, None, &[]);
        let pass = layout.channels() * (size_of::<f32>() + size_of::<i64>());
        let images = 2 * techniques(options, deepest).count();
        images * (Film::bytes_per_pixel(&layout, options.replicates) + pass)
    }
}

/// Enumerates the enabled techniques of paths with at most `deepest` scattering events.
fn techniques(options: &IntegratorConfig, deepest: u32) -> impl Iterator<Item = (usize, usize)> {
    let (techniques, deepest) =
        (options.method.bdpt().techniques, options.max_depth.map_or(deepest, |most| most.min(deepest)));
    let all = (0..=deepest as usize).flat_map(|events| (0..=events + 1).map(move |s| (s, events + 2 - s)));
    all.filter(move |&(s, t)| techniques.has(s, t))
}

/// Renders the images of all techniques of bidirectional path tracing over `passes`, for paths of at most `deepest`
/// scattering events; `None` if it was cancelled. Like those of a film, sums are kept by replicate (pass mod
/// [`IntegratorConfig::replicates`]) and do not depend on order or threads.
pub fn technique_images(
    scene: &Scene,
    camera: &Camera,
    options: &IntegratorConfig,
    layout: &Layout,
    passes: impl IntoIterator<Item = u64>,
    deepest: u32,
    cancel: &Cancel,
) -> Option<TechniqueImages> {
    let options =
        IntegratorConfig { max_depth: Some(options.max_depth.map_or(deepest, |most| most.min(deepest))), ..*options };
    let units = pilot(scene, camera, &options, layout).units;
    let layout = Layout::new(layout.width, layout.height, Some(layout.crop), &[]);
    let recorder = Recorder {
        samples: Samples::new(camera.clone(), &options),
        method: Bidirectional::new(scene, camera, &options, &PilotEstimate::default()),
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

/// Films of one pass by technique: weighted and unweighted.
struct Shelf {
    names: Vec<(usize, usize)>,
    films: Vec<[PassFilm; 2]>,
}

impl Shelf {
    fn new(names: &[(usize, usize)], layout: &Layout, unit: f64) -> Self {
        let film = || PassFilm::new(layout).with_unit(unit);
        Shelf { names: names.to_vec(), films: names.iter().map(|_| [film(), film()]).collect() }
    }

    /// Returns the films of a technique.
    #[inline]
    fn of(&self, s: usize, t: usize) -> Option<&[PassFilm; 2]> {
        let at = self.names.iter().position(|&name| name == (s, t))?;
        Some(&self.films[at])
    }

    /// Commits the pass to the images and clears the films.
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

/// State shared by all passes.
struct Recorder<'a> {
    samples: Samples,
    method: Bidirectional<'a>,
    layout: Layout,
    options: IntegratorConfig,
}

/// State of a running pass.
struct Pass<'p, 'a> {
    all: &'p Recorder<'a>,
    pass: u64,
    cancel: &'p Cancel,
    shelf: &'p Shelf,
}

impl Work for Pass<'_, '_> {
    type Output = Option<PassReport>;

    fn run(self, numbers: impl PassNumbers) -> Option<PassReport> {
        let pixels = self.all.layout.pixels();
        let chunk = |chunk: usize| chunk * CHUNK..((chunk + 1) * CHUNK).min(pixels);
        let chunks = (0..pixels.div_ceil(CHUNK)).into_par_iter();
        gather(chunks.map(|at| (!self.cancel.requested()).then(|| self.chunk(chunk(at), numbers))))
    }
}

impl Pass<'_, '_> {
    /// Renders the pixels of a range.
    fn chunk<N: PassNumbers>(&self, pixels: std::ops::Range<usize>, of: N) -> PassReport {
        let Recorder { samples, method, layout, options } = self.all;
        let (mut report, mut tally) = (PassReport::default(), TraceStats::default());
        let address = Address::new(options.seed).with(self.pass);
        for at in pixels {
            let Sample { pixel, index, camera, mut numbers } = samples.of_pixel(layout, at, of);
            let centre = pixel.map(|x| x as f32 + 0.5);
            let mut sink = Recording { shelf: self.shelf, options, centre, key: address.with(index), valid: true };
            method.sample(&camera, &mut numbers, || of.of_light(index), &mut sink, &mut tally);
            if !sink.valid {
                report.drop_sample(InvalidSample { pass: self.pass, x: pixel[0], y: pixel[1] });
            }
        }
        report.add_tally(&tally);
        report
    }
}

/// A sink that separates a sample by technique.
struct Recording<'a> {
    shelf: &'a Shelf,
    options: &'a IntegratorConfig,
    /// Centre of the pixel on the film.
    centre: [f32; 2],
    /// Address of the rounding.
    key: Address,
    /// Whether all contributions were finite.
    valid: bool,
}

impl Recording<'_> {
    /// Adds to the images of a technique. A box filter around the centre of a pixel covers that pixel alone.
    #[inline]
    fn record(&mut self, [s, t]: [usize; 2], filter: Filter, film: [f32; 2], [weighted, unweighted]: [Spectrum; 2]) {
        let Some(films) = self.shelf.of(s, t) else { return };
        self.key = self.key.with(0);
        for (i, (film_of, value)) in films.iter().zip([weighted, unweighted]).enumerate() {
            if !value.is_finite() {
                self.valid = false;
            } else if !value.is_black() {
                film_of.splats().queue(filter).add(film, value, self.key.bits(i as u64));
            }
        }
    }
}

impl Sink for Recording<'_> {
    #[inline]
    fn add(&mut self, TechniqueSample { s, t, value, weight, .. }: TechniqueSample) {
        self.record([s, t], Filter::Box, self.centre, [value * weight as f32, value]);
    }

    #[inline]
    fn splat(&mut self, film: [f32; 2], TechniqueSample { s, value, weight, .. }: TechniqueSample) {
        // Splats are normalised per light subpath; a pass has one for each pixel.
        let per_walk = (self.options.pixels() as f32).recip();
        self.record([s, 1], self.options.filter, film, [value * weight as f32 * per_walk, value * per_walk]);
    }
}
