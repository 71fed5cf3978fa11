//! Batches of many pictures.

use crate::run::{Place, Ran, cornell, cornell_file};
use crate::signals::signal;
use std::io::{BufRead, BufReader};
use std::process::Child;

/// A batch file in `place`: the Cornell box by path and bdpt, then `more`.
fn job(place: &Place, settings: &str, more: &str) {
    let scene = cornell_file();
    let text = format!(
        "output = '{{scene}}.{{method}}.exr'\n[settings]\nsize = '16x16'\n{settings}\n\
         [[render]]\nscenes = ['{scene}']\nmethods = ['path', 'bdpt']\n{more}"
    );
    std::fs::write(place.path("job.toml"), text).unwrap();
}

fn summary(ran: &Ran) -> serde_json::Value {
    serde_json::from_str(&ran.stdout()).unwrap_or_else(|e| panic!("{e}: {}\n{}", ran.stdout(), ran.stderr()))
}

fn outcomes(summary: &serde_json::Value) -> Vec<String> {
    summary["pictures"].as_array().unwrap().iter().map(|row| row["outcome"].as_str().unwrap().to_owned()).collect()
}

#[test]
fn a_batch_renders_what_single_runs_do_and_nothing_twice() {
    let place = Place::new();
    job(&place, "spp = 8", "");
    let first = place.run("batch job.toml --json");
    assert_eq!(first.code(), 0, "{}", first.stderr());
    let first = summary(&first);
    assert_eq!(outcomes(&first), ["rendered", "rendered"]);
    let single = place.pixels(&format!("render {} --size 16x16 --spp 8 -m bdpt -o single.exr", cornell_file()));
    assert_eq!(first["pictures"][1]["pixel_hash"], *single);
    let second = place.run("batch job.toml --json");
    assert_eq!(outcomes(&summary(&second)), ["complete", "complete"]);
    // Another seed is another picture.
    let third = place.run("batch job.toml --json --seed 1");
    assert_eq!(outcomes(&summary(&third)), ["rendered", "rendered"]);
    assert_eq!(outcomes(&summary(&place.run("batch job.toml --json --seed 1 --again"))), ["rendered", "rendered"]);
    let left: Vec<_> = std::fs::read_dir(place.path(".")).unwrap().map(|f| f.unwrap().file_name()).collect();
    assert!(!left.iter().any(|name| name.to_string_lossy().ends_with(".film")), "{left:?}");
}

#[test]
fn batch_continues_after_a_failed_image() {
    let place = Place::new();
    std::fs::write(place.path("bad.gltf"), "{").unwrap();
    job(
        &place,
        "spp = 4",
        "[[render]]\nscenes = ['bad.gltf', 'none.gltf']\n[[render]]\nscenes = ['bad.gltf']\noutput = 'x/y/last.exr'",
    );
    let ran = place.run("batch job.toml --json");
    assert_eq!(ran.code(), 3);
    let last = ran.stderr().lines().rfind(|l| l.starts_with("etendue: error: ")).unwrap().to_owned();
    assert!(last.contains("3 of 5 pictures"), "{last}");
    let summary = summary(&ran);
    assert_eq!(outcomes(&summary), ["rendered", "rendered", "failed", "failed", "failed"]);
    assert_eq!(summary["exit_code"], 3);
    assert!(summary["pictures"][3]["problem"].as_str().unwrap().contains("none.gltf"));
}

#[test]
fn invalid_batch_is_refused_before_the_first_image() {
    let place = Place::new();
    for (settings, more, what) in [
        ("spp = 4\nshiny = true", "", "shiny"),
        ("spp = 4", "[[render]]\nscenes = ['a.gltf']\noutput = '{film}.exr'", "no field 'film'"),
        ("spp = 4", "[[render]]\nscenes = ['a.gltf']\noutput = 'a.jpg'", ".exr, .png or .film"),
        ("spp = 4\nclamp = -1.0", "", "clamp"),
    ] {
        job(&place, settings, more);
        place.run("batch job.toml").fails(2, what);
    }
    place.run("batch nothing.toml").fails(2, "nothing.toml");
    assert_eq!(std::fs::read_dir(place.path(".")).unwrap().count(), 1, "nothing was left behind");
}

/// Waits until the child has begun its picture number `n`.
fn until_picture(child: &mut Child, n: usize) -> BufReader<std::process::ChildStderr> {
    let mut stderr = BufReader::new(child.stderr.take().unwrap());
    let mut said = String::new();
    while !said.contains(&format!("{n} of ")) || said.matches("etendue: rendering").count() < n {
        assert!(stderr.read_line(&mut said).unwrap() > 0, "{said}");
    }
    stderr
}

