//! Densities of media: files that `extras.etendue.density` of materials names.

use super::document::{Document, name_or};
use super::extras;
use super::resource::read_uri;
use crate::error::{Error, Result};
use crate::io::medium;
use crate::io::volume::{self, VolumeOptions};
use crate::scene::description::{DensityGrid, Material, MaterialModel, Volume};
use std::collections::HashMap;

/// Reads the densities of `materials`, whose indices in the file are `order` (`None` is the default material), and stores
/// in the materials which is theirs. A file that several materials name is read once.
///
/// # Errors
/// A scene error that names the material if a file cannot be read or has several channels, or if the material has no
/// volume.
pub(super) fn load(
    document: &Document,
    order: &[Option<usize>],
    materials: &mut [Material],
) -> Result<Vec<DensityGrid>> {
    let (mut grids, mut known) = (Vec::new(), HashMap::new());
    for (material, index) in materials.iter_mut().zip(order) {
        let Some(json) = index.map(|index| &document.root.materials[index]) else { continue };
        let named = |error: Error| {
            error.context(format!("material '{}'", name_or(&json.name, "material", index.unwrap_or_default())))
        };
        let Some(uri) = extras::of_material(&json.extras).map_err(named)?.medium.density else { continue };
        let place = match known.get(&uri) {
            Some(&place) => place,
            None => {
                grids.push(read(document, &uri).map_err(named)?);
                known.insert(uri, grids.len() - 1);
                grids.len() - 1
            }
        };
        let MaterialModel::MetallicRoughness(model) = &mut material.model else { continue };
        model.volume = model.volume.map(|volume| Volume { density: Some(place), ..volume });
    }
    Ok(grids)
}

/// Reads the grid at `uri`.
fn read(document: &Document, uri: &str) -> Result<DensityGrid> {
    let options = VolumeOptions { memory: document.memory, ..VolumeOptions::default() };
    let bytes = read_uri(&document.base, uri, document.memory)?;
    volume::decode(&bytes, &options).and_then(medium::density).map_err(|e| e.context(format!("density '{uri}'")))
}
