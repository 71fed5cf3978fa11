//! Chain diagnostics: acceptance by kernel, error of the normalisation, and coverage of image tiles.

use super::contribution::Region;
use crate::film::{Filter, Layout};
use crate::mcmc::KernelCounts;
use crate::spectrum::Spectrum;
use std::collections::BTreeMap;

/// Maximum number of tiles along an image axis.
const TILES: usize = 16;
/// A chain owns a tile if it contributes more than this share of the tile's light.
const OWNED: f64 = 0.5;

/// Diagnostics of the chains of one or more passes.
#[derive(Debug, Clone, Default, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct ChainReport {
    /// Number of chains.
    pub chains: u64,
    /// Their steps.
    pub steps: u64,
    /// Seeds with zero contribution when their chain began: the light of these chains is missing.
    pub lost_seeds: u64,
    /// Proposal counts, by kernel.
    pub kernels: BTreeMap<String, KernelCounts>,
    /// Mean contribution of each pass's samples, which scales all deposits of its chains.
    pub normalisation: Normalisation,
    /// Statistics by image tile.
    pub tiles: Tiles,
}

/// Summary of a [`ChainReport`].
#[derive(Debug, Clone, PartialEq, serde::Serialize)]
pub struct ChainDigest {
    /// Number of chains.
    pub chains: u64,
    /// Their steps.
    pub steps: u64,
    /// See [`ChainReport::lost_seeds`].
    pub lost_seeds: u64,
    /// Proposal counts, by kernel.
    pub kernels: BTreeMap<String, KernelCounts>,
    /// See [`ChainReport::scale_error`].
    pub scale_error: Option<f64>,
    /// Split-R̂ of tiles between chains: median and maximum. It is large if chains stay near their seeds; the sampling
    /// of seeds then substitutes for mixing.
    pub r_hat: Option<[f64; 2]>,
    /// Effective number of independent steps: median and minimum over tiles.
    pub effective_steps: Option<[f64; 2]>,
    /// Tiles with deposits.
    pub lit_tiles: usize,
    /// Tiles in which one chain contributed most of the light: their error is unknown.
    pub owned_tiles: usize,
}

/// Sums over passes of the normalisation.
#[derive(Debug, Clone, Copy, Default, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct Normalisation {
    /// Number of passes.
    pub passes: u64,
    /// Sum of their means.
    pub sum: f64,
    /// Sum of the squares of their means.
    pub square: f64,
}

/// Statistics by image tile. All vectors are in row-major order.
#[derive(Debug, Clone, Default, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct Tiles {
    /// Tiles in a row.
    pub columns: usize,
    /// Light deposited by chains.
    pub light: Vec<f64>,
    /// Maximum contribution of a single chain.
    pub largest: Vec<f64>,
    /// Variance of a step's deposit within half a chain.
    pub within: Vec<f64>,
    /// Variance of the means of half chains.
    pub between: Vec<f64>,
    /// Variance of `light` under independent steps.
    pub independent: Vec<f64>,
    /// Variance of `light`, estimated from half chains taken as independent.
    pub correlated: Vec<f64>,
}

impl ChainReport {
    /// Report of a chain with a dark seed.
    pub(super) fn lost_seed() -> Self {
        ChainReport { chains: 1, lost_seeds: 1, ..Self::default() }
    }

