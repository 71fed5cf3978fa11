//! Materials, textures and images.

use crate::support::{File, merge};
use etendue::medium::Phase;
use etendue::scene::description::{
    AlphaMode, Material, MaterialModel, MetalFresnel, MetallicRoughnessMaterial, Volume,
};
use etendue::spectrum::Spectrum;
use etendue::texture::{Encoding, TextureFilter, Wrap};
use glam::{Vec3, Vec4};
use image::{DynamicImage, ImageFormat};
use serde_json::{Value, json};
use std::f32::consts::LN_2;
use std::io::Cursor;

fn png(image: DynamicImage) -> Vec<u8> {
    let mut bytes = Vec::new();
    image.write_to(&mut Cursor::new(&mut bytes), ImageFormat::Png).expect("an encoded image");
    bytes
}

/// A triangle with one material; texture 0 is a grey image of 2 × 1 texels with 8 bits, texture 1 one with 16 bits.
fn file(material: Value) -> File {
    let mut file = File::triangle(json!({ "materials": [material] }));
    file.json["meshes"][0]["primitives"][0]["material"] = json!(0);
    let grey = image::GrayImage::from_raw(2, 1, vec![0, 128]).expect("two texels");
    let deep = image::ImageBuffer::from_raw(1, 1, vec![1u16, 2, 65535]).expect("one texel");
    let views = [png(grey.into()), png(DynamicImage::ImageRgb16(deep))].map(|bytes| file.view(&bytes));
    let images = views.map(|view| json!({ "bufferView": view, "mimeType": "image/png" }));
    merge(
        &mut file.json,
        json!({
            "images": images,
            "samplers": [{ "wrapS": 33071, "wrapT": 33648, "minFilter": 9984 }],
            "textures": [{ "source": 0 }, { "source": 1, "sampler": 0 }]
        }),
    );
    file
}

fn material(json: Value) -> Material {
    file(json).load().expect("a valid file").materials.remove(0)
}

/// Its metallic-roughness model.
pub(crate) fn model(material: &Material) -> &MetallicRoughnessMaterial {
    let MaterialModel::MetallicRoughness(model) = &material.model else { panic!("another model") };
    model
}

#[test]
fn a_primitive_without_material_has_the_default_one() {
    let description = File::triangle(json!({})).load().expect("a valid file");
    let default = model(&description.materials[description.meshes[0].primitives[0].material]);
    assert_eq!((default.metallic, default.roughness, default.ior, default.specular), (1.0, 1.0, 1.5, 1.0));
}

#[test]
fn factors_and_extensions_are_read() {
    let m = material(json!({
        "name": "all", "doubleSided": true, "alphaMode": "MASK", "alphaCutoff": 0.25,
        "pbrMetallicRoughness": { "baseColorFactor": [0.125, 0.25, 0.5, 0.75], "metallicFactor": 0.5, "roughnessFactor": 0.375 },
        "emissiveFactor": [1, 0.5, 0],
        "extensions": {
            "KHR_materials_emissive_strength": { "emissiveStrength": 8 },
            "KHR_materials_ior": { "ior": 1.25 },
            "KHR_materials_specular": { "specularFactor": 0.5, "specularColorFactor": [2, 1, 0] },
            "KHR_materials_transmission": { "transmissionFactor": 0.625 },
            "KHR_materials_volume": { "thicknessFactor": 1, "attenuationDistance": 2, "attenuationColor": [0.5, 1, 1] }
        }
    }));
    assert_eq!((m.name.as_str(), m.double_sided, m.alpha_mode), ("all", true, AlphaMode::Mask { cutoff: 0.25 }));
    assert_eq!((m.alpha, m.emission.to_rgb()), (0.75, [8.0, 4.0, 0.0]));
    let m = model(&m);
    assert_eq!((m.base_color.to_rgb(), m.metallic, m.roughness, m.ior), ([0.125, 0.25, 0.5], 0.5, 0.375, 1.25));
    assert_eq!((m.specular, m.specular_color.to_rgb(), m.transmission), (0.5, [2.0, 1.0, 0.0], 0.625));
    let volume = m.volume.expect("a volume");
    assert!(
        (volume.absorption - Spectrum([0.5 * LN_2, 0.0, 0.0])).map(f32::abs).max_lane() < f32::EPSILON,
        "{volume:?}"
    );
    assert_eq!(m.metal_fresnel, MetalFresnel::Schlick);
}

