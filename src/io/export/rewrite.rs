//! Replaces one mesh's vertices in a glTF and removes its morph targets, by editing the JSON.

use super::compact;
use super::glb::{Blob, container, list_mut, push_attribute, push_view};
use super::vertices::Vertices;
use crate::base::error::Error;
use crate::io::import::document::Document;
use crate::io::import::gltf::{Part, choose, parts};
use crate::io::import::uri::{self, UriTarget};
use crate::io::import::{MeshChoice, unsupported};
use serde_json::{Map, Value};
use std::collections::HashMap;
use std::path::Path;

pub(super) fn deformed<'v>(
    source: &[u8],
    base_dir: Option<&Path>,
    mesh: MeshChoice<'_>,
    vertices: impl FnOnce(usize) -> Result<Vertices<'v>, Error>,
) -> Result<Vec<u8>, Error> {
    let doc = Document::parse(source, base_dir)?;
    let mesh = choose(&doc, mesh)?;
    let parts = parts(&doc, mesh)?;
    let vertices = vertices(parts.iter().filter(|p| p.owns_vertices).map(|p| p.vertex_count).sum())?;
    let used_before = compact::Used::of(&doc.value);
    let mut root = doc.value.clone();
    let mut blob = Blob::default();
    let old_views = doc.root.buffer_views.len();
    replace_vertices(&mut root, &mut blob, mesh, &parts, vertices);
    drop_targets(&mut root, mesh);
    drop_weight_animations(&mut root, mesh);
    embed_images(&doc, &mut root, &mut blob)?;
    let bin = compact::lay_out(&doc, &mut root, blob, old_views, used_before)?;
    container(&root, &bin)
}

