//! Hash of the contents of a description, independent of the location and format of its files: the bytes of its fields,
//! with the length of each array and the index of each enum variant.
//!
//! Every struct is destructured without `..`, so that a new field does not compile until it has its line here:
//! `field.feed(bytes)`, or `field: _` if no image depends on it, such as names that nothing is selected by.

use super::{
    AlphaMode, CameraDescription, ColorGrid, DensityGrid, Description, DiffuseMaterial, EnvironmentDescription,
    Instance, Lens, Material, MaterialModel, Mesh, MetalFresnel, MetallicRoughnessMaterial, Primitive, Projection,
    PunctualKind, PunctualLight, Volume,
};
use crate::spectrum::Spectrum;
use crate::texture::{Bitmap, Encoding, RadianceMap, Texture, TextureFilter, Wrap};
use glam::{Affine2, DAffine3};
use std::sync::Arc;

/// Returns the hexadecimal BLAKE3 hash of everything that can affect an image.
pub(in crate::scene) fn of(description: &Description) -> String {
    let mut bytes = Bytes::new();
    description.feed(&mut bytes);
    bytes.finalize().to_hex()[..32].to_owned()
}

type Bytes = blake3::Hasher;

/// Hashed content.
trait Content {
    /// Feeds the content to the hash. The encoding is injective and prefix-free within a type.
    fn feed(&self, bytes: &mut Bytes);
}

impl Content for Description {
    fn feed(&self, bytes: &mut Bytes) {
        // Images are hashed where textures use them; the other fields do not affect the image.
        let Description {
            meshes,
            instances,
            materials,
            densities,
            albedos,
            emissions,
            media,
            images: _,
            lights,
            cameras,
            environment,
            has_punctual_lights,
            has_emission,
            hides: _,
            animations: _,
            animation_end: _,
            ignored: _,
            warnings: _,
        } = self;
        meshes.feed(bytes);
        instances.feed(bytes);
        materials.feed(bytes);
        lights.feed(bytes);
        cameras.feed(bytes);
        environment.feed(bytes);
        has_punctual_lights.feed(bytes);
        has_emission.feed(bytes);
        // Files without grids, and without media around them, keep their hashes.
        if !densities.is_empty() {
            densities.feed(bytes);
        }
        if !albedos.is_empty() {
            albedos.feed(bytes);
        }
        if !emissions.is_empty() {
            emissions.feed(bytes);
        }
        if !media.is_empty() {
            media.feed(bytes);
        }
    }
}

impl Content for ColorGrid {
    fn feed(&self, bytes: &mut Bytes) {
        let ColorGrid { cells, transform } = self;
        cells.cells().iter().for_each(|n| n.feed(bytes));
        bytes.update(bytemuck::cast_slice(cells.values()));
        transform.feed(bytes);
    }
}

impl Content for DensityGrid {
    fn feed(&self, bytes: &mut Bytes) {
        let DensityGrid { blocks, transform } = self;
        blocks.cells().iter().for_each(|n| n.feed(bytes));
        for part in blocks.content_bytes() {
            part.len().feed(bytes);
            bytes.update(part);
        }
        transform.feed(bytes);
    }
}

impl Content for EnvironmentDescription {
    fn feed(&self, bytes: &mut Bytes) {
        match self {
            EnvironmentDescription::Uniform(radiance) => {
                0_u8.feed(bytes);
                radiance.feed(bytes);
            }
            EnvironmentDescription::Map { map, scale, rotation } => {
                1_u8.feed(bytes);
                map.feed(bytes);
                scale.feed(bytes);
                rotation.feed(bytes);
            }
        }
    }
}

impl Content for Mesh {
    fn feed(&self, bytes: &mut Bytes) {
        let Mesh { name: _, primitives } = self;
        primitives.feed(bytes);
    }
}

impl Content for Primitive {
    fn feed(&self, bytes: &mut Bytes) {
        let Primitive { positions, triangles, normals, tangents, uvs: [uv_0, uv_1], colors, material } = self;
        array(bytes, Some(positions));
        array(bytes, Some(triangles));
        array(bytes, normals.as_ref());
        array(bytes, tangents.as_ref());
        array(bytes, uv_0.as_ref());
        array(bytes, uv_1.as_ref());
        array(bytes, colors.as_ref());
        material.feed(bytes);
    }
}

impl Content for Instance {
    fn feed(&self, bytes: &mut Bytes) {
        let Instance { name: _, mesh, transform } = self;
        mesh.feed(bytes);
        transform.feed(bytes);
    }
}

