//! Metallic-roughness materials with the extensions that étendue models.

use super::document::{Document, name_or};
use super::notes::Notes;
use super::texture::{self, Role, Slot};
use super::{extensions, extras, image};
use crate::error::{Error, Result};
use crate::io::medium::MOST_G;
use crate::medium::Phase;
use crate::medium::inversion::kulla_conty;
use crate::scene::description::{AlphaMode, Material, MaterialModel, MetallicRoughnessMaterial, Volume};
use crate::spectrum::Spectrum;
use crate::texture::{Bitmap, Texture};
use ::gltf::json;
use json::material::AlphaMode as JsonAlphaMode;
use json::validation::Checked;
use serde_json::Value;
use std::collections::BTreeMap;
use std::sync::Arc;

/// Decoded images by their index in the file.
type Images = BTreeMap<usize, Arc<Bitmap>>;

/// Loads the materials with these indices, in this order (`None` is the default material), and the images they use.
///
/// # Errors
/// A scene error that names the material or image at fault.
pub(super) fn load(
    document: &Document,
    indices: &[Option<usize>],
    notes: &mut Notes,
) -> Result<(Vec<Material>, Vec<Arc<Bitmap>>)> {
    let name = |index: usize| name_or(&document.root.materials[index].name, "material", index);
    let mut slots_of = |index: &Option<usize>| match *index {
        Some(i) => texture::slots(document, &document.root.materials[i], &name(i), notes),
        None => Vec::new(),
    };
    let slots: Vec<Vec<Slot>> = indices.iter().map(&mut slots_of).collect();
    let images = images(document, slots.iter().flatten())?;
    let material = |(index, slots): (&Option<usize>, &Vec<Slot>)| match *index {
        Some(i) => {
            let (json, raw) = (&document.root.materials[i], &document.raw["materials"][i]);
            Source { document, json, raw, name: name(i), slots, images: &images }.material(notes)
        }
        None => Ok(Material::default()),
    };
    let materials = indices.iter().zip(&slots).map(material).collect::<Result<_>>()?;
    Ok((materials, images.into_values().collect()))
}

fn images<'a>(document: &Document, slots: impl Iterator<Item = &'a Slot>) -> Result<Images> {
    let mut used: Vec<usize> = slots.map(|s| s.image).collect();
    used.sort_unstable();
    used.dedup();
    let decoded = image::decode(document, &used)?;
    Ok(used.into_iter().zip(decoded).collect())
}

/// A material of the file with the data needed to read it.
struct Source<'a> {
    document: &'a Document,
    json: &'a json::Material,
    /// The same as unchecked JSON, for extensions that the crate does not know.
    raw: &'a Value,
    name: String,
    slots: &'a [Slot],
    images: &'a Images,
}

