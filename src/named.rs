//! Names of the values of an enum: the same on the command line, in `render.toml`, in file headers and in reports.
//!
//! An enum has them if it derives `VariantArray`, `IntoStaticStr` and `EnumMessage` of strum. Explanations are the
//! documentation comments of its values.

use strum::{EnumMessage, VariantArray};

/// An enum whose values have names.
pub trait Named: Copy + 'static {
    /// Returns all values in the order of their declaration.
    fn all() -> &'static [Self];
    /// Returns the name of the value.
    fn name(self) -> &'static str;
    /// Returns the explanation of the value; empty if it has none.
    fn about(self) -> &'static str;
    /// Returns the value of that name, if there is one.
    fn of_name(name: &str) -> Option<Self> {
        Self::all().iter().copied().find(|value| value.name() == name)
    }
}

impl<T: VariantArray + EnumMessage + Into<&'static str> + Copy> Named for T {
    fn all() -> &'static [Self] {
        Self::VARIANTS
    }

    fn name(self) -> &'static str {
        self.into()
    }

    fn about(self) -> &'static str {
        self.get_documentation().unwrap_or_default()
    }
}
