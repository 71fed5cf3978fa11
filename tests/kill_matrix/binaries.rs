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

/// Every killer with its binary, built in the copy `tree` without Embree.
pub(crate) fn locate(killers: &[Killer], tree: &Path) -> Result<Vec<Located>, String> {
    let mut names: Vec<&str> = killers.iter().map(|k| k.binary).filter(|&b| b != "lib").collect();
    names.sort_unstable();
    names.dedup();
    let built = executables(&names, tree)?;
    let find = |&killer: &Killer| {
        let name = if killer.binary == "lib" { "etendue" } else { killer.binary };
        let binary = built.get(name).cloned().ok_or_else(|| format!("cargo made no test binary {name}"))?;
        Ok(Located { killer, binary })
    };
    killers.iter().map(find).collect()
}

fn executables(tests: &[&str], tree: &Path) -> Result<HashMap<String, PathBuf>, String> {
    let mut cargo = Command::new(std::env::var_os("CARGO").unwrap_or_else(|| "cargo".into()));
    cargo.current_dir(tree).args([
        "test",
        "--locked",
        "--workspace",
        "--no-default-features",
        "--features",
        "cli",
        "--no-run",
        "--lib",
    ]);
    cargo.args(tests.iter().flat_map(|test| ["--test", test]));
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
