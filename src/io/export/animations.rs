//! Removes the weights of dropped targets from animations.

use super::compact;
use crate::io::glb::{Blob, list_mut, push_attribute};
use crate::io::import::accessor::Accessor;
use crate::io::import::document::Document;
use crate::io::import::whole;
use ::gltf::json::Index;
use serde_json::Value;
use std::collections::HashMap;

/// For each target of a mesh whether it stays.
pub(super) type Keep = Vec<bool>;

/// What of the targets of meshes and of the nodes that show them stays. What is absent stays whole.
#[derive(Default)]
pub(super) struct Kept {
    pub meshes: HashMap<usize, Keep>,
    pub nodes: HashMap<usize, Keep>,
}

/// Filters the channels that animate weights, and removes what they leave unused: samplers, and animations without channels.
pub(super) fn filter(doc: &Document<'_>, root: &mut Value, blob: &mut Blob, kept: &Kept) {
    let count = root["animations"].as_array().map_or(0, Vec::len);
    let mut emptied = Vec::with_capacity(count);
    for i in 0..count {
        let animation = root["animations"][i].take();
        let mut animation = animation;
        emptied.push(filter_one(doc, root, blob, kept, &mut animation));
        root["animations"][i] = animation;
    }
    let Some(animations) = root.get_mut("animations").and_then(Value::as_array_mut) else { return };
    let mut emptied = emptied.into_iter();
    animations.retain(|_| !emptied.next().unwrap_or(false));
    if animations.is_empty() {
        root.as_object_mut().map(|r| r.shift_remove("animations"));
    }
}

/// What a channel does to weights.
enum Weights<'k> {
    /// Nothing, or to none that are dropped.
    Untouched,
    /// It animates all weights, of which these stay.
    All(&'k Keep),
    /// It animates one weight, which gets this number.
    One(usize),
    /// It animates nothing that stays.
    Dropped,
}

fn weights<'k>(channel: &Value, kept: &'k Kept) -> Weights<'k> {
    let target = &channel["target"];
    let of_node = |node: Option<u64>| node.and_then(|node| kept.nodes.get(&(node as usize)));
    let pointer = target["extensions"]["KHR_animation_pointer"]["pointer"].as_str();
    let path: Option<Vec<&str>> = pointer.map(|pointer| pointer.split('/').collect());
    let (keep, one) = match (target["path"].as_str(), path.as_deref()) {
        (Some("weights"), _) => (of_node(whole(&target["node"])), None),
        (_, Some(["", "meshes", mesh, "weights", rest @ ..])) => {
            (mesh.parse().ok().and_then(|mesh: usize| kept.meshes.get(&mesh)), rest.first())
        }
        (_, Some(["", "nodes", node, "weights", rest @ ..])) => (of_node(node.parse().ok()), rest.first()),
        _ => (None, None),
    };
    let Some(keep) = keep else { return Weights::Untouched };
    match one.map(|text| text.parse::<usize>().ok()) {
        _ if !keep.contains(&true) => Weights::Dropped,
        None => Weights::All(keep),
        Some(Some(one)) if keep.get(one) == Some(&true) => Weights::One(keep[..one].iter().filter(|k| **k).count()),
        Some(_) => Weights::Dropped,
    }
}

/// Returns whether nothing is left of the animation.
fn filter_one(doc: &Document<'_>, root: &mut Value, blob: &mut Blob, kept: &Kept, animation: &mut Value) -> bool {
    let Some(channels) = animation["channels"].as_array().cloned() else { return false };
    let before = channels.len();
    let mut filtered: HashMap<(u64, Keep), usize> = HashMap::new();
    let mut left = Vec::with_capacity(before);
    let mut changed = false;
    for mut channel in channels {
        match weights(&channel, kept) {
            Weights::Untouched => {}
            Weights::Dropped => {
                changed = true;
                continue;
            }
            Weights::One(number) => {
                let pointer = &mut channel["target"]["extensions"]["KHR_animation_pointer"]["pointer"];
                let start = pointer.as_str().and_then(|p| p.rsplit_once('/')).map_or("", |(start, _)| start);
                *pointer = format!("{start}/{number}").into();
            }
            Weights::All(keep) => {
                changed = true;
                let Some(old) = whole(&channel["sampler"]) else { continue };
                let known = filtered.get(&(old, keep.clone())).copied();
                let new = known.or_else(|| filtered_sampler(doc, root, blob, animation, old as usize, keep));
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
fn filtered_sampler(
    doc: &Document<'_>,
    root: &mut Value,
    blob: &mut Blob,
    animation: &mut Value,
    old: usize,
    keep: &Keep,
) -> Option<usize> {
    let mut sampler = animation["samplers"].get(old)?.clone();
    let output = Index::new(u32::try_from(whole(&sampler["output"])?).ok()?);
    let values = Accessor::of_numbers(doc, output, "animated weights").ok()?.values::<1>().ok()?;
    // The weights of all targets follow each other, for each key or each of its tangents.
    let left: Vec<[f32; 1]> =
        values.chunks(keep.len()).flat_map(|key| key.iter().zip(keep).filter(|(_, k)| **k).map(|(w, _)| *w)).collect();
    let accessor = push_attribute(root, blob, &left, false);
    // Only vertex attributes name a target.
    let view = whole(&root["accessors"][accessor]["bufferView"])? as usize;
    root["bufferViews"][view].as_object_mut()?.shift_remove("target");
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