#[test]
fn a_stopped_batch_goes_on_where_it_was() {
    let place = Place::new();
    job(&place, "spp = 1048576", "");
    let mut child = place.start("batch job.toml --progress none");
    let stderr = until_picture(&mut child, 1);
    std::thread::sleep(std::time::Duration::from_millis(200));
    signal(&child, "USR1");
    drop(stderr);
    let output = child.wait_with_output().unwrap();
    assert_eq!(output.status.code(), Some(75));
    let told = String::from_utf8(output.stdout).unwrap();
    assert!(told.contains("\nnot-begun") && told.starts_with("stopped"), "{told}");
    let held = place.report("merge cornell-box.path.film --allow-gaps -o held.exr")["render"]["spp"].as_u64().unwrap();
    let goal = held.div_ceil(4).next_power_of_two() * 4;
    job(&place, &format!("spp = {goal}"), "");
    let text = std::fs::read_to_string(place.path("job.toml")).unwrap().replace("'path', 'bdpt'", "'path'");
    std::fs::write(place.path("job.toml"), text).unwrap();
    let ended = summary(&place.run("batch job.toml --json"));
    let whole = place.pixels(&format!("render {} --size 16x16 --spp {goal} -o whole.exr", cornell_file()));
    assert_eq!(ended["pictures"][0]["pixel_hash"], *whole);
    assert!(!place.path("cornell-box.path.film").exists());
}

#[test]
fn skip_complete_continues_an_earlier_film() {
    let place = Place::new();
    let line = format!("render {} --spp 8 -o x.exr --skip-complete", cornell());
    let whole = place.pixels(&line);
    let before = std::fs::metadata(place.path("x.exr")).unwrap().modified().unwrap();
    let again = place.run(&line);
    assert!(again.stdout().contains("complete already"), "{}", again.stdout());
    assert_eq!(std::fs::metadata(place.path("x.exr")).unwrap().modified().unwrap(), before);
    // A film of its first passes is gone on with, and gone when the image is there.
    std::fs::remove_file(place.path("x.exr")).unwrap();
    place.run(&format!("render {} --passes 0..3 -o x.film", cornell()));
    let ran = place.run(&line);
    assert!(ran.stderr().contains("continuing an earlier run after 3 samples"), "{}", ran.stderr());
    assert!(!place.path("x.film").exists());
    assert_eq!(place.pixels(&line.replace("x.exr", "y.exr")), whole);
    // One of another picture is not.
    std::fs::remove_file(place.path("x.exr")).unwrap();
    place.run(&format!("render {} --passes 0..3 --seed 7 -o x.film", cornell()));
    let ran = place.run(&line);
    assert!(!ran.stderr().contains("continuing"), "{}", ran.stderr());
    assert!(place.path("x.film").exists());
}

#[test]
fn a_png_alone_is_complete_too_and_a_picture_with_gaps_is_not() {
    let place = Place::new();
    let line = format!("render {} --spp 8 -o x.png --skip-complete", cornell());
    assert_eq!(place.run(&line).code(), 0);
    assert!(place.run(&line).stdout().contains("complete already: x.png"));
    assert!(!place.run(&line.replace("spp 8", "spp 8 --exposure 1")).stdout().contains("complete already"));
    let line = format!("render {} --spp 8 -o y.exr --skip-complete", cornell());
    place.run(&format!("render {} --spp 8 --shard 0/2 -o half.film", cornell()));
    assert_eq!(place.run("merge half.film --allow-gaps -o y.exr").code(), 0);
    assert!(!place.run(&line).stdout().contains("complete already"));
    assert!(place.run(&line).stdout().contains("complete already: y.exr"));
}

#[test]
fn progress_and_status_are_reported_as_json() {
    let place = Place::new();
    let openjd = place.run(&format!("render {} --spp 8 -o x.exr --progress openjd", cornell())).stdout();
    let told: Vec<u64> = openjd.lines().filter_map(|l| l.strip_prefix("openjd_progress: ")?.parse().ok()).collect();
    assert!(told.windows(2).all(|w| w[0] < w[1]) && told.last() == Some(&100), "{openjd}");
    let alf = place.run(&format!("render {} --spp 8 -o x.exr --progress alf", cornell())).stdout();
    assert!(alf.contains("ALF_PROGRESS 100%"), "{alf}");
    let status = place.run(&format!("render {} --spp 8 -o x.exr --status json --shard 1/2", cornell())).stdout();
    let events: Vec<serde_json::Value> = status.lines().filter_map(|l| serde_json::from_str(l).ok()).collect();
    let of = |name: &str| events.iter().filter(|e| e["event"] == name).count();
    assert_eq!((of("begin"), of("complete")), (1, 1), "{status}");
    let last = events.last().unwrap();
    assert_eq!((&last["passes"], &last["shard"], &last["percent"]), (&4.into(), &"1/2".into(), &100.into()));
    assert!(last["rays_per_second"].as_f64().unwrap() > 0.0 && last["rss_bytes"].as_u64().unwrap() > 1 << 20);
}

