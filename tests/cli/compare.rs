//! Compares a glTF with what `crumple apply` made of it: everything that no dent reached must be as it was, byte for byte.

use base64::Engine;
use crumple::glam::{DMat4, DQuat, DVec3};
use serde_json::{Value, json};
use std::collections::{HashMap, HashSet};
use std::path::{Path, PathBuf};

/// What was found.
#[derive(Debug, Default)]
pub struct Report {
    /// Vertices of triangles, and those of them whose position changed.
    pub vertices: usize,
    pub moved: usize,
    /// What changed that should not have.
    pub differences: Vec<String>,
}

/// A glTF with its buffers.
pub struct File {
    pub json: Value,
    buffers: Vec<Option<Vec<u8>>>,
    /// What a GLB has behind its JSON and its binary chunk.
    other_chunks: Vec<u8>,
    folder: PathBuf,
}

/// The elements of an accessor: their bytes, and their components as numbers.
#[derive(PartialEq)]
pub struct Elements {
    pub bytes: Vec<Vec<u8>>,
    pub values: Vec<Vec<f64>>,
    kind: (u64, String, bool),
}

fn number(value: &Value) -> Option<usize> {
    value.as_f64().map(|x| x as usize)
}

fn list(value: &Value) -> &[Value] {
    value.as_array().map(Vec::as_slice).unwrap_or_default()
}

impl File {
    pub fn open(path: &Path) -> File {
        Self::open_in(path, path.parent().unwrap())
    }

    /// `folder` has the other files that it refers to.
    fn open_in(path: &Path, folder: &Path) -> File {
        let bytes = std::fs::read(path).unwrap_or_else(|e| panic!("{}: {e}", path.display()));
        let word = |at: usize| u32::from_le_bytes(bytes[at..at + 4].try_into().unwrap()) as usize;
        let (text, bin, other_chunks) = if bytes.starts_with(b"glTF") {
            let end = 20 + word(12);
            let bin = (word(8) > end).then(|| bytes[end + 8..end + 8 + word(end)].to_vec());
            let behind = bin.as_ref().map_or(end, |bin| end + 8 + bin.len());
            (&bytes[20..end], bin, bytes[behind..word(8)].to_vec())
        } else {
            (&bytes[..], None, Vec::new())
        };
        let wide = text.starts_with(&[0xFF, 0xFE]);
        let pairs = text.as_chunks::<2>().0.iter().map(|pair| u16::from_le_bytes(*pair));
        let text = if wide {
            String::from_utf16(&pairs.collect::<Vec<_>>()).unwrap()
        } else {
            String::from_utf8_lossy(text).into()
        };
        let json: Value = serde_json::from_str(text.trim_start_matches('\u{feff}').trim_end_matches('\0')).unwrap();
        let buffers = list(&json["buffers"]).iter().enumerate().map(|(i, buffer)| match buffer["uri"].as_str() {
            Some(uri) => uri_bytes(folder, uri),
            None if i == 0 => bin.clone(),
            None => None,
        });
        File { buffers: buffers.collect(), json, other_chunks, folder: folder.to_owned() }
    }

    fn view(&self, index: usize) -> Option<Vec<u8>> {
        let view = &self.json["bufferViews"][index];
        let packed =
            ["EXT_meshopt_compression", "KHR_meshopt_compression"].iter().find_map(|e| view["extensions"].get(e));
        let of = packed.unwrap_or(view);
        let bytes = self.buffers.get(number(&of["buffer"])?)?.as_ref()?;
        let start = number(&of["byteOffset"]).unwrap_or(0);
        let bytes = bytes.get(start..start + number(&of["byteLength"])?)?;
        let Some(packed) = packed else { return Some(bytes.to_vec()) };
        use meshoptimizer_rs::codec as m;
        let (count, stride, mut w) = (number(&packed["count"])?, number(&packed["byteStride"])?, Default::default());
        let mut out = match packed["mode"].as_str()? {
            "ATTRIBUTES" => m::decode_vertex_buffer(count, stride, bytes, &mut w),
            "TRIANGLES" => m::decode_index_buffer(count, stride, bytes, &mut w),
            _ => m::decode_index_sequence(count, stride, bytes, &mut w),
        }
        .ok()?;
        match packed["filter"].as_str().unwrap_or("NONE") {
            "OCTAHEDRAL" => m::decode_filter_oct(&mut out, count, stride, &mut w),
            "QUATERNION" => m::decode_filter_quat(&mut out, count, stride, &mut w),
            "EXPONENTIAL" => m::decode_filter_exp(&mut out, count, stride, &mut w),
            "COLOR" => m::decode_filter_color(&mut out, count, stride, &mut w),
            _ => Ok(()),
        }
        .ok()?;
        Some(out)
    }

