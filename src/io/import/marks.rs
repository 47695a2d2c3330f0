//! What of a file does not dent: by the patterns of a reading, and by the extras of nodes, meshes and materials.

use super::document::Document;
use super::nodes::Nodes;
use super::reading::{Found, Mark, MeshChoice, Patterns, Reading, mark_in};
use crate::base::error::Error;

/// The marks that patterns give, strongest first.
const BY_PATTERNS: [Mark; 3] = [Mark::Moving, Mark::Rigid, Mark::Glass];

/// The marks of a file's nodes and materials.
pub(super) struct Marks<'r> {
    /// Of [`BY_PATTERNS`].
    patterns: [&'r Patterns; 3],
    nodes: Vec<Hints>,
    materials: Vec<Hints>,
    meshes: Vec<Mark>,
    taken: Vec<bool>,
    /// Nodes that are not shown beside the others, and not taken.
    aside: Vec<bool>,
}

/// What the patterns find, and what extras say.
#[derive(Clone, Copy)]
struct Hints {
    found: [Found; 3],
    extras: Mark,
}

impl<'r> Marks<'r> {
    pub(super) fn of(doc: &Document<'_>, nodes: &Nodes<'_, '_>, reading: &'r Reading<'r>) -> Result<Self, Error> {
        let list = |key: &str| doc.value[key].as_array().map(Vec::as_slice).unwrap_or_default();
        let names: Vec<String> = (0..doc.nodes.len()).map(|node| nodes.name(node)).collect();
        let names: Vec<&str> = names.iter().map(String::as_str).collect();
        let material_names: Vec<&str> =
            list("materials").iter().map(|material| material["name"].as_str().unwrap_or_default()).collect();
        let all = [names.as_slice(), &material_names].concat();
        reading.rigid.all_match("what is rigid", &all)?;
        reading.glass.all_match("glass", &all)?;
        reading.moving.all_match("what moves on its own", &all)?;
        let patterns = [&reading.moving, &reading.rigid, &reading.glass];
        let marks = |key: &'static str| {
            let of = |(i, element)| mark_in(element, || format!("{key}[{i}]"));
            list(key).iter().enumerate().map(of).collect::<Result<Vec<Mark>, Error>>()
        };
        let hints = |name: &str, extras: Mark| Hints { found: patterns.map(|list| list.found(name)), extras };
        let of_nodes = marks("nodes")?;
        let inherited = |node: usize, above: &Hints| {
            let own = hints(names[node], of_nodes[node]);
            Hints {
                found: std::array::from_fn(|k| own.found[k].or(above.found[k])),
                extras: if own.extras == Mark::Dents { above.extras } else { own.extras },
            }
        };
        let of_materials = material_names.iter().zip(marks("materials")?).map(|(name, extras)| hints(name, extras));
        let (mut taken, mut aside) = (Vec::new(), Vec::new());
        if let MeshChoice::Nodes(patterns) = reading.mesh {
            patterns.all_match("nodes", &names)?;
            let own = |node: usize, above: &Found| patterns.found(names[node]).or(*above);
            taken = nodes.inherited(Found::default(), own).into_iter().map(|found| patterns.take(found)).collect();
            if patterns.is_all() {
                aside = nodes.aside();
            }
        }
        let nothing = Hints { found: [Found::default(); 3], extras: Mark::Dents };
        Ok(Self {
            patterns,
            nodes: nodes.inherited(nothing, inherited),
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
        self.taken.get(node).copied().unwrap_or(false) && self.decide(Some(node), None, None) != Mark::Moving
    }

    fn is_aside(&self, node: usize) -> bool {
        self.aside.get(node).copied().unwrap_or(false)
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
        let found = |hints: Option<&Hints>| hints.map(|hints| hints.found).unwrap_or_default();
        let found = found(node).into_iter().zip(found(material)).map(|(node, material)| node.or(material));
        if let Some((_, mark)) = self.patterns.iter().zip(found).zip(BY_PATTERNS).find(|((list, f), _)| list.mark(*f)) {
            return mark;
        }
        let mesh = mesh.and_then(|mesh| self.meshes.get(mesh)).copied();
        let extras = [node.map(|hints| hints.extras), mesh, material.map(|hints| hints.extras)];
        extras.into_iter().flatten().find(|mark| *mark != Mark::Dents).unwrap_or(Mark::Dents)
    }
}
