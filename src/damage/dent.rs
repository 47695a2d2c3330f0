//! A dent: a mark prepared for evaluation, with each example placed and scaled. A pure function of the marks and the
//! set.
//!
//! For a mark with target depth `T` at contact `c` (normal `n`), a pair of example `i` and share `s_i` contributes
//!
//! ```text
//! anchored   a_i = T / |d_i(c)|      e_i(v) = d_i(v)      (at the example's own contact d_i(c) is not rounded)
//! carried    a_i = T / |d_i(p_i)|    e_i(v) = R d_i at p_i + stretch^-1 (R^T (v - c))
//! ```
//!
//! `R` is the smallest rotation from `n_i` to `n`. The stretch along the surface is `clamp(wide sqrt(a_i), 1/4, 4)`. A
//! mirrored pair uses the example's mirror image. `wide` is 1 for a hit alone; [`super::overlap`] computes it. An
//! anchored example has no stretch. If it has a stamp and `wide` is above 1, it is read from the stamp at its own
//! contact, stretched by `wide` alone. All contributions are then scaled by `g = T / |sum s_i a_i e_i(c)|`,
//! so that the contact gets the target depth. Anchored examples are never scaled above 1. Carried examples fade to zero towards held rims ([`crate::mesh::rim`]).

use super::carried::{Carried, Lookup, Placement};
use super::mark::{MAX_PAIRS, Mark, Pair};
use super::told::predicted;
use crate::base::array_vec::ArrayVec;
use crate::base::math::{Aabb, rotation_between};
use crate::basis::field::NodeField;
use crate::example::mesh_lod::MeshLod;
use crate::example::options::Seams;
use crate::example::set::ExampleSet;
use crate::mesh::vertex_blocks::BLOCK;
use glam::{Mat3, Vec3};
use std::sync::Arc;

/// Limits of a carried example's stretch along the surface.
const STRETCH: (f32, f32) = (0.25, 4.0);

/// One example of a dent, placed and scaled.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct PlacedExample {
    pub example: usize,
    /// Factor for its displacements.
    pub scale: f32,
    /// `None` if the example is anchored.
    pub carried: Option<Placement>,
}

/// What moves vertices in a dent.
#[derive(Debug, Clone)]
pub(crate) enum Part {
    /// An example where it was made, and the factor for its displacements.
    Anchored(usize, f32),
    /// Examples read from their stamps.
    Carried(Carried),
    /// Nodes that the set predicts, and the factor for their displacements.
    Predicted(Arc<NodeField>, f32),
}

/// A mark prepared for evaluation.
#[derive(Debug, Clone)]
pub(crate) struct Dent {
    /// Factor for all parts. Repeated hits and hits nearby change it.
    pub strength: f32,
    /// The strength if there were no other mark.
    pub alone: f32,
    /// Factor for the stretch of all parts; 1 for a hit alone.
    pub wide: f32,
    pub contact: Vec3,
    /// The mark's examples as one hit alone places them.
    examples: ArrayVec<PlacedExample, MAX_PAIRS>,
    /// What moves vertices: carried examples, then anchored ones in the mark's order.
    pub parts: Vec<Part>,
    pub nearby: Nearby,
}

/// What a dent needs to know of itself and of the marks near it ([`super::overlap`]).
#[derive(Debug, Clone, Default)]
pub(crate) struct Nearby {
    pub contact: u32,
    /// Depth to the power by which energies grow.
    pub power: f64,
    /// How far one hit moves the contact, m.
    pub depth: f32,
    /// Squared distance from the contact beyond which one hit moves nothing, m².
    pub reach_square: f32,
    /// The largest factor for the stretch.
    pub widest: f32,
    /// Energy that other marks have here, in units of [`Mark::energy`] with hits of this mark's depth.
    pub others: u128,
}

