//! New accessors, and the GLB container.

use crate::base::error::Error;
use crate::io::import::unsupported;
use serde_json::{Map, Value, json};

/// OpenGL's constants for the content of a bufferView, which glTF uses too.
pub(crate) const ARRAY_BUFFER: u32 = 34962;
pub(crate) const ELEMENT_ARRAY_BUFFER: u32 = 34963;

/// Bytes for the file's binary chunk.
#[derive(Default)]
pub(crate) struct Blob {
    pub bytes: Vec<u8>,
}

impl Blob {
    /// Appends at the next multiple of 4, the alignment that all component types need. Returns (offset, length).
    pub fn push(&mut self, bytes: &[u8]) -> (usize, usize) {
        self.bytes.resize(self.bytes.len().next_multiple_of(4), 0);
        self.bytes.extend_from_slice(bytes);
        (self.bytes.len() - bytes.len(), bytes.len())
    }
}

/// Adds a bufferView of `blob`. Its buffer is filled in when the buffers are laid out.
pub(crate) fn push_view(root: &mut Value, blob: &mut Blob, bytes: &[u8], target: Option<u32>) -> usize {
    let (offset, length) = blob.push(bytes);
    let mut view = json!({ "buffer": 0, "byteOffset": offset, "byteLength": length });
    if let Some(target) = target {
        view["target"] = target.into();
    }
    push(root, "bufferViews", view)
}

/// Adds an accessor of float `values`, with bounds if asked for; glTF requires bounds for positions.
pub(crate) fn push_attribute<const N: usize>(
    root: &mut Value,
    blob: &mut Blob,
    values: &[[f32; N]],
    bounds: bool,
) -> usize {
    let bytes: Vec<u8> = values.iter().flatten().flat_map(|x| x.to_le_bytes()).collect();
    let view = push_view(root, blob, &bytes, Some(ARRAY_BUFFER));
    let kind = ["SCALAR", "VEC2", "VEC3", "VEC4"][N - 1];
    let mut accessor = json!({ "bufferView": view, "componentType": 5126, "count": values.len(), "type": kind });
    if bounds {
        let fold = |f: fn(f32, f32) -> f32| {
            (0..N).map(|i| values.iter().map(|v| v[i]).reduce(f).unwrap_or(0.0)).map(f64::from).collect::<Vec<_>>()
        };
        accessor["min"] = fold(f32::min).into();
        accessor["max"] = fold(f32::max).into();
    }
    push(root, "accessors", accessor)
}

/// Appends to one of the root's arrays, which is created if needed.
pub(crate) fn push(root: &mut Value, key: &str, element: Value) -> usize {
    if !root[key].is_array() {
        root[key] = Value::Array(Vec::new());
    }
    let list = root[key].as_array_mut().expect("an array, made above");
    list.push(element);
    list.len() - 1
}

/// Header, JSON chunk, binary chunk and `others`, each padded to 4 bytes.
pub(crate) fn container(root: &Value, bin: &[u8], others: &[([u8; 4], &[u8])]) -> Result<Vec<u8>, Error> {
    let mut text = root.to_string().into_bytes();
    text.resize(text.len().next_multiple_of(4), b' ');
    let binary = (!bin.is_empty()).then_some((*b"BIN\0", bin));
    let chunks = || binary.iter().chain(others);
    let total = 12 + 8 + text.len() + chunks().map(|(_, bytes)| 8 + bytes.len().next_multiple_of(4)).sum::<usize>();
    let total = u32::try_from(total)
        .map_err(|_| unsupported(format!("the result has {total} bytes; a GLB holds less than 4 GiB")))?;
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
