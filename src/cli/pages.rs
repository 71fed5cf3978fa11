//! `etendue completions` and `etendue man`: the command line for shells and for `man`.

use super::{Console, command};
use crate::error::{Error, Result};
use crate::io::atomic::write_atomically;
use clap_complete::{Shell, generate};
use clap_mangen::Man;
use std::io::Write;
use std::path::{Path, PathBuf};

/// Arguments of `completions`.
#[derive(Debug, clap::Args)]
pub(super) struct CompletionArgs {
    /// The shell
    shell: Shell,
}

/// Arguments of `man`.
#[derive(Debug, clap::Args)]
pub(super) struct ManArgs {
    /// The folder that the pages go into
    folder: PathBuf,
    #[command(flatten)]
    console: Console,
}

/// Prints what a shell must know to complete commands.
pub(super) fn completions(args: &CompletionArgs) -> Result<()> {
    let mut text = Vec::new();
    generate(args.shell, &mut command(), "etendue", &mut text);
    super::console::print(&String::from_utf8_lossy(&text))
}

/// Writes a page for the program and for each of its commands.
pub(super) fn man(args: &ManArgs) -> Result<()> {
    std::fs::create_dir_all(&args.folder).map_err(|cause| Error::write(&args.folder, cause))?;
    let mut program = command();
    program.build();
    page(&program, "etendue", &args.folder)?;
    for sub in program.get_subcommands().filter(|sub| sub.get_name() != "help") {
        page(sub, &format!("etendue-{}", sub.get_name()), &args.folder)?;
    }
    args.console.line(&format!("pages: {}", args.folder.display()))
}

fn page(command: &clap::Command, name: &str, folder: &Path) -> Result<()> {
    let path = folder.join(format!("{name}.1"));
    // The name of a page is leaked, once for each: clap keeps names for as long as the program runs.
    let name: &'static str = String::leak(name.to_owned());
    let man = Man::new(command.clone().name(name));
    write_atomically(&path, |file| man.render(&mut std::io::BufWriter::new(file as &mut dyn Write)))
}
