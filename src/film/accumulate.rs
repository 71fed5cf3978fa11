//! The film: exact integer sums of every plane, one set per replicate. Integer addition is associative, so that the
//! order of passes and merges does not change any bit. The image is therefore independent of threads, shards and
//! resumption.
//!
//! Values are quantised to [`Units`] by unbiased stochastic rounding, with a hash of (seed, pass, pixel, channel) as
//! its random number. Values that are not finite or reach 2¹⁸⁰ units count as zero and in [`Film::dropped`];
//! integrators filter them beforehand.

use super::max_samples::Peaks;
use super::sums::{Spill, Sums, add_rounded};
use super::{FilmHeader, Layout, PassFilm, PassSet, Plane, Units};
use crate::error::Result;
use crate::sampling::mix64;
use rayon::prelude::*;

/// Exact sums of every plane over passes, by replicate.
#[derive(Debug, Clone, PartialEq)]
pub struct Film {
    head: FilmHeader,
    /// By replicate; values are pixel-interleaved like those of a pass.
    sums: Vec<Sums>,
    peaks: Peaks,
}

/// Quantisation of one channel.
struct Channel {
    /// 2³² / unit.
    scale: f64,
    /// Odd, so that its product with a uniform hash of the pixel is uniform. Independent of the planes in the layout.
    hash_factor: u64,
}

impl Film {
    /// Returns an empty film. `seed` is the seed of the render; it also seeds the rounding.
    ///
    /// # Panics
    /// If `replicates` is 0, or a unit is not a power of two within 2^±[`Units::MAX_EXPONENT`].
    pub fn new(layout: Layout, replicates: u32, seed: u64, units: Units) -> Self {
        assert!(replicates > 0 && units.exponents().is_some(), "{replicates} replicates, {units:?}");
        Film::empty(FilmHeader { layout, replicates, seed, units, passes: PassSet::new(), dropped: 0 })
    }

    /// Returns a film with all sums zero, whatever passes `head` lists.
    pub(crate) fn empty(head: FilmHeader) -> Self {
        let sums = (0..head.replicates).map(|_| Sums::new(head.values())).collect();
        Film { peaks: Peaks::new(head.layout.pixels()), sums, head }
    }

    /// Adds a pass to replicate pass mod R. Committing a pass twice is a caller's bug. A release build then leaves the
    /// film unchanged, since the same pass has the same values.
    ///
    /// # Panics
    /// If the pass has another layout or the index `u64::MAX`.
    pub fn commit(&mut self, pass: u64, values: &PassFilm) {
        assert!(*values.layout() == self.head.layout, "a pass of another layout");
        let is_new = self.head.passes.insert(pass);
        debug_assert!(is_new, "pass {pass} was committed twice");
        if !is_new || values.values().is_empty() {
            return;
        }
        let channels = self.channels();
        let key = mix64(self.head.seed ^ mix64(pass.wrapping_add(0x6669_6c6d)));
        let row = (self.head.layout.crop.x1 - self.head.layout.crop.x0) as usize * channels.len();
        let layout = &self.head.layout;
        let sums = &mut self.sums[(pass % u64::from(self.head.replicates)) as usize];
        let rows = sums.low_mut().par_chunks_mut(row).zip(values.values().par_chunks(row)).enumerate();
        let spill = rows.map(|(y, (sums, values))| add_row(sums, values, y, layout, &channels, key));
        let spill = spill.reduce(Spill::default, Spill::join);
        debug_assert!(spill.dropped == 0, "pass {pass} has {} values that are not finite or too large", spill.dropped);
        self.head.dropped += spill.dropped;
        sums.carry(spill.carries);
        self.peaks.add(pass, values.values(), channels.len());
    }

    /// Adds all passes of another film of the same render.
    ///
    /// # Errors
    /// See [`FilmHeader::admits`]; this film is then unchanged.
    pub fn merge(&mut self, other: &Film) -> Result<()> {
        self.head.absorb(&other.head)?;
        self.sums.iter_mut().zip(&other.sums).for_each(|(a, b)| a.merge(b));
        self.peaks.merge(&other.peaks);
        Ok(())
    }

