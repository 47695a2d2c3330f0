//! Small GLBs made by hand, for tests that need what exporters do not write.
#![allow(dead_code)]

use crumple::Deltas;
use serde_json::{Value, json};
use std::path::PathBuf;

pub fn fixture(name: &str) -> PathBuf {
    PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("tests/fixtures").join(name)
}

pub struct Glb {
    pub json: Value,
    pub bin: Vec<u8>,
}

impl Glb {
    pub fn empty() -> Self {
        let json = json!({
            "asset": { "version": "2.0" }, "scene": 0, "scenes": [{ "nodes": [0] }], "nodes": [{ "mesh": 0 }],
            "meshes": [], "accessors": [], "bufferViews": [], "buffers": [{ "byteLength": 0 }],
        });
        Self { json, bin: Vec::new() }
    }

    pub fn push(&mut self, key: &str, value: Value) -> usize {
        let list = self.json[key].as_array_mut().unwrap();
        list.push(value);
        list.len() - 1
    }

    pub fn view(&mut self, bytes: &[u8]) -> usize {
        self.bin.resize(self.bin.len().next_multiple_of(4), 0);
        let view = json!({ "buffer": 0, "byteOffset": self.bin.len(), "byteLength": bytes.len() });
        self.bin.extend_from_slice(bytes);
        self.json["buffers"][0]["byteLength"] = self.bin.len().into();
        self.push("bufferViews", view)
    }

    pub fn floats(&mut self, kind: &str, values: &[f32]) -> usize {
        let width = ["SCALAR", "VEC2", "VEC3", "VEC4"].iter().position(|k| *k == kind).unwrap() + 1;
        let view = self.view(&bytes(values));
        let count = values.len() / width;
        self.push("accessors", json!({ "bufferView": view, "componentType": 5126, "count": count, "type": kind }))
    }

    /// Vertex indices in components of 1, 2 or 4 bytes.
    pub fn indices(&mut self, width: usize, values: &[u32]) -> usize {
        let (view, component) = self.components(width, values);
        self.push(
            "accessors",
            json!({ "bufferView": view, "componentType": component, "count": values.len(), "type": "SCALAR" }),
        )
    }

    fn components(&mut self, width: usize, values: &[u32]) -> (usize, u32) {
        let raw: Vec<u8> = values.iter().flat_map(|v| v.to_le_bytes()[..width].to_vec()).collect();
        (self.view(&raw), [5121, 5123, 0, 5125][width - 1])
    }

    /// Sparse over `base` (zeros where there is none).
    pub fn sparse(&mut self, count: usize, base: Option<usize>, width: usize, at: &[u32], values: &[f32]) -> usize {
        let ((indices, component), values) = (self.components(width, at), self.view(&bytes(values)));
        let mut accessor = json!({
            "componentType": 5126, "count": count, "type": "VEC3",
            "sparse": {
                "count": at.len(),
                "indices": { "bufferView": indices, "componentType": component },
                "values": { "bufferView": values },
            },
        });
        if let Some(base) = base {
            accessor["bufferView"] = base.into();
        }
        self.push("accessors", accessor)
    }

    pub fn bytes(&self) -> Vec<u8> {
        container(self.json.to_string().as_bytes(), Some(&self.bin))
    }
}

pub fn container(json: &[u8], bin: Option<&[u8]>) -> Vec<u8> {
    let mut text = json.to_vec();
    text.resize(text.len().next_multiple_of(4), b' ');
    let mut out = b"glTF\x02\0\0\0\0\0\0\0".to_vec();
    let mut chunk = |kind: &[u8; 4], data: &[u8]| {
        out.extend_from_slice(&(data.len().next_multiple_of(4) as u32).to_le_bytes());
        out.extend_from_slice(kind);
        out.extend_from_slice(data);
        out.resize(out.len().next_multiple_of(4), 0);
    };
    chunk(b"JSON", &text);
    if let Some(bin) = bin {
        chunk(b"BIN\0", bin);
    }
    let length = out.len() as u32;
    out[8..12].copy_from_slice(&length.to_le_bytes());
    out
}

pub fn parts(glb: &[u8]) -> (Value, Vec<u8>) {
    let word = |at: usize| u32::from_le_bytes(glb[at..at + 4].try_into().unwrap()) as usize;
    let json = 20 + word(12);
    let bin = if glb.len() > json { glb[json + 8..json + 8 + word(json)].to_vec() } else { Vec::new() };
    (serde_json::from_slice(&glb[20..json]).unwrap(), bin)
}

pub fn bytes(values: &[f32]) -> Vec<u8> {
    values.iter().flat_map(|v| v.to_le_bytes()).collect()
}

pub const SQUARE: [f32; 12] = [0., 0., 0., 1., 0., 0., 1., 0., 1., 0., 0., 1.];
pub const UP: [f32; 12] = [0., 1., 0., 0., 1., 0., 0., 1., 0., 0., 1., 0.];

/// A square of two triangles. Accessors: 0 POSITION, 1 NORMAL, 2 u16 indices, 3 a dense target, 4 its normal deltas, 5 a sparse target over
/// zeros that moves vertices 1 and 3.
pub fn square() -> Glb {
    let mut glb = Glb::empty();
    glb.floats("VEC3", &SQUARE);
    glb.floats("VEC3", &UP);
    glb.indices(2, &[0, 2, 1, 0, 3, 2]);
    glb.floats("VEC3", &[0., -0.5, 0., 0., 0., 0., 0., -0.25, 0., 0., 0., 0.]);
    glb.floats("VEC3", &[0.5, -0.5, 0., 0., 0., 0., 0., 0., 0., 0., 0., 0.]);
    glb.sparse(4, None, 2, &[1, 3], &[0., -1., 0., 0., -2., 0.]);
    glb.push(
        "meshes",
        json!({
            "name": "Square",
            "primitives": [{
                "attributes": { "POSITION": 0, "NORMAL": 1 }, "indices": 2,
                "targets": [{ "POSITION": 3, "NORMAL": 4 }, { "POSITION": 5 }],
            }],
            "extras": { "targetNames": ["dense", "sparse"] },
        }),
    );
    glb
}

/// Indices and values of deltas, which the importer writes sparse, in order and without zeros.
pub fn sparse(deltas: &Deltas) -> (&[u32], &[[f32; 3]]) {
    match deltas {
        Deltas::Sparse { indices, values } => {
            assert_eq!(indices.len(), values.len());
            assert!(indices.is_sorted_by(|a, b| a < b));
            assert!(values.iter().all(|v| *v != [0.0; 3]));
            (indices, values)
        }
        Deltas::Full(_) => panic!("the importer writes sparse deltas"),
    }
}
