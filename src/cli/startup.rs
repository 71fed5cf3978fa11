//! What happens before and around a subcommand: is this the right processor, what to say about a panic or a command
//! line that cannot be read.

use super::args::ThreadArgs;
use crate::error::{Error, Kind, Result};
use crate::render::Program;
use crate::render::machine::{Processor, limit_memory, threads};
use std::process::ExitCode;
use std::sync::LazyLock;

/// Version, revision and instruction set, as `--version` shows them.
pub(super) fn version() -> &'static str {
    static TEXT: LazyLock<String> = LazyLock::new(|| Program::current().to_string());
    &TEXT
}

/// Prints panics as the defects they are.
pub(super) fn report_panics() {
    std::panic::set_hook(Box::new(|panic| {
        let payload = panic.payload();
        let text = payload.downcast_ref::<&str>().copied().or_else(|| payload.downcast_ref::<String>().map(String::as_str));
        let place = panic.location().map(|l| format!(" at {}:{}", l.file(), l.line())).unwrap_or_default();
        let text = text.unwrap_or("no message");
        super::console::error(&format!("internal error, please report this as a bug of étendue {}: {text}{place}", version()));
    }));
}

/// Prints what clap has to say: help and versions are answers, everything else is an error of usage.
pub(super) fn refuse(refusal: &clap::Error) -> ExitCode {
    if !refusal.use_stderr() {
        return if refusal.print().is_ok() { ExitCode::SUCCESS } else { ExitCode::from(Kind::Output.exit_code()) };
    }
    let text = refusal.render().to_string();
    super::console::error(text.strip_prefix("error: ").unwrap_or(&text).trim_end());
    ExitCode::from(Kind::Usage.exit_code())
}

/// Refuses to run where the compiled instructions do not exist, instead of dying of an illegal one.
pub(super) fn check_processor() -> Result<()> {
    let processor = Processor::detect();
    let missing = processor.missing();
    if missing.is_empty() {
        return Ok(());
    }
    let model = processor.model.unwrap_or_else(|| "this processor".into());
    let what = format!("this étendue was built for processors with AVX2 and FMA, and {model} lacks {}", missing.join(", "));
    Err(Error::new(Kind::Internal, format!("{what}: build it with RUSTFLAGS=\"-C target-cpu=native\"")))
}

/// Decides how much memory there is and the number of threads, and gives these to rayon, once for the whole process.
pub(super) fn start_threads(asked: ThreadArgs) -> Result<usize> {
    asked.memory.iter().for_each(|bytes| limit_memory(bytes.0));
    let threads = threads(asked.threads, |name| std::env::var(name).ok())?;
    let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).thread_name(|i| format!("render-{i}"));
    pool.build_global().map_err(|cause| Error::new(Kind::Internal, "cannot start the render threads").because(cause))?;
    Ok(threads)
}
