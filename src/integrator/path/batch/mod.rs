//! `path` in batches: the paths of many pixels go from bounce to bounce together. Rays are traced in packets, cache
//! misses of different paths overlap, and kernels do the work of eight paths at once.
//!
//! A bounce has three stages: rays find their hits, vertices get light and send paths on, shadow rays are traced. All
//! paths of a batch have the same depth. Each adds to its own pixel in the order in which a single path would, by the
//! same operations in every lane, so that films have the bits of the scalar [`super::PathTracer`] for any number of
//! lanes, size of batches and width of packets.
//!
//! Not for scenes with surfaces on edges (blends, panes, nested bodies), contacts or absorption: see [`knows`].

mod lane_sets;
mod lights;
mod objects;
mod paths;
mod points;
mod surfaces;
#[cfg(test)]
mod tests;
mod vertices;

use super::{Combined, PathTracer};
use crate::accel::{Coherence, RayClass};
use crate::camera::Camera;
use crate::film::{Layout, Splats};
use crate::geometry::{Hits, PADDING, RayState};
use crate::integrator::camera_pass::{Chunks, SampleRecord};
use crate::integrator::samples::{PassNumbers, Sample, Samples};
use crate::integrator::{IntegratorConfig, PassReport};
use crate::path::{RandomWalk, TraceStats};
use crate::scene::Scene;
use crate::spectrum::Spectrum;
use etendue_lanes::{Float, Int, Long, MOST_LANES, Native, filled};
use lights::LightRows;
use objects::Objects;
use paths::{Kept, Paths, Rare, Shadows};
use std::marker::PhantomData;
use std::ops::Range;
use std::sync::Mutex;
use surfaces::VaryingSurfaces;

/// Largest number of paths in a batch.
const LARGEST: usize = 1024;

/// Least number of paths in a batch, and what their number is a multiple of.
const SMALLEST: usize = 32;

/// Size of an acceleration structure, in bytes, up to which the hint that camera rays are coherent pays: on the Cornell
/// box it multiplies their rate by 2.9, and on two million triangles by .87. Shadow rays of camera hits lose by it.
const CACHED: usize = 16 << 20;

/// Batches of a pass per thread, for load balance.
const BATCHES_PER_THREAD: usize = 4;

/// Whether a scene can be rendered in batches.
pub(in crate::integrator) fn knows(scene: &Scene) -> bool {
    let features = scene.features();
    !(features.content() || features.contacts || features.media)
}

/// The batched path tracer, with kernels of as many lanes as `F` has.
pub(in crate::integrator) struct BatchedPath<'a, F: Float = Native> {
    tracer: PathTracer<'a, Combined>,
    samples: Samples,
    options: IntegratorConfig,
    objects: Objects<'a>,
    kept: Kept,
    lights: LightRows,
    /// That of camera rays.
    coherence: Coherence,
    /// Number of paths in a batch; `None` for the best one.
    size: Option<usize>,
    /// Batches that no task uses at the moment.
    idle: Mutex<Vec<Batch>>,
    lanes: PhantomData<F>,
}

/// State of a batch in a task.
struct Batch {
    paths: Paths,
    next: Paths,
    shadows: Shadows,
    hits: Hits,
    occluded: Vec<bool>,
    /// Light of each pixel.
    colors: Vec<Spectrum>,
    varying: VaryingSurfaces,
    capacity: usize,
}

impl Batch {
    fn new(capacity: usize, kept: Kept) -> Self {
        Batch {
            paths: Paths::new(capacity, kept),
            next: Paths::new(capacity, kept),
            shadows: Shadows::new(capacity),
            hits: Hits::new(capacity),
            occluded: vec![false; capacity + PADDING],
            colors: vec![Spectrum::ZERO; capacity],
            varying: VaryingSurfaces::new(),
            capacity,
        }
    }
}

impl<'a, F: Float> BatchedPath<'a, F> {
    pub(in crate::integrator) fn new(scene: &'a Scene, camera: Camera, options: &IntegratorConfig) -> Self {
        let objects = Objects::new(scene);
        BatchedPath {
            tracer: PathTracer::new(scene, options.max_depth, options.transparent),
            samples: Samples::new(camera, options),
            options: *options,
            kept: Kept { rare: objects.has_rare(), outlines: scene.lights().is_by_receiver() },
            objects,
            lights: LightRows::new(scene.lights()),
            coherence: if scene.accel().bytes() < CACHED { Coherence::Coherent } else { Coherence::Incoherent },
            size: None,
            idle: Mutex::new(Vec::new()),
            lanes: PhantomData,
        }
    }

    /// Returns an idle batch of `capacity` paths, or a new one.
    fn batch(&self, capacity: usize) -> Batch {
        let idle = self.idle.lock().ok().and_then(|mut idle| idle.pop());
        idle.filter(|batch| batch.capacity >= capacity).unwrap_or_else(|| Batch::new(capacity, self.kept))
    }

