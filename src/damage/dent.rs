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
//! so that the contact gets the target depth. Anchored examples are never scaled above 1; in a strict set no example
//! is. Carried examples fade to zero towards held rims ([`crate::mesh::rim`]).

use super::mark::{MAX_PAIRS, Mark, Pair};
use crate::base::array_vec::ArrayVec;
use crate::base::math::{Aabb, rotation_between};
use crate::example::mesh_lod::MeshLod;
use crate::example::options::Seams;
use crate::example::set::ExampleSet;
use crate::example::stamp::{WEIGHTS, lift};
use glam::{Mat3, UVec2, Vec2, Vec3};

/// Limits of a carried example's stretch along the surface.
const STRETCH: (f32, f32) = (0.25, 4.0);
/// Share by which boxes are enlarged before they are tested against a stamp. Far more than rounding errors.
const ROUNDING: f32 = 1e-4;

/// One example of a dent, placed and scaled.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct PlacedExample {
    pub example: usize,
    /// Factor for its displacements.
    pub scale: f32,
    /// Whether the example is anchored in the mark.
    pub anchored: bool,
    /// `None` if the example's own displacements are read.
    pub carried: Option<Carried>,
}

/// The placement of a carried example.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Carried {
    pub contact: Vec3,
    /// From mesh space, relative to the contact, to the stamp's frame. Undoes the stretch.
    pub to_stamp: Mat3,
    /// Factor from unrolled coordinates to grid cells, and the grid's origin in cells, which is then subtracted.
    pub per_cell: Vec2,
    pub grid_origin: Vec2,
    /// Largest coordinates on the grid, cells.
    pub grid_top: Vec2,
    /// From the stamp's frame to mesh space.
    from_stamp: Mat3,
    /// From weighted sums of a stamp's numbers to displacements and to changes of normals, in mesh space. Changes of
    /// normals are divided by the stretch, because slopes decrease as a dent gets wider.
    pub displacement: Mat3,
    pub normal_change: Mat3,
    /// From weighted sums of a stamp's numbers to heights, m.
    pub height: f32,
    /// 2 divided by the stamp's fade, 1/m.
    pub fade: f32,
    /// Range of z in the stamp's frame outside which nothing is moved, m.
    heights: (f32, f32),
    /// The stamp's z in mesh space.
    pub up: Vec3,
    /// Distance from the contact beyond which nothing is moved, m.
    radius: f32,
    /// The stretch of a hit alone, before it is limited.
    stretch: f32,
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
    pub parts: ArrayVec<PlacedExample, MAX_PAIRS>,
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
        let parts =
            place(set, mark.contact, mark.depth, &mark.pairs, &frame_rotations(set, mark.contact, &mark.pairs)).parts;
        let contact = set.mesh().positions()[mark.contact as usize];
        Dent { strength: 1.0, alone: 1.0, wide: 1.0, contact, parts, nearby: Nearby::default() }
    }

    /// Sets the factor for the stretch.
    pub(crate) fn widen(&mut self, set: &ExampleSet, wide: f32) {
        if self.wide == wide {
            return;
        }
        self.wide = wide;
        for p in self.parts.iter_mut() {
            let e = &set.examples()[p.example];
            p.carried = match &p.carried {
                Some(c) if !p.anchored => Some(Carried::new(set, p.example, c.from_stamp, c.contact, c.stretch, wide)),
                // Stamps close torn seams.
                _ if wide > 1.0 && e.stamp().is_some() && set.options().seams == Seams::Weld => {
                    Some(Carried::new(set, p.example, e.frame(), e.contact_point(), 1.0, wide))
                }
                _ => None,
            };
        }
    }

    /// Displacement of the base vertex `v` by the mark's hit alone, without held rims, m.
    pub(crate) fn alone_at(&self, set: &ExampleSet, v: u32) -> Vec3 {
        let p = set.mesh().positions()[v as usize];
        let part = |part: &PlacedExample| match &part.carried {
            Some(c) if !part.anchored => c.alone_at(set, part.example, p) * part.scale,
            _ => set.examples()[part.example].displacement_at(v, p) * part.scale,
        };
        self.parts.iter().fold(Vec3::ZERO, |sum, p| sum + part(p))
    }

    /// The region where the dent may move vertices.
    pub(crate) fn reach(&self) -> Reach {
        let radius = |p: &PlacedExample| match &p.carried {
            Some(c) => c.radius + (c.contact - self.contact).length(),
            None => f32::INFINITY,
        };
        let radius = self.parts.iter().map(radius).fold(0.0, f32::max);
        Reach { contact: self.contact, square: radius * radius }
    }

    /// Whether part `p` is shown on a level of detail: whether any of its scaled displacements may exceed `threshold`
    /// (m). Always true for 0.
    pub(crate) fn counts(&self, set: &ExampleSet, lod: &MeshLod, p: &PlacedExample, threshold: f32) -> bool {
        let scale = (p.scale * self.strength).abs();
        threshold == 0.0
            || scale == 0.0
            || match &p.carried {
                Some(_) => set.examples()[p.example].stamp().is_none_or(|s| s.longest > threshold / scale),
                None => lod.anchored[p.example].exceeds(threshold / scale),
            }
    }

    /// Calls `f` for every part and every block it may move, with an upper bound of its displacements there, m.
    pub(crate) fn lengths(&self, set: &ExampleSet, lod: &MeshLod, mut f: impl FnMut(usize, f32)) {
        self.parts.iter().for_each(|p| self.part_lengths(set, lod, p, &mut f));
    }

    /// Calls `f` for every block that a part longer than `threshold` (m) may move. 0 includes all parts. `f` may get a
    /// block more than once.
    pub(crate) fn blocks(&self, set: &ExampleSet, lod: &MeshLod, threshold: f32, mut f: impl FnMut(usize)) {
        let counts = self.parts.iter().filter(|p| self.counts(set, lod, p, threshold));
        counts.for_each(|p| self.part_lengths(set, lod, p, &mut |b, _| f(b)));
    }

    fn part_lengths(&self, set: &ExampleSet, lod: &MeshLod, p: &PlacedExample, f: &mut impl FnMut(usize, f32)) {
        let scale = (p.scale * self.strength).abs();
        match &p.carried {
            Some(c) => {
                let longest = set.examples()[p.example].stamp().map_or(0.0, |s| s.longest) * scale;
                let reached = (0..lod.blocks()).filter(|b| c.reaches(&lod.block_bounds[*b]));
                reached.for_each(|b| f(b, longest));
            }
            None => {
                lod.anchored[p.example].heads.iter().for_each(|h| f(h.block as usize, h.longest * scale));
            }
        }
    }
}

