//! The table: file, options, methods, and what must come out.

use crate::render::{backends, try_render};

/// A part of a picture with a right value.
struct Case {
    file: &'static str,
    options: &'static str,
    /// Those that see the light.
    methods: &'static [&'static str],
    /// Left, top, right, bottom, as shares of the picture.
    part: [f64; 4],
    right: [f64; 3],
    /// The right value is known within this: half a unit of its last digit, or a bound that the case states.
    within: f64,
}

const WHOLE: [f64; 4] = [0.0, 0.0, 1.0, 1.0];
/// Walks from both ends and chains.
const ALL: &[&str] = &["path", "bdpt", "light", "mlt", "mmlt", "pssmlt"];
/// Lambert surfaces under an environment alone: uniform directions find it too.
const OPEN: &[&str] = &["path", "path-naive", "path-nee", "bdpt", "light", "pssmlt"];
/// What the camera sees directly, with nothing that scatters.
const SEEN: &[&str] = &["path", "path-naive", "bdpt", "mlt"];
/// Through mirrors and glass to the surroundings.
const CLEAR: &[&str] = &["path", "bdpt"];
/// The rounding of a film sum and of f32 arithmetic along a path, relative to values of about 1.
const ROUNDING: f64 = 1e-5;

/// A decal above a wall, which looks the same whatever the gap.
const DECAL: Case = Case {
    file: "touching/decal-gap-1e-06.gltf",
    options: "--size 8x8 --spp 256",
    methods: OPEN,
    part: WHOLE,
    right: [0.125, 0.0, 0.25],
    within: ROUNDING,
};

const CASES: &[Case] = &[
    DECAL,
    Case { file: "touching/decal-gap-2e-06.gltf", ..DECAL },
    // Mitsuba's volpath: .1302 ± .0003.
    Case {
        file: "nested-media/off-centre.gltf",
        options: "--env 0 --size 8x8 --spp 4096",
        methods: &["path", "bdpt", "light", "mlt"],
        part: WHOLE,
        right: [0.1302; 3],
        within: 3e-4,
    },
    // The value is that of the middle of the view; its edge is nearer to the lamp or farther by 2 %, which leaves 3e-4
    // in the mean (7e-5), beside half a unit of the last digit.
    Case {
        file: "camera-in-medium/point-cam1.4.gltf",
        options: "--env 0 --size 8x8 --spp 256",
        methods: &["path", "bdpt", "mlt", "mmlt", "pssmlt"],
        part: WHOLE,
        right: [0.2284, 0.0846, 0.01],
        within: 1.2e-4,
    },
    // One wall at normal incidence: 1 − .04 of the sun on an albedo of .5. Walks from the sun, which meet the floor
    // once in many, have 6e-5 of it in bdpt.
    Case {
        file: "pane/sun-r0.0.gltf",
        options: "--env 0 --size 8x8 --spp 16 --depth 1",
        methods: &["path", "bdpt"],
        part: WHOLE,
        right: [0.48; 3],
        within: 1e-4,
    },
    Case {
        file: "nested-media/control-outer-alone.gltf",
        options: "--size 8x8 --spp 16",
        methods: CLEAR,
        part: WHOLE,
        right: [0.25, 0.0625, 0.015625],
        within: ROUNDING,
    },
    Case {
        file: "unlit/vertex-colours.gltf",
        options: "--env 0 --size 64x32 --spp 4",
        methods: SEEN,
        part: [0.1, 0.2, 0.4, 0.8],
        right: [0.8, 0.2, 0.1],
        within: ROUNDING,
    },
    Case {
        file: "unlit/from-behind.gltf",
        options: "--env 0,0,1 --size 8x8 --spp 4",
        methods: SEEN,
        part: WHOLE,
        right: [0.0, 0.0, 1.0],
        within: ROUNDING,
    },
    Case {
        file: "hidden/lamp-off.gltf",
        options: "--size 8x8 --spp 256 --fps 1 --frame 0",
        methods: ALL,
        part: WHOLE,
        right: [0.0258; 3],
        within: 5e-5,
    },
    Case {
        file: "hidden/lamp-off.gltf",
        options: "--size 8x8 --spp 256 --fps 1 --frame 1",
        methods: ALL,
        part: WHOLE,
        right: [0.0; 3],
        within: 0.0,
    },
    Case {
        file: "hidden/lamp-off.gltf",
        options: "--size 8x8 --spp 256 --fps 1 --frame 2",
        methods: ALL,
        part: WHOLE,
        right: [0.0258; 3],
        within: 5e-5,
    },
    Case {
        file: "hidden/light-of-intensity-0.gltf",
        options: "--size 8x8 --spp 4",
        methods: ALL,
        part: WHOLE,
        right: [0.0; 3],
        within: 0.0,
    },
    Case {
        file: "hidden/appears.gltf",
        options: "--env .5 --size 8x8 --spp 4 --fps 1 --frame 0",
        methods: SEEN,
        part: WHOLE,
        right: [0.5; 3],
        within: ROUNDING,
    },
    // The quad, a quarter of the view, reflects up to 4 % of the blue at its coat.
    Case {
        file: "flat-node/flat-quad-scale-1-1-0.gltf",
        options: "--env 0,0,1 --size 8x8 --spp 4",
        methods: SEEN,
        part: WHOLE,
        right: [0.25, 0.0, 0.75],
        within: 0.01,
    },
    Case {
        file: "env/scene.gltf",
        options: "--env chrAP0.exr --size 4x4 --spp 4",
        methods: SEEN,
        part: WHOLE,
        right: [0.5, 0.25, 0.125],
        within: 5e-4,
    },
];

/// Every case on every backend by every method; all failures are reported.
#[test]
fn each_scene_has_its_right_value() {
    let mut wrong = Vec::new();
    for case in CASES {
        for backend in backends() {
            for method in case.methods {
                let options = format!("{} --method {method}", case.options);
                let what = format!("{} {options} {backend}", case.file);
                match try_render(case.file, &options, backend).map(|picture| picture.mean(case.part)) {
                    Ok(mean) if mean.is(case.right, case.within) => {}
                    Ok(mean) => wrong.push(format!("{what}: {mean:?} and not {:?}", case.right)),
                    Err(console) => wrong.push(format!("{what}: {console}")),
                }
            }
        }
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}
