//! The parsed, validated JSON of a file, with its buffers.

use super::budget::Budget;
use super::buffer::{self, Buffer};
use super::{extensions, glb};
use crate::error::{Error, Result};
use ::gltf::json::validation::{Error as Defect, Validate};
use ::gltf::json::{self, Root};
use json::mesh::Semantic;
use json::validation::Checked;
use serde::Deserialize;
use serde_json::Value;
use std::path::{Path, PathBuf};

/// A glTF file. All indices between parts of `root` are in range, and no checked value is invalid.
pub(super) struct Document {
    pub(super) root: Root,
    /// The same JSON, with f64 numbers where `root` has f32.
    pub(super) raw: Value,
    /// Contents of each buffer; `None` for one without a URI or a binary chunk.
    buffers: Vec<Option<Buffer>>,
    /// Bytes of the file and of its buffers, with shared ones counted once.
    pub(super) size: usize,
    /// Remaining budget for expanded data.
    pub(super) budget: Budget,
    /// Memory limit of decoded images, in bytes.
    pub(super) memory: u64,
    /// Irregularities of the container, one sentence each.
    pub(super) oddities: Vec<String>,
    /// Base directory of relative URIs.
    pub(super) base: PathBuf,
    /// The file's animations as unchecked JSON, separated from `raw`; null if there are none.
    pub(super) animations: Value,
}

impl Document {
    /// Parses the contents of a `.gltf` or `.glb` file and reads its buffers.
    ///
    /// # Errors
    /// A scene error if any part is malformed, unsupported or missing.
    pub(super) fn parse(file: &[u8], base: &Path, memory: u64) -> Result<Self> {
        let (text, binary) = if file.starts_with(glb::MAGIC) { glb::split(file)? } else { (file, None) };
        let (text, mut oddities) = plain(text)?;
        let mut raw: Value =
            serde_json::from_slice(text).map_err(|e| Error::scene("the JSON is not valid").because(e))?;
        check_version(&raw["asset"])?;
        check_required(&raw["extensionsRequired"])?;
        allow_empty_scenes(&mut raw);
        write_integers_as_such(&mut raw);
        let animations = set_animations_aside(&mut raw);
        let mut root =
            Root::deserialize(&raw).map_err(|e| Error::scene("the glTF is not valid").because(located(e, text)))?;
        forget_skins(&mut root);
        oddities.extend(validate(&root)?);
        let buffers = buffer::read_all(&root, base, binary)?;
        let size = file.len() + buffer::size(&buffers);
        let (budget, base) = (Budget::of(size), base.to_path_buf());
        Ok(Document { root, raw, buffers, size, budget, memory, oddities, base, animations })
    }

    /// Returns the bytes of a buffer view.
    ///
    /// # Errors
    /// A scene error if it exceeds its buffer, or the buffer has no data.
    pub(super) fn view(&self, index: usize) -> Result<&[u8]> {
        let view = self
            .root
            .buffer_views
            .get(index)
            .ok_or_else(|| Error::scene(format!("there is no buffer view {index}")))?;
        let buffer = view.buffer.value();
        let Some(bytes) = self.buffers.get(buffer).and_then(Option::as_ref).map(Buffer::bytes) else {
            return Err(Error::scene(format!("buffer view {index}: buffer {buffer} has no data")));
        };
        let offset = view.byte_offset.unwrap_or_default().0;
        let range = usize::try_from(offset).ok().zip(usize::try_from(offset.saturating_add(view.byte_length.0)).ok());
        range.and_then(|(begin, end)| bytes.get(begin..end)).ok_or_else(|| {
            let (length, have) = (view.byte_length.0, bytes.len());
            Error::scene(format!(
                "buffer view {index}: {length} bytes at {offset} do not fit into buffer {buffer} ({have} bytes)"
            ))
        })
    }
}

