//! Cases whose right value is no constant: bounds, positions, twins, sentences.

use crate::render::{backends, render};

const WHOLE: [f64; 4] = [0.0, 0.0, 1.0, 1.0];

/// A glass cube stands on a table of albedo (.5, 0, 0) under a white sky: what is not red is reflected by the glass,
/// twice at most.
#[test]
fn table_under_glass_is_visible() {
    for file in
        ["touching/glass-on-table-01.gltf", "touching/glass-on-table-02.gltf", "touching/glass-on-table-07.gltf"]
    {
        for backend in backends() {
            for method in ["path", "bdpt"] {
                let mean =
                    render(file, &format!("--env 1 --size 8x8 --spp 256 --method {method}"), backend).mean(WHOLE);
                assert!(mean.is_at_most([0.5, 0.08, 0.08]), "{file} {backend} {method}: {mean:?}");
                assert!(mean.value[0] > 0.25, "{file} {backend} {method}: {mean:?}");
            }
        }
    }
}

/// An orthographic beam through a wedge of index 1.5 in a slab of 1.33 lands at x = −.3206 on a ramp of red from x = −4
/// to 4 by Snell's law. Green and blue are constant there. Light reflected within the slab is up to 1 % of the rest and
/// lands within the ramp.
#[test]
fn wedge_in_a_slab_refracts_by_the_ratio_of_iors() {
    for backend in backends() {
        for method in ["path", "bdpt"] {
            let options = format!("--env 0 --size 8x8 --spp 64 --method {method}");
            let [red, green, _] = render("nested-media/wedge-1.33-1.5.gltf", &options, backend).mean(WHOLE).value;
            let x = red / green * 8.0 - 4.0;
            assert!((x + 0.3206).abs() < 0.01 * 8.0 * 0.5, "{backend} {method}: {x}");
        }
    }
}

/// KHR_texture_transform of a normal map is the same as texture coordinates that have it already.
#[test]
fn a_transform_of_a_normal_map_turns_its_tangents() {
    for backend in backends() {
        let [baked, extension] = ["baked", "extension"].map(|kind| {
            let file = format!("normal-map-transform/rot90_{kind}_+x.gltf");
            render(&file, "--size 16x16 --spp 16", backend).mean(WHOLE)
        });
        // The rotation of the extension is rounded to f32.
        assert!(extension.is(baked.value, 1e-5), "{backend}: {baked:?}, {extension:?}");
    }
}

/// Clear things in a white world are white, whatever their normals; the camera's frame holds nothing else.
#[test]
fn clear_glass_with_averaged_normals_keeps_its_light() {
    for (file, least) in [("tube-tilted", 0.97), ("cube-smooth", 0.97), ("cube-flat", 0.9999)] {
        for backend in backends() {
            for method in ["path", "bdpt"] {
                let options = format!("--env 1 --size 32x32 --spp 16 --method {method}");
                let mean = render(&format!("smooth-glass/{file}.gltf"), &options, backend).mean(WHOLE);
                let [r, _, _] = mean.value;
                assert!(
                    r + 4.0 * mean.error[0] >= least && r <= 1.0 + 1e-4 + 4.0 * mean.error[0],
                    "{file} {backend} {method}: {mean:?}"
                );
            }
        }
    }
}

/// Infinite texels are clamped, and the console says so.
#[test]
fn an_infinite_sun_is_clamped() {
    let picture =
        render("env/scene.gltf", "--env sun-inf.exr --size 4x4 --spp 4", backends().next().expect("a backend"));
    assert!(picture.console.contains("not finite") || picture.console.contains("infinite"), "{}", picture.console);
    assert!(picture.mean(WHOLE).value.iter().all(|v| v.is_finite()));
}

/// Emissive meshes at many places are bounded by memory, not by the size of the file.
#[test]
fn many_bulbs_render() {
    for backend in backends() {
        let mean = render("bulbs/300-16-ext0-em1.glb", "--env 0 --size 32x18 --spp 4", backend).mean(WHOLE);
        assert!(mean.value.iter().all(|&v| v > 0.0), "{mean:?}");
    }
}

/// Zero padding after the JSON of a GLB, a byte order mark before that of a .gltf, a spot without a soft edge: read.
#[test]
fn files_of_other_exporters_are_read() {
    for file in ["container/nul.glb", "container/bom.gltf", "spot/blender-blend0.0-size60.gltf"] {
        render(file, "--size 8x8 --spp 1", backends().next().expect("a backend"));
    }
}
