//! Hash of what a description says, wherever its files lie and whatever their format.

use super::{Description, Primitive};
use bytemuck::Pod;

/// Hexadecimal BLAKE3 of everything that can change a picture.
pub(in crate::scene) fn of(description: &Description) -> String {
    let mut hasher = blake3::Hasher::new();
    let mut text = |what: String| {
        hasher.update(&(what.len() as u64).to_le_bytes());
        hasher.update(what.as_bytes());
    };
    // Debug output holds every field of the plain data; images print the hash of their texels.
    text(format!("{:?}", description.materials));
    text(format!("{:?}", description.instances));
    text(format!("{:?}", description.lights));
    text(format!("{:?} {:?}", description.cameras, description.environment));
    text(format!("{} {}", description.has_punctual_lights, description.has_emission));
    for primitive in description.meshes.iter().flat_map(|m| &m.primitives) {
        geometry(&mut hasher, primitive);
    }
    hasher.finalize().to_hex()[..32].to_owned()
}

fn geometry(hasher: &mut blake3::Hasher, primitive: &Primitive) {
    array(hasher, Some(&primitive.positions));
    array(hasher, Some(&primitive.triangles));
    array(hasher, primitive.normals.as_ref());
    array(hasher, primitive.tangents.as_ref());
    array(hasher, primitive.uvs[0].as_ref());
    array(hasher, primitive.uvs[1].as_ref());
    array(hasher, primitive.colors.as_ref());
    hasher.update(&(primitive.material as u64).to_le_bytes());
}

/// Length (−1 for none) and bytes.
fn array<T: Pod>(hasher: &mut blake3::Hasher, values: Option<&Vec<T>>) {
    let length = values.map_or(-1, |v| v.len() as i64);
    hasher.update(&length.to_le_bytes());
    if let Some(values) = values {
        hasher.update(bytemuck::cast_slice(values));
    }
}