impl Content for Material {
    fn feed(&self, bytes: &mut Bytes) {
        let Material {
            name: _,
            model,
            alpha,
            alpha_texture,
            alpha_mode,
            normal_texture,
            emission,
            emission_texture,
            double_sided,
            priority,
        } = self;
        model.feed(bytes);
        alpha.feed(bytes);
        alpha_texture.feed(bytes);
        alpha_mode.feed(bytes);
        normal_texture.feed(bytes);
        emission.feed(bytes);
        emission_texture.feed(bytes);
        double_sided.feed(bytes);
        priority.feed(bytes);
    }
}

impl Content for MaterialModel {
    fn feed(&self, bytes: &mut Bytes) {
        match self {
            MaterialModel::Unlit => 0_u8.feed(bytes),
            MaterialModel::Diffuse(model) => {
                1_u8.feed(bytes);
                model.feed(bytes);
            }
            MaterialModel::MetallicRoughness(model) => {
                2_u8.feed(bytes);
                model.feed(bytes);
            }
        }
    }
}

impl Content for DiffuseMaterial {
    fn feed(&self, bytes: &mut Bytes) {
        let DiffuseMaterial { reflectance, reflectance_texture } = self;
        reflectance.feed(bytes);
        reflectance_texture.feed(bytes);
    }
}

impl Content for MetallicRoughnessMaterial {
    fn feed(&self, bytes: &mut Bytes) {
        let MetallicRoughnessMaterial {
            base_color,
            base_color_texture,
            metallic,
            roughness,
            metallic_roughness_texture,
            specular,
            specular_texture,
            specular_color,
            specular_color_texture,
            ior,
            transmission,
            transmission_texture,
            volume,
            metal_fresnel,
        } = self;
        base_color.feed(bytes);
        base_color_texture.feed(bytes);
        metallic.feed(bytes);
        roughness.feed(bytes);
        metallic_roughness_texture.feed(bytes);
        specular.feed(bytes);
        specular_texture.feed(bytes);
        specular_color.feed(bytes);
        specular_color_texture.feed(bytes);
        ior.feed(bytes);
        transmission.feed(bytes);
        transmission_texture.feed(bytes);
        volume.feed(bytes);
        metal_fresnel.feed(bytes);
    }
}

impl Content for AlphaMode {
    fn feed(&self, bytes: &mut Bytes) {
        match self {
            AlphaMode::Opaque => 0_u8.feed(bytes),
            AlphaMode::Mask { cutoff } => {
                1_u8.feed(bytes);
                cutoff.feed(bytes);
            }
            AlphaMode::Blend => 2_u8.feed(bytes),
        }
    }
}

impl Content for MetalFresnel {
    fn feed(&self, bytes: &mut Bytes) {
        match self {
            MetalFresnel::Schlick => 0_u8.feed(bytes),
            MetalFresnel::Constant => 1_u8.feed(bytes),
        }
    }
}

impl Content for Volume {
    fn feed(&self, bytes: &mut Bytes) {
        let Volume { absorption, scattering, emission, phase, density, albedo, emission_grid } = self;
        absorption.feed(bytes);
        scattering.feed(bytes);
        emission.feed(bytes);
        phase.numbers().feed(bytes);
        density.feed(bytes);
        albedo.feed(bytes);
        emission_grid.feed(bytes);
    }
}

impl Content for PunctualLight {
    fn feed(&self, bytes: &mut Bytes) {
        let PunctualLight { name: _, kind, intensity, transform } = self;
        kind.feed(bytes);
        intensity.feed(bytes);
        transform.feed(bytes);
    }
}

impl Content for PunctualKind {
    fn feed(&self, bytes: &mut Bytes) {
        match self {
            PunctualKind::Point => 0_u8.feed(bytes),
            PunctualKind::Spot { inner, outer } => {
                1_u8.feed(bytes);
                inner.feed(bytes);
                outer.feed(bytes);
            }
            PunctualKind::Directional => 2_u8.feed(bytes),
        }
    }
}

impl Content for CameraDescription {
    fn feed(&self, bytes: &mut Bytes) {
        // Cameras are selected by name.
        let CameraDescription { name, projection, transform, lens } = self;
        name.feed(bytes);
        // No projection begins with a 2. A camera without a lens keeps the bytes that it had before there were lenses.
        if let Some(lens) = lens {
            2_u8.feed(bytes);
            lens.feed(bytes);
        }
        projection.feed(bytes);
        transform.feed(bytes);
    }
}

impl Content for Lens {
    fn feed(&self, bytes: &mut Bytes) {
        let Lens { radius, focus, blades, rotation } = self;
        radius.feed(bytes);
        focus.feed(bytes);
        blades.feed(bytes);
        rotation.feed(bytes);
    }
}