/// Returns the name, or one generated from the kind and the index. Names appear in messages: long ones are truncated,
/// and control characters become spaces.
pub(super) fn name_or(name: &Option<String>, what: &str, index: usize) -> String {
    match name {
        Some(name) if !name.is_empty() => {
            name.chars().take(LONGEST_NAME).map(|c| if c.is_control() { ' ' } else { c }).collect()
        }
        _ => format!("{what} {index}"),
    }
}

/// Maximum length of a name in characters.
const LONGEST_NAME: usize = 256;

/// Reads `N` f64 numbers from a JSON array.
pub(super) fn numbers<const N: usize>(value: &Value) -> Option<[f64; N]> {
    let numbers: Option<Vec<f64>> = value.as_array()?.iter().map(Value::as_f64).collect();
    numbers?.try_into().ok()
}

/// Strips what the specification forbids around the JSON but writers still emit. Returns notes about it.
fn plain(mut text: &[u8]) -> Result<(&[u8], Vec<String>)> {
    let mut oddities = Vec::new();
    if matches!(text, [0xff, 0xfe, ..] | [0xfe, 0xff, ..]) {
        return Err(Error::scene("the JSON is UTF-16, and glTF is UTF-8"));
    }
    if let Some(rest) = text.strip_prefix(b"\xef\xbb\xbf") {
        text = rest;
        oddities.push("the JSON begins with a byte order mark, which glTF forbids, and is read without it".into());
    }
    let length = text.iter().rposition(|&byte| byte != 0).map_or(0, |last| last + 1);
    if length < text.len() {
        text = &text[..length];
        oddities.push("the JSON is padded with zeros where glTF wants spaces, and is read without them".into());
    }
    Ok((text, oddities))
}

fn check_version(asset: &Value) -> Result<()> {
    let version = asset["version"].as_str().unwrap_or("missing");
    let minimum = asset["minVersion"].as_str().unwrap_or("2.0");
    if version.starts_with("2.") && minimum == "2.0" {
        return Ok(());
    }
    Err(Error::scene(format!(
        "glTF version is {version} (at least {minimum} required to read it) where 2.0 is supported"
    )))
}

fn check_required(extensions: &Value) -> Result<()> {
    let names = extensions.as_array().into_iter().flatten().filter_map(Value::as_str);
    let unknown: Vec<&str> = names.filter(|name| !extensions::READ.contains(name)).collect();
    if unknown.is_empty() {
        return Ok(());
    }
    Err(Error::scene(format!("the file requires what is not supported: {}", unknown.join(", "))))
}

/// The specification allows scenes without `nodes`, but the crate requires the list.
fn allow_empty_scenes(raw: &mut Value) {
    for scene in raw.get_mut("scenes").and_then(Value::as_array_mut).into_iter().flatten() {
        if let Some(scene) = scene.as_object_mut() {
            scene.entry("nodes").or_insert_with(|| Value::Array(Vec::new()));
        }
    }
}

/// Removes the animations, so that errors in them do not prevent the scene from loading.
fn set_animations_aside(raw: &mut Value) -> Value {
    raw.as_object_mut().and_then(|root| root.remove("animations")).unwrap_or_default()
}

/// Removes the skins for the same reason.
fn forget_skins(root: &mut Root) {
    root.skins.clear();
    root.nodes.iter_mut().for_each(|node| node.skin = None);
}

/// In JSON 1 and 1.0 are the same number, but the crate requires indices without a decimal point. The parser bounds the
/// recursion depth.
fn write_integers_as_such(value: &mut Value) {
    match value {
        Value::Array(elements) => elements.iter_mut().for_each(write_integers_as_such),
        Value::Object(members) => members.values_mut().for_each(write_integers_as_such),
        Value::Number(number) => {
            let exact = number.as_f64().filter(|x| x.is_sign_positive() && x.fract() == 0.0 && *x <= LARGEST_INTEGER);
            if let Some(integer) = exact.filter(|_| number.is_f64()) {
                *value = Value::from(integer as u64);
            }
        }
        Value::Null | Value::Bool(_) | Value::String(_) => {}
    }
}