impl Dent {
    /// Makes the dent of one hit of a mark, not widened. The mark must be valid.
    pub(crate) fn of_one_hit(set: &ExampleSet, mark: &Mark) -> Self {
        if mark.is_predicted() {
            return Self::of_prediction(set, mark);
        }
        let rotations = frame_rotations(set, mark.contact, &mark.pairs);
        let examples = place(set, mark.contact, mark.depth, &mark.pairs, &rotations).parts;
        let contact = set.mesh().positions()[mark.contact as usize];
        let (strength, nearby) = (1.0, Nearby::default());
        let mut dent = Dent { strength, alone: 1.0, wide: 0.0, contact, examples, parts: Vec::new(), nearby };
        dent.widen(set, 1.0);
        dent
    }

    fn of_prediction(set: &ExampleSet, mark: &Mark) -> Self {
        Dent {
            strength: 1.0,
            alone: 1.0,
            wide: 1.0,
            contact: set.mesh().positions()[mark.contact as usize],
            examples: ArrayVec::new(),
            parts: predicted(set, mark).map(|p| Part::Predicted(p.predicted.field, p.scale)).into_iter().collect(),
            nearby: Nearby::default(),
        }
    }

    /// Sets the factor for the stretch. A prediction has none.
    pub(crate) fn widen(&mut self, set: &ExampleSet, wide: f32) {
        if self.wide == wide {
            return;
        }
        if let [Part::Predicted(..)] = &self.parts[..] {
            self.wide = wide;
            return;
        }
        self.wide = wide;
        self.parts.clear();
        let mut carried: ArrayVec<(usize, f32, Placement), MAX_PAIRS> = ArrayVec::new();
        for p in self.examples.iter() {
            if let Some(at) = p.carried {
                carried.push((p.example, p.scale, Placement { stretch: limited(at.stretch * wide), ..at }));
            }
        }
        self.parts.extend(Carried::new(set, &carried).map(Part::Carried));
        for p in self.examples.iter().filter(|p| p.carried.is_none()) {
            let e = &set.examples()[p.example];
            let own = Placement { contact: e.contact_point(), frame: e.frame(), stretch: limited(wide) };
            // Stamps close torn seams.
            let widened = (wide > 1.0 && set.options().seams == Seams::Weld)
                .then(|| Carried::new(set, &[(p.example, p.scale, own)]))
                .flatten();
            self.parts.push(widened.map_or(Part::Anchored(p.example, p.scale), Part::Carried));
        }
    }

    /// Displacement of the base vertex `v` by the mark's hit alone, without held rims, m.
    pub(crate) fn alone_at(&self, set: &ExampleSet, v: u32) -> Vec3 {
        let p = set.mesh().positions()[v as usize];
        if let ([Part::Predicted(field, scale)], Some(rows)) = (&self.parts[..], &set.base_lod().rows) {
            return field.at_vertex(rows, v) * *scale;
        }
        let part = |part: &PlacedExample| match &part.carried {
            Some(at) => at.alone(set, part.example, p) * part.scale,
            None => set.examples()[part.example].displacement_at(v, p) * part.scale,
        };
        self.examples.iter().fold(Vec3::ZERO, |sum, p| sum + part(p))
    }

    /// The region where the dent may move vertices.
    pub(crate) fn reach(&self) -> Reach {
        let radius = |p: &Part| match p {
            Part::Carried(c) => c.radius() + (c.contact - self.contact).length(),
            Part::Anchored(..) | Part::Predicted(..) => f32::INFINITY,
        };
        let radius = self.parts.iter().map(radius).fold(0.0, f32::max);
        Reach { contact: self.contact, square: radius * radius }
    }

    /// Squared distance from the contact beyond which a hit alone moves nothing that counts as an overlap, m².
    pub(crate) fn own_reach_square(&self, set: &ExampleSet) -> f32 {
        let ([Part::Predicted(field, _)], Some(nodes)) = (&self.parts[..], set.nodes()) else {
            return self.reach().square;
        };
        // Dents overlap where they move a contact by a third of their depth. A tenth of it leaves room for vertices between nodes.
        let longest = field.moved().map(|(_, u)| u.length_squared()).fold(0.0, f32::max);
        let far = field.moved().filter(|(_, u)| u.length_squared() >= 0.01 * longest);
        far.map(|(n, _)| nodes.lod.mesh.positions()[n as usize].distance_squared(self.contact)).fold(0.0, f32::max)
    }

