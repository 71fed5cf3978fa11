//! Checks that the code has the shape that ARCHITECTURE.md describes: floors, no circles of imports, where `unsafe` may
//! stand, citation keys, bare epsilons, sizes, nothing unfinished. The rules are in `rules.rs` and `circles.rs`, each
//! with a test that it fails where it is broken.

mod circles;
mod rules;
mod source;

use rules::{Finding, Floors};
use source::{Source, read_folder};
use std::path::Path;

/// Which module stands on which floor, from the first. A new folder under `src/` gets its place here.
const FLOORS: Floors<'static> = &[
    &["error", "named", "numeric", "huge_vec", "parallel"],
    &["spectrum", "sampling", "stats"],
    &["mcmc", "geometry"],
    &["transport", "accel", "texture"],
    &["bsdf", "light", "medium", "subsurface", "camera", "film"],
    &["scene"],
    &["path"],
    &["integrator", "io"],
    &["session"],
    &["lab", "batch"],
    &["cli"],
];
const UNSAFE_ALLOWED: [&str; 2] = ["sys/", "src/accel/embree/"];
const LONGEST_FILE: usize = 600;
const LONGEST_FUNCTION: usize = 120;

fn root() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR"))
}

/// The crate's own files.
fn crate_files() -> Vec<Source> {
    let files = read_folder(root(), "src");
    assert!(files.len() > 20, "only {} files under src: is this the right folder?", files.len());
    files
}

/// The crate's own files, `sys/` and the tests.
fn all_files() -> Vec<Source> {
    ["src", "sys", "tests"].into_iter().flat_map(|folder| read_folder(root(), folder)).collect()
}

fn assert_none(mut findings: Vec<Finding>) {
    findings.sort();
    let list: String = findings.iter().map(|f| format!("\n  {f}")).collect();
    assert!(findings.is_empty(), "{} findings:{list}", findings.len());
}

#[test]
fn modules_import_lower_floors_only() {
    assert_none(crate_files().iter().flat_map(|s| rules::floors(s, FLOORS)).collect());
}

#[test]
fn files_do_not_import_each_other() {
    assert_none(circles::circles(&crate_files()));
}

#[test]
fn the_command_line_alone_names_clap() {
    assert_none(crate_files().iter().flat_map(|s| rules::clap_outside(s, "src/cli/")).collect());
}

#[test]
fn unsafe_stays_where_it_belongs() {
    assert_none(all_files().iter().flat_map(|s| rules::unsafe_code(s, &UNSAFE_ALLOWED)).collect());
}

#[test]
fn nothing_is_left_unfinished() {
    assert_none(all_files().iter().flat_map(rules::unfinished).collect());
}

#[test]
fn citations_have_references() {
    let table = std::fs::read_to_string(root().join("src/references.md")).unwrap();
    let keys = rules::reference_keys(&table);
    let mut sorted = keys.clone();
    sorted.sort_by_key(|key| key.to_lowercase());
    sorted.dedup();
    assert_eq!(keys, sorted, "rows of src/references.md: each key once, in alphabetical order");
    let files = crate_files();
    assert_none(files.iter().flat_map(|s| rules::uncited(s, &keys)).collect());
    let cited: Vec<_> = files.iter().flat_map(rules::citations).map(|(_, key)| key).collect();
    for key in keys.iter().filter(|key| !cited.iter().any(|c| c == *key)) {
        println!("warning: nothing cites [{key}]");
    }
}

#[test]
fn small_numbers_say_what_they_are() {
    assert_none(crate_files().iter().flat_map(rules::bare_epsilons).collect());
}

#[test]
fn files_and_functions_stay_readable() {
    let files = crate_files();
    let mut lines: Vec<_> = files.iter().map(|s| s.lines).collect();
    let mut functions: Vec<_> = files.iter().flat_map(rules::functions).map(|f| f.lines).collect();
    println!("files:     {}", spread(&mut lines));
    println!("functions: {}", spread(&mut functions));
    assert_none(all_files().iter().flat_map(|s| rules::sizes(s, LONGEST_FILE, LONGEST_FUNCTION)).collect());
}

/// How sizes are distributed.
fn spread(lines: &mut [usize]) -> String {
    lines.sort_unstable();
    let quantile = |percent: usize| lines[(lines.len() - 1) * percent / 100];
    format!("{} of median {}, 90 % up to {}, longest {} lines", lines.len(), quantile(50), quantile(90), quantile(100))
}
