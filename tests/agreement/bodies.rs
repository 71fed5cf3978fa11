//! Bodies in bodies, cameras and lamps in bodies, and panes between them: every method on every backend against closed
//! forms. Bodies of index 1 do not bend light, so that what reaches the camera by one diffuse reflection is an integral
//! over the film.

use crate::picture::{Shot, agree, expect, render, scene_under};
use etendue::accel::Backend;
use etendue::bsdf::Shading;
use etendue::camera::{CameraSample, LensPoint};
use etendue::integrator::Method;
use etendue::path::{RandomWalk, TraceStats};
use etendue::sampling::{Address, IndependentSampler};
use etendue::scene::Scene;
use etendue::scene::description::{Description, EnvironmentDescription, Material, PunctualKind, Volume};
use etendue::spectrum::Spectrum;
use etendue::transport::TransportMode;
use etendue_testing::studio::{Ball, add_box, add_room, add_square, camera, glass, matte, point_light, with_model};
use glam::{DVec3, Vec3};
use std::f64::consts::PI;

const ALBEDO: f32 = 0.5;
const INTENSITY: f32 = 4.0;
const FLOOR: f64 = -1.0;
/// Samples of the film along an axis that stand for its integral.
const GRID: u32 = 96;

/// A block of index 1 that absorbs `sigma` per metre.
#[derive(Clone, Copy)]
struct Block {
    centre: DVec3,
    half: DVec3,
    sigma: f64,
    priority: i32,
}

const fn block(centre: [f64; 3], half: [f64; 3], sigma: f64) -> Block {
    Block { centre: DVec3::from_array(centre), half: DVec3::from_array(half), sigma, priority: 0 }
}

/// A wide thin pane of index 1.5 at a height, with its tint and the share that it transmits.
type Pane = (f64, f32, f32);

/// A floor under a lamp, seen from above, and what stands between.
struct Case {
    name: &'static str,
    lamp: Option<[f64; 3]>,
    eye: [f64; 3],
    blocks: Vec<Block>,
    panes: Vec<Pane>,
}

fn solid(ior: f32, sigma: f64) -> Material {
    with_model(glass(0.0), |m| {
        m.ior = ior;
        m.volume = Some(Volume { absorption: Spectrum::splat(sigma as f32), ..Volume::CLEAR });
    })
}

fn pane(tint: f32, transmission: f32) -> Material {
    with_model(matte(tint, 0.0), |m| {
        m.specular = 1.0;
        m.transmission = transmission;
        m.roughness = 0.0;
    })
}

impl Case {
    fn description(&self) -> Description {
        let mut scene = Description::default();
        add_square(&mut scene, Vec3::new(0.0, FLOOR as f32, 0.0), Vec3::X * 2.0, Vec3::NEG_Z * 2.0, matte(ALBEDO, 0.0));
        for block in &self.blocks {
            let material = Material { priority: block.priority, ..solid(1.0, block.sigma) };
            add_box(&mut scene, block.centre.as_vec3(), block.half.as_vec3(), material);
        }
        for &(height, tint, transmission) in &self.panes {
            let wide = 2.5;
            add_square(
                &mut scene,
                Vec3::Y * height as f32,
                Vec3::X * wide,
                Vec3::NEG_Z * wide,
                pane(tint, transmission),
            );
        }
        let mut light = point_light(DVec3::from(self.lamp.unwrap_or_default()), INTENSITY);
        if self.lamp.is_none() {
            light.kind = PunctualKind::Directional;
            light.transform = camera(DVec3::Y, DVec3::ZERO).transform;
        }
        scene.lights.push(light);
        scene.cameras.push(camera(DVec3::from(self.eye), DVec3::new(0.0, FLOOR, 0.0)));
        scene
    }

    /// What is left of light between two points.
    fn through(&self, a: DVec3, b: DVec3) -> f64 {
        let mut cuts = vec![0.0, 1.0];
        for Block { centre, half, .. } in &self.blocks {
            for (face, axis) in [-1.0, 1.0].into_iter().flat_map(|side| (0..3).map(move |axis| (side, axis))) {
                cuts.push(((centre[axis] + face * half[axis] - a[axis]) / (b - a)[axis]).clamp(0.0, 1.0));
            }
        }
        cuts.retain(|t: &f64| t.is_finite());
        cuts.sort_by(f64::total_cmp);
        let depth: f64 = cuts.windows(2).map(|w| self.sigma(a.lerp(b, 0.5 * (w[0] + w[1]))) * (w[1] - w[0])).sum();
        let walls = self.panes.iter().filter(|(height, ..)| (a.y - height) * (b.y - height) < 0.0);
        let cos = ((b - a).normalize().y).abs();
        let f = 0.04 + 0.96 * (1.0 - cos).powi(5);
        let passed: f64 = walls.map(|&(_, tint, transmission)| (1.0 - f) * f64::from(tint * transmission)).product();
        (-depth * (b - a).length()).exp() * passed
    }

