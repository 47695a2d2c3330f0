//! What of a file is read: which mesh or nodes, which morph targets are dents, and what does not dent.

use super::document::Document;
use super::nodes::Nodes;
use super::words::{brief, listed};
use super::{PartKind, malformed};
use crate::base::error::Error;
use serde_json::Value;
use wildmatch::WildMatch;

/// The mesh of a file to read, or the nodes whose meshes are joined to one body.
#[derive(Debug, Clone, PartialEq, Default)]
pub enum MeshChoice {
    /// The first whose morph targets move a vertex.
    #[default]
    First,
    /// By its index in the file.
    Index(usize),
    /// By its name; the first of that name.
    Name(String),
    /// The meshes of all nodes whose names, or the names of nodes above them, match: a body of parts, in the scene's space. Without
    /// a pattern that takes names, of all but those of other scenes and levels of detail. See [`Part`](super::Part).
    Nodes(Patterns),
}

/// What of a glTF file is read.
///
/// `MeshChoice` converts to a reading with defaults for the rest. What does not dent can also be said in the file: the custom
/// property `crumple` of a node, a mesh or a material is `"rigid"`, `"glass"` or `"moving"`. A node's holds for the nodes below
/// it. Patterns take precedence.
///
/// ```
/// use crumple::import::{MeshChoice, Patterns, Reading, gltf_file};
/// # let folder = std::path::Path::new(env!("CARGO_MANIFEST_DIR"));
/// let nodes = Patterns::new(["Door*", "Panel"]);
/// let reading = Reading { rigid: Patterns::new(["Panel"]), ..MeshChoice::Nodes(nodes).into() };
/// let body = gltf_file(&folder.join("tests/fixtures/nodes.glb"), &reading)?;
/// assert_eq!(body.parts.iter().map(|part| &*part.name).collect::<Vec<_>>(), ["Door", "Panel", "Door again"]);
/// # Ok::<(), crumple::Error>(())
/// ```
#[derive(Debug, Clone, PartialEq)]
pub struct Reading {
    /// The mesh, or the nodes.
    pub mesh: MeshChoice,
    /// The names of the morph targets that are dents. The others stay in the file. Without patterns: `mesh.extras.dents`, a list of
    /// patterns, or else all.
    pub targets: Patterns,
    /// Names of nodes or materials that never move: hits on them leave no mark, and what touches them is held there.
    pub rigid: Patterns,
    /// Names of nodes or materials that break instead of denting: hits on them leave no mark, but they follow dents around them.
    pub glass: Patterns,
    /// Names of nodes that move on their own, such as wheels and doors that open: they are no part of the body and never dent.
    pub moving: Patterns,
    /// The length of the file's unit, m. Positions that are read are multiplied by it; an export divides by it.
    pub unit: f32,
}

impl Default for Reading {
    fn default() -> Self {
        MeshChoice::First.into()
    }
}

impl From<MeshChoice> for Reading {
    fn from(mesh: MeshChoice) -> Self {
        let none = Patterns::default;
        Reading { mesh, targets: none(), rigid: none(), glass: none(), moving: none(), unit: 1.0 }
    }
}

impl From<&Reading> for Reading {
    fn from(reading: &Reading) -> Self {
        reading.clone()
    }
}

/// Patterns of names: `*` stands for any text, `?` for any character, and upper and lower case are the same. A pattern that begins
/// with `!` takes names out again.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Patterns {
    taken: Vec<WildMatch>,
    left: Vec<WildMatch>,
}

impl Patterns {
    /// Patterns in any order.
    pub fn new<S: AsRef<str>>(patterns: impl IntoIterator<Item = S>) -> Self {
        let mut out = Self::default();
        for pattern in patterns {
            match pattern.as_ref().strip_prefix('!') {
                Some(left) => out.left.push(WildMatch::new_case_insensitive(left)),
                None => out.taken.push(WildMatch::new_case_insensitive(pattern.as_ref())),
            }
        }
        out
    }

    /// Whether there are none.
    pub fn is_empty(&self) -> bool {
        self.taken.is_empty() && self.left.is_empty()
    }

    /// Whether every name is taken that is not taken out again.
    fn is_all(&self) -> bool {
        self.taken.is_empty()
    }

    /// Whether a name is taken, and whether it is taken out again.
    fn found(&self, name: &str) -> Found {
        let any = |list: &[WildMatch]| list.iter().any(|pattern| pattern.matches(name));
        Found { taken: any(&self.taken), left: any(&self.left) }
    }

    /// Whether a name is taken in the end.
    pub(super) fn takes(&self, name: &str) -> bool {
        self.take(self.found(name))
    }

    /// Whether to take what has been found. Without a pattern that takes names, all are taken.
    fn take(&self, found: Found) -> bool {
        (self.taken.is_empty() || found.taken) && !found.left
    }

    /// As [`Patterns::take`], but without patterns nothing is taken.
    fn mark(&self, found: Found) -> bool {
        !self.is_empty() && self.take(found)
    }

