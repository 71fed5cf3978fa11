//! glTF files made in the test, and the folder of shared ones.

use etendue::error::{Kind, Result};
use etendue::io::scene_file::{self, ReadOptions};
use etendue::scene::description::{Description, Primitive};
use etendue_testing::folders;
use serde_json::{Value, json};
use std::path::PathBuf;

/// The folder of shared assets, if this machine has it.
pub(crate) fn shared(folder: &str) -> Option<PathBuf> {
    let path = folders::shared().join("scenes").join(folder);
    if path.is_dir() {
        return Some(path);
    }
    eprintln!("skipped: {} is not there", path.display());
    None
}

/// A file with one buffer.
pub(crate) struct File {
    pub(crate) json: Value,
    pub(crate) bytes: Vec<u8>,
}

impl File {
    /// A file without anything in it.
    pub(crate) fn empty() -> Self {
        File { json: json!({ "asset": { "version": "2.0" }, "accessors": [], "bufferViews": [] }), bytes: Vec::new() }
    }

    /// A file with one node `n` that holds mesh `m` with one primitive: `positions`, and `more` merged into it.
    pub(crate) fn mesh(positions: &[[f32; 3]], more: impl FnOnce(&mut File) -> Value) -> Self {
        let mut file = File::empty();
        let accessor = file.accessor(5126, "VEC3", positions.len(), bytemuck::cast_slice(positions));
        let mut primitive = json!({ "attributes": { "POSITION": accessor } });
        merge(&mut primitive, more(&mut file));
        merge(
            &mut file.json,
            json!({ "nodes": [{ "name": "n", "mesh": 0 }], "meshes": [{ "name": "m", "primitives": [primitive] }] }),
        );
        file
    }

    /// A file with one triangle, and `more` merged into its JSON.
    pub(crate) fn triangle(more: Value) -> Self {
        let mut file = File::mesh(&TRIANGLE, |_| json!({}));
        merge(&mut file.json, more);
        file
    }

    /// Adds a buffer view; its index.
    pub(crate) fn view(&mut self, bytes: &[u8]) -> usize {
        let view = json!({ "buffer": 0, "byteOffset": self.bytes.len(), "byteLength": bytes.len() });
        self.bytes.extend_from_slice(bytes);
        push(&mut self.json["bufferViews"], view)
    }

    /// Adds an accessor with its own buffer view; its index.
    pub(crate) fn accessor(&mut self, component: u32, shape: &str, count: usize, bytes: &[u8]) -> usize {
        let view = self.view(bytes);
        push(
            &mut self.json["accessors"],
            json!({ "bufferView": view, "componentType": component, "type": shape, "count": count }),
        )
    }

    /// The bytes of a `.glb`.
    pub(crate) fn glb(&self) -> Vec<u8> {
        let mut json = self.json.clone();
        if !self.bytes.is_empty() && json.get("buffers").is_none() {
            json["buffers"] = json!([{ "byteLength": self.bytes.len() }]);
        }
        glb(json.to_string().as_bytes(), Some(&self.bytes))
    }

    /// What the loader says to this file.
    pub(crate) fn load(&self) -> Result<Description> {
        load_bytes("scene.glb", &self.glb())
    }

    /// What the loader says to this file at that time.
    pub(crate) fn load_at(&self, seconds: f64) -> Result<Description> {
        load_bytes_at("scene.glb", &self.glb(), Some(seconds))
    }

    /// The only primitive of this file, if it is valid.
    pub(crate) fn primitive(&self) -> Primitive {
        let mut description = self.load().expect("a valid file");
        assert_eq!((description.meshes.len(), description.meshes[0].primitives.len()), (1, 1));
        description.meshes.remove(0).primitives.remove(0)
    }

    /// The sentence of the error that this file must be, without its path.
    pub(crate) fn error(&self) -> String {
        sentence("scene.glb", self.load())
    }
}

pub(crate) const TRIANGLE: [[f32; 3]; 3] = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]];

/// Adds an element to a JSON array; its index.
pub(crate) fn push(array: &mut Value, element: Value) -> usize {
    let array = array.as_array_mut().expect("an array");
    array.push(element);
    array.len() - 1
}

/// Sets the keys of `more` in `into`, objects within objects too.
pub(crate) fn merge(into: &mut Value, more: Value) {
    match (into, more) {
        (Value::Object(into), Value::Object(more)) => {
            more.into_iter().for_each(|(key, value)| merge(into.entry(key).or_insert(Value::Null), value));
        }
        (into, more) => *into = more,
    }
}

/// The binary container around a JSON and a binary chunk.
pub(crate) fn glb(json: &[u8], binary: Option<&[u8]>) -> Vec<u8> {
    let chunk = |kind: &[u8], bytes: &[u8], fill: u8| {
        let mut padded = bytes.to_vec();
        padded.resize(bytes.len().next_multiple_of(4), fill);
        [&(padded.len() as u32).to_le_bytes()[..], kind, &padded].concat()
    };
    let mut chunks = chunk(b"JSON", json, b' ');
    chunks.extend(binary.map(|b| chunk(b"BIN\0", b, 0)).unwrap_or_default());
    [b"glTF", &2u32.to_le_bytes()[..], &(chunks.len() as u32 + 12).to_le_bytes(), &chunks].concat()
}

/// What the loader says to a file of that name and contents, alone in its folder.
pub(crate) fn load_bytes(name: &str, bytes: &[u8]) -> Result<Description> {
    load_bytes_at(name, bytes, None)
}

/// The same at a time of its animations.
pub(crate) fn load_bytes_at(name: &str, bytes: &[u8], seconds: Option<f64>) -> Result<Description> {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let path = folder.path().join(name);
    std::fs::write(&path, bytes).expect("a written file");
    scene_file::load_with(&path, &ReadOptions { seconds, ..ReadOptions::default() })
}

/// The sentence of an error of class scene, checked to be one line that names the file.
pub(crate) fn sentence(name: &str, result: Result<Description>) -> String {
    let error = result.expect_err("an error");
    assert_eq!(error.kind, Kind::Scene, "{error}");
    let chain = error.chain();
    assert!(chain.contains(name) && !chain.contains('\n'), "{chain}");
    chain.split_once(&format!("{name}: ")).expect("the path first").1.to_owned()
}
