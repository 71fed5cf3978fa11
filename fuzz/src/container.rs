//! A glTF file taken apart into JSON and binary chunk, and put together again with lengths that are right.

use serde_json::Value;

/// JSON with the binary chunk beside it, or none in a `.gltf`.
pub struct Container {
    pub json: Value,
    pub binary: Option<Vec<u8>>,
}

impl Container {
    /// `None` if `bytes` are no JSON and no binary glTF with JSON first.
    pub fn parse(bytes: &[u8]) -> Option<Container> {
        if !bytes.starts_with(b"glTF") {
            return Some(Container { json: serde_json::from_slice(bytes).ok()?, binary: None });
        }
        let length = u32::from_le_bytes(bytes.get(12..16)?.try_into().ok()?) as usize;
        let (json, rest) = bytes.get(20..)?.split_at_checked(length)?;
        let binary = rest.get(8..).unwrap_or_default().to_vec();
        Some(Container { json: serde_json::from_slice(json).ok()?, binary: Some(binary) })
    }

    /// The file again.
    pub fn write(&self) -> Vec<u8> {
        let mut json = self.json.to_string().into_bytes();
        let Some(binary) = &self.binary else { return json };
        json.resize(json.len().next_multiple_of(4), b' ');
        let mut binary = binary.clone();
        binary.resize(binary.len().next_multiple_of(4), 0);
        let word = |n: usize| (n as u32).to_le_bytes();
        let total = 12 + 8 + json.len() + 8 + binary.len();
        let header = [&b"glTF"[..], &word(2), &word(total), &word(json.len()), b"JSON"].concat();
        [&header[..], &json, &word(binary.len()), b"BIN\0", &binary].concat()
    }
}
