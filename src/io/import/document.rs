//! The container of a glTF: GLB chunks, parsed JSON, and buffers that are loaded on first use.

use super::uri::{self, UriTarget};
use super::{malformed, unsupported};
use crate::base::error::Error;
use ::gltf::json::{self, Index};
use serde_json::Value;
use std::borrow::Cow;
use std::cell::{Cell, OnceCell};
use std::path::Path;

/// Required extensions (by name or by prefix ending in `_`) that do not change the geometry. `KHR_mesh_quantization` is
/// among them, since each accessor's type is checked when it is read.
const HARMLESS: &[&str] = &[
    "KHR_materials_",
    "EXT_materials_",
    "KHR_texture_",
    "EXT_texture_",
    "MSFT_texture_dds",
    "KHR_lights_punctual",
    "EXT_lights_",
    "KHR_animation_pointer",
    "KHR_node_visibility",
    "KHR_xmp",
    "KHR_xmp_json_ld",
    "EXT_mesh_gpu_instancing",
    "KHR_mesh_quantization",
];

/// Decoded bytes allowed per byte of the file. Shared accessors can make decoded data larger than the file; this limits
/// the factor.
const EXPANSION: u64 = 64;

/// A parsed glTF whose buffers are loaded on first use.
pub(crate) struct Document<'a> {
    /// The typed JSON of accessors, views, buffers, meshes and nodes. The rest stays empty, so that a file with a
    /// broken material can still be read. Types are right; values are checked where they are used.
    pub root: json::Root,
    /// The same JSON as plain values: extras, extensions and everything unknown.
    pub value: Value,
    bin: Option<&'a [u8]>,
    base_dir: Option<&'a Path>,
    buffers: Vec<OnceCell<Cow<'a, [u8]>>>,
    pub budget: Budget,
}

/// Limits the memory that a file may ask for.
pub(crate) struct Budget {
    loaded: Cell<u64>,
    decoded: Cell<u64>,
}

impl Budget {
    /// Counts memory that the file asks for, before it is allocated.
    pub fn charge(&self, elements: usize, bytes_each: usize, what: &str) -> Result<(), Error> {
        let bytes = (elements as u64).saturating_mul(bytes_each as u64);
        let decoded = self.decoded.get().saturating_add(bytes);
        let limit = self.loaded.get().saturating_mul(EXPANSION).saturating_add(1 << 20);
        if decoded > limit {
            return Err(malformed(format!(
                "{what} asks for {bytes} bytes, {decoded} in all; a file of {} bytes may ask for {limit}",
                self.loaded.get()
            )));
        }
        self.decoded.set(decoded);
        Ok(())
    }
}

impl<'a> Document<'a> {
    pub fn parse(bytes: &'a [u8], base_dir: Option<&'a Path>) -> Result<Self, Error> {
        let (text, bin) = split(bytes)?;
        let not_json = |e: serde_json::Error| malformed(format!("the glTF's JSON: {e}"));
        let value: Value = serde_json::from_slice(text).map_err(not_json)?;
        check_version(&value)?;
        check_extensions(&value)?;
        let root = json::Root {
            accessors: list(&value, "accessors")?,
            buffers: list(&value, "buffers")?,
            buffer_views: list(&value, "bufferViews")?,
            meshes: list(&value, "meshes")?,
            nodes: list(&value, "nodes")?,
            ..Default::default()
        };
        let buffers = root.buffers.iter().map(|_| OnceCell::new()).collect();
        let budget = Budget { loaded: Cell::new(bytes.len() as u64), decoded: Cell::new(0) };
        Ok(Self { root, value, bin, base_dir, buffers, budget })
    }

    /// The bytes of a buffer, exactly as many as the file states.
    pub fn buffer(&self, index: usize) -> Result<&[u8], Error> {
        let cell = self.buffers.get(index).ok_or_else(|| out_of_range("buffer", index, self.buffers.len()))?;
        if let Some(bytes) = cell.get() {
            return Ok(bytes);
        }
        let bytes = self.load(index)?;
        Ok(cell.get_or_init(|| bytes))
    }

