//! Memory of emissive triangles. Each placed triangle is a light of its own, since instances do not share lights.

use crate::error::{Error, Kind, Result};
use crate::scene::description::{Description, Material, Mesh};

/// Bytes of a light, including its entry in light selection.
const BYTES_A_LIGHT: u64 = 256;

/// Rejects emissive meshes whose lights exceed `memory` bytes.
///
/// # Errors
/// An error of class memory that names the mesh with most of them, and the remedy.
pub(super) fn afford(out: &Description, materials: &[Material], memory: u64) -> Result<()> {
    let emits: Vec<bool> = materials.iter().map(|m| !m.emission.is_black()).collect();
    let emitting = |mesh: &Mesh| {
        mesh.primitives
            .iter()
            .filter(|p| emits[p.material])
            .map(|p| p.triangles.len() as u64)
            .fold(0, u64::saturating_add)
    };
    let mut places = vec![0u64; out.meshes.len()];
    out.instances.iter().for_each(|instance| places[instance.mesh] += 1);
    let lamps: Vec<[u64; 2]> = out.meshes.iter().zip(places).map(|(mesh, places)| [emitting(mesh), places]).collect();
    let lights = lamps.iter().fold(0u64, |sum, [a, b]| sum.saturating_add(a.saturating_mul(*b)));
    let need = lights.saturating_mul(BYTES_A_LIGHT);
    let most = (0..lamps.len()).max_by_key(|&i| lamps[i][0].saturating_mul(lamps[i][1]));
    let Some(most) = most.filter(|_| need > memory) else { return Ok(()) };
    let ([triangles, places], name) = (lamps[most], &out.meshes[most].name);
    let (need, have) = (need as f64 / 1e9, memory as f64 / 1e9);
    Err(Error::new(
        Kind::Memory,
        format!(
            "{lights} emitting triangles would take {need:.2} GB as lights and {have:.2} GB are available: {triangles} \
             of mesh '{name}' emit at each of {places} places; give it more with --memory, or let fewer triangles emit"
        ),
    ))
}