#[test]
fn thin_walls_have_no_volume_and_index_zero_is_kept() {
    let volume = json!({ "attenuationDistance": 2 });
    let m = material(json!({
        "alphaMode": "BLEND",
        "extensions": { "KHR_materials_volume": volume, "KHR_materials_ior": { "ior": 0 } }
    }));
    assert_eq!((model(&m).volume, model(&m).ior, m.alpha_mode), (None, 0.0, AlphaMode::Blend));
    assert_eq!(m.name, "material 0");
}

#[test]
fn unlit_materials_emit_their_base_colour_alone() {
    let unlit = material(json!({
        "emissiveFactor": [1, 1, 1], "normalTexture": { "index": 0 }, "emissiveTexture": { "index": 1 },
        "pbrMetallicRoughness": { "baseColorFactor": [0.5, 1, 0.25, 1], "baseColorTexture": { "index": 0 } },
        "extensions": { "KHR_materials_unlit": {}, "KHR_materials_transmission": { "transmissionFactor": 1 } }
    }));
    assert!(unlit.is_unlit() && unlit.normal_texture.is_none());
    assert_eq!(unlit.emission, Spectrum::from_rgb([0.5, 1.0, 0.25]));
    // Texture 0 repeats, texture 1 does not.
    assert_eq!(unlit.emission_texture.expect("the base colour").wrap, [Wrap::Repeat; 2]);
}

#[test]
fn the_base_colour_texture_has_alpha_where_alpha_counts() {
    let alpha_texture = |mode: &str| {
        let base = json!({ "baseColorTexture": { "index": 0 } });
        material(json!({ "alphaMode": mode, "pbrMetallicRoughness": base })).alpha_texture
    };
    assert!(alpha_texture("OPAQUE").is_none());
    assert!(alpha_texture("MASK").is_some() && alpha_texture("BLEND").is_some());
}

#[test]
fn each_texture_has_the_encoding_of_its_role() {
    let texture = json!({ "index": 0 });
    let m = material(json!({
        "pbrMetallicRoughness": { "baseColorTexture": texture, "metallicRoughnessTexture": texture },
        "normalTexture": { "index": 0, "scale": 0.5 }, "emissiveTexture": texture, "occlusionTexture": texture,
        "extensions": {
            "KHR_materials_specular": { "specularTexture": texture, "specularColorTexture": texture },
            "KHR_materials_transmission": { "transmissionTexture": texture }
        }
    }));
    let encoding = |t: &Option<etendue::texture::Texture>| t.as_ref().map(|t| t.encoding);
    let textured = model(&m);
    for colour in [&textured.base_color_texture, &m.emission_texture, &textured.specular_color_texture] {
        assert_eq!(encoding(colour), Some(Encoding::Srgb));
    }
    for data in [&textured.metallic_roughness_texture, &textured.specular_texture, &textured.transmission_texture] {
        assert_eq!(encoding(data), Some(Encoding::Linear));
    }
    let (normal, scale) = m.normal_texture.expect("a normal map");
    assert_eq!((normal.encoding, scale), (Encoding::Linear, 0.5));
}

