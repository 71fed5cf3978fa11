//! State of a batch: live paths side by side, and the shadow rays of one bounce.

use crate::geometry::{PADDING, Ray, RayState, Rays};
use crate::light::{LightSampleContext, Receivers};
use crate::path::{PreviousVertex, RandomWalk};
use crate::sampling::{Density, Pdf};
use crate::scene::Scene;
use crate::spectrum::{LANES, Spectrum};
use crate::transport::ScatteringOutline;
use etendue_lanes::Float;
use glam::Vec3;

/// Live paths after the same number of scattering events.
pub(super) struct Paths {
    /// Current edges.
    pub(super) rays: Rays,
    /// Throughputs.
    pub(super) beta: [Vec<f32>; LANES],
    /// Densities of the directions.
    pub(super) pdf: Vec<f32>,
    /// Positions of the departure vertices.
    pub(super) from: [Vec<f32>; 3],
    /// Normals of the departure vertices.
    pub(super) from_ng: [Vec<f32>; 3],
    /// Keys of the random numbers.
    pub(super) keys: Vec<u64>,
    /// Places of the pixels in the batch.
    pub(super) pixels: Vec<u32>,
    /// What only some surfaces change; empty in a scene without such surfaces.
    pub(super) rare: Vec<Rare>,
    /// Scattering at the departure vertices; empty if the selection of lights does not depend on it.
    pub(super) outlines: Vec<ScatteringOutline>,
}

/// State that not every scene needs.
#[derive(Debug, Clone, Copy)]
pub(super) struct Kept {
    /// See [`Paths::rare`].
    pub(super) rare: bool,
    /// See [`Paths::outlines`].
    pub(super) outlines: bool,
}

/// State of a path that surfaces with a kernel leave as it is.
#[derive(Debug, Clone, Copy)]
pub(super) struct Rare {
    /// See [`RandomWalk::scale`].
    pub(super) scale: f32,
    /// See [`RandomWalk::straight`].
    pub(super) straight: bool,
    /// Whether the direction is a Dirac one, and its density a probability.
    pub(super) delta: bool,
    /// State of the ray.
    pub(super) state: RayState,
}

impl Rare {
    /// State of a path in empty space that has not met such a surface.
    pub(super) const NONE: Rare = Rare { scale: 1.0, straight: false, delta: false, state: RayState::INITIAL };
}

/// Returns arrays with room for `capacity` values each.
fn columns<const N: usize>(capacity: usize) -> [Vec<f32>; N] {
    [(); N].map(|()| vec![0.0; capacity + PADDING])
}

fn vector(columns: &[Vec<f32>; 3], at: usize) -> Vec3 {
    Vec3::new(columns[0][at], columns[1][at], columns[2][at])
}

impl Paths {
    /// Returns room for `capacity` paths.
    pub(super) fn new(capacity: usize, kept: Kept) -> Self {
        Paths {
            rays: Rays::new(capacity),
            beta: columns(capacity),
            pdf: vec![0.0; capacity + PADDING],
            from: columns(capacity),
            from_ng: columns(capacity),
            keys: vec![0; capacity + PADDING],
            pixels: vec![0; capacity + PADDING],
            rare: if kept.rare { vec![Rare::NONE; capacity + PADDING] } else { Vec::new() },
            outlines: if kept.outlines { vec![ScatteringOutline::UNKNOWN; capacity + PADDING] } else { Vec::new() },
        }
    }

    /// Returns the number of paths.
    #[inline]
    pub(super) fn len(&self) -> usize {
        self.rays.len()
    }

    /// Returns the receivers from which a group of paths departs.
    #[inline(always)]
    pub(super) fn receivers<F: Float>(&self, at: usize) -> Receivers<'_, F> {
        let [p, ng] = [&self.from, &self.from_ng].map(|columns| etendue_lanes::Vec3::load(columns, at));
        Receivers { p, ng, outlines: self.outlines.get(at..).and_then(|rest| rest.first_chunk()) }
    }

    /// Appends the path of `walk`.
    #[inline]
    pub(super) fn push(&mut self, walk: &RandomWalk, key: u64, pixel: u32) {
        let at = self.len();
        self.rays.push(&walk.ray);
        (0..LANES).for_each(|lane| self.beta[lane][at] = walk.beta[lane]);
        (self.keys[at], self.pixels[at]) = (key, pixel);
        let mut delta = false;
        if let PreviousVertex::Scattered(LightSampleContext { p, ng, scattering }, density) = walk.departure {
            self.pdf[at] = density.value();
            delta = density.is_delta();
            for axis in 0..3 {
                (self.from[axis][at], self.from_ng[axis][at]) = (p[axis], ng[axis]);
            }
            if let Some(outline) = self.outlines.get_mut(at) {
                *outline = scattering;
            }
        }
        if let Some(rare) = self.rare.get_mut(at) {
            *rare = Rare { scale: walk.scale(), straight: walk.straight, delta, state: walk.ray.state };
        }
    }

    /// Returns path number `at` as a walk after `depth` scattering events.
    #[inline]
    pub(super) fn walk<'a>(&self, scene: &'a Scene, at: usize, depth: u32) -> RandomWalk<'a> {
        let rare = self.rare.get(at).copied().unwrap_or(Rare { straight: depth == 0, ..Rare::NONE });
        let departure = if depth == 0 {
            PreviousVertex::Camera
        } else {
            let from = LightSampleContext::new(vector(&self.from, at), vector(&self.from_ng, at));
            let from = self.outlines.get(at).map_or(from, |&outline| from.scattering(outline));
            let pdf = self.pdf[at];
            let density = if rare.delta { Density::Delta(pdf) } else { Density::Smooth(Pdf::new(pdf)) };
            PreviousVertex::Scattered(from, density)
        };
        let beta = Spectrum(std::array::from_fn(|lane| self.beta[lane][at]));
        let ray: Ray = self.rays.ray(at).carrying(rare.state);
        RandomWalk::resumed(scene, ray, beta, departure, depth, (rare.straight, rare.scale))
    }
}

/// Shadow rays with the light that each carries to its pixel.
pub(super) struct Shadows {
    /// The rays.
    pub(super) rays: Rays,
    /// Contributions.
    pub(super) light: [Vec<f32>; LANES],
    /// Places of the pixels in the batch.
    pub(super) pixels: Vec<u32>,
}

impl Shadows {
    /// Returns room for `capacity` rays.
    pub(super) fn new(capacity: usize) -> Self {
        Shadows { rays: Rays::new(capacity), light: columns(capacity), pixels: vec![0; capacity + PADDING] }
    }

    /// Appends a ray that carries `light` to the pixel at `pixel`.
    #[inline]
    pub(super) fn push(&mut self, ray: &Ray, light: Spectrum, pixel: u32) {
        let at = self.rays.len();
        self.rays.push(ray);
        (0..LANES).for_each(|lane| self.light[lane][at] = light[lane]);
        self.pixels[at] = pixel;
    }

    /// Returns the contribution of ray number `at`.
    #[inline]
    pub(super) fn light(&self, at: usize) -> Spectrum {
        Spectrum(std::array::from_fn(|lane| self.light[lane][at]))
    }
}
