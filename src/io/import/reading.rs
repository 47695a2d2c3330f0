//! What of a file is read: which mesh or nodes, which morph targets are dents, and what does not dent.

use super::malformed;
use super::words::{brief, listed};
use crate::base::error::Error;
use serde_json::Value;
use wildmatch::WildMatch;

/// The mesh of a file to read, or the nodes whose meshes are joined to one body.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub enum MeshChoice<'a> {
    /// The first whose morph targets move a vertex.
    #[default]
    First,
    /// By its index in the file.
    Index(usize),
    /// By its name; the first of that name.
    Name(&'a str),
    /// The meshes of all nodes whose names, or the names of nodes above them, match: a body of parts, in the scene's space. Without
    /// a pattern that takes names, of all but those of other scenes and levels of detail. See [`Part`](super::Part).
    Nodes(&'a Patterns),
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
/// let reading = Reading { rigid: Patterns::new(["Panel"]), ..MeshChoice::Nodes(&nodes).into() };
/// let body = gltf_file(&folder.join("tests/fixtures/nodes.glb"), &reading)?;
/// assert_eq!(body.parts.iter().map(|part| &*part.name).collect::<Vec<_>>(), ["Door", "Panel", "Door again"]);
/// # Ok::<(), crumple::Error>(())
/// ```
#[derive(Debug, Clone, PartialEq)]
pub struct Reading<'a> {
    /// The mesh, or the nodes.
    pub mesh: MeshChoice<'a>,
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

impl Default for Reading<'_> {
    fn default() -> Self {
        MeshChoice::First.into()
    }
}

impl<'a> From<MeshChoice<'a>> for Reading<'a> {
    fn from(mesh: MeshChoice<'a>) -> Self {
        let none = Patterns::default;
        Reading { mesh, targets: none(), rigid: none(), glass: none(), moving: none(), unit: 1.0 }
    }
}

impl<'a> From<&Reading<'a>> for Reading<'a> {
    fn from(reading: &Reading<'a>) -> Self {
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
    pub(super) fn is_all(&self) -> bool {
        self.taken.is_empty()
    }

    /// Whether a name is taken, and whether it is taken out again.
    pub(super) fn found(&self, name: &str) -> Found {
        let any = |list: &[WildMatch]| list.iter().any(|pattern| pattern.matches(name));
        Found { taken: any(&self.taken), left: any(&self.left) }
    }

    /// Whether to take what has been found. Without a pattern that takes names, all are taken.
    pub(super) fn take(&self, found: Found) -> bool {
        (self.taken.is_empty() || found.taken) && !found.left
    }

    /// As [`Patterns::take`], but without patterns nothing is taken.
    pub(super) fn mark(&self, found: Found) -> bool {
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
pub(super) struct Found {
    taken: bool,
    left: bool,
}

impl Found {
    pub(super) fn or(self, other: Found) -> Found {
        Found { taken: self.taken || other.taken, left: self.left || other.left }
    }
}

/// What a piece of the body does when it is hit.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub(super) enum Mark {
    Dents,
    Glass,
    Rigid,
    Moving,
}

impl Reading<'_> {
    pub(super) fn check(&self) -> Result<(), Error> {
        if self.unit > 0.0 && self.unit.is_finite() {
            return Ok(());
        }
        Err(Error::invalid("unit", self.unit, "the length of the file's unit, m, above 0 and finite"))
    }
}

/// The mark in the extras of a node, mesh or material, which `what` names. An object of that name is a note of who made the file.
pub(super) fn mark_in(element: &Value, what: impl FnOnce() -> String) -> Result<Mark, Error> {
    match &element["extras"]["crumple"] {
        Value::Null | Value::Object(_) => Ok(Mark::Dents),
        Value::String(text) => match text.trim().to_ascii_lowercase().as_str() {
            "rigid" => Ok(Mark::Rigid),
            "glass" => Ok(Mark::Glass),
            "moving" => Ok(Mark::Moving),
            _ => Err(malformed(format!("{}: extras.crumple is '{text}'; it must be rigid, glass or moving", what()))),
        },
        other => {
            Err(malformed(format!("{}: extras.crumple is {}; it must be rigid, glass or moving", what(), brief(other))))
        }
    }
}
