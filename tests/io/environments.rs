//! Environment files, good and bad.

use etendue::error::{Kind, Result};
use etendue::io::environment::{self, LoadedMap};
use etendue::io::exr::{self, Layer};
use std::path::{Path, PathBuf};

struct Folder(tempfile::TempDir);

impl Folder {
    fn new() -> Self {
        Folder(tempfile::tempdir().expect("a temporary folder"))
    }

    fn path(&self, name: &str) -> PathBuf {
        self.0.path().join(name)
    }

    /// A 3×2 picture with these channels, all of these values.
    fn exr(&self, name: &str, channels: &[&str], values: [f32; 6]) -> PathBuf {
        let layer = |name: &&str| Layer { name: (*name).into(), values: values.to_vec() };
        let layers: Vec<Layer> = channels.iter().map(layer).collect();
        let path = self.path(name);
        exr::write(&path, 3, 2, None, &layers, &[]).expect("a written file");
        path
    }

    fn bytes(&self, name: &str, bytes: &[u8]) -> PathBuf {
        let path = self.path(name);
        std::fs::write(&path, bytes).expect("a written file");
        path
    }
}

/// The sentence of an error of class scene, checked to be one line that names the file.
fn sentence(path: &Path, result: Result<LoadedMap>) -> String {
    let error = result.expect_err("an error");
    assert_eq!(error.kind, Kind::Scene, "{error}");
    let chain = error.chain();
    assert!(chain.contains(&path.display().to_string()) && !chain.contains('\n'), "{chain}");
    chain
}

fn hdr(size: &str, texels: &[[u8; 4]]) -> Vec<u8> {
    [format!("#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n{size}\n").as_bytes(), texels.as_flattened()].concat()
}

#[test]
fn colours_are_found_under_their_usual_names() {
    let folder = Folder::new();
    let values = [0.0, 1.0, 2.0, 3.0, 4.0, 5.0];
    for channels in [&["R", "G", "B", "A"][..], &["sky.R", "sky.G", "sky.B", "depth.Z"], &["Y"]] {
        let map = environment::load(&folder.exr("a.exr", channels, values), None).expect("a map").map;
        assert_eq!(map.size(), [3, 2]);
        assert_eq!(map.row(1), [[3.0; 3], [4.0; 3], [5.0; 3]], "{channels:?}");
    }
}

#[test]
fn radiance_pictures_are_read() {
    let folder = Folder::new();
    let path = folder.bytes("a.HDR", &hdr("-Y 2 +X 1", &[[128, 64, 32, 129], [1, 2, 4, 136]]));
    let map = environment::load(&path, None).expect("a map").map;
    assert_eq!((map.row(0), map.row(1)), (&[[1.0, 0.5, 0.25]][..], &[[1.0, 2.0, 4.0]][..]));
}

#[test]
fn negative_texels_count_as_black_and_are_counted() {
    let folder = Folder::new();
    let path = folder.exr("a.exr", &["R", "G", "B"], [1.0, -1.0, 0.0, -0.0, -2.0, 7.0]);
    let loaded = environment::load(&path, None).expect("a map");
    assert_eq!(loaded.map.row(0), [[1.0; 3], [0.0; 3], [0.0; 3]]);
    assert!(loaded.warnings[0].contains("a.exr: 2 texels") && loaded.lost.is_empty(), "{:?}", loaded.warnings);
}

#[test]
fn invalid_environment_maps_are_refused_in_one_sentence() {
    let folder = Folder::new();
    let ones = [1.0; 6];
    let nan = [1.0, f32::NAN, f32::INFINITY, 2e30, 0.0, 0.0];
    let header = "#?RADIANCE\n\n-Y 65536 +X 65536\n";
    for (path, what) in [
        (folder.exr("nan.exr", &["R", "G", "B"], nan), "2 of its 6 texels are not numbers or beyond 1e30"),
        (folder.exr("rg.exr", &["R", "G"], ones), "no channels R, G and B"),
        (folder.bytes("text.exr", b"no picture at all"), "text.exr"),
        (folder.bytes("empty.hdr", b""), "not a Radiance picture"),
        (folder.bytes("huge.hdr", header.as_bytes()), "more than 30 bytes can hold"),
        (folder.bytes("short.hdr", &hdr("-Y 2 +X 3", &[[9; 4]; 5])), "ends too early"),
        (folder.bytes("sky.png", b"\x89PNG"), "neither in .exr nor in .hdr"),
        (folder.path("none.exr"), "none.exr"),
        (folder.path("none.hdr"), "none.hdr"),
    ] {
        let said = sentence(&path, environment::load(&path, None));
        assert!(said.contains(what), "{said}");
    }
    let device = Path::new("/dev/zero");
    assert!(sentence(device, environment::load(device, None)).contains("regular file"));
    let directory = folder.path("folder.hdr");
    std::fs::create_dir(&directory).expect("a folder");
    assert!(sentence(&directory, environment::load(&directory, None)).contains("regular file"));
}

/// Headers that claim billions of pixels are refused before memory is asked for.
#[test]
fn claims_of_an_exr_header_are_bounded_by_its_file() {
    let folder = Folder::new();
    let path = folder.exr("a.exr", &["R", "G", "B"], [1.0; 6]);
    let mut bytes = std::fs::read(&path).expect("a file");
    for window in ["dataWindow", "displayWindow"] {
        let name = bytes.windows(window.len()).position(|w| w == window.as_bytes()).expect("the attribute");
        let value = name + window.len() + 1 + "box2i\0".len() + 4;
        bytes[value + 8..value + 16].copy_from_slice(&[0xff, 0xff, 0x0f, 0, 0xff, 0xff, 0x0f, 0]);
    }
    let path = folder.bytes("claims.exr", &bytes);
    assert!(sentence(&path, environment::load(&path, None)).contains("bytes can hold"));
}