    /// The absorption at a point: of the highest priority, then of the smallest block.
    fn sigma(&self, p: DVec3) -> f64 {
        let inside = self.blocks.iter().filter(|b| (p - b.centre).abs().cmple(b.half).all());
        let volume = |b: &Block| b.half.x * b.half.y * b.half.z;
        let first = inside.min_by(|a, b| b.priority.cmp(&a.priority).then(volume(a).total_cmp(&volume(b))));
        first.map_or(0.0, |b| b.sigma)
    }

    /// Mean radiance of the picture, by so many samples of the film along an axis.
    fn radiance(&self, scene: &Scene, grid: u32) -> f64 {
        let camera = scene.camera(None, grid, grid).expect("a camera");
        let mut sum = 0.0;
        for i in 0..grid * grid {
            let ray = camera.ray([(i % grid) as f32 + 0.5, (i / grid) as f32 + 0.5]);
            let (eye, w) = (scene.rebase().point_in_file(ray.origin.as_dvec3()), ray.direction.as_dvec3());
            let p = eye + w * ((FLOOR - eye.y) / w.y);
            let (lamp, falloff) = match self.lamp {
                Some(lamp) => {
                    let to = DVec3::from(lamp) - p;
                    (DVec3::from(lamp), to.y / to.length().powi(3))
                }
                None => (p + DVec3::Y * 10.0, 1.0),
            };
            sum += f64::from(ALBEDO * INTENSITY) / PI * falloff * self.through(p, lamp) * self.through(p, eye);
        }
        sum / f64::from(grid * grid)
    }

    /// All of `methods`, on all backends. The integral is as uncertain as it changes with half the samples.
    fn check(&self, methods: &[(Method, u64, f64)]) {
        for &backend in Backend::AVAILABLE {
            let scene = scene_under(backend, self.description());
            let [value, coarse] = [GRID, GRID / 2].map(|grid| self.radiance(&scene, grid));
            let by = (value - coarse).abs() + 1e-5 * value;
            for &(method, spp, planted) in methods {
                let picture = render(&scene, Shot { depth: Some(1), ..Shot::new(method, 16, spp) });
                expect(&picture, [value - by, value + by], planted, &format!("{}, {method:?}, {backend:?}", self.name));
            }
        }
    }
}

const LAMP: Option<[f64; 3]> = Some([0.4, 0.6, 0.2]);
const EYE: [f64; 3] = [0.0, 0.9, 0.1];

/// Number `i` of blocks in each other, every third of them clear.
fn shell(i: f64) -> Block {
    block([0.0, -0.2, 0.0], [1.6 - 0.1 * i, 0.65 - 0.05 * i, 1.6 - 0.1 * i], i % 3.0)
}

