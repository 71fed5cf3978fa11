//! glTF 2.0 into a [`Description`], from `.gltf` and `.glb` files, with data URIs and files beside them [glTF20].
//!
//! The `gltf` crate parses and validates the JSON. What it would narrow to `f32` (node transforms, cameras) is read from
//! the JSON again in `f64`, and binary data goes through our own checked reader: a file may say anything, and at worst
//! gets one error. What the file has and étendue does not is said in [`Description::ignored`].
//!
//! Lights keep their numbers: glTF's candela (point, spot) become W/sr and its lux (directional) W/m², one to one and
//! per lane, as users of other path tracers expect.
//!
//! Animations of nodes are played to a time and stop there. Limits: meshes as modelled, without skinning or morphing; two
//! texture coordinate sets; no mipmaps.

mod accessor;
mod animation;
mod budget;
mod buffer;
mod camera;
mod document;
mod extras;
mod glb;
mod graph;
mod image;
mod instancing;
mod lamps;
mod light;
mod material;
mod notes;
mod primitive;
mod resource;
mod texture;
mod topology;
mod vertex;

use crate::error::{Error, Result};
use crate::scene::description::{Description, Instance, Mesh, PunctualLight};
use animation::Pose;
use document::{Document, name_or};
use graph::Placement;
use notes::Notes;
use std::collections::HashMap;
use std::path::Path;

/// Reads the scene in `path`: the default scene, else the first one, else all root nodes. Only what it uses is loaded.
/// It is as it stands, whatever animations the file has.
///
/// # Errors
/// A scene error, in one sentence that begins with the path, if the file or one that it refers to cannot be read, is not
/// valid, or requires an extension that is not supported.
pub fn load(path: &Path) -> Result<Description> {
    load_at(path, None)
}

/// Reads the scene in `path` as [`load`] does, as it is at that time in seconds of its animations if one is given.
///
/// # Errors
/// As [`load`], and with a time if an animation is not valid.
pub fn load_at(path: &Path, seconds: Option<f64>) -> Result<Description> {
    load_with(path, &Reading { seconds, ..Reading::default() })
}

/// How a file is read.
#[derive(Debug, Clone, Copy)]
pub struct Reading<'a> {
    /// The time of its animations in seconds; as it stands without one.
    pub seconds: Option<f64>,
    /// The only animation that is played, by name or number from 0; all together without one.
    pub animation: Option<&'a str>,
    /// Bytes that decoded images may take, and as many that lamps may.
    pub memory: u64,
}

impl Default for Reading<'_> {
    /// As it stands, with 4 GiB.
    fn default() -> Self {
        Reading { seconds: None, animation: None, memory: 1 << 32 }
    }
}

/// Reads the scene in `path` as [`load`] does, in that way.
///
/// # Errors
/// As [`load_at`]; a usage error that names all animations if there is no such one; an error of class memory that says what is
/// large if images or lamps would take too much.
pub fn load_with(path: &Path, reading: &Reading) -> Result<Description> {
    let bytes = resource::read_file(path, u64::MAX)?;
    parse_with(&bytes, path.parent().unwrap_or(Path::new("")), reading).map_err(|e| e.context(path.display()))
}

/// Reads the scene in the contents of a `.gltf` or `.glb` file, whose relative URIs start from `base`, as [`load`] does.
///
/// # Errors
/// As [`load`], without the path.
pub fn parse(file: &[u8], base: &Path) -> Result<Description> {
    parse_at(file, base, None)
}

/// Reads the scene in the contents of a file as [`parse`] does, at a time as [`load_at`] does.
///
/// # Errors
/// As [`load_at`], without the path.
pub fn parse_at(file: &[u8], base: &Path, seconds: Option<f64>) -> Result<Description> {
    parse_with(file, base, &Reading { seconds, ..Reading::default() })
}

/// Reads the scene in the contents of a file as [`parse`] does, in the way of [`load_with`].
///
/// # Errors
/// As [`load_with`], without the path.
pub fn parse_with(file: &[u8], base: &Path, reading: &Reading) -> Result<Description> {
    Document::parse(file, base, reading.memory).and_then(|document| describe(&document, reading))
}

fn describe(document: &Document, reading: &Reading) -> Result<Description> {
    let mut loader = Loader { document, notes: Notes::default(), meshes: HashMap::new(), materials: Materials::default() };
    loader.notes.about_file(document);
    let animations = animation::names(document);
    let pose = pose(document, reading, &mut loader.notes)?;
    let mut out = Description { animation_end: pose.end, animations, ..Description::default() };
    for placement in graph::placements(document, &pose)? {
        loader.place(&placement, &mut out)?;
    }
    let (materials, images) = material::load(document, &loader.materials.order, &mut loader.notes)?;
    lamps::afford(&out, &materials, reading.memory)?;
    Ok(Description { materials, images, ignored: loader.notes.into_sentences(), ..out })
}

