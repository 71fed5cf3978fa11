//! Renders the candidates in turns. The next candidate is the one with the least time so far, or the fewest samples if
//! their number is fixed. All get equal shares, and background load affects them alike.

use super::Candidate;
use crate::error::Result;
use crate::film::Layout;
use crate::parallel::Cancel;
use crate::session::machine;
use std::time::{Duration, Instant};

/// Amount of rendering.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Effort {
    /// Time for all candidates together; at least one sample per pixel in every replicate.
    Time(Duration),
    /// Samples per pixel of each candidate.
    Spp(u64),
}

/// Reason for the end of the rendering.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Ran {
    /// The amount was rendered.
    Complete,
    /// A stop was requested.
    Interrupted,
}

/// Renders all candidates. `watch` receives the completed fraction and the remaining time.
pub fn run(
    candidates: &mut [Candidate<'_>],
    effort: Effort,
    cancel: &Cancel,
    watch: &mut dyn FnMut(f64, Duration),
) -> Ran {
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

/// Selects the next candidate.
fn next<'b, 'a>(
    candidates: &'b mut [Candidate<'a>],
    effort: Effort,
    elapsed: Duration,
) -> Option<&'b mut Candidate<'a>> {
    let had = |c: &Candidate<'_>| match effort {
        Effort::Time(_) => c.seconds(),
        Effort::Spp(_) => c.spp() as f64,
    };
    let next = candidates.iter_mut().min_by(|a, b| had(a).total_cmp(&had(b)))?;
    let wanted = match effort {
        // A block starts if its midpoint is within the budget. Runs thus end early as often as late.
        Effort::Time(budget) => {
            next.spp() == 0 || elapsed.as_secs_f64() + 0.5 * next.last_block() < budget.as_secs_f64()
        }
        Effort::Spp(spp) => next.spp() < spp,
    };
    wanted.then_some(next)
}

fn fraction(candidates: &[Candidate<'_>], effort: Effort, elapsed: Duration) -> f64 {
    let done = match effort {
        Effort::Time(budget) => elapsed.as_secs_f64() / budget.as_secs_f64(),
        Effort::Spp(spp) => {
            candidates.iter().map(Candidate::spp).sum::<u64>() as f64 / (spp * candidates.len() as u64) as f64
        }
    };
    done.min(1.0)
}

/// Rejects films that do not fit into memory.
///
/// # Errors
/// The memory they need.
pub fn affordable(layout: &Layout, candidates: usize) -> Result<()> {
    let what = format!("the films of {candidates} candidates");
    machine::affordable(&what, Candidate::bytes(layout, candidates), "use a smaller --size")
}
