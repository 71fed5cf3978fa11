//! Tile statistics of a picture, stored as an attribute of its image. Tests need them if pixels share samples, since
//! the error of a tile's mean does not follow from the pixel errors then. The attribute is JSON with base64 of
//! little-endian f32. For each smallest tile and channel it holds the mean of each replicate. For independent pixels it
//! holds the mean, its standard error, the degrees of freedom of the latter, and the cube root of its third cumulant.
//! The tiles are those of [`smallest_tiles`].

use super::sum::{Parts, Replicates, Sum};
use super::tiles::{CHANNELS, Level, Pyramid, Tile, smallest_tiles};
use crate::film::{Crop, Independent};
use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use serde::{Deserialize, Serialize};

/// Name of the attribute.
pub const RECORD: &str = "etendue.tiles";

/// Content of the attribute.
#[derive(Serialize, Deserialize)]
struct Record {
    independent: Independent,
    /// Share of each replicate in all passes.
    shares: Vec<f32>,
    /// Base64 of f32.
    values: String,
}

/// Numbers per sum over independent pixels.
const OF_PIXELS: usize = 4;

/// Encodes the record of a picture.
pub fn encode(pyramid: &Pyramid) -> String {
    let values =
        pyramid.levels[0].tiles.iter().flat_map(|tile| tile.sums.iter().flat_map(|sum| numbers(sum, tile, pyramid)));
    let bytes: Vec<u8> = values.flat_map(f32::to_le_bytes).collect();
    let shares = pyramid.replicates.shares().iter().map(|&share| share as f32).collect();
    serde_json::json!(Record { independent: pyramid.independent, shares, values: STANDARD.encode(bytes) }).to_string()
}

fn numbers(sum: &Sum, tile: &Tile, pyramid: &Pyramid) -> Vec<f32> {
    match sum {
        Sum::Pixels(_) => {
            let mean = sum.estimate(tile.pixels, &pyramid.replicates);
            let third = sum.third(tile.pixels, &pyramid.replicates).cbrt();
            [mean.value, mean.standard_error, mean.dof, third].map(|x| x as f32).to_vec()
        }
        Sum::Splats { by_replicate, .. } | Sum::Chains(by_replicate) => {
            by_replicate.iter().map(|sum| (sum / tile.pixels) as f32).collect()
        }
    }
}

/// Decodes the record of an image with window `crop`; `None` if the record is damaged.
pub fn decode(record: &str, crop: Crop) -> Option<Pyramid> {
    let Record { independent, shares, values } = serde_json::from_str(record).ok()?;
    let replicates = Replicates::of_shares(&shares)?;
    let bytes = STANDARD.decode(values).ok()?;
    let values: Vec<f64> =
        bytes.chunks_exact(4).map(|b| f64::from(f32::from_le_bytes([b[0], b[1], b[2], b[3]]))).collect();
    let each = if independent == Independent::Pixels { OF_PIXELS } else { replicates.count() };
    let (columns, areas) = smallest_tiles(crop);
    let is_whole = bytes.len() == 4 * values.len() && areas.len().checked_mul(CHANNELS * each) == Some(values.len());
    if !is_whole || values.iter().any(|v| !v.is_finite()) {
        return None;
    }
    let mut numbers = values.chunks_exact(each);
    let mut tiles = Vec::with_capacity(areas.len());
    for area in areas {
        let mut sums = Vec::with_capacity(CHANNELS);
        for numbers in numbers.by_ref().take(CHANNELS) {
            sums.push(sum(numbers, independent, area.pixels() as f64, &replicates)?);
        }
        tiles.push(Tile::new(area, sums.try_into().ok()?));
    }
    Some(Pyramid::upon(crop, independent, replicates, Level { columns, tiles }))
}

/// Reconstructs the sum over `pixels` pixels from its numbers.
fn sum(numbers: &[f64], independent: Independent, pixels: f64, replicates: &Replicates) -> Option<Sum> {
    if let (Independent::Pixels, &[mean, error, dof, third]) = (independent, numbers) {
        let variance = (error * pixels).powi(2);
        let squares = replicates.dof() * variance * variance / dof;
        let parts = Parts { value: mean * pixels, variance, squares, third: (third * pixels).powi(3) };
        return (error >= 0.0 && dof > 0.0).then_some(Sum::Pixels(parts));
    }
    let mut sum = Sum::new(independent, replicates);
    let sums: Vec<f64> = numbers.iter().map(|mean| mean * pixels).collect();
    sum.add_pixel(&sums, replicates);
    sum.finish(replicates);
    Some(sum)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::stats::test_random::Random;
    use std::cell::RefCell;

    const CROP: Crop = Crop { x0: 3, y0: 1, x1: 40, y1: 20 };

    fn pyramid(independent: Independent, passes: &[u64]) -> Pyramid {
        let random = RefCell::new(Random::new(1));
        Pyramid::new(CROP, independent, Replicates::of(passes).unwrap(), |_, _, means| {
            let mut random = random.borrow_mut();
            means.clear();
            means.extend(passes.iter().map(|_| random.exponential()));
        })
    }

    /// All inputs of the tests survive, up to the f32 rounding of a few operations.
    #[test]
    fn record_round_trip_preserves_tested_statistics() {
        for independent in [Independent::Pixels, Independent::Blocks, Independent::Replicates] {
            let before = pyramid(independent, &[3, 3, 2, 2, 2]);
            let after = decode(&encode(&before), CROP).unwrap();
            for (a, b) in before.levels.iter().zip(&after.levels) {
                for (x, y) in a.tiles.iter().zip(&b.tiles) {
                    assert_eq!((x.area, x.pixels.to_bits()), (y.area, y.pixels.to_bits()));
                    for channel in 0..CHANNELS {
                        let (p, q) = (before.estimate(x, channel), after.estimate(y, channel));
                        let (s, t) = (before.third(x, channel), after.third(y, channel));
                        let scale = p.standard_error.powi(3);
                        assert!((p.value - q.value).abs() < 1e-6 * p.value, "{independent:?} {p:?} {q:?}");
                        assert!(
                            (p.standard_error / q.standard_error - 1.0).abs() < 1e-5,
                            "{independent:?} {p:?} {q:?}"
                        );
                        assert!(
                            (p.dof / q.dof - 1.0).abs() < 1e-5 && (s - t).abs() < 1e-4 * scale,
                            "{independent:?} {s} {t}"
                        );
                    }
                }
            }
        }
    }

    #[test]
    fn damaged_records_are_none() {
        let record = encode(&pyramid(Independent::Replicates, &[1; 5]));
        assert!(decode(&record, CROP).is_some());
        assert!(decode(&record, Crop { x1: 60, ..CROP }).is_none());
        for cut in 0..record.len() {
            assert!(decode(&record[..cut], CROP).is_none());
        }
        for (from, to) in [("replicates", "pixels"), ("[0.2", "[-0.2"), ("[0.2", "[0.0,0.2"), ("[0.2", "[null,0.2")] {
            assert!(decode(&record.replacen(from, to, 1), CROP).is_none(), "{from} as {to}");
        }
    }
}
