//! `[media.NAME]` of render.toml: what it changes, what is refused, and that films remember it.

use crate::run::{Place, cornell_file};
use etendue::io::exr;

const LINE: &str = "render s/scene.gltf --size 8x8 --spp 8 --filter box --depth 4";

/// A triangle of clear glass before a white environment.
const SCENE: &str = r#"{"asset":{"version":"2.0"},"nodes":[{"mesh":0},{"mesh":1,"translation":[3,0,0]},{"camera":0,"translation":[0.3,0.3,1]}],
"extensionsUsed":["KHR_materials_transmission"],
"materials":[{"name":"pane","pbrMetallicRoughness":{"metallicFactor":0,"roughnessFactor":0},"extensions":{"KHR_materials_transmission":{"transmissionFactor":1}}},{"name":"wall"}],
"cameras":[{"type":"orthographic","orthographic":{"xmag":0.6,"ymag":0.6,"zfar":9,"znear":0.1}}],
"meshes":[{"primitives":[{"attributes":{"POSITION":0},"material":0}]},
{"primitives":[{"attributes":{"POSITION":0},"material":1}]}],"buffers":[{"byteLength":36,
"uri":"data:application/octet-stream;base64,AAAAAAAAAAAAAAAAAACAPwAAAAAAAAAAAAAAAAAAgD8AAAAA"}],
"bufferViews":[{"buffer":0,"byteLength":36}],"accessors":[{"bufferView":0,"componentType":5126,"count":3,"type":"VEC3",
"min":[0,0,0],"max":[1,1,0]}]}"#;

fn place(toml: &str) -> Place {
    let place = Place::new();
    std::fs::create_dir(place.path("s")).unwrap();
    std::fs::write(place.path("s/scene.gltf"), SCENE).unwrap();
    tell(&place, toml);
    place
}

fn tell(place: &Place, toml: &str) {
    std::fs::write(place.path("s/render.toml"), format!("env = 1.0\n{toml}")).unwrap();
}

/// A Mitsuba volume of one cell in a box around the pane, a metre thick.
fn write_volume(place: &Place, name: &str, value: f32) {
    let mut bytes = b"VOL\x03".to_vec();
    [1i32, 1, 1, 1, 1].iter().for_each(|n| bytes.extend(n.to_le_bytes()));
    [-2.0f32, -2.0, -0.5, 2.0, 2.0, 0.5, value].iter().for_each(|x| bytes.extend(x.to_le_bytes()));
    std::fs::write(place.path(name), bytes).unwrap();
}

/// The mean over pixels and lanes of a render.
fn light(place: &Place, toml: &str) -> f32 {
    tell(place, toml);
    place.report(&format!("{LINE} -o a.exr"));
    let pixels = exr::read(&place.path("a.exr")).unwrap().rgb("").unwrap();
    pixels.iter().sum::<f32>() / pixels.len() as f32
}

#[test]
fn media_fill_the_scene_the_box_of_a_density_and_solids() {
    let place = place("");
    write_volume(&place, "s/fog.vol", 2.0);
    let light = |toml: &str| light(&place, toml);
    let clear = light("");
    let fog = light("[media.fog]\nabsorption = 0.25\n");
    let thick = light("[media.fog]\nabsorption = 0.5\nfills = \"scene\"\n");
    let grid = light("[media.fog]\nabsorption = 0.25\ndensity = \"fog.vol\"\n");
    assert!(0.2 < thick && thick < 0.9 * fog && fog < 0.9 * clear, "{thick} {fog} {clear}");
    // The camera looks through a metre of twice the coefficient, and what the pane reflects comes as far: exp(−0.5).
    assert!((grid / clear / (-0.5f32).exp() - 1.0).abs() < 1e-4, "{grid} {clear}"); // roundings of 64 pixels
    let glass = light("[media.tint]\nabsorption = [5, 5, 5]\nfills = [\"pane\"]\n");
    assert!(glass < clear, "the open pane has an inside: {glass} {clear}");
}

#[test]
fn media_that_make_no_sense_are_refused() {
    let place = place("");
    write_volume(&place, "s/fog.vol", -2.0);
    write_volume(&place, "s/hot.vol", 2e6);
    for (toml, code, what) in [
        ("absorbtion = 1", 2, "[media.fog] has the unknown key 'absorbtion'"),
        ("absorption = -1", 2, "[media.fog].absorption is neither"),
        ("phase = 0.5", 2, "[media.fog] has a phase, but no scattering"),
        ("temperature = 1500", 2, "[media.fog] has the key temperature, but no emission"),
        ("emission = 1\ntemperature = 1", 2, "[media.fog].temperature is no number of kelvins from 500"),
        ("fills = 3", 2, "[media.fog].fills is neither"),
        ("absorption = 1\nfills = [\"water\"]", 2, "the scene has no material 'water'"),
        ("absorption = 1\nfills = [\"wall\"]", 2, "no light enters the material 'wall'"),
        ("absorption = 1\ndensity = \"none.vol\"", 3, "none.vol"),
        ("absorption = 1\ndensity = \"fog.vol\"", 3, "fog.vol"),
        ("emission-grid = \"fog.vol\"", 2, "[media.fog] has the key emission_grid, but no emission"),
        ("emission = 1\ntemperature-grid = \"hot.vol\"", 3, "the temperature of cell 0 is 2000000"),
        (
            "emission = 1\ntemperature = 900\ntemperature-grid = \"fog.vol\"",
            2,
            "[media.fog] has more than one of temperature, temperature_grid, emission_grid",
        ),
        ("scattering = 1\nalbedo-grid = \"fog.vol\"", 3, "fog.vol"),
        ("scattering = 1\nemission = 1\n[media.b]\nphase = \"mie\"\nscattering = 1", 2, "[media.b].phase is neither"),
    ] {
        tell(&place, &format!("[media.fog]\n{toml}\n"));
        let ran = place.run(&format!("{LINE} -o a.exr"));
        assert!(ran.code() == code && ran.stderr().contains(what), "{toml}: {} {}", ran.code(), ran.stderr());
    }
    tell(&place, "[media.fire]\nemission = 1\n");
    place.run(&format!("{LINE} --method light -o a.exr")).fails(2, "media that emit");
}