#[test]
fn samplers_and_transforms_are_read_and_only_used_images_are_decoded() {
    let transform = json!({ "KHR_texture_transform": { "offset": [0.25, 0.5], "scale": [2, 4], "texCoord": 1 } });
    let mut file = file(json!({ "normalTexture": { "index": 1, "texCoord": 7, "extensions": transform } }));
    // Were image 0 decoded, this would be an error.
    file.json["images"][0] = json!({ "uri": "nowhere.png" });
    let description = file.load().expect("a valid file");
    assert_eq!(description.images.len(), 1);
    let (texture, _) = description.materials[0].normal_texture.as_ref().expect("a normal map");
    assert_eq!(
        (texture.wrap, texture.filter, texture.uv_set),
        ([Wrap::Clamp, Wrap::Mirror], TextureFilter::Nearest, 1)
    );
    assert_eq!(texture.transform.transform_point2(glam::Vec2::ONE), glam::Vec2::new(2.25, 4.5));
}

#[test]
fn every_mode_of_a_sampler_is_read() {
    let texture = |sampler: Value| {
        let mut file = file(json!({ "emissiveTexture": { "index": 1 } }));
        file.json["samplers"][0] = sampler;
        file.load().expect("a valid file").materials.remove(0).emission_texture.expect("a texture")
    };
    let wraps = [
        (json!(33071), Wrap::Clamp),
        (json!(33648), Wrap::Mirror),
        (json!(10497), Wrap::Repeat),
        (Value::Null, Wrap::Repeat),
    ];
    for (s, in_u) in &wraps {
        for (t, in_v) in &wraps {
            let mut sampler = json!({});
            [("wrapS", s), ("wrapT", t)]
                .into_iter()
                .filter(|(_, w)| !w.is_null())
                .for_each(|(k, w)| sampler[k] = w.clone());
            assert_eq!(texture(sampler).wrap, [*in_u, *in_v]);
        }
    }
    // Magnification decides; without it minification does, of which only what is no mipmap is left.
    for (min, without_mag) in [
        (9728, TextureFilter::Nearest),
        (9729, TextureFilter::Linear),
        (9984, TextureFilter::Nearest),
        (9985, TextureFilter::Linear),
        (9986, TextureFilter::Nearest),
        (9987, TextureFilter::Linear),
    ] {
        assert_eq!(texture(json!({ "minFilter": min })).filter, without_mag, "{min}");
        assert_eq!(texture(json!({ "minFilter": min, "magFilter": 9728 })).filter, TextureFilter::Nearest);
        assert_eq!(texture(json!({ "minFilter": min, "magFilter": 9729 })).filter, TextureFilter::Linear);
    }
}

#[test]
fn sixteen_bits_have_the_curve_of_eight() {
    use etendue::texture::{Bitmap, Texels};
    let eight = Bitmap::new(256, 1, Texels::Rgba8((0..=255).map(|i| [i, i, i, i]).collect::<Vec<_>>().into()));
    let sixteen = Bitmap::new(256, 1, Texels::Rgba16((0..=255u16).map(|i| [i * 257; 4]).collect::<Vec<_>>().into()));
    for encoding in [Encoding::Srgb, Encoding::Linear] {
        for x in 0..256 {
            let (a, b) = (eight.texel(x, 0, encoding), sixteen.texel(x, 0, encoding));
            // i/255 and 257 i/65535 are one number, each rounded once; the curve's slope is at most 2.3, and alpha has
            // none.
            assert!(a.iter().zip(b).all(|(a, b)| (a - b).abs() <= 2.5 * f32::EPSILON), "{x}: {a:?} {b:?}");
        }
    }
    // IEC 61966-2-1 at 32768/65535, in double precision; two roundings of the argument at a slope below 1.
    let half = Bitmap::new(1, 1, Texels::Rgba16(vec![[32768; 4]].into())).texel(0, 0, Encoding::Srgb);
    assert!((half[0] - 0.214_048_2).abs() < 2e-7 && half[3] > 0.5, "{half:?}");
}

