//! A hit, and what it was turned into.

use crate::damage::mark::Mark;
use crate::mesh::mirror::Mirror;
use std::num::NonZeroU64;

/// The space that a hit is given in.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default)]
pub enum Space {
    /// The mesh's own space. The default.
    #[default]
    Local = 0,
    /// World space. The instance's transform maps it to the mesh's space.
    World = 1,
}

/// What a hit does to the vertex it hits.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Cause {
    /// The literature's target displacement `impulse * duration / mass` (Eq. 4.4). It depends on `duration`, so on the
    /// engine's time step if that is what is passed: give a duration of the material's own, and report a contact once, with
    /// its whole impulse, or in parts with an id ([`Hit::contact`]). [`Cause::Displacement`] has no duration.
    Impulse {
        /// N·s.
        impulse: [f32; 3],
        /// How long it acted, s; above 0.
        duration: f32,
        /// Mass of the vertex, kg, above 0. `None`: the set's.
        mass: Option<f32>,
    },
    /// The displacement the contact should get, m: the engine's own mapping, free of the frame rate.
    Displacement([f32; 3]),
}

/// A hit as the engine's physics reports it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Hit {
    /// Contact point, m.
    pub point: [f32; 3],
    /// Impulse or displacement; points into the body for a dent.
    pub cause: Cause,
    /// The space of `point` and of the vector in `cause`.
    pub space: Space,
    /// The contact it is part of. `None`: a hit of its own. Hits of one contact, which may come over many steps until
    /// [`Inbox::end_contact`](crate::Inbox::end_contact), make the one dent of their sum, whatever the time step. An
    /// impulse's `duration` is then a constant of the material, not the step. The rule `Marks` only.
    pub contact: Option<NonZeroU64>,
}

impl Hit {
    /// A hit in the mesh's space that should displace the contact by `displacement`, m.
    pub fn displacement(point: [f32; 3], displacement: [f32; 3]) -> Self {
        Hit { point, cause: Cause::Displacement(displacement), space: Space::Local, contact: None }
    }

    /// A hit in the mesh's space by an impulse (N·s) that acted for `duration` (s).
    pub fn impulse(point: [f32; 3], impulse: [f32; 3], duration: f32, mass: Option<f32>) -> Self {
        Hit { point, cause: Cause::Impulse { impulse, duration, mass }, space: Space::Local, contact: None }
    }

    /// The same hit as part of a contact.
    pub fn of_contact(self, id: NonZeroU64) -> Self {
        Hit { contact: Some(id), ..self }
    }
}

/// How examples are chosen.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default)]
pub enum Selection {
    /// The K that say most of the hit's place, depth and lean, carried or anchored as each example says.
    #[default]
    Nearest,
    /// The paper's Figure 4.2: best cosine among the examples that move the nearest vertex, anchored; weight at most 1.
    Classic,
    /// The same without the limit of the weight: diverges above 2. For comparison, with the classic rules only.
    ClassicUnclamped,
}

/// What became of a hit.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum HitStatus {
    /// It leaves a mark. With a classic rule, it deforms the instance.
    Marked = 0,
    /// It is below a yield threshold, or its target is shorter than a millionth of the depth limit.
    BelowYield = 1,
    /// No example moves the contact vertex towards the target.
    NothingReaches = 2,
    /// Alone it would leave no mark, but it adds to its contact.
    Accumulated = 3,
}

/// An example chosen for a hit.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Chosen {
    /// Its index.
    pub example: u32,
    /// Its share of the dent; shares sum to 1. Negative where it corrects others that overshoot.
    pub share: f32,
    /// What its displacements are multiplied with.
    pub scale: f32,
    /// Whether it stays where it was made.
    pub anchored: bool,
    /// The planes that it is mirrored in.
    pub mirror: Mirror,
}

/// What a hit was turned into.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Outcome {
    /// What became of it.
    pub status: HitStatus,
    /// The vertex nearest to the contact point.
    pub contact_vertex: u32,
    /// Its distance from the contact point, m.
    pub contact_distance: f32,
    /// Displacement asked for at the contact, in the mesh's space, m.
    pub target: [f32; 3],
    /// Displacement that this hit alone achieves there, m.
    pub achieved: [f32; 3],
    /// Whether the target was longer than the depth limit and was cut to it.
    pub clamped: bool,
    /// The examples chosen, the weightiest first.
    pub chosen: [Option<Chosen>; 4],
    /// The mark it leaves; none with the classic rules.
    pub mark: Option<Mark>,
}

impl Outcome {
    /// The part of the target that was not achieved: `target - achieved`, m.
    pub fn shortfall(&self) -> [f32; 3] {
        std::array::from_fn(|i| self.target[i] - self.achieved[i])
    }
}
