//! Coincident emitters: a lamp that was exported twice is twice as bright, which is hard to notice.

use super::ObjectInfo;
use super::description::{Description, PunctualLight};
use crate::geometry::{Geometry, Hit};
use crate::light::Light;
use glam::Vec3;
use std::collections::HashMap;

/// Number of pairs that are listed; further pairs are only mentioned.
const NAMED: usize = 4;

/// Returns a sentence for each pair of equal punctual lights, and each pair of emitting objects with coincident
/// triangles.
pub(super) fn emitters(
    description: &Description,
    objects: &[ObjectInfo],
    geometry: &Geometry,
    lights: &[Light],
) -> Vec<String> {
    let mut pairs = alike(&description.lights);
    let name = |object: u32| description.instances[objects[object as usize].instance as usize].name.clone();
    for [a, b] in coincident(objects, geometry, lights) {
        pairs.push([name(a), name(b)]);
    }
    let more = pairs.len().saturating_sub(NAMED);
    let said = pairs.iter().take(NAMED);
    let mut sentences: Vec<String> = said
        .map(|[a, b]| format!("lights '{a}' and '{b}' coincide and shine twice (was a lamp exported twice?)"))
        .collect();
    if more > 0 {
        sentences.push(format!("{more} more pairs of lights coincide"));
    }
    sentences
}

/// Returns the names of neighbouring punctual lights that are equal except for their names.
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

/// Returns the pairs of emitting objects that share a triangle with the same corners, each pair once.
fn coincident(objects: &[ObjectInfo], geometry: &Geometry, lights: &[Light]) -> Vec<[u32; 2]> {
    let mut first: HashMap<[[u32; 3]; 3], u32> = HashMap::new();
    let mut pairs: Vec<[u32; 2]> = Vec::new();
    for (object, info) in (0..).zip(objects) {
        let Some(light) = info.first_light else { continue };
        if lights[light as usize].is_only_seen() {
            continue;
        }
        for primitive in 0..geometry.mesh_of(object).triangles().len() as u32 {
            let mut corners = geometry
                .triangle(Hit { object, primitive })
                .vertices
                .map(|p: Vec3| (p + 0.0).to_array().map(f32::to_bits));
            corners.sort_unstable();
            match first.insert(corners, object) {
                Some(other) if other != object && pairs.last() != Some(&[other, object]) => pairs.push([other, object]),
                _ => {}
            }
        }
    }
    pairs
}