/// Upper end of the range in which f64 represents every integer.
const LARGEST_INTEGER: f64 = (1u64 << f64::MANTISSA_DIGITS) as f64;

/// Returns the same error with line and column, if parsing the original text gives it too.
fn located(defect: serde_json::Error, text: &[u8]) -> serde_json::Error {
    let same = |again: &serde_json::Error| again.to_string().starts_with(&defect.to_string());
    Root::from_slice(text).err().filter(same).unwrap_or(defect)
}

/// Rejects ambiguous values. Returns notes about invalid values that are replaced by defaults.
fn validate(root: &Root) -> Result<Vec<String>> {
    // The crate's validation uses these indices before it checks them.
    let positions = Checked::Valid(Semantic::Positions);
    let used = root.meshes.iter().flat_map(|m| &m.primitives).filter_map(|p| p.attributes.get(&positions));
    if let Some(missing) = used.map(|a| a.value()).find(|&a| a >= root.accessors.len()) {
        return Err(Error::scene(format!("a mesh's positions refer to accessor {missing}, which does not exist")));
    }
    let (mut first, mut more, mut defaults) = (None, 0, Vec::new());
    root.validate(root, json::Path::new, &mut |path, defect| {
        let path = path();
        match (&first, tolerated(path.as_str(), defect)) {
            (_, true) if defect == Defect::Invalid && has_default(path.as_str()) => {
                defaults.push(format!("{} has an invalid value, and the default is taken", path.as_str()));
            }
            (_, true) => {}
            (None, false) => first = Some((path, defect)),
            (Some(_), false) => more += 1,
        }
    });
    let Some((path, defect)) = first else { return Ok(defaults) };
    let others = if more > 0 { format!(" (and {more} more defects)") } else { String::new() };
    Err(Error::scene(format!("{} {}{others}", path.as_str(), sentence_end(defect))))
}

/// Defects that are harmless here, or are checked more precisely elsewhere.
fn tolerated(path: &str, defect: Defect) -> bool {
    let positions = path.contains(".attributes[\"POSITION\"]");
    match defect {
        Defect::Unsupported => path.starts_with("extensionsRequired"),
        // An accessor without data is all zeros. A texture may have its image in an unsupported extension.
        Defect::Missing => {
            positions
                || path.ends_with("].bufferView")
                || path.ends_with("].source")
                || path.starts_with("cameras[")
                || path.ends_with(".spot")
        }
        Defect::Invalid => positions && (path.ends_with(".min") || path.ends_with(".max")) || is_forgiven(path),
        Defect::IndexOutOfBounds => path.contains(".khr_lights_punctual") || path.contains(".KHR_lights_punctual"),
        Defect::Oversize => false,
    }
}

/// Whether an invalid value has a default, or belongs to a part that can be left out: see docs/forgiven.md.
fn is_forgiven(path: &str) -> bool {
    let left_out =
        path.starts_with("cameras[") || path.contains("khrLightsPunctual") || path.contains("lights_punctual");
    left_out || path.contains(".mode") || has_default(path)
}

/// Whether an invalid value has a default. The type of an image follows from its first bytes.
fn has_default(path: &str) -> bool {
    const WITH_DEFAULTS: [&str; 7] =
        [".alphaMode", ".wrapS", ".wrapT", ".magFilter", ".minFilter", ".target", ".mimeType"];
    WITH_DEFAULTS.iter().any(|end| path.ends_with(end))
}

fn sentence_end(defect: Defect) -> &'static str {
    match defect {
        Defect::IndexOutOfBounds => "refers to something that does not exist",
        Defect::Invalid => "has an invalid value",
        Defect::Missing => "is missing",
        Defect::Oversize => "is too large for this machine",
        Defect::Unsupported => "is not supported",
    }
}