    /// Returns the mean of a plane over all samples of all replicates: the exact sum times the unit over the number of
    /// passes. Pixels are row by row within the crop, channels interleaved. [`Plane::Invalid`] is the sum. Depth and
    /// position are divided by the coverage; they are 0 where the coverage is 0. The mean is zero without passes, and
    /// empty if the layout lacks the plane.
    pub fn mean(&self, plane: Plane) -> Vec<f32> {
        let Some(offset) = self.head.layout.offset(plane) else { return Vec::new() };
        let (stride, unit) = (self.head.layout.channels(), self.head.units.of(plane));
        let coverage =
            self.head.layout.offset(Plane::Alpha).filter(|_| matches!(plane, Plane::Depth | Plane::Position));
        let divisor = |pixel: usize| match (plane, coverage) {
            (Plane::Invalid, _) => 1.0,
            (_, Some(alpha)) => self.total(pixel * stride + alpha) * self.head.units.of(Plane::Alpha),
            _ => self.head.passes.len() as f64,
        };
        let channels = plane.channels();
        let mut mean = vec![0.0; self.head.layout.pixels() * channels];
        mean.par_chunks_mut(channels).enumerate().with_min_len(1024).for_each(|(pixel, out)| {
            let divisor = divisor(pixel);
            if divisor > 0.0 {
                for (c, value) in out.iter_mut().enumerate() {
                    *value = (self.total(pixel * stride + offset + c) * unit / divisor) as f32;
                }
            }
        });
        mean
    }

    /// Returns the mean colour of one replicate, which is independent of the other replicates. Pixels are row by row
    /// within the crop, channels interleaved. The mean is zero without passes.
    ///
    /// # Panics
    /// If there is no such replicate.
    pub fn mean_of(&self, replicate: u32) -> Vec<f64> {
        let (sums, stride) = (&self.sums[replicate as usize], self.head.layout.channels());
        // Colour is the first plane of every layout. max(1) avoids 0/0 without passes.
        let scale = self.head.units.of(Plane::Color) / self.passes_of(replicate).max(1) as f64;
        let pixels = 0..self.head.layout.pixels();
        pixels.flat_map(|p| (0..Plane::Color.channels()).map(move |c| sums.value(p * stride + c) * scale)).collect()
    }

    /// Returns the set of passes in the film.
    pub fn passes(&self) -> &PassSet {
        &self.head.passes
    }

    /// Returns the number of replicates.
    pub fn replicates(&self) -> u32 {
        self.head.replicates
    }

    /// Returns the number of passes of a replicate.
    pub fn passes_of(&self, replicate: u32) -> u64 {
        self.head.passes.count_congruent(u64::from(replicate), u64::from(self.head.replicates))
    }

    /// Returns the pixels and planes of the film.
    pub fn layout(&self) -> &Layout {
        &self.head.layout
    }

    /// Returns the quantisation units of the sums.
    pub fn units(&self) -> Units {
        self.head.units
    }

    /// Returns the seed of the render.
    pub fn seed(&self) -> u64 {
        self.head.seed
    }

    /// Returns the number of values that were not finite or too large. They count as zero. Nonzero only if an
    /// integrator has a defect.
    pub fn dropped(&self) -> u64 {
        self.head.dropped
    }

    /// Returns the memory of sums and largest samples, in bytes per pixel.
    pub fn bytes_per_pixel(layout: &Layout, replicates: u32) -> usize {
        layout.channels() * replicates as usize * size_of::<i64>() + size_of::<u64>()
    }

    /// Returns everything but the sums.
    pub fn head(&self) -> &FilmHeader {
        &self.head
    }

    /// Returns everything but the sums, for adding the sums of other passes.
    pub(crate) fn head_mut(&mut self) -> &mut FilmHeader {
        &mut self.head
    }

    /// The sums by replicate.
    pub(crate) fn sums(&self) -> &[Sums] {
        &self.sums
    }

    /// The largest sample of each pixel.
    pub(crate) fn peaks(&self) -> &Peaks {
        &self.peaks
    }

    /// The sums by replicate.
    pub(crate) fn sums_mut(&mut self) -> &mut [Sums] {
        &mut self.sums
    }

    /// The largest sample of each pixel.
    pub(crate) fn peaks_mut(&mut self) -> &mut Peaks {
        &mut self.peaks
    }

    /// Units of the sum over all replicates.
    pub(super) fn total(&self, index: usize) -> f64 {
        Sums::total(self.sums.iter().map(|sums| (sums, index)))
    }

