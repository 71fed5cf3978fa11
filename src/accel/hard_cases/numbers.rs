//! The random numbers of one ray, or of one geometry. They are made of integers, square roots and divisions alone, so that an
//! address means the same ray on every machine.

use crate::sampling::{Address, unit_f32};
use glam::Vec3;

/// A stream that its name and an index address.
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

    /// Uniform in [0, 1).
    pub(super) fn unit(&mut self) -> f32 {
        unit_f32((self.bits() >> 32) as u32)
    }

    /// Uniform in [−1, 1).
    pub(super) fn signed(&mut self) -> f32 {
        2.0 * self.unit() - 1.0
    }

    /// Uniform below `n`.
    pub(super) fn below(&mut self, n: usize) -> usize {
        (self.bits() % n as u64) as usize
    }

    /// One of `choices`.
    pub(super) fn any<T: Copy>(&mut self, choices: &[T]) -> T {
        choices[self.below(choices.len())]
    }

    /// Between two positive numbers, every octave about as likely: uniform in what represents them.
    pub(super) fn magnitude(&mut self, least: f32, most: f32) -> f32 {
        let (least, most) = (least.to_bits(), most.to_bits());
        f32::from_bits(least + self.below((most - least) as usize) as u32)
    }

    /// Uniform in the cube of half-width `half` around the origin.
    pub(super) fn in_cube(&mut self, half: f32) -> Vec3 {
        Vec3::new(self.signed(), self.signed(), self.signed()) * half
    }

    /// Uniform in the ball of `radius` around the origin.
    pub(super) fn in_ball(&mut self, radius: f32) -> Vec3 {
        loop {
            let p = self.in_cube(1.0);
            if p.length_squared() < 1.0 {
                return p * radius;
            }
        }
    }

    /// Uniform on the unit sphere.
    pub(super) fn direction(&mut self) -> Vec3 {
        loop {
            if let Some(d) = self.in_ball(1.0).try_normalize() {
                return d;
            }
        }
    }

    /// Uniform weights of the second and third corner of a triangle.
    pub(super) fn barycentric(&mut self) -> [f32; 2] {
        let (u, v) = (self.unit(), self.unit());
        if u + v < 1.0 { [u, v] } else { [1.0 - u, 1.0 - v] }
    }
}