#[test]
fn images_keep_their_depth() {
    let image = |index: usize| {
        let material = json!({ "pbrMetallicRoughness": { "baseColorTexture": { "index": index } } });
        file(material).load().expect("a valid file").images.remove(0)
    };
    assert_eq!((image(0).size(), image(0).bytes()), ([2, 1], 8));
    let texel = |index: usize, x: u32| Vec4::from(image(index).texel(x, 0, Encoding::Linear));
    assert_eq!(texel(0, 1), Vec3::splat(128.0 / 255.0).extend(1.0));
    assert_eq!((image(1).size(), image(1).bytes()), ([1, 1], 8));
    assert_eq!(texel(1, 0), Vec4::new(1.0 / 65535.0, 2.0 / 65535.0, 1.0, 1.0));
}

#[test]
fn two_textures_of_one_image_share_it() {
    let material =
        json!({ "pbrMetallicRoughness": { "baseColorTexture": { "index": 0 } }, "emissiveTexture": { "index": 0 } });
    let description = file(material).load().expect("a valid file");
    assert_eq!(description.images.len(), 1);
    // One here, one in each of two textures.
    assert_eq!(std::sync::Arc::strong_count(&description.images[0]), 3);
}

#[test]
fn broken_images_are_errors_that_name_them() {
    let material = json!({ "emissiveTexture": { "index": 0 } });
    let mut missing = file(material.clone());
    missing.json["images"][0] = json!({ "uri": "no%20such.png", "name": "lost" });
    let error = missing.error();
    assert!(error.starts_with("image 'lost': cannot read") && error.contains("no such.png"), "{error}");
    let mut other = file(material.clone());
    other.json["images"][0] = json!({ "uri": "data:image/webp;base64,UklGRgAAAABXRUJQVlA4" });
    assert_eq!(other.error(), "image 'image 0': it is neither PNG nor JPEG");
    let mut cut = file(material);
    let view = cut.json["images"][0]["bufferView"].as_u64().expect("a view") as usize;
    let length = cut.json["bufferViews"][view]["byteLength"].as_u64().expect("a length");
    cut.json["bufferViews"][view]["byteLength"] = json!(length - 30);
    assert!(cut.error().starts_with("image 'image 0': it cannot be decoded"), "{}", cut.error());
}

#[test]
fn a_png_that_claims_to_be_huge_is_refused_by_its_header() {
    let mut bytes = png(image::GrayImage::new(1, 1).into());
    // Width and height in IHDR, and its checksum, which the decoder would otherwise complain about.
    bytes[16..24].copy_from_slice(&[0, 1, 0, 0, 0, 1, 0, 0]);
    let crc = crc32(&bytes[12..29]);
    bytes[29..33].copy_from_slice(&crc.to_be_bytes());
    let mut file = file(json!({ "emissiveTexture": { "index": 0 } }));
    let view = file.view(&bytes);
    file.json["images"][0]["bufferView"] = json!(view);
    assert!(file.error().starts_with("image 'image 0': it cannot be decoded"), "{}", file.error());
    assert!(file.error().contains("limit"), "{}", file.error());
}

/// The checksum of PNG chunks.
pub(crate) fn crc32(bytes: &[u8]) -> u32 {
    let bit = |crc: u32, _| if crc & 1 == 1 { 0xEDB8_8320 ^ (crc >> 1) } else { crc >> 1 };
    !bytes.iter().fold(!0, |crc, &byte| (0..8).fold(crc ^ u32::from(byte), bit))
}

#[test]
fn unsupported_material_features_are_reported() {
    let description = |json| file(json).load().expect("a valid file");
    let third = description(json!({ "name": "a", "emissiveTexture": { "index": 0, "texCoord": 2 } }));
    assert!(third.materials[0].emission_texture.is_none() && third.images.is_empty());
    assert_eq!(third.ignored, ["the emissive texture of material 'a' is left out: it uses texture coordinate set 2"]);
    let bright = description(json!({ "name": "a", "pbrMetallicRoughness": { "baseColorFactor": [2, 1e300, 0, 1] } }));
    assert_eq!(model(&bright.materials[0]).base_color, Spectrum::from_rgb([1.0, 1.0, 0.0]));
    assert_eq!(bright.ignored, ["material 'a' has a base colour outside 0 to 1, which is clamped"]);
    let mut webp = file(json!({ "name": "a", "emissiveTexture": { "index": 0 } }));
    webp.json["textures"][0] = json!({ "extensions": { "EXT_texture_webp": { "source": 0 } } });
    webp.json["extensionsUsed"] = json!(["EXT_texture_webp"]);
    let ignored = webp.load().expect("a valid file").ignored;
    assert_eq!(
        ignored,
        [
            "the extension EXT_texture_webp is not read",
            "the emissive texture of material 'a' is left out: it has no PNG or JPEG image"
        ]
    );
}

