//! Formats of scene files.

use crate::support::{File, load_bytes, sentence};
use serde_json::json;

#[test]
fn formats_are_known_by_contents_or_extension() {
    let binary = File::triangle(json!({})).glb();
    for name in ["scene.glb", "scene.GLTF", "scene", "scene.obj"] {
        assert!(load_bytes(name, &binary).is_ok(), "{name}");
    }
    let unknown = |name: &str, bytes: &[u8]| sentence(name, load_bytes(name, bytes));
    let refused = "this is not a scene that étendue reads, which are .gltf and .glb files";
    assert_eq!(unknown("scene.obj", b"v 0 0 0"), refused);
    assert_eq!(unknown("scene", b""), refused);
    // A file that claims to be glTF gets the parser's sentence.
    assert!(unknown("scene.gltf", b"v 0 0 0").contains("JSON"));
    assert!(unknown("scene.obj", b"\xef\xbb\xbf {").contains("JSON"));
}
