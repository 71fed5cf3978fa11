//! Loads glTF 2.0 into a [`Description`], from `.gltf` and `.glb` files, with data URIs and files beside them [glTF20].
//!
//! The `gltf` crate parses and validates the JSON. Values that it would narrow to `f32` (node transforms, cameras) are
//! read again from the JSON in `f64`. Binary data goes through our own checked reader. Files are untrusted: a malformed
//! one yields an error. Unsupported features are listed in [`Description::ignored`].
//!
//! Lights keep their numerical values. glTF's candela (point, spot) become W/sr and its lux (directional) W/m², one to
//! one and per lane, as users of other path tracers expect.
//!
//! Node animations are evaluated at one time. Limits: no skinning and no morph targets; two texture coordinate sets; no
//! mipmaps.

mod accessor;
mod animation;
mod budget;
mod buffer;
mod camera;
mod document;
mod extensions;
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
mod quaternion;
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

/// Reads the scene in `path`: the default scene, else the first one, else all root nodes. Only the parts it uses are
/// loaded. Animations are ignored: the scene is at rest.
///
/// # Errors
/// A scene error, in one sentence that begins with the path, if the file or one that it refers to cannot be read, is
/// not valid, or requires an unsupported extension.
pub fn load(path: &Path) -> Result<Description> {
    load_at(path, None)
}

/// Reads the scene in `path` as [`load`] does, at a time in seconds of its animations if given.
///
/// # Errors
/// As [`load`]; with a time also if an animation is not valid.
pub fn load_at(path: &Path, seconds: Option<f64>) -> Result<Description> {
    load_with(path, &Reading { seconds, ..Reading::default() })
}

/// Options for reading a file.
#[derive(Debug, Clone, Copy)]
pub struct Reading<'a> {
    /// Time of the animations in seconds; `None` reads the scene at rest.
    pub seconds: Option<f64>,
    /// The only animation that is played, by name or number from 0; `None` plays all together.
    pub animation: Option<&'a str>,
    /// Memory limit of decoded images in bytes, and separately of the lights of emissive meshes.
    pub memory: u64,
}

impl Default for Reading<'_> {
    /// The scene at rest, with 4 GiB.
    fn default() -> Self {
        Reading { seconds: None, animation: None, memory: 1 << 32 }
    }
}

/// Reads the scene in `path` as [`load`] does, with options.
///
/// # Errors
/// As [`load_at`]. A usage error that lists all animations if there is no such one. An error of class memory that names
/// the largest part if images or lights exceed the memory.
pub fn load_with(path: &Path, reading: &Reading) -> Result<Description> {
    let bytes = resource::read_file(path, u64::MAX)?;
    parse_with(&bytes, path.parent().unwrap_or(Path::new("")), reading).map_err(|e| e.context(path.display()))
}

/// Reads the scene from the contents of a `.gltf` or `.glb` file as [`load`] does. Relative URIs are resolved against
/// `base`.
///
/// # Errors
/// As [`load`], without the path.
pub fn parse(file: &[u8], base: &Path) -> Result<Description> {
    parse_at(file, base, None)
}

/// Reads the scene from the contents of a file as [`parse`] does, at a time as [`load_at`] does.
///
/// # Errors
/// As [`load_at`], without the path.
pub fn parse_at(file: &[u8], base: &Path, seconds: Option<f64>) -> Result<Description> {
    parse_with(file, base, &Reading { seconds, ..Reading::default() })
}

/// Reads the scene from the contents of a file as [`parse`] does, with options as [`load_with`] does.
///
/// # Errors
/// As [`load_with`], without the path.
pub fn parse_with(file: &[u8], base: &Path, reading: &Reading) -> Result<Description> {
    Document::parse(file, base, reading.memory).and_then(|document| describe(&document, reading))
}

fn describe(document: &Document, reading: &Reading) -> Result<Description> {
    let mut loader =
        Loader { document, notes: Notes::default(), meshes: HashMap::new(), materials: Materials::default() };
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

/// Returns the animated node values at the given time; none without a time.
fn pose(document: &Document, reading: &Reading, notes: &mut Notes) -> Result<Pose> {
    match reading.seconds {
        Some(seconds) => animation::pose(document, seconds, reading.animation, notes),
        None => {
            notes.about_rest(document);
            Ok(Pose::default())
        }
    }
}

/// Bytes of one placed mesh primitive: an object and an instance in the acceleration structure.
const BYTES_A_PART: usize = 128;
/// Materials in the order of their first use; `None` is glTF's default material.
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
    /// Index in the description of each mesh of the file; `None` if no part of it can be shown.
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
            // Many nodes may refer to one light of the file.
            let name = node.name.as_ref().map(|_| name_or(&node.name, "node", placement.node));
            out.lights.extend(light.map(|light| PunctualLight { name: name.unwrap_or(light.name), ..light }));
        }
        Ok(())
    }

    /// Whether any material of a mesh emits, however weakly.
    fn emits(&self, mesh: usize) -> bool {
        let materials = self.document.root.meshes[mesh].primitives.iter().filter_map(|p| p.material);
        materials.map(|m| &self.document.root.materials[m.value()]).any(|m| {
            let unlit = m.extensions.as_ref().is_some_and(|e| e.unlit.is_some());
            !unlit && m.emissive_factor.0.iter().any(|&c| c > 0.0)
        })
    }

    /// Adds the instances of `mesh` at the node of `placement`.
    fn copies(&mut self, placement: &Placement, name: &str, mesh: usize, out: &mut Description) -> Result<()> {
        let cost = size_of::<Instance>() + name.len() + BYTES_A_PART * out.meshes[mesh].primitives.len();
        for place in instancing::places(self.document, placement.node)? {
            let transform = placement.transform * place;
            if !transform.is_finite() {
                return Err(Error::scene(format!("{} has a transform that is not finite", extensions::INSTANCING)));
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