    fn load(&self, index: usize) -> Result<Cow<'a, [u8]>, Error> {
        let buffer = &self.root.buffers[index];
        let what = format!("buffer {index}");
        let length = buffer.byte_length.0;
        let external = |bytes: Vec<u8>| {
            let loaded = &self.budget.loaded;
            loaded.set(loaded.get().saturating_add(bytes.len() as u64));
            Cow::Owned(bytes)
        };
        let bytes: Cow<'a, [u8]> = match (&buffer.uri, self.bin) {
            (Some(uri), _) => match uri::parse(uri, &what)? {
                UriTarget::Data(bytes) => Cow::Owned(bytes),
                UriTarget::File(path) => external(uri::read_file(self.base_dir, &path, &what, Some(length))?),
            },
            (None, Some(bin)) if index == 0 => Cow::Borrowed(bin),
            (None, _) => return Err(self.no_data(index)),
        };
        let wanted = usize::try_from(length)
            .ok()
            .filter(|n| *n <= bytes.len())
            .ok_or_else(|| malformed(format!("{what} says it has {length} bytes; there are {}", bytes.len())))?;
        Ok(match bytes {
            Cow::Borrowed(b) => Cow::Borrowed(&b[..wanted]),
            Cow::Owned(mut b) => {
                b.truncate(wanted);
                Cow::Owned(b)
            }
        })
    }

    fn no_data(&self, index: usize) -> Error {
        let extension = self.value["buffers"][index]["extensions"].as_object().and_then(|o| o.keys().next());
        match extension {
            Some(name) => unsupported(format!("buffer {index} has its data in {name}; plain buffers are read")),
            None if index == 0 => malformed("buffer 0 has neither a uri nor a binary chunk behind the JSON"),
            None => malformed(format!("buffer {index} has no uri; only buffer 0 may be the binary chunk")),
        }
    }

    /// The bytes of a bufferView, and its stride if it has one.
    pub fn view(&self, index: Index<json::buffer::View>, user: &str) -> Result<(&[u8], Option<usize>), Error> {
        let views = &self.root.buffer_views;
        let index = index.value();
        let view = views.get(index).ok_or_else(|| out_of_range(&format!("{user}: bufferView"), index, views.len()))?;
        let buffer = self.buffer(view.buffer.value())?;
        let (offset, length) = (view.byte_offset.map_or(0, |o| o.0), view.byte_length.0);
        let range = range(offset, Some(length), buffer.len()).ok_or_else(|| {
            malformed(format!(
                "{user}: bufferView {index} is {length} bytes from byte {offset}; buffer {} has {}",
                view.buffer.value(),
                buffer.len()
            ))
        })?;
        Ok((&buffer[range], view.byte_stride.map(|s| s.0)))
    }

    /// Reads a file that an image refers to.
    pub fn read_relative(&self, path: &str, what: &str) -> Result<Vec<u8>, Error> {
        uri::read_file(self.base_dir, path, what, None)
    }

    /// The mesh's name in errors, such as `mesh 2 'Door'`. A long one is cut: each primitive repeats it, so that a file could
    /// ask for the square of its size.
    pub fn mesh_label(&self, mesh: usize) -> String {
        match self.root.meshes[mesh].name.as_deref() {
            None | Some("") => format!("mesh {mesh}"),
            Some(name) => match name.char_indices().nth(60) {
                Some((end, _)) => format!("mesh {mesh} '{}…'", &name[..end]),
                None => format!("mesh {mesh} '{name}'"),
            },
        }
    }
}

/// `offset..offset+length`, if it lies within `size`.
pub(crate) fn range(offset: u64, length: Option<u64>, size: usize) -> Option<std::ops::Range<usize>> {
    let end = offset.checked_add(length?)?;
    let (start, end) = (usize::try_from(offset).ok()?, usize::try_from(end).ok()?);
    (end <= size).then_some(start..end)
}

pub(crate) fn out_of_range(name: &str, index: usize, len: usize) -> Error {
    Error::IndexOutOfRange { name: name.into(), index: index as u64, len: len as u64 }
}

/// One of the root's arrays as typed values. Errors name the element.
fn list<T: serde::de::DeserializeOwned>(value: &Value, key: &str) -> Result<Vec<T>, Error> {
    let elements = match &value[key] {
        Value::Null => return Ok(Vec::new()),
        Value::Array(elements) => elements,
        _ => return Err(malformed(format!("the glTF's {key} is not a list"))),
    };
    let typed = |(i, element): (usize, &Value)| {
        // serde also reads these structures from lists, but the exporter edits objects.
        let parts = element["primitives"].as_array().map(Vec::as_slice).unwrap_or_default();
        if !element.is_object() || !parts.iter().all(Value::is_object) {
            return Err(malformed(format!("{key}[{i}] of the glTF is not made of objects")));
        }
        // This goes through text, since the typed structures can read raw extras from nothing else.
        serde_json::from_str(&element.to_string())
            .map_err(|e| malformed(format!("{key}[{i}] of the glTF: {}", in_json_terms(&e))))
    };
    elements.iter().enumerate().map(typed).collect()
}

/// serde's message with JSON's names for types. Its line and column belong to a copy of the text, so they are left out.
fn in_json_terms(error: &serde_json::Error) -> String {
    const TERMS: [(&str, &str); 9] = [
        ("expected u64", "expected a whole number"),
        ("expected u32", "expected a whole number"),
        ("expected f64", "expected a number"),
        ("expected f32", "expected a number"),
        ("expected a sequence", "expected a list"),
        ("expected a map", "expected an object"),
        ("expected struct", "expected an object:"),
        ("type: sequence", "type: a list"),
        ("type: map", "type: an object"),
    ];
    let text = error.to_string();
    let text = text.split(" at line ").next().unwrap_or_default();
    TERMS.iter().fold(text.to_owned(), |text, (serde, json)| text.replace(serde, json))
}

