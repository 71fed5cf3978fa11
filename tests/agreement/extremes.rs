//! Features of a scene that depend on textures: only the texels in use count.

use crate::picture::{Block, Shot, agree, render, scene};
use etendue::integrator::{Method, blind_spots};
use etendue::scene::Features;
use etendue::scene::description::{AlphaMode, Description, DiffuseMaterial, Material, MaterialModel};
use etendue::spectrum::Spectrum;
use etendue::texture::{Bitmap, Encoding, Texels, Texture, TextureFilter, Wrap};
use etendue_testing::studio::{add_square, camera, glass, matte, metal, point_light, with_model};
use glam::{Affine2, DVec3, Vec2, Vec3, Vec4};
use std::sync::Arc;

pub(crate) fn strip(texels: Vec<[u8; 4]>) -> Option<Texture> {
    let image = Arc::new(Bitmap::new(texels.len() as u32, 1, Texels::Rgba8(texels.into())));
    let (wrap, filter, encoding) = ([Wrap::Repeat; 2], TextureFilter::Linear, Encoding::Linear);
    Some(Texture { image, encoding, wrap, filter, uv_set: 0, transform: Affine2::IDENTITY })
}

fn flat(texel: [u8; 4]) -> Option<Texture> {
    strip(vec![texel])
}

/// A square of `material` before the camera, with u from one number to the other.
fn wearing(material: Material, [from, to]: [f32; 2]) -> Description {
    let mut room = Description::default();
    add_square(&mut room, Vec3::ZERO, Vec3::X, Vec3::Y, material);
    room.meshes[0].primitives[0].uvs[0] = Some([from, to, to, from].map(|u| Vec2::new(u, 0.5)).to_vec());
    add_square(&mut room, Vec3::Z * 6.0, Vec3::X * 4.0, Vec3::NEG_Y * 4.0, matte(0.0, 1.0));
    room.cameras.push(camera(DVec3::Z * 3.0, DVec3::ZERO));
    room
}

fn features(material: Material) -> Features {
    scene(wearing(material, [0.0, 1.0])).features()
}

/// A factor, and a texture of one texel under a factor of 1, are one scene.
#[test]
fn constant_texture_equals_a_factor() {
    let mirror = || metal(0.8, 0.0);
    let half = Material { alpha: 0.5, alpha_mode: AlphaMode::Blend, ..matte(0.5, 0.0) };
    let cutoff = AlphaMode::Mask { cutoff: 0.5 };
    let white = || flat([255; 4]);
    let pairs = [
        (with_model(mirror(), |m| m.base_color_texture = white()), mirror()),
        (with_model(glass(0.0), |m| m.base_color_texture = white()), glass(0.0)),
        (with_model(glass(0.0), |m| m.transmission_texture = white()), glass(0.0)),
        (
            with_model(glass(0.0), |m| m.transmission_texture = flat([0; 4])),
            with_model(glass(0.0), |m| m.transmission = 0.0),
        ),
        (with_model(mirror(), |m| m.metallic_roughness_texture = white()), mirror()),
        (with_model(metal(0.8, 1.0), |m| m.metallic_roughness_texture = flat([0, 0, 255, 255])), mirror()),
        (
            with_model(metal(0.8, 0.3), |m| m.metallic_roughness_texture = flat([0, 255, 0, 255])),
            with_model(metal(0.8, 0.3), |m| m.metallic = 0.0),
        ),
        (
            with_model(matte(0.5, 0.0), |m| {
                m.specular_texture = flat([255, 255, 255, 0]);
                m.specular = 1.0;
            }),
            matte(0.5, 0.0),
        ),
        (with_model(mirror(), |m| m.specular_color_texture = white()), mirror()),
        (Material { emission_texture: flat([0; 4]), ..matte(0.5, 4.0) }, matte(0.5, 0.0)),
        (Material { emission_texture: white(), ..matte(0.5, 4.0) }, matte(0.5, 4.0)),
        (
            Material { alpha: 1.0, alpha_texture: flat([255, 255, 255, 0]), ..half.clone() },
            Material { alpha: 0.0, ..half.clone() },
        ),
        (Material { alpha: 1.0, alpha_texture: white(), ..half.clone() }, matte(0.5, 0.0)),
        (Material { alpha_mode: cutoff, alpha_texture: white(), ..matte(0.5, 0.0) }, matte(0.5, 0.0)),
        (
            Material { alpha_mode: cutoff, alpha_texture: flat([255, 255, 255, 9]), ..matte(0.5, 0.0) },
            Material { alpha: 0.1, alpha_mode: cutoff, ..matte(0.5, 0.0) },
        ),
    ];
    for (index, (textured, plain)) in pairs.into_iter().enumerate() {
        let [a, b] = [textured, plain].map(|m| scene(wearing(m, [0.0, 1.0])));
        assert_eq!(a.features().names(), b.features().names(), "pair {index}");
        assert_eq!(a.info().lights, b.info().lights, "pair {index}");
        for method in [Method::PathNaive, Method::Path, Method::Light] {
            assert_eq!(blind_spots(method, &a), blind_spots(method, &b), "pair {index}");
        }
    }
}

