//! Grids of media: files that `extras.etendue` of materials names.

use super::document::{Document, name_or};
use super::extras;
use super::resource::read_uri;
use crate::error::{Error, Result};
use crate::io::medium;
use crate::io::volume::{self, VolumeGrid, VolumeOptions};
use crate::scene::description::{ColorGrid, DensityGrid, Material, MaterialModel, Volume};
use std::collections::HashMap;

/// The grids of a file's media.
#[derive(Default)]
pub(super) struct Grids {
    pub(super) densities: Vec<DensityGrid>,
    pub(super) albedos: Vec<ColorGrid>,
    pub(super) emissions: Vec<ColorGrid>,
}

/// Reads the grids of `materials`, whose indices in the file are `order` (`None` is the default material), and stores
/// in the materials which are theirs. A file that several materials name is read once.
///
/// # Errors
/// A scene error that names the material if a file cannot be read or has wrong values.
pub(super) fn load(document: &Document, order: &[Option<usize>], materials: &mut [Material]) -> Result<Grids> {
    let mut grids = Grids::default();
    let (mut densities, mut albedos) = (HashMap::new(), HashMap::new());
    let (mut emissions, mut temperatures) = (HashMap::new(), HashMap::new());
    for (material, index) in materials.iter_mut().zip(order) {
        let Some(json) = index.map(|index| &document.root.materials[index]) else { continue };
        let named = |error: Error| {
            error.context(format!("material '{}'", name_or(&json.name, "material", index.unwrap_or_default())))
        };
        let asked = extras::of_material(&json.extras).map_err(named)?.medium;
        let density = asked
            .density
            .map(|uri| place(document, uri, &mut densities, &mut grids.densities, medium::density))
            .transpose()
            .map_err(named)?;
        let albedo = asked
            .albedo_grid
            .map(|uri| place(document, uri, &mut albedos, &mut grids.albedos, medium::albedo))
            .transpose()
            .map_err(named)?;
        let glow = &mut grids.emissions;
        let emission_grid = match (asked.emission_grid, asked.temperature_grid) {
            (Some(uri), _) => Some(place(document, uri, &mut emissions, glow, medium::emission)),
            (None, Some(uri)) => Some(place(document, uri, &mut temperatures, glow, medium::temperatures)),
            (None, None) => None,
        };
        let emission_grid = emission_grid.transpose().map_err(named)?;
        let MaterialModel::MetallicRoughness(model) = &mut material.model else { continue };
        model.volume = model.volume.map(|volume| Volume { density, albedo, emission_grid, ..volume });
    }
    Ok(grids)
}

/// Returns the place in `grids` of the file at `uri`, which is read if it is not `known`.
fn place<T>(
    document: &Document,
    uri: String,
    known: &mut HashMap<String, usize>,
    grids: &mut Vec<T>,
    made: impl FnOnce(VolumeGrid) -> Result<T>,
) -> Result<usize> {
    if let Some(&place) = known.get(&uri) {
        return Ok(place);
    }
    let options = VolumeOptions { memory: document.memory, ..VolumeOptions::default() };
    let bytes = read_uri(&document.base, &uri, document.memory)?;
    let grid = volume::decode(&bytes, &options).and_then(made);
    grids.push(grid.map_err(|error| error.context(format!("grid '{uri}'")))?);
    known.insert(uri, grids.len() - 1);
    Ok(grids.len() - 1)
}
