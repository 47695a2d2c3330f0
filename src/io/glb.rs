//! Writes GLBs: new accessors, and the container.

use crate::base::error::Error;
use bytemuck::cast_slice;
use serde_json::{Map, Value, json};

/// OpenGL's constants for the content of a bufferView, which glTF uses too.
pub(crate) const ARRAY_BUFFER: u32 = 34962;
const ELEMENT_ARRAY_BUFFER: u32 = 34963;

/// A written GLB.
#[derive(Debug, Clone, PartialEq)]
pub struct GlbFile {
    /// The file's bytes.
    pub glb: Vec<u8>,
    /// What was odd in the source or could not be kept as it was, and what was done about it: a sentence each, for people.
    pub notes: Vec<String>,
}

/// A GLB that is being written: its JSON, and bytes of its binary chunk.
pub(crate) struct Glb {
    pub root: Value,
    pub bin: Vec<u8>,
}

impl Glb {
    pub fn new(root: Value) -> Self {
        Glb { root, bin: Vec::new() }
    }

    /// Appends to one of the root's arrays, which is created if needed.
    pub fn push(&mut self, key: &str, element: Value) -> usize {
        if !self.root[key].is_array() {
            self.root[key] = Value::Array(Vec::new());
        }
        let list = self.root[key].as_array_mut().expect("an array, made above");
        list.push(element);
        list.len() - 1
    }

    /// Adds a bufferView of the binary chunk. Other buffers are laid out later.
    pub fn push_view(&mut self, bytes: &[u8], target: Option<u32>) -> usize {
        // The alignment that all component types need.
        self.bin.resize(self.bin.len().next_multiple_of(4), 0);
        let mut view = json!({ "buffer": 0, "byteOffset": self.bin.len(), "byteLength": bytes.len() });
        self.bin.extend_from_slice(bytes);
        if let Some(target) = target {
            view["target"] = target.into();
        }
        self.push("bufferViews", view)
    }

    /// Adds an accessor of float `values`, with bounds if asked for; glTF requires bounds for positions.
    pub fn push_attribute<const N: usize>(&mut self, values: &[[f32; N]], bounds: bool) -> usize {
        let view = self.push_view(cast_slice(values.as_flattened()), Some(ARRAY_BUFFER));
        let (count, kind) = (values.len(), kind::<N>());
        let mut accessor = json!({ "bufferView": view, "componentType": 5126, "count": count, "type": kind });
        if bounds {
            set_bounds(&mut accessor, values.iter());
        }
        self.push("accessors", accessor)
    }

    /// Adds an accessor of vertex indices.
    pub fn push_indices(&mut self, indices: &[u32]) -> usize {
        let view = self.push_view(cast_slice(indices), Some(ELEMENT_ARRAY_BUFFER));
        let accessor = json!({ "bufferView": view, "componentType": 5125, "count": indices.len(), "type": "SCALAR" });
        self.push("accessors", accessor)
    }

    /// The bytes of a GLB that has no other buffers.
    pub fn finish(mut self) -> Result<Vec<u8>, Error> {
        self.root["buffers"] = json!([{ "byteLength": self.bin.len() }]);
        container(&self.root, &self.bin, &[])
    }
}

/// The JSON of a new glTF with one scene.
pub(crate) fn new_root(scene: Value, nodes: Value) -> Value {
    let asset = json!({ "version": "2.0", "generator": concat!("crumple ", env!("CARGO_PKG_VERSION")) });
    json!({ "asset": asset, "scene": 0, "scenes": [scene], "nodes": nodes })
}

/// The type of an accessor with `N` numbers an element.
pub(crate) fn kind<const N: usize>() -> &'static str {
    ["SCALAR", "VEC2", "VEC3", "VEC4"][N - 1]
}

/// Gives an accessor the bounds of its values.
pub(crate) fn set_bounds<'v, const N: usize>(accessor: &mut Value, values: impl Iterator<Item = &'v [f32; N]> + Clone) {
    let bound = |least: fn(f32, f32) -> f32| -> Vec<f64> {
        (0..N).map(|k| f64::from(values.clone().map(|v| v[k]).reduce(least).unwrap_or(0.0))).collect()
    };
    (accessor["min"], accessor["max"]) = (bound(f32::min).into(), bound(f32::max).into());
}

/// Header, JSON chunk, binary chunk and `others`, each padded to 4 bytes.
pub(crate) fn container(root: &Value, bin: &[u8], others: &[([u8; 4], &[u8])]) -> Result<Vec<u8>, Error> {
    let mut text = root.to_string().into_bytes();
    text.resize(text.len().next_multiple_of(4), b' ');
    let binary = (!bin.is_empty()).then_some((*b"BIN\0", bin));
    let chunks = || binary.iter().chain(others);
    let total = 12 + 8 + text.len() + chunks().map(|(_, bytes)| 8 + bytes.len().next_multiple_of(4)).sum::<usize>();
    let total = u32::try_from(total).map_err(|_| Error::Unsupported {
        what: format!("the result has {total} bytes; a GLB holds less than 4 GiB"),
    })?;
    let mut out = crate::base::error::reserve(total as usize, "the GLB")?;
    out.extend_from_slice(b"glTF");
    out.extend_from_slice(&2u32.to_le_bytes());
    out.extend_from_slice(&total.to_le_bytes());
    out.extend_from_slice(&(text.len() as u32).to_le_bytes());
    out.extend_from_slice(b"JSON");
    out.append(&mut text);
    for (kind, bytes) in chunks() {
        out.extend_from_slice(&(bytes.len().next_multiple_of(4) as u32).to_le_bytes());
        out.extend_from_slice(kind);
        out.extend_from_slice(bytes);
        out.resize(out.len().next_multiple_of(4), 0);
    }
    Ok(out)
}

/// The elements of a list in an object; none if there is no such list. (`IndexMut` would create one.)
pub(crate) fn list_mut<'v>(object: &'v mut Value, key: &str) -> impl Iterator<Item = &'v mut Value> + use<'v> {
    object.get_mut(key).and_then(Value::as_array_mut).into_iter().flatten()
}

/// Removes keys from an object in `parent`, and the object itself if that leaves it empty.
pub(crate) fn remove_within(parent: &mut Map<String, Value>, object: &str, keys: &[&str]) {
    let Some(inner) = parent.get_mut(object).and_then(Value::as_object_mut) else { return };
    let removed = keys.iter().filter(|key| inner.shift_remove(**key).is_some()).count();
    if removed > 0 && inner.is_empty() {
        parent.shift_remove(object);
    }
}
