//! Sets of lanes of a group, by what happens there.

use super::objects::flags;
use crate::bsdf::lanes::LaneModel;
use crate::geometry::Hits;
use etendue_lanes::{Float, MOST_LANES, Mask};

/// Bytes of a `u64`.
const BYTES: usize = 8;

/// Lanes of a group by what happens there, as bits.
#[derive(Default)]
pub(super) struct LaneSets {
    /// With a kernel for the hit point.
    pub(super) met: u32,
    /// That emit, of these.
    pub(super) lit: u32,
    /// That may be culled, of these.
    pub(super) may_be_culled: u32,
    /// With shading normals.
    pub(super) bent: u32,
    /// With a surface that is yet to be found.
    pub(super) varying: u32,
    pub(super) lambert: u32,
    pub(super) conductor: u32,
    pub(super) metal_dielectric: u32,
    /// Without a kernel.
    pub(super) single: u32,
}

impl LaneSets {
    pub(super) fn new<F: Float>(flags: &[u8], hits: &Hits, at: usize, hit: F::Mask) -> Self {
        // Rays without a hit have the largest number, for which the table ends with no flags.
        let last = flags.len() as u32 - 1;
        let mut all = [0; MOST_LANES];
        let objects = &hits.objects[at..at + F::LANES];
        for (flags_of, &object) in all.iter_mut().zip(objects) {
            *flags_of = flags[object.min(last) as usize];
        }
        let hit = hit.bits();
        let lanes = F::LANES.next_multiple_of(BYTES);
        let with = |flag: u8| bits_of(&all[..lanes], flag) & hit;
        let single = with(flags::SINGLE);
        LaneSets {
            met: hit & !single,
            lit: with(flags::EMITS),
            may_be_culled: with(flags::MAY_BE_CULLED),
            bent: with(flags::HAS_NORMALS),
            varying: with(flags::VARYING),
            lambert: with(flags::LAMBERT),
            conductor: with(flags::CONDUCTOR),
            metal_dielectric: with(flags::METAL_DIELECTRIC),
            single,
        }
    }

    #[inline(always)]
    pub(super) fn add(&mut self, model: LaneModel, bits: u32) {
        match model {
            LaneModel::Lambert => self.lambert |= bits,
            LaneModel::Conductor => self.conductor |= bits,
            LaneModel::MetalDielectric => self.metal_dielectric |= bits,
        }
    }

    /// Those with a model.
    #[inline(always)]
    pub(super) fn scattering(&self) -> u32 {
        self.lambert | self.conductor | self.metal_dielectric
    }

    /// Removes lanes from all but the single ones.
    #[inline(always)]
    pub(super) fn remove(&mut self, bits: u32) {
        for lanes in [
            &mut self.met,
            &mut self.lit,
            &mut self.bent,
            &mut self.varying,
            &mut self.lambert,
            &mut self.conductor,
            &mut self.metal_dielectric,
        ] {
            *lanes &= !bits;
        }
    }
}

/// Returns the lanes in which the bit `flag` is set, as bits.
#[inline(always)]
fn bits_of(flags: &[u8], flag: u8) -> u32 {
    let mut bits = 0;
    for (i, eight) in flags.chunks_exact(BYTES).enumerate() {
        let eight = eight.iter().rev().fold(0, |all, &byte| all << 8 | u64::from(byte));
        let set = eight >> flag.trailing_zeros() & 0x0101_0101_0101_0101;
        // Eight copies, in which bit 8 i of copy 7 − i moves to bit 56 + i.
        let gathered = set.wrapping_mul(0x0102_0408_1020_4080) >> 56;
        bits |= (gathered as u32) << (BYTES * i);
    }
    bits
}
