//! Finds Embree 4, checks its version and generates the bindings from its headers.
//!
//! `EMBREE_DIR` names an installation (its `include/` and `lib/` or `lib64/`); without it the compiler's default
//! folders are searched. Embree ships no pkg-config file, so none is asked for.

use std::env;
use std::fs;
use std::path::{Path, PathBuf};

/// From 4.3 a hit names the primitive of an instance array, which fixes the size of every ray structure.
const OLDEST: u32 = 40300;

/// Where an installation keeps its headers and its library.
struct Embree {
    include: PathBuf,
    lib: PathBuf,
    version: u32,
}

fn main() {
    println!("cargo::rerun-if-changed=build.rs");
    println!("cargo::rerun-if-env-changed=EMBREE_DIR");
    if let Err(message) = run() {
        println!("cargo::error={message}");
    }
}

fn run() -> Result<(), String> {
    let embree = find()?;
    println!("cargo::rerun-if-changed={}", config_header(&embree.include).display());
    println!("cargo::rustc-link-search=native={}", embree.lib.display());
    println!("cargo::rustc-link-lib=dylib=embree4");
    println!("cargo::metadata=include={}", embree.include.display());
    println!("cargo::metadata=lib={}", embree.lib.display());
    println!("cargo::metadata=version={}", embree.version);
    // bindgen panics where it cannot load libclang.
    std::panic::catch_unwind(|| generate(&embree.include))
        .unwrap_or_else(|_| Err("bindgen failed, most likely because libclang is not installed: run ./setup.sh".into()))
}

/// The installation to build against, of a sufficient version.
fn find() -> Result<Embree, String> {
    let (include, libs) = match env::var_os("EMBREE_DIR") {
        Some(dir) => chosen(Path::new(&dir))?,
        None => installed()?,
    };
    let version = version(&include)?;
    if version < OLDEST {
        return Err(format!(
            "Embree {} in {} is too old, at least {} is needed: run ./setup.sh or set EMBREE_DIR to a newer installation",
            dotted(version),
            include.display(),
            dotted(OLDEST)
        ));
    }
    let lib = libs.iter().find(|lib| has_library(lib)).cloned().ok_or_else(|| {
        let searched: Vec<_> = libs.iter().map(|lib| lib.display().to_string()).collect();
        format!(
            "Embree's headers are in {}, but libembree4 is not in {}: run ./setup.sh",
            include.display(),
            searched.join(", ")
        )
    })?;
    Ok(Embree { include, lib, version })
}

/// The headers and possible library folders of the installation that `EMBREE_DIR` names.
fn chosen(dir: &Path) -> Result<(PathBuf, Vec<PathBuf>), String> {
    // Relative to where? Cargo runs build scripts in the package's folder, a person means another one.
    if !dir.is_absolute() {
        return Err(format!("EMBREE_DIR={} must be an absolute path", dir.display()));
    }
    let include = dir.join("include");
    if !config_header(&include).is_file() {
        return Err(format!(
            "EMBREE_DIR={} holds no include/embree4/rtcore_config.h: name the folder of an Embree 4 installation, or unset \
             EMBREE_DIR and run ./setup.sh",
            dir.display()
        ));
    }
    Ok((include, vec![dir.join("lib"), dir.join("lib64")]))
}

/// The headers and possible library folders of an installation in the system's folders; one made by hand comes first,
/// as it does for the compiler.
fn installed() -> Result<(PathBuf, Vec<PathBuf>), String> {
    let prefix =
        ["/usr/local", "/usr"].map(Path::new).into_iter().find(|prefix| config_header(&prefix.join("include")).is_file()).ok_or(
            "Embree 4 is not installed (no embree4/rtcore_config.h in /usr/include or /usr/local/include): run ./setup.sh",
        )?;
    let arch = env::var("CARGO_CFG_TARGET_ARCH").unwrap_or_default();
    let libs = [format!("lib/{arch}-linux-gnu"), "lib64".into(), "lib".into()];
    Ok((prefix.join("include"), libs.iter().map(|lib| prefix.join(lib)).collect()))
}

fn config_header(include: &Path) -> PathBuf {
    include.join("embree4").join("rtcore_config.h")
}

fn has_library(lib: &Path) -> bool {
    ["libembree4.so", "libembree4.dylib"].iter().any(|name| lib.join(name).exists())
}

/// `RTC_VERSION` of the headers: major · 10000 + minor · 100 + patch.
fn version(include: &Path) -> Result<u32, String> {
    let path = config_header(include);
    let text = fs::read_to_string(&path).map_err(|e| format!("cannot read {}: {e}", path.display()))?;
    text.lines()
        .find_map(|line| line.strip_prefix("#define RTC_VERSION "))
        .and_then(|value| value.trim().parse().ok())
        .ok_or_else(|| format!("{} does not define RTC_VERSION: is this Embree 4?", path.display()))
}

fn dotted(version: u32) -> String {
    format!("{}.{}.{}", version / 10000, version / 100 % 100, version % 100)
}

fn generate(include: &Path) -> Result<(), String> {
    let out = env::var_os("OUT_DIR").map(PathBuf::from).ok_or("OUT_DIR is not set: build with cargo")?;
    bindgen::Builder::default()
        .header(include.join("embree4").join("rtcore.h").display().to_string())
        .clang_arg(format!("-I{}", include.display()))
        .allowlist_item("(rtc|RTC).*")
        // An enum value that the library adds later must not be undefined behaviour here, so never a Rust enum.
        .default_enum_style(bindgen::EnumVariation::NewType { is_bitfield: false, is_global: false })
        .bitfield_enum("RTC.*Flags")
        .prepend_enum_name(false)
        .generate_comments(false)
        .parse_callbacks(Box::new(bindgen::CargoCallbacks::new()))
        .generate()
        .map_err(|e| format!("cannot generate bindings from Embree's headers in {}: {e}", include.display()))?
        .write_to_file(out.join("bindings.rs"))
        .map_err(|e| format!("cannot write the bindings: {e}"))
}