    /// The elements of an accessor. `None` if it is broken.
    pub fn elements(&self, accessor: &Value) -> Option<Elements> {
        let accessor = &self.json["accessors"][number(accessor)?];
        let (component, kind) = (number(&accessor["componentType"])? as u64, accessor["type"].as_str()?.to_owned());
        let width_of = |component: u64| [1, 1, 2, 2].get(component as usize - 5120).copied().unwrap_or(4);
        let width = width_of(component);
        let components = ["SCALAR", "VEC2", "VEC3", "VEC4"].iter().position(|k| *k == kind).map_or(16, |at| at + 1);
        let (size, count) = (width * components, number(&accessor["count"])?);
        let rows = |view: usize, offset: usize, size: usize, count: usize| -> Option<Vec<Vec<u8>>> {
            let bytes = self.view(view)?;
            let stride = number(&self.json["bufferViews"][view]["byteStride"]).unwrap_or(size);
            (0..count).map(|i| bytes.get(offset + i * stride..offset + i * stride + size).map(<[u8]>::to_vec)).collect()
        };
        let mut bytes = match number(&accessor["bufferView"]) {
            Some(view) => rows(view, number(&accessor["byteOffset"]).unwrap_or(0), size, count)?,
            None => vec![vec![0; size]; count],
        };
        if let Some(sparse) = accessor.get("sparse") {
            let (at, values, count) = (&sparse["indices"], &sparse["values"], number(&sparse["count"])?);
            let wide = width_of(number(&at["componentType"])? as u64);
            let offset = |of: &Value| number(&of["byteOffset"]).unwrap_or(0);
            let indices = rows(number(&at["bufferView"])?, offset(at), wide, count)?;
            for (i, value) in indices.iter().zip(rows(number(&values["bufferView"])?, offset(values), size, count)?) {
                let index = i.iter().rev().fold(0usize, |n, b| n << 8 | usize::from(*b));
                *bytes.get_mut(index)? = value;
            }
        }
        let normalized = accessor["normalized"] == true;
        let of = |x: f32, one: f32| f64::from(if normalized { x / one } else { x });
        let value = |b: &[u8]| match component {
            5120 => of(f32::from(b[0] as i8), 127.0),
            5121 => of(f32::from(b[0]), 255.0),
            5122 => of(f32::from(i16::from_le_bytes([b[0], b[1]])), 32767.0),
            5123 => of(f32::from(u16::from_le_bytes([b[0], b[1]])), 65535.0),
            5125 => f64::from(u32::from_le_bytes([b[0], b[1], b[2], b[3]])),
            _ => f64::from(f32::from_le_bytes([b[0], b[1], b[2], b[3]])),
        };
        let values = bytes.iter().map(|element| element.chunks(width).map(value).collect()).collect();
        Some(Elements { bytes, values, kind: (component, kind, normalized) })
    }

    /// The triangles of a primitive.
    pub fn triangles(&self, primitive: &Value) -> Vec<[usize; 3]> {
        let count = self.elements(&primitive["attributes"]["POSITION"]).map_or(0, |e| e.bytes.len());
        let c: Vec<usize> = match primitive.get("indices") {
            Some(indices) => {
                self.elements(indices).map_or(Vec::new(), |e| e.values.iter().map(|v| v[0] as usize).collect())
            }
            None => (0..count).collect(),
        };
        match number(&primitive["mode"]).unwrap_or(4) {
            4 => c.as_chunks::<3>().0.to_vec(),
            5 => (0..c.len().saturating_sub(2)).map(|i| [c[i], c[i + 1 + i % 2], c[i + 2 - i % 2]]).collect(),
            6 => (0..c.len().saturating_sub(2)).map(|i| [c[i + 1], c[i + 2], c[0]]).collect(),
            _ => Vec::new(),
        }
    }

    /// The mesh of each node that has one, with the node's world matrix.
    fn shown(&self) -> Vec<(usize, &Value, DMat4)> {
        let nodes = list(&self.json["nodes"]);
        let mut parent = vec![None; nodes.len()];
        for (i, node) in nodes.iter().enumerate() {
            list(&node["children"]).iter().filter_map(number).for_each(|child| parent[child] = Some(i));
        }
        let world = |mut node: usize| {
            let mut matrix = local(&nodes[node]);
            while let Some(up) = parent[node] {
                matrix = local(&nodes[up]) * matrix;
                node = up;
            }
            matrix
        };
        let mesh = |(i, node): (usize, &Value)| Some((i, &self.json["meshes"][number(&node["mesh"])?], world(i)));
        nodes.iter().enumerate().filter_map(mesh).collect()
    }
}