    /// Number of stamps that a vertex is looked up in.
    pub(crate) fn lookups(&self) -> usize {
        self.parts.iter().map(|p| if let Part::Carried(c) = p { c.lookups.len() } else { 0 }).sum()
    }

    /// Whether an anchored example with this scale is shown on a level of detail: whether any of its displacements may
    /// exceed `threshold` (m). Always true for 0.
    pub(crate) fn shows_anchored(&self, lod: &MeshLod, (example, scale): (usize, f32), threshold: f32) -> bool {
        let scale = (scale * self.strength).abs();
        threshold == 0.0 || scale == 0.0 || lod.anchored[example].exceeds(threshold / scale)
    }

    /// The same for a carried example.
    pub(crate) fn shows_carried(&self, lookup: &Lookup, threshold: f32) -> bool {
        threshold == 0.0 || lookup.longest * self.strength > threshold
    }

    /// Calls `f` for every example and every block it may move, with an upper bound of its displacements there, m.
    pub(crate) fn lengths(&self, lod: &MeshLod, mut f: impl FnMut(usize, f32)) {
        for part in &self.parts {
            match part {
                Part::Carried(c) => {
                    for (b, bounds) in lod.block_bounds.iter().enumerate() {
                        c.reaching(bounds).for_each(|l| f(b, l.longest * self.strength));
                    }
                }
                Part::Anchored(example, scale) => {
                    let scale = (scale * self.strength).abs();
                    lod.anchored[*example].heads.iter().for_each(|h| f(h.block as usize, h.longest * scale));
                }
                Part::Predicted(..) => {}
            }
        }
    }

    /// Sets the epoch of every block that an example longer than `threshold` (m) may move. 0 includes all examples.
    pub(crate) fn mark_blocks(&self, lod: &MeshLod, threshold: f32, epochs: &mut [u64], epoch: u64) {
        for part in &self.parts {
            match part {
                Part::Carried(c) => {
                    let reach = c.radius() * c.radius();
                    // A hit changes dents near it, which move the same blocks: most are marked already.
                    for (at, bounds) in epochs.iter_mut().zip(&*lod.block_bounds).filter(|(at, _)| **at != epoch) {
                        let near = bounds.distance_squared(c.contact) <= reach;
                        if near && c.reaching(bounds).any(|l| self.shows_carried(l, threshold)) {
                            *at = epoch;
                        }
                    }
                }
                Part::Anchored(example, scale) if self.shows_anchored(lod, (*example, *scale), threshold) => {
                    lod.anchored[*example].heads.iter().for_each(|h| epochs[h.block as usize] = epoch);
                }
                Part::Anchored(..) => {}
                // Vertices follow nodes, so the mesh is that of the nodes.
                Part::Predicted(field, _) => {
                    field.nodes().iter().for_each(|n| epochs[*n as usize / BLOCK] = epoch);
                }
            }
        }
    }

    /// The nodes that predictions of the dent move, and their displacements, m.
    pub(crate) fn predicted(&self) -> impl Iterator<Item = (u32, Vec3)> {
        self.parts
            .iter()
            .flat_map(|part| match part {
                Part::Predicted(field, scale) => {
                    let scale = scale * self.strength;
                    Some(field.moved().map(move |(n, u)| (n, u * scale)))
                }
                _ => None,
            })
            .flatten()
    }

    /// Memory that the dent holds, bytes.
    pub(crate) fn memory_bytes(&self) -> usize {
        let own = |p: &Part| match p {
            Part::Carried(c) => c.lookups.capacity() * size_of::<Lookup>(),
            Part::Predicted(field, _) => field.bytes(),
            Part::Anchored(..) => 0,
        };
        size_of::<Self>() + self.parts.capacity() * size_of::<Part>() + self.parts.iter().map(own).sum::<usize>()
    }
}

/// A sphere outside which a dent moves nothing. Its radius is infinite if the dent has an anchored example.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Reach {
    pub contact: Vec3,
    /// Squared radius, m².
    pub square: f32,
}

impl Reach {
    /// Whether the dent may move vertices in a box.
    #[inline(always)]
    pub(crate) fn meets(&self, bounds: &Aabb) -> bool {
        bounds.distance_squared(self.contact) <= self.square
    }
}

