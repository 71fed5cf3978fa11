//! Renders a scene that is described in code: `cargo run --release --example own_scene`.

use etendue::glam::{DAffine3, DVec3, Vec3};
use etendue::scene::description::{CameraDescription, Instance, Material, Mesh, Primitive, Projection};
use etendue::spectrum::Spectrum;
use etendue::{Description, Render, Scene};

fn main() -> etendue::Result<()> {
    let mut description = Description::default();
    let clay = Material { double_sided: true, ..Material::diffuse(Spectrum::splat(0.5)) };
    let lamp = Material { emission: Spectrum::splat(10.0), double_sided: true, ..Material::default() };
    add_square(&mut description, DVec3::ZERO, 2.0, clay);
    add_square(&mut description, DVec3::new(0.0, 2.0, 0.0), 0.5, lamp);
    let projection = Projection::Perspective { yfov: 0.8, aspect: None };
    // A camera looks along −z of its transform.
    let transform = DAffine3::from_translation(DVec3::new(0.0, 1.0, 5.0));
    description.cameras.push(CameraDescription { name: "front".into(), projection, transform, lens: None });

    let scene = Scene::from_description(description)?;
    let image = Render::new(&scene).size(64, 48).spp(16).run()?;
    let mean = image.rgb().iter().sum::<f32>() / image.rgb().len() as f32;
    println!("mean radiance {mean:.3}");
    Ok(())
}

/// Adds a horizontal square with that centre and half side.
fn add_square(description: &mut Description, centre: DVec3, half: f32, material: Material) {
    let positions = [[-1.0, 1.0], [1.0, 1.0], [1.0, -1.0], [-1.0, -1.0]].map(|[x, z]| Vec3::new(x, 0.0, z) * half);
    let (mesh, material_index) = (description.meshes.len(), description.materials.len());
    let triangles = vec![[0, 1, 2], [0, 2, 3]];
    let primitive =
        Primitive { positions: positions.to_vec(), triangles, material: material_index, ..Primitive::default() };
    description.materials.push(material);
    description.meshes.push(Mesh { name: format!("square {mesh}"), primitives: vec![primitive] });
    let transform = DAffine3::from_translation(centre);
    description.instances.push(Instance { name: format!("square {mesh}"), mesh, transform });
}
