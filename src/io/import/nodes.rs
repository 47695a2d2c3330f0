//! The nodes of a glTF: which of them show a mesh, and where they place it.

use super::accessor::Accessor;
use super::document::{Document, out_of_range};
use super::words::cut;
use super::{malformed, whole};
use crate::base::error::Error;
use ::gltf::json;
use ::gltf::json::Index;
use ::gltf::json::accessor::Type;
use glam::{DMat4, DQuat, DVec3, Mat4};
use serde_json::Value;
use std::collections::{HashMap, HashSet};

/// The tree of nodes, with their matrices: files have many nodes, and trees may be deep.
pub(super) struct Nodes<'d, 'a> {
    doc: &'d Document<'a>,
    /// The first node that shows each mesh.
    first: HashMap<usize, usize>,
    parents: Vec<Option<usize>>,
    /// The nodes that a root leads to, each after its parent. A node that no root leads to is below a node that is its own ancestor.
    order: Vec<usize>,
    worlds: Vec<Option<DMat4>>,
    /// For each node the next with a name: itself, or one above it.
    named: Vec<usize>,
}

impl<'d, 'a> Nodes<'d, 'a> {
    pub(super) fn of(doc: &'d Document<'a>) -> Result<Self, Error> {
        let nodes = &doc.nodes;
        let mut first = HashMap::new();
        for (i, mesh) in nodes.iter().enumerate().filter_map(|(i, node)| Some((i, node.mesh?))) {
            first.entry(mesh.value()).or_insert(i);
        }
        let children = |i: usize| nodes[i].children.iter().flatten().map(|child| child.value());
        let mut parents = vec![None; nodes.len()];
        for (i, child) in (0..nodes.len()).flat_map(|i| children(i).map(move |child| (i, child))) {
            let slot: &mut Option<usize> = parents
                .get_mut(child)
                .ok_or_else(|| out_of_range(&format!("a child of node {i}"), child, nodes.len()))?;
            if let Some(other) = slot.replace(i).filter(|other| *other != i) {
                return Err(malformed(format!(
                    "node {child} is a child of node {other} and of node {i}; a node has at most one parent"
                )));
            }
        }
        let (mut worlds, mut order): (Vec<Option<DMat4>>, _) = (vec![None; nodes.len()], Vec::new());
        let mut named: Vec<usize> = (0..nodes.len()).collect();
        let mut next: Vec<usize> = (0..nodes.len()).filter(|i| parents[*i].is_none()).collect();
        while let Some(i) = next.pop() {
            // A list of children may name one twice.
            if worlds[i].is_none() {
                let local = local_matrix(&nodes[i]);
                worlds[i] = Some(parents[i].and_then(|up: usize| worlds[up]).map_or(local, |above| above * local));
                if nodes[i].name.as_deref().is_none_or(str::is_empty) {
                    named[i] = parents[i].map_or(i, |up| named[up]);
                }
                order.push(i);
                next.extend(children(i));
            }
        }
        Ok(Nodes { doc, first, parents, order, worlds, named })
    }

    /// The first node that shows the mesh.
    pub(super) fn first(&self, mesh: usize) -> Option<usize> {
        self.first.get(&mesh).copied()
    }

    /// The world matrix of the first node that shows the mesh.
    pub(super) fn transform_of_mesh(&self, mesh: usize) -> Result<Option<Mat4>, Error> {
        self.first(mesh).map(|node| self.shown(node, &mut Vec::new()).map(|world| world.as_mat4())).transpose()
    }

    /// The node's name; else its mesh's, that of the next node above it with a name, or `node N`.
    pub(super) fn name(&self, node: usize) -> String {
        let mesh = self.doc.nodes[node].mesh.map_or(usize::MAX, |mesh| mesh.value());
        let above = self.named[node];
        let of_mesh = self.doc.value["meshes"][mesh]["name"].as_str();
        let named = [self.doc.nodes[node].name.as_deref(), of_mesh, self.doc.nodes[above].name.as_deref()];
        let name = named.into_iter().flatten().find(|name| !name.is_empty());
        name.map_or_else(|| format!("node {node}"), str::to_owned)
    }

    /// A value for each node, made from the node and its parent's value. `start` is the value above roots, and of nodes that no
    /// root leads to.
    pub(super) fn inherited<T: Clone>(&self, start: T, mut of: impl FnMut(usize, &T) -> T) -> Vec<T> {
        let mut out = vec![start.clone(); self.doc.nodes.len()];
        for node in &self.order {
            let above = self.parents[*node].map_or(&start, |parent| &out[parent]);
            let value = of(*node, above);
            out[*node] = value;
        }
        out
    }