fn nested() -> Vec<Case> {
    let case = |name, blocks| Case { name, lamp: LAMP, eye: EYE, blocks, panes: Vec::new() };
    let first = |priority, block| Block { priority, ..block };
    vec![
        case(
            "three clear blocks in each other",
            vec![
                block([0.0, -0.2, 0.0], [1.5, 0.5, 1.5], 0.0),
                block([0.0, -0.2, 0.0], [1.4, 0.4, 1.4], 0.0),
                block([0.1, -0.2, 0.0], [1.2, 0.3, 1.2], 0.0),
            ],
        ),
        case("twelve shells", (0..12).map(|i| shell(f64::from(i))).collect()),
        case("a lamp in a tinted block", vec![block([0.4, 0.6, 0.2], [0.3, 0.2, 0.3], 1.5)]),
        case("all in a tinted block", vec![block([0.0, 0.0, 0.0], [3.0, 3.0, 3.0], 0.8)]),
        case(
            "clear in tinted",
            vec![block([0.0, -0.2, 0.0], [1.7, 0.6, 1.7], 1.0), block([0.3, -0.1, 0.0], [0.9, 0.3, 1.3], 0.0)],
        ),
        case(
            "tinted in tinted",
            vec![block([0.0, -0.2, 0.0], [1.7, 0.6, 1.7], 0.4), block([0.3, -0.1, 0.0], [0.9, 0.3, 1.3], 2.0)],
        ),
        case(
            "lamp and camera in different blocks",
            vec![block([0.4, 0.6, 0.2], [0.2, 0.2, 0.1], 3.0), block([-0.1, 1.0, 0.1], [0.25, 0.3, 0.25], 1.0)],
        ),
        case(
            "a drink that overlaps its glass",
            vec![block([0.0, -0.4, 0.0], [1.5, 0.5, 1.5], 0.5), block([0.0, 0.0, 0.0], [1.4, 0.3, 1.4], 1.5)],
        ),
        case(
            "a glass that has priority over its drink",
            vec![
                first(2, block([0.0, -0.4, 0.0], [1.5, 0.5, 1.5], 0.5)),
                first(-1, block([0.0, 0.0, 0.0], [1.4, 0.3, 1.4], 1.5)),
            ],
        ),
        case(
            "touching blocks with a small overlap",
            vec![block([0.0, -0.4, 0.0], [1.5, 0.301, 1.5], 0.7), block([0.0, 0.1, 0.0], [1.5, 0.2, 1.5], 1.4)],
        ),
        case(
            "a lamp in a block in a block",
            vec![block([0.4, 0.5, 0.2], [0.5, 0.35, 0.5], 0.5), block([0.4, 0.6, 0.2], [0.3, 0.2, 0.3], 2.0)],
        ),
    ]
}

fn panes() -> Vec<Case> {
    let case = |name, lamp, panes| Case { name, lamp, eye: [0.0, 0.2, 0.1], blocks: Vec::new(), panes };
    vec![
        case("a pane before a lamp", LAMP, vec![(0.4, 1.0, 1.0)]),
        case("a tinted pane of half transmission before a lamp", LAMP, vec![(0.4, 0.8, 0.5)]),
        case("two panes before the sun", None, vec![(0.4, 1.0, 1.0), (0.7, 0.9, 1.0)]),
        case("a pane between camera and floor", LAMP, vec![(-0.5, 0.9, 1.0)]),
        Case {
            blocks: vec![block([0.0, 0.0, 0.0], [1.7, 0.65, 1.7], 0.4)],
            ..case("a pane in a block", LAMP, vec![(0.4, 1.0, 1.0)])
        },
    ]
}

/// Method, samples a pixel, and an error that must be convicted.
const FAST: [(Method, u64, f64); 2] = [(Method::Path, 16, 0.02), (Method::Bdpt, 16, 0.05)];
const FROM_LIGHTS: [(Method, u64, f64); 1] = [(Method::Light, 512, 0.1)];
const CHAINS: [(Method, u64, f64); 2] = [(Method::Mlt, 64, 0.1), (Method::Pssmlt, 64, 0.1)];

#[test]
fn nested_bodies_absorb_by_precedence() {
    nested().iter().for_each(|case| case.check(&FAST));
}

#[test]
fn light_subpaths_start_in_the_medium_of_the_lamp() {
    let with_lamps = |case: &&Case| case.name.contains("lamp");
    nested().iter().filter(with_lamps).for_each(|case| case.check(&FROM_LIGHTS));
}

#[test]
fn light_subpaths_track_nested_media() {
    let without_lamps = |case: &&Case| !case.name.contains("lamp");
    nested().iter().filter(without_lamps).for_each(|case| case.check(&FROM_LIGHTS));
}

#[test]
fn metropolis_tracks_nested_media() {
    nested().iter().for_each(|case| case.check(&CHAINS));
}

#[test]
fn panes_transmit_area_and_directional_lights() {
    panes().iter().for_each(|case| case.check(&FAST));
}

#[test]
fn light_subpaths_and_metropolis_pass_panes() {
    [&FROM_LIGHTS[..], &CHAINS[..]].iter().for_each(|how| panes().iter().for_each(|case| case.check(how)));
}

