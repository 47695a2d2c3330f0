//! Merges all buffers into the GLB's one and drops what nothing uses any more.

use super::vertices::Rewrite;
use crate::base::error::Error;
use crate::io::glb::{Glb, container, list_mut, remove_within};
use crate::io::import::document::Document;
use crate::io::import::{meshopt, whole};
use ::gltf::json::Index;
use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use serde_json::{Value, json};

/// Extensions (by name or by prefix ending in `_`) that do not refer to bufferViews, and whose references to accessors
/// are handled here.
const KNOWN: &[&str] = &[
    "KHR_materials_",
    "KHR_texture_",
    "EXT_texture_",
    "MSFT_texture_dds",
    "KHR_lights_punctual",
    "KHR_animation_pointer",
    "KHR_node_visibility",
    "KHR_xmp",
    "KHR_xmp_json_ld",
    "KHR_mesh_quantization",
    "EXT_meshopt_compression",
    "KHR_meshopt_compression",
    "EXT_mesh_gpu_instancing",
    "GODOT_single_root",
];

/// Offsets in a buffer keep their remainder modulo this, so that aligned data stays aligned.
const ALIGNMENT: usize = 16;

/// Which accessors are used, and which bufferViews an accessor or image uses.
struct Used {
    accessors: Vec<bool>,
    views: Vec<bool>,
    /// False if a reference is out of range; then nothing is renumbered.
    sound: bool,
}

impl Used {
    fn of(root: &Value) -> Self {
        // The walk needs mutable references, since renumbering uses the same walk.
        let mut root = root.clone();
        let count = |root: &Value, key: &str| vec![false; root[key].as_array().map_or(0, Vec::len)];
        let (mut accessors, mut views, mut sound) = (count(&root, "accessors"), count(&root, "bufferViews"), true);
        let mut mark = |list: &mut Vec<bool>, index: &Value| match whole(index).and_then(|i| list.get_mut(i as usize)) {
            Some(slot) => *slot = true,
            None => sound = false,
        };
        accessor_references(&mut root, &mut |index| mark(&mut accessors, index));
        view_references(&mut root, &mut |index| mark(&mut views, index));
        Self { accessors, views, sound }
    }
}

/// Writes the file. The bufferViews that are not the document's are in the binary chunk.
pub(super) fn write(Rewrite { doc, glb: Glb { root, bin: new }, notes }: &mut Rewrite<'_>) -> Result<Vec<u8>, Error> {
    let before = Used::of(&doc.value);
    if before.sound && extensions_known(root) {
        let mut packed = root.clone();
        // If a view is broken, that of another mesh, nothing is moved.
        if let Ok(bin) = pack(doc, &mut packed, new, &before) {
            return container(&packed, &bin, &doc.chunks);
        }
    }
    let bin = append(doc, root, new, notes)?;
    container(root, &bin, &doc.chunks)
}

/// Keeps every buffer's index and content, and appends the new data to buffer 0. No reference needs to change. A buffer that cannot
/// be read keeps its uri.
fn append(doc: &Document<'_>, root: &mut Value, new: &[u8], notes: &mut Vec<String>) -> Result<Vec<u8>, Error> {
    let data_uri =
        |bytes: &[u8]| Value::from(format!("data:application/octet-stream;base64,{}", STANDARD.encode(bytes)));
    let count = doc.buffers.len();
    let first = if count == 0 { Some(&[][..]) } else { doc.buffer(0).ok() };
    for (i, buffer) in doc.buffers.iter().enumerate().skip(usize::from(first.is_some())) {
        let Some(uri) = buffer.and_then(|buffer| buffer.uri.as_deref()).filter(|uri| !uri.starts_with("data:")) else {
            continue;
        };
        match doc.buffer(i) {
            Ok(bytes) => root["buffers"][i]["uri"] = data_uri(bytes),
            Err(error) => notes.push(format!("buffer {i}, '{uri}', cannot be embedded and keeps its uri: {error}")),
        }
    }
    let Some(first) = first else {
        // The binary chunk is buffer 0, which is elsewhere.
        root["buffers"].as_array_mut().into_iter().for_each(|list| {
            list.push(json!({ "byteLength": new.len(), "uri": data_uri(new) }));
        });
        place(doc, root, count, 0);
        return Ok(Vec::new());
    };
    let mut bin = first.to_vec();
    bin.resize(bin.len().next_multiple_of(ALIGNMENT), 0);
    place(doc, root, 0, bin.len());
    bin.extend_from_slice(new);
    if count == 0 {
        root["buffers"] = json!([{}]);
    }
    root["buffers"][0]["byteLength"] = bin.len().into();
    root["buffers"][0].as_object_mut().map(|b| b.shift_remove("uri"));
    Ok(bin)
}

