//! The fuzzing corpus and every file of the shared scenes: each loads or is one clear sentence.

use crate::support::shared;
use etendue::accel::{Backend, Build};
use etendue::error::{Error, Kind};
use etendue::io::gltf;
use etendue::io::scene_file::{self, ReadOptions};
use etendue::scene::description::Description;
use etendue::scene::{BuildOptions, Scene};
use etendue::session::SettingsPatch;
use etendue_testing::forge;
use std::panic::catch_unwind;
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

/// What one file may take: the largest takes a second. This is to find what never ends.
const PATIENCE: Duration = Duration::from_secs(30);

/// The committed corpus and past findings of a fuzz target.
fn kept(target: &str) -> Vec<PathBuf> {
    let fuzz = Path::new(env!("CARGO_MANIFEST_DIR")).join("fuzz");
    let folders = ["corpus", "regressions"].map(|folder| fuzz.join(folder).join(target));
    folders.iter().filter(|f| f.is_dir()).flat_map(|f| files_below(f)).collect()
}

pub(crate) fn files_below(folder: &Path) -> Vec<PathBuf> {
    let entries = std::fs::read_dir(folder).expect("a folder").map(|e| e.expect("an entry").path());
    let mut files: Vec<_> =
        entries.flat_map(|path| if path.is_dir() { files_below(&path) } else { vec![path] }).collect();
    files.sort();
    files
}

/// Runs `read` on a file, which must return in time and without a panic, and an error be one sentence.
fn survives<T>(file: &Path, read: impl FnOnce() -> Result<T, Error> + std::panic::UnwindSafe) -> Option<T> {
    let start = Instant::now();
    let result = catch_unwind(read).unwrap_or_else(|_| panic!("{} panics", file.display()));
    assert!(start.elapsed() < PATIENCE, "{} takes {:?}", file.display(), start.elapsed());
    result.map_err(|error| assert!(!error.chain().contains(char::is_control), "{:?}", error.chain())).ok()
}

fn built(description: Description) -> Result<(), Error> {
    let options =
        BuildOptions { backend: Backend::default(), build: Build::Compact, threads: 1, ..BuildOptions::default() };
    match Scene::build(description, &options) {
        // Without a backend what comes before it is all there is to test.
        Err(error) if error.kind == Kind::Usage => Ok(()),
        other => other.map(drop),
    }
}

#[test]
fn every_kept_gltf_loads_or_is_one_sentence() {
    let files = kept("gltf");
    assert!(files.len() > 300, "{} files", files.len());
    let load = |file: &PathBuf| {
        let bytes = std::fs::read(file).expect("a file");
        let at = |seconds: Option<f64>| {
            survives(file, || {
                gltf::parse(&bytes, Path::new("nowhere"), &ReadOptions { seconds, ..ReadOptions::default() })
                    .and_then(built)
            })
        };
        [at(None).is_some(), at(Some(0.25)).is_some()]
    };
    let results: Vec<[bool; 2]> = files.iter().map(load).collect();
    let loaded = results.iter().filter(|[rest, _]| *rest).count();
    // What loads at a time of its animations loads without them, unless they are what keeps it from being seen.
    assert!(results.iter().any(|&[rest, moved]| rest && !moved), "no animation is broken");
    // Most are broken on purpose; that some load says that the test reaches the end.
    assert!(loaded > 0 && loaded < files.len(), "{loaded} of {} load", files.len());
}

#[test]
fn every_kept_film_image_stream_and_configuration_is_read_or_one_sentence() {
    for file in kept("exr") {
        survives(&file, || etendue::io::exr::read(&file));
    }
    let folder = tempfile::tempdir().expect("a temporary folder");
    for file in kept("environment") {
        let bytes = std::fs::read(&file).expect("a file");
        let Some((choice, bytes)) = bytes.split_first() else { continue };
        let map = folder.path().join(if choice & 1 == 0 { "a.hdr" } else { "a.exr" });
        std::fs::write(&map, bytes).expect("a written file");
        survives(&file, || etendue::io::environment::load(&map, (choice & 2 != 0).then_some("Combined")));
    }
    for file in kept("config") {
        let bytes = std::fs::read(&file).expect("a file");
        survives(&file, || SettingsPatch::parse(&String::from_utf8_lossy(&bytes)));
    }
    let forged = folder.path().join("forged.film");
    let mut read = [0; 2];
    for file in kept("film") {
        read[0] += survives(&file, || etendue::session::film_file::read(&file)).map_or(0, |_| 1);
        std::fs::write(&forged, forge::film(&std::fs::read(&file).expect("a file"))).expect("a written file");
        read[1] += survives(&file, || etendue::session::film_file::read(&forged)).map_or(0, |_| 1);
    }
    // Those of the current version are read to their end, as they are and as the fuzz target makes them.
    assert!(read.iter().all(|&count| count > 0), "{read:?} films are read");
    let stream = |file: &PathBuf| survives(file, || etendue::lab::bench_rays::stream_file::read(file)).is_some();
    assert!(kept("rays").iter().filter(|file| stream(file)).count() > 0, "none is read to its end");
}

/// Whatever a person may name as the scene: models, meshes and textures of other formats, licences.
#[test]
fn every_shared_file_loads_or_is_one_sentence_that_names_it() {
    let Some(folder) = shared("") else { return };
    let files = files_below(&folder);
    assert!(files.len() > 900, "{} files", files.len());
    for file in files {
        let start = Instant::now();
        let scene = survives(&file, || {
            scene_file::load(&file).inspect_err(|error| {
                let (chain, kind) = (error.chain(), error.kind);
                assert!(kind == Kind::Scene && chain.starts_with(&*file.to_string_lossy()), "{kind:?} {chain}");
            })
        });
        let is_gltf = file.extension().is_some_and(|e| e == "gltf" || e == "glb");
        assert!(is_gltf || scene.is_none(), "{}", file.display());
        if let Some(scene) = scene {
            survives(&file, || built(scene));
        }
        assert!(start.elapsed() < PATIENCE, "{} takes too long", file.display());
    }
}

/// 1000 teapots and as many places as the file says.
#[test]
fn teapots_galore_shares_its_meshes_between_instances() {
    let Some(folder) = shared("gltf-samples/TeapotsGalore") else { return };
    let scene = scene_file::load(&folder.join("TeapotsGalore.gltf")).expect("a valid file");
    let teapots = scene.instances.iter().filter(|i| i.name.starts_with("teapot")).count();
    assert!(scene.meshes.len() <= 3 && teapots > 100, "{} meshes, {teapots} teapots", scene.meshes.len());
    assert!(scene.ignored.is_empty(), "{:?}", scene.ignored);
}
