//! The Cargo.toml of the copy.

use toml::{Table, Value};

/// Returns the manifest of the copy, given that of the repository. It has no lints, since the copy is not written by
/// hand. Its package is built without line tables: cargo names files in the target folder by the path relative to the
/// workspace and by the profile, and would take the copy's for those of the repository under an equal profile.
pub(crate) fn of_copy(text: &str) -> Result<String, String> {
    let mut manifest: Table = toml::from_str(text).map_err(|e| format!("Cargo.toml: {e}"))?;
    manifest.remove("lints");
    let profile = ["profile", "dev", "package", "etendue"].iter().try_fold(&mut manifest, |table, &name| {
        table.entry(name).or_insert_with(|| Value::Table(Table::new())).as_table_mut()
    });
    profile.ok_or("Cargo.toml: a profile is no table")?.insert("debug".into(), Value::Boolean(false));
    toml::to_string(&manifest).map_err(|e| format!("Cargo.toml of the copy: {e}"))
}
