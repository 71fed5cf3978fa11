//! Any bytes as a glTF file: loading, at a time of its animations and without them, and building the scene ends, within
//! time and memory, in a scene or one sentence.

#![no_main]

use etendue::accel::Backend;
use etendue::io::scene_file::ReadOptions;
use etendue::light::EmitterPoint;
use etendue::scene::{BuildOptions, Edge, EdgeEnd, Scene};
use etendue_fuzz::{Container, check};
use libfuzzer_sys::{fuzz_crossover, fuzz_mutator, fuzz_target, fuzzer_mutate};
use std::path::Path;

fuzz_target!(|bytes: &[u8]| {
    let options = BuildOptions { backend: Backend::Obvhs, threads: 1, ..BuildOptions::default() };
    // As much as libFuzzer leaves.
    let load = |seconds| {
        let reading = ReadOptions { seconds, memory: 1 << 28, ..ReadOptions::default() };
        etendue::io::gltf::parse(bytes, Path::new("/nonexistent"), &reading)
    };
    // Broken animations are to leave the rest to be fuzzed.
    let loaded = load(Some(0.25)).inspect_err(check).or_else(|_| load(None));
    let scene = loaded.and_then(|d| Scene::build(d, &options));
    match scene {
        Ok(scene) => look(&scene),
        Err(error) => check(&error),
    }
});

/// A few rays of the scene's camera, and what is on the edges beyond what they meet.
fn look(scene: &Scene) {
    let Ok(camera) = scene.camera(None, 4, 4) else { return };
    for at in [[0.5, 0.5], [2.0, 2.0], [3.5, 1.0]] {
        let ray = camera.ray(at);
        let bodies = scene.bodies_at(ray.origin);
        if let Some(mut point) = scene.intersect(&ray) {
            scene.surface(&mut point, bodies);
            let state = ray.state.within(bodies);
            let edge = Edge::new(scene, &point, state, ray.direction, EdgeEnd::Light(EmitterPoint::Distant));
            scene.is_blocked(&edge, &mut 0);
        }
    }
}

fuzz_mutator!(|data: &mut [u8], size: usize, max_size: usize, seed: u32| {
    // One in four by bytes: the container and the parser want to be fuzzed too.
    let container = if seed % 4 == 0 { None } else { Container::parse(&data[..size]) };
    let Some(mut container) = container else { return fuzzer_mutate(data, size, max_size) };
    match &mut container.binary {
        Some(binary) if seed % 4 == 1 && !binary.is_empty() => {
            let length = binary.len();
            binary.resize(length + 64, 0);
            let room = binary.len();
            let new = fuzzer_mutate(binary, length, room);
            binary.truncate(new);
        }
        _ => etendue_fuzz::mutate(&mut container.json, seed),
    }
    put(&container.write(), data, max_size).unwrap_or(size)
});

fuzz_crossover!(|one: &[u8], two: &[u8], out: &mut [u8], seed: u32| {
    let room = out.len();
    let crossed = Container::parse(one).zip(Container::parse(two)).and_then(|(mut one, two)| {
        etendue_fuzz::cross(&mut one.json, &two.json, seed);
        if one.binary.as_ref().is_none_or(|b| b.is_empty()) {
            one.binary = two.binary;
        }
        put(&one.write(), out, room)
    });
    crossed.unwrap_or_else(|| put(one, out, room).unwrap_or(0))
});

/// Writes `bytes` if they fit; how many they are.
fn put(bytes: &[u8], into: &mut [u8], room: usize) -> Option<usize> {
    into.get_mut(..bytes.len()).filter(|_| bytes.len() <= room)?.copy_from_slice(bytes);
    Some(bytes.len())
}
