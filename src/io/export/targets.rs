//! Removes the morph targets that are dents. Other targets keep their weights, names and animation.

use super::animations::{self, Keep, Kept};
use crate::io::glb::{Blob, list_mut, remove_within};
use crate::io::import::document::Document;
use serde_json::{Map, Value};

/// Removes the other targets, with what describes them.
pub(super) fn drop(doc: &Document<'_>, root: &mut Value, blob: &mut Blob, kept: &Kept) {
    for (mesh, keep) in &kept.meshes {
        let mesh = &mut root["meshes"][*mesh];
        for primitive in list_mut(mesh, "primitives").filter_map(Value::as_object_mut) {
            retain(primitive, "targets", keep);
            names(primitive, keep);
        }
        if let Some(mesh) = mesh.as_object_mut() {
            retain(mesh, "weights", keep);
            names(mesh, keep);
            remove_within(mesh, "extras", &["impacts", "placements"]);
            // It still says of the others that they are none.
            if !keep.contains(&true) {
                remove_within(mesh, "extras", &["dents"]);
            }
        }
    }
    for (node, keep) in &kept.nodes {
        root["nodes"][*node].as_object_mut().into_iter().for_each(|node| retain(node, "weights", keep));
    }
    animations::filter(doc, root, blob, kept);
}

fn names(owner: &mut Map<String, Value>, keep: &Keep) {
    if let Some(extras) = owner.get_mut("extras").and_then(Value::as_object_mut) {
        retain(extras, "targetNames", keep);
        if extras.is_empty() {
            owner.shift_remove("extras");
        }
    }
}

/// Keeps some elements of a list, and removes the list if none is left.
fn retain(owner: &mut Map<String, Value>, key: &str, keep: &Keep) {
    let Some(list) = owner.get_mut(key).and_then(Value::as_array_mut) else { return };
    let mut keep = keep.iter();
    list.retain(|_| *keep.next().unwrap_or(&false));
    if list.is_empty() {
        owner.shift_remove(key);
    }
}
