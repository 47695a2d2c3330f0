//! The container of a glTF: GLB chunks, parsed JSON, and buffers that are loaded on first use.

use super::meshopt::Packed;
use super::uri::{self, UriTarget};
use super::words::{cut, decoded};
use super::{malformed, unsupported, whole};
use crate::base::error::Error;
use ::gltf::json::{self, Index};
use serde_json::Value;
use std::borrow::Cow;
use std::cell::{Cell, OnceCell};
use std::path::Path;

/// Extensions (by name or by prefix ending in `_`) that may be required: they do not change the geometry, or are read. Whether a
/// primitive's data is in Draco's is seen where it is read.
const KNOWN: &[&str] = &[
    "KHR_materials_",
    "EXT_materials_",
    "KHR_texture_",
    "EXT_texture_",
    "MSFT_texture_dds",
    "KHR_lights_",
    "EXT_lights_",
    "KHR_animation_pointer",
    "KHR_node_",
    "KHR_xmp",
    "KHR_xmp_json_ld",
    "EXT_mesh_gpu_instancing",
    "EXT_mesh_features",
    "KHR_mesh_quantization",
    "KHR_draco_mesh_compression",
    "EXT_meshopt_compression",
    "KHR_meshopt_compression",
];

/// Decoded bytes allowed per byte of the file. Shared accessors can make decoded data larger than the file; this limits
/// the factor.
const EXPANSION: u64 = 64;

/// A parsed glTF whose buffers are loaded on first use.
///
/// Only what reading meshes needs is typed, so that a file with a broken material can still be read. Types are right; values are
/// checked where they are used.
pub(crate) struct Document<'a> {
    pub accessors: List<json::Accessor>,
    pub buffers: List<json::Buffer>,
    pub views: List<json::buffer::View>,
    pub meshes: List<json::Mesh>,
    pub nodes: Vec<json::Node>,
    /// The same JSON as plain values: extras, extensions and everything unknown.
    pub value: Value,
    bin: Option<&'a [u8]>,
    /// The chunks of a GLB that glTF does not know, each with its type. They are kept.
    pub chunks: Vec<([u8; 4], &'a [u8])>,
    base_dir: Option<&'a Path>,
    loaded: Vec<OnceCell<Cow<'a, [u8]>>>,
    unpacked: Vec<OnceCell<Vec<u8>>>,
    pub budget: Budget,
}

/// One of the root's lists. An element that cannot be read is an error only to who asks for it: it may be of another mesh.
pub(crate) struct List<T>(Vec<Result<T, Error>>);

impl<T> List<T> {
    pub fn len(&self) -> usize {
        self.0.len()
    }

    /// An element. `user` names who refers to it.
    pub fn get(&self, index: usize, user: &str) -> Result<&T, Error> {
        match self.0.get(index) {
            Some(element) => element.as_ref().map_err(Error::clone),
            None => Err(out_of_range(user, index, self.0.len())),
        }
    }

