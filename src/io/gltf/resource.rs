//! Reads data URIs and files beside the scene. There is no network access.

use crate::error::{Error, Result};
use crate::io::reading::read_file;
use std::path::{Path, PathBuf};

/// Resolves `uri`: its embedded data, or at most `limit` bytes of a file relative to the directory `base`.
///
/// # Errors
/// A scene error if the URI is malformed, has a scheme other than `data:`, is absolute, or its file cannot be read.
pub(super) fn read_uri(base: &Path, uri: &str, limit: u64) -> Result<Vec<u8>> {
    match scheme(uri) {
        Some(data) if data.eq_ignore_ascii_case("data") => read_data(uri),
        Some(other) => {
            Err(Error::scene(format!("the URI scheme '{other}:' is not supported; refer to files by relative paths")))
        }
        None => read_file(&base.join(relative_path(uri)?), limit),
    }
}

/// Returns the canonical path of a relative URI; `None` for data URIs and missing files.
pub(super) fn file_of(base: &Path, uri: &str) -> Option<PathBuf> {
    if scheme(uri).is_some() {
        return None;
    }
    std::fs::canonicalize(base.join(relative_path(uri).ok()?)).ok()
}

fn read_data(uri: &str) -> Result<Vec<u8>> {
    let plain = uri.split_once(',').filter(|(head, _)| !head.ends_with(";base64"));
    if let Some((_, contents)) = plain {
        return percent_decoded(contents).ok_or_else(|| Error::scene("a data URI is not valid"));
    }
    // The crate's own reader contains the base64 decoder.
    let data = ::gltf::buffer::Data::from_source(::gltf::buffer::Source::Uri(uri), None);
    data.map(|data| data.0).map_err(|e| Error::scene("a data URI is not valid base64").because(e))
}

/// Returns the scheme of an absolute URI (RFC 3986 §3.1).
fn scheme(uri: &str) -> Option<&str> {
    let (scheme, _) = uri.split_once(':')?;
    let well_formed = scheme.starts_with(|c: char| c.is_ascii_alphabetic())
        && scheme.chars().all(|c| c.is_ascii_alphanumeric() || "+-.".contains(c));
    well_formed.then_some(scheme)
}

fn relative_path(uri: &str) -> Result<String> {
    let path = percent_decoded(uri)
        .and_then(|bytes| String::from_utf8(bytes).ok())
        .ok_or_else(|| Error::scene(format!("the URI '{uri}' is not valid")))?;
    if path.is_empty() || Path::new(&path).has_root() {
        return Err(Error::scene(format!("the URI '{uri}' is not a relative path")));
    }
    Ok(path)
}

fn percent_decoded(uri: &str) -> Option<Vec<u8>> {
    let mut parts = uri.split('%');
    let mut bytes = parts.next()?.as_bytes().to_vec();
    for part in parts {
        let (code, rest) = part.split_at_checked(2)?;
        bytes.push(u8::from_str_radix(code, 16).ok().filter(|_| !code.starts_with('+'))?);
        bytes.extend_from_slice(rest.as_bytes());
    }
    Some(bytes)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn percent_decoding_follows_rfc_3986() {
        assert_eq!(percent_decoded("a%20b%C3%A9%ff"), Some(b"a b\xc3\xa9\xff".to_vec()));
        assert_eq!(percent_decoded("plain.bin").as_deref(), Some(&b"plain.bin"[..]));
        for bad in ["%", "%2", "%zz", "%+1", "%é"] {
            assert_eq!(percent_decoded(bad), None, "{bad}");
        }
        assert_eq!(read_data("data:application/octet-stream,%00a").ok(), Some(b"\0a".to_vec()));
        assert_eq!(relative_path("a%20b%C3%A9").ok().as_deref(), Some("a bé"));
        assert!(relative_path("%ff").is_err());
    }

    #[test]
    fn only_relative_files_and_data_are_read() {
        let refused = |uri| read_uri(Path::new("."), uri, 0).expect_err("refused").chain();
        assert!(refused("https://example.org/a.bin").contains("scheme 'https:'"));
        assert!(refused("file:///a.bin").contains("scheme 'file:'"));
        assert!(refused("/a.bin").contains("not a relative path"));
        assert!(refused("").contains("not a relative path"));
        assert!(refused("src").contains("not a regular file"));
        assert!(refused("data:;base64,@").contains("base64"));
        assert!(refused("nowhere/a%20b.bin").contains("nowhere/a b.bin"));
    }
}
