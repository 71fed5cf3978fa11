//! Primary sample space: the unit cube of the numbers that a sampler takes, as many as it asks for [Kelemen02].
//!
//! A point has a coordinate for each address that was asked for while it was evaluated, and no other. Which addresses those are must be
//! decided by the numbers themselves, as it is where control flow follows them: then coordinates that a point does not use are uniform
//! and independent of all else, and may be drawn anew at each step in place of being kept and moved along. So a proposal moves what the
//! present point uses, and draws what it does not; nothing needs to be brought up to date, or restored if it is rejected.

use super::SmallStep;
use crate::defects::{Defect, planted};
use crate::sampling::{Address, SLOTS, Sampler, Slot, unit_f32};
use std::collections::BTreeMap;

/// What a number is for. Each stream has its own addresses, so that a longer walk from one end leaves the other's alone.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[repr(usize)]
pub enum Stream {
    /// The walk from one end, with what is sampled at its vertices.
    Camera,
    /// The walk from the other.
    Light,
    /// How both are joined.
    Connection,
}

const STREAMS: usize = 3;

/// Addresses below this are kept side by side, which long walks never leave; others, as those of roulette on connections, by themselves.
const SIDE_BY_SIDE: u64 = 1 << 16;

/// How a proposal comes from the present point.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Step {
    /// Every coordinate anew.
    Large,
    /// Each moved a little.
    Small(SmallStep),
}

/// A coordinate and the evaluation that used it last.
#[derive(Debug, Clone, Copy, Default)]
struct Cell {
    value: u32,
    epoch: u32,
}

/// The coordinates of one stream, at whatever addresses they are.
#[derive(Debug, Clone, Default)]
struct Cells {
    near: Vec<Cell>,
    far: BTreeMap<u64, Cell>,
}

impl Cells {
    fn get(&self, index: u64) -> Option<&Cell> {
        if index < SIDE_BY_SIDE { self.near.get(index as usize) } else { self.far.get(&index) }
    }

    /// The cell of an address, made if it is new.
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

/// A point: the numbers that its evaluation took.
#[derive(Debug, Clone, Default)]
pub struct Point {
    streams: [Cells; STREAMS],
    epoch: u32,
}

impl Point {
    /// Forgets everything.
    pub fn clear(&mut self) {
        if self.epoch == u32::MAX {
            *self = Point::default();
        }
        self.epoch += 1;
        self.streams.iter_mut().for_each(|cells| cells.far.clear());
    }

    fn get(&self, stream: usize, index: u64) -> Option<u32> {
        self.streams[stream].get(index).filter(|cell| cell.epoch == self.epoch).map(|cell| cell.value)
    }

    /// Gives the coordinate at an address a value, before the evaluation that asks for it with [`Point::draw`].
    pub fn set(&mut self, stream: Stream, bounce: u32, slot: Slot, value: u32) {
        let epoch = self.epoch;
        *self.streams[stream as usize].at(index(bounce, slot)) = Cell { value, epoch };
    }

    /// The number of coordinates.
    pub fn dimension(&self) -> usize {
        let cells = self.streams.iter().flat_map(|cells| cells.near.iter().chain(cells.far.values()));
        cells.filter(|cell| cell.epoch == self.epoch).count()
    }

    /// Samplers, one a stream, whose numbers make this the point that `step` leads to from `from`, with `address` for what is random.
    pub fn propose<'a>(&'a mut self, from: &'a Point, step: Step, address: Address) -> [Source<'a>; STREAMS] {
        self.clear();
        self.sources(Some((from, step)), address)
    }

    /// Samplers that draw from `address` what was not [`Point::set`]: stream i has the numbers of an
    /// [`Independent`](crate::sampling::Independent) sampler at `address.with(i)`.
    pub fn draw(&mut self, address: Address) -> [Source<'_>; STREAMS] {
        self.sources(None, address)
    }

    fn sources<'a>(&'a mut self, from: Option<(&'a Point, Step)>, address: Address) -> [Source<'a>; STREAMS] {
        let epoch = self.epoch;
        let mut streams = 0..;
        self.streams.each_mut().map(|cells| {
            let stream = streams.next().unwrap_or(0);
            Source { cells, epoch, from, stream, address: address.with(stream as u64) }
        })
    }
}

/// The place of an address in its stream: no bounce is too high for it.
fn index(bounce: u32, slot: Slot) -> u64 {
    u64::from(bounce) * u64::from(SLOTS) + slot as u64
}

/// The numbers of one stream of a [`Point`] in the making.
pub struct Source<'a> {
    cells: &'a mut Cells,
    epoch: u32,
    from: Option<(&'a Point, Step)>,
    stream: usize,
    address: Address,
}

impl Source<'_> {
    /// The coordinate at `index`, made if it has not been asked for before: `new` where it is drawn.
    #[inline]
    fn coordinate(&mut self, index: u64, new: u32) -> u32 {
        let cell = self.cells.at(index);
        if cell.epoch != self.epoch {
            let value = match self.from {
                Some((from, Step::Small(small))) => match from.get(self.stream, index) {
                    Some(x) => small.apply(x, self.address.bits(index)),
                    None if planted(Defect::NewCoordinatesZero) => 0,
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
        [(first, (bits >> 32) as u32), (first + 1, bits as u32)].map(|(index, new)| unit_f32(self.coordinate(index, new)))
    }
}
