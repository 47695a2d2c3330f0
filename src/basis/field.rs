//! A displacement field as the nodes that it moves.

use super::Rows;
use crate::base::math::small_whole;
use crate::base::simd::{Work, widest};
use glam::Vec3;

/// The largest number of steps along an axis.
pub(crate) const MOST: f32 = 32767.0;

/// Nodes in a group.
pub(crate) const GROUP: usize = 32;

/// Vectors of [`GROUP`] successive nodes, side by side: along x, y and z.
pub(crate) type Group = [[f32; GROUP]; 3];

/// The first vectors side by side. Missing ones are `other`.
#[inline(always)]
pub(crate) fn side_by_side(vectors: &[Vec3], other: Vec3) -> Group {
    let mut first = [other; GROUP];
    let count = vectors.len().min(GROUP);
    first[..count].copy_from_slice(&vectors[..count]);
    let mut group = [[0.0; GROUP]; 3];
    let [x, y, z] = &mut group;
    for i in 0..GROUP {
        (x[i], y[i], z[i]) = (first[i].x, first[i].y, first[i].z);
    }
    group
}

/// Squared distances from a point.
#[inline(always)]
pub(crate) fn squares(group: &Group, from: Vec3) -> [f32; GROUP] {
    let [x, y, z] = group;
    let mut out = [0.0; GROUP];
    for i in 0..GROUP {
        let (x, y, z) = (x[i] - from.x, y[i] - from.y, z[i] - from.z);
        out[i] = x * x + y * y + z * z;
    }
    out
}

/// The greatest of the numbers of all lists; 0 if none is above 0.
#[inline(always)]
pub(crate) fn greatest(lists: impl Iterator<Item = [f32; GROUP]>) -> f32 {
    let mut most = [0.0f32; GROUP];
    for list in lists {
        for i in 0..GROUP {
            most[i] = if list[i] > most[i] { list[i] } else { most[i] };
        }
    }
    most.iter().fold(0.0, |most, x| x.max(most))
}

/// Displacements of nodes, 6 bytes each, for groups of [`GROUP`] successive nodes with one that moves.
#[derive(Debug, Clone, Default, PartialEq)]
pub(crate) struct NodeField {
    /// Ascending.
    groups: Box<[u32]>,
    /// Those of each group in units of `step`: along x, y and z.
    moves: Box<[[[i16; GROUP]; 3]]>,
    /// m.
    step: f32,
}

impl NodeField {
    /// The field of all nodes, in groups, m. If one of them is not finite, it moves none.
    pub(crate) fn of(nodes: &[Group]) -> Self {
        widest(Rounding(nodes))
    }

    /// The nodes that it moves and their displacements, m.
    #[cfg(test)]
    pub(crate) fn moved(&self) -> impl Iterator<Item = (u32, Vec3)> {
        let nodes = self.groups().flat_map(|(group, moves)| {
            let first = GROUP as u32 * group;
            (0..GROUP).map(move |i| (first + i as u32, [0, 1, 2].map(|k| moves[k][i])))
        });
        nodes.filter(|(_, u)| *u != [0; 3]).map(|(n, u)| (n, self.metres(u)))
    }

    /// The greatest squared distance from a place of a node that it moves by at least this share of the longest displacement, m²; 0 if it
    /// moves none. `nodes` are the places of all.
    pub(crate) fn reach_square(&self, share: f32, nodes: &[Vec3], from: Vec3) -> f32 {
        widest(Reaching { field: self, share, nodes, from })
    }

    /// The groups with nodes that it moves, and the displacements of all their nodes in units of [`NodeField::step`], along x, y and z.
    pub(crate) fn groups(&self) -> impl Iterator<Item = (u32, &[[i16; GROUP]; 3])> {
        self.groups.iter().copied().zip(&self.moves)
    }

    /// m.
    pub(crate) fn step(&self) -> f32 {
        self.step
    }

    fn metres(&self, steps: [i16; 3]) -> Vec3 {
        Vec3::from(steps.map(f32::from)) * self.step
    }

    /// Displacement of a vertex that follows the nodes by these rows, m.
    pub(crate) fn at_vertex(&self, rows: &Rows, v: u32) -> Vec3 {
        // Most nodes of a vertex lie in the group of the one before.
        let (mut group, mut moves) = (u32::MAX, None);
        rows.at_vertex(v, |node| {
            if group_of(node) != group {
                group = group_of(node);
                moves = self.groups.binary_search(&group).ok().map(|at| &self.moves[at]);
            }
            moves.map_or(Vec3::ZERO, |moves| self.metres([0, 1, 2].map(|k| moves[k][node as usize % GROUP])))
        })
    }