/// Where nodes are at that time; where they stand in the file without one.
fn pose(document: &Document, reading: &Reading, notes: &mut Notes) -> Result<Pose> {
    match reading.seconds {
        Some(seconds) => animation::pose(document, seconds, reading.animation, notes),
        None => {
            notes.about_rest(document);
            Ok(Pose::default())
        }
    }
}

/// What a part of a mesh at a place takes in a scene: an object and an instance in the ray-tracing structure.
const BYTES_A_PART: usize = 128;
/// Materials in the order in which they are first used; `None` is glTF's default material.
#[derive(Default)]
struct Materials {
    order: Vec<Option<usize>>,
    places: HashMap<Option<usize>, usize>,
}

impl Materials {
    fn place(&mut self, material: Option<usize>) -> usize {
        *self.places.entry(material).or_insert_with(|| {
            self.order.push(material);
            self.order.len() - 1
        })
    }
}

struct Loader<'a> {
    document: &'a Document,
    notes: Notes,
    /// Where each mesh of the file stands in the description; `None` if nothing of it can be shown.
    meshes: HashMap<usize, Option<usize>>,
    materials: Materials,
}

impl Loader<'_> {
    fn place(&mut self, placement: &Placement, out: &mut Description) -> Result<()> {
        let node = &self.document.root.nodes[placement.node];
        let punctual = node.extensions.as_ref().and_then(|e| e.khr_lights_punctual.as_ref());
        out.has_punctual_lights |= punctual.is_some();
        out.has_emission |= node.mesh.is_some_and(|mesh| self.emits(mesh.value()));
        if let Some(index) = node.camera {
            out.cameras.extend(camera::load(self.document, index.value(), placement.stand, &mut self.notes));
        }
        if placement.hidden {
            out.hides |= node.mesh.is_some();
            let name = name_or(&node.name, "node", placement.node);
            self.notes.add(format!("node '{name}' is scaled to zero: its mesh and its light are left out"));
            return Ok(());
        }
        if let Some(mesh) = node.mesh {
            if let Some(mesh) = self.mesh(mesh.value(), out)? {
                let name = name_or(&node.name, "node", placement.node);
                self.copies(placement, &name, mesh, out).map_err(|e| e.context(format!("node '{name}'")))?;
            }
        }
        if let Some(punctual) = punctual {
            let light = light::load(self.document, punctual.light, placement.stand, &mut self.notes)?;
            // Many nodes may stand for one light of the file.
            let name = node.name.as_ref().map(|_| name_or(&node.name, "node", placement.node));
            out.lights.extend(light.map(|light| PunctualLight { name: name.unwrap_or(light.name), ..light }));
        }
        Ok(())
    }

    /// Whether a material of a mesh is made to emit, however weakly.
    fn emits(&self, mesh: usize) -> bool {
        let materials = self.document.root.meshes[mesh].primitives.iter().filter_map(|p| p.material);
        materials.map(|m| &self.document.root.materials[m.value()]).any(|m| {
            let unlit = m.extensions.as_ref().is_some_and(|e| e.unlit.is_some());
            !unlit && m.emissive_factor.0.iter().any(|&c| c > 0.0)
        })
    }

    /// Adds the instances of `mesh` that the node at `placement` stands for.
    fn copies(&mut self, placement: &Placement, name: &str, mesh: usize, out: &mut Description) -> Result<()> {
        let cost = size_of::<Instance>() + name.len() + BYTES_A_PART * out.meshes[mesh].primitives.len();
        for place in instancing::places(self.document, placement.node)? {
            let transform = placement.transform * place;
            if !transform.is_finite() {
                return Err(Error::scene(format!("{} has a transform that is not finite", instancing::NAME)));
            }
            if graph::is_line(&transform.matrix3) {
                self.notes.add(format!("copies of node '{name}' are scaled to a line or a point and are left out"));
                out.hides = true;
                continue;
            }
            self.document.budget.spend(1, cost)?;
            out.instances.push(Instance { name: name.to_owned(), mesh, transform });
        }
        Ok(())
    }

    fn mesh(&mut self, index: usize, out: &mut Description) -> Result<Option<usize>> {
        if let Some(&known) = self.meshes.get(&index) {
            return Ok(known);
        }
        let mesh = self.load_mesh(index)?;
        let place = (!mesh.primitives.is_empty()).then(|| {
            out.meshes.push(mesh);
            out.meshes.len() - 1
        });
        self.meshes.insert(index, place);
        Ok(place)
    }

    fn load_mesh(&mut self, index: usize) -> Result<Mesh> {
        let mesh = &self.document.root.meshes[index];
        let name = name_or(&mesh.name, "mesh", index);
        let mut primitives = Vec::new();
        for primitive in &mesh.primitives {
            let loaded = primitive::load(self.document, primitive, &name, &mut self.notes)
                .map_err(|e| e.context(format!("mesh '{name}'")))?;
            if let Some(mut loaded) = loaded {
                loaded.material = self.materials.place(primitive.material.map(|m| m.value()));
                primitives.push(loaded);
            }
        }
        Ok(Mesh { name, primitives })
    }
}
