//! Texture references of a material, with their samplers and transforms.

use super::document::Document;
use super::notes::Notes;
use crate::texture::{Bitmap, Encoding, Texture, TextureFilter, Wrap};
use ::gltf::json::extensions::texture::TextureTransform;
use ::gltf::json::material::{Material, NormalTexture};
use ::gltf::json::texture::{Info, MagFilter, MinFilter, Sampler, WrappingMode};
use ::gltf::json::validation::Checked;
use glam::{Affine2, Vec2};
use serde::Deserialize;
use std::sync::Arc;

/// Role of a texture in its material.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Role {
    BaseColor,
    MetallicRoughness,
    Normal,
    Emission,
    Specular,
    SpecularColor,
    Transmission,
}

impl Role {
    fn encoding(self) -> Encoding {
        match self {
            Role::BaseColor | Role::Emission | Role::SpecularColor => Encoding::Srgb,
            Role::MetallicRoughness | Role::Normal | Role::Specular | Role::Transmission => Encoding::Linear,
        }
    }

    fn name(self) -> &'static str {
        match self {
            Role::BaseColor => "base colour",
            Role::MetallicRoughness => "metallic-roughness",
            Role::Normal => "normal",
            Role::Emission => "emissive",
            Role::Specular => "specular",
            Role::SpecularColor => "specular colour",
            Role::Transmission => "transmission",
        }
    }
}

/// A texture reference that étendue supports.
pub(super) struct Slot {
    pub(super) role: Role,
    /// Index of the image in the file.
    pub(super) image: usize,
    sampler: Option<usize>,
    uv_set: usize,
    transform: Affine2,
}

impl Slot {
    /// Builds the texture from its decoded image.
    pub(super) fn texture(&self, document: &Document, image: Arc<Bitmap>) -> Texture {
        let sampler = self.sampler.and_then(|s| document.root.samplers.get(s));
        Texture {
            image,
            encoding: self.role.encoding(),
            wrap: sampler.map_or([Wrap::Repeat; 2], |s| [wrap(s.wrap_s), wrap(s.wrap_t)]),
            filter: sampler.map_or(TextureFilter::Linear, filter),
            uv_set: self.uv_set,
            transform: self.transform,
        }
    }
}

/// Returns the supported textures of `material`. Notes tell which are left out. Thickness and occlusion textures have
/// no effect here.
pub(super) fn slots(document: &Document, material: &Material, name: &str, notes: &mut Notes) -> Vec<Slot> {
    let pbr = &material.pbr_metallic_roughness;
    let extensions = material.extensions.as_ref();
    let specular = extensions.and_then(|e| e.specular.as_ref());
    let transmission = extensions.and_then(|e| e.transmission.as_ref());
    let references = [
        (Role::BaseColor, pbr.base_color_texture.as_ref().map(Reference::of)),
        (Role::MetallicRoughness, pbr.metallic_roughness_texture.as_ref().map(Reference::of)),
        (Role::Normal, material.normal_texture.as_ref().map(Reference::of_normal)),
        (Role::Emission, material.emissive_texture.as_ref().map(Reference::of)),
        (Role::Specular, specular.and_then(|s| s.specular_texture.as_ref()).map(Reference::of)),
        (Role::SpecularColor, specular.and_then(|s| s.specular_color_texture.as_ref()).map(Reference::of)),
        (Role::Transmission, transmission.and_then(|t| t.transmission_texture.as_ref()).map(Reference::of)),
    ];
    let present = references.into_iter().filter_map(|(role, reference)| Some((role, reference?)));
    present.filter_map(|(role, reference)| reference.slot(document, role, name, notes)).collect()
}

/// Common fields of the two kinds of texture references in glTF.
struct Reference {
    texture: usize,
    uv_set: u32,
    transform: Option<TextureTransform>,
}

impl Reference {
    fn of(info: &Info) -> Self {
        let transform = info.extensions.as_ref().and_then(|e| e.texture_transform.clone());
        Reference { texture: info.index.value(), uv_set: info.tex_coord, transform }
    }

    /// The crate does not parse the transform of normal textures.
    fn of_normal(info: &NormalTexture) -> Self {
        let raw = info.extensions.as_ref().and_then(|e| e.others.get("KHR_texture_transform"));
        let transform = raw.and_then(|t| TextureTransform::deserialize(t).ok());
        Reference { texture: info.index.value(), uv_set: info.tex_coord, transform }
    }

