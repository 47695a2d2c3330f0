//! Writes a GLB from an imported mesh alone.

use super::glb::{Blob, ELEMENT_ARRAY_BUFFER, container, push, push_attribute, push_view};
use super::vertices::{Vertices, each};
use crate::base::error::Error;
use crate::io::import::{Imported, PrimitiveRange};
use serde_json::{Value, json};
use std::collections::HashMap;

pub(super) fn mesh(imported: &Imported, vertices: Vertices<'_>) -> Result<Vec<u8>, Error> {
    imported.primitives.iter().enumerate().try_for_each(|(i, range)| check(imported, i, range))?;
    if let Some(t) = &imported.texcoords {
        each(imported.mesh.positions.len(), t, "texcoords")?;
    }
    let mut root = json!({
        "asset": { "version": "2.0", "generator": concat!("crumple ", env!("CARGO_PKG_VERSION")) },
        "scene": 0,
        "scenes": [{ "nodes": [0] }],
        "nodes": [{ "mesh": 0 }],
    });
    if !imported.name.is_empty() {
        root["nodes"][0]["name"] = imported.name.as_str().into();
    }
    if let Some(columns) = imported.node_transform.filter(|m| *m != IDENTITY) {
        root["nodes"][0]["matrix"] = columns.as_flattened().iter().map(|x| f64::from(*x)).collect();
    }
    let mut blob = Blob::default();
    let mut attributes = HashMap::new();
    let mut primitives = Vec::new();
    for range in &imported.primitives {
        let shared = attributes
            .entry((range.first_vertex, range.vertex_count))
            .or_insert_with(|| push_attributes(&mut root, &mut blob, imported, vertices, range))
            .clone();
        primitives.push(primitive(&mut root, &mut blob, imported, range, shared)?);
    }
    root["meshes"] = json!([{ "name": imported.name, "primitives": primitives }]);
    root["buffers"] = json!([{ "byteLength": blob.bytes.len() }]);
    container(&root, &blob.bytes)
}

const IDENTITY: [[f32; 4]; 4] =
    [[1.0, 0.0, 0.0, 0.0], [0.0, 1.0, 0.0, 0.0], [0.0, 0.0, 1.0, 0.0], [0.0, 0.0, 0.0, 1.0]];

/// Checks a primitive's range: the fields are public, so the caller may have changed them.
fn check(imported: &Imported, i: usize, range: &PrimitiveRange) -> Result<(), Error> {
    let (vertices, triangles) = (imported.mesh.positions.len(), &imported.mesh.triangles);
    let vertex_end = u64::from(range.first_vertex) + u64::from(range.vertex_count);
    let triangle_end = u64::from(range.first_triangle) + u64::from(range.triangle_count);
    if range.vertex_count == 0 || vertex_end > vertices as u64 || triangle_end > triangles.len() as u64 {
        let right = format!("ranges within {vertices} vertices and {} triangles, not empty", triangles.len());
        return Err(Error::invalid(&format!("primitives[{i}]"), format_args!("{range:?}"), &right));
    }
    let own = u64::from(range.first_vertex)..vertex_end;
    let corners = triangles[range.first_triangle as usize..triangle_end as usize].as_flattened();
    match corners.iter().find(|v| !own.contains(&u64::from(**v))) {
        None => Ok(()),
        Some(v) => Err(Error::invalid(&format!("a triangle corner of primitives[{i}]"), v, &format!("within {own:?}"))),
    }
}

fn push_attributes(
    root: &mut Value,
    blob: &mut Blob,
    imported: &Imported,
    vertices: Vertices<'_>,
    range: &PrimitiveRange,
) -> Value {
    let own = range.first_vertex as usize..(range.first_vertex + range.vertex_count) as usize;
    let mut attributes = json!({ "POSITION": push_attribute(root, blob, &vertices.positions[own.clone()], true) });
    if let Some(normals) = vertices.normals {
        attributes["NORMAL"] = push_attribute(root, blob, &normals[own.clone()], false).into();
    }
    if let Some(tangents) = vertices.tangents {
        attributes["TANGENT"] = push_attribute(root, blob, &tangents[own.clone()], false).into();
    }
    if let Some(texcoords) = &imported.texcoords {
        attributes["TEXCOORD_0"] = push_attribute(root, blob, &texcoords[own], false).into();
    }
    attributes
}

fn primitive(
    root: &mut Value,
    blob: &mut Blob,
    imported: &Imported,
    range: &PrimitiveRange,
    attributes: Value,
) -> Result<Value, Error> {
    let mut primitive = json!({ "attributes": attributes });
    let triangles = &imported.mesh.triangles[range.first_triangle as usize..][..range.triangle_count as usize];
    if triangles.is_empty() {
        primitive["mode"] = 0.into();
    } else {
        let local = triangles.as_flattened().iter().map(|i| i - range.first_vertex);
        // 65535 is the restart value of 16-bit indices.
        let (component, bytes): (u32, Vec<u8>) = if range.vertex_count <= u32::from(u16::MAX) {
            (5123, local.flat_map(|i| (i as u16).to_le_bytes()).collect())
        } else {
            (5125, local.flat_map(u32::to_le_bytes).collect())
        };
        let view = push_view(root, blob, &bytes, Some(ELEMENT_ARRAY_BUFFER));
        let accessor =
            json!({ "bufferView": view, "componentType": component, "count": triangles.len() * 3, "type": "SCALAR" });
        primitive["indices"] = push(root, "accessors", accessor).into();
    }
    if let Some(name) = &range.material {
        let known = root["materials"].as_array().and_then(|list| list.iter().position(|m| m["name"] == name.as_str()));
        let index = known.unwrap_or_else(|| push(root, "materials", json!({ "name": name })));
        primitive["material"] = index.into();
    }
    Ok(primitive)
}
