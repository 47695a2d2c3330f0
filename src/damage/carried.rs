//! Carried examples of a dent that act at one contact. They share a frame with z along the normal and differ by
//! rotations in the surface. So a vertex is turned into the frame once, unrolled with one division, and looked up in
//! each example's stamp; what the look-ups find is added and turned back once.

use crate::base::math::Aabb;
use crate::example::set::ExampleSet;
use crate::example::stamp::{MOST, Stamp, WEIGHTS, lift};
use glam::{Mat2, Mat3, UVec2, Vec2, Vec3};

/// Share by which boxes are enlarged before they are tested against a stamp. Far more than rounding errors.
const ROUNDING: f32 = 1e-4;

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
}

/// Examples carried to one contact.
#[derive(Debug, Clone)]
pub(crate) struct Carried {
    pub contact: Vec3,
    /// From mesh space, relative to the contact, to the shared frame.
    pub to_frame: Mat3,
    pub lookups: Vec<Lookup>,
}

/// How an example is read from its stamp, and what becomes of the numbers found there.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct Lookup {
    pub example: usize,
    /// Square of the stretch.
    pub stretch_square: f32,
    /// From the shared frame to the stamp's grid, in units of 1 / [`WEIGHTS`] cells: the matrix, and the grid's origin,
    /// which is then subtracted.
    pub to_grid: Mat2,
    pub origin: Vec2,
    /// The largest coordinates on the grid, in the same units, and the number of nodes along x and y.
    pub last: Vec2,
    pub dims: UVec2,
    /// From weighted sums of the stamp's numbers to heights, m.
    pub height: f32,
    /// 2 divided by the stamp's fade, 1/m.
    pub fade: f32,
    /// From weighted sums to scaled displacements (m) and changes of normals in the shared frame: in the surface, and
    /// along z. Changes of normals are divided by the stretch, because slopes decrease as a dent gets wider.
    pub displacement: Mat2,
    pub displacement_z: f32,
    pub normal_change: Mat2,
    pub normal_change_z: f32,
    /// Upper bound of the length of scaled displacements, m.
    pub longest: f32,
    /// Upper bound of the length of scaled changes of normals.
    pub steepest: f32,
    /// Range of z outside which nothing is moved, m.
    heights: (f32, f32),
    /// Distance from the contact beyond which nothing is moved, m.
    radius: f32,
}

impl Carried {
    /// Prepares examples with scales and placements at one contact with one normal. `None` if none of them has a stamp.
    pub(super) fn new(set: &ExampleSet, examples: &[(usize, f32, Placement)]) -> Option<Self> {
        let mut carried: Option<Carried> = None;
        for (example, scale, at) in examples {
            let Some(stamp) = set.examples()[*example].stamp() else { continue };
            let (contact, to_frame) = (at.contact, at.frame.transpose());
            let carried = carried.get_or_insert(Carried { contact, to_frame, lookups: Vec::new() });
            carried.lookups.push(Lookup::new(*example, *scale, stamp, carried.to_frame * at.frame, at.stretch));
        }
        carried
    }

    /// Distance from the contact beyond which nothing is moved, m.
    pub(super) fn radius(&self) -> f32 {
        self.lookups.iter().map(|l| l.radius).fold(0.0, f32::max)
    }

    /// The look-ups that may move anything in the box. The box must meet a look-up's sphere and, in the frame, must not
    /// lie entirely above, below or beside its stamp.
    pub(crate) fn reaching(&self, bounds: &Aabb) -> impl Iterator<Item = &Lookup> {
        let distance = bounds.distance_squared(self.contact);
        // Subtract first, which loses no precision far from the origin.
        let centre = self.to_frame * ((bounds.min - self.contact + (bounds.max - self.contact)) * 0.5);
        let half = self.to_frame.abs() * ((bounds.max - bounds.min) * 0.5);
        self.lookups.iter().filter(move |l| distance <= l.radius * l.radius && l.reaches(centre, half))
    }
}

impl Lookup {
    /// `turn` goes from the stamp's frame to the shared one.
    fn new(example: usize, scale: f32, stamp: &Stamp, turn: Mat3, stretch: f32) -> Self {
        let turn = Mat2::from_cols(turn.x_axis.truncate(), turn.y_axis.truncate());
        let (grid, steps) = (&stamp.grid, &stamp.steps);
        let unit = |step: Vec3, scale: f32| {
            let step = step * (scale / WEIGHTS);
            (turn * Mat2::from_diagonal(step.truncate()), step.z)
        };
        let (displacement, displacement_z) = unit(steps.displacement, scale);
        let (normal_change, normal_change_z) = unit(steps.normal, scale / stretch);
        Lookup {
            example,
            stretch_square: stretch * stretch,
            to_grid: Mat2::from_diagonal(WEIGHTS / (grid.cell * stretch)) * turn.transpose(),
            origin: grid.origin / grid.cell * WEIGHTS,
            last: ((grid.dims - UVec2::ONE) * WEIGHTS as u32 - UVec2::ONE).as_vec2(),
            dims: grid.dims,
            height: steps.height / WEIGHTS,
            fade: 2.0 / stamp.fade,
            displacement,
            displacement_z,
            normal_change,
            normal_change_z,
            longest: stamp.longest * scale.abs(),
            steepest: steps.normal.length() * MOST * (scale / stretch).abs(),
            heights: (stamp.heights.0 - stamp.fade, stamp.heights.1 + stamp.fade),
            radius: stamp.reach(stretch),
        }
    }

    /// Whether the stamp may move anything in a box of the shared frame.
    fn reaches(&self, centre: Vec3, half: Vec3) -> bool {
        let half_z = half.z * (1.0 + ROUNDING) + self.radius * ROUNDING;
        if centre.z - half_z > self.heights.1 || centre.z + half_z < self.heights.0 {
            return false;
        }
        // In the stamp's own directions, in cells.
        let per_cell = 1.0 / WEIGHTS;
        let (to_cells, origin) = (self.to_grid * per_cell, self.origin * per_cell);
        let middle = to_cells * centre.truncate();
        let wide = to_cells.abs() * (half.truncate() * (1.0 + ROUNDING) + self.radius * ROUNDING);
        let (low, high) = (middle - wide, middle + wide);
        // The steepest point that the box could contain bounds how far unrolling moves any of its points outwards.
        let nearest = (centre.truncate().abs() - half.truncate() * (1.0 + ROUNDING)).max(Vec2::ZERO).length_squared();
        let up = (centre.z - half_z).abs().max((centre.z + half_z).abs());
        let lift = lift(up, nearest / self.stretch_square) + ROUNDING;
        let (low, high) = (low.min(low * lift) - origin, high.max(high * lift) - origin);
        let top = (self.dims - UVec2::ONE).as_vec2();
        high.cmpge(Vec2::ZERO).all() && low.cmple(top).all()
    }
}
