//! What of a file does not dent: by the patterns of a reading, and by the extras of nodes, meshes and materials.

use super::document::Document;
use super::nodes::Nodes;
use super::reading::{Found, Mark, MeshChoice, Reading, mark_in};
use crate::base::error::Error;
use serde_json::Value;

/// The marks of a file's nodes and materials.
pub(super) struct Marks<'r> {
    reading: &'r Reading<'r>,
    nodes: Vec<Found3>,
    materials: Vec<Found3>,
    meshes: Vec<Mark>,
    taken: Vec<bool>,
    /// Nodes that are not shown beside the others, and not taken.
    aside: Vec<bool>,
}

/// What the three lists of patterns find, and what extras say.
#[derive(Clone, Copy)]
struct Found3 {
    rigid: Found,
    glass: Found,
    moving: Found,
    extras: Mark,
}

impl<'r> Marks<'r> {
    pub(super) fn of(doc: &Document<'_>, nodes: &Nodes<'_, '_>, reading: &'r Reading<'r>) -> Result<Self, Error> {
        let list = |key: &str| doc.value[key].as_array().map(Vec::as_slice).unwrap_or_default();
        let names: Vec<String> = (0..doc.nodes.len()).map(|node| nodes.name(node)).collect();
        let material_name = |material: &Value| material["name"].as_str().unwrap_or_default().to_owned();
        let material_names: Vec<String> = list("materials").iter().map(material_name).collect();
        let all: Vec<&str> = names.iter().chain(&material_names).map(String::as_str).collect();
        reading.rigid.all_match("what is rigid", &all)?;
        reading.glass.all_match("glass", &all)?;
        reading.moving.all_match("what moves on its own", &all)?;
        let found = |name: &str, extras: Mark| Found3 {
            rigid: reading.rigid.found(name),
            glass: reading.glass.found(name),
            moving: reading.moving.found(name),
            extras,
        };
        let marks = |key: &'static str| {
            let of = |(i, element)| mark_in(element, || format!("{key}[{i}]"));
            list(key).iter().enumerate().map(of).collect::<Result<Vec<Mark>, Error>>()
        };
        let of_nodes = marks("nodes")?;
        let inherited = |node: usize, above: &Found3| {
            let own = found(&names[node], of_nodes[node]);
            Found3 {
                rigid: own.rigid.or(above.rigid),
                glass: own.glass.or(above.glass),
                moving: own.moving.or(above.moving),
                extras: if own.extras == Mark::Dents { above.extras } else { own.extras },
            }
        };
        let nothing =
            Found3 { rigid: Found::default(), glass: Found::default(), moving: Found::default(), extras: Mark::Dents };
        let of_materials = material_names.iter().zip(marks("materials")?).map(|(name, extras)| found(name, extras));
        let taken = match reading.mesh {
            MeshChoice::Nodes(patterns) => {
                patterns.all_match("nodes", &names.iter().map(String::as_str).collect::<Vec<_>>())?;
                let own = |node: usize, above: &Found| patterns.found(&names[node]).or(*above);
                nodes.inherited(Found::default(), own)?.into_iter().map(|found| patterns.take(found)).collect()
            }
            _ => Vec::new(),
        };
        let aside = match reading.mesh {
            MeshChoice::Nodes(patterns) if patterns.is_all() => nodes.aside()?,
            _ => Vec::new(),
        };
        Ok(Self {
            reading,
            nodes: nodes.inherited(nothing, inherited)?,
            materials: of_materials.collect(),
            meshes: marks("meshes")?,
            taken,
            aside,
        })
    }

    /// Whether the reading takes a node for its body.
    pub(super) fn takes(&self, node: usize) -> bool {
        self.would_take(node) && !self.is_aside(node)
    }

    /// Whether it does not, because the node is not shown beside the others.
    pub(super) fn leaves_aside(&self, node: usize) -> bool {
        self.would_take(node) && self.is_aside(node)
    }

    fn would_take(&self, node: usize) -> bool {
        self.taken.get(node).copied().unwrap_or(false) && self.of_node(node) != Mark::Moving
    }

    fn is_aside(&self, node: usize) -> bool {
        self.aside.get(node).copied().unwrap_or(false)
    }

    /// The mark of a node, whatever its materials.
    fn of_node(&self, node: usize) -> Mark {
        self.decide(Some(node), None, None)
    }

    /// The mark of a primitive.
    pub(super) fn of_primitive(&self, node: Option<usize>, mesh: usize, material: Option<usize>) -> Mark {
        match self.decide(node, Some(mesh), material) {
            // A primitive cannot be left out of its mesh.
            Mark::Moving => Mark::Rigid,
            mark => mark,
        }
    }

    fn decide(&self, node: Option<usize>, mesh: Option<usize>, material: Option<usize>) -> Mark {
        let node = node.and_then(|node| self.nodes.get(node));
        let material = material.and_then(|material| self.materials.get(material));
        let either = |of: fn(&Found3) -> Found| {
            let found = |one: Option<&Found3>| one.map(of).unwrap_or_default();
            found(node).or(found(material))
        };
        if self.reading.moving.mark(either(|found| found.moving)) {
            return Mark::Moving;
        }
        if self.reading.rigid.mark(either(|found| found.rigid)) {
            return Mark::Rigid;
        }
        if self.reading.glass.mark(either(|found| found.glass)) {
            return Mark::Glass;
        }
        let mesh = mesh.and_then(|mesh| self.meshes.get(mesh)).copied();
        let extras = [node.map(|found| found.extras), mesh, material.map(|found| found.extras)];
        extras.into_iter().flatten().find(|mark| *mark != Mark::Dents).unwrap_or(Mark::Dents)
    }
}
