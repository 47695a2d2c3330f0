//! A hit and its outcome.

use crate::damage::mark::Mark;
use crate::example::blow::Blow;
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

/// What a hit asks of the vertex it hits.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Cause {
    /// A blow, in the hit's space. Its impulse, or the mass and velocity of its striker, must be known. Report a contact
    /// once with its whole impulse, or in parts with an id ([`Hit::contact`]).
    ///
    /// If any example of the set knows its blow, the set predicts the target displacement
    /// ([`ExampleSet::predicts_blows`](crate::ExampleSet::predicts_blows)); the more of the blow is known, the nearer it is.
    /// Otherwise the target is the paper's `impulse * duration / mass` (Eq. 4.4), which needs the duration. Do not pass
    /// the engine's time step as duration, because dents would depend on it; pass a constant of the material.
    Impulse {
        /// What is known of the blow.
        blow: Blow,
        /// Mass of the vertex, kg. Above 0. `None` takes the set's. It is the calibration mass of the paper's formula,
        /// not the striker's mass, and a set that predicts the target does not need it.
        mass: Option<f32>,
    },
    /// The desired contact displacement, m, for engines with their own mapping from impulse to depth. It does not
    /// depend on the frame rate.
    Displacement([f32; 3]),
}

/// A hit as the engine's physics reports it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Hit {
    /// Contact point, m.
    pub point: [f32; 3],
    /// Impulse or displacement. For a dent it points into the body.
    pub cause: Cause,
    /// The space of `point` and of the vectors in `cause`.
    pub space: Space,
    /// Id of the contact that the hit is part of. `None` for a separate hit. Hits of one contact make one dent, that of
    /// their sum, whatever the time step. They may come over many steps until
    /// [`Inbox::end_contact`](crate::Inbox::end_contact). The `duration` of their impulses must be a constant of the
    /// material, not the time step. Only for the rule `Marks`.
    pub contact: Option<NonZeroU64>,
}

impl Hit {
    /// A hit in the mesh's space that asks for a contact displacement of `displacement`, m.
    pub fn displacement(point: [f32; 3], displacement: [f32; 3]) -> Self {
        Hit { point, cause: Cause::Displacement(displacement), space: Space::Local, contact: None }
    }

    /// A hit in the mesh's space by an impulse (N·s) that acted for `duration` (s).
    pub fn impulse(point: [f32; 3], impulse: [f32; 3], duration: f32, mass: Option<f32>) -> Self {
        let cause = Cause::Impulse { blow: Blow::of_impulse(impulse, duration), mass };
        Hit { point, cause, space: Space::Local, contact: None }
    }

    /// A hit in the mesh's space by a blow. The mass of the vertex is the set's.
    pub fn blow(point: [f32; 3], blow: Blow) -> Self {
        Hit { point, cause: Cause::Impulse { blow, mass: None }, space: Space::Local, contact: None }
    }

    /// The same hit as part of a contact.
    pub fn of_contact(self, id: NonZeroU64) -> Self {
        Hit { contact: Some(id), ..self }
    }
}

/// How a classic rule selects the example for a hit.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default)]
pub enum Selection {
    /// The one example that moves the contact vertex most nearly in the target's direction, with a weight of at most 1. The
    /// default.
    #[default]
    Classic = 0,
    /// Without the weight limit. Diverges at weights above 2.
    ClassicUnclamped = 1,
}

/// What became of a hit.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum HitStatus {
    /// It leaves a mark. With a classic rule, it deforms the instance.
    Marked = 0,
    /// It is below a yield threshold, or its target is shorter than a millionth of the depth limit.
    BelowYield = 1,
    /// No example tells of a dent there.
    NothingReaches = 2,
    /// Alone it would leave no mark, but it adds to its contact.
    Accumulated = 3,
    /// Its contact cannot move: it is in a rigid part, such as glass, or its own depth limit is 0 or its stiffness 1. It
    /// leaves no mark.
    Rigid = 4,
}

/// The example that a classic rule blends towards.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Chosen {
    /// Index of the example.
    pub example: u32,
    /// Factor for its displacements.
    pub weight: f32,
}

/// The outcome of a hit.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Outcome {
    /// What became of the hit.
    pub status: HitStatus,
    /// The vertex nearest to the contact point.
    pub contact_vertex: u32,
    /// Distance of that vertex from the contact point, m.
    pub contact_distance: f32,
    /// The displacement that the hit asks for at the contact vertex, in the mesh's space, m.
    pub target: [f32; 3],
    /// The displacement of the contact vertex by this hit alone, in the mesh's space, m.
    pub achieved: [f32; 3],
    /// Whether the target was longer than the depth limit, of the instance or of the contact vertex, and was shortened to it.
    pub clamped: bool,
    /// What a classic rule chose. `None` with the rule `Marks`.
    pub classic: Option<Chosen>,
    /// The mark that the hit leaves. `None` with the classic rules.
    pub mark: Option<Mark>,
    /// The relative L2 error that is expected of the mark's dent: 1 is the error of no dent at all. Where it is large, one more example
    /// would help.
    pub expected_error: Option<f32>,
}

impl Outcome {
    /// The part of the target that was not achieved: `target - achieved`, m.
    pub fn shortfall(&self) -> [f32; 3] {
        std::array::from_fn(|i| self.target[i] - self.achieved[i])
    }
}
