//! Records what a build was made of and, where the loader would not find Embree by itself, writes its folder into the
//! binary.

use std::env;
use std::path::{Path, PathBuf};
use std::process::Command;

fn main() {
    println!("cargo::rerun-if-changed=build.rs");
    println!("cargo::rustc-env=ETENDUE_GIT_REVISION={}", git_revision().unwrap_or_else(|| "unknown".into()));
    println!("cargo::rustc-env=ETENDUE_TARGET_FEATURES={}", variable("CARGO_CFG_TARGET_FEATURE"));
    let rustc = output(Command::new(variable("RUSTC")).arg("--version"));
    println!("cargo::rustc-env=ETENDUE_RUSTC_VERSION={}", rustc.unwrap_or_else(|| "unknown".into()));
    let embree = env::var_os("DEP_EMBREE4_LIB").map(PathBuf::from);
    if let Some(lib) = embree.filter(|lib| !loader_searches(lib)) {
        println!("cargo::rustc-link-arg=-Wl,-rpath,{}", lib.display());
    }
}

/// The commit this source tree is at, `-dirty` if tracked files differ from it; `None` outside a checkout of this
/// project.
fn git_revision() -> Option<String> {
    let root = variable("CARGO_MANIFEST_DIR");
    // Sources unpacked inside another project's checkout are not at that project's revision.
    if Path::new(&git(&["rev-parse", "--show-toplevel"])?).canonicalize().ok()?
        != Path::new(&root).canonicalize().ok()?
    {
        return None;
    }
    let revision = git(&["rev-parse", "--short=12", "HEAD"])?;
    rerun_when_revision_changes();
    let changes = git(&["status", "--porcelain", "--untracked-files=no"])?;
    Some(if changes.is_empty() { revision } else { revision + "-dirty" })
}

/// Watches what moves when a commit is made or checked out, and the sources, whose edits make the tree dirty. The index
/// is not watched: `git status` alone rewrites it. A watched file that does not exist would rerun this script every
/// time.
fn rerun_when_revision_changes() {
    let branch = git(&["symbolic-ref", "--quiet", "HEAD"]);
    let references = ["HEAD", "logs/HEAD"].into_iter().chain(branch.as_deref());
    let paths = references.filter_map(|name| git(&["rev-parse", "--git-path", name]));
    for path in paths.filter(|path| Path::new(path).exists()) {
        println!("cargo::rerun-if-changed={path}");
    }
    for sources in ["src", "sys", "Cargo.toml", "Cargo.lock"] {
        println!("cargo::rerun-if-changed={sources}");
    }
}

/// What git prints; `None` where it fails. Optional locks would rewrite the index of a person's checkout.
fn git(arguments: &[&str]) -> Option<String> {
    output(Command::new("git").arg("--no-optional-locks").args(arguments))
}

/// Whether the dynamic loader finds Embree in `lib` by itself, by its own cache.
fn loader_searches(lib: &Path) -> bool {
    let cache = ["ldconfig", "/sbin/ldconfig"].iter().find_map(|ldconfig| output(Command::new(ldconfig).arg("-p")));
    let Ok(lib) = lib.canonicalize() else { return false };
    cache.is_some_and(|cache| {
        let libraries = cache.lines().filter(|line| line.trim_start().starts_with("libembree4."));
        let mut folders =
            libraries.filter_map(|line| Path::new(line.rsplit("=> ").next()?).parent()?.canonicalize().ok());
        folders.any(|folder| folder == lib)
    })
}

/// The trimmed standard output of a command that succeeds.
fn output(command: &mut Command) -> Option<String> {
    let output = command.output().ok().filter(|output| output.status.success())?;
    Some(String::from_utf8(output.stdout).ok()?.trim().to_owned())
}

fn variable(name: &str) -> String {
    env::var(name).unwrap_or_default()
}