fn uri_bytes(folder: &Path, uri: &str) -> Option<Vec<u8>> {
    if let Some((head, data)) = uri.strip_prefix("data:").and_then(|rest| rest.split_once(',')) {
        assert!(head.ends_with(";base64"), "{head}");
        return base64::prelude::BASE64_STANDARD.decode(data).ok();
    }
    let path = percent_encoding::percent_decode_str(uri).decode_utf8().ok()?.into_owned();
    std::fs::read(folder.join(path)).ok()
}

fn local(node: &Value) -> DMat4 {
    let numbers = |key: &str, default: &[f64]| -> Vec<f64> {
        let given: Vec<f64> = list(&node[key]).iter().filter_map(Value::as_f64).collect();
        if given.is_empty() { default.to_vec() } else { given }
    };
    let m = numbers("matrix", &[]);
    if m.len() == 16 {
        return DMat4::from_cols_slice(&m);
    }
    let of = |key: &str, default: [f64; 3]| DVec3::from_slice(&numbers(key, &default));
    let rotation = DQuat::from_slice(&numbers("rotation", &[0.0, 0.0, 0.0, 1.0]));
    DMat4::from_scale_rotation_translation(of("scale", [1.0; 3]), rotation, of("translation", [0.0; 3]))
}

const INSTANCING: &str = "EXT_mesh_gpu_instancing";

/// The parts of a file that no dent concerns, without indices of accessors and views.
fn rest(json: &Value) -> Value {
    let mut out = json.clone();
    for key in ["accessors", "bufferViews", "buffers", "meshes", "images", "animations"] {
        out.as_object_mut().unwrap().shift_remove(key);
    }
    for node in out["nodes"].as_array_mut().into_iter().flatten().filter_map(Value::as_object_mut) {
        node.shift_remove("mesh");
        node.shift_remove("weights");
        node.get_mut("extensions").and_then(Value::as_object_mut).map(|e| e.shift_remove(INSTANCING));
    }
    for skin in out["skins"].as_array_mut().into_iter().flatten().filter_map(Value::as_object_mut) {
        skin.shift_remove("inverseBindMatrices");
    }
    for key in ["extensionsUsed", "extensionsRequired"] {
        let kept: Vec<Value> =
            list(&out[key]).iter().filter(|e| !e.as_str().unwrap_or_default().contains("meshopt")).cloned().collect();
        out[key] = kept.into();
    }
    out
}

/// Compares a file, whose pictures are in `folder`, with what became of it.
pub fn compare(source: &Path, folder: &Path, output: &Path) -> Report {
    let (before, after) = (File::open_in(source, folder), File::open(output));
    let mut report = Report::default();
    let mut differ = |what: String| report.differences.push(what);
    if rest(&before.json) != rest(&after.json) {
        let (a, b) = (rest(&before.json), rest(&after.json));
        let keys = a.as_object().unwrap().keys().filter(|key| a[*key] != b[*key]);
        differ(format!("JSON: {}", keys.cloned().collect::<Vec<_>>().join(", ")));
    }
    if before.other_chunks != after.other_chunks {
        differ("chunks of the GLB".into());
    }
    for (a, b) in list(&before.json["nodes"]).iter().zip(list(&after.json["nodes"])) {
        let places = |file: &File, node: &Value| {
            let attributes = node["extensions"][INSTANCING]["attributes"].as_object().cloned().unwrap_or_default();
            attributes
                .into_iter()
                .map(|(key, accessor)| (key, file.elements(&accessor).map(|e| e.bytes)))
                .collect::<Vec<_>>()
        };
        if places(&before, a) != places(&after, b) {
            differ("instances".into());
        }
    }
    images(&before, &after, &mut differ);
    for (a, b) in list(&before.json["skins"]).iter().zip(list(&after.json["skins"])) {
        let key = "inverseBindMatrices";
        if before.elements(&a[key]) != after.elements(&b[key]) {
            differ("inverse bind matrices".into());
        }
    }
    animations(&before, &after, &mut differ);
    let pairs: Vec<_> = before.shown().into_iter().zip(after.shown()).collect();
    let near = reached(&before, &after, &pairs);
    for ((node, a, world), (_, b, _)) in &pairs {
        let name = format!("node {node}");
        let (parts_a, parts_b) = (list(&a["primitives"]), list(&b["primitives"]));
        if parts_a.len() != parts_b.len() || a["name"] != b["name"] {
            report.differences.push(format!("{name}: another number of primitives or another name"));
        }
        for (i, (p, q)) in parts_a.iter().zip(parts_b).enumerate() {
            let weights = before.json["nodes"][*node].get("weights").unwrap_or(&a["weights"]);
            let shown = shown(&before, p, weights);
            primitive(
                (&before, &after),
                (p, q),
                &format!("{name}, primitive {i}"),
                (world, &near, &shown),
                &mut report,
            );
        }
    }
    report
}

