//! Writes a GLB from arrays alone.

use super::vertices::Vertices;
use crate::base::error::Error;
use crate::io::glb::{Blob, ELEMENT_ARRAY_BUFFER, container, push, push_attribute, push_view};
use serde_json::json;

pub(super) fn mesh(name: &str, triangles: &[[u32; 3]], vertices: Vertices<'_>) -> Result<Vec<u8>, Error> {
    let count = vertices.positions.len();
    if count == 0 || count > u32::MAX as usize {
        return Err(Error::invalid("positions.len()", count, &format!("from 1 to {}", u32::MAX)));
    }
    let corners = triangles.as_flattened();
    if let Some(at) = corners.iter().position(|v| *v as usize >= count) {
        let name = format!("triangles[{}][{}]", at / 3, at % 3);
        return Err(Error::IndexOutOfRange { name, index: corners[at].into(), len: count as u64 });
    }
    let mut root = json!({
        "asset": { "version": "2.0", "generator": concat!("crumple ", env!("CARGO_PKG_VERSION")) },
        "scene": 0,
        "scenes": [{ "nodes": [0] }],
        "nodes": [{ "mesh": 0 }],
    });
    if !name.is_empty() {
        root["nodes"][0]["name"] = name.into();
    }
    let mut blob = Blob::default();
    let mut attributes = json!({ "POSITION": push_attribute(&mut root, &mut blob, vertices.positions, true) });
    if let Some(normals) = vertices.normals {
        attributes["NORMAL"] = push_attribute(&mut root, &mut blob, normals, false).into();
    }
    if let Some(tangents) = vertices.tangents {
        attributes["TANGENT"] = push_attribute(&mut root, &mut blob, tangents, false).into();
    }
    let mut primitive = json!({ "attributes": attributes });
    if corners.is_empty() {
        primitive["mode"] = 0.into();
    } else {
        let bytes: Vec<u8> = corners.iter().flat_map(|i| i.to_le_bytes()).collect();
        let view = push_view(&mut root, &mut blob, &bytes, Some(ELEMENT_ARRAY_BUFFER));
        let accessor = json!({ "bufferView": view, "componentType": 5125, "count": corners.len(), "type": "SCALAR" });
        primitive["indices"] = push(&mut root, "accessors", accessor).into();
    }
    root["meshes"] = json!([{ "name": name, "primitives": [primitive] }]);
    root["buffers"] = json!([{ "byteLength": blob.bytes.len() }]);
    container(&root, &blob.bytes, &[])
}
