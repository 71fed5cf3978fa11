//! Flags whose values are an enum's: see [`Named`].

use crate::named::Named;
use clap::builder::{PossibleValue, PossibleValuesParser, TypedValueParser};

/// Returns the parser of an enum's values.
pub(super) fn named<T: Named + Send + Sync>() -> impl TypedValueParser<Value = T> {
    let values = T::all().iter().map(|value| possible((value.name(), value.about())));
    PossibleValuesParser::new(values).try_map(|name| T::of_name(&name).ok_or("no such value"))
}

/// Returns a value with its explanation, on one line and without a full stop as all help.
pub(super) fn possible((name, about): (&'static str, &'static str)) -> PossibleValue {
    PossibleValue::new(name).help(about.trim_end_matches('.').replace('\n', " "))
}
