//! Stopped, killed and resumed.

use crate::run::{Place, Ran, cornell};
use std::process::{Child, Command};
use std::thread::sleep;
use std::time::{Duration, Instant};

/// Long enough that no machine finishes it before the signal.
const ENDLESS: &str = "--spp 1048576";

fn signal(child: &Child, name: &str) {
    assert!(Command::new("kill").args(["-s", name, &child.id().to_string()]).status().unwrap().success());
}

/// Starts an endless render and waits until it renders: passes are committed from then on.
fn begun(place: &Place, options: &str) -> Child {
    let child = place.start(&format!("render {} {ENDLESS} {options}", cornell()));
    // Signals are heard once the scene is built; there is no other sign of it than time.
    sleep(Duration::from_secs(2));
    child
}

fn ended(child: Child) -> Ran {
    Ran(child.wait_with_output().unwrap())
}

#[test]
fn a_stopped_render_resumes_to_the_same_pixels() {
    for name in ["TERM", "INT"] {
        let place = Place::new();
        let child = begun(&place, "-o x.exr");
        let asked = Instant::now();
        signal(&child, name);
        let ran = ended(child);
        ran.fails(75, "etendue resume x.film");
        assert!(asked.elapsed() < Duration::from_secs(10));
        assert!(!place.path("x.exr").exists());
        let held = place.report("resume x.film --spp 4 -o x.exr");
        let spp = held["render"]["spp"].as_u64().unwrap();
        let goal = spp.div_ceil(4).next_power_of_two() * 4;
        let whole = place.pixels(&format!("render {} --spp {goal} -o whole.exr", cornell()));
        assert_eq!(place.pixels(&format!("resume x.film --spp {goal} -o x.exr")), whole);
    }
}

#[test]
fn a_killed_render_leaves_old_files_whole() {
    let place = Place::new();
    for file in ["x.exr", "x.film"] {
        std::fs::write(place.path(file), "old").unwrap();
    }
    let child = begun(&place, "-o x.exr --film x.film");
    signal(&child, "KILL");
    child.wait_with_output().unwrap();
    for file in ["x.exr", "x.film"] {
        assert_eq!(std::fs::read(place.path(file)).unwrap(), b"old", "{file}");
    }
}
