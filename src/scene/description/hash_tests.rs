//! Every field of a description affects the image, or is listed here as irrelevant to it.

use super::*;
use crate::texture::Texels;

fn texture() -> Texture {
    Texture {
        image: Arc::new(Bitmap::new(2, 1, Texels::Rgba8(vec![[1; 4], [2; 4]].into()))),
        encoding: Encoding::Linear,
        wrap: [Wrap::Repeat; 2],
        filter: TextureFilter::Linear,
        uv_set: 0,
        transform: Affine2::IDENTITY,
    }
}

fn model(base_color_texture: Option<Texture>) -> MaterialModel {
    MaterialModel::MetallicRoughness(MetallicRoughnessMaterial {
        base_color_texture,
        ..MetallicRoughnessMaterial::default()
    })
}

/// The metallic-roughness model of the material.
fn glossy(d: &mut Description) -> &mut MetallicRoughnessMaterial {
    let MaterialModel::MetallicRoughness(model) = &mut d.materials[0].model else { panic!("another model") };
    model
}

fn description() -> Description {
    let primitive =
        Primitive { positions: vec![glam::Vec3::ZERO; 3], triangles: vec![[0, 1, 2]], ..Primitive::default() };
    Description {
        meshes: vec![Mesh { name: "mesh".into(), primitives: vec![primitive] }],
        instances: vec![Instance { name: "node".into(), mesh: 0, transform: DAffine3::IDENTITY }],
        materials: vec![Material { model: model(Some(texture())), ..Material::default() }],
        lights: vec![PunctualLight {
            name: "lamp".into(),
            kind: PunctualKind::Spot { inner: 0.1, outer: 0.2 },
            intensity: Spectrum::ONE,
            transform: DAffine3::IDENTITY,
        }],
        cameras: vec![CameraDescription {
            name: "camera".into(),
            projection: Projection::Perspective { yfov: 1.0, aspect: None },
            transform: DAffine3::IDENTITY,
            lens: None,
        }],
        ..Description::default()
    }
}

type Change = fn(&mut Description);

/// Returns whether `change` changes the hash.
fn changes(change: Change) -> bool {
    let mut changed = description();
    change(&mut changed);
    of(&changed) != of(&description())
}

#[test]
fn every_rendered_field_changes_the_scene_hash() {
    let changed: &[(&str, Change)] = &[
        ("positions", |d| d.meshes[0].primitives[0].positions[1].x = 1.0),
        ("triangles", |d| d.meshes[0].primitives[0].triangles[0] = [0, 2, 1]),
        ("normals", |d| d.meshes[0].primitives[0].normals = Some(vec![glam::Vec3::Z; 3])),
        ("no normals", |d| d.meshes[0].primitives[0].normals = Some(vec![])),
        ("second coordinates", |d| d.meshes[0].primitives[0].uvs[1] = Some(vec![glam::Vec2::ONE; 3])),
        ("colours", |d| d.meshes[0].primitives[0].colors = Some(vec![glam::Vec4::ONE; 3])),
        ("material", |d| d.meshes[0].primitives[0].material = 1),
        ("parts of meshes", |d| d.meshes.insert(0, Mesh { name: "mesh".into(), primitives: vec![] })),
        ("place", |d| d.instances[0].transform.translation.x = 1e-9),
        ("roughness", |d| glossy(d).roughness = 0.5),
        ("unlit", |d| d.materials[0].model = MaterialModel::Unlit),
        ("double sided", |d| d.materials[0].double_sided = true),
        ("alpha mode", |d| d.materials[0].alpha_mode = AlphaMode::Mask { cutoff: 0.0 }),
        ("volume", |d| {
            glossy(d).volume = Some(Volume::absorbing(1.0, Spectrum::splat(0.5)));
        }),
        ("which texture", |d| d.materials[0].emission_texture = glossy(d).base_color_texture.take()),
        ("alpha texture", |d| d.materials[0].alpha_texture = Some(texture())),
        ("reflectance", |d| d.materials[0].model = Material::diffuse(Spectrum::ONE).model),
        ("texel", |d| {
            let image = Arc::new(Bitmap::new(2, 1, Texels::Rgba8(vec![[1; 4], [3; 4]].into())));
            glossy(d).base_color_texture = Some(Texture { image, ..texture() });
        }),
        ("shape of an image", |d| {
            let image = Arc::new(Bitmap::new(1, 2, Texels::Rgba8(vec![[1; 4], [2; 4]].into())));
            glossy(d).base_color_texture = Some(Texture { image, ..texture() });
        }),
        ("wrap", |d| glossy(d).base_color_texture = Some(Texture { wrap: [Wrap::Repeat, Wrap::Clamp], ..texture() })),
        ("intensity", |d| d.lights[0].intensity = Spectrum::ZERO),
        ("cone", |d| d.lights[0].kind = PunctualKind::Spot { inner: 0.1, outer: 0.3 }),
        ("projection", |d| d.cameras[0].projection = Projection::Orthographic { xmag: 1.0, ymag: 1.0 }),
        ("a lens", |d| d.cameras[0].lens = Some(Lens { radius: 0.0, focus: 1.0, blades: 0, rotation: 0.0 })),
        ("a camera's name", |d| d.cameras[0].name = "other".into()),
        ("environment", |d| d.environment = Some(EnvironmentDescription::Uniform(Spectrum::ZERO))),
    ];
    for (what, change) in changed {
        assert!(changes(*change), "{what}");
    }
}

#[test]
fn names_and_notes_do_not_change_the_scene_hash() {
    let kept: &[(&str, Change)] = &[
        ("a material's name", |d| d.materials[0].name = "other".into()),
        ("a mesh's name", |d| d.meshes[0].name = "other".into()),
        ("a node's name", |d| d.instances[0].name = "other".into()),
        ("a lamp's name", |d| d.lights[0].name = "other".into()),
        ("warnings", |d| d.warnings.push("doubtful".into())),
        ("another copy of an image", |d| glossy(d).base_color_texture = Some(texture())),
    ];
    for (what, change) in kept {
        assert!(!changes(*change), "{what}");
    }
}