/// A box of panes over a floor under a white sky: each direction crosses one pane. Lights found by walks and by samples
/// are the same light, and it counts once.
#[test]
fn environment_behind_panes_is_counted_once() {
    let mut description = Description::default();
    add_square(&mut description, Vec3::NEG_Y, Vec3::X, Vec3::NEG_Z, matte(ALBEDO, 0.0));
    for (n, u) in
        [(Vec3::Y, Vec3::X), (Vec3::X, Vec3::Y), (Vec3::NEG_X, Vec3::Y), (Vec3::Z, Vec3::X), (Vec3::NEG_Z, Vec3::X)]
    {
        add_square(&mut description, n, u, n.cross(u), pane(1.0, 1.0));
    }
    description.environment = Some(EnvironmentDescription::Uniform(Spectrum::ONE));
    let view = camera(DVec3::new(0.0, -0.8, 0.0), DVec3::new(0.0, -1.0, 0.0));
    description.cameras.push(etendue_testing::studio::narrow(view, 0.02));
    let n = 400;
    let mut passed = 0.0;
    for i in 0..n * n {
        // Cosine-distributed directions from the middle of the floor, and the pane that each meets.
        let (r, phi) = ((f64::from(i % n) + 0.5) / f64::from(n), 2.0 * PI * (f64::from(i / n) + 0.5) / f64::from(n));
        let w = DVec3::new(r.sqrt() * phi.cos(), (1.0 - r).sqrt(), r.sqrt() * phi.sin());
        let reach = DVec3::new(1.0, 2.0, 1.0) / w.abs();
        let cos = if reach.y < reach.x.min(reach.z) { w.y } else { w.x.abs().max(w.z.abs()) };
        passed += 0.96 * (1.0 - (1.0 - cos).powi(5)) / f64::from(n * n);
    }
    for &backend in Backend::AVAILABLE {
        let scene = scene_under(backend, description_again(&description));
        let methods = [
            (Method::PathNaive, 256, 0.1),
            (Method::PathNee, 64, 0.05),
            (Method::Path, 64, 0.02),
            (Method::Bdpt, 64, 0.05),
        ];
        for (method, spp, planted) in methods {
            let picture = render(&scene, Shot { depth: Some(1), ..Shot::new(method, 16, spp) });
            let value = f64::from(ALBEDO) * passed;
            // The view is a tenth of a degree wide, and the sum over directions as fine.
            expect(&picture, [value * 0.999, value * 1.001], planted, &format!("{method:?}, {backend:?}"));
        }
    }
}

fn description_again(d: &Description) -> Description {
    let mut copy =
        Description { environment: d.environment.clone(), cameras: d.cameras.clone(), ..Description::default() };
    for mesh in &d.meshes {
        let p = &mesh.primitives[0];
        etendue_testing::studio::add(
            &mut copy,
            p.positions.clone(),
            p.triangles.clone(),
            d.materials[p.material].clone(),
        );
    }
    copy
}

/// Where a ray comes out that goes on through every boundary it meets.
fn comes_out(scene: &Scene, ray: etendue::geometry::Ray) -> RandomWalk<'_> {
    let sample = CameraSample { film: [0.0; 2], lens: LensPoint::CENTRE, ray, medium: None };
    let mut walk = RandomWalk::from_camera(scene, &sample);
    let (mut numbers, mut tally) = (IndependentSampler::new(Address::new(1)), TraceStats::default());
    while let Some(mut point) = walk.arrive(&mut numbers, &mut tally) {
        let surface = scene.surface(&mut point, walk.ray.state.bodies);
        let shading = Shading::new(&point, &surface, -walk.ray.direction, TransportMode::Radiance).expect("flat faces");
        let scatter = shading.sample([1.0 - f32::EPSILON, 0.5, 0.5]).expect("it goes on");
        walk.depart(&point, (&point).into(), &scatter);
    }
    walk
}