#[test]
fn factors_out_of_range_are_errors() {
    let error = |json: Value| file(json).error();
    let extension = |name: &str, value: Value| json!({ "name": "a", "extensions": { name: value } });
    assert_eq!(
        error(extension("KHR_materials_ior", json!({ "ior": 0.5 }))),
        "material 'a': the refractive index is out of range"
    );
    let volume = json!({ "attenuationDistance": 0 });
    assert_eq!(
        error(extension("KHR_materials_volume", volume)),
        "material 'a': the attenuation distance is out of range"
    );
    let glow = json!({ "name": "a", "emissiveFactor": [1e300, 0, 0] });
    assert_eq!(error(glow), "material 'a': the emission is out of range");
}

#[test]
fn our_own_extras_are_read_strictly() {
    let with = |etendue: Value| file(json!({ "name": "gold", "extras": { "etendue": etendue, "other": 1 } }));
    let fresnel = |etendue: Value| model(&with(etendue).load().expect("a valid file").materials[0]).metal_fresnel;
    assert_eq!(fresnel(json!({ "fresnel": "constant" })), MetalFresnel::Constant);
    assert_eq!(fresnel(json!({ "fresnel": "schlick" })), MetalFresnel::Schlick);
    assert_eq!(fresnel(json!({})), MetalFresnel::Schlick);
    assert_eq!(
        with(json!({ "fresnell": "constant" })).error(),
        "material 'gold': extras.etendue has the unknown key 'fresnell'"
    );
    let neither = "material 'gold': extras.etendue.fresnel is neither \"schlick\" nor \"constant\"";
    assert_eq!(with(json!({ "fresnel": "Constant" })).error(), neither);
    assert_eq!(with(json!({ "fresnel": 1 })).error(), neither);
    assert_eq!(with(json!(1)).error(), "material 'gold': extras.etendue is not an object");
    let scattering = "material 'gold': extras.etendue.scattering is neither a number nor three of them, from 0 to 1e6";
    for wrong in [json!(-1), json!([1, 2]), json!("milk"), json!([1, 2, 1e7])] {
        assert_eq!(with(json!({ "scattering": wrong })).error(), scattering);
    }
    for wrong in [json!(1), json!([0.5, 0.5, 2]), json!("mie")] {
        let error = with(json!({ "scattering": 1, "phase": wrong })).error();
        assert!(error.starts_with("material 'gold': extras.etendue.phase is neither"), "{error}");
    }
    assert_eq!(with(json!({ "phase": 0.5 })).error(), "material 'gold': extras.etendue has a phase, but no scattering");
    let nothing = "material 'gold': the medium in extras.etendue has no volume with a thickness to fill";
    assert_eq!(with(json!({ "scattering": 1 })).error(), nothing);
    let parts = "material 'gold': extras.etendue tells albedo and mean_free_path, or scattering and absorption, but not parts of both";
    for part in [
        json!({ "albedo": 0.5 }),
        json!({ "mean_free_path": 1 }),
        json!({ "albedo": 1, "mean_free_path": 1, "scattering": 1 }),
    ] {
        assert_eq!(with(part).error(), parts);
    }
    let bright = "material 'gold': extras.etendue.albedo is neither a number nor three of them, from 0 to 1e0";
    assert_eq!(with(json!({ "albedo": 2, "mean_free_path": 1 })).error(), bright);
}