/// The vertices that targets of a default weight change: they may be written into the shape.
fn shown(file: &File, primitive: &Value, weights: &Value) -> HashSet<usize> {
    let shown = list(&primitive["targets"]).iter().zip(list(weights)).filter(|(_, w)| w.as_f64() != Some(0.0));
    let accessors = shown.flat_map(|(target, _)| target.as_object().unwrap().values());
    let elements = accessors.filter_map(|accessor| file.elements(accessor));
    elements
        .flat_map(|e| (0..e.values.len()).filter(move |v| e.values[*v].iter().any(|x| *x != 0.0)).collect::<Vec<_>>())
        .collect()
}

fn images(before: &File, after: &File, differ: &mut dyn FnMut(String)) {
    for (i, (a, b)) in list(&before.json["images"]).iter().zip(list(&after.json["images"])).enumerate() {
        let bytes = |file: &File, image: &Value| match image["uri"].as_str() {
            Some(uri) if uri.starts_with("data:") || !uri.contains("..") => uri_bytes(&file.folder, uri),
            Some(_) => None,
            None => file.view(number(&image["bufferView"])?),
        };
        let same = match (bytes(before, a), bytes(after, b)) {
            (Some(a), Some(b)) => a == b,
            _ => a["uri"] == b["uri"],
        };
        if !same {
            differ(format!("image {i}"));
        }
    }
}

/// Channels that are left play the same. Those that animate weights have other lists of them.
fn animations(before: &File, after: &File, differ: &mut dyn FnMut(String)) {
    for b in list(&after.json["animations"]) {
        let same = |a: &&Value| a["name"] == b["name"];
        let Some(a) = list(&before.json["animations"]).iter().find(same) else {
            differ(format!("a new animation {}", b["name"]));
            continue;
        };
        for channel in list(&b["channels"]).iter().filter(|c| c["target"]["path"] != "weights") {
            let twin = list(&a["channels"]).iter().find(|c| c["target"] == channel["target"]);
            let play = |file: &File, animation: &Value, channel: &Value| {
                let sampler = &animation["samplers"][number(&channel["sampler"])?];
                Some((
                    file.elements(&sampler["input"])?,
                    file.elements(&sampler["output"])?,
                    sampler["interpolation"].clone(),
                ))
            };
            let same = twin.is_some_and(|twin| play(before, a, twin) == play(after, b, channel));
            if !same {
                differ(format!("a channel of {}", b["name"]));
            }
        }
    }
}

