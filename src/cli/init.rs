//! `etendue init`: writes a `render.toml` that explains every setting and sets none.

use super::Console;
use crate::error::{Error, Result};
use crate::io::atomic::write_atomically;
use crate::session::SettingsPatch;
use clap::{Args as _, Command};
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
    args.console.line(&format!("settings: {}", path.display()))
}

/// Returns every setting as a comment with an example. Names and help texts are those of the command line, so that none
/// can be missing.
fn template() -> String {
    let mut text = String::from(
        "# RenderSettings of the scenes in this folder. The command line wins over them; remove the # of what you want to set.\n",
    );
    for argument in SettingsPatch::augment_args(Command::new("")).get_arguments() {
        let Some(name) = argument.get_long() else { continue };
        let help = argument.get_help().map(ToString::to_string).unwrap_or_default();
        let values: Vec<String> =
            argument.get_possible_values().iter().map(|value| value.get_name().to_owned()).collect();
        text.push_str(&format!("\n# {}\n", help.replace('\n', " ")));
        if values.len() > 2 {
            text.push_str(&format!("# One of {}\n", values.join(", ")));
        }
        text.push_str(&format!("# {name} = {}\n", example(name)));
    }
    text
}

/// Returns a valid value of a setting, mostly its default.
fn example(name: &str) -> &'static str {
    EXAMPLES.iter().find(|(of, _)| *of == name).map_or("\"\"", |(_, value)| value)
}

const EXAMPLES: &[(&str, &str)] = &[
    ("method", "\"path\""),
    ("spp", "64"),
    ("time", "\"5m\""),
    ("target-error", "1e-3"),
    ("size", "\"1280x720\""),
    ("crop", "\"0,0,640,360\""),
    ("camera", "\"0\""),
    ("aperture", "\"f/2.8\""),
    ("focus", "2.5"),
    ("blades", "6"),
    ("depth", "64"),
    ("frame", "0"),
    ("fps", "24.0"),
    ("filter", "\"blackman-harris\""),
    ("animation", "\"walk\""),
    ("sampler", "\"sobol\""),
    ("seed", "0"),
    ("replicates", "4"),
    ("backend", "\"obvhs\""),
    ("build", "\"robust\""),
    ("aov", "[\"albedo\", \"normal\"]"),
    ("clamp", "10.0"),
    ("transparent", "true"),
    ("without", "[\"splat\"]"),
    ("heuristic", "\"balance\""),
    ("chains", "128"),
    ("large-step", "0.3"),
    ("lengths", "8"),
    ("mutations", "\"bidirectional=1,lens=2\""),
    ("limit", "10.0"),
    ("two-stage", "true"),
    ("env", "\"sky.hdr\""),
    ("env-rotation", "90.0"),
    ("env-layer", "\"ViewLayer.Combined\""),
    ("env-scale", "1.0"),
    ("exposure", "0.0"),
    ("curve", "\"filmic\""),
];

/// Uncomments the settings of a template.
#[cfg(test)]
fn uncommented(text: &str) -> String {
    let settings = text.lines().filter_map(|line| line.strip_prefix("# ")).filter(|line| {
        let name = line.split(" = ").next().unwrap_or_default();
        line.contains(" = ") && EXAMPLES.iter().any(|(of, _)| *of == name)
    });
    settings.map(|line| format!("{line}\n")).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Fails if a setting has no example, or an example is no longer valid.
    #[test]
    fn the_template_is_complete_and_valid() {
        let text = template();
        assert!(!text.contains("= \"\""), "a setting has no example: {text}");
        SettingsPatch::parse(&text).expect("nothing but comments");
        let set = uncommented(&text);
        let choices = SettingsPatch::parse(&set).unwrap_or_else(|e| panic!("{}: {set}", e.chain()));
        let settings = SettingsPatch { crop: None, ..choices }.settings(None);
        assert!(settings.is_ok(), "{:?}", settings.err());
        assert_eq!(set.lines().count(), SettingsPatch::augment_args(Command::new("")).get_arguments().count());
    }
}
