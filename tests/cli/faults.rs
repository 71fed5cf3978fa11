//! Faults of farms: kills at any moment, full disks, damaged films.

use crate::run::{Place, cornell_file};
use crate::signals::signal;
use etendue::io::exr;
use etendue_testing::deep;
use std::io::{BufRead, BufReader, Read};
use std::process::Command;
use std::thread::sleep;
use std::time::Duration;

/// Numbers that are all over the place and the same in each run.
fn moments(count: u64, most: u64) -> impl Iterator<Item = Duration> {
    (0..count).map(move |i| Duration::from_micros(i.wrapping_mul(0x9e37_79b9_7f4a_7c15) % (1000 * most)))
}

/// The old picture stays whole until the new one is, and the film that is there always goes on.
#[test]
fn kills_at_any_moment_lose_nothing() {
    let place = Place::new();
    let line =
        format!("render {} -m bdpt --spp 256 --size 64x64 -o x.exr --skip-complete --checkpoint 10ms", cornell_file());
    let whole = place.pixels(&line.replace("x.exr", "whole.exr"));
    std::fs::write(place.path("x.exr"), "old").unwrap();
    let (mut films, mut kills) = (0, 0);
    for moment in moments(if deep() { 200 } else { 12 }, 250) {
        let mut child = place.start(&line);
        sleep(moment);
        signal(&child, "KILL");
        if child.wait().unwrap().success() {
            // It was faster: from the beginning.
            std::fs::write(place.path("x.exr"), "old").unwrap();
            continue;
        }
        kills += 1;
        assert_eq!(std::fs::read(place.path("x.exr")).unwrap(), b"old");
        if place.path("x.film").exists() {
            films += 1;
            let status = place.run("status x.film");
            assert_eq!(status.code(), 0, "{}", status.stderr());
        }
        // From the beginning once in a while, so that films do not all become complete.
        if kills % 5 == 0 {
            std::fs::remove_file(place.path("x.film")).ok();
        }
    }
    println!("{kills} kills, {films} times with a film");
    assert!(films > 0, "no kill found a film");
    std::fs::remove_file(place.path("x.exr")).unwrap();
    let resumed = place.run(&line);
    assert_eq!(resumed.code(), 0, "{}", resumed.stderr());
    assert!(place.run(&line).stdout().starts_with("complete already"));
    let pixels = |name: &str| exr::read(&place.path(name)).unwrap().hash_pixels();
    assert_eq!(pixels("x.exr"), whole, "killed and resumed");
    let left: Vec<_> = std::fs::read_dir(place.path(".")).unwrap().map(|f| f.unwrap().file_name()).collect();
    println!("{left:?} are left");
}

/// A limit of file sizes stands for a full disk.
#[test]
fn a_full_disk_is_told_and_old_files_stay() {
    let place = Place::new();
    for (file, options) in [("x.exr", "-o x.exr"), ("x.film", "-o x.film"), ("x.png", "-o x.png")] {
        std::fs::write(place.path(file), "old").unwrap();
        let render =
            format!("{} render {} --size 256x256 --spp 4 {options}", env!("CARGO_BIN_EXE_etendue"), cornell_file());
        let limited = format!("trap '' XFSZ; ulimit -f 8; exec {render}");
        let ran = Command::new("bash").args(["-c", &limited]).current_dir(place.path(".")).output().unwrap();
        let said = String::from_utf8_lossy(&ran.stderr);
        assert_eq!(ran.status.code(), Some(4), "{said}");
        assert!(said.contains("cannot write") && said.contains(file), "{said}");
        assert_eq!(std::fs::read(place.path(file)).unwrap(), b"old", "{file}");
    }
    let left: Vec<_> = std::fs::read_dir(place.path(".")).unwrap().map(|f| f.unwrap().file_name()).collect();
    assert_eq!(left.len(), 3, "{left:?}");
}

