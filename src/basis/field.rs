//! A displacement field as the nodes that it moves.

use super::{ONE, Rows};
use crate::base::math::nearest_whole;
use glam::Vec3;

/// The largest number of steps.
const MOST: f32 = 32767.0;

/// A displacement in steps of this length, both in m, rounded to the nearest.
pub(crate) fn in_steps(u: Vec3, step: f32) -> [i16; 3] {
    (u / step).to_array().map(|x| nearest_whole(x.clamp(-MOST, MOST).into()) as i16)
}

/// Displacements of some nodes, 10 bytes each.
#[derive(Debug, Clone, Default, PartialEq)]
pub(crate) struct NodeField {
    /// Ascending.
    nodes: Box<[u32]>,
    /// In units of `step`.
    moves: Box<[[i16; 3]]>,
    /// m.
    step: f32,
}

impl NodeField {
    /// The field of these nodes, ascending, with finite displacements, m.
    pub(crate) fn new(moved: &[(u32, Vec3)]) -> Self {
        let longest = moved.iter().fold(0.0f32, |m, (_, u)| m.max(u.abs().max_element()));
        let step = (longest / MOST).max(f32::MIN_POSITIVE);
        let rounded = moved.iter().map(|(n, u)| (*n, in_steps(*u, step))).filter(|(_, u)| *u != [0; 3]);
        let (nodes, moves): (Vec<u32>, Vec<[i16; 3]>) = rounded.unzip();
        NodeField { nodes: nodes.into(), moves: moves.into(), step }
    }

    /// The nodes that it moves and their displacements, m.
    pub(crate) fn moved(&self) -> impl Iterator<Item = (u32, Vec3)> {
        self.nodes.iter().copied().zip(self.moves.iter().map(|u| self.metres(*u)))
    }

    /// Displacement of a node, m.
    fn at_node(&self, node: u32) -> Vec3 {
        self.nodes.binary_search(&node).map_or(Vec3::ZERO, |at| self.metres(self.moves[at]))
    }

    fn metres(&self, steps: [i16; 3]) -> Vec3 {
        Vec3::from(steps.map(f32::from)) * self.step
    }

    /// Displacement of a vertex that follows the nodes by these rows, m.
    pub(crate) fn at_vertex(&self, rows: &Rows, v: u32) -> Vec3 {
        rows.of(v).fold(Vec3::ZERO, |sum, (node, w)| sum + self.at_node(node) * (w as f32 / ONE as f32))
    }

    /// Memory used, bytes.
    pub(crate) fn bytes(&self) -> usize {
        size_of::<Self>() + self.nodes.len() * (size_of::<u32>() + size_of::<[i16; 3]>())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn displacements_are_rounded_to_a_32767th_of_the_longest() {
        let moved = [(2, Vec3::new(0.1, -0.05, 0.0)), (5, Vec3::splat(1e-9)), (9, Vec3::Z * 0.01)];
        let field = NodeField::new(&moved);
        assert!(field.moved().map(|(n, _)| n).eq([2, 9]), "what rounds to nothing is left out");
        for ((_, u), (node, ought)) in field.moved().zip([moved[0], moved[2]]) {
            assert!(u.distance(ought) <= 0.1 / 32767.0, "node {node}: {u}");
        }
        assert_eq!(NodeField::new(&[]).moved().count(), 0);
        assert!(NodeField::new(&[(0, Vec3::splat(1e-44))]).moved().all(|(_, u)| u.is_finite()));
    }
}
