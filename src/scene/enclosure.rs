//! Media in the space around a scene: boxes of glass of index 1, in which everything else takes precedence.
//!
//! A medium without a density fills a box around everything, with a margin. So light from infinity crosses a finite
//! part of it. One with a density fills the density's box.

use super::description::{
    ColorGrid, DensityGrid, Description, Instance, Material, Mesh, MetallicRoughnessMaterial, Primitive, PunctualKind,
    Volume,
};
use super::extent::world_box;
use super::view::framing;
use crate::error::{Error, Result};
use glam::{DAffine3, DVec3, Vec3};

/// The margin of the box around everything, as a share of its diagonal.
const MARGIN: f64 = 0.1;

/// Adds the boxes of [`Description::media`]. Returns the box of everything without media around everything, if there is
/// one of these: it is what a camera should show.
///
/// # Errors
/// A scene error if there is nothing to surround.
pub(super) fn enclose(description: &mut Description) -> Result<Option<[DVec3; 2]>> {
    let mut rest = Vec::new();
    for medium in std::mem::take(&mut description.media) {
        match medium.density {
            Some(density) => add_density(description, medium, density),
            None => rest.push(medium),
        }
    }
    if rest.is_empty() {
        return Ok(None);
    }
    let (min, max) = world_box(description);
    let around = around(description, [min, max])?;
    rest.into_iter().for_each(|medium| add_box(description, medium, around));
    Ok(Some([min, max]))
}

/// Adds the box of a density.
fn add_density(description: &mut Description, medium: Volume, density: usize) {
    let grid = description.densities[density].clone();
    // The box takes the density along.
    let placed = Some(description.densities.len());
    description.densities.push(DensityGrid { transform: DAffine3::IDENTITY, ..grid.clone() });
    add_box(description, Volume { density: placed, ..medium }, grid.transform);
}

/// Returns the transform of the unit cube to a box around what lies from `min` to `max`, lamps and cameras.
fn around(description: &Description, [mut min, mut max]: [DVec3; 2]) -> Result<DAffine3> {
    let lamps = description.lights.iter().filter(|lamp| lamp.kind != PunctualKind::Directional);
    let automatic = description.cameras.is_empty().then(|| framing(min, max));
    let eyes = description.cameras.iter().chain(&automatic).map(|camera| camera.transform.translation);
    for p in lamps.map(|lamp| lamp.transform.translation).chain(eyes) {
        (min, max) = (min.min(p), max.max(p));
    }
    let margin = (max - min).length() * MARGIN;
    if !(margin.is_finite() && margin > 0.0) {
        return Err(Error::scene("a medium around the scene has nothing to surround"));
    }
    Ok(DAffine3::from_translation(min - margin) * DAffine3::from_scale(max - min + 2.0 * margin))
}

/// Adds the image of the unit cube under `transform`, filled with `medium`.
fn add_box(description: &mut Description, medium: Volume, transform: DAffine3) {
    let name = format!("medium {}", description.materials.len());
    // The box takes the colours along.
    let along = |grids: &mut Vec<ColorGrid>, index: usize| {
        let grid = grids[index].clone();
        grids.push(ColorGrid { transform: transform.inverse() * grid.transform, ..grid });
        grids.len() - 1
    };
    let albedo = medium.albedo.map(|index| along(&mut description.albedos, index));
    let emission_grid = medium.emission_grid.map(|index| along(&mut description.emissions, index));
    let medium = Volume { albedo, emission_grid, ..medium };
    let model = MetallicRoughnessMaterial {
        metallic: 0.0,
        roughness: 0.0,
        ior: 1.0,
        transmission: 1.0,
        volume: Some(medium),
        ..MetallicRoughnessMaterial::default()
    };
    let material = Material { name: name.clone(), priority: i32::MIN, ..model.into() };
    let corner = |i: u32| Vec3::new((i & 1) as f32, (i >> 1 & 1) as f32, (i >> 2 & 1) as f32);
    let side = |[a, b, c, d]: [u32; 4]| [[a, b, c], [a, c, d]];
    let sides = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
    let primitive = Primitive {
        positions: (0..8).map(corner).collect(),
        triangles: sides.into_iter().flat_map(side).collect(),
        material: description.materials.len(),
        ..Primitive::default()
    };
    description.materials.push(material);
    description.instances.push(Instance { name: name.clone(), mesh: description.meshes.len(), transform });
    description.meshes.push(Mesh { name, primitives: vec![primitive] });
}