impl Placement {
    /// Unscaled displacement of a vertex at base position `v` by one hit alone, m.
    pub(crate) fn alone(&self, set: &ExampleSet, example: usize, v: Vec3) -> Vec3 {
        let at = Placement { stretch: limited(self.stretch), ..*self };
        set.examples()[example].stamp().map_or(Vec3::ZERO, |s| at.displacement(s, v))
    }
}

/// A stretch within its limits.
pub(crate) fn limited(stretch: f32) -> f32 {
    stretch.clamp(STRETCH.0, STRETCH.1)
}

/// A mark's parts, placed and scaled.
pub(crate) struct PlacedMark {
    pub parts: ArrayVec<PlacedExample, MAX_PAIRS>,
    /// The parts' displacement of the contact, m.
    pub achieved: Vec3,
    /// The displacement of the contact if no rim were held, m.
    pub without_rim: Vec3,
}

/// For each carried pair of a mark, the rotation from its stamp's frame to mesh space, with a reflection if the pair is
/// mirrored. It does not depend on the depth.
pub(crate) fn frame_rotations(set: &ExampleSet, contact: u32, pairs: &[Pair; MAX_PAIRS]) -> [Mat3; MAX_PAIRS] {
    let n = set.mesh().contact_normal(contact).unwrap_or(Vec3::Z);
    pairs.map(|pair| {
        if pair.is_none() || pair.is_anchored() {
            return Mat3::IDENTITY;
        }
        let (e, mirror) = (&set.examples()[pair.example as usize], pair.mirror());
        let own = e.contact_normal().unwrap_or(Vec3::Z);
        rotation_between(mirror.direction(own), n) * mirror.matrix() * e.frame()
    })
}

/// Places and scales the parts of a mark. `rotations` are the [`frame_rotations`] of its pairs.
pub(crate) fn place(
    set: &ExampleSet,
    contact: u32,
    depth: f32,
    pairs: &[Pair; MAX_PAIRS],
    rotations: &[Mat3; MAX_PAIRS],
) -> PlacedMark {
    let c = set.mesh().positions()[contact as usize];
    let mut parts: ArrayVec<PlacedExample, MAX_PAIRS> = ArrayVec::new();
    let mut at_contact = [Vec3::ZERO; MAX_PAIRS];
    let mut sum = Vec3::ZERO;
    for (pair, rotation) in pairs.iter().zip(rotations).filter(|(p, _)| !p.is_none()) {
        let example = pair.example as usize;
        let e = &set.examples()[example];
        let (size, carried, u) = if pair.is_anchored() {
            let u = e.displacement_at(contact, c);
            (depth / u.length(), None, u)
        } else {
            let size = depth / e.depth();
            // The stamp at its own contact, whatever the stretch.
            let u = e.stamp().map_or(Vec3::ZERO, |s| *rotation * s.centre);
            let carried = Placement { contact: c, frame: *rotation, stretch: size.sqrt() };
            (size, Some(carried), u)
        };
        let scale = pair.share_fraction() * size;
        // Only a corrupt file can contain an anchored example that does not move the contact.
        if !scale.is_finite() {
            continue;
        }
        at_contact[parts.len()] = u;
        sum += u * scale;
        parts.push(PlacedExample { example, scale, carried });
    }
    let together = depth / sum.length();
    // Limits the scale of examples that cancel each other at the contact and so cannot reach the depth.
    let together = if together.is_finite() { together.min(4.0) } else { 1.0 };
    let held = set.rim().at(contact).factor;
    let (mut achieved, mut without_rim) = (Vec3::ZERO, Vec3::ZERO);
    for (p, u) in parts.iter_mut().zip(at_contact) {
        p.scale *= together;
        if (p.scale - 1.0).abs() < 1e-6 {
            p.scale = 1.0;
        }
        if p.carried.is_none() {
            p.scale = p.scale.clamp(-1.0, 1.0);
        }
        without_rim += u * p.scale;
        achieved += u * (if p.carried.is_some() { p.scale * held } else { p.scale });
    }
    PlacedMark { parts, achieved, without_rim }
}
