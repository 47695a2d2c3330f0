//! Mirror symmetry. If a body is symmetric about a plane, an example made on one side is also used on the other.
//!
//! Only the three coordinate planes through the centre of the bounds are tested. The body is symmetric about a plane if
//! the plane maps the vertices onto themselves; triangles are ignored.

use crate::base::math::Aabb;
use crate::mesh::Mesh;
use crate::mesh::nearest::VertexIndex;
use glam::Vec3;

/// Greatest distance between a mirrored vertex and its nearest vertex, as a share of the bounds' diagonal.
pub(crate) const TOLERANCE: f32 = 1e-3;
/// Share of the vertices that may miss the tolerance.
const STRAYS: f32 = 0.01;

/// A set of coordinate planes to mirror in. Bit 0 mirrors x, bit 1 y, bit 2 z.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Default)]
pub struct Mirror(u8);

impl Mirror {
    /// No mirroring.
    pub const NONE: Mirror = Mirror(0);

    /// Makes a set from bits: 1 mirrors x, 2 mirrors y, 4 mirrors z. Higher bits are ignored.
    pub fn from_bits(bits: u8) -> Self {
        Mirror(bits & 7)
    }

    /// The set as bits: 1 mirrors x, 2 mirrors y, 4 mirrors z.
    pub fn bits(self) -> u8 {
        self.0
    }

    /// Whether `other` contains all planes of `self`.
    pub fn within(self, other: Mirror) -> bool {
        self.0 & !other.0 == 0
    }

    /// All subsets of its planes, starting with the empty one.
    pub(crate) fn choices(self) -> impl Iterator<Item = Mirror> {
        (0..8).map(Mirror).filter(move |m| m.within(self))
    }

    /// Its planes, one by one.
    pub(crate) fn planes(self) -> impl Iterator<Item = Mirror> {
        self.choices().filter(|m| m.0.is_power_of_two())
    }

    /// Its planes but those of `other`.
    pub(crate) fn without(self, other: Mirror) -> Mirror {
        Mirror(self.0 & !other.0)
    }

    fn signs(self) -> Vec3 {
        let sign = |bit: u8| if self.0 >> bit & 1 == 1 { -1.0 } else { 1.0 };
        Vec3::new(sign(0), sign(1), sign(2))
    }

    /// Mirrors a direction.
    pub(crate) fn direction(self, v: Vec3) -> Vec3 {
        // -0 becomes +0, so that coincident images have equal bits.
        v * self.signs() + Vec3::ZERO
    }

    /// Mirrors a point in planes through `centre`, m.
    pub(crate) fn point(self, p: Vec3, centre: Vec3) -> Vec3 {
        if self == Self::NONE { p } else { centre + self.direction(p - centre) }
    }
}

/// The planes through the bounds' centre that map the vertices onto themselves.
pub(crate) fn planes(positions: &[Vec3], index: &VertexIndex, bounds: &Aabb) -> Mirror {
    let centre = bounds.centre();
    let near = TOLERANCE * bounds.diagonal();
    let strays = (STRAYS * positions.len() as f32) as usize;
    let maps = |m: Mirror| {
        let mut left = strays;
        positions.iter().all(|p| {
            let image = m.point(*p, centre);
            let hit = index.nearest(image, positions).is_some_and(|n| n.distance <= near);
            hit || left.checked_sub(1).map(|l| left = l).is_some()
        })
    };
    Mirror((0..3).map(|bit| 1 << bit).filter(|bits| has_extent(bounds, *bits) && maps(Mirror(*bits))).sum())
}

/// Where a symmetric body has the mirror images of its vertices.
pub(crate) struct Images<'a> {
    pub mesh: &'a Mesh,
    /// Of its vertices.
    pub index: &'a VertexIndex,
    pub planes: Mirror,
}

impl Images<'_> {
    /// The vertices where a vertex has its mirror images: of several at one position the first. There are none where the body is not symmetric.
    pub(crate) fn of(&self, v: u32) -> impl Iterator<Item = u32> {
        let (positions, bounds) = (self.mesh.positions(), self.mesh.bounds());
        let (centre, near) = (bounds.centre(), TOLERANCE * bounds.diagonal());
        let image = move |m: Mirror| {
            let found = self.index.nearest(m.point(positions[v as usize], centre), positions)?;
            (found.distance <= near).then(|| self.mesh.weld()[found.vertex as usize]).filter(|w| *w != v)
        };
        self.planes.choices().skip(1).filter_map(image)
    }
}

/// Whether the body has extent along an axis. Without extent it is its own mirror image, so every example would count
/// twice.
fn has_extent(bounds: &Aabb, bits: u8) -> bool {
    let extent = (bounds.max - bounds.min)[bits.trailing_zeros() as usize];
    extent > 2.0 * TOLERANCE * bounds.diagonal()
}