impl Source<'_> {
    fn material(&self, notes: &mut Notes) -> Result<Material> {
        let pbr = &self.json.pbr_metallic_roughness;
        let [r, g, b, a] = pbr.base_color_factor.0;
        let normal_texture = self.texture(Role::Normal).zip(self.normal_scale()?);
        let asked = extras::of_material(&self.json.extras).map_err(|e| self.named(e))?;
        let base_color = self.unit_color([r, g, b], "base colour", notes);
        let alpha = self.unit(a, "alpha", notes);
        let alpha_mode = self.alpha_mode();
        let base = MetallicRoughnessMaterial {
            base_color,
            base_color_texture: self.texture(Role::BaseColor),
            metallic: self.unit(pbr.metallic_factor.0, "metalness", notes),
            roughness: self.unit(pbr.roughness_factor.0, "roughness", notes),
            metallic_roughness_texture: self.texture(Role::MetallicRoughness),
            metal_fresnel: asked.metal_fresnel,
            ..MetallicRoughnessMaterial::default()
        };
        let material = Material {
            name: self.name.clone(),
            alpha,
            // The base colour texture has alpha too.
            alpha_texture: self.texture(Role::BaseColor).filter(|_| alpha_mode != AlphaMode::Opaque),
            alpha_mode,
            normal_texture,
            emission: self.emission()?,
            emission_texture: self.texture(Role::Emission),
            double_sided: self.json.double_sided,
            priority: asked.priority,
            ..Material::default()
        };
        if self.json.extensions.as_ref().is_some_and(|extensions| extensions.unlit.is_some()) {
            return Ok(unlit(material, base));
        }
        let mut model = self.extended(base, notes)?;
        if !asked.medium.is_empty() {
            let without =
                || self.named(Error::scene("the medium in extras.etendue has no volume with a thickness to fill"));
            model.volume = Some(asked.medium.fill(model.volume.ok_or_else(without)?));
        }
        Ok(Material { model: MaterialModel::MetallicRoughness(model), ..material })
    }

    /// Applies the material's extensions to `base`.
    fn extended(&self, mut base: MetallicRoughnessMaterial, notes: &mut Notes) -> Result<MetallicRoughnessMaterial> {
        let Some(extensions) = &self.json.extensions else { return Ok(base) };
        if let Some(specular) = &extensions.specular {
            base.specular = self.unit(specular.specular_factor.0, "specular strength", notes);
            base.specular_color = self.non_negative(specular.specular_color_factor.0, "specular colour")?;
            base.specular_texture = self.texture(Role::Specular);
            base.specular_color_texture = self.texture(Role::SpecularColor);
        }
        if let Some(ior) = &extensions.ior {
            base.ior = self.ior(ior.ior.0)?;
        }
        if let Some(transmission) = &extensions.transmission {
            base.transmission = self.unit(transmission.transmission_factor.0, "transmission", notes);
            base.transmission_texture = self.texture(Role::Transmission);
        }
        if let Some(volume) = &extensions.volume {
            base.volume = self.volume(volume, notes)?.map(|volume| self.scattering(volume)).transpose()?;
        }
        Ok(base)
    }

    fn texture(&self, role: Role) -> Option<Texture> {
        let slot = self.slots.iter().find(|s| s.role == role)?;
        Some(slot.texture(self.document, Arc::clone(self.images.get(&slot.image)?)))
    }

    fn normal_scale(&self) -> Result<Option<f32>> {
        let scale = self.json.normal_texture.as_ref().map(|t| t.scale);
        if scale.is_some_and(|s| !s.is_finite()) {
            return Err(self.invalid("normal scale"));
        }
        Ok(scale)
    }

    fn emission(&self) -> Result<Spectrum> {
        let strength = self.json.extensions.as_ref().and_then(|e| e.emissive_strength.as_ref());
        let strength = strength.map_or(1.0, |s| s.emissive_strength.0);
        self.non_negative(self.json.emissive_factor.0.map(|c| c * strength), "emission")
    }

    fn alpha_mode(&self) -> AlphaMode {
        match self.json.alpha_mode {
            Checked::Valid(JsonAlphaMode::Mask) => {
                AlphaMode::Mask { cutoff: self.json.alpha_cutoff.unwrap_or_default().0 }
            }
            Checked::Valid(JsonAlphaMode::Blend) => AlphaMode::Blend,
            Checked::Valid(JsonAlphaMode::Opaque) | Checked::Invalid => AlphaMode::Opaque,
        }
    }

    fn ior(&self, ior: f32) -> Result<f32> {
        // KHR_materials_ior uses 0 to request total reflection.
        if ior == 0.0 || (ior >= 1.0 && ior.is_finite()) { Ok(ior) } else { Err(self.invalid("refractive index")) }
    }

    fn volume(&self, volume: &json::extensions::material::Volume, notes: &mut Notes) -> Result<Option<Volume>> {
        let distance = f64::from(volume.attenuation_distance.0);
        if distance <= 0.0 {
            return Err(self.invalid("attenuation distance"));
        }
        let attenuation_color = self.unit_color(volume.attenuation_color.0, "attenuation colour", notes);
        let solid = volume.thickness_factor.0 > 0.0;
        Ok(solid.then_some(Volume::absorbing(distance, attenuation_color)))
    }

    /// Returns `volume` with the scattering of the draft KHR_materials_volume_scatter, if it has any: the attenuation
    /// is that of scattering and absorption together.
    fn scattering(&self, volume: Volume) -> Result<Volume> {
        let extension = &self.raw["extensions"][extensions::SCATTERING];
        if extension.is_null() {
            return Ok(volume);
        }
        let color = |lane: usize| match extension.get("multiscatterColor") {
            None => Some(0.0),
            Some(color) => color[lane].as_f64().filter(|c| (0.0..=1.0).contains(c)),
        };
        let g = extension.get("scatterAnisotropy").map_or(Some(0.0), Value::as_f64).filter(|g| g.abs() < 1.0);
        let ([Some(r), Some(green), Some(b)], Some(g)) = ([0, 1, 2].map(color), g) else {
            return Err(self.invalid("colour or anisotropy of scattering"));
        };
        let albedo = [r, green, b].map(|c| kulla_conty(c as f32));
        let scattering = volume.absorption * Spectrum(albedo);
        let phase = Phase::HenyeyGreenstein(g.clamp(-MOST_G, MOST_G) as f32);
        Ok(Volume { scattering, absorption: volume.absorption - scattering, phase, ..volume })
    }

    /// Files often exceed the range by a rounding error, which must not cause an energy gain.
    fn unit(&self, x: f32, what: &str, notes: &mut Notes) -> f32 {
        if !(0.0..=1.0).contains(&x) {
            notes.add(format!("material '{}' has a {what} outside 0 to 1, which is clamped", self.name));
        }
        x.clamp(0.0, 1.0)
    }

    fn unit_color(&self, rgb: [f32; 3], what: &str, notes: &mut Notes) -> Spectrum {
        Spectrum::from_rgb(rgb.map(|c| self.unit(c, what, notes)))
    }

    fn non_negative(&self, rgb: [f32; 3], what: &str) -> Result<Spectrum> {
        let valid = rgb.iter().all(|c| c.is_finite() && *c >= 0.0);
        if valid { Ok(Spectrum::from_rgb(rgb)) } else { Err(self.invalid(what)) }
    }

    fn invalid(&self, what: &str) -> Error {
        self.named(Error::scene(format!("the {what} is out of range")))
    }

    fn named(&self, error: Error) -> Error {
        error.context(format!("material '{}'", self.name))
    }
}

/// Returns the unlit `material`, which shows its base colour. Its other properties are ignored.
fn unlit(material: Material, base: MetallicRoughnessMaterial) -> Material {
    Material {
        model: MaterialModel::Unlit,
        emission: base.base_color,
        emission_texture: base.base_color_texture,
        normal_texture: None,
        ..material
    }
}
