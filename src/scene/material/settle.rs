//! Simplification of materials: textures that are constant wherever they are used become factors.

use super::model::rgb;
use crate::scene::description::{AlphaMode, Material, MaterialModel};
use crate::scene::usage::Usage;
use crate::texture::{Extremes, Texture};

/// Folds constant textures into the factors, and removes these textures from both `m` and `usage`. Sets the alpha mode
/// to opaque if alpha has no effect.
pub(in crate::scene) fn settle(m: &mut Material, usage: &mut Usage) {
    let holes = match m.alpha_mode {
        AlphaMode::Opaque => false,
        AlphaMode::Mask { cutoff } => least_alpha(m, usage) < cutoff,
        AlphaMode::Blend => least_alpha(m, usage) < 1.0,
    };
    if !holes {
        m.alpha_mode = AlphaMode::Opaque;
        (m.alpha_texture, usage.alpha) = (None, Extremes::ONE);
    }
    if let Some(alpha) = take(&mut m.alpha_texture, &mut usage.alpha, &[3]) {
        m.alpha *= alpha[3];
    }
    if let Some(emission) = take(&mut m.emission_texture, &mut usage.emission, &[0, 1, 2]) {
        m.emission *= rgb(emission);
    }
    settle_model(&mut m.model, usage);
}

fn settle_model(model: &mut MaterialModel, usage: &mut Usage) {
    match model {
        MaterialModel::Unlit => {}
        MaterialModel::Diffuse(m) => {
            if let Some(reflectance) = take(&mut m.reflectance_texture, &mut usage.base, &[0, 1, 2]) {
                m.reflectance *= rgb(reflectance);
            }
        }
        MaterialModel::MetallicRoughness(m) => {
            if let Some(base) = take(&mut m.base_color_texture, &mut usage.base, &[0, 1, 2]) {
                m.base_color *= rgb(base);
            }
            let both = take(&mut m.metallic_roughness_texture, &mut usage.metallic_roughness, &[1, 2]);
            if let Some([_, rough, metal, _]) = both {
                m.roughness *= rough;
                m.metallic *= metal;
            }
            if let Some(specular) = take(&mut m.specular_texture, &mut usage.specular, &[3]) {
                m.specular *= specular[3];
            }
            if let Some(color) = take(&mut m.specular_color_texture, &mut usage.specular_color, &[0, 1, 2]) {
                m.specular_color *= rgb(color);
            }
            if let Some(transmission) = take(&mut m.transmission_texture, &mut usage.transmission, &[0]) {
                m.transmission *= transmission[0];
            }
        }
    }
}

/// Removes the texture if the relevant `channels` are constant wherever it is used; returns their values.
fn take(texture: &mut Option<Texture>, extremes: &mut Extremes, channels: &[usize]) -> Option<[f32; 4]> {
    let constant = texture.is_some() && extremes.is_constant(channels);
    let value = constant.then_some(extremes.min)?;
    (*texture, *extremes) = (None, Extremes::ONE);
    Some(value)
}

fn least_alpha(m: &Material, usage: &Usage) -> f32 {
    let ends = |e: &Extremes| [e.min[3], e.max[3]];
    let products =
        ends(&usage.alpha).into_iter().flat_map(|texture| ends(&usage.colors).map(|color| m.alpha * texture * color));
    products.fold(f32::INFINITY, f32::min)
}
