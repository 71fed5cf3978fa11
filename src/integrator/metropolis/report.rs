//! What chains say of themselves: which kernels were accepted, how far the normalisation is known, how parts of the image were visited.

use super::contribution::Region;
use crate::film::{Filter, Layout};
use crate::mcmc::KernelCounts;
use crate::spectrum::Spectrum;
use std::collections::BTreeMap;

/// Tiles along an axis of the image at most.
const TILES: usize = 16;
/// A tile of whose light one chain has more than this share is owned by it.
const OWNED: f64 = 0.5;

/// The chains of one or more passes.
#[derive(Debug, Clone, Default, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct ChainReport {
    /// How many.
    pub chains: u64,
    /// Their steps.
    pub steps: u64,
    /// Seeds that were dark when their chain began: the light of their chains is missing.
    pub lost_seeds: u64,
    /// What became of proposals, by kernel.
    pub kernels: BTreeMap<String, KernelCounts>,
    /// The mean contribution of each pass's samples, which scales all that its chains deposit.
    pub normalisation: Normalisation,
    /// Parts of the image.
    pub tiles: Tiles,
}

/// A [`ChainReport`] in a few numbers.
#[derive(Debug, Clone, PartialEq, serde::Serialize)]
pub struct ChainDigest {
    /// How many chains.
    pub chains: u64,
    /// Their steps.
    pub steps: u64,
    /// See [`ChainReport::lost_seeds`].
    pub lost_seeds: u64,
    /// What became of proposals, by kernel.
    pub kernels: BTreeMap<String, KernelCounts>,
    /// See [`ChainReport::scale_error`].
    pub scale_error: Option<f64>,
    /// Split-R̂ of tiles between chains: of the usual tile and of the worst. Chains that stay near their seeds have a large one; their seeds
    /// then stand for the mixing.
    pub r_hat: Option<[f64; 2]>,
    /// Independent steps that would have done as well: for the usual tile and the worst.
    pub effective_steps: Option<[f64; 2]>,
    /// Tiles that chains brought light to.
    pub lit_tiles: usize,
    /// Tiles most of whose light one chain brought: nothing is known of their error.
    pub owned_tiles: usize,
}

/// Sums over passes of what scales them.
#[derive(Debug, Clone, Copy, Default, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct Normalisation {
    /// Passes.
    pub passes: u64,
    /// Of their means.
    pub sum: f64,
    /// Of the squares of their means.
    pub square: f64,
}

/// Parts of the image and how chains visited them. All vectors row by row.
#[derive(Debug, Clone, Default, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct Tiles {
    /// Tiles in a row.
    pub columns: usize,
    /// Light that chains deposited.
    pub light: Vec<f64>,
    /// The most that a single chain did.
    pub largest: Vec<f64>,
    /// Variance of a step's deposit within half a chain.
    pub within: Vec<f64>,
    /// Variance of the means of half chains.
    pub between: Vec<f64>,
    /// Variance of `light` if steps were independent.
    pub independent: Vec<f64>,
    /// Variance of `light`, as far as half chains are independent.
    pub correlated: Vec<f64>,
}

impl ChainReport {
    /// Of a chain whose seed was dark.
    pub(super) fn lost_seed() -> Self {
        ChainReport { chains: 1, lost_seeds: 1, ..Self::default() }
    }

    /// Of a chain.
    pub(super) fn of_chain(names: &[&'static str], counts: &[KernelCounts], steps: usize) -> Self {
        let kernels = names.iter().zip(counts).map(|(name, counts)| ((*name).to_string(), *counts)).collect();
        ChainReport { chains: 1, steps: steps as u64, kernels, ..Self::default() }
    }

    /// Of a pass before its chains.
    pub(super) fn of_pass(mean: f64, layout: &Layout) -> Self {
        let normalisation = Normalisation { passes: 1, sum: mean, square: mean * mean };
        ChainReport { normalisation, tiles: Tiles::new(Grid::new(layout)), ..Self::default() }
    }

    /// Adds another chain or other passes.
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

    /// All in a few numbers, beside an image whose pixels are `image` together: radiance, the mean over lanes.
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

    /// Half the 95 % interval of what the scale that all light of chains has in common adds to an image or takes from it, relative to the
    /// image; `None` for fewer than two passes.
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

/// The median and the largest, or the smallest where little is bad.
fn usual_and_last(values: impl Iterator<Item = f64>, little_is_bad: bool) -> Option<[f64; 2]> {
    let mut sorted: Vec<f64> = values.collect();
    sorted.sort_by(f64::total_cmp);
    let worst = if little_is_bad { sorted.first() } else { sorted.last() };
    Some([sorted[sorted.len().checked_sub(1)? / 2], *worst?])
}

impl Tiles {
    /// 1 for each pixel of `layout` in an owned tile, 0 elsewhere.
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

    /// Adds the chains of one class of a pass, all of one length.
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
            // Both of the sum over all steps.
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

    /// Whether each tile owes more than half of what chains brought to a single one: nothing is then known of its error.
    pub fn owned(&self) -> impl Iterator<Item = bool> + '_ {
        self.light.iter().zip(&self.largest).map(|(&light, &largest)| light > 0.0 && largest > OWNED * light)
    }

    /// How many independent steps, of `steps` in all, would have told each lit tile's light as well.
    pub fn effective_steps(&self, steps: u64) -> impl Iterator<Item = f64> + '_ {
        let lit = |&(_, &correlated): &(&f64, &f64)| correlated > 0.0;
        let pairs = self.independent.iter().zip(&self.correlated).filter(lit);
        pairs.map(move |(independent, correlated)| steps as f64 * independent / correlated)
    }

    /// The potential scale reduction of each lit tile, from halves of chains [Gelman13 §11.4].
    pub fn r_hats(&self) -> impl Iterator<Item = f64> + '_ {
        let pairs = self.within.iter().zip(&self.between).filter(|&(&within, _)| within > 0.0);
        pairs.map(|(within, between)| (1.0 + between / within).sqrt())
    }
}

/// The tiles of an image; what falls around it belongs to those at its border.
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

/// What a chain deposits by tile.
pub(super) struct ChainLight {
    grid: Grid,
    /// Steps of half the chain.
    half: usize,
    done: f64,
    halves: [Vec<f64>; 2],
    /// Of each step's deposit.
    squares: Vec<f64>,
}

impl ChainLight {
    pub(super) fn new(layout: &Layout, steps: usize) -> Self {
        let grid = Grid::new(layout);
        let zeros = || vec![0.0; grid.columns * grid.rows];
        ChainLight { grid, half: steps / 2, done: 0.0, halves: [zeros(), zeros()], squares: zeros() }
    }

    /// Adds `weight` steps at which `color` fell at a film position, multiplied by `scale`.
    pub(super) fn add(&mut self, film: [f32; 2], color: Spectrum, weight: f64, scale: f64) {
        let light = f64::from(color.mean()) * scale;
        let (tile, half) = (self.grid.tile(film), usize::from(self.done >= self.half as f64));
        self.halves[half][tile] += weight * light;
        self.squares[tile] += weight * light * light;
    }

    /// `weight` steps are over.
    pub(super) fn pass(&mut self, weight: f64) {
        self.done += weight;
    }
}