    /// Starts a path in each of `pixels`.
    fn begin(&self, batch: &mut Batch, layout: &Layout, pixels: Range<usize>, numbers: impl PassNumbers) {
        let Batch { paths, colors, .. } = batch;
        colors.fill(Spectrum::ZERO);
        paths.rays.set_len(0);
        let mut rest = layout.pixels_from(pixels.start).take(pixels.len());
        let mut group = [[0; 2]; MOST_LANES];
        loop {
            let count = group.iter_mut().take(F::LANES).zip(&mut rest).map(|(to, pixel)| *to = pixel).count();
            if count == 0 || !self.start(paths, layout, &group[..count], numbers) {
                break;
            }
        }
        for place in paths.len()..pixels.len() {
            let Sample { camera, index, .. } = self.samples.of_pixel(layout, pixels.start + place, numbers);
            let walk = RandomWalk::from_camera(self.tracer.scene, &camera);
            paths.push(&walk, numbers.keys(index), place as u32);
        }
    }

    /// Appends paths from `pixels`, at most as many as there are lanes, to `paths`; returns whether the camera has a
    /// kernel.
    #[inline(always)]
    fn start(&self, paths: &mut Paths, layout: &Layout, pixels: &[[u32; 2]], numbers: impl PassNumbers) -> bool {
        let of = |lane: usize| pixels[lane.min(pixels.len() - 1)];
        let indices = filled([0; MOST_LANES], |lane| layout.index(of(lane)));
        let keys = numbers.keys(F::Long::load(&indices, 0));
        let position = |axis: usize| F::from_fn(|lane| of(lane)[axis] as f32);
        let position = [position(0), position(1)];
        let Some(([origin, direction], medium)) = self.samples.camera_rays(position, &mut numbers.of_keys(keys)) else {
            return false;
        };
        let at = paths.len();
        let all = F::first(F::LANES);
        origin.pack(all, &mut paths.rays.origin, at);
        direction.pack(all, &mut paths.rays.direction, at);
        F::splat(f32::INFINITY).store(&mut paths.rays.t_max, at);
        Spectrum::<F>::in_lanes(Spectrum::ONE).pack(all, &mut paths.beta, at);
        keys.store(&mut paths.keys, at);
        F::Int::from_fn(|lane| (at + lane) as u32).store(&mut paths.pixels, at);
        if !paths.rare.is_empty() {
            let bodies = medium.unwrap_or_else(|| self.tracer.scene.bodies_at(origin.lane(0).into()));
            let rare = Rare { straight: true, state: RayState::INITIAL.within(bodies), ..Rare::NONE };
            paths.rare[at..at + pixels.len()].fill(rare);
        }
        paths.rays.set_len(at + pixels.len());
        true
    }

    /// Traces all paths of `batch` to their ends.
    fn trace(&self, batch: &mut Batch, numbers: impl PassNumbers, tally: &mut TraceStats) {
        let scene = self.tracer.scene;
        for depth in 0.. {
            if batch.paths.len() == 0 {
                break;
            }
            let (class, count, coherence) = match depth {
                0 => (RayClass::Camera, &mut tally.cameras, self.coherence),
                _ => (RayClass::Bounce(depth), &mut tally.bounces, Coherence::Incoherent),
            };
            *count += batch.paths.len() as u64;
            scene.accel().announce(class);
            scene.intersect_all(&batch.paths.rays, coherence, &mut batch.hits);
            self.vertices(batch, depth, numbers, tally);
            scene.accel().announce(RayClass::Shadow);
            tally.shadows += batch.shadows.rays.len() as u64;
            scene.occluded_all(&batch.shadows.rays, Coherence::Incoherent, &mut batch.occluded);
            batch.add_light();
            std::mem::swap(&mut batch.paths, &mut batch.next);
        }
    }
}

impl Batch {
    /// Adds the light of the shadow rays that nothing blocks to the pixels.
    fn add_light(&mut self) {
        for at in 0..self.shadows.rays.len() {
            if !self.occluded[at] {
                self.colors[self.shadows.pixels[at] as usize] += self.shadows.light(at);
            }
        }
    }
}

impl<F: Float> Chunks for BatchedPath<'_, F> {
    fn samples(&self) -> &Samples {
        &self.samples
    }

    fn chunk_size(&self, pixels: usize) -> usize {
        self.size.unwrap_or_else(|| batch_size(pixels, rayon::current_num_threads()))
    }

    fn chunk(
        &self,
        pass: u64,
        layout: &Layout,
        (first, out): (usize, &mut [f32]),
        _: &Splats,
        numbers: impl PassNumbers,
    ) -> PassReport {
        let pixels = out.len() / layout.channels();
        let mut record = SampleRecord::new(self.tracer.scene, &self.options, layout, pass);
        let mut batch = self.batch(pixels);
        self.begin(&mut batch, layout, first..first + pixels, numbers);
        self.trace(&mut batch, numbers, &mut record.tally);
        let values = out.chunks_exact_mut(layout.channels());
        for ((place, values), pixel) in values.enumerate().zip(layout.pixels_from(first)) {
            record.put(pixel, batch.colors[place], true, values);
            if record.has_features() {
                record.features(&mut self.samples.of_pixel(layout, first + place, numbers), values);
            }
        }
        if let Ok(mut idle) = self.idle.lock() {
            idle.push(batch);
        }
        record.finish()
    }
}

/// Returns the number of paths in a batch, for a pass of `pixels` on `threads` threads.
fn batch_size(pixels: usize, threads: usize) -> usize {
    let even = pixels.div_ceil(threads * BATCHES_PER_THREAD).next_multiple_of(SMALLEST);
    even.clamp(SMALLEST, LARGEST)
}