    /// Report of one chain.
    pub(super) fn of_chain(names: &[&'static str], counts: &[KernelCounts], steps: usize) -> Self {
        let kernels = names.iter().zip(counts).map(|(name, counts)| ((*name).to_string(), *counts)).collect();
        ChainReport { chains: 1, steps: steps as u64, kernels, ..Self::default() }
    }

    /// Report of a pass before its chains.
    pub(super) fn of_pass(mean: f64, layout: &Layout) -> Self {
        let normalisation = Normalisation { passes: 1, sum: mean, square: mean * mean };
        ChainReport { normalisation, tiles: Tiles::new(Grid::new(layout)), ..Self::default() }
    }

    /// Merges the report of another chain or of other passes.
    pub(crate) fn absorb(&mut self, other: ChainReport) {
        self.chains += other.chains;
        self.steps += other.steps;
        self.lost_seeds += other.lost_seeds;
        for (name, counts) in other.kernels {
            self.kernels.entry(name).or_default().absorb(&counts);
        }
        self.normalisation.passes += other.normalisation.passes;
        self.normalisation.sum += other.normalisation.sum;
        self.normalisation.square += other.normalisation.square;
        self.tiles.absorb(other.tiles);
    }

    /// Summarises the report. `image` is the sum of all pixels: radiance, mean over lanes.
    pub fn digest(&self, image: f64) -> ChainDigest {
        ChainDigest {
            chains: self.chains,
            steps: self.steps,
            lost_seeds: self.lost_seeds,
            kernels: self.kernels.clone(),
            scale_error: self.scale_error(image),
            r_hat: usual_and_last(self.tiles.r_hats(), false),
            effective_steps: usual_and_last(self.tiles.effective_steps(self.steps), true),
            lit_tiles: self.tiles.light.iter().filter(|&&light| light > 0.0).count(),
            owned_tiles: self.tiles.owned().filter(|&owned| owned).count(),
        }
    }

    /// Returns half the 95 % interval of the error from the common scale of the chains, relative to the image; `None`
    /// for fewer than two passes.
    pub fn scale_error(&self, image: f64) -> Option<f64> {
        let Normalisation { passes, sum, square } = self.normalisation;
        let n = passes as f64;
        let mean = sum / n;
        let variance = ((square - n * mean * mean) / (n - 1.0)).max(0.0);
        let share = self.tiles.light.iter().sum::<f64>() / (n * image);
        (passes > 1 && mean > 0.0 && image > 0.0)
            .then(|| share * crate::stats::student_quantile(0.975, n - 1.0) * (variance / n).sqrt() / mean)
    }
}

/// Returns the median, and the maximum or, if `little_is_bad`, the minimum.
fn usual_and_last(values: impl Iterator<Item = f64>, little_is_bad: bool) -> Option<[f64; 2]> {
    let mut sorted: Vec<f64> = values.collect();
    sorted.sort_by(f64::total_cmp);
    let worst = if little_is_bad { sorted.first() } else { sorted.last() };
    Some([sorted[sorted.len().checked_sub(1)? / 2], *worst?])
}

impl Tiles {
    /// Returns 1 for each pixel of `layout` in an owned tile, 0 elsewhere.
    pub fn owned_pixels(&self, layout: &Layout) -> Vec<f32> {
        let (grid, owned): (Grid, Vec<bool>) = (Grid::new(layout), self.owned().collect());
        let centre = |i: usize| layout.pixel(i).map(|x| x as f32 + 0.5);
        let of = |i: usize| owned.get(grid.tile(centre(i))).is_some_and(|&owned| owned);
        (0..layout.pixels()).map(|i| f32::from(u8::from(of(i)))).collect()
    }

    fn new(grid: Grid) -> Self {
        let zeros = || vec![0.0; grid.columns * grid.rows];
        let [light, largest, within, between, independent, correlated] = std::array::from_fn(|_| zeros());
        Tiles { columns: grid.columns, light, largest, within, between, independent, correlated }
    }

    /// Adds the chains of one class of a pass, all of the same length.
    pub(super) fn add_class(&mut self, chains: &[&ChainLight]) {
        let Some(first) = chains.first() else { return };
        let (n, half) = (chains.len() as f64, first.half as f64);
        if first.half == 0 {
            return;
        }
        for tile in 0..self.light.len() {
            let halves = || chains.iter().flat_map(|chain| chain.halves.iter().map(|h| h[tile] / half));
            let mean = halves().sum::<f64>() / (2.0 * n);
            let between = halves().map(|h| (h - mean).powi(2)).sum::<f64>() / (2.0 * n - 1.0);
            let square = chains.iter().map(|chain| chain.squares[tile]).sum::<f64>() / (2.0 * n * half);
            let total = (square - mean * mean).max(0.0);
            self.light[tile] += mean * 2.0 * n * half;
            self.within[tile] += (total - between).max(0.0);
            self.between[tile] += between;
            // Both are variances of the sum over all steps.
            self.independent[tile] += total * 2.0 * n * half;
            self.correlated[tile] += between * 2.0 * n * half * half;
            let most = chains.iter().map(|chain| chain.halves[0][tile] + chain.halves[1][tile]).fold(0.0, f64::max);
            self.largest[tile] = self.largest[tile].max(most);
        }
    }