/// Each byte of a film's head changed, and the film cut anywhere, is an invalid input and never a picture.
#[test]
fn damaged_films_are_refused() {
    let place = Place::new();
    place.run(&format!("render {} --spp 4 --size 8x8 -o x.film", cornell_file()));
    let film = std::fs::read(place.path("x.film")).unwrap();
    let refused = |bytes: &[u8], what: &str| {
        std::fs::write(place.path("y.film"), bytes).unwrap();
        let ran = place.run("merge y.film -o y.exr");
        assert_eq!(ran.code(), 3, "{what}: {}", ran.stderr());
        assert!(!place.path("y.exr").exists(), "{what}");
    };
    let step = if deep() { 1 } else { 7 };
    for at in (0..film.len().min(64)).step_by(step) {
        let mut bytes = film.clone();
        bytes[at] ^= 0x40;
        refused(&bytes, &format!("byte {at}"));
    }
    let cuts = if deep() { 50 } else { 8 };
    for cut in 0..cuts {
        let length = film.len() * cut / cuts;
        refused(&film[..length], &format!("cut after {length} bytes"));
    }
}

/// A network folder that goes while a picture is rendered costs a warning, and in the end an exit code that says to try
/// again; the samples are kept where they can be.
#[test]
fn a_folder_that_vanishes_loses_no_sample() {
    for stop in [false, true] {
        let place = Place::new();
        std::fs::create_dir(place.path("gone")).unwrap();
        let spp = if stop { 1 << 20 } else { 512 };
        let line = format!("render {} --size 64x64 --spp {spp} --checkpoint 10ms", cornell_file());
        let mut child = place.start(&format!("{line} -o gone/x.exr"));
        let mut stderr = BufReader::new(child.stderr.take().unwrap());
        let mut said = String::new();
        while !said.contains("etendue: rendering") {
            assert!(stderr.read_line(&mut said).unwrap() > 0, "{said}");
        }
        std::fs::remove_dir_all(place.path("gone")).unwrap();
        if stop {
            sleep(Duration::from_millis(200));
            signal(&child, "TERM");
        }
        stderr.read_to_string(&mut said).unwrap();
        assert_eq!(child.wait().unwrap().code(), Some(4), "{said}");
        assert!(said.contains("gone/x.film") && said.contains("; the render goes on"), "{said}");
        let again = said.rsplit_once("nothing is lost: etendue ").expect("how to go on").1.trim();
        std::fs::create_dir(place.path("gone")).unwrap();
        let film = again.split(' ').nth(1).expect("the film");
        let held = place.report(&format!("status {film}"))["held"].as_u64().unwrap();
        let spp = held.div_ceil(4).next_power_of_two() * 4;
        let again = format!("{again} --spp {spp}");
        let report = place.report(&again);
        let spp = report["render"]["spp"].as_u64().unwrap();
        assert_eq!(
            report["pixel_hash"],
            *place.pixels(&format!("render {} --size 64x64 --spp {spp} -o whole.exr", cornell_file()))
        );
        assert!(exr::read(&place.path("gone/x.exr")).is_ok());
    }
}

/// A picture that cannot be written, which shows while the next one renders, is that picture's failure alone.
#[test]
fn a_folder_that_vanishes_under_a_batch_costs_one_picture() {
    let place = Place::new();
    let job = format!(
        "output = 'out-{{method}}/x.exr'\n[settings]\nsize = '64x64'\nspp = 256\n\
         [[render]]\nscenes = ['{}']\nmethods = ['path', 'bdpt']\n",
        cornell_file()
    );
    std::fs::write(place.path("job.toml"), job).unwrap();
    let mut child = place.start("batch job.toml --json");
    let mut stderr = BufReader::new(child.stderr.take().unwrap());
    let mut said = String::new();
    while !said.contains("etendue: rendering") {
        assert!(stderr.read_line(&mut said).unwrap() > 0, "{said}");
    }
    std::fs::remove_dir_all(place.path("out-path")).unwrap();
    stderr.read_to_string(&mut said).unwrap();
    let output = child.wait_with_output().unwrap();
    assert_eq!(output.status.code(), Some(4), "{said}");
    assert!(
        said.contains("out-path/x.exr: cannot write") && said.contains("nothing is lost: etendue resume"),
        "{said}"
    );
    let summary: serde_json::Value = serde_json::from_slice(&output.stdout).unwrap();
    let outcomes = summary["pictures"].as_array().unwrap().iter().map(|row| row["outcome"].as_str().unwrap());
    assert_eq!(outcomes.collect::<Vec<_>>(), ["failed", "rendered"]);
    assert!(exr::read(&place.path("out-bdpt/x.exr")).is_ok());
}
