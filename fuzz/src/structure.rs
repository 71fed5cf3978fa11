//! Mutations of JSON that keep it JSON: numbers become others, parts are removed, doubled, or grafted from elsewhere.

use serde_json::{Number, Value};

/// A small generator; libFuzzer gives the seed, so that a mutation can be replayed.
struct Random(u64);

impl Random {
    /// A number below `n`, which is not 0 (xorshift64).
    fn below(&mut self, n: usize) -> usize {
        self.0 ^= self.0 << 13;
        self.0 ^= self.0 >> 7;
        self.0 ^= self.0 << 17;
        (self.0 >> 11) as usize % n
    }

    fn of<'a, T>(&mut self, choices: &'a [T]) -> &'a T {
        &choices[self.below(choices.len())]
    }
}

/// Changes one to four places of `json`.
pub fn mutate(json: &mut Value, seed: u32) {
    let mut random = Random(u64::from(seed) << 1 | 1);
    for _ in 0..=random.below(4) {
        let donor = pick(json, &mut random).1;
        change(json, donor, &mut random);
    }
}

/// Puts a part of `other` where `json` has one of that name, or into its root.
pub fn cross(json: &mut Value, other: &Value, seed: u32) {
    let mut random = Random(u64::from(seed) << 1 | 1);
    for _ in 0..=random.below(4) {
        let (path, part) = pick(other, &mut random);
        let there = json.pointer_mut(&path).is_some();
        match (there, path.rsplit_once('/')) {
            (true, _) => replace(json, &path, part),
            (false, Some((parent, key))) => insert(json, parent, key, part),
            (false, None) => {}
        }
    }
}

/// Every place in the document, as a JSON pointer.
fn places(json: &Value, at: String, into: &mut Vec<String>) {
    match json {
        Value::Array(elements) => elements.iter().enumerate().for_each(|(i, e)| places(e, format!("{at}/{i}"), into)),
        Value::Object(members) => {
            members.iter().for_each(|(k, v)| places(v, format!("{at}/{}", k.replace('~', "~0").replace('/', "~1")), into));
        }
        _ => {}
    }
    into.push(at);
}

fn pick(json: &Value, random: &mut Random) -> (String, Value) {
    let mut all = Vec::new();
    places(json, String::new(), &mut all);
    let path = random.of(&all).clone();
    let value = json.pointer(&path).cloned().unwrap_or(Value::Null);
    (path, value)
}

fn change(json: &mut Value, donor: Value, random: &mut Random) {
    let (path, value) = pick(json, random);
    let Some((parent, key)) = path.rsplit_once('/') else { return };
    match (random.below(8), value) {
        (0, _) => remove(json, parent, key),
        (1, _) => replace(json, &path, donor),
        (2, value) => insert(json, parent, key, value),
        (3, Value::Array(mut elements)) if !elements.is_empty() => {
            let again = random.of(&elements).clone();
            let times = *random.of(&[1, 2, 17, 300]);
            elements.extend(std::iter::repeat_n(again, times));
            replace(json, &path, Value::Array(elements));
        }
        (_, Value::Number(number)) => replace(json, &path, other_number(&number, random)),
        (_, Value::Bool(b)) => replace(json, &path, Value::Bool(!b)),
        (_, Value::String(_)) => replace(json, &path, Value::from(*random.of(&STRINGS))),
        (4, _) => replace(json, &path, Value::from(*random.of(&INTEGERS))),
        (5, _) => replace(json, parent, donor),
        (_, Value::Object(_)) => insert(json, &path, random.of::<&str>(&KEYS), donor),
        (_, value) => insert(json, parent, key, value),
    }
}

fn replace(json: &mut Value, path: &str, with: Value) {
    if let Some(place) = json.pointer_mut(path) {
        *place = with;
    }
}

fn remove(json: &mut Value, parent: &str, key: &str) {
    match json.pointer_mut(parent) {
        Some(Value::Object(members)) => drop(members.remove(key)),
        Some(Value::Array(elements)) => {
            if let Some(i) = key.parse().ok().filter(|&i| i < elements.len()) {
                elements.remove(i);
            }
        }
        _ => {}
    }
}

/// Before element `key` of an array, or as member `key` of an object.
fn insert(json: &mut Value, parent: &str, key: &str, value: Value) {
    match json.pointer_mut(parent) {
        Some(Value::Object(members)) => drop(members.insert(key.to_owned(), value)),
        Some(Value::Array(elements)) => {
            let at = key.parse().unwrap_or(elements.len()).min(elements.len());
            elements.insert(at, value);
        }
        _ => {}
    }
}

fn other_number(number: &Number, random: &mut Random) -> Value {
    match (number.as_i64(), random.below(4)) {
        (Some(i), 0) => Value::from(i.wrapping_add(1)),
        (Some(i), 1) => Value::from(i.wrapping_sub(1)),
        (_, 2) => Value::from(*random.of(&FLOATS)),
        _ => Value::from(*random.of(&INTEGERS)),
    }
}

const INTEGERS: [i64; 28] = [
    0, 1, 2, 3, 4, 5, 6, 7, 8, 12, 16, 31, 255, 256, 65535, 65536, 5120, 5121, 5122, 5123, 5125, 5126, 0x7fff_ffff, 0xffff_ffff,
    1 << 32, 1 << 40, i64::MAX, -1,
];

const FLOATS: [f64; 14] =
    [0.0, -0.0, 0.5, 1.0, -1.0, 1.5, 1e-7, 1e-30, 1e-46, 1e30, 3.5e38, -1e300, 1e308, 0.333_333_333_333];

const STRINGS: [&str; 22] = [
    "", "SCALAR", "VEC2", "VEC3", "VEC4", "MAT2", "MAT3", "MAT4", "OPAQUE", "MASK", "BLEND", "perspective", "orthographic",
    "point", "spot", "directional", "image/png", "image/jpeg", "2.0", "../x", "data:,abc",
    "data:application/octet-stream;base64,AAAAAAAAAAAAAIA/",
];

const KEYS: [&str; 66] = [
    "EXT_mesh_gpu_instancing", "KHR_lights_punctual", "KHR_materials_emissive_strength", "KHR_materials_ior",
    "KHR_materials_specular", "KHR_materials_transmission", "KHR_materials_unlit", "KHR_materials_volume",
    "KHR_mesh_quantization", "KHR_texture_transform", "POSITION", "NORMAL", "TANGENT", "TEXCOORD_0", "TEXCOORD_1", "COLOR_0",
    "TRANSLATION", "ROTATION", "SCALE", "accessors", "alphaCutoff", "alphaMode", "attributes", "baseColorTexture", "bufferView",
    "byteLength", "byteOffset", "byteStride", "camera", "children", "componentType", "count", "doubleSided", "emissiveFactor",
    "emissiveTexture", "extensions", "extras", "images", "index", "indices", "material", "matrix", "mesh", "meshes",
    "metallicRoughnessTexture", "mode", "nodes", "normalTexture", "normalized", "offset", "pbrMetallicRoughness", "primitives",
    "rotation", "sampler", "samplers", "scale", "scene", "source", "sparse", "targets", "texCoord", "textures", "translation",
    "type", "uri", "values",
];