#[test]
fn films_remember_their_media_and_refuse_others() {
    let fog = "[media.fog]\nabsorption = 0.25\ndensity = \"fog.vol\"\n";
    let place = place(fog);
    write_volume(&place, "s/fog.vol", 2.0);
    let whole = place.pixels(&format!("{LINE} --spp 16 -o a.exr").replace("--spp 8 ", ""));
    place.report(&format!("{LINE} -o a.film"));
    // What render.toml says now is not what the film began with.
    tell(&place, "");
    assert_eq!(place.pixels("resume a.film --spp 16"), whole);
    place.report(&format!("{LINE} --shard 0/2 -o 0.film"));
    tell(&place, fog);
    place.report(&format!("{LINE} --shard 1/2 -o 1.film"));
    place.run("merge 0.film 1.film -o a.exr").fails(2, "scenes");
}

/// A tetrahedron of wax in a white environment.
const WAX: &str = r#"{"asset":{"version":"2.0"},"nodes":[{"mesh":0},{"camera":0,"translation":[0.2,0.2,3]}],
"extensionsUsed":["KHR_materials_transmission","KHR_materials_volume"],"materials":[{"pbrMetallicRoughness":
{"metallicFactor":0,"roughnessFactor":0},"extensions":{"KHR_materials_transmission":{"transmissionFactor":1},
"KHR_materials_volume":{"thicknessFactor":1}},"extras":{"etendue":{"albedo":0.8,"mean_free_path":0.01}}}],
"cameras":[{"type":"orthographic","orthographic":{"xmag":0.6,"ymag":0.6,"zfar":9,"znear":0.1}}],
"meshes":[{"primitives":[{"attributes":{"POSITION":0},"indices":1,"material":0}]}],"buffers":[{"byteLength":72,
"uri":"data:application/octet-stream;base64,AAAAAAAAAAAAAAAAAACAPwAAAAAAAAAAAAAAAAAAgD8AAAAAAAAAAAAAAAAAAIA/AAACAAEAAAABAAMAAAADAAIAAQACAAMA"}],"bufferViews":[{"buffer":0,"byteLength":48},{"buffer":0,
"byteOffset":48,"byteLength":24}],"accessors":[{"bufferView":0,"componentType":5126,"count":4,"type":"VEC3",
"min":[0,0,0],"max":[1,1,1]},{"bufferView":1,"componentType":5123,"count":12,"type":"SCALAR"}]}"#;

/// A picture with a diffusion model is approximate, and says so in all that is written about it.
#[test]
fn diffusion_models_call_their_pictures_approximate() {
    let place = place("");
    std::fs::write(place.path("s/wax.gltf"), WAX).unwrap();
    let line = "render s/wax.gltf --size 8x8 --spp 4 --subsurface burley";
    let ran = place.run(&format!("{line} -o a.png"));
    assert_eq!(ran.code(), 0, "{}", ran.stderr());
    assert!(ran.stderr().contains("approximate: subsurface scattering by burley"), "{}", ran.stderr());
    let png = std::fs::read(place.path("a.png")).unwrap();
    assert!(png.windows(11).any(|text| text == b"Approximate"));
    let report = place.report(&format!("{line} -o b.exr"));
    assert_eq!(report["approximate"], "subsurface scattering by burley");
    assert_eq!(report["settings"]["subsurface"], "burley");
    // The walk is not, nor is another method with the same option.
    for other in ["--subsurface burley --method bdpt", ""] {
        let line = format!("render s/wax.gltf --size 8x8 --spp 4 {other} -o c.exr");
        assert!(place.report(&line)["approximate"].is_null(), "{other}");
    }
    place
        .run(&format!("render {} --subsurface dipole -o d.png", cornell_file()))
        .fails(2, "the scene has no body for --subsurface dipole");
    place.run(&format!("{line}x -o e.png")).fails(2, "burleyx");
}

/// The tables that a user asks for have the medium's row, and what makes no sense is refused.
#[test]
fn bench_diffusion_prints_tables() {
    let place = Place::new();
    let ran = place.run("bench diffusion --albedos 0.8 --paths 2000 --index 1.3");
    let text = ran.stdout();
    assert!(
        text.contains("photon-beam") && text.lines().filter(|line| line.starts_with("| 0.8 |")).count() == 2,
        "{text}"
    );
    place.run("bench diffusion --albedos 1.5").fails(2, "albedos must be above 0 and below 1");
    place.run("bench diffusion --mean-cosine -0.99").fails(2, "mean-cosine must be");
    place.run("bench diffusion --index 0.5").fails(2, "index must be from 1 to 3");
}
