//! Signal handling: a render that is asked to stop keeps the samples so far.

use crate::error::{Error, Kind, Result};
use crate::parallel::Cancel;
use signal_hook::consts::{SIGINT, SIGTERM, SIGUSR1};
use signal_hook::flag::{register, register_conditional_default, register_conditional_shutdown};
use std::io;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

/// Handlers of SIGINT, SIGTERM and SIGUSR1; the last is what Slurm sends some time before the end of a job. Until
/// [`Signals::hold`] a signal ends the program at once, since there is nothing to lose. From then on the first signal
/// requests a stop, and the second kills.
pub(super) struct Signals {
    /// Stop request, set by the first signal.
    pub(super) cancel: Cancel,
    idle: Arc<AtomicBool>,
}

impl Signals {
    /// Installs the handlers.
    ///
    /// # Errors
    /// The system refuses.
    pub(super) fn heed() -> Result<Self> {
        let signals = Signals { cancel: Cancel::new(), idle: Arc::new(AtomicBool::new(true)) };
        for signal in [SIGINT, SIGTERM, SIGUSR1] {
            signals
                .on(signal)
                .map_err(|cause| Error::new(Kind::Internal, "cannot listen for signals").because(cause))?;
        }
        Ok(signals)
    }

    fn on(&self, signal: i32) -> io::Result<()> {
        let again = i32::from(Kind::Interrupted.exit_code());
        register_conditional_shutdown(signal, again, Arc::clone(&self.idle))?;
        // The order matters: the flag is still clear when this handler sees the first signal.
        register_conditional_default(signal, self.cancel.flag())?;
        register(signal, self.cancel.flag()).map(drop)
    }

    /// Marks the start of work that a stop must not lose.
    pub(super) fn hold(&self) {
        self.idle.store(false, Ordering::Relaxed);
    }
}
