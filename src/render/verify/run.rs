//! Rendering by turns: always the candidate that has had the least, so that all have equal time and whatever else the machine does
//! falls on all alike.

use super::Candidate;
use crate::error::{Error, Kind, Result};
use crate::film::Layout;
use crate::parallel::Cancel;
use crate::render::machine::available_memory;
use std::time::{Duration, Instant};

/// How much is rendered.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Effort {
    /// As much as this time allows for all candidates together; at least one sample in every pixel of every replicate.
    Time(Duration),
    /// So many samples per pixel of each candidate.
    Spp(u64),
}

/// How it ended.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Ran {
    /// The effort was made.
    Complete,
    /// A stop was requested.
    Interrupted,
}

/// Renders; `watch` is told the share that is done and the time that is left.
pub fn run(candidates: &mut [Candidate<'_>], effort: Effort, cancel: &Cancel, watch: &mut dyn FnMut(f64, Duration)) -> Ran {
    let start = Instant::now();
    loop {
        let Some(next) = next(candidates, effort, start.elapsed()) else { return Ran::Complete };
        if next.block(cancel).is_none() {
            return Ran::Interrupted;
        }
        let (done, elapsed) = (fraction(candidates, effort, start.elapsed()), start.elapsed());
        watch(done, if done > 0.0 { elapsed.mul_f64((1.0 - done) / done) } else { Duration::ZERO });
    }
}

/// Whose turn it is.
fn next<'b, 'a>(candidates: &'b mut [Candidate<'a>], effort: Effort, elapsed: Duration) -> Option<&'b mut Candidate<'a>> {
    let had = |c: &Candidate<'_>| match effort {
        Effort::Time(_) => c.seconds(),
        Effort::Spp(_) => c.spp() as f64,
    };
    let next = candidates.iter_mut().min_by(|a, b| had(a).total_cmp(&had(b)))?;
    let wanted = match effort {
        // The middle of the block may be past the end: then half of the runs end a bit early and half a bit late.
        Effort::Time(budget) => next.spp() == 0 || elapsed.as_secs_f64() + 0.5 * next.last_block() < budget.as_secs_f64(),
        Effort::Spp(spp) => next.spp() < spp,
    };
    wanted.then_some(next)
}

fn fraction(candidates: &[Candidate<'_>], effort: Effort, elapsed: Duration) -> f64 {
    let done = match effort {
        Effort::Time(budget) => elapsed.as_secs_f64() / budget.as_secs_f64(),
        Effort::Spp(spp) => candidates.iter().map(Candidate::spp).sum::<u64>() as f64 / (spp * candidates.len() as u64) as f64,
    };
    done.min(1.0)
}

/// Refuses films that would not fit into memory.
///
/// # Errors
/// Says how much they take.
pub fn affordable(layout: &Layout, candidates: usize) -> Result<()> {
    let need = Candidate::bytes(layout, candidates);
    match available_memory() {
        Some(available) if need > available => {
            let (need, available) = (need as f64 / 1e9, available as f64 / 1e9);
            let what = format!("the films of {candidates} candidates take {need:.1} GB and {available:.1} GB are free");
            Err(Error::new(Kind::Memory, format!("{what}: use a smaller --size")))
        }
        _ => Ok(()),
    }
}
