//! TEMP stand-in until branch `film` is merged.
#![allow(missing_docs)]
use super::{ImageError, Layout, PassSet, Plane, RelMse};
use crate::error::{Error, Result};

#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct Units {
    pub radiance: f64,
    pub length: f64,
}
#[derive(Debug)]
pub struct PassFilm {
    pub values: Vec<i64>,
}
impl PassFilm {
    pub fn new(layout: &Layout) -> Self {
        PassFilm { values: vec![0; layout.pixels() * layout.channels()] }
    }
    pub fn clear(&mut self) {
        self.values.fill(0);
    }
}
#[derive(Debug, serde::Serialize, serde::Deserialize)]
pub struct Film {
    layout: Layout,
    seed: u64,
    units: Units,
    passes: PassSet,
    sums: Vec<Vec<i64>>,
    counts: Vec<u64>,
}
impl Film {
    pub fn new(layout: Layout, replicates: u32, seed: u64, units: Units) -> Self {
        let n = layout.pixels() * layout.channels();
        let r = replicates as usize;
        Film { layout, seed, units, passes: PassSet::default(), sums: vec![vec![0; n]; r], counts: vec![0; r] }
    }
    pub fn bytes_per_pixel(layout: &Layout, replicates: u32) -> usize {
        layout.channels() * replicates as usize * 8
    }
    pub fn commit(&mut self, pass: u64, film: &PassFilm) {
        let r = (pass % self.sums.len() as u64) as usize;
        for (a, b) in self.sums[r].iter_mut().zip(&film.values) {
            *a += b;
        }
        self.counts[r] += 1;
        self.passes.insert(pass);
    }
    pub fn merge(&mut self, other: &Film) -> Result<()> {
        if self.layout != other.layout || self.seed != other.seed || self.units != other.units {
            return Err(Error::usage("films differ"));
        }
        for p in other.passes.iter() {
            if self.passes.contains(p) {
                return Err(Error::usage(format!("pass {p} twice")));
            }
            self.passes.insert(p);
        }
        for r in 0..self.sums.len() {
            for (a, b) in self.sums[r].iter_mut().zip(&other.sums[r]) {
                *a += b;
            }
            self.counts[r] += other.counts[r];
        }
        Ok(())
    }
    pub fn passes(&self) -> &PassSet {
        &self.passes
    }
    pub fn mean(&self, plane: Plane) -> Vec<f32> {
        let (c, o) = (self.layout.channels(), self.layout.offset(plane).unwrap_or(0));
        let n = self.counts.iter().sum::<u64>().max(1) as f64;
        (0..self.layout.pixels() * plane.channels())
            .map(|i| (i / plane.channels()) * c + o + i % plane.channels())
            .map(|i| (self.sums.iter().map(|s| s[i]).sum::<i64>() as f64 / n / 65536.0) as f32)
            .collect()
    }
    pub fn standard_error(&self) -> Option<Vec<f32>> {
        (self.sums.len() > 1 && self.counts.iter().all(|&c| c > 0)).then(|| vec![0.01; self.layout.pixels() * 3])
    }
    pub fn image_error(&self) -> Option<ImageError> {
        self.standard_error()?;
        Some(ImageError {
            relmse: RelMse { value: 0.01, low: 0.009, high: 0.011 },
            rmse: 0.1,
            mean: 0.5,
            mean_standard_error: 0.001,
            epsilon: 0.01,
            replicates: self.sums.len() as u32,
        })
    }
    pub fn pixel_hash(&self) -> String {
        let mut h = blake3::Hasher::new();
        for s in &self.sums {
            for v in s {
                h.update(&v.to_le_bytes());
            }
        }
        h.finalize().to_hex().to_string()
    }
}
