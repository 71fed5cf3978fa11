//! Signal handling: a render that is asked to stop keeps the samples so far.

use crate::error::{Error, Kind, Result};
use crate::parallel::Cancel;
use signal_hook::consts::{SIGINT, SIGTERM, SIGUSR1};
use signal_hook::flag::register_conditional_shutdown;
use signal_hook::iterator;
use signal_hook::low_level::emulate_default_handler;
use std::io;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

const SIGNALS: [i32; 3] = [SIGINT, SIGTERM, SIGUSR1];

/// Signals this soon after the first one belong to the same request: `timeout` and some schedulers signal the process
/// and its group.
const SAME_REQUEST: Duration = Duration::from_secs(1);

/// Handlers of SIGINT, SIGTERM and SIGUSR1; the last is what Slurm sends some time before the end of a job. Until
/// [`Signals::hold`] a signal ends the program at once, since there is nothing to lose. From then on the first signal
/// requests a stop, and a later one kills.
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
        signals.listen().map_err(|cause| Error::new(Kind::Internal, "cannot listen for signals").because(cause))?;
        Ok(signals)
    }

    fn listen(&self) -> io::Result<()> {
        let again = i32::from(Kind::Interrupted.exit_code());
        for signal in SIGNALS {
            register_conditional_shutdown(signal, again, Arc::clone(&self.idle))?;
        }
        let (mut received, cancel) = (iterator::Signals::new(SIGNALS)?, self.cancel.clone());
        std::thread::Builder::new().name("signals".into()).spawn(move || {
            let mut first: Option<Instant> = None;
            for signal in received.forever() {
                cancel.request();
                if first.get_or_insert_with(Instant::now).elapsed() > SAME_REQUEST {
                    // Fails for a signal without a default action only, and these have one.
                    let _ = emulate_default_handler(signal);
                }
            }
        })?;
        Ok(())
    }

    /// Marks the start of work that a stop must not lose.
    pub(super) fn hold(&self) {
        self.idle.store(false, Ordering::Relaxed);
    }
}