/// A sphere outside which a dent moves nothing. Its radius is infinite if the dent has an anchored example.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Reach {
    pub contact: Vec3,
    /// Squared radius, m².
    pub square: f32,
}

impl Carried {
    const NOTHING: Carried = Carried {
        contact: Vec3::ZERO,
        to_stamp: Mat3::ZERO,
        per_cell: Vec2::ONE,
        grid_origin: Vec2::ZERO,
        grid_top: Vec2::ZERO,
        from_stamp: Mat3::ZERO,
        displacement: Mat3::ZERO,
        normal_change: Mat3::ZERO,
        height: 0.0,
        fade: 0.0,
        heights: (0.0, 0.0),
        up: Vec3::Z,
        radius: 0.0,
        stretch: 1.0,
    };

    /// `alone` is the stretch of a hit alone, before it is limited.
    fn new(set: &ExampleSet, example: usize, from_stamp: Mat3, contact: Vec3, alone: f32, wide: f32) -> Self {
        let e = &set.examples()[example];
        let stretch = limited(alone * wide);
        let to_stamp = to_stamp(&from_stamp, stretch);
        let c = Carried { contact, to_stamp, from_stamp, stretch: alone, ..Carried::NOTHING };
        // Only anchored examples lack a stamp, and they are not carried.
        let Some(s) = e.stamp() else { return c };
        let unit = |step: Vec3| Mat3::from_diagonal(step * (1.0 / WEIGHTS));
        Carried {
            per_cell: 1.0 / s.grid.cell,
            grid_origin: s.grid.origin / s.grid.cell,
            grid_top: (s.grid.dims - UVec2::ONE).as_vec2(),
            displacement: from_stamp * unit(s.steps.displacement),
            normal_change: from_stamp * unit(s.steps.normal) * (1.0 / stretch),
            height: s.steps.height * (1.0 / WEIGHTS),
            fade: 2.0 / s.fade,
            heights: (s.heights.0 - s.fade, s.heights.1 + s.fade),
            up: from_stamp.z_axis,
            radius: s.reach(stretch),
            ..c
        }
    }