/// Gives the mesh's primitives new accessors. The old ones stay for other users.
fn replace_vertices(root: &mut Value, blob: &mut Blob, mesh: usize, parts: &[Part<'_>], vertices: Vertices<'_>) {
    let mut known: HashMap<usize, Vec<(&str, usize)>> = HashMap::new();
    for part in parts {
        let own = part.first_vertex..part.first_vertex + part.vertex_count;
        let accessors = known.entry(part.first_vertex).or_insert_with(|| {
            let mut list = vec![("POSITION", push_attribute(root, blob, &vertices.positions[own.clone()], true))];
            list.extend(vertices.normals.map(|n| ("NORMAL", push_attribute(root, blob, &n[own.clone()], false))));
            list.extend(vertices.tangents.map(|t| ("TANGENT", push_attribute(root, blob, &t[own.clone()], false))));
            list
        });
        for (semantic, accessor) in accessors {
            root["meshes"][mesh]["primitives"][part.index]["attributes"][*semantic] = (*accessor).into();
        }
    }
}

fn drop_targets(root: &mut Value, mesh: usize) {
    for primitive in list_mut(&mut root["meshes"][mesh], "primitives") {
        if let Some(primitive) = primitive.as_object_mut() {
            primitive.shift_remove("targets");
            remove_within(primitive, "extras", &["targetNames"]);
            // An optional compressed copy of the vertices would take precedence over the new ones.
            remove_within(primitive, "extensions", &["KHR_draco_mesh_compression"]);
        }
    }
    if let Some(mesh) = root["meshes"][mesh].as_object_mut() {
        mesh.shift_remove("weights");
        remove_within(mesh, "extras", &["targetNames", "impacts", "placements"]);
    }
    for node in list_mut(root, "nodes").filter(|n| shows(n, mesh)) {
        node.as_object_mut().map(|n| n.shift_remove("weights"));
    }
}

/// Removes keys from an object in `parent`, and the object itself if that leaves it empty.
fn remove_within(parent: &mut Map<String, Value>, object: &str, keys: &[&str]) {
    let Some(inner) = parent.get_mut(object).and_then(Value::as_object_mut) else { return };
    let removed = keys.iter().filter(|key| inner.shift_remove(**key).is_some()).count();
    if removed > 0 && inner.is_empty() {
        parent.shift_remove(object);
    }
}

/// Removes channels that animate the weights, samplers that only they used, and animations that are then empty.
fn drop_weight_animations(root: &mut Value, mesh: usize) {
    let nodes: Vec<bool> = root["nodes"].as_array().into_iter().flatten().map(|n| shows(n, mesh)).collect();
    let moves_weights = |channel: &Value| {
        let target = &channel["target"];
        let node = |i: u64| nodes.get(i as usize).copied().unwrap_or(false);
        let pointer = target["extensions"]["KHR_animation_pointer"]["pointer"].as_str();
        match (target["path"].as_str(), pointer.map(|p| p.split('/').collect::<Vec<_>>()).as_deref()) {
            (Some("weights"), _) => target["node"].as_u64().is_some_and(node),
            (_, Some(["", "meshes", m, "weights", ..])) => m.parse() == Ok(mesh),
            (_, Some(["", "nodes", n, "weights", ..])) => n.parse().is_ok_and(node),
            _ => false,
        }
    };
    let Some(animations) = root.get_mut("animations").and_then(Value::as_array_mut) else { return };
    let mut emptied = Vec::new();
    for animation in animations.iter_mut() {
        let Some(channels) = animation.get_mut("channels").and_then(Value::as_array_mut) else {
            emptied.push(false);
            continue;
        };
        let before = channels.len();
        channels.retain(|c| !moves_weights(c));
        let changed = channels.len() < before;
        emptied.push(changed && channels.is_empty());
        if changed {
            drop_unused_samplers(animation);
        }
    }
    let mut emptied = emptied.into_iter();
    animations.retain(|_| !emptied.next().unwrap_or(false));
    if animations.is_empty() {
        root.as_object_mut().map(|r| r.shift_remove("animations"));
    }
}

fn drop_unused_samplers(animation: &mut Value) {
    let count = animation["samplers"].as_array().map_or(0, Vec::len);
    let mut used = vec![false; count];
    for channel in animation["channels"].as_array().into_iter().flatten() {
        match channel["sampler"].as_u64().and_then(|s| used.get_mut(s as usize)) {
            Some(slot) => *slot = true,
            // A channel without a sampler is an error of the file, so nothing is dropped.
            None => return,
        }
    }
    let mut keep = used.iter();
    if let Some(samplers) = animation.get_mut("samplers").and_then(Value::as_array_mut) {
        samplers.retain(|_| *keep.next().unwrap_or(&true));
    }
    let mut renumber = compact::renumber(&used);
    for channel in list_mut(animation, "channels") {
        channel.get_mut("sampler").into_iter().for_each(&mut renumber);
    }
}

/// Turns images in separate files into bufferViews. Images in `data:` URIs are in the file already.
fn embed_images(doc: &Document<'_>, root: &mut Value, blob: &mut Blob) -> Result<(), Error> {
    for i in 0..root["images"].as_array().map_or(0, Vec::len) {
        let what = format!("image {i}");
        let Some(uri) = root["images"][i]["uri"].as_str().map(str::to_owned) else { continue };
        let UriTarget::File(path) = uri::parse(&uri, &what)? else { continue };
        let bytes = doc.read_relative(&path, &what)?;
        let mime = media_type(&bytes, &path).ok_or_else(|| {
            unsupported(format!("{what}, '{path}', is no image that glTF knows (PNG, JPEG, WebP, AVIF, KTX2, DDS)"))
        })?;
        let view = push_view(root, blob, &bytes, None);
        if let Some(image) = root["images"][i].as_object_mut() {
            image.shift_remove("uri");
            image.insert("bufferView".into(), view.into());
            image.entry("mimeType").or_insert(mime.into());
            let stem = Path::new(&path).file_stem().unwrap_or_default().to_string_lossy();
            image.entry("name").or_insert(stem.into());
        }
    }
    Ok(())
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

fn shows(node: &Value, mesh: usize) -> bool {
    node["mesh"].as_u64() == Some(mesh as u64)
}
