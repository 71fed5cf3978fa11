//! Primary sample space: the unit cube of a sampler's random numbers, with as many dimensions as it uses [Kelemen02].
//!
//! A point has a coordinate for each address used in its evaluation, and no other. Coordinates are created lazily.
//! Unused ones are resampled each step. This is valid since control flow depends only on coordinates already used:
//! unused coordinates are then uniform and independent of all others. A proposal perturbs the coordinates that the
//! current point uses, and draws new ones where it does not. No coordinate needs a lazy update, or a restore after
//! rejection.

use super::SmallStep;
use crate::sampling::{Address, SLOTS, Sampler, Slot, unit_f32};
use std::collections::BTreeMap;

/// Purpose of a random number. Each stream has its own addresses, so that a longer subpath from one end does not shift
/// the random numbers of the other.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[repr(usize)]
pub enum PrimaryStream {
    /// Camera subpath, including samples at its vertices.
    Camera,
    /// Light subpath.
    Light,
    /// Connection of the two.
    Connection,
}

const STREAMS: usize = 3;

/// Addresses below this bound are stored in an array, which ordinary walks never leave. Others, such as those of
/// connection roulette, are stored in a map.
const SIDE_BY_SIDE: u64 = 1 << 16;

/// Kind of proposal.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Step {
    /// Resamples every coordinate.
    Large,
    /// Perturbs each coordinate.
    Small(SmallStep),
}

/// A coordinate and the epoch of the evaluation that last used it.
#[derive(Debug, Clone, Copy, Default)]
struct Cell {
    value: u32,
    epoch: u32,
}

/// Coordinates of one stream, by address.
#[derive(Debug, Clone, Default)]
struct Cells {
    near: Vec<Cell>,
    far: BTreeMap<u64, Cell>,
}

impl Cells {
    fn get(&self, index: u64) -> Option<&Cell> {
        if index < SIDE_BY_SIDE { self.near.get(index as usize) } else { self.far.get(&index) }
    }

    /// Returns the cell of an address, created on first use.
    fn at(&mut self, index: u64) -> &mut Cell {
        if index >= SIDE_BY_SIDE {
            return self.far.entry(index).or_default();
        }
        let near = index as usize;
        if near >= self.near.len() {
            self.near.resize(near + 1, Cell::default());
        }
        &mut self.near[near]
    }
}

/// Point in primary sample space: the random numbers used in its evaluation.
#[derive(Debug, Clone, Default)]
pub struct PrimaryPoint {
    streams: [Cells; STREAMS],
    epoch: u32,
}

impl PrimaryPoint {
    /// Invalidates all coordinates.
    pub fn clear(&mut self) {
        if self.epoch == u32::MAX {
            *self = PrimaryPoint::default();
        }
        self.epoch += 1;
        self.streams.iter_mut().for_each(|cells| cells.far.clear());
    }

    fn get(&self, stream: usize, index: u64) -> Option<u32> {
        self.streams[stream].get(index).filter(|cell| cell.epoch == self.epoch).map(|cell| cell.value)
    }

    /// Sets the coordinate at an address, before the evaluation that uses it with [`PrimaryPoint::draw`].
    pub fn set(&mut self, stream: PrimaryStream, bounce: u32, slot: Slot, value: u32) {
        let epoch = self.epoch;
        *self.streams[stream as usize].at(index(bounce, slot)) = Cell { value, epoch };
    }

    /// Number of coordinates.
    pub fn dimension(&self) -> usize {
        let cells = self.streams.iter().flat_map(|cells| cells.near.iter().chain(cells.far.values()));
        cells.filter(|cell| cell.epoch == self.epoch).count()
    }

    /// Returns one sampler per stream. Evaluation with these samplers makes this point the proposal of `step` from
    /// `from`, with randomness from `address`.
    pub fn propose<'a>(&'a mut self, from: &'a PrimaryPoint, step: Step, address: Address) -> [Source<'a>; STREAMS] {
        self.clear();
        self.sources(Some((from, step)), address)
    }

    /// Returns samplers that draw coordinates from `address` unless they were [`PrimaryPoint::set`]. Stream i has the
    /// random numbers of an [`IndependentSampler`](crate::sampling::IndependentSampler) at `address.with(i)`.
    pub fn draw(&mut self, address: Address) -> [Source<'_>; STREAMS] {
        self.sources(None, address)
    }

    fn sources<'a>(&'a mut self, from: Option<(&'a PrimaryPoint, Step)>, address: Address) -> [Source<'a>; STREAMS] {
        let epoch = self.epoch;
        let mut streams = 0..;
        self.streams.each_mut().map(|cells| {
            let stream = streams.next().unwrap_or(0);
            Source { cells, epoch, from, stream, address: address.with(stream as u64) }
        })
    }
}

/// Index of an address in its stream, valid for any bounce.
fn index(bounce: u32, slot: Slot) -> u64 {
    u64::from(bounce) * u64::from(SLOTS) + slot as u64
}

/// Sampler of one stream of a [`PrimaryPoint`] under evaluation.
pub struct Source<'a> {
    cells: &'a mut Cells,
    epoch: u32,
    from: Option<(&'a PrimaryPoint, Step)>,
    stream: usize,
    address: Address,
}

impl Source<'_> {
    /// Returns the coordinate at `index`. On first use it is perturbed from the current point, or set to `new` if
    /// drawn.
    #[inline]
    fn coordinate(&mut self, index: u64, new: u32) -> u32 {
        let cell = self.cells.at(index);
        if cell.epoch != self.epoch {
            let value = match self.from {
                Some((from, Step::Small(small))) => match from.get(self.stream, index) {
                    Some(x) => small.apply(x, self.address.bits(index)),
                    None => new,
                },
                _ => new,
            };
            *cell = Cell { value, epoch: self.epoch };
        }
        cell.value
    }
}

impl Sampler for Source<'_> {
    #[inline]
    fn u1(&mut self, bounce: u32, slot: Slot) -> f32 {
        let index = index(bounce, slot);
        let bits = self.address.bits(index);
        unit_f32(self.coordinate(index, (bits >> 32) as u32))
    }

    #[inline]
    fn u2(&mut self, bounce: u32, slot: Slot) -> [f32; 2] {
        let first = index(bounce, slot);
        let bits = self.address.bits(first);
        [(first, (bits >> 32) as u32), (first + 1, bits as u32)]
            .map(|(index, new)| unit_f32(self.coordinate(index, new)))
    }
}
