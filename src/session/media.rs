//! Media that a `render.toml` adds to a scene: `[media.NAME]`.
//!
//! A table has the keys of [`crate::io::medium`] and `fills`: `"scene"` (the default), the space around everything or
//! the box of the density, or a list of materials, whose solids it fills. Paths of grids are relative to the
//! file's folder.

use crate::error::{Error, Result};
use crate::io::medium::{self, MediumOptions};
use crate::io::volume::{self, VolumeOptions};
use crate::scene::description::{Description, Material, MaterialModel, Volume};
use serde_json::{Map, Value};
use std::collections::BTreeMap;
use std::path::Path;

/// Media by name.
#[derive(Debug, Clone, Default, PartialEq, serde::Serialize, serde::Deserialize)]
#[serde(transparent)]
pub struct Media(BTreeMap<String, Map<String, Value>>);

/// What a medium fills.
enum Fills {
    Scene,
    Materials(Vec<String>),
}

impl Media {
    /// Whether there are none.
    pub fn is_empty(&self) -> bool {
        self.0.is_empty()
    }

    /// Returns the media with paths of grids relative to `folder`.
    pub(super) fn seen_from(&self, folder: &Path) -> Media {
        self.with_paths(|path| folder.join(path).to_string_lossy().into_owned())
    }

    /// Returns the media with absolute paths, for another process in another folder.
    pub fn absolute(&self) -> Media {
        self.with_paths(|path| std::path::absolute(path).map_or(path.to_owned(), |p| p.to_string_lossy().into_owned()))
    }

    fn with_paths(&self, moved: impl Fn(&str) -> String) -> Media {
        let mut media = self.clone();
        for table in media.0.values_mut() {
            for (key, value) in table.iter_mut() {
                if let (true, Value::String(path)) = (is_path(key), value) {
                    *path = moved(path);
                }
            }
        }
        media
    }

    /// Checks all values without a scene.
    ///
    /// # Errors
    /// A usage error for the first value that is out of range, unknown, or contradicts another.
    pub(super) fn check(&self) -> Result<()> {
        self.0.iter().try_for_each(|(name, table)| read(name, table).map(drop))
    }

    /// Adds the media to `description`; densities may have `memory` bytes each.
    ///
    /// # Errors
    /// A density cannot be read, or a material does not exist or lets no light in.
    pub(super) fn fill(&self, description: &mut Description, memory: u64) -> Result<()> {
        for (name, table) in &self.0 {
            let (options, fills) = read(name, table)?;
            let read = |path: &String| {
                let options = VolumeOptions { memory, ..VolumeOptions::default() };
                volume::read(Path::new(path), &options)
            };
            let named = |error: Error| error.context(place(name));
            if let Some(path) = &options.density {
                description.densities.push(read(path).and_then(medium::density).map_err(named)?);
            }
            if let Some(path) = &options.albedo_grid {
                description.albedos.push(read(path).and_then(medium::albedo).map_err(named)?);
            }
            let emission = match (&options.emission_grid, &options.temperature_grid) {
                (Some(path), _) => Some(read(path).and_then(medium::emission)),
                (None, Some(path)) => Some(read(path).and_then(medium::temperatures)),
                (None, None) => None,
            };
            description.emissions.extend(emission.transpose().map_err(named)?);
            let glows = options.emission_grid.is_some() || options.temperature_grid.is_some();
            let glow = glows.then(|| description.emissions.len() - 1);
            let density = options.density.as_ref().map(|_| description.densities.len() - 1);
            let albedo = options.albedo_grid.as_ref().map(|_| description.albedos.len() - 1);
            match fills {
                Fills::Scene => {
                    let filled = options.fill(Volume::CLEAR);
                    description.media.push(Volume { density, albedo, emission_grid: glow, ..filled });
                }
                Fills::Materials(materials) => {
                    for wanted in materials {
                        let volume = volume_of(&mut description.materials, &wanted)
                            .map_err(|error| error.context(place(name)))?;
                        let (density, albedo) = (density.or(volume.density), albedo.or(volume.albedo));
                        let emission_grid = glow.or(volume.emission_grid);
                        *volume = Volume { density, albedo, emission_grid, ..options.fill(*volume) };
                    }
                }
            }
        }
        Ok(())
    }
}

/// Whether the value of a key is a path.
fn is_path(key: &str) -> bool {
    ["density", "albedo_grid", "emission_grid", "temperature_grid"].contains(&key.replace('-', "_").as_str())
}

fn place(name: &str) -> String {
    format!("[media.{name}]")
}

/// Reads the table of the medium `name`.
fn read(name: &str, table: &Map<String, Value>) -> Result<(MediumOptions, Fills)> {
    let place = place(name);
    // As other keys of the file, they may have hyphens.
    let table: Map<String, Value> = table.iter().map(|(key, value)| (key.replace('-', "_"), value.clone())).collect();
    let is_known = |key: &str| key == "fills" || MediumOptions::KEYS.contains(&key);
    if let Some(unknown) = table.keys().find(|key| !is_known(key)) {
        return Err(Error::usage(format!("{place} has the unknown key '{unknown}'")));
    }
    let texts = |list: &Vec<Value>| list.iter().map(|name| name.as_str().map(str::to_owned)).collect::<Option<_>>();
    let fills = match table.get("fills") {
        None => Some(Fills::Scene),
        Some(Value::String(text)) if text == "scene" => Some(Fills::Scene),
        Some(Value::Array(list)) => texts(list).map(Fills::Materials),
        Some(_) => None,
    };
    let fills =
        fills.ok_or_else(|| Error::usage(format!("{place}.fills is neither \"scene\" nor a list of materials")))?;
    let options = MediumOptions::read(&table, &place).map_err(|error| Error::usage(error.to_string()))?;
    Ok((options, fills))
}

/// Returns the volume of the material `wanted`, which becomes solid glass if it was thin.
fn volume_of<'a>(materials: &'a mut [Material], wanted: &str) -> Result<&'a mut Volume> {
    let material = materials.iter_mut().find(|material| material.name == wanted);
    let material = material.ok_or_else(|| Error::usage(format!("the scene has no material '{wanted}'")))?;
    match &mut material.model {
        MaterialModel::MetallicRoughness(model) if model.transmission > 0.0 => {
            Ok(model.volume.get_or_insert(Volume::CLEAR))
        }
        _ => Err(Error::usage(format!("no light enters the material '{wanted}': it has no transmission"))),
    }
}
