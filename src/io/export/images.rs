//! Embeds images of separate files. An image that cannot be embedded keeps its uri: it never stops a dent.

use super::vertices::Rewrite;
use crate::base::error::Error;
use crate::io::import::document::Document;
use crate::io::import::uri::{self, UriTarget};
use crate::io::import::words::cut;
use std::path::Path;

/// Turns images in separate files into bufferViews. Images in `data:` URIs are in the file already.
pub(super) fn embed(Rewrite { doc, glb, notes }: &mut Rewrite<'_>) {
    let mut kept = Vec::new();
    for i in 0..glb.root["images"].as_array().map_or(0, Vec::len) {
        let Some(uri) = glb.root["images"][i]["uri"].as_str().map(str::to_owned) else { continue };
        if uri.starts_with("data:") {
            continue;
        }
        match read(doc, i, &uri) {
            Ok((path, bytes, mime)) => {
                let view = glb.push_view(&bytes, None);
                let Some(image) = glb.root["images"][i].as_object_mut() else { continue };
                image.shift_remove("uri");
                image.insert("bufferView".into(), view.into());
                image.entry("mimeType").or_insert(mime.into());
                let stem = Path::new(&path).file_stem().unwrap_or_default().to_string_lossy();
                image.entry("name").or_insert(stem.into());
            }
            Err(why) => kept.push(format!("image {i}, '{}', {why}", cut(&uri))),
        }
    }
    match kept.as_slice() {
        [] => {}
        [one] => notes.push(format!("{one}; its uri is kept")),
        [first, more @ ..] => {
            notes.push(format!("{first}; its uri is kept, and so are those of {} more images", more.len()))
        }
    }
}

/// The path, bytes and media type of an image, or why it is not embedded.
fn read(doc: &Document<'_>, i: usize, uri: &str) -> Result<(String, Vec<u8>, &'static str), String> {
    let what = format!("image {i}");
    let path = match uri::parse(uri, &what) {
        Ok(UriTarget::File(path)) => path,
        _ => return Err("is not in the file's folder or below, and is not embedded".into()),
    };
    let bytes = match doc.read_relative(&path, &what) {
        Ok(bytes) => bytes,
        Err(Error::Io { message, .. }) => return Err(format!("cannot be read ({message})")),
        Err(error) => return Err(format!("cannot be read ({error})")),
    };
    let mime = media_type(&bytes, &path);
    mime.map(|mime| (path, bytes, mime)).ok_or_else(|| "is of a kind that glTF does not embed".into())
}

fn media_type(bytes: &[u8], path: &str) -> Option<&'static str> {
    let extension = Path::new(path).extension().unwrap_or_default().to_string_lossy().to_ascii_lowercase();
    match bytes {
        [0x89, b'P', b'N', b'G', ..] => Some("image/png"),
        [0xFF, 0xD8, 0xFF, ..] => Some("image/jpeg"),
        [b'R', b'I', b'F', b'F', _, _, _, _, b'W', b'E', b'B', b'P', ..] => Some("image/webp"),
        [0xAB, b'K', b'T', b'X', b' ', b'2', b'0', ..] => Some("image/ktx2"),
        [b'D', b'D', b'S', b' ', ..] => Some("image/vnd-ms.dds"),
        [_, _, _, _, b'f', b't', b'y', b'p', ..] if extension == "avif" => Some("image/avif"),
        _ => None,
    }
}