    /// Whether the stamp may move anything in the box. The box must meet the stamp's sphere and, in the stamp's frame,
    /// must not lie entirely above, below or beside the stamp.
    pub(crate) fn reaches(&self, bounds: &Aabb) -> bool {
        if bounds.distance_squared(self.contact) > self.radius * self.radius {
            return false;
        }
        // Subtract first, which loses no precision far from the origin.
        let centre = self.to_stamp * ((bounds.min - self.contact + (bounds.max - self.contact)) * 0.5);
        let half = self.to_stamp.abs() * ((bounds.max - bounds.min) * 0.5);
        let half = half * (1.0 + ROUNDING) + Vec3::splat(self.radius * ROUNDING);
        let (low, high) = (centre - half, centre + half);
        if low.z > self.heights.1 || high.z < self.heights.0 {
            return false;
        }
        // The steepest point that the box could contain bounds how far unrolling moves any of its points outwards.
        let across = low.truncate().max(-high.truncate()).max(Vec2::ZERO).length_squared();
        let up = low.z.abs().max(high.z.abs());
        let lift = lift(up, across) + ROUNDING;
        let low = low.truncate().min(low.truncate() * lift) * self.per_cell - self.grid_origin;
        let high = high.truncate().max(high.truncate() * lift) * self.per_cell - self.grid_origin;
        high.cmpge(Vec2::ZERO).all() && low.cmple(self.grid_top).all()
    }

    /// Unscaled displacement of a vertex at base position `v`, m.
    pub(crate) fn at(&self, set: &ExampleSet, example: usize, v: Vec3) -> Vec3 {
        self.read(set, example, &self.to_stamp, v)
    }

    /// The same by a hit alone.
    fn alone_at(&self, set: &ExampleSet, example: usize, v: Vec3) -> Vec3 {
        self.read(set, example, &to_stamp(&self.from_stamp, limited(self.stretch)), v)
    }

    fn read(&self, set: &ExampleSet, example: usize, to_stamp: &Mat3, v: Vec3) -> Vec3 {
        let stamp = set.examples()[example].stamp();
        stamp.map_or(Vec3::ZERO, |s| self.from_stamp * s.displacement(*to_stamp * (v - self.contact)))
    }
}

/// A stretch within its limits.
pub(crate) fn limited(stretch: f32) -> f32 {
    stretch.clamp(STRETCH.0, STRETCH.1)
}

/// From mesh space, relative to the contact, to the stamp's frame.
fn to_stamp(from_stamp: &Mat3, stretch: f32) -> Mat3 {
    Mat3::from_diagonal(Vec3::new(1.0 / stretch, 1.0 / stretch, 1.0)) * from_stamp.transpose()
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
            let carried = Carried::new(set, example, *rotation, c, size.sqrt(), 1.0);
            // The stamp at its own contact, whatever the stretch.
            let u = e.stamp().map_or(Vec3::ZERO, |s| *rotation * s.centre);
            (size, Some(carried), u)
        };
        let scale = pair.share_fraction() * size;
        // Only a corrupt file can contain an anchored example that does not move the contact.
        if !scale.is_finite() {
            continue;
        }
        at_contact[parts.len()] = u;
        sum += u * scale;
        parts.push(PlacedExample { example, scale, anchored: pair.is_anchored(), carried });
    }
    let together = depth / sum.length();
    // Limits the scale of examples that cancel each other at the contact and so cannot reach the depth.
    let together = if together.is_finite() { together.min(4.0) } else { 1.0 };
    let strict = set.options().strict;
    let held = set.rim().at(contact).factor;
    let (mut achieved, mut without_rim) = (Vec3::ZERO, Vec3::ZERO);
    for (p, u) in parts.iter_mut().zip(at_contact) {
        p.scale *= together;
        if (p.scale - 1.0).abs() < 1e-6 {
            p.scale = 1.0;
        }
        if strict || p.carried.is_none() {
            p.scale = p.scale.clamp(-1.0, 1.0);
        }
        without_rim += u * p.scale;
        achieved += u * (if p.carried.is_some() { p.scale * held } else { p.scale });
    }
    PlacedMark { parts, achieved, without_rim }
}
