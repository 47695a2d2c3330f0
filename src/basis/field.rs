//! A displacement field as the nodes that it moves.

use super::Rows;
use crate::base::math::{Four, small_whole};
use glam::Vec3;

/// The largest number of steps along an axis.
pub(crate) const MOST: f32 = 32767.0;

/// Nodes in a group.
pub(crate) const GROUP: usize = 32;

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
    /// The field of groups of nodes, ascending, with finite displacements, m. Groups that do not move are left out.
    pub(crate) fn new(groups: &[(u32, [[f32; GROUP]; 3])]) -> Self {
        let longest = groups.iter().map(|(_, u)| longest_of(u)).fold(0.0, f32::max);
        let step = (longest / MOST).max(f32::MIN_POSITIVE);
        let steps = |x: f32| small_whole((x / step).clamp(-MOST, MOST)) as i16;
        let moving = || groups.iter().filter(|(_, u)| u.as_flattened().iter().any(|x| *x != 0.0));
        let count = moving().count();
        let (mut names, mut moves) = (Vec::with_capacity(count), Vec::with_capacity(count));
        for (group, u) in moving() {
            names.push(*group);
            moves.push(u.map(|along| along.map(steps)));
        }
        NodeField { groups: names.into(), moves: moves.into(), step }
    }

    /// The field of all nodes, with finite displacements, m.
    pub(crate) fn of(nodes: &[Four]) -> Self {
        let groups = (0..).zip(nodes.chunks(GROUP / 4).map(|fours| {
            let mut group = [[0.0; GROUP]; 3];
            for (i, u) in fours.iter().enumerate() {
                (0..3).for_each(|k| u[k].write_to_slice(&mut group[k][4 * i..]));
            }
            group
        }));
        Self::new(&groups.collect::<Vec<_>>())
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

    /// The nodes that it moves by at least this share of the longest displacement.
    pub(crate) fn moved_most(&self, share: f32) -> impl Iterator<Item = u32> {
        let squares = |moves: &[[i16; GROUP]; 3]| -> [f32; GROUP] {
            let square = |x: i16| f32::from(x) * f32::from(x);
            std::array::from_fn(|i| square(moves[0][i]) + square(moves[1][i]) + square(moves[2][i]))
        };
        let longest = self.moves.iter().flat_map(squares).fold(0.0, f32::max);
        let least = (share * share * longest).max(f32::MIN_POSITIVE);
        self.groups().flat_map(move |(group, moves)| {
            let own = (GROUP as u32 * group..).zip(squares(moves));
            own.filter(move |(_, square)| *square >= least).map(|(node, _)| node)
        })
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

/// The largest coordinate without its sign.
fn longest_of(group: &[[f32; GROUP]; 3]) -> f32 {
    let mut most = [0.0f32; GROUP];
    for along in group {
        most.iter_mut().zip(along).for_each(|(most, x)| *most = if x.abs() > *most { x.abs() } else { *most });
    }
    most.iter().fold(0.0, |most, x| x.max(most))
}

fn group_of(node: u32) -> u32 {
    node / GROUP as u32
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::base::math::side_by_side;

    #[test]
    fn displacements_are_rounded_to_a_32767th_of_the_longest() {
        let mut nodes = vec![Vec3::ZERO; 40];
        (nodes[2], nodes[5], nodes[39]) = (Vec3::new(0.1, -0.05, 0.0), Vec3::splat(1e-9), Vec3::Z * 0.01);
        let of = |nodes: &[Vec3]| NodeField::of(&nodes.chunks(4).map(|n| side_by_side(n, 0.0)).collect::<Vec<_>>());
        let field = of(&nodes);
        assert!(field.moved().map(|(n, _)| n).eq([2, 39]), "what rounds to nothing is left out");
        for (node, u) in field.moved() {
            assert!(u.distance(nodes[node as usize]) <= 0.1 / 32767.0, "node {node}: {u}");
        }
        assert_eq!(of(&[Vec3::ZERO; 9]), NodeField { step: f32::MIN_POSITIVE, ..NodeField::default() });
        assert!(of(&[Vec3::splat(1e-44)]).moved().all(|(_, u)| u.is_finite()));
    }
}