    fn channels(&self) -> Vec<Channel> {
        let channel = |plane: Plane, c: usize| Channel {
            scale: 4_294_967_296.0 / self.head.units.of(plane),
            hash_factor: mix64(plane as u64 * 4 + c as u64 + 1) | 1,
        };
        self.head
            .layout
            .planes()
            .iter()
            .flat_map(|&plane| (0..plane.channels()).map(move |c| channel(plane, c)))
            .collect()
    }
}

/// Adds row `y` of the crop. The rounding hash uses the pixel's index in the full image, so that a crop rounds like the
/// full image.
fn add_row(sums: &mut [i64], values: &[f32], y: usize, layout: &Layout, channels: &[Channel], key: u64) -> Spill {
    let mut spill = Spill::default();
    let first = (u64::from(layout.crop.y0) + y as u64) * u64::from(layout.width) + u64::from(layout.crop.x0);
    let row = y as u64 * values.len() as u64;
    let n = channels.len();
    for (x, (sums, values)) in sums.chunks_exact_mut(n).zip(values.chunks_exact(n)).enumerate() {
        let hash = mix64(key ^ (first + x as u64).wrapping_mul(0x9e37_79b9_7f4a_7c15));
        let index = row + (x * n) as u64;
        for c in 0..n {
            let scaled = f64::from(values[c]) * channels[c].scale;
            add_rounded(&mut sums[c], scaled, hash.wrapping_mul(channels[c].hash_factor), index + c as u64, &mut spill);
        }
    }
    spill
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::film::Crop;
    use crate::stats::test_random::Random;

    fn units() -> Units {
        Units::from_exponents(-24, -20).unwrap()
    }

    fn noise(layout: &Layout, pass: u64) -> PassFilm {
        let mut random = Random::new(pass + 1);
        let mut film = PassFilm::new(layout);
        let count = layout.pixels() * layout.channels();
        let values: Vec<f32> =
            (0..count).map(|_| (random.exponential() * 2_f64.powf(8.0 * random.normal())) as f32).collect();
        film.par_chunks(1).for_each(|(p, out)| out.copy_from_slice(&values[p * out.len()..][..out.len()]));
        film
    }

    fn commit_all(layout: &Layout, passes: impl Iterator<Item = u64>) -> Film {
        let mut film = Film::new(layout.clone(), 4, 11, units());
        passes.for_each(|pass| film.commit(pass, &noise(layout, pass)));
        film
    }

    #[test]
    fn film_is_independent_of_pass_order_and_sharding() {
        let layout = Layout::new(13, 9, None, &[Plane::Depth, Plane::Normal, Plane::Invalid]);
        let whole = commit_all(&layout, 0..16);
        assert_eq!(commit_all(&layout, (0..16).rev()), whole);
        let shard = |i: u64| commit_all(&layout, (0..16).filter(move |k| k % 3 == i));
        let mut merged = shard(2);
        merged.merge(&shard(0)).unwrap();
        merged.merge(&shard(1)).unwrap();
        assert_eq!(merged, whole);
        let one_thread = rayon::ThreadPoolBuilder::new().num_threads(1).build().unwrap();
        assert_eq!(one_thread.install(|| commit_all(&layout, 0..16)), whole);
    }

    /// A crop has exactly the sums of the full film.
    #[test]
    fn crop_rounds_like_the_full_image() {
        let full = Layout::new(6, 5, None, &[]);
        let crop = Layout::new(6, 5, Some(Crop { x0: 2, y0: 1, x1: 5, y1: 4 }), &[Plane::Alpha]);
        let (mut a, mut b) = (Film::new(full.clone(), 1, 5, units()), Film::new(crop.clone(), 1, 5, units()));
        let (mut pa, mut pb) = (PassFilm::new(&full), PassFilm::new(&crop));
        pa.par_chunks(1).for_each(|(_, v)| v.fill(0.123_456_79));
        pb.par_chunks(1).for_each(|(_, v)| v.fill(0.123_456_79));
        a.commit(3, &pa);
        b.commit(3, &pb);
        for pixel in 0..crop.pixels() {
            let [x, y] = crop.pixel(pixel);
            let whole = &a.sums[0].low()[(y * 6 + x) as usize * 3..][..3];
            assert_eq!(&b.sums[0].low()[pixel * 4..][..3], whole);
        }
    }

    /// The mean of 64 passes equals the exact mean of their values within rounding: 5 σ of 64 × unit²/4 (level 6e-7 per
    /// value, 6e-4 for all), plus half an ulp of f32.
    #[test]
    fn film_mean_is_the_average_of_added_values() {
        let layout = Layout::new(16, 8, None, &[Plane::Albedo]);
        let passes: Vec<PassFilm> = (0..64).map(|k| noise(&layout, k)).collect();
        let mut film = Film::new(layout.clone(), 4, 1, units());
        passes.iter().enumerate().for_each(|(k, pass)| film.commit(k as u64, pass));
        let mean = film.mean(Plane::Albedo);
        for (i, &found) in mean.iter().enumerate() {
            let at = i / 3 * 6 + 3 + i % 3;
            let exact = passes.iter().map(|p| f64::from(p.values()[at])).sum::<f64>() / 64.0;
            let bound = 5.0 * units().of(Plane::Albedo) * 0.5 / 8.0 + exact * f64::from(f32::EPSILON);
            assert!((f64::from(found) - exact).abs() < bound, "{found} {exact}");
        }
    }

    /// The means of replicates of equal size average to the image mean: their sums are exact, so that only the image is
    /// rounded, to f32.
    #[test]
    fn replicates_have_their_share_of_the_mean() {
        let layout = Layout::new(5, 3, None, &[Plane::Normal]);
        let film = commit_all(&layout, 0..8);
        let means: Vec<_> = (0..4).map(|r| film.mean_of(r)).collect();
        for (i, &mean) in film.mean(Plane::Color).iter().enumerate() {
            let found = means.iter().map(|m| m[i]).sum::<f64>() / 4.0;
            assert!((found - f64::from(mean)).abs() <= f64::from(f32::EPSILON) * found, "{found} {mean}");
        }
        assert!(commit_all(&layout, 1..4).mean_of(0).iter().all(|m| m.to_bits() == 0));
    }

    #[test]
    fn depth_is_per_coverage_and_invalid_is_a_sum() {
        let layout = Layout::new(2, 1, None, &[Plane::Depth, Plane::Invalid]);
        let mut film = Film::new(layout.clone(), 2, 0, units());
        assert!(film.mean(Plane::Depth).iter().all(|v| v.to_bits() == 0));
        for pass in 0..4 {
            let mut values = PassFilm::new(&layout);
            let covered = f32::from(pass % 2 == 0);
            values
                .par_chunks(2)
                .for_each(|(_, v)| v[..6].copy_from_slice(&[1.0, 1.0, 1.0, covered, 6.0 * covered, 1.0]));
            film.commit(pass, &values);
        }
        assert_eq!(film.mean(Plane::Depth), [6.0, 0.0]);
        assert_eq!(film.mean(Plane::Invalid), [4.0, 0.0]);
        assert_eq!(film.mean(Plane::Alpha), [0.5, 0.0]);
        assert!(film.mean(Plane::Normal).is_empty());
    }

    #[test]
    fn merge_refuses_films_of_other_renders() {
        let layout = Layout::new(2, 2, None, &[]);
        let film = |layout: &Layout, r, seed, unit, pass| {
            let mut film = Film::new(layout.clone(), r, seed, Units { radiance: unit, length: 1.0 });
            film.commit(pass, &PassFilm::new(layout));
            film
        };
        let mut base = film(&layout, 2, 1, 1.0, 0);
        let before = base.clone();
        for (other, word) in [
            (film(&Layout::new(2, 3, None, &[]), 2, 1, 1.0, 1), "size"),
            (film(&layout, 3, 1, 1.0, 1), "replicates"),
            (film(&layout, 2, 2, 1.0, 1), "seed"),
            (film(&layout, 2, 1, 0.5, 1), "units"),
            (film(&layout, 2, 1, 1.0, 0), "both hold pass 0"),
        ] {
            let message = base.merge(&other).unwrap_err().to_string();
            assert!(message.contains(word), "{message}");
            assert_eq!(base, before);
        }
        base.merge(&film(&layout, 2, 1, 1.0, 7)).unwrap();
        assert_eq!((base.passes().to_string().as_str(), base.passes_of(0), base.passes_of(1)), ("0,7", 1, 1));
    }
}
