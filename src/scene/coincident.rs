//! Emitters that coincide: a lamp that was exported twice shines twice, and nobody sees why.

use super::ObjectInfo;
use super::description::{Description, PunctualLight};
use crate::geometry::{Geometry, Hit};
use crate::light::Light;
use glam::Vec3;
use std::collections::HashMap;

/// How many pairs are named; of more it is said that there are.
const NAMED: usize = 4;

/// A sentence for each pair of lights without extent that are alike, and each pair of emitting objects of which triangles coincide.
pub(super) fn emitters(description: &Description, objects: &[ObjectInfo], geometry: &Geometry, lights: &[Light]) -> Vec<String> {
    let mut pairs = alike(&description.lights);
    let name = |object: u32| description.instances[objects[object as usize].instance as usize].name.clone();
    for [a, b] in coincident(objects, geometry, lights) {
        pairs.push([name(a), name(b)]);
    }
    let more = pairs.len().saturating_sub(NAMED);
    let said = pairs.iter().take(NAMED);
    let mut sentences: Vec<String> =
        said.map(|[a, b]| format!("lights '{a}' and '{b}' coincide and shine twice (was a lamp exported twice?)")).collect();
    if more > 0 {
        sentences.push(format!("{more} more pairs of lights coincide"));
    }
    sentences
}

/// Names of neighbouring lights without extent that are equal in all but their names.
fn alike(lights: &[PunctualLight]) -> Vec<[String; 2]> {
    let mut first: HashMap<String, &str> = HashMap::new();
    let mut pairs = Vec::new();
    for light in lights.iter().filter(|l| !l.intensity.is_black()) {
        let key = format!("{:?} {:?} {:?}", light.kind, light.intensity, light.transform);
        if let Some(other) = first.insert(key, &light.name) {
            pairs.push([other.to_owned(), light.name.clone()]);
        }
    }
    pairs
}

/// Emitting objects of which some triangle has the corners of another one's, each pair once.
fn coincident(objects: &[ObjectInfo], geometry: &Geometry, lights: &[Light]) -> Vec<[u32; 2]> {
    let mut first: HashMap<[[u32; 3]; 3], u32> = HashMap::new();
    let mut pairs: Vec<[u32; 2]> = Vec::new();
    for (object, info) in (0..).zip(objects) {
        let Some(light) = info.first_light else { continue };
        if lights[light as usize].is_only_seen() {
            continue;
        }
        for primitive in 0..geometry.mesh_of(object).triangles().len() as u32 {
            let mut corners =
                geometry.triangle(Hit { object, primitive }).vertices.map(|p: Vec3| (p + 0.0).to_array().map(f32::to_bits));
            corners.sort_unstable();
            match first.insert(corners, object) {
                Some(other) if other != object && pairs.last() != Some(&[other, object]) => pairs.push([other, object]),
                _ => {}
            }
        }
    }
    pairs
}
