//! Where the test binaries of the copy are: cargo knows, and builds what is missing.

use crate::killers::Killer;
use std::collections::HashMap;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

/// A killer and the binary that holds it.
pub(crate) struct Located {
    pub(crate) killer: Killer,
    pub(crate) binary: PathBuf,
}

/// Every killer with its binary, built in the copy `tree`.
pub(crate) fn locate(killers: &[Killer], tree: &Path) -> Result<Vec<Located>, String> {
    let built = [false, true].map(|embree| executables(killers.iter().filter(|k| k.embree == embree), embree, tree));
    let [without, with] = built;
    let (without, with) = (without?, with?);
    let find = |&killer: &Killer| {
        let name = if killer.binary == "lib" { "etendue" } else { killer.binary };
        let binary = if killer.embree { &with } else { &without }.get(name).cloned();
        Ok(Located { killer, binary: binary.ok_or_else(|| format!("cargo made no test binary {name}"))? })
    };
    killers.iter().map(find).collect()
}

/// The paths of the binaries of `killers` by name, built with Embree or without it.
fn executables<'k>(
    killers: impl Iterator<Item = &'k Killer>,
    embree: bool,
    tree: &Path,
) -> Result<HashMap<String, PathBuf>, String> {
    let mut names: Vec<&str> = killers.map(|killer| killer.binary).collect();
    names.sort_unstable();
    names.dedup();
    let mut cargo = Command::new(std::env::var_os("CARGO").unwrap_or_else(|| "cargo".into()));
    cargo.current_dir(tree).args(["test", "--locked", "--workspace", "--no-run"]);
    if !embree {
        cargo.args(["--no-default-features", "--features", "cli"]);
    }
    for name in names {
        match name {
            "lib" => cargo.arg("--lib"),
            test => cargo.args(["--test", test]),
        };
    }
    cargo.arg("--message-format=json").stderr(Stdio::inherit());
    // The target folder of this binary, so that dependencies are shared.
    let target = Path::new(env!("CARGO_TARGET_TMPDIR")).parent().ok_or("the target folder has no parent")?;
    cargo.env("CARGO_TARGET_DIR", target);
    let output = cargo.output().map_err(|e| format!("cargo does not run: {e}"))?;
    if !output.status.success() {
        return Err("the tests of the copy do not build".into());
    }
    Ok(String::from_utf8_lossy(&output.stdout).lines().filter_map(executable).collect())
}

/// The name and the path that one of cargo's messages tells of a test binary.
fn executable(line: &str) -> Option<(String, PathBuf)> {
    let message: serde_json::Value = serde_json::from_str(line).ok()?;
    let path = message["executable"].as_str().filter(|_| message["profile"]["test"] == true)?;
    Some((message["target"]["name"].as_str()?.to_owned(), path.into()))
}