    fn absorb(&mut self, other: Tiles) {
        if self.light.is_empty() {
            *self = other;
            return;
        }
        let add = |a: &mut [f64], b: &[f64]| a.iter_mut().zip(b).for_each(|(a, b)| *a += b);
        add(&mut self.light, &other.light);
        add(&mut self.within, &other.within);
        add(&mut self.between, &other.between);
        add(&mut self.independent, &other.independent);
        add(&mut self.correlated, &other.correlated);
        self.largest.iter_mut().zip(&other.largest).for_each(|(a, &b)| *a = a.max(b));
    }

    /// Whether a single chain contributed more than half of each tile's light: the error of such a tile is unknown.
    pub fn owned(&self) -> impl Iterator<Item = bool> + '_ {
        self.light.iter().zip(&self.largest).map(|(&light, &largest)| light > 0.0 && largest > OWNED * light)
    }

    /// Returns the effective number of independent steps, of `steps` in total, for each lit tile.
    pub fn effective_steps(&self, steps: u64) -> impl Iterator<Item = f64> + '_ {
        let lit = |&(_, &correlated): &(&f64, &f64)| correlated > 0.0;
        let pairs = self.independent.iter().zip(&self.correlated).filter(lit);
        pairs.map(move |(independent, correlated)| steps as f64 * independent / correlated)
    }

    /// Returns the potential scale reduction of each lit tile, from halves of chains [Gelman13 §11.4].
    pub fn r_hats(&self) -> impl Iterator<Item = f64> + '_ {
        let pairs = self.within.iter().zip(&self.between).filter(|&(&within, _)| within > 0.0);
        pairs.map(|(within, between)| (1.0 + between / within).sqrt())
    }
}

/// Tiles of an image. Positions outside the image belong to the border tiles.
#[derive(Debug, Clone, Copy)]
struct Grid {
    image: Region,
    columns: usize,
    rows: usize,
}

impl Grid {
    fn new(layout: &Layout) -> Self {
        let crop = layout.crop;
        let [columns, rows] = [crop.x1 - crop.x0, crop.y1 - crop.y0].map(|n| (n as usize).min(TILES));
        Grid { image: Region::new(crop, Filter::Box), columns, rows }
    }

    fn tile(&self, film: [f32; 2]) -> usize {
        self.image.cell(film, [self.columns, self.rows])
    }
}

/// Deposits of a chain by tile.
pub(super) struct ChainLight {
    grid: Grid,
    /// Steps of half the chain.
    half: usize,
    done: f64,
    halves: [Vec<f64>; 2],
    /// Sum of squares of each step's deposit.
    squares: Vec<f64>,
}

impl ChainLight {
    pub(super) fn new(layout: &Layout, steps: usize) -> Self {
        let grid = Grid::new(layout);
        let zeros = || vec![0.0; grid.columns * grid.rows];
        ChainLight { grid, half: steps / 2, done: 0.0, halves: [zeros(), zeros()], squares: zeros() }
    }

    /// Adds a deposit of `color` times `scale` at a raster position for `weight` steps.
    pub(super) fn add(&mut self, film: [f32; 2], color: Spectrum, weight: f64, scale: f64) {
        let light = f64::from(color.mean()) * scale;
        let (tile, half) = (self.grid.tile(film), usize::from(self.done >= self.half as f64));
        self.halves[half][tile] += weight * light;
        self.squares[tile] += weight * light * light;
    }

    /// Advances by `weight` steps.
    pub(super) fn pass(&mut self, weight: f64) {
        self.done += weight;
    }
}
