//! The `etendue` command.

fn main() -> std::process::ExitCode {
    etendue::cli::run()
}
