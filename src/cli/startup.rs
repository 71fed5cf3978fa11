//! Code that runs before and around a subcommand: the processor check, the panic hook, and errors of the command line.

use super::args::ThreadArgs;
use crate::error::{Error, Kind, Result};
use crate::session::Program;
use crate::session::machine::{Processor, limit_memory, threads};
use std::process::ExitCode;
use std::sync::LazyLock;

/// Version, revision and instruction set, as shown by `--version`.
pub(super) fn version() -> &'static str {
    static TEXT: LazyLock<String> = LazyLock::new(|| Program::current().to_string());
    &TEXT
}

/// Installs a hook that reports panics as internal errors.
pub(super) fn report_panics() {
    std::panic::set_hook(Box::new(|panic| {
        let payload = panic.payload();
        let text =
            payload.downcast_ref::<&str>().copied().or_else(|| payload.downcast_ref::<String>().map(String::as_str));
        let place = panic.location().map(|l| format!(" at {}:{}", l.file(), l.line())).unwrap_or_default();
        let text = text.unwrap_or("no message");
        super::console::error(&format!(
            "internal error, please report this as a bug of étendue {}: {text}{place}",
            version()
        ));
    }));
}

/// Prints a result of clap. Help and version are answers, everything else is a usage error.
pub(super) fn refuse(refusal: &clap::Error) -> ExitCode {
    if !refusal.use_stderr() {
        return if refusal.print().is_ok() { ExitCode::SUCCESS } else { ExitCode::from(Kind::Output.exit_code()) };
    }
    let text = refusal.render().to_string();
    super::console::error(text.strip_prefix("error: ").unwrap_or(&text).trim_end());
    ExitCode::from(Kind::Usage.exit_code())
}

/// Rejects a processor that lacks the compiled instruction sets, which would otherwise crash with an illegal
/// instruction.
pub(super) fn check_processor() -> Result<()> {
    let processor = Processor::detect();
    let missing = processor.missing();
    if missing.is_empty() {
        return Ok(());
    }
    let model = processor.model.unwrap_or_else(|| "this processor".into());
    let what =
        format!("this étendue was built for processors with AVX2 and FMA, and {model} lacks {}", missing.join(", "));
    Err(Error::new(Kind::Internal, format!("{what}: build it with RUSTFLAGS=\"-C target-cpu=native\"")))
}

/// Sets the memory limit, and starts rayon's threads for the whole process. Returns their number.
pub(super) fn start_threads(asked: ThreadArgs) -> Result<usize> {
    asked.memory.iter().for_each(|bytes| limit_memory(bytes.0));
    let threads = threads(asked.threads, |name| std::env::var(name).ok())?;
    let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).thread_name(|i| format!("render-{i}"));
    pool.build_global()
        .map_err(|cause| Error::new(Kind::Internal, "cannot start the render threads").because(cause))?;
    Ok(threads)
}