/// Lambertian reflection is a dielectric without reflection.
#[test]
fn diffuse_materials_equal_matte_dielectrics() {
    let grey = || flat([100, 150, 200, 255]);
    let diffuse = Material { double_sided: true, ..Material::diffuse(Spectrum::splat(0.5)) };
    let model = DiffuseMaterial { reflectance: Spectrum::splat(0.5), reflectance_texture: grey() };
    let textured = Material { model: MaterialModel::Diffuse(model), ..diffuse.clone() };
    let pairs =
        [(diffuse, matte(0.5, 0.0)), (textured, with_model(matte(0.5, 0.0), |m| m.base_color_texture = grey()))];
    for (diffuse, glossy) in pairs {
        let [a, b] = [diffuse, glossy].map(|material| {
            let mut room = wearing(material, [0.0, 1.0]);
            room.meshes[0].primitives[0].colors = Some(vec![Vec4::new(0.9, 0.8, 0.7, 1.0); 4]);
            render(&scene(room), Shot::new(Method::Bdpt, 8, 16)).blocks(8)
        });
        let means = |blocks: Vec<Block>| blocks.into_iter().map(|block| block.mean).collect::<Vec<_>>();
        let (a, b) = (means(a), means(b));
        assert!(a.iter().any(|mean| *mean > 0.0));
        assert_eq!(a, b);
    }
}

/// One of eight texels is exceptional. It affects exactly the surfaces whose coordinates touch it.
#[test]
fn texels_outside_the_used_uvs_have_no_effect() {
    let special = |usual: [u8; 4], other: [u8; 4]| {
        let mut texels = vec![usual; 8];
        texels[5] = other;
        strip(texels)
    };
    let mirrors = with_model(metal(0.8, 1.0), |m| m.metallic_roughness_texture = special([255; 4], [0, 0, 255, 255]));
    let glass = with_model(glass(0.0), |m| m.transmission_texture = special([0; 4], [255; 4]));
    let lamp = Material { emission_texture: special([0; 4], [255; 4]), ..matte(0.5, 4.0) };
    let hole = Material {
        alpha_mode: AlphaMode::Blend,
        alpha_texture: special([255; 4], [255, 255, 255, 0]),
        ..matte(0.5, 0.0)
    };
    let count = |m: &Material, uvs| {
        let scene = scene(wearing(m.clone(), uvs));
        let (f, lamps) = (scene.features(), scene.info().lights - 2);
        [f.dirac && f.textures, f.refraction, lamps > 0, f.blends]
    };
    // Texel 5 is looked up from 4.5/8 to 6.5/8, and again one to the left and to the right.
    for uvs in [[0.0, 1.0], [0.1, 0.57], [0.8, 0.9], [1.1, 1.6], [-0.4, -0.3], [0.6, 0.65]] {
        assert_eq!(count(&mirrors, uvs), [true, false, false, false], "{uvs:?}");
        assert!(count(&hole, uvs)[3], "{uvs:?}");
        assert!(count(&lamp, uvs)[2], "{uvs:?}");
        assert!(count(&glass, uvs)[1], "{uvs:?}");
    }
    for uvs in [[0.0, 0.55], [0.82, 0.99], [0.85, 1.55], [-0.15, 0.55]] {
        for material in [&mirrors, &lamp, &hole] {
            assert_eq!(count(material, uvs), [false; 4], "{uvs:?}");
        }
        assert!(!count(&glass, uvs)[1], "{uvs:?}");
    }
}

