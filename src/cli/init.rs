//! `etendue init`: writes a `render.toml` that explains every setting and sets none.

use super::Console;
use crate::error::{Error, Result};
use crate::io::atomic::write_atomically;
use crate::session::{SETTINGS, Setting};
use std::io::Write;
use std::path::PathBuf;

/// Arguments of `init`.
#[derive(Debug, clap::Args)]
pub(super) struct Args {
    /// A folder for the file, or a scene beside which it goes
    #[arg(default_value = ".")]
    place: PathBuf,
    /// Replace an existing render.toml
    #[arg(long)]
    force: bool,
    #[command(flatten)]
    console: Console,
}

/// Writes the file.
pub(super) fn run(args: Args) -> Result<()> {
    let path =
        if args.place.is_dir() { args.place.join("render.toml") } else { args.place.with_file_name("render.toml") };
    if path.exists() && !args.force {
        return Err(Error::usage(format!("{} is there already: --force replaces it", path.display())));
    }
    write_atomically(&path, |file| file.write_all(template().as_bytes()))?;
    args.console.document(&serde_json::json!({ "settings": path }))?;
    args.console.line(&format!("settings: {}", path.display()))
}

/// What can only stand in the file: a table for each medium.
const MEDIUM: &str = "
# Media around everything, in the box of a density or in the solids of materials, a table each
# [media.fog]
# fills = \"scene\"
# scattering = 0.05
# absorption = 0.0
# phase = 0.7
";

/// Returns every setting as a comment with an example. Names and help texts are those of the command line, so that none
/// can be missing.
fn template() -> String {
    let mut text = String::from(
        "# Settings of the scenes in this folder. The command line overrides them. Remove the # of those to set.\n",
    );
    for setting in SETTINGS {
        let Setting { name, example, .. } = setting;
        text.push_str(&format!("\n# {}\n", setting.help.trim()));
        let values: Vec<&str> = (setting.values)().into_iter().map(|(value, _)| value).collect();
        if !values.is_empty() {
            text.push_str(&format!("# One of {}\n", values.join(", ")));
        }
        text.push_str(&format!("# {name} = {example}\n"));
    }
    text.push_str(MEDIUM);
    text
}

/// Uncomments the settings of a template.
#[cfg(test)]
fn uncommented(text: &str) -> String {
    let settings = text.lines().filter_map(|line| line.strip_prefix("# ")).filter(|line| {
        let name = line.split(" = ").next().unwrap_or_default();
        line.contains(" = ") && SETTINGS.iter().any(|setting| setting.name == name)
    });
    settings.map(|line| format!("{line}\n")).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::session::SettingsPatch;

    /// Fails if a setting has no example, or an example is no longer valid.
    #[test]
    fn the_template_is_complete_and_valid() {
        let text = template();
        SettingsPatch::parse(&text).expect("nothing but comments");
        let set = uncommented(&text);
        let choices = SettingsPatch::parse(&set).unwrap_or_else(|e| panic!("{}: {set}", e.chain()));
        let settings = SettingsPatch { crop: None, ..choices }.settings(None);
        assert!(settings.is_ok(), "{:?}", settings.err());
        assert_eq!(set.lines().count(), SETTINGS.len());
    }
}
