//! `etendue completions` and `etendue man`: shell completions and manual pages.

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
    /// Folder of the pages
    folder: PathBuf,
    #[command(flatten)]
    console: Console,
}

/// Prints the completion script of a shell.
pub(super) fn completions(args: &CompletionArgs) -> Result<()> {
    let mut text = Vec::new();
    generate(args.shell, &mut command(), "etendue", &mut text);
    super::console::print(&String::from_utf8_lossy(&text))
}

/// Writes a manual page for the program and for each of its commands.
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
    // The page name is leaked once per page, since clap requires `'static` names.
    let name: &'static str = String::leak(name.to_owned());
    let man = Man::new(command.clone().name(name));
    write_atomically(&path, |file| man.render(&mut std::io::BufWriter::new(file as &mut dyn Write)))
}