#[test]
fn cut_files_end_in_a_sentence() {
    let folder = Folder::new();
    let whole = std::fs::read(folder.exr("a.exr", &["R", "G", "B"], [1.0; 6])).expect("a file");
    for length in (0..whole.len()).step_by(7) {
        let path = folder.bytes("cut.exr", &whole[..length]);
        sentence(&path, environment::load(&path, None));
    }
    let whole = hdr("-Y 2 +X 3", &[[9, 9, 9, 130]; 6]);
    for length in 0..whole.len() {
        let path = folder.bytes("cut.hdr", &whole[..length]);
        sentence(&path, environment::load(&path, None));
    }
}

/// Values of a channel in every third, with the names of a Blender file.
fn layered(folder: &Folder, names: [(&str, f32); 6]) -> PathBuf {
    let layers = names.map(|(name, value)| Layer { name: name.into(), values: vec![value; 6] });
    let path = folder.path("layers.exr");
    exr::write(&path, 3, 2, None, &layers, &[]).expect("a written file");
    path
}

/// What is likely to be the picture is taken and named, unless another layer is asked for by its name or the end of it.
#[test]
fn a_layer_is_chosen_and_named() {
    let folder = Folder::new();
    let [albedo, combined] = ["Denoising.Albedo", "ViewLayer.Combined"];
    let names = [("R", 0.1), ("G", 0.1), ("B", 0.1)].map(|(c, v)| (format!("{albedo}.{c}"), v));
    let more = ["R", "G", "B"].map(|c| (format!("{combined}.{c}"), 2.0));
    let all: Vec<(&str, f32)> = names.iter().chain(&more).map(|(n, v)| (n.as_str(), *v)).collect();
    let path = layered(&folder, all.try_into().expect("six channels"));
    let taken = environment::load(&path, None).expect("a map");
    assert_eq!(taken.map.row(0)[0].map(f32::to_bits), [2.0f32.to_bits(); 3]);
    assert!(taken.warnings[0].contains("'ViewLayer.Combined' is taken") && taken.warnings[0].contains("--env-layer"));
    for (name, value) in [(albedo, 0.1), ("Albedo", 0.1), (combined, 2.0), ("ViewLayer", 2.0)] {
        assert_eq!(
            environment::load(&path, Some(name)).expect("a map").map.row(1)[2].map(f32::to_bits),
            [f32::to_bits(value); 3],
            "{name}"
        );
    }
    let said = sentence(&path, environment::load(&path, Some("Combin")));
    assert!(said.contains("no layer 'Combin'") && said.contains(albedo) && said.contains(combined), "{said}");
    let hdr = folder.bytes("a.hdr", &hdr("-Y 1 +X 1", &[[1; 4]]));
    assert!(sentence(&hdr, environment::load(&hdr, Some("x"))).contains("no layers"));
}

/// What is infinite becomes the largest finite number of the picture, and `--strict` can refuse it.
#[test]
fn infinite_texels_are_clamped_and_told() {
    let folder = Folder::new();
    let path = folder.exr("sun.exr", &["R", "G", "B"], [1.0, f32::INFINITY, 0.0, 9.0, f32::NEG_INFINITY, 2.0]);
    assert!(sentence(&path, environment::load(&path, None)).contains("1 of its 6 texels"));
    let path = folder.exr("sun.exr", &["R", "G", "B"], [1.0, f32::INFINITY, 0.0, 9.0, 3.0, 2.0]);
    let loaded = environment::load(&path, None).expect("a map");
    assert_eq!(loaded.map.row(0)[1].map(f32::to_bits), [9.0f32.to_bits(); 3]);
    assert!(loaded.lost[0].contains("sun.exr: 1 texels are infinite and count as 9"), "{:?}", loaded.lost);
}

/// A picture of one colour, with its chromaticities in the header of a Radiance file: XYZ of (.5 .25 .125) in Rec. 709,
/// and the same in ACES's AP0.
#[test]
fn colours_become_rec_709() {
    let folder = Folder::new();
    // A mantissa of 8 bits, rounded down or up.
    let rounding = 1.0 / 128.0;
    let [x, y, z] = [0.318_147, 0.294_124, 0.158_319].map(|v: f64| (v * 256.0).round() as u8);
    let header = |lines: &str| format!("#?RADIANCE\n{lines}\n\n-Y 1 +X 1\n");
    let ap0 = "PRIMARIES= .7347 .2653 0 1 .0001 -.077 .32168 .33767";
    let [r, g, b] = [0.333_85, 0.262_1, 0.157].map(|v: f64| (v * 256.0).round() as u8);
    for (lines, texel) in [("FORMAT=32-bit_rle_xyze", [x, y, z, 128]), (ap0, [r, g, b, 128])] {
        let bytes = [header(lines).as_bytes(), &texel].concat();
        let map = environment::load(&folder.bytes("a.hdr", &bytes), None).expect("a map").map;
        for (lane, want) in map.row(0)[0].into_iter().zip([0.5, 0.25, 0.125]) {
            // Half a step in each of three lanes, times coefficients up to 3.3 in all 5.3.
            assert!((lane - want).abs() <= 5.3 * 0.5 * rounding, "{lines}: {lane} is not {want}");
        }
    }
}