    /// Fails if a pattern matches none of the names. `what` says what they name.
    pub(super) fn all_match(&self, what: &str, names: &[&str]) -> Result<(), Error> {
        let unused = |pattern: &&WildMatch| !names.iter().any(|name| pattern.matches(name));
        let Some(pattern) = self.taken.iter().chain(&self.left).find(unused) else { return Ok(()) };
        Err(Error::InvalidArgument {
            name: format!("a pattern for {what}"),
            value: format!("'{}'", pattern.pattern()),
            expected: format!("one that matches a name of the file: {}", listed(names.iter())),
        })
    }
}

/// Which of the patterns match a name, or one of several.
#[derive(Debug, Clone, Copy, Default)]
struct Found {
    taken: bool,
    left: bool,
}

impl Found {
    fn or(self, other: Found) -> Found {
        Found { taken: self.taken || other.taken, left: self.left || other.left }
    }
}

/// What a piece of the body does when it is hit. `None`: it moves on its own.
type Mark = Option<PartKind>;

const DENTS: Mark = Some(PartKind::Dents);

impl Reading {
    pub(super) fn check(&self) -> Result<(), Error> {
        if self.unit > 0.0 && self.unit.is_finite() {
            return Ok(());
        }
        Err(Error::invalid("unit", self.unit, "the length of the file's unit, m, above 0 and finite"))
    }
}

/// The mark in the extras of a node, mesh or material, which `what` names. An object of that name is a note of who made the file.
fn mark_in(element: &Value, what: impl FnOnce() -> String) -> Result<Mark, Error> {
    let value = &element["extras"]["crumple"];
    let shown = match value {
        Value::Null | Value::Object(_) => return Ok(DENTS),
        Value::String(text) => match text.trim().to_ascii_lowercase().as_str() {
            "rigid" => return Ok(Some(PartKind::Rigid)),
            "glass" => return Ok(Some(PartKind::Glass)),
            "moving" => return Ok(None),
            _ => format!("'{text}'"),
        },
        other => brief(other),
    };
    Err(malformed(format!("{}: extras.crumple is {shown}; it must be rigid, glass or moving", what())))
}

/// The marks that patterns give, strongest first.
const BY_PATTERNS: [Mark; 3] = [None, Some(PartKind::Rigid), Some(PartKind::Glass)];

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
    pub(super) fn of(doc: &Document<'_>, nodes: &Nodes<'_, '_>, reading: &'r Reading) -> Result<Self, Error> {
        let names: Vec<String> = (0..doc.nodes.len()).map(|node| nodes.name(node)).collect();
        let names: Vec<&str> = names.iter().map(String::as_str).collect();
        let material_names: Vec<&str> =
            doc.list("materials").iter().map(|material| material["name"].as_str().unwrap_or_default()).collect();
        let all = [names.as_slice(), &material_names].concat();
        reading.rigid.all_match("what is rigid", &all)?;
        reading.glass.all_match("glass", &all)?;
        reading.moving.all_match("what moves on its own", &all)?;
        let patterns = [&reading.moving, &reading.rigid, &reading.glass];
        let marks = |key: &'static str| {
            let of = |(i, element)| mark_in(element, || format!("{key}[{i}]"));
            doc.list(key).iter().enumerate().map(of).collect::<Result<Vec<Mark>, Error>>()
        };
        let hints = |name: &str, extras: Mark| Hints { found: patterns.map(|list| list.found(name)), extras };
        let of_nodes = marks("nodes")?;
        let inherited = |node: usize, above: &Hints| {
            let own = hints(names[node], of_nodes[node]);
            Hints {
                found: std::array::from_fn(|k| own.found[k].or(above.found[k])),
                extras: if own.extras == DENTS { above.extras } else { own.extras },
            }
        };
        let of_materials = material_names.iter().zip(marks("materials")?).map(|(name, extras)| hints(name, extras));
        let mut taken = vec![false; names.len()];
        let mut aside = taken.clone();
        if let MeshChoice::Nodes(patterns) = &reading.mesh {
            patterns.all_match("nodes", &names)?;
            let own = |node: usize, above: &Found| patterns.found(names[node]).or(*above);
            taken = nodes.inherited(Found::default(), own).into_iter().map(|found| patterns.take(found)).collect();
            if patterns.is_all() {
                aside = nodes.aside();
            }
        }
        let nothing = Hints { found: [Found::default(); 3], extras: DENTS };
        Ok(Self {
            patterns,
            nodes: nodes.inherited(nothing, inherited),
            materials: of_materials.collect(),
            meshes: marks("meshes")?,
            taken,
            aside,
        })
    }

    /// The nodes that the reading takes for its body, and those that it does not take because they are not shown beside the others.
    pub(super) fn chosen(&self) -> (Vec<usize>, Vec<usize>) {
        let is_chosen = |node: &usize| self.taken[*node] && self.decide(Some(*node), None, None).is_some();
        (0..self.taken.len()).filter(is_chosen).partition(|node| !self.aside[*node])
    }

    /// What a primitive does when it is hit.
    pub(super) fn of_primitive(&self, node: Option<usize>, mesh: usize, material: Option<usize>) -> PartKind {
        // A primitive cannot be left out of its mesh.
        self.decide(node, Some(mesh), material).unwrap_or(PartKind::Rigid)
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
        extras.into_iter().flatten().find(|mark| *mark != DENTS).unwrap_or(DENTS)
    }
}
