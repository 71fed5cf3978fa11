//! Random numbers of one ray or geometry. They use only integers, square roots and divisions, so that an address gives
//! the same ray on every machine.

use crate::sampling::{Address, unit_f32};
use glam::Vec3;

/// A random stream, addressed by name and index.
pub(super) struct Numbers {
    address: Address,
    drawn: u64,
}

impl Numbers {
    pub(super) fn new(name: &str, index: u64) -> Self {
        let named = name.bytes().fold(Address::new(0), |address, byte| address.with(u64::from(byte)));
        Numbers { address: named.with(index), drawn: 0 }
    }

    fn bits(&mut self) -> u64 {
        self.drawn += 1;
        self.address.bits(self.drawn)
    }

    /// Returns a random number in [0, 1).
    pub(super) fn unit(&mut self) -> f32 {
        unit_f32((self.bits() >> 32) as u32)
    }

    /// Returns a random number in [−1, 1).
    pub(super) fn signed(&mut self) -> f32 {
        2.0 * self.unit() - 1.0
    }

    /// Returns a random integer below `n`.
    pub(super) fn below(&mut self, n: usize) -> usize {
        (self.bits() % n as u64) as usize
    }

    /// Returns a random element of `choices`.
    pub(super) fn any<T: Copy>(&mut self, choices: &[T]) -> T {
        choices[self.below(choices.len())]
    }

    /// Returns a random number between two positive bounds, uniform in the bit pattern: every octave is about equally
    /// likely.
    pub(super) fn magnitude(&mut self, least: f32, most: f32) -> f32 {
        let (least, most) = (least.to_bits(), most.to_bits());
        f32::from_bits(least + self.below((most - least) as usize) as u32)
    }

    /// Returns a uniform point in the cube of half-width `half` around the origin.
    pub(super) fn in_cube(&mut self, half: f32) -> Vec3 {
        Vec3::new(self.signed(), self.signed(), self.signed()) * half
    }

    /// Returns a uniform point in the ball of `radius` around the origin.
    pub(super) fn in_ball(&mut self, radius: f32) -> Vec3 {
        loop {
            let p = self.in_cube(1.0);
            if p.length_squared() < 1.0 {
                return p * radius;
            }
        }
    }

    /// Returns a uniform direction.
    pub(super) fn direction(&mut self) -> Vec3 {
        loop {
            if let Some(d) = self.in_ball(1.0).try_normalize() {
                return d;
            }
        }
    }

    /// Returns uniform barycentric weights of the second and third vertex.
    pub(super) fn barycentric(&mut self) -> [f32; 2] {
        let (u, v) = (self.unit(), self.unit());
        if u + v < 1.0 { [u, v] } else { [1.0 - u, 1.0 - v] }
    }
}