    fn slot(self, document: &Document, role: Role, material: &str, notes: &mut Notes) -> Option<Slot> {
        let mut left_out = |why: String| {
            notes.add(format!("the {} texture of material '{material}' is left out: {why}", role.name()));
            None
        };
        let uv_set = self.transform.as_ref().and_then(|t| t.tex_coord).unwrap_or(self.uv_set) as usize;
        if uv_set >= UV_SETS {
            return left_out(format!("it uses texture coordinate set {uv_set}"));
        }
        let transform = self.transform.as_ref().map_or(Affine2::IDENTITY, uv_transform);
        if !transform.is_finite() {
            return left_out("its transform is not finite".into());
        }
        let texture = &document.root.textures[self.texture];
        if document.root.images.get(texture.source.value()).is_none() {
            return left_out("it has no PNG or JPEG image".into());
        }
        let sampler = texture.sampler.map(|s| s.value());
        Some(Slot { role, image: texture.source.value(), sampler, uv_set, transform })
    }
}

/// Number of coordinate sets in [`crate::scene::description::Primitive::uvs`].
const UV_SETS: usize = 2;

/// Scale, then rotation, then offset. Angles are counter-clockwise in the displayed image, whose v axis points down.
fn uv_transform(t: &TextureTransform) -> Affine2 {
    Affine2::from_scale_angle_translation(Vec2::from(t.scale.0), -t.rotation.0, Vec2::from(t.offset.0))
}

fn wrap(mode: Checked<WrappingMode>) -> Wrap {
    match mode {
        Checked::Valid(WrappingMode::ClampToEdge) => Wrap::Clamp,
        Checked::Valid(WrappingMode::MirroredRepeat) => Wrap::Mirror,
        Checked::Valid(WrappingMode::Repeat) | Checked::Invalid => Wrap::Repeat,
    }
}

/// The magnification filter decides, else the minification filter without its mipmaps.
fn filter(sampler: &Sampler) -> TextureFilter {
    match (sampler.mag_filter, sampler.min_filter) {
        (Some(Checked::Valid(MagFilter::Nearest)), _) => TextureFilter::Nearest,
        (Some(_), _) | (None, None) => TextureFilter::Linear,
        (None, Some(Checked::Valid(min))) => match min {
            MinFilter::Nearest | MinFilter::NearestMipmapNearest | MinFilter::NearestMipmapLinear => {
                TextureFilter::Nearest
            }
            MinFilter::Linear | MinFilter::LinearMipmapNearest | MinFilter::LinearMipmapLinear => TextureFilter::Linear,
        },
        (None, Some(Checked::Invalid)) => TextureFilter::Linear,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Checks that the transform in `json` maps each point to its partner, up to one rounding of the angle and of each
    /// product of numbers up to 1.
    fn maps(json: &str, points: &[([f32; 2], [f32; 2])]) {
        let transform = uv_transform(&serde_json::from_str(json).expect("valid"));
        for &(uv, want) in points {
            let got = transform.transform_point2(Vec2::from(uv));
            assert!(
                (got - Vec2::from(want)).abs().max_element() <= 4.0 * f32::EPSILON,
                "{uv:?}: {got} is not {want:?}"
            );
        }
    }

    /// The example in KHR_texture_transform: "utilizes only the lower left quadrant of the source image, rotated".
    #[test]
    fn rotation_has_the_sign_of_the_specification() {
        maps(
            r#"{ "offset": [0, 1], "rotation": 1.57079632679, "scale": [0.5, 0.5] }"#,
            &[([0.0, 0.0], [0.0, 1.0]), ([1.0, 0.0], [0.0, 0.5]), ([0.0, 1.0], [0.5, 1.0]), ([1.0, 1.0], [0.5, 0.5])],
        );
    }

    /// "translation * rotation * scale": the specification's example has a uniform scale, which does not determine the
    /// order.
    #[test]
    fn an_uneven_scale_comes_before_rotation_and_offset() {
        maps(
            r#"{ "offset": [0.25, 0.5], "rotation": 1.57079632679, "scale": [1, 0.25] }"#,
            &[([0.0, 0.0], [0.25, 0.5]), ([1.0, 0.0], [0.25, -0.5]), ([0.0, 1.0], [0.5, 0.5])],
        );
    }
}
