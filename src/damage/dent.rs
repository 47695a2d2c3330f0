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

use super::mark::{MAX_PAIRS, Mark, Pair};
use super::told::predicted;
use crate::base::array_vec::ArrayVec;
use crate::base::math::{Four, dots, rotation_between, side_by_side, squares};
use crate::basis::field::{GROUP, NodeField};
use crate::example::mesh_lod::MeshLod;
use crate::example::set::ExampleSet;
use crate::example::stamp::{Reader, Stamp};
use crate::mesh::rim::WindowBlock;
use crate::mesh::vertex_blocks::{BLOCK, block_range};
use glam::{Mat3, Vec3, Vec4};
use std::ops::Range;
use std::sync::Arc;

/// Limits of a carried example's stretch along the surface.
const STRETCH: (f32, f32) = (0.25, 4.0);

/// Where a stamp is applied, and how.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Placement {
    /// Where the stamp's contact lies, m.
    pub contact: Vec3,
    /// From the stamp's frame to mesh space: a rotation, with a reflection if the example is mirrored.
    pub frame: Mat3,
    /// How many times as wide along the surface.
    pub stretch: f32,
}

impl Default for Placement {
    fn default() -> Self {
        Placement { contact: Vec3::ZERO, frame: Mat3::IDENTITY, stretch: 1.0 }
    }
}

impl Placement {
    /// Unscaled displacement of a vertex at base position `v`, m.
    pub(crate) fn displacement(&self, stamp: &Stamp, v: Vec3) -> Vec3 {
        let p = self.frame.transpose() * (v - self.contact);
        self.frame * stamp.displacement(Vec3::new(p.x / self.stretch, p.y / self.stretch, p.z))
    }

    /// The same by one hit alone.
    pub(crate) fn alone(&self, set: &ExampleSet, example: usize, v: Vec3) -> Vec3 {
        let at = Placement { stretch: limited(self.stretch), ..*self };
        set.examples()[example].stamp().map_or(Vec3::ZERO, |s| at.displacement(s, v))
    }
}

/// One example of a dent, placed and scaled.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct PlacedExample {
    pub example: usize,
    /// Factor for its displacements.
    pub scale: f32,
    /// `None` if the example is anchored.
    pub carried: Option<Placement>,
}

/// A mark prepared for evaluation: the nodes that it moves.
#[derive(Debug, Clone)]
pub(crate) struct Dent {
    /// Factor for the field. Repeated hits and hits nearby change it.
    pub strength: f32,
    /// The strength if there were no other mark.
    pub alone: f32,
    /// Factor for the stretch of all examples; 1 for a hit alone.
    pub wide: f32,
    pub contact: Vec3,
    /// The mark's examples as one hit alone places them; none if the set predicts the hit.
    examples: ArrayVec<PlacedExample, MAX_PAIRS>,
    field: Arc<NodeField>,
    /// Factor with which the field has the mark's depth.
    scale: f32,
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
    /// Makes the dent of one hit of a mark. It has a field once it is [widened](Dent::widen). The mark must be valid.
    pub(crate) fn of_one_hit(set: &ExampleSet, mark: &Mark) -> Self {
        let contact = set.mesh().positions()[mark.contact as usize];
        let (strength, alone, wide, nearby) = (1.0, 1.0, 0.0, Nearby::default());
        if mark.is_predicted() {
            let (field, scale) = predicted(set, mark).map(|p| (p.predicted.field, p.scale)).unwrap_or_default();
            return Dent { strength, alone, wide, contact, examples: ArrayVec::new(), field, scale, nearby };
        }
        let rotations = frame_rotations(set, mark.contact, &mark.pairs);
        let examples = place(set, mark.contact, mark.depth, &mark.pairs, &rotations).parts;
        Dent { strength, alone, wide, contact, examples, field: Arc::default(), scale: 1.0, nearby }
    }

    /// Sets the factor for the stretch. A prediction has none.
    pub(crate) fn widen(&mut self, set: &ExampleSet, wide: f32) {
        if self.wide != wide && !self.examples.is_empty() {
            self.field = Arc::new(node_field(set, &self.examples, wide));
        }
        self.wide = wide;
    }

    /// The nodes that the dent moves, and what their displacements are multiplied by.
    pub(crate) fn field(&self) -> (&Arc<NodeField>, f32) {
        (&self.field, self.scale * self.strength)
    }

    /// Displacement of the base vertex `v` by the mark's hit alone, without held rims, m.
    pub(crate) fn alone_at(&self, set: &ExampleSet, v: u32) -> Vec3 {
        if self.examples.is_empty() {
            return self.field.at_vertex(&set.base_lod().rows, v) * self.scale;
        }
        let p = set.mesh().positions()[v as usize];
        let part = |part: &PlacedExample| match &part.carried {
            Some(at) => at.alone(set, part.example, p) * part.scale,
            None => set.examples()[part.example].displacement_at(v, p) * part.scale,
        };
        self.examples.iter().fold(Vec3::ZERO, |sum, p| sum + part(p))
    }

    /// Squared distance from the contact beyond which a hit alone moves nothing that counts as an overlap, m².
    pub(crate) fn own_reach_square(&self, set: &ExampleSet) -> f32 {
        if !self.examples.is_empty() {
            let radius = |p: &PlacedExample| match p.carried {
                Some(at) => set.examples()[p.example].stamp().map_or(0.0, |s| s.reach(limited(at.stretch))),
                None => f32::INFINITY,
            };
            let radius = self.examples.iter().map(radius).fold(0.0, f32::max);
            return radius * radius;
        }
        let nodes = &set.nodes().lod;
        // Dents overlap where they move a contact by a third of their depth. A tenth of it leaves room for vertices between nodes.
        let far = self.field.moved_most(0.1);
        far.map(|n| nodes.mesh.positions()[n as usize].distance_squared(self.contact)).fold(0.0, f32::max)
    }