/// Moves the views of new data to `start` in a buffer.
fn place(doc: &Document<'_>, root: &mut Value, buffer: usize, start: usize) {
    for view in list_mut(root, "bufferViews").skip(doc.views.len()) {
        view["buffer"] = buffer.into();
        view["byteOffset"] = (start as u64 + whole(&view["byteOffset"]).unwrap_or(0)).into();
    }
}

/// Drops what the change made unused, and moves the rest into one buffer.
fn pack(doc: &Document<'_>, root: &mut Value, new: &[u8], before: &Used) -> Result<Vec<u8>, Error> {
    let after = Used::of(root);
    let keeps = |before: &[bool], after: &[bool]| -> Vec<bool> {
        after.iter().enumerate().map(|(i, used)| *used || !before.get(i).copied().unwrap_or(false)).collect()
    };
    let accessors = keeps(&before.accessors, &after.accessors);
    accessor_references(root, &mut renumber(&accessors));
    retain(root.get_mut("accessors"), &accessors);
    // Only now that the accessors are gone is it known which views are used.
    let views = keeps(&before.views, &Used::of(root).views);
    view_references(root, &mut renumber(&views));
    let bin = gather(doc, root, new, &views)?;
    retain(root.get_mut("bufferViews"), &views);
    root["buffers"] = json!([{ "byteLength": bin.len() }]);
    for key in ["accessors", "bufferViews"] {
        if root[key].as_array().is_some_and(Vec::is_empty) {
            root.as_object_mut().map(|r| r.shift_remove(key));
        }
    }
    Ok(bin)
}

/// Copies the bytes of the kept views, each byte once even where views overlap. What meshoptimizer packed is unpacked.
fn gather(doc: &Document<'_>, root: &mut Value, new: &[u8], keep: &[bool]) -> Result<Vec<u8>, Error> {
    let (mut plain, mut packed) = (Vec::new(), Vec::new());
    for i in (0..doc.views.len()).filter(|i| keep[*i]) {
        let extensions = root["bufferViews"][i].get("extensions");
        if extensions.is_some_and(|e| meshopt::EXTENSIONS.iter().any(|name| e.get(name).is_some())) {
            packed.push(i);
            continue;
        }
        let view = doc.views.get(i, "bufferView")?;
        let (buffer, start) = (view.buffer.value(), view.byte_offset.map_or(0, |o| o.0));
        let bytes = doc.bytes(buffer, start, view.byte_length.0, &format!("bufferView {i}"))?;
        // It lies within the buffer.
        plain.push((buffer, start as usize, start as usize + bytes.len(), i));
    }
    plain.sort_unstable();
    let mut bin: Vec<u8> = Vec::new();
    // The stretch of a buffer that was copied last, and where it is now.
    let (mut copied, mut at) = ((usize::MAX, 0..0), 0);
    for (buffer, start, end, view) in plain {
        if copied.0 != buffer || start > copied.1.end {
            at = bin.len().next_multiple_of(ALIGNMENT) + start % ALIGNMENT;
            bin.resize(at, 0);
            copied = (buffer, start..start);
        }
        let known = copied.1.end;
        bin.extend_from_slice(doc.buffer(buffer)?.get(known..end).unwrap_or_default());
        copied.1.end = known.max(end);
        root["bufferViews"][view]["buffer"] = 0.into();
        root["bufferViews"][view]["byteOffset"] = (at + start - copied.1.start).into();
    }
    for view in &packed {
        bin.resize(bin.len().next_multiple_of(ALIGNMENT), 0);
        let (bytes, _) = doc.view(Index::new(*view as u32), "a kept view")?;
        let json = &mut root["bufferViews"][*view];
        (json["buffer"], json["byteOffset"]) = (0.into(), bin.len().into());
        if let Some(json) = json.as_object_mut() {
            remove_within(json, "extensions", &meshopt::EXTENSIONS);
        }
        bin.extend_from_slice(bytes);
    }
    // Nothing refers to packed data any more.
    for key in ["extensionsUsed", "extensionsRequired"] {
        let Some(list) = root.get_mut(key).and_then(Value::as_array_mut) else { continue };
        list.retain(|name| !meshopt::EXTENSIONS.iter().any(|packed| name == packed));
        if list.is_empty() {
            root.as_object_mut().map(|r| r.shift_remove(key));
        }
    }
    bin.resize(bin.len().next_multiple_of(ALIGNMENT), 0);
    place(doc, root, 0, bin.len());
    bin.extend_from_slice(new);
    Ok(bin)
}

