//! Construction of a scene from a description: rebasing, baking, material compilation, acceleration structure.

use super::assemble::assemble;
use super::bodies::AllBodies;
use super::contact::Contacts;
use super::description::{self, ColorGrid, DensityGrid, Description};
use super::extent::Extent;
use super::lights::{area_lights, check_emission, punctual_lights};
use super::material::{Material, settle};
use super::rebase::Rebase;
use super::usage::Usage;
use super::view::Views;
use super::{Features, ObjectInfo, Scene, SceneInfo, coincident, enclosure, surroundings};
use crate::accel::{Accel, Backend, Build};
use crate::bsdf::Lobes;
use crate::error::Result;
use crate::geometry::Geometry;
use crate::light::{BoundingSphere, Environment, Light, LightChoice, Lights};
use crate::medium::{Colors, Grid};
use glam::DAffine3;
use std::sync::Arc;
use std::time::Instant;

/// Options of scene construction.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct BuildOptions {
    /// Intersection backend.
    pub backend: Backend,
    /// Build quality and robustness of the acceleration structure.
    pub build: Build,
    /// Number of threads for its construction; 0 leaves it to the backend.
    pub threads: usize,
    /// How lights are selected.
    pub light_choice: LightChoice,
}

impl Scene {
    /// Builds `description`. Must be called from outside the rayon pool.
    ///
    /// # Errors
    /// A scene error that names the cause: no geometry, a mesh with bad indices or positions, or a light out of range;
    /// or the backend's error.
    pub fn build(mut description: Description, options: &BuildOptions) -> Result<Scene> {
        let start = Instant::now();
        let hash = description::hash::of(&description);
        check_emission(&description.materials)?;
        let within = enclosure::enclose(&mut description)?;
        let extent = Extent::of(&description)?;
        extent.check()?;
        let rebase = Rebase::new(extent.detail, extent.radius());
        let mut warnings = std::mem::take(&mut description.warnings);
        if description.cameras.is_empty() {
            warnings.push("the file has no camera: everything is framed automatically".to_owned());
        }
        if extent.spoilt > 0 {
            warnings.push(format!(
                "about {} triangles are too small for where they are: single precision moves their vertices by more \
                 than a hundredth of their size (detail in two places far apart?)",
                extent.spoilt
            ));
        }
        let compile = |(m, mut usage): (&description::Material, Usage)| {
            let mut m = m.clone();
            settle(&mut m, &mut usage);
            Material::new(m, &usage, &rebase)
        };
        let usages = Usage::of_all(&description);
        let materials: Vec<Material> = description.materials.iter().zip(usages).map(compile).collect();
        let (mut geometry, mut objects) = assemble(&description, &rebase, &materials)?;
        let mut bodies = AllBodies::find(&geometry, &mut objects, &materials);
        let placed = |instance: u32, transform: &DAffine3| {
            rebase.transform(&description.instances[instance as usize].transform) * *transform
        };
        bodies.place_grids(
            |index, instance| {
                let DensityGrid { blocks, transform } = &description.densities[index];
                Grid::new(Arc::clone(blocks), &placed(instance, transform))
            },
            [&description.albedos, &description.emissions].map(|grids| {
                |index: usize, instance| {
                    let ColorGrid { cells, transform } = &grids[index];
                    Colors::new(Arc::clone(cells), &placed(instance, transform))
                }
            }),
        );
        let contacts = contacts(&mut geometry, &objects, &materials, &description.cameras, &rebase, &mut warnings);
        let mut lights = area_lights(&geometry, &mut objects, &materials, contacts.as_deref());
        lights.extend(punctual_lights(&description.lights, &rebase)?);
        warnings.extend(coincident::emitters(&description, &objects, &geometry, &lights));
        let environment = description
            .environment
            .take()
            .or_else(|| surroundings::by_default(&description, &lights, bodies.emit(), &mut warnings));
        let environment = environment.and_then(surroundings::light);
        let environment_bytes = environment.as_ref().map_or(0, Environment::bytes);
        lights.extend(environment.map(Light::Environment));
        let prepare_seconds = start.elapsed().as_secs_f64();
        let accel = Accel::build(&geometry, options.backend, options.build, options.threads)?;
        let centre = rebase.point((extent.min + extent.max) * 0.5).as_vec3();
        let ball = BoundingSphere { centre, radius: (extent.radius() * rebase.scale) as f32 };
        let shining = lights.iter().filter(|light| light.power(ball.radius) > 0.0).count();
        for object in &mut objects {
            let material = &materials[object.material as usize];
            let blends = material.source.alpha_mode == description::AlphaMode::Blend;
            object.passes = blends || material.may_pass(1.0);
            object.plain = material.is_plain() && !object.colors;
        }
        let features =
            Features { contacts: contacts.is_some(), ..features(&geometry, &objects, &materials, &lights, &bodies) };
        let mut info = census(&geometry, &materials, shining, features);
        info.instances = description.instances.len();
        info.texture_bytes += environment_bytes;
        info.animations = description.animations;
        info.ignored = description.ignored;
        info.warnings = warnings;
        (info.centre, info.scale) = (rebase.centre, rebase.scale);
        info.prepare_seconds = prepare_seconds;
        info.accel_seconds = start.elapsed().as_secs_f64() - prepare_seconds;
        info.accel_bytes = accel.bytes();
        let [min, max] = within.unwrap_or([extent.min, extent.max]);
        let views = Views::new(description.cameras, min, max);
        let names = description.instances.into_iter().map(|instance| instance.name).collect();
        let lights = Lights::new(lights, ball.radius, options.light_choice);
        info.light_tree_bytes = lights.tree_bytes();
        info.density_bytes = bodies.density_bytes();
        let mut scene = Scene {
            geometry,
            objects,
            materials,
            bodies,
            lights,
            light_media: Vec::new(),
            accel,
            contacts,
            rebase,
            ball,
            features,
            views,
            names,
            info,
            hash,
        };
        scene.light_media = scene.media_of_lights();
        Ok(scene)
    }
}