type Place = [i64; 3];
type Pair<'f> = ((usize, &'f Value, DMat4), (usize, &'f Value, DMat4));

/// Where a vertex stands in the scene, to a thousandth of a millimetre for a body of a metre.
fn place(world: &DMat4, p: &[f64]) -> Place {
    world.transform_point3(DVec3::from_slice(p)).to_array().map(|x| (x * 1e5).round() as i64)
}

/// The places of all vertices of triangles with a corner that moved: their normals may turn.
fn reached(before: &File, after: &File, pairs: &[Pair<'_>]) -> HashSet<Place> {
    let mut moved: HashSet<Place> = HashSet::new();
    let mut triangles: Vec<[Place; 3]> = Vec::new();
    for ((_, a, world), (_, b, _)) in pairs {
        for (p, q) in list(&a["primitives"]).iter().zip(list(&b["primitives"])) {
            let elements = |file: &File, p: &Value| file.elements(&p["attributes"]["POSITION"]);
            let (Some(old), Some(new)) = (elements(before, p), elements(after, q)) else { continue };
            let places: Vec<Place> = old.values.iter().map(|v| place(world, v)).collect();
            let changed = (0..places.len()).filter(|v| old.values[*v] != new.values[*v]);
            moved.extend(changed.map(|v| places[v]));
            triangles.extend(before.triangles(p).into_iter().map(|t| t.map(|v| places[v])));
        }
    }
    triangles.into_iter().filter(|t| t.iter().any(|v| moved.contains(v))).flatten().collect()
}

fn primitive(
    (before, after): (&File, &File),
    (a, b): (&Value, &Value),
    name: &str,
    (world, near, shown): (&DMat4, &HashSet<Place>, &HashSet<usize>),
    report: &mut Report,
) {
    let mut differ = |what: String| report.differences.push(format!("{name}: {what}"));
    if a["mode"] != b["mode"] || a["material"] != b["material"] || a["extensions"] != b["extensions"] {
        differ("mode, material or extensions".into());
    }
    let indices = |file: &File, p: &Value| file.elements(&p["indices"]).map(|e| e.values);
    if indices(before, a) != indices(after, b) {
        differ("indices".into());
    }
    let keys =
        |p: &Value| p["attributes"].as_object().map(|m| m.keys().cloned().collect::<Vec<_>>()).unwrap_or_default();
    if keys(a) != keys(b) {
        differ(format!("attributes {:?} became {:?}", keys(a), keys(b)));
        return;
    }
    targets((before, after), (a, b), &mut differ);
    let read = |file: &File, p: &Value, key: &str| file.elements(&p["attributes"][key]);
    let (Some(old), Some(new)) = (read(before, a, "POSITION"), read(after, b, "POSITION")) else { return };
    let is_surface = number(&a["mode"]).unwrap_or(4) >= 4;
    let moved = |v: usize| old.values[v] != new.values[v];
    for key in keys(a) {
        let (Some(x), Some(y)) = (read(before, a, &key), read(after, b, &key)) else { continue };
        let is_direction = key == "NORMAL" || key == "TANGENT";
        let odd = |v: usize| {
            let e = &x.values[v];
            is_direction && shown.contains(&v)
                || !e.iter().all(|c| c.is_finite())
                || is_direction && e[..3].iter().all(|c| *c == 0.0)
        };
        let turned = |v: usize| is_direction && near.contains(&place(world, &old.values[v]));
        // Positions that were quantised may be floats, but of the same values.
        let same = |v: usize| if x.kind == y.kind { x.bytes[v] == y.bytes[v] } else { x.values[v] == y.values[v] };
        let wrong = (0..x.values.len())
            .filter(|v| !(moved(*v) && (is_direction || key == "POSITION") || turned(*v) || odd(*v)));
        let wrong: Vec<usize> = wrong.filter(|v| !same(*v)).collect();
        if x.values.len() != y.values.len() || x.kind != y.kind && key != "POSITION" || !wrong.is_empty() {
            differ(format!("{key} of {} vertices that no dent reached, such as {:?}", wrong.len(), wrong.first()));
        }
        if !y.values.iter().flatten().all(|c| c.is_finite()) {
            differ(format!("{key} has numbers that are none"));
        }
    }
    if is_surface {
        report.vertices += old.values.len();
        report.moved += (0..old.values.len()).filter(|v| moved(*v)).count();
    }
}

/// Targets that are left are those of the same name, unchanged.
fn targets((before, after): (&File, &File), (a, b): (&Value, &Value), differ: &mut dyn FnMut(String)) {
    let resolved = |file: &File, target: &Value| -> HashMap<String, Option<Vec<Vec<u8>>>> {
        let one = |(key, accessor): (&String, &Value)| (key.clone(), file.elements(accessor).map(|e| e.bytes));
        target.as_object().into_iter().flatten().map(one).collect()
    };
    let all: Vec<_> = list(&a["targets"]).iter().map(|t| resolved(before, t)).collect();
    for (i, target) in list(&b["targets"]).iter().enumerate() {
        if !all.contains(&resolved(after, target)) {
            differ(format!("target {i}"));
        }
    }
}

/// A value of the file by a pointer; `{n}` after the pointer of an accessor's index is the n-th element.
pub fn at(file: &File, pointer: &str) -> Value {
    match pointer.split_once('{') {
        None => file.json.pointer(pointer).cloned().unwrap_or(Value::Null),
        Some((pointer, element)) => {
            let element: usize = element.trim_end_matches('}').parse().unwrap();
            let elements = file.json.pointer(pointer).and_then(|accessor| file.elements(accessor));
            elements.map_or(Value::Null, |e| json!(e.values[element]))
        }
    }
}