/// Snell's law between the indices on both sides: a wedge of 1.5 in a block of 1.33, and one of 1.33 that is not there.
#[test]
fn refraction_uses_the_iors_on_both_sides() {
    for (ior, outer) in [(1.5f64, 1.33f64), (1.33, 1.33), (1.0, 1.33), (1.5, 1.0)] {
        for &backend in Backend::AVAILABLE {
            let mut description = Description::default();
            add_box(&mut description, Vec3::ZERO, Vec3::ONE, solid(outer as f32, 0.0));
            // Its upper face falls 30 degrees toward +x.
            let (l, h) = (0.8, 0.8 * 3f32.sqrt().recip());
            let at = |x: f32, y: f32| [Vec3::new(x, y, -0.5), Vec3::new(x, y, 0.5)];
            let corners = [at(-l, h), at(-l, -0.6), at(l, -0.6), at(l, -h)].concat();
            let sides = [[0, 2, 3], [0, 3, 1], [2, 4, 5], [2, 5, 3], [4, 6, 7], [4, 7, 5], [6, 0, 1], [6, 1, 7]];
            let caps = [[0, 6, 4], [0, 4, 2], [1, 5, 7], [1, 3, 5]];
            let triangles = sides.into_iter().chain(caps).collect();
            etendue_testing::studio::add(&mut description, corners, triangles, solid(ior as f32, 0.0));
            description.environment = Some(EnvironmentDescription::Uniform(Spectrum::ONE));
            let scene = scene_under(backend, description);
            let origin = scene.rebase().point(DVec3::new(0.1, 2.0, 0.05)).as_vec3();
            let out = comes_out(&scene, etendue::geometry::Ray::new(origin, Vec3::NEG_Y)).ray.direction.as_dvec3();
            let inside = 30f64.to_radians() - (30f64.to_radians().sin() * outer / ior).asin();
            let sin = inside.sin() * ior;
            // Four refractions, each a dozen roundings.
            assert!(
                (out.x.abs() - sin.abs()).abs() < 48.0 * f64::from(f32::EPSILON),
                "{ior} in {outer}: {out} for {sin}"
            );
            assert_eq!(out.x > 1e-6, sin < -1e-6, "{out} for {sin}");
        }
    }
}

/// In a body under a white sky all that is clear is as bright: n² of the medium that the camera stands in, whatever
/// else is there.
#[test]
fn a_camera_in_water_sees_the_sky_through_glass() {
    let mut description = Description::default();
    add_box(&mut description, Vec3::ZERO, Vec3::ONE, solid(1.33, 0.0));
    Ball::new(2, 0.3).add(&mut description, DVec3::new(0.1, 0.0, -0.2), solid(1.5, 0.0));
    Ball::new(1, 0.1).add(&mut description, DVec3::new(0.1, 0.0, -0.2), solid(1.0, 0.0));
    add_box(&mut description, Vec3::new(0.9, 0.0, 0.0), Vec3::splat(0.25), solid(1.7, 0.0));
    description.environment = Some(EnvironmentDescription::Uniform(Spectrum::ONE));
    description.cameras.push(camera(DVec3::new(0.0, 0.05, 0.8), DVec3::ZERO));
    for &backend in Backend::AVAILABLE {
        let scene = scene_under(backend, description_again(&description));
        for method in [Method::Path, Method::Bdpt] {
            let picture = render(&scene, Shot::new(method, 16, 64));
            let value = 1.33f64.powi(2);
            // Scale factors of f32 along a path.
            expect(&picture, [value * (1.0 - 1e-4), value * (1.0 + 1e-4)], 0.05, &format!("{method:?}, {backend:?}"));
        }
    }
}

/// A room with a block of glass, and the same with balls of equal index in it: the same picture by every method.
#[test]
fn bodies_of_equal_ior_are_invisible() {
    let room = |filled: bool| {
        let mut description = Description::default();
        add_room(&mut description, &matte(0.6, 0.0));
        add_square(&mut description, Vec3::new(0.2, 0.9, 0.1), Vec3::X * 0.4, Vec3::Z * 0.4, matte(0.0, 6.0));
        add_box(&mut description, Vec3::new(0.0, -0.4, -0.2), Vec3::new(0.5, 0.4, 0.4), solid(1.5, 0.5));
        if filled {
            Ball::new(2, 0.35).add(&mut description, DVec3::new(0.0, -0.4, -0.2), solid(1.5, 0.5));
            Ball::new(2, 0.2).add(&mut description, DVec3::new(0.1, -0.4, -0.2), solid(1.5, 0.5));
        }
        description.cameras.push(camera(DVec3::new(0.0, 0.1, 0.95), DVec3::new(0.0, -0.3, -0.2)));
        description
    };
    let empty = scene_under(Backend::default(), room(false));
    let reference = render(&empty, Shot::new(Method::Bdpt, 16, 128));
    for &backend in Backend::AVAILABLE {
        let scene = scene_under(backend, room(true));
        for method in [Method::Path, Method::Bdpt, Method::Mmlt, Method::Mlt] {
            let picture = render(&scene, Shot { seed: 2, ..Shot::new(method, 16, 128) });
            agree(&picture, &reference, 2).unwrap_or_else(|e| panic!("{method:?}, {backend:?}: {e}"));
        }
    }
}