    /// Memory used, bytes.
    pub(crate) fn bytes(&self) -> usize {
        size_of::<Self>() + size_of_val(&*self.groups) + size_of_val(&*self.moves)
    }
}

/// Makes a field of displacements.
struct Rounding<'a>(&'a [Group]);

impl Work for Rounding<'_> {
    type Done = NodeField;

    #[inline(always)]
    fn run(self) -> NodeField {
        let sizes = self.0.iter().flatten().map(|along| {
            let mut sizes = [0.0; GROUP];
            sizes.iter_mut().zip(along).for_each(|(size, x)| *size = x.abs());
            sizes
        });
        let is_finite =
            |good: bool, sizes: [f32; GROUP]| sizes.iter().fold(good, |good, x| good & (*x < f32::INFINITY));
        if !sizes.clone().fold(true, is_finite) {
            return NodeField { step: f32::MIN_POSITIVE, ..NodeField::default() };
        }
        let step = (greatest(sizes) / MOST).max(f32::MIN_POSITIVE);
        let moves = |u: &Group| u.as_flattened().iter().fold(false, |moves, x| moves | (*x != 0.0));
        let mut groups = Vec::with_capacity(self.0.iter().filter(|u| moves(u)).count());
        groups.extend((0..).zip(self.0).filter(|(_, u)| moves(u)).map(|(group, _)| group));
        let groups = groups.into_boxed_slice();
        let mut moves = vec![[[0i16; GROUP]; 3]; groups.len()].into_boxed_slice();
        for (to, group) in moves.iter_mut().zip(&groups) {
            for (to, x) in to.as_flattened_mut().iter_mut().zip(self.0[*group as usize].as_flattened()) {
                *to = small_whole((x / step).clamp(-MOST, MOST)) as i16;
            }
        }
        NodeField { groups, moves, step }
    }
}

/// Finds how far a field reaches.
struct Reaching<'a> {
    field: &'a NodeField,
    share: f32,
    nodes: &'a [Vec3],
    from: Vec3,
}

impl Work for Reaching<'_> {
    type Done = f32;

    #[inline(always)]
    fn run(self) -> f32 {
        let Reaching { field, share, nodes, from } = self;
        let moved = |moves: &[[i16; GROUP]; 3]| {
            let mut group = [[0.0; GROUP]; 3];
            let all = group.as_flattened_mut().iter_mut().zip(moves.as_flattened());
            all.for_each(|(to, x)| *to = f32::from(*x));
            squares(&group, Vec3::ZERO)
        };
        let least = (share * share * greatest(field.moves.iter().map(moved))).max(f32::MIN_POSITIVE);
        greatest(field.groups().map(|(group, moves)| {
            let moved = moved(moves);
            let mut distances = squares(&side_by_side(&nodes[GROUP * group as usize..], from), from);
            for i in 0..GROUP {
                distances[i] = if moved[i] >= least { distances[i] } else { 0.0 };
            }
            distances
        }))
    }
}

fn group_of(node: u32) -> u32 {
    node / GROUP as u32
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn displacements_are_rounded_to_a_32767th_of_the_longest() {
        let mut nodes = vec![Vec3::ZERO; 40];
        (nodes[2], nodes[5], nodes[39]) = (Vec3::new(0.1, -0.05, 0.0), Vec3::splat(1e-9), Vec3::Z * 0.01);
        let group = |nodes: &[Vec3]| side_by_side(nodes, Vec3::ZERO);
        let of = |nodes: &[Vec3]| NodeField::of(&nodes.chunks(GROUP).map(group).collect::<Vec<_>>());
        let field = of(&nodes);
        assert!(field.moved().map(|(n, _)| n).eq([2, 39]), "what rounds to nothing is left out");
        for (node, u) in field.moved() {
            assert!(u.distance(nodes[node as usize]) <= 0.1 / 32767.0, "node {node}: {u}");
        }
        assert_eq!(of(&[Vec3::ZERO; 9]), NodeField { step: f32::MIN_POSITIVE, ..NodeField::default() });
        assert!(of(&[Vec3::splat(1e-44)]).moved().all(|(_, u)| u.is_finite()));
    }
}