    /// Which nodes are not shown beside the others: those of other scenes than the file's, and levels of detail (MSFT_lod) after the
    /// first. No node if that leaves no mesh.
    pub(super) fn aside(&self) -> Vec<bool> {
        let indices = |value: &Value| -> HashSet<usize> {
            value.as_array().into_iter().flatten().filter_map(|i| usize::try_from(whole(i)?).ok()).collect()
        };
        let shown = whole(&self.doc.value["scene"]).map_or(0, |scene| scene as usize);
        let (mut own, mut others) = (HashSet::new(), HashSet::new());
        for (i, scene) in self.doc.list("scenes").iter().enumerate() {
            if i == shown { &mut own } else { &mut others }.extend(indices(&scene["nodes"]));
        }
        others.retain(|node| !own.contains(node));
        others.extend(self.doc.list("nodes").iter().flat_map(|node| indices(&node["extensions"]["MSFT_lod"]["ids"])));
        let aside = self.inherited(false, |node, above| *above || others.contains(&node));
        let any = self.doc.nodes.iter().zip(&aside).any(|(node, aside)| !aside && node.mesh.is_some());
        if any { aside } else { vec![false; aside.len()] }
    }

    /// Where a node shows its mesh: its world matrix, or where the joints of its skin place the mesh. The glTF 2.0 specification
    /// (3.7.3.3) ignores the transform of a skinned mesh's node.
    pub(super) fn shown(&self, node: usize, notes: &mut Vec<String>) -> Result<DMat4, Error> {
        let joints = self.joints(node);
        let Some(first) = joints.first() else { return self.world(node) };
        let elements = first.to_cols_array();
        let size = elements.iter().fold(0.0f64, |most, x| most.max(x.abs()));
        let off = |m: &DMat4| m.to_cols_array().iter().zip(&elements).any(|(a, b)| (a - b).abs() > 1e-4 * size);
        if joints.iter().any(off) {
            notes.push(format!(
                "{} is skinned and its joints are posed; the scene's space is taken where its first joint stands",
                cut(&self.name(node))
            ));
        }
        finite(*first, node)
    }

    /// Where each joint of a node's skin places the mesh. None if the node has no skin, or a broken one.
    fn joints(&self, node: usize) -> Vec<DMat4> {
        let Some(skin) = self.doc.nodes[node].skin.map(|skin| &self.doc.value["skins"][skin.value()]) else {
            return Vec::new();
        };
        let bind = whole(&skin["inverseBindMatrices"]).and_then(|accessor| {
            let index = Index::new(u32::try_from(accessor).ok()?);
            Accessor::new(self.doc, index, "inverseBindMatrices", Type::Mat4).and_then(|a| a.floats::<16>()).ok()
        });
        let listed = skin["joints"].as_array().into_iter().flatten();
        let joint = |(i, joint)| {
            let world = self.world(usize::try_from(whole(joint)?).ok()?).ok()?;
            Some(bind.as_ref().and_then(|list| list.get(i)).map_or(world, |bind| world * matrix(*bind)))
        };
        listed.enumerate().map(joint).collect::<Option<Vec<DMat4>>>().unwrap_or_default()
    }

    /// The product of the matrices from the root to a node, whose elements are finite as f32.
    fn world(&self, node: usize) -> Result<DMat4, Error> {
        let world = self.worlds.get(node).ok_or_else(|| out_of_range("node", node, self.worlds.len()))?;
        finite(world.ok_or_else(|| malformed(format!("node {node} is its own ancestor")))?, node)
    }
}

fn finite(world: DMat4, node: usize) -> Result<DMat4, Error> {
    match world.as_mat4().to_cols_array().into_iter().find(|x| !x.is_finite()) {
        None => Ok(world),
        Some(x) => Err(Error::NotFinite { name: format!("the world matrix of node {node}"), value: x.to_string() }),
    }
}

fn matrix(columns: [f32; 16]) -> DMat4 {
    DMat4::from_cols_array(&columns.map(f64::from))
}

fn local_matrix(node: &json::scene::Node) -> DMat4 {
    if let Some(columns) = node.matrix {
        return matrix(columns);
    }
    let vector = |v: [f32; 3]| DVec3::from(v.map(f64::from));
    DMat4::from_scale_rotation_translation(
        vector(node.scale.unwrap_or([1.0; 3])),
        DQuat::from_array(node.rotation.unwrap_or_default().0.map(f64::from)),
        vector(node.translation.unwrap_or_default()),
    )
}
