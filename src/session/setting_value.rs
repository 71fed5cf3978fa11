//! Types of settings: how their values are written on the command line.

use super::{Aov, Aperture, Budget, EnvironmentChoice, Focus, Size, Window};
use crate::accel::{Backend, Build};
use crate::film::Filter;
use crate::integrator::{Execution, Method, Mutations};
use crate::io::png::ToneCurve;
use crate::light::LightChoice;
use crate::named::Named;
use crate::path::Technique;
use crate::sampling::{Heuristic, SamplerKind};
use crate::subsurface::DiffusionModel;

/// Form of a value on the command line.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Form {
    /// `--name VALUE`.
    Value,
    /// `--name VALUE,VALUE`.
    List,
    /// `--name`, or `--name=BOOL`.
    Switch,
}

/// A type of settings.
pub(super) trait SettingValue: Sized {
    /// Form on the command line.
    const FORM: Form = Form::Value;

    /// Parses a value.
    fn parse(text: &str) -> Result<Self, String>;

    /// Returns the names and explanations of all values; empty if they cannot be listed.
    fn values() -> Vec<(&'static str, &'static str)> {
        Vec::new()
    }
}

macro_rules! parsed {
    ($($type:ty),*) => {
        $(impl SettingValue for $type {
            fn parse(text: &str) -> Result<Self, String> {
                text.parse().map_err(|error| format!("{error}"))
            }
        })*
    };
}

parsed!(u32, u64, f32, f64, String, Aperture, Budget, EnvironmentChoice, Focus, Mutations, Size, Window);

macro_rules! named {
    ($($type:ty),*) => {
        $(impl SettingValue for $type {
            fn parse(text: &str) -> Result<Self, String> {
                named(text)
            }

            fn values() -> Vec<(&'static str, &'static str)> {
                <$type>::all().iter().map(|value| (value.name(), value.about())).collect()
            }
        })*
    };
}

named!(
    Aov,
    Backend,
    Build,
    DiffusionModel,
    Execution,
    Filter,
    Heuristic,
    LightChoice,
    Method,
    SamplerKind,
    Technique,
    ToneCurve
);

/// Parses the name of a value.
fn named<T: Named>(text: &str) -> Result<T, String> {
    T::of_name(text).ok_or_else(|| {
        let names: Vec<_> = T::all().iter().map(|value| value.name()).collect();
        format!("'{text}' is none of {}", names.join(", "))
    })
}

impl SettingValue for bool {
    const FORM: Form = Form::Switch;

    fn parse(text: &str) -> Result<Self, String> {
        text.parse().map_err(|_| format!("'{text}' is neither true nor false"))
    }
}

impl<T: SettingValue> SettingValue for Vec<T> {
    const FORM: Form = Form::List;

    fn parse(text: &str) -> Result<Self, String> {
        text.split(',').map(|part| T::parse(part.trim())).collect()
    }

    fn values() -> Vec<(&'static str, &'static str)> {
        T::values()
    }
}