    /// The elements, broken ones as `None`.
    pub fn iter(&self) -> impl ExactSizeIterator<Item = Option<&T>> {
        self.0.iter().map(|element| element.as_ref().ok())
    }
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
        let Container { text, bin, chunks } = split(bytes)?;
        let not_json = |e: serde_json::Error| malformed(format!("the glTF's JSON: {e}"));
        let value: Value = serde_json::from_str(&text).map_err(not_json)?;
        check_version(&value)?;
        let (accessors, buffers, views) =
            (list(&value, "accessors")?, list(&value, "buffers")?, list(&value, "bufferViews")?);
        Ok(Self {
            loaded: (0..buffers.len()).map(|_| OnceCell::new()).collect(),
            unpacked: (0..views.len()).map(|_| OnceCell::new()).collect(),
            accessors,
            buffers,
            views,
            meshes: list(&value, "meshes")?,
            nodes: list(&value, "nodes")?.0.into_iter().collect::<Result<_, _>>()?,
            bin,
            chunks,
            base_dir,
            budget: Budget { loaded: Cell::new(bytes.len() as u64), decoded: Cell::new(0) },
            value,
        })
    }

    /// One of the root's lists as plain values; empty if it is absent or no list.
    pub fn list(&self, key: &str) -> &[Value] {
        self.value[key].as_array().map(Vec::as_slice).unwrap_or_default()
    }

    /// Whether the file says that meshes are compressed with Draco.
    pub fn uses_draco(&self) -> bool {
        let lists = ["extensionsRequired", "extensionsUsed"].map(|key| self.list(key));
        lists.into_iter().flatten().any(|name| name == "KHR_draco_mesh_compression")
    }

    /// The extensions that the file requires and that this library does not know.
    pub fn unknown_requirements(&self) -> Vec<&str> {
        let known = |name: &str| KNOWN.iter().any(|k| *k == name || (k.ends_with('_') && name.starts_with(k)));
        self.list("extensionsRequired").iter().filter_map(Value::as_str).filter(|name| !known(name)).collect()
    }

    /// The bytes of a buffer, exactly as many as the file states.
    pub fn buffer(&self, index: usize) -> Result<&[u8], Error> {
        let buffer = self.buffers.get(index, "buffer")?;
        let bytes = match self.loaded[index].get() {
            Some(bytes) => bytes,
            None => {
                let bytes = self.load(index, buffer)?;
                self.loaded[index].get_or_init(|| bytes)
            }
        };
        let length = usize::try_from(buffer.byte_length.0).ok();
        length.and_then(|length| bytes.get(..length)).ok_or_else(|| {
            malformed(format!("buffer {index} says it has {} bytes; there are {}", buffer.byte_length.0, bytes.len()))
        })
    }

    fn load(&self, index: usize, buffer: &json::Buffer) -> Result<Cow<'a, [u8]>, Error> {
        let what = format!("buffer {index}");
        let length = buffer.byte_length.0;
        let external = |bytes: Vec<u8>| {
            let loaded = &self.budget.loaded;
            loaded.set(loaded.get().saturating_add(bytes.len() as u64));
            Cow::Owned(bytes)
        };
        match (&buffer.uri, self.bin) {
            (Some(uri), _) => match uri::parse(uri, &what)? {
                UriTarget::Data(bytes) => Ok(Cow::Owned(bytes)),
                UriTarget::File(path) => Ok(external(uri::read_file(self.base_dir, &path, &what, Some(length))?)),
            },
            (None, Some(bin)) if index == 0 => Ok(Cow::Borrowed(bin)),
            (None, _) => Err(self.no_data(index)),
        }
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
        let index = index.value();
        let view = self.views.get(index, &format!("{user}: bufferView"))?;
        let stride = view.byte_stride.map(|s| s.0);
        let user = format!("{user}: bufferView {index}");
        let Some(packed) = Packed::of(&self.value["bufferViews"][index], &user)? else {
            let offset = view.byte_offset.map_or(0, |o| o.0);
            return Ok((self.bytes(view.buffer.value(), offset, view.byte_length.0, &user)?, stride));
        };
        if let Some(bytes) = self.unpacked[index].get() {
            return Ok((bytes, stride));
        }
        let bytes = self.bytes(packed.buffer, packed.offset, packed.length, &user)?;
        self.budget.charge(packed.count, packed.stride, &user)?;
        let bytes = packed.decode(bytes, &user)?;
        Ok((self.unpacked[index].get_or_init(|| bytes), stride))
    }

    /// `length` bytes of a buffer. `user` names who refers to them.
    pub fn bytes(&self, buffer: usize, offset: u64, length: u64, user: &str) -> Result<&[u8], Error> {
        let bytes = self.buffer(buffer)?;
        let range = range(offset, Some(length), bytes.len()).ok_or_else(|| {
            malformed(format!("{user} is {length} bytes from byte {offset}; buffer {buffer} has {}", bytes.len()))
        })?;
        Ok(&bytes[range])
    }

    /// Reads a file that an image refers to.
    pub fn read_relative(&self, path: &str, what: &str) -> Result<Vec<u8>, Error> {
        uri::read_file(self.base_dir, path, what, None)
    }

    /// The mesh's name in errors, such as `mesh 2 'Door'`. A long one is cut: each primitive repeats it, so that a file could
    /// ask for the square of its size.
    pub fn mesh_label(&self, mesh: usize) -> String {
        match self.value["meshes"][mesh]["name"].as_str() {
            None | Some("") => format!("mesh {mesh}"),
            Some(name) => format!("mesh {mesh} '{}'", cut(name)),
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

/// The same JSON with whole numbers written without a point, except in extras.
fn without_points(value: &Value) -> Value {
    match value {
        Value::Number(number) if number.is_f64() => whole(value).map_or_else(|| value.clone(), Value::from),
        Value::Array(list) => list.iter().map(without_points).collect(),
        Value::Object(map) => {
            let inner = |(key, v): (&String, &Value)| {
                (key.clone(), if key == "extras" { v.clone() } else { without_points(v) })
            };
            Value::Object(map.iter().map(inner).collect())
        }
        other => other.clone(),
    }
}

/// One of the root's arrays as typed values. Errors name the element.
fn list<T: serde::de::DeserializeOwned>(value: &Value, key: &str) -> Result<List<T>, Error> {
    let elements = match &value[key] {
        Value::Null => return Ok(List(Vec::new())),
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
        serde_json::from_str(&without_points(element).to_string())
            .map_err(|e| malformed(format!("{key}[{i}] of the glTF: {}", in_json_terms(&e))))
    };
    Ok(List(elements.iter().enumerate().map(typed).collect()))
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

/// What a file holds.
struct Container<'a> {
    /// The JSON.
    text: Cow<'a, str>,
    bin: Option<&'a [u8]>,
    /// Other chunks.
    chunks: Vec<([u8; 4], &'a [u8])>,
}

fn split(bytes: &[u8]) -> Result<Container<'_>, Error> {
    if bytes.starts_with(b"glTF") {
        return split_glb(bytes);
    }
    let text = decoded(bytes);
    match text.trim_ascii_start().chars().next() {
        Some('{') => Ok(Container { text, bin: None, chunks: Vec::new() }),
        None => Err(malformed("the file is empty; a glTF starts with 'glTF' (.glb) or '{' (.gltf)")),
        Some(_) => Err(malformed(format!(
            "the file starts with {}; a glTF starts with 'glTF' (.glb) or '{{' (.gltf)",
            describe_start(bytes)
        ))),
    }
}

fn split_glb(bytes: &[u8]) -> Result<Container<'_>, Error> {
    let word = |bytes: &[u8], at: usize| bytes.get(at..)?.first_chunk().map(|four| u32::from_le_bytes(*four));
    let (Some(version), Some(length)) = (word(bytes, 4), word(bytes, 8)) else {
        return Err(malformed(format!("the GLB ends after {} bytes, inside its header of 12", bytes.len())));
    };
    if version != 2 {
        return Err(unsupported(format!("GLB version {version}; version 2 (glTF 2.0) is read")));
    }
    // Some writers pad the file. What follows the length in the header is not part of the GLB.
    let bytes = bytes.get(..length as usize).ok_or_else(|| {
        malformed(format!("the GLB says it has {length} bytes; there are {}, so it was cut short", bytes.len()))
    })?;
    let (mut text, mut bin, mut chunks) = (None, None, Vec::new());
    let mut at = 12;
    while at < bytes.len() {
        let (Some(size), Some(kind)) = (word(bytes, at), word(bytes, at + 4)) else {
            return Err(malformed(format!("the GLB ends inside the chunk header at byte {at}")));
        };
        let chunk = range(at as u64 + 8, Some(size.into()), bytes.len()).ok_or_else(|| {
            malformed(format!("the GLB chunk at byte {at} says it has {size} bytes; {} follow", bytes.len() - at - 8))
        })?;
        at = chunk.end;
        let kind = kind.to_le_bytes();
        match (&kind, text) {
            (b"JSON", None) => text = Some(&bytes[chunk]),
            (b"BIN\0", Some(_)) if bin.is_none() => bin = Some(&bytes[chunk]),
            (_, None) => {
                return Err(malformed(format!("the first GLB chunk is '{}'; it must be 'JSON'", kind.escape_ascii())));
            }
            _ => chunks.push((kind, &bytes[chunk])),
        }
    }
    let text: &[u8] = text.ok_or_else(|| malformed("the GLB has no JSON chunk"))?;
    let end = text.iter().rposition(|b| *b != 0 && *b != b' ').map_or(0, |last| last + 1);
    Ok(Container { text: decoded(&text[..end]), bin, chunks })
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
