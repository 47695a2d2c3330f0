//! Removes the morph targets that are dents. Other targets keep their weights, names and animation.

use super::compact;
use super::vertices::Rewrite;
use crate::io::glb::{list_mut, remove_within};
use crate::io::import::accessor::Accessor;
use crate::io::import::whole;
use ::gltf::json::Index;
use ::gltf::json::accessor::Type;
use serde_json::{Map, Value};
use std::collections::HashMap;

/// For each target of a mesh whether it stays.
type Keep = Vec<bool>;

/// What of the targets of meshes and of the nodes that show them stays. What is absent stays whole.
#[derive(Default)]
pub(super) struct Kept {
    pub meshes: HashMap<usize, Keep>,
    pub nodes: HashMap<usize, Keep>,
}

/// Removes the other targets, with what describes them.
pub(super) fn drop(to: &mut Rewrite<'_>, kept: &Kept) {
    let root = &mut to.glb.root;
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
    filter(to, kept);
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

/// Filters the channels that animate weights, and removes what they leave unused: samplers, and animations without channels.
fn filter(to: &mut Rewrite<'_>, kept: &Kept) {
    let Some(animations) = to.glb.root.get_mut("animations").and_then(Value::as_array_mut) else { return };
    let mut animations = std::mem::take(animations);
    animations.retain_mut(|animation| !filter_one(to, kept, animation));
    if animations.is_empty() {
        to.glb.root.as_object_mut().map(|r| r.shift_remove("animations"));
    } else {
        to.glb.root["animations"] = animations.into();
    }
}

/// What stays of the targets whose weights a channel animates, and the number of the weight if it is one. `None` if it animates none
/// that are dropped.
fn weights<'k>(channel: &Value, kept: &'k Kept) -> Option<(&'k Keep, Option<usize>)> {
    let target = &channel["target"];
    let of_node = |node: Option<u64>| kept.nodes.get(&(node? as usize));
    let pointer = target["extensions"]["KHR_animation_pointer"]["pointer"].as_str();
    let path: Option<Vec<&str>> = pointer.map(|pointer| pointer.split('/').collect());
    let (keep, one) = match (target["path"].as_str(), path.as_deref()) {
        (Some("weights"), _) => (of_node(whole(&target["node"])), None),
        (_, Some(["", "meshes", mesh, "weights", rest @ ..])) => (kept.meshes.get(&mesh.parse().ok()?), rest.first()),
        (_, Some(["", "nodes", node, "weights", rest @ ..])) => (of_node(node.parse().ok()), rest.first()),
        _ => return None,
    };
    Some((keep?, one.map(|text| text.parse().unwrap_or(usize::MAX))))
}

/// Returns whether nothing is left of the animation.
fn filter_one(to: &mut Rewrite<'_>, kept: &Kept, animation: &mut Value) -> bool {
    let Some(channels) = animation["channels"].as_array().cloned() else { return false };
    let before = channels.len();
    let mut filtered: HashMap<(u64, Keep), usize> = HashMap::new();
    let mut left = Vec::with_capacity(before);
    let mut changed = false;
    for mut channel in channels {
        match weights(&channel, kept) {
            None => {}
            Some((keep, one)) if !keep.contains(&true) || one.is_some_and(|one| keep.get(one) != Some(&true)) => {
                changed = true;
                continue;
            }
            Some((keep, Some(one))) => {
                let number = keep[..one].iter().filter(|k| **k).count();
                let pointer = &mut channel["target"]["extensions"]["KHR_animation_pointer"]["pointer"];
                let start = pointer.as_str().and_then(|p| p.rsplit_once('/')).map_or("", |(start, _)| start);
                *pointer = format!("{start}/{number}").into();
            }
            Some((keep, None)) => {
                changed = true;
                let Some(old) = whole(&channel["sampler"]) else { continue };
                let known = filtered.get(&(old, keep.clone())).copied();
                let new = known.or_else(|| filtered_sampler(to, animation, old as usize, keep));
                // Without a usable sampler there is nothing to play.
                let Some(new) = new else { continue };
                filtered.insert((old, keep.clone()), new);
                channel["sampler"] = new.into();
            }
        }
        left.push(channel);
    }
    let is_empty = left.is_empty() && before > 0 && changed;
    animation["channels"] = left.into();
    if changed {
        drop_unused_samplers(animation);
    }
    is_empty
}

/// Adds a sampler whose output has only the weights that stay.
fn filtered_sampler(to: &mut Rewrite<'_>, animation: &mut Value, old: usize, keep: &Keep) -> Option<usize> {
    let mut sampler = animation["samplers"].get(old)?.clone();
    let output = Index::new(u32::try_from(whole(&sampler["output"])?).ok()?);
    let values = Accessor::new(to.doc, output, "animated weights", Type::Scalar).ok()?.values::<1>().ok()?;
    // The weights of all targets follow each other, for each key or each of its tangents.
    let left: Vec<[f32; 1]> =
        values.chunks(keep.len()).flat_map(|key| key.iter().zip(keep).filter(|(_, k)| **k).map(|(w, _)| *w)).collect();
    let accessor = to.glb.push_attribute(&left, false);
    // Only vertex attributes name a target.
    let view = whole(&to.glb.root["accessors"][accessor]["bufferView"])? as usize;
    to.glb.root["bufferViews"][view].as_object_mut()?.shift_remove("target");
    sampler["output"] = accessor.into();
    let samplers = animation["samplers"].as_array_mut()?;
    samplers.push(sampler);
    Some(samplers.len() - 1)
}

fn drop_unused_samplers(animation: &mut Value) {
    let count = animation["samplers"].as_array().map_or(0, Vec::len);
    let mut used = vec![false; count];
    for channel in animation["channels"].as_array().into_iter().flatten() {
        match whole(&channel["sampler"]).and_then(|s| used.get_mut(s as usize)) {
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