/// What vertex colours do to alpha counts as what textures do.
#[test]
fn vertex_alpha_makes_holes_where_it_is_below_one() {
    for (alpha, holes) in [(1.0, false), (0.9, true)] {
        let mut room = wearing(Material { alpha_mode: AlphaMode::Blend, ..matte(0.5, 0.0) }, [0.0, 1.0]);
        room.meshes[0].primitives[0].colors =
            Some([1.0, alpha, 1.0, 1.0].map(|a| Vec4::new(1.0, 1.0, 1.0, a)).to_vec());
        assert_eq!(scene(room).features().blends, holes);
    }
}

/// Methods that do not sample the caustics of point lights report mirrors that only a texture makes as blind spots.
#[test]
fn textured_mirrors_are_blind_spots() {
    let rough = with_model(metal(0.8, 1.0), |m| m.metallic_roughness_texture = strip(vec![[255; 4], [0, 0, 255, 255]]));
    let mut room = wearing(rough, [0.0, 1.0]);
    room.lights.push(point_light(DVec3::new(0.0, 1.0, 2.0), 1.0));
    let room = scene(room);
    let told = |method| blind_spots(method, &room).join(" ");
    assert!(told(Method::Light).contains("mirrors"));
    assert!(told(Method::PathNaive).contains("mirrors"));
    assert!(told(Method::Path).contains("point, spot"));
    assert!(told(Method::PathNee).contains("point, spot"));
    assert!(told(Method::Bdpt).is_empty());
    assert!(features(matte(0.5, 0.0)).names().iter().all(|name| *name != "dirac-materials"));
}

/// A lamp of many triangles of which a texture lights few: the same picture, whatever light is chosen.
#[test]
fn triangles_without_light_are_never_chosen() {
    let lamp = Material { emission_texture: strip([vec![[0; 4]; 7], vec![[255; 4]]].concat()), ..matte(0.0, 8.0) };
    let mut room = Description::default();
    for i in 0..8 {
        add_square(&mut room, Vec3::new(i as f32 * 0.4 - 1.4, 0.9, 0.0), Vec3::X * 0.2, Vec3::Z * 0.2, lamp.clone());
        // One texel of the strip each, at its centre.
        room.meshes[i].primitives[0].uvs[0] = Some(vec![Vec2::new((i as f32 + 0.5) / 8.0, 0.5); 4]);
    }
    add_square(
        &mut room,
        Vec3::ZERO,
        Vec3::X * 2.0,
        Vec3::NEG_Z * 2.0,
        with_model(matte(0.7, 0.0), |m| m.base_color = Spectrum::splat(0.7)),
    );
    room.cameras.push(camera(DVec3::new(0.0, 0.6, 2.5), DVec3::new(0.0, 0.1, 0.0)));
    let room = scene(room);
    assert_eq!(room.info().lights, 2);
    let [path, naive, bdpt] = [(Method::Path, 64), (Method::PathNaive, 512), (Method::Bdpt, 64)]
        .map(|(method, spp)| render(&room, Shot::new(method, 32, spp)));
    agree(&path, &naive, 4).unwrap_or_else(|e| panic!("path and path-naive: {e}"));
    agree(&path, &bdpt, 4).unwrap_or_else(|e| panic!("path and bdpt: {e}"));
}