impl Content for Projection {
    fn feed(&self, bytes: &mut Bytes) {
        match self {
            Projection::Perspective { yfov, aspect } => {
                0_u8.feed(bytes);
                yfov.feed(bytes);
                aspect.feed(bytes);
            }
            Projection::Orthographic { xmag, ymag } => {
                1_u8.feed(bytes);
                xmag.feed(bytes);
                ymag.feed(bytes);
            }
        }
    }
}

impl Content for Texture {
    fn feed(&self, bytes: &mut Bytes) {
        let Texture { image, encoding, wrap, filter, uv_set, transform } = self;
        image.feed(bytes);
        encoding.feed(bytes);
        wrap.feed(bytes);
        filter.feed(bytes);
        uv_set.feed(bytes);
        transform.feed(bytes);
    }
}

impl Content for Encoding {
    fn feed(&self, bytes: &mut Bytes) {
        match self {
            Encoding::Srgb => 0_u8.feed(bytes),
            Encoding::Linear => 1_u8.feed(bytes),
        }
    }
}

impl Content for Wrap {
    fn feed(&self, bytes: &mut Bytes) {
        match self {
            Wrap::Repeat => 0_u8.feed(bytes),
            Wrap::Mirror => 1_u8.feed(bytes),
            Wrap::Clamp => 2_u8.feed(bytes),
        }
    }
}

impl Content for TextureFilter {
    fn feed(&self, bytes: &mut Bytes) {
        match self {
            TextureFilter::Nearest => 0_u8.feed(bytes),
            TextureFilter::Linear => 1_u8.feed(bytes),
        }
    }
}

impl Content for Bitmap {
    fn feed(&self, bytes: &mut Bytes) {
        self.size().feed(bytes);
        bytes.update(self.texel_hash().as_bytes());
    }
}

impl Content for RadianceMap {
    fn feed(&self, bytes: &mut Bytes) {
        self.size().feed(bytes);
        bytes.update(self.texel_hash().as_bytes());
    }
}

/// Arrays of plain values: their length (−1 if absent), then their bytes in memory order, which is little-endian here.
fn array<T: bytemuck::Pod>(bytes: &mut Bytes, values: Option<&Vec<T>>) {
    values.map_or(-1, |values| values.len() as i64).feed(bytes);
    if let Some(values) = values {
        bytes.update(bytemuck::cast_slice(values));
    }
}

/// Plain numbers, in little-endian order.
macro_rules! numbers {
    ($($number:ty),*) => {
        $(impl Content for $number {
            fn feed(&self, bytes: &mut Bytes) {
                bytes.update(&self.to_le_bytes());
            }
        })*
    };
}

numbers!(u8, u32, u64, i64, f32, f64);

impl Content for usize {
    fn feed(&self, bytes: &mut Bytes) {
        (*self as u64).feed(bytes);
    }
}

impl Content for i32 {
    fn feed(&self, bytes: &mut Bytes) {
        bytes.update(&self.to_le_bytes());
    }
}

impl Content for bool {
    fn feed(&self, bytes: &mut Bytes) {
        u8::from(*self).feed(bytes);
    }
}

impl Content for String {
    fn feed(&self, bytes: &mut Bytes) {
        self.len().feed(bytes);
        bytes.update(self.as_bytes());
    }
}

impl Content for Spectrum {
    fn feed(&self, bytes: &mut Bytes) {
        self.0.feed(bytes);
    }
}

/// Vectors and transforms, lane by lane.
macro_rules! lanes {
    ($($kind:ty, $lanes:ident);*) => {
        $(impl Content for $kind {
            fn feed(&self, bytes: &mut Bytes) {
                self.$lanes().feed(bytes);
            }
        })*
    };
}

lanes!(Affine2, to_cols_array; DAffine3, to_cols_array);

impl<T: Content, const N: usize> Content for [T; N] {
    fn feed(&self, bytes: &mut Bytes) {
        self.iter().for_each(|item| item.feed(bytes));
    }
}

impl<T: Content> Content for Vec<T> {
    fn feed(&self, bytes: &mut Bytes) {
        self.len().feed(bytes);
        self.iter().for_each(|item| item.feed(bytes));
    }
}

impl<T: Content> Content for Option<T> {
    fn feed(&self, bytes: &mut Bytes) {
        self.is_some().feed(bytes);
        self.iter().for_each(|item| item.feed(bytes));
    }
}

impl<T: Content> Content for Arc<T> {
    fn feed(&self, bytes: &mut Bytes) {
        self.as_ref().feed(bytes);
    }
}

impl<A: Content, B: Content> Content for (A, B) {
    fn feed(&self, bytes: &mut Bytes) {
        self.0.feed(bytes);
        self.1.feed(bytes);
    }
}

#[cfg(test)]
#[path = "hash_tests.rs"]
mod tests;