/// The JSON text, and the binary chunk if there is one.
fn split(bytes: &[u8]) -> Result<(&[u8], Option<&[u8]>), Error> {
    if bytes.starts_with(b"glTF") {
        return split_glb(bytes);
    }
    let text = bytes.strip_prefix(b"\xEF\xBB\xBF").unwrap_or(bytes);
    match text.iter().find(|b| !b.is_ascii_whitespace()) {
        Some(b'{') => Ok((text, None)),
        None => Err(malformed("the file is empty; a glTF starts with 'glTF' (.glb) or '{' (.gltf)")),
        Some(_) => Err(malformed(format!(
            "the file starts with {}; a glTF starts with 'glTF' (.glb) or '{{' (.gltf)",
            describe_start(text)
        ))),
    }
}

fn split_glb(bytes: &[u8]) -> Result<(&[u8], Option<&[u8]>), Error> {
    let word = |at: usize| bytes.get(at..at + 4).map(|b| u32::from_le_bytes([b[0], b[1], b[2], b[3]]));
    let (Some(version), Some(length)) = (word(4), word(8)) else {
        return Err(malformed(format!("the GLB ends after {} bytes, inside its header of 12", bytes.len())));
    };
    if version != 2 {
        return Err(unsupported(format!("GLB version {version}; version 2 (glTF 2.0) is read")));
    }
    if length as usize != bytes.len() {
        return Err(malformed(format!("the GLB says it has {length} bytes; there are {}", bytes.len())));
    }
    let (mut text, mut bin) = (None, None);
    let mut at = 12;
    while at < bytes.len() {
        let (Some(size), Some(kind)) = (word(at), word(at + 4)) else {
            return Err(malformed(format!("the GLB ends inside the chunk header at byte {at}")));
        };
        let chunk = range(at as u64 + 8, Some(size.into()), bytes.len()).ok_or_else(|| {
            malformed(format!("the GLB chunk at byte {at} says it has {size} bytes; {} follow", bytes.len() - at - 8))
        })?;
        at = chunk.end;
        let kind = kind.to_le_bytes();
        match (&kind, text) {
            (b"JSON", None) => text = Some(&bytes[chunk]),
            (b"BIN\0", Some(_)) => bin = bin.or(Some(&bytes[chunk])),
            (_, None) => {
                return Err(malformed(format!("the first GLB chunk is '{}'; it must be 'JSON'", kind.escape_ascii())));
            }
            _ => {}
        }
    }
    let text = text.ok_or_else(|| malformed("the GLB has no JSON chunk"))?;
    let end = text.iter().rposition(|b| *b != 0 && *b != b' ').map_or(0, |last| last + 1);
    Ok((&text[..end], bin))
}

fn describe_start(bytes: &[u8]) -> String {
    let known: &[(&[u8], &str)] = &[
        (b"\x89PNG", "a PNG image"),
        (b"\xFF\xD8\xFF", "a JPEG image"),
        (b"PK\x03\x04", "a ZIP archive"),
        (b"Kaydara FBX", "an FBX file"),
        (b"BLENDER", "a Blender file"),
        (b"\x28\xB5\x2F\xFD", "a compressed (zstd) file"),
        (b"\x1F\x8B", "a compressed (gzip) file"),
    ];
    let start = bytes[..bytes.len().min(8)].escape_ascii();
    match known.iter().find(|(magic, _)| bytes.starts_with(magic)) {
        Some((_, name)) => format!("'{start}' ({name})"),
        None => format!("'{start}'"),
    }
}

fn check_version(value: &Value) -> Result<(), Error> {
    let asset = &value["asset"];
    let needed = if asset["minVersion"].is_string() { &asset["minVersion"] } else { &asset["version"] };
    match needed.as_str() {
        Some("2.0") => Ok(()),
        Some(v) if v.starts_with("2.") && !asset["minVersion"].is_string() => Ok(()),
        Some(v) => Err(unsupported(format!("glTF version {v}; version 2.0 is read"))),
        None => Err(malformed("the glTF has no asset.version; '2.0' is read")),
    }
}

fn check_extensions(value: &Value) -> Result<(), Error> {
    let harmless = |name: &str| HARMLESS.iter().any(|h| *h == name || (h.ends_with('_') && name.starts_with(h)));
    let required = value["extensionsRequired"].as_array().map(Vec::as_slice).unwrap_or_default();
    let Some(name) = required.iter().filter_map(Value::as_str).find(|name| !harmless(name)) else { return Ok(()) };
    let advice = match name {
        "KHR_draco_mesh_compression" => "; export without mesh compression (Draco)",
        "EXT_meshopt_compression" | "KHR_meshopt_compression" => "; export without mesh compression (meshopt)",
        _ => "",
    };
    Err(unsupported(format!("the file requires the extension {name}{advice}")))
}