/// The volume of a solid of glass with these extras and more extensions.
fn medium(etendue: Value, scattering: Value) -> Volume {
    let mut extensions = json!({
        "KHR_materials_transmission": { "transmissionFactor": 1 },
        "KHR_materials_volume": { "thicknessFactor": 1, "attenuationDistance": 0.5, "attenuationColor": [0.5, 1, 1] }
    });
    if !scattering.is_null() {
        extensions["KHR_materials_volume_scatter"] = scattering;
    }
    let material = json!({ "name": "wax", "extensions": extensions, "extras": { "etendue": etendue } });
    model(&file(material).load().expect("a valid file").materials[0]).volume.expect("a volume")
}

#[test]
fn media_are_told_by_coefficients_or_by_how_they_look() {
    let told = medium(json!({ "scattering": [1, 2, 3], "absorption": 4, "emission": 5, "phase": 0.5 }), Value::Null);
    assert_eq!((told.scattering.to_rgb(), told.absorption.to_rgb()), ([1.0, 2.0, 3.0], [4.0; 3]));
    assert_eq!((told.emission.to_rgb(), told.phase), ([5.0; 3], Phase::HenyeyGreenstein(0.5)));
    // The attenuation of the volume is absorption.
    let glass = medium(json!({}), Value::Null);
    assert!((glass.absorption - Spectrum([2.0 * LN_2, 0.0, 0.0])).map(f32::abs).max_lane() < f32::EPSILON, "{glass:?}");
    // Black absorbs, white scatters; at 0.256557 the single-scattering albedo is 0.7.
    let looks = medium(json!({ "albedo": [0, 1, 0.256557], "mean_free_path": [0.5, 0.25, 1] }), Value::Null);
    let [[a, b, c], [d, e, f]] = [looks.scattering.to_rgb(), looks.absorption.to_rgb()];
    assert_eq!((a, b, d, e), (0.0, 4.0, 2.0, 0.0));
    // The table's digits and the fit: 1e-5.
    assert!((c - 0.7).abs() < 1e-5 && (f - 0.3).abs() < 1e-5, "{c} {f}");
    // Red glows at 1000 K.
    let [r, g, b] = medium(json!({ "emission": 2, "temperature": 1000 }), Value::Null).emission.to_rgb();
    assert!(r > 5.0 && g > 0.0 && g < 0.2 * r && b <= 0.0, "{r} {g} {b}");
}

#[test]
fn the_draft_of_scattering_shares_attenuation() {
    let draft = json!({ "multiscatterColor": [0.8, 0, 0], "scatterAnisotropy": 0.3 });
    let volume = medium(json!({}), draft);
    let attenuation = 2.0 * LN_2;
    // The draft's formula at 0.8.
    let albedo = 1.0 - (4.09712 + 4.20863 * 0.8 - f64::sqrt(9.59217 + 41.6808 * 0.8 + 17.7126 * 0.64)).powi(2);
    let [scattering, absorption] = [volume.scattering.0[0] / attenuation, volume.absorption.0[0] / attenuation];
    assert!((f64::from(scattering) - albedo).abs() < 1e-6, "{scattering} {albedo}");
    assert!((scattering + absorption - 1.0).abs() < 1e-6);
    assert_eq!((volume.phase, volume.scattering.0[1]), (Phase::HenyeyGreenstein(0.3), 0.0));
    let volume = json!({ "KHR_materials_volume": { "thicknessFactor": 1 } });
    for draft in [
        json!({ "multiscatterColor": [2, 0, 0] }),
        json!({ "scatterAnisotropy": 1 }),
        json!({ "multiscatterColor": 1 }),
    ] {
        let mut material = json!({ "name": "a", "extensions": volume });
        material["extensions"]["KHR_materials_volume_scatter"] = draft;
        assert_eq!(file(material).error(), "material 'a': the colour or anisotropy of scattering is out of range");
    }
}
