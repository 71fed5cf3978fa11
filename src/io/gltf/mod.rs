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
mod grids;
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

use super::reading::ReadOptions;
use crate::error::{Error, Result};
use crate::scene::description::{Description, Instance, Mesh, PunctualLight};
use animation::Pose;
use document::{Document, name_or};
use graph::Placement;
use grids::Grids;
use notes::Notes;
use std::collections::HashMap;
use std::path::Path;

/// Reads the scene from the contents of a `.gltf` or `.glb` file: the default scene, else the first one, else all root
/// nodes. Only the parts it uses are loaded. Relative URIs are resolved against `base`.
///
/// # Errors
/// A scene error in one sentence if the file or one that it refers to cannot be read, is not valid, or requires an
/// unsupported extension; with a time also if an animation is not valid. A usage error that lists all animations if
/// there is no such one. An error of class memory that names the largest part if images or lights exceed the memory.
pub fn parse(file: &[u8], base: &Path, options: &ReadOptions) -> Result<Description> {
    Document::parse(file, base, options.memory).and_then(|document| describe(&document, options))
}

/// Returns whether `file` looks like the contents of a `.gltf` or `.glb` file.
pub(super) fn is_gltf(file: &[u8]) -> bool {
    let json = file.strip_prefix(b"\xef\xbb\xbf").unwrap_or(file).trim_ascii_start();
    file.starts_with(b"glTF") || json.starts_with(b"{")
}

fn describe(document: &Document, options: &ReadOptions) -> Result<Description> {
    let mut loader =
        Loader { document, notes: Notes::default(), meshes: HashMap::new(), materials: Materials::default() };
    loader.notes.about_file(document);
    let animations = animation::names(document);
    let pose = pose(document, options, &mut loader.notes)?;
    let mut out = Description { animation_end: pose.end, animations, ..Description::default() };
    for placement in graph::placements(document, &pose)? {
        loader.place(&placement, &mut out)?;
    }
    let (mut materials, images) = material::load(document, &loader.materials.order, &mut loader.notes)?;
    let Grids { densities, albedos, emissions } = grids::load(document, &loader.materials.order, &mut materials)?;
    lamps::afford(&out, &materials, options.memory)?;
    Ok(Description { materials, densities, albedos, emissions, images, ignored: loader.notes.into_sentences(), ..out })
}

/// Returns the animated node values at the given time; none without a time.
fn pose(document: &Document, options: &ReadOptions, notes: &mut Notes) -> Result<Pose> {
    match options.seconds {
        Some(seconds) => animation::pose(document, seconds, options.animation, notes),
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
