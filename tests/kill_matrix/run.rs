//! Runs killers, each in a process of its own on one processor, and says how each ended.

use crate::binaries::Located;
use crate::mutations::Mutation;
use std::path::Path;
use std::process::Command;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::{Mutex, PoisonError};

/// Processor seconds that a killer may take on the developers' machine. `--all` fails where one takes longer. Slower or
/// shared machines take longer for the same work, so elsewhere only [`SCRIPT`]'s limit holds.
pub(crate) const LIMIT: f64 = 5.0;

/// How a killer ended.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) enum Ending {
    /// One test ran and passed.
    Passed,
    /// One test ran and failed.
    Failed,
    /// Neither: it does not exist, was stopped by [`SCRIPT`], or died without a verdict. No kill.
    Unclear(String),
    /// It did not run, since another had killed before.
    NotRun,
}

/// How a killer ended and how long it took.
#[derive(Debug, Clone)]
pub(crate) struct Outcome {
    pub(crate) ending: Ending,
    /// Of a processor, user and system.
    pub(crate) seconds: f64,
}

impl Outcome {
    pub(crate) fn is_kill(&self) -> bool {
        self.ending == Ending::Failed
    }
}

/// Runs the killers in the copy.
pub(crate) struct Runner<'r> {
    pub(crate) killers: &'r [Located],
    /// The copy.
    pub(crate) tree: &'r Path,
}

impl Runner<'_> {
    /// The outcome of every killer with this mutation on, on all processors.
    pub(crate) fn all(&self, mutation: Option<&Mutation>) -> Vec<Outcome> {
        self.in_order(mutation, &(0..self.killers.len()).collect::<Vec<_>>(), |_| false)
    }

    /// The same, the fastest first by what they took when `healthy`, until one kills.
    pub(crate) fn until_killed(&self, mutation: &Mutation, healthy: &[Outcome]) -> Vec<Outcome> {
        let mut order: Vec<usize> = (0..self.killers.len()).collect();
        order.sort_by(|&a, &b| healthy[a].seconds.total_cmp(&healthy[b].seconds));
        self.in_order(Some(mutation), &order, Outcome::is_kill)
    }

    /// Runs killers in this `order` until one ends as `is_enough` wants.
    fn in_order(&self, mutation: Option<&Mutation>, order: &[usize], is_enough: fn(&Outcome) -> bool) -> Vec<Outcome> {
        let not_run = Outcome { ending: Ending::NotRun, seconds: 0.0 };
        let (next, done) = (AtomicUsize::new(0), Mutex::new(vec![not_run; self.killers.len()]));
        let work = || {
            while let Some(&i) = order.get(next.fetch_add(1, Ordering::Relaxed)) {
                let outcome = self.one(mutation, &self.killers[i]);
                if is_enough(&outcome) {
                    next.store(order.len(), Ordering::Relaxed);
                }
                done.lock().unwrap_or_else(PoisonError::into_inner)[i] = outcome;
            }
        };
        let workers = std::thread::available_parallelism().map_or(1, usize::from);
        std::thread::scope(|scope| (0..workers).for_each(|_| _ = scope.spawn(work)));
        done.into_inner().unwrap_or_else(PoisonError::into_inner)
    }

    fn one(&self, mutation: Option<&Mutation>, located: &Located) -> Outcome {
        let mut shell = Command::new("sh");
        shell.arg("-c").arg(SCRIPT).arg(&located.binary).arg(located.killer.test);
        shell.current_dir(self.tree).env("RAYON_NUM_THREADS", "1");
        shell.env("ETENDUE_MUTANT", mutation.map_or("", |m| &m.name)).env_remove("ETENDUE_TEST_DEEP");
        match shell.output() {
            Ok(output) => read(&String::from_utf8_lossy(&output.stdout), &String::from_utf8_lossy(&output.stderr)),
            Err(e) => Outcome { ending: Ending::Unclear(format!("sh does not run: {e}")), seconds: 0.0 },
        }
    }
}

/// The shell stops what takes more than three times [`LIMIT`], and knows how much processor time its children took.
const SCRIPT: &str = r#"ulimit -t 15; "$0" --exact "$1" --test-threads=1; times"#;

/// The last two lines are the shell's times: its own, and its children's.
fn read(stdout: &str, stderr: &str) -> Outcome {
    let seconds = stdout.lines().last().map_or(0.0, |times| times.split_whitespace().filter_map(minutes).sum());
    let ending = if stdout.contains("test result: ok. 1 passed; 0 failed") {
        Ending::Passed
    } else if stdout.contains("test result: FAILED. 0 passed; 1 failed") {
        Ending::Failed
    } else if stdout.contains("running 0 tests") {
        Ending::Unclear("there is no such test".into())
    } else {
        Ending::Unclear(format!("no verdict after {seconds:.1} s: {}", stderr.lines().last().unwrap_or_default()))
    };
    Outcome { ending, seconds }
}

/// Seconds of `0m1.230s`.
fn minutes(text: &str) -> Option<f64> {
    let (minutes, seconds) = text.strip_suffix('s')?.split_once('m')?;
    Some(minutes.parse::<f64>().ok()? * 60.0 + seconds.parse::<f64>().ok()?)
}
