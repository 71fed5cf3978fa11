//! Renders that are stopped or killed by signals, and resumed.

use crate::run::{Place, Ran, cornell};
use std::io::{BufRead, BufReader, Read};
use std::process::{Child, ChildStderr, Command};
use std::thread::sleep;
use std::time::{Duration, Instant};

/// Long enough that no machine finishes it before the signal.
const ENDLESS: &str = "--spp 1048576";

pub(crate) fn signal(child: &Child, name: &str) {
    assert!(Command::new("kill").args(["-s", name, &child.id().to_string()]).status().unwrap().success());
}

/// A render that has begun, with what it said on stderr so far.
struct Begun {
    child: Child,
    stderr: BufReader<ChildStderr>,
    said: String,
}

/// Starts an endless render and waits until passes are rendered: signals are heard from then on.
fn begun(place: &Place, options: &str) -> Begun {
    let mut child = place.start(&format!("render {} {ENDLESS} {options}", cornell()));
    let mut stderr = BufReader::new(child.stderr.take().unwrap());
    let mut said = String::new();
    while !said.contains("etendue: rendering") {
        assert!(stderr.read_line(&mut said).unwrap() > 0, "{said}");
    }
    sleep(Duration::from_millis(300));
    Begun { child, stderr, said }
}

fn ended(mut begun: Begun) -> Ran {
    begun.stderr.read_to_string(&mut begun.said).unwrap();
    let mut output = begun.child.wait_with_output().unwrap();
    output.stderr = begun.said.into_bytes();
    Ran(output)
}

#[test]
fn a_stopped_render_resumes_to_the_same_pixels() {
    for name in ["TERM", "INT"] {
        let place = Place::new();
        let begun = begun(&place, "-o x.exr");
        let asked = Instant::now();
        signal(&begun.child, name);
        let ran = ended(begun);
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

/// `timeout` signals a process and its group, so that it receives two.
#[test]
fn signals_at_once_are_one_request() {
    let place = Place::new();
    let begun = begun(&place, "-o x.exr");
    for _ in 0..3 {
        signal(&begun.child, "TERM");
    }
    ended(begun).fails(75, "etendue resume x.film");
    assert!(place.path("x.film").exists());
}

#[test]
fn a_killed_render_leaves_old_files_whole() {
    let place = Place::new();
    for file in ["x.exr", "x.film"] {
        std::fs::write(place.path(file), "old").unwrap();
    }
    let begun = begun(&place, "-o x.exr --film x.film");
    signal(&begun.child, "KILL");
    ended(begun);
    for file in ["x.exr", "x.film"] {
        assert_eq!(std::fs::read(place.path(file)).unwrap(), b"old", "{file}");
    }
}
