//! The settings as flags: [`SETTINGS`] lists them.

use super::named_value;
use crate::session::{Form, SETTINGS, Setting, SettingsPatch};
use clap::builder::{PossibleValuesParser, ValueParser};
use clap::error::ErrorKind;
use clap::{Arg, ArgAction, ArgMatches, Command};

/// Settings given as flags.
#[derive(Debug, Clone, Default)]
pub(super) struct SettingsArgs(pub(super) SettingsPatch);

impl clap::Args for SettingsArgs {
    fn augment_args(command: Command) -> Command {
        SETTINGS.iter().fold(command, |command, setting| command.arg(argument(setting)))
    }

    fn augment_args_for_update(command: Command) -> Command {
        Self::augment_args(command)
    }
}

impl clap::FromArgMatches for SettingsArgs {
    fn from_arg_matches(matches: &ArgMatches) -> Result<Self, clap::Error> {
        let mut args = SettingsArgs::default();
        args.update_from_arg_matches(matches)?;
        Ok(args)
    }

    fn update_from_arg_matches(&mut self, matches: &ArgMatches) -> Result<(), clap::Error> {
        for setting in SETTINGS {
            let Ok(Some(values)) = matches.try_get_many::<String>(setting.name) else { continue };
            let text = values.map(String::as_str).collect::<Vec<_>>().join(",");
            let refuse = |why| clap::Error::raw(ErrorKind::ValueValidation, format!("--{}: {why}\n", setting.name));
            setting.set(&mut self.0, &text).map_err(refuse)?;
        }
        Ok(())
    }
}

fn argument(setting: &'static Setting) -> Arg {
    let arg = Arg::new(setting.name)
        .long(setting.name)
        .aliases(setting.alias)
        .help(setting.help.trim())
        .help_heading("Picture")
        .value_name(setting.value)
        .allow_negative_numbers(true)
        .value_parser(parser(setting));
    let arg = if let Some(short) = setting.short { arg.short(short) } else { arg };
    match setting.form {
        Form::Value => arg,
        Form::List => arg.value_delimiter(',').action(ArgAction::Append),
        Form::Switch => arg.num_args(0..=1).default_missing_value("true").require_equals(true),
    }
}

/// Checks a value where it stands, so that clap's message shows it.
fn parser(setting: &'static Setting) -> ValueParser {
    let values = (setting.values)();
    if values.is_empty() {
        return ValueParser::new(move |text: &str| -> Result<String, String> {
            setting.set(&mut SettingsPatch::default(), text)?;
            Ok(text.to_owned())
        });
    }
    ValueParser::new(PossibleValuesParser::new(values.into_iter().map(named_value::possible)))
}
