//! The nodes of a glTF: which of them show a mesh, and where they place it.

use super::document::{Document, out_of_range};
use super::malformed;
use crate::base::error::Error;
use ::gltf::json;
use std::cell::OnceCell;
use std::collections::HashMap;

/// Four columns.
pub(super) type Matrix = [[f64; 4]; 4];

/// The tree of nodes. Matrices are computed for all nodes at once when the first is asked for: files have many nodes, and
/// trees may be deep.
pub(super) struct Nodes<'d> {
    nodes: &'d [json::Node],
    /// The first node that shows each mesh.
    first: HashMap<usize, usize>,
    worlds: OnceCell<Vec<Option<Matrix>>>,
}

impl<'d> Nodes<'d> {
    pub(super) fn of(doc: &'d Document<'_>) -> Self {
        let (nodes, mut first) = (&*doc.root.nodes, HashMap::new());
        for (i, node) in nodes.iter().enumerate() {
            if let Some(mesh) = node.mesh {
                first.entry(mesh.value()).or_insert(i);
            }
        }
        Nodes { nodes, first, worlds: OnceCell::new() }
    }

    /// The world matrix of the first node that shows the mesh.
    pub(super) fn transform_of_mesh(&self, mesh: usize) -> Result<Option<[[f32; 4]; 4]>, Error> {
        let rounded = |world: Matrix| world.map(|column| column.map(|x| x as f32));
        self.first.get(&mesh).map(|node| self.world(*node).map(rounded)).transpose()
    }

    /// The product of the matrices from the root to a node, whose elements are finite as f32.
    pub(super) fn world(&self, node: usize) -> Result<Matrix, Error> {
        let worlds = match self.worlds.get() {
            Some(worlds) => worlds,
            None => {
                let worlds = worlds(self.nodes)?;
                self.worlds.get_or_init(|| worlds)
            }
        };
        let world = worlds[node].ok_or_else(|| malformed(format!("node {node} is its own ancestor")))?;
        match world.iter().flatten().map(|x| *x as f32).find(|x| !x.is_finite()) {
            None => Ok(world),
            Some(x) => Err(Error::NotFinite { name: format!("the world matrix of node {node}"), value: x.to_string() }),
        }
    }
}

/// The world matrix of each node. `None` for a node that no root leads to: it is below a node that is its own ancestor.
fn worlds(nodes: &[json::Node]) -> Result<Vec<Option<Matrix>>, Error> {
    let children = |i: usize| nodes[i].children.iter().flatten().map(|child: &json::Index<json::Node>| child.value());
    let mut parent = vec![None; nodes.len()];
    for i in 0..nodes.len() {
        for child in children(i) {
            let slot: &mut Option<usize> = parent
                .get_mut(child)
                .ok_or_else(|| out_of_range(&format!("a child of node {i}"), child, nodes.len()))?;
            if let Some(other) = slot.replace(i).filter(|other| *other != i) {
                return Err(malformed(format!(
                    "node {child} is a child of node {other} and of node {i}; a node has at most one parent"
                )));
            }
        }
    }
    let mut worlds: Vec<Option<Matrix>> = vec![None; nodes.len()];
    let mut next: Vec<usize> = (0..nodes.len()).filter(|i| parent[*i].is_none()).collect();
    while let Some(i) = next.pop() {
        // A list of children may name one twice.
        if worlds[i].is_none() {
            let above = parent[i].and_then(|up| worlds[up]);
            let local = local_matrix(&nodes[i]);
            worlds[i] = Some(above.map_or(local, |above| product(&above, &local)));
            next.extend(children(i));
        }
    }
    Ok(worlds)
}

fn local_matrix(node: &json::scene::Node) -> Matrix {
    if let Some(m) = node.matrix {
        let m = m.map(f64::from);
        return std::array::from_fn(|column| std::array::from_fn(|row| m[column * 4 + row]));
    }
    let t = node.translation.unwrap_or([0.0; 3]).map(f64::from);
    let [x, y, z, w] = node.rotation.unwrap_or_default().0.map(f64::from);
    let s = node.scale.unwrap_or([1.0; 3]).map(f64::from);
    let rotation = [
        [1.0 - 2.0 * (y * y + z * z), 2.0 * (x * y + z * w), 2.0 * (x * z - y * w)],
        [2.0 * (x * y - z * w), 1.0 - 2.0 * (x * x + z * z), 2.0 * (y * z + x * w)],
        [2.0 * (x * z + y * w), 2.0 * (y * z - x * w), 1.0 - 2.0 * (x * x + y * y)],
    ];
    let column = |i: usize| [rotation[i][0] * s[i], rotation[i][1] * s[i], rotation[i][2] * s[i], 0.0];
    [column(0), column(1), column(2), [t[0], t[1], t[2], 1.0]]
}

fn product(a: &Matrix, b: &Matrix) -> Matrix {
    std::array::from_fn(|column| std::array::from_fn(|row| (0..4).map(|k| a[k][row] * b[column][k]).sum()))
}
