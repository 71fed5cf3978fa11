//! Usage of textures and vertex colours by material: their extremes over the coordinates of all primitives with the
//! material.

use super::description::{Description, Material, MaterialModel, Primitive};
use crate::texture::{Extremes, Texture};
use glam::Vec2;
use rayon::prelude::*;

/// Extremes of the multipliers of a material's factors; [`Extremes::ONE`] without a multiplier.
#[derive(Debug, Clone, Copy)]
pub(super) struct Usage {
    /// Base colour or reflectance.
    pub(super) base: Extremes,
    /// Alpha.
    pub(super) alpha: Extremes,
    /// Roughness in green, metalness in blue.
    pub(super) metallic_roughness: Extremes,
    /// Emission.
    pub(super) emission: Extremes,
    /// Strength of the dielectric reflection in alpha.
    pub(super) specular: Extremes,
    /// Its colour.
    pub(super) specular_color: Extremes,
    /// Transmission in red.
    pub(super) transmission: Extremes,
    /// Vertex colours.
    pub(super) colors: Extremes,
}

impl Usage {
    /// Usage without variation.
    pub(super) const NOTHING: Usage = Usage {
        base: Extremes::ONE,
        alpha: Extremes::ONE,
        metallic_roughness: Extremes::ONE,
        emission: Extremes::ONE,
        specular: Extremes::ONE,
        specular_color: Extremes::ONE,
        transmission: Extremes::ONE,
        colors: Extremes::ONE,
    };

    /// Returns the usage of each material of `description`.
    pub(super) fn of_all(description: &Description) -> Vec<Usage> {
        let mut placed = vec![false; description.meshes.len()];
        description.instances.iter().for_each(|instance| placed[instance.mesh] = true);
        let mut wearers = vec![Vec::new(); description.materials.len()];
        let shown = description.meshes.iter().zip(placed).filter(|(_, placed)| *placed);
        for primitive in shown.flat_map(|(mesh, _)| &mesh.primitives) {
            wearers[primitive.material].push(primitive);
        }
        description.materials.par_iter().zip(wearers).map(|(m, wearers)| Usage::of(m, &wearers)).collect()
    }

    fn of(m: &Material, wearers: &[&Primitive]) -> Usage {
        if wearers.is_empty() {
            return Usage::NOTHING;
        }
        let united = |all: &dyn Fn(&Primitive) -> Extremes| {
            wearers.iter().fold(Extremes::NONE, |found, wearer| found.united(all(wearer)))
        };
        let of = |texture: &Option<Texture>| {
            texture.as_ref().map_or(Extremes::ONE, |t| united(&|wearer| t.extremes(coordinates(wearer, t.uv_set))))
        };
        let shared = Usage {
            alpha: of(&m.alpha_texture),
            emission: of(&m.emission_texture),
            colors: united(&colors),
            ..Usage::NOTHING
        };
        match &m.model {
            MaterialModel::Unlit => shared,
            MaterialModel::Diffuse(m) => Usage { base: of(&m.reflectance_texture), ..shared },
            MaterialModel::MetallicRoughness(m) => Usage {
                base: of(&m.base_color_texture),
                metallic_roughness: of(&m.metallic_roughness_texture),
                specular: of(&m.specular_texture),
                specular_color: of(&m.specular_color_texture),
                transmission: of(&m.transmission_texture),
                ..shared
            },
        }
    }
}

/// Returns the texture coordinates of the primitive's triangles; the origin without coordinates.
fn coordinates(primitive: &Primitive, set: usize) -> impl Iterator<Item = Vec2> {
    let given = primitive.uvs[set].as_deref();
    // Indices out of range are reported at mesh construction.
    let at = |uvs: &[Vec2], &vertex: &u32| uvs.get(vertex as usize).copied();
    let used =
        given.into_iter().flat_map(move |uvs| primitive.triangles.iter().flatten().filter_map(move |v| at(uvs, v)));
    used.chain(given.is_none().then_some(Vec2::ZERO))
}

fn colors(primitive: &Primitive) -> Extremes {
    let Some(colors) = primitive.colors.as_deref() else { return Extremes::ONE };
    let used = primitive.triangles.iter().flatten().filter_map(|&vertex| colors.get(vertex as usize));
    used.fold(Extremes::NONE, |found, color| found.with(color.to_array()))
}