/// Returns a function that changes an old index into the index among the elements kept.
pub(super) fn renumber(keep: &[bool]) -> impl FnMut(&mut Value) + use<> {
    let mut next = 0usize;
    let new: Vec<usize> = keep
        .iter()
        .map(|k| {
            next += usize::from(*k);
            next - usize::from(*k)
        })
        .collect();
    move |index| {
        if let Some(new) = whole(index).and_then(|i| new.get(i as usize)) {
            *index = (*new).into();
        }
    }
}

fn retain(list: Option<&mut Value>, keep: &[bool]) {
    let mut keep = keep.iter();
    if let Some(list) = list.and_then(Value::as_array_mut) {
        list.retain(|_| *keep.next().unwrap_or(&true));
    }
}

fn accessor_references(root: &mut Value, visit: &mut dyn FnMut(&mut Value)) {
    for primitive in list_mut(root, "meshes").flat_map(|m| list_mut(m, "primitives")) {
        values_mut(primitive.get_mut("attributes")).for_each(&mut *visit);
        primitive.get_mut("indices").into_iter().for_each(&mut *visit);
        list_mut(primitive, "targets").flat_map(|t| values_mut(Some(t))).for_each(&mut *visit);
    }
    for node in list_mut(root, "nodes") {
        let instances = node.get_mut("extensions").and_then(|e| e.get_mut("EXT_mesh_gpu_instancing"));
        values_mut(instances.and_then(|i| i.get_mut("attributes"))).for_each(&mut *visit);
    }
    for skin in list_mut(root, "skins") {
        skin.get_mut("inverseBindMatrices").into_iter().for_each(&mut *visit);
    }
    for sampler in list_mut(root, "animations").flat_map(|a| list_mut(a, "samplers")) {
        sampler.get_mut("input").into_iter().for_each(&mut *visit);
        sampler.get_mut("output").into_iter().for_each(&mut *visit);
    }
}

fn view_references(root: &mut Value, visit: &mut dyn FnMut(&mut Value)) {
    for accessor in list_mut(root, "accessors") {
        accessor.get_mut("bufferView").into_iter().for_each(&mut *visit);
        for key in ["indices", "values"] {
            let sparse = accessor.get_mut("sparse").and_then(|s| s.get_mut(key));
            sparse.and_then(|s| s.get_mut("bufferView")).into_iter().for_each(&mut *visit);
        }
    }
    for image in list_mut(root, "images") {
        image.get_mut("bufferView").into_iter().for_each(&mut *visit);
    }
}

fn values_mut(object: Option<&mut Value>) -> impl Iterator<Item = &mut Value> {
    object.and_then(Value::as_object_mut).into_iter().flat_map(|o| o.values_mut())
}

/// Whether all extensions of the file, listed or not, are known not to refer to anything that might be dropped.
fn extensions_known(root: &Value) -> bool {
    let known = |name: &str| KNOWN.iter().any(|k| *k == name || (k.ends_with('_') && name.starts_with(k)));
    let listed = root["extensionsUsed"].as_array().into_iter().flatten().filter_map(Value::as_str).all(known);
    listed && extensions_within(root, &known)
}

fn extensions_within(value: &Value, known: &dyn Fn(&str) -> bool) -> bool {
    match value {
        Value::Array(list) => list.iter().all(|v| extensions_within(v, known)),
        Value::Object(map) => map.iter().all(|(key, v)| match (key.as_str(), v) {
            ("extras", _) => true,
            ("extensions", Value::Object(names)) => {
                names.iter().all(|(name, v)| known(name) && extensions_within(v, known))
            }
            _ => extensions_within(v, known),
        }),
        _ => true,
    }
}