/// Finds touching surfaces of which one transmits light. Backend queries may then exclude the objects that they belong
/// to.
fn contacts(
    geometry: &mut Geometry,
    objects: &[ObjectInfo],
    materials: &[Material],
    cameras: &[description::CameraDescription],
    rebase: &Rebase,
    warnings: &mut Vec<String>,
) -> Option<Box<Contacts>> {
    let passes = |o: &ObjectInfo| materials[o.material as usize].lets_light_pass();
    let passes: Vec<bool> = objects.iter().map(passes).collect();
    let eyes: Vec<_> = cameras.iter().map(|camera| rebase.point(camera.transform.translation).as_vec3()).collect();
    let contacts = Contacts::find(geometry, &passes, &eyes).unwrap_or_else(|many| {
        warnings.push(format!(
            "{many} triangles lie at surfaces that let light pass, too many to tell which of them touch"
        ));
        None
    })?;
    for (object, placed) in (0..).zip(&mut geometry.objects) {
        placed.filtered |= contacts.has(object);
    }
    Some(Box::new(contacts))
}

/// Determines the features of the scene.
fn features(
    geometry: &Geometry,
    objects: &[ObjectInfo],
    materials: &[Material],
    lights: &[Light],
    bodies: &AllBodies,
) -> Features {
    let used = |test: &dyn Fn(&Material) -> bool| objects.iter().any(|o| test(&materials[o.material as usize]));
    let holes = |mode: fn(description::AlphaMode) -> bool| used(&|m| mode(m.source.alpha_mode));
    Features {
        masks: holes(|m| matches!(m, description::AlphaMode::Mask { .. })),
        blends: holes(|m| matches!(m, description::AlphaMode::Blend)),
        culled: used(&Material::is_culled),
        media: bodies.attenuate(),
        scattering: bodies.scatter(),
        emission: bodies.emit(),
        panes: used(&|m| m.may_pass(1.0)),
        nested: bodies.overlap(),
        textures: used(&Material::has_surface_textures),
        normal_maps: used(&|m| m.source.normal_texture.is_some()),
        shading_normals: geometry.meshes.iter().any(|m| m.attributes().normals.is_some()),
        dirac: used(&|m| m.lobes().intersects(Lobes::DIRAC)),
        refraction: used(&Material::refracts),
        instances: geometry.objects.iter().any(|o| o.placement.is_some()),
        dirac_lights: lights.iter().any(Light::is_dirac),
        small_lights: lights.iter().any(|light| light.pivot().is_some()),
        contacts: false,
    }
}

/// Returns counts and sizes of the scene.
fn census(geometry: &Geometry, materials: &[Material], lights: usize, features: Features) -> SceneInfo {
    let mut images: Vec<_> = materials.iter().flat_map(Material::images).map(|t| &t.image).collect();
    images.sort_by_key(|image| Arc::as_ptr(image));
    images.dedup_by_key(|image| Arc::as_ptr(image));
    SceneInfo {
        triangles: geometry.meshes.iter().map(|m| m.triangles().len()).sum(),
        placed_triangles: (0..geometry.objects.len()).map(|o| geometry.mesh_of(o as u32).triangles().len()).sum(),
        meshes: geometry.meshes.len(),
        materials: materials.len(),
        lights,
        images: images.len(),
        texture_bytes: images.iter().map(|image| image.bytes()).sum(),
        geometry_bytes: geometry.meshes.iter().map(|m| m.bytes()).sum(),
        features: features.names().into_iter().map(str::to_owned).collect(),
        ..SceneInfo::default()
    }
}