#[test]
fn frames_are_pictures_of_their_own() {
    let place = Place::new();
    let ran = place.run(&format!("render {} --spp 4 --frames 1,3-5x2 -o out/{{scene}}.{{frame:04}}.exr", cornell()));
    assert_eq!(ran.code(), 0, "{}", ran.stderr());
    for frame in [1, 3, 5] {
        assert!(place.path(&format!("out/cornell-box.{frame:04}.exr")).exists(), "{}", ran.stdout());
    }
    place.run(&format!("render {} --spp 4 --frames 1-3 -o x.exr", cornell())).fails(2, "two pictures");
    assert!(place.run(&format!("render {} --frames 3-1", cornell())).code() == 2);
}

#[test]
fn init_writes_a_commented_render_toml() {
    let place = Place::new();
    assert_eq!(place.run("init").code(), 0);
    let text = std::fs::read_to_string(place.path("render.toml")).unwrap();
    // The example of a medium is one.
    let medium: String =
        text.lines().skip_while(|line| *line != "# [media.fog]").map(|line| line[2..].to_owned() + "\n").collect();
    etendue::session::SettingsPatch::parse(&medium).unwrap().overrides().unwrap();
    assert!(text.contains("# spp = 64") && text.contains("# One of path-naive, path-nee, path"), "{text}");
    place.run("init").fails(2, "--force");
    assert_eq!(place.run("init --force").code(), 0);
}

/// A program that stops reading does not cost the picture.
#[test]
fn closed_stdout_is_no_error() {
    let place = Place::new();
    let mut child = place.start(&format!("render {} --spp 64 --status json -o x.exr", cornell()));
    drop(child.stdout.take());
    child.wait().unwrap();
    assert!(place.path("x.exr").exists());
    job(&place, "spp = 8", "");
    let mut child = place.start("batch job.toml");
    drop(child.stdout.take());
    child.wait().unwrap();
    assert!(place.path("cornell-box.path.exr").exists() && place.path("cornell-box.bdpt.exr").exists());
}

/// What a person asks about a film, a machine and the command line gets an answer.
#[test]
fn films_and_machines_are_described() {
    let place = Place::new();
    place.run(&format!("render {} --spp 8 --shard 0/2 -o x.film", cornell()));
    let status = place.run("status x.film").stdout();
    assert!(status.contains("4 of 4, 100 %") && status.contains("32x32, path"), "{status}");
    assert_eq!(place.run("status none.film").code(), 3);
    let watched = place.run("watch x.film --every 10ms");
    assert!(watched.stdout().contains("image: x.png") && place.path("x.png").exists(), "{}", watched.stderr());
    let doctor = place.report("doctor");
    assert!(doctor["threads"].as_u64().unwrap() > 0 && doctor["problems"].as_array().unwrap().is_empty(), "{doctor}");
    assert!(place.run("completions bash").stdout().contains("etendue__subcmd__batch"));
    assert_eq!(place.run("man pages").code(), 0);
    assert!(std::fs::read_to_string(place.path("pages/etendue-render.1")).unwrap().contains("skip\\-complete"));
}

/// A budget is kept before the kernel has to.
#[test]
fn render_beyond_the_memory_budget_is_refused() {
    let place = Place::new();
    place.run(&format!("render {} --memory 1M -o x.exr", cornell())).fails(33, "GB are available");
    place
        .run(&format!("render {} --memory plenty -o x.exr", cornell()))
        .fails(2, "'plenty' is not an amount of memory");
    assert_eq!(place.run(&format!("render {} --spp 4 --memory 2G -o x.exr", cornell())).code(), 0);
}

/// The viewer receives the image. Without a listener the render is the same.
#[test]
fn tev_viewer_receives_the_image() {
    let place = Place::new();
    let listener = std::net::TcpListener::bind("127.0.0.1:0").unwrap();
    let port = listener.local_addr().unwrap().port();
    let seen = std::thread::spawn(move || {
        let mut bytes = Vec::new();
        std::io::Read::read_to_end(&mut listener.accept().unwrap().0, &mut bytes).unwrap();
        bytes
    });
    let line = format!("render {} --spp 4 -o x.exr --view 127.0.0.1:{port}", cornell());
    let shown = place.pixels(&line);
    let bytes = seen.join().unwrap();
    // Each packet begins with its length; the first makes an image (4) and the others fill it, a number a pixel and
    // channel.
    let length = u32::from_le_bytes(bytes[..4].try_into().unwrap()) as usize;
    assert_eq!(bytes[4], 4);
    assert!(String::from_utf8_lossy(&bytes[..length]).contains("cornell-box"));
    assert!(bytes.len() > length + 32 * 32 * 3 * 4, "{} bytes", bytes.len());
    let alone = place.run(&format!("{line} --json"));
    assert!(alone.stderr().contains("no viewer listens"), "{}", alone.stderr());
    assert!(alone.stdout().contains(&shown));
    place.run(&format!("render {} --view nowhere", cornell())).fails(2, "'nowhere' is not the address of a viewer");
}