    /// Memory that the dent holds, bytes.
    pub(crate) fn memory_bytes(&self) -> usize {
        size_of::<Self>() + self.field.bytes()
    }

    /// The vertices of a mesh that one hit alone moves by examples, ascending, and their displacements, m.
    pub(crate) fn alone_on(&self, set: &ExampleSet, mesh: &MeshLod) -> Vec<(u32, Vec3)> {
        let mut moved = Vec::with_capacity(mesh.vertex_count());
        by_examples(set, &self.examples, 1.0, mesh, |vertices, sums| {
            let own = vertices.zip(0..).map(|(v, i)| (v as u32, Vec3::from([0, 1, 2].map(|k| sums[k][i]))));
            moved.extend(own.filter(|(_, u)| *u != Vec3::ZERO));
        });
        moved
    }
}

/// The nodes that placed examples move, stretched by a factor.
fn node_field(set: &ExampleSet, examples: &[PlacedExample], wide: f32) -> NodeField {
    let nodes = &set.nodes().lod;
    let mut groups = Vec::with_capacity(nodes.vertex_count().div_ceil(GROUP));
    by_examples(set, examples, wide, nodes, |nodes, sums| {
        let [x, y, z] = sums.each_ref().map(|along| along.as_chunks::<GROUP>().0);
        let own = x.iter().zip(y).zip(z).map(|((x, y), z)| [*x, *y, *z]);
        groups.extend(((nodes.start / GROUP) as u32..).zip(own).take(nodes.len().div_ceil(GROUP)));
    });
    NodeField::new(&groups)
}

/// Calls `f` with the vertices of each block of a mesh that placed examples, stretched by a factor, may move, and with their displacements.
/// Those behind the last vertex do not move.
fn by_examples(
    set: &ExampleSet,
    examples: &[PlacedExample],
    wide: f32,
    mesh: &MeshLod,
    mut f: impl FnMut(Range<usize>, &Sums),
) {
    let mut placed = [None; MAX_PAIRS];
    examples.iter().zip(&mut placed).for_each(|(p, to)| *to = Carried::of(set, p, wide));
    for (block, bounds) in mesh.block_bounds.iter().enumerate() {
        let range = block_range(block, mesh.vertex_count());
        let mut sums: Sums = [[0.0; BLOCK]; 3];
        let mut any = false;
        for (p, carried) in examples.iter().zip(&placed) {
            if let Some(carried) = carried {
                if bounds.distance_squared(carried.contact) <= carried.reach_square {
                    any = true;
                    carried.add(&mesh.mesh.positions()[range.clone()], mesh.rim.block(block), &mut sums);
                }
            } else if let Some(head) = mesh.anchored[p.example].block(block as u32) {
                any = true;
                let stored = mesh.anchored[p.example].displacements(head);
                for i in 0..range.len() {
                    let moved = (stored.at(i) * p.scale).to_array();
                    sums.iter_mut().zip(moved).for_each(|(sum, u)| sum[i] += u);
                }
            }
        }
        if any {
            f(range, &sums);
        }
    }
}

/// An example read from its stamp, prepared for many points.
#[derive(Clone, Copy)]
struct Carried<'a> {
    reader: Reader<'a>,
    contact: Vec3,
    /// From mesh space, relative to the contact, to the stamp's frame.
    to_frame: Mat3,
    /// From the stamp's frame to mesh space, scaled.
    back: Mat3,
    /// Squared distance from the contact beyond which nothing moves, m².
    reach_square: f32,
}

impl<'a> Carried<'a> {
    /// `None` for an example where it was made; one that is wider than it was made is read from its stamp.
    fn of(set: &'a ExampleSet, placed: &PlacedExample, wide: f32) -> Option<Self> {
        let e = &set.examples()[placed.example];
        let stamp = e.stamp()?;
        let own = Placement { contact: e.contact_point(), frame: e.frame(), stretch: 1.0 };
        let at = match placed.carried {
            Some(at) => at,
            None if wide > 1.0 => own,
            None => return None,
        };
        let stretch = limited(at.stretch * wide);
        let reach = stamp.reach(stretch);
        Some(Carried {
            reader: stamp.reader(stretch),
            contact: at.contact,
            to_frame: at.frame.transpose(),
            back: at.frame * placed.scale,
            reach_square: reach * reach,
        })
    }

    /// Adds the scaled displacements (m) of a block's points, of which rims let only shares move, to `sums`.
    fn add(&self, points: &[Vec3], held: Option<&WindowBlock>, sums: &mut Sums) {
        let rows = [0, 1, 2].map(|k| (self.to_frame.row(k), self.back.row(k)));
        for (first, points) in (0..).step_by(4).zip(points.chunks(4)) {
            // Missing points are outside.
            let at = side_by_side(points, f32::INFINITY);
            let at: Four = std::array::from_fn(|k| at[k] - self.contact[k]);
            let near = squares(&at).cmple(Vec4::splat(self.reach_square));
            if !near.any() {
                continue;
            }
            let moved = self.reader.read(rows.map(|(row, _)| dots(&at, row)));
            let share = held.map_or(Vec4::ONE, |held| Vec4::from_slice(&held[first..]));
            for (sum, (_, row)) in sums.iter_mut().zip(rows) {
                let sum = &mut sum[first..first + 4];
                let more = Vec4::select(near, dots(&moved, row) * share, Vec4::ZERO);
                (Vec4::from_slice(sum) + more).write_to_slice(sum);
            }
        }
    }
}

/// Displacements of a block's vertices along x, y and z, m.
type Sums = [[f32; BLOCK]; 3];

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
    let held = set.rim().at(contact);
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
