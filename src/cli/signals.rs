//! Signals: a render that is asked to stop keeps what it has.

use crate::error::{Error, Kind, Result};
use crate::parallel::Cancel;
use signal_hook::consts::{SIGINT, SIGTERM, SIGUSR1};
use signal_hook::flag::{register, register_conditional_default, register_conditional_shutdown};
use std::io;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

/// Hears SIGINT, SIGTERM and SIGUSR1, which Slurm sends some time before the end. While there is nothing to lose the program ends at
/// once, for a render to be begun again; from [`Signals::hold`] on the first asks for a stop and the second kills.
pub(super) struct Signals {
    /// The stop.
    pub(super) cancel: Cancel,
    idle: Arc<AtomicBool>,
}

impl Signals {
    /// Listens.
    ///
    /// # Errors
    /// The system refuses.
    pub(super) fn heed() -> Result<Self> {
        let signals = Signals { cancel: Cancel::new(), idle: Arc::new(AtomicBool::new(true)) };
        for signal in [SIGINT, SIGTERM, SIGUSR1] {
            signals.on(signal).map_err(|cause| Error::new(Kind::Internal, "cannot listen for signals").because(cause))?;
        }
        Ok(signals)
    }

    fn on(&self, signal: i32) -> io::Result<()> {
        let again = i32::from(Kind::Interrupted.exit_code());
        register_conditional_shutdown(signal, again, Arc::clone(&self.idle))?;
        // The order matters: the flag is still clear when the first signal passes this handler.
        register_conditional_default(signal, self.cancel.flag())?;
        register(signal, self.cancel.flag()).map(drop)
    }

    /// From now on there is something to lose.
    pub(super) fn hold(&self) {
        self.idle.store(false, Ordering::Relaxed);
    }
}
