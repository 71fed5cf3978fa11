//! Textures where they meet light: lamps that are brighter in some places, normals that a map bends.

use crate::picture::{Picture, Shot, agree, render, scene};
use etendue::integrator::Method;
use etendue::scene::description::{Description, Material};
use etendue::texture::{Bitmap, Encoding, Texels, Texture, TextureFilter, Wrap};
use etendue_testing::studio::{add_square, camera, matte, narrow, point_light};
use glam::{Affine2, DVec3, Vec2, Vec3, Vec4};
use std::f64::consts::PI;
use std::sync::Arc;

fn texture(width: u32, encoding: Encoding, texels: Vec<[u8; 4]>) -> Texture {
    let image = Arc::new(Bitmap::new(width, texels.len() as u32 / width, Texels::Rgba8(texels.into())));
    let (wrap, filter) = ([Wrap::Clamp; 2], TextureFilter::Nearest);
    Texture { image, encoding, wrap, filter, uv_set: 0, transform: Affine2::IDENTITY }
}

/// The corners of `add_square`'s squares in a picture whose u runs along the first half edge and whose v against the
/// second.
fn corners() -> Vec<Vec2> {
    [[0.0, 1.0], [1.0, 1.0], [1.0, 0.0], [0.0, 0.0]].map(Vec2::from).to_vec()
}

/// A lamp close above a floor, with one half ten times as bright as the other: found by chance or sampled, its light
/// falls to the same places.
#[test]
fn a_textured_lamp_lights_alike_by_every_method() {
    let mut room = Description::default();
    add_square(&mut room, Vec3::ZERO, Vec3::X * 2.0, Vec3::NEG_Z * 2.0, matte(0.7, 0.0));
    let halves = vec![[250, 250, 250, 255], [25, 25, 25, 255]];
    let lamp = Material { emission_texture: Some(texture(2, Encoding::Linear, halves)), ..matte(0.0, 4.0) };
    add_square(&mut room, Vec3::Y * 0.5, Vec3::X, Vec3::Z * 0.5, lamp);
    room.meshes[1].primitives[0].uvs[0] = Some(corners());
    room.cameras.push(camera(DVec3::new(0.0, 0.4, 2.5), DVec3::new(0.0, 0.1, 0.0)));
    let room = scene(room);
    let shots = [(Method::PathNaive, 512), (Method::PathNee, 64), (Method::Path, 64)];
    let [naive, nee, path]: [Picture; 3] = shots.map(|(method, spp)| render(&room, Shot::new(method, 32, spp)));
    agree(&path, &nee, 4).unwrap_or_else(|e| panic!("path and path-nee: {e}"));
    agree(&path, &naive, 4).unwrap_or_else(|e| panic!("path and path-naive: {e}"));
}

/// A matte floor whose map bends all normals one way, under a point light: radiance is ρ I cos / (π d²) by the angle to
/// the bent normal. Red bends along the tangent (u), green along the bitangent (against v, since v runs downward), or
/// the other way where the handedness is −1 [glTF 2.0 §3.9.3].
#[test]
fn normal_maps_bend_where_the_specification_says() {
    let light = DVec3::new(0.6, 1.5, -0.9);
    let bend = |texel: u8| 2.0 * f64::from(texel) / 255.0 - 1.0;
    for [red, green] in [[128u8, 204], [204, 128], [90, 170]] {
        for handedness in [None, Some(1.0f32), Some(-1.0)] {
            let mut floor = Description::default();
            let map = texture(1, Encoding::Linear, vec![[red, green, 230, 255]]);
            add_square(
                &mut floor,
                Vec3::ZERO,
                Vec3::X,
                Vec3::NEG_Z,
                Material { normal_texture: Some((map, 1.0)), ..matte(0.5, 0.0) },
            );
            let primitive = &mut floor.meshes[0].primitives[0];
            primitive.uvs[0] = Some(corners());
            primitive.normals = Some(vec![Vec3::Y; 4]);
            primitive.tangents = handedness.map(|w| vec![Vec4::new(1.0, 0.0, 0.0, w); 4]);
            floor.lights.push(point_light(light, 3.0));
            floor.cameras.push(narrow(camera(DVec3::new(0.1, 1.0, 0.0), DVec3::ZERO), 1e-4));
            // u runs along x, v along z: the bitangent is −z
            let bitangent = DVec3::NEG_Z * f64::from(handedness.unwrap_or(1.0));
            let ns = (DVec3::X * bend(red) + bitangent * bend(green) + DVec3::Y * bend(230)).normalize();
            let expected = 0.5 * 3.0 * ns.dot(light.normalize()) / (PI * light.length_squared());
            let picture = render(&scene(floor), Shot { depth: Some(1), ..Shot::new(Method::Path, 4, 4) });
            for &seen in &picture.mean {
                // the view's width
                assert!((seen / expected - 1.0).abs() < 1e-3, "{red} {green} {handedness:?}: {seen}, not {expected}");
            }
        }
    }
}
