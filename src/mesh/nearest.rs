//! Finds the base vertices nearest to a point. The index is an implicit, balanced tree of boxes in two flat arrays.
//! Ties go to the lowest index.
//!
//! # Layout
//! The tree holds the lowest vertex at each position. Leaves hold [`LEAF`] points. Nodes are numbered as in a heap with
//! four children per node: node 0 is the root, and the children of inner node `i` are `4 i + 1` to `4 i + 4`, if they
//! exist. With `L` leaves the `I = ceil((L - 1) / 3)` inner nodes come first; node `I + i` is leaf `i`.
//!
//! - `inner`, `I` elements: for each child, the box around its points.
//! - `leaves`, `L` elements: coordinates and vertices, sorted by vertex. Only the rightmost leaf of the tree may
//!   have empty slots. These have infinite coordinates and vertex 0.
//!
//! A query reads only these two arrays. Whatever they contain, it visits at most `I + L` nodes and returns only
//! vertices that are in the leaves.
//!
//! Squared distances are the f32 sums `(x² + y²) + z²`. The distance to a box uses the same operations on smaller
//! differences. Rounding is monotonic, so no point in a box is nearer than the box. Results therefore equal those of
//! comparing all vertices.

use super::finite;
use crate::base::array::Array;
use crate::base::array_vec::ArrayVec;
use crate::base::error::Error;
use crate::base::math::Aabb;
use bytemuck::{Pod, Zeroable};
use glam::Vec3;

/// Points per leaf.
pub(crate) const LEAF: usize = 16;
/// Children of an inner node.
const WIDE: usize = 4;
/// The number of leaves is below this.
const MAX_LEAVES: usize = 1 << 30;
/// Capacity of the stack of nodes to visit: on each of at most 16 levels the other children wait.
const WAITING: usize = 16 * (WIDE - 1) + 1;

/// The vertex nearest to a point.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Nearest {
    /// Its index. The lowest if several are equally near.
    pub vertex: u32,
    /// Its distance, m.
    pub distance: f32,
}

/// The boxes around the points of an inner node's children, by axis. A missing child has an empty box.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Pod, Zeroable)]
pub(crate) struct Inner {
    /// Smallest coordinates, m.
    min: [[f32; WIDE]; 3],
    /// Largest coordinates, m.
    max: [[f32; WIDE]; 3],
}

impl Inner {
    const EMPTY: Inner = Inner { min: [[f32::INFINITY; WIDE]; 3], max: [[f32::NEG_INFINITY; WIDE]; 3] };

    fn set(&mut self, child: usize, b: &Aabb) {
        for (axis, (min, max)) in b.min.to_array().into_iter().zip(b.max.to_array()).enumerate() {
            (self.min[axis][child], self.max[axis][child]) = (min, max);
        }
    }

    /// Squared distances to the boxes, m².
    #[inline]
    fn distances(&self, q: [f32; 3]) -> [f32; WIDE] {
        let max = |a: f32, b: f32| if a > b { a } else { b };
        let mut d = [0.0; WIDE];
        for (i, d) in d.iter_mut().enumerate() {
            let off = |axis: usize| max(max(self.min[axis][i] - q[axis], q[axis] - self.max[axis][i]), 0.0);
            let (x, y, z) = (off(0), off(1), off(2));
            *d = x * x + y * y + z * z;
        }
        d
    }
}

/// The points of a leaf.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Pod, Zeroable)]
pub(crate) struct Leaf {
    /// Coordinates, m.
    x: [f32; LEAF],
    y: [f32; LEAF],
    z: [f32; LEAF],
    vertex: [u32; LEAF],
}

impl Leaf {
    const EMPTY: Leaf =
        Leaf { x: [f32::INFINITY; LEAF], y: [f32::INFINITY; LEAF], z: [f32::INFINITY; LEAF], vertex: [0; LEAF] };

    fn of(points: &[Point]) -> Self {
        let mut leaf = Leaf::EMPTY;
        for (i, p) in points.iter().enumerate() {
            (leaf.x[i], leaf.y[i], leaf.z[i], leaf.vertex[i]) = (p.at[0], p.at[1], p.at[2], p.vertex);
        }
        leaf
    }

    /// Squared distances, m².
    #[inline]
    fn distances(&self, q: [f32; 3]) -> [f32; LEAF] {
        let mut d = [0.0; LEAF];
        for (i, d) in d.iter_mut().enumerate() {
            let (x, y, z) = (self.x[i] - q[0], self.y[i] - q[1], self.z[i] - q[2]);
            *d = x * x + y * y + z * z;
        }
        d
    }
}

/// Whether all vertices of the leaves are below `vertices`.
pub(crate) fn vertices_known(leaves: &[Leaf], vertices: usize) -> bool {
    leaves.iter().all(|l| l.vertex.iter().all(|v| (*v as usize) < vertices))
}

/// The smallest of a leaf's distances. The comparisons form a tree, so that compilers vectorize them.
#[inline]
fn least(d: &[f32; LEAF]) -> f32 {
    let min = |a: f32, b: f32| if a < b { a } else { b };
    let mut m = *d;
    let mut half = LEAF / 2;
    while half > 0 {
        for i in 0..half {
            m[i] = min(m[i], m[i + half]);
        }
        half /= 2;
    }
    m[0]
}

/// The tree. Its arrays may be borrowed from a file.
#[derive(Debug)]
pub(crate) struct VertexIndex {
    inner: Array<Inner>,
    leaves: Array<Leaf>,
}

impl VertexIndex {
    /// Builds the tree. Keeps only the lowest vertex at each position (`weld[v] == v`), which is the result for all of
    /// them. Needs at least one vertex and finite positions.
    pub(crate) fn new(positions: &[Vec3], weld: &[u32]) -> Self {
        let mut points: Vec<Point> = (0..)
            .zip(positions.iter().zip(weld))
            .filter(|(v, (_, w))| v == *w)
            .map(|(vertex, (p, _))| Point { at: p.to_array(), vertex })
            .collect();
        let count = points.len().div_ceil(LEAF).max(1);
        arrange(&mut points, count);
        let (deep, shallow) = points.split_at((LEAF * (count - shallow_leaves(count))).min(points.len()));
        let by_leaves = || shallow.chunks(LEAF).chain(deep.chunks(LEAF));
        let leaves: Vec<Leaf> = by_leaves().map(Leaf::of).collect();
        let mut inner = vec![Inner::EMPTY; inner_nodes(count)];
        // One box per node.
        let mut boxes = vec![Aabb::EMPTY; inner.len()];
        boxes.extend(by_leaves().map(bounds));
        for i in (0..inner.len()).rev() {
            for (child, at) in (WIDE * i + 1..boxes.len()).take(WIDE).enumerate() {
                let b = boxes[at];
                inner[i].set(child, &b);
                boxes[i].union(&b);
            }
        }
        VertexIndex { inner: inner.into(), leaves: leaves.into() }
    }

    /// The tree of points, all of which it keeps.
    pub(crate) fn of_points(points: &[Vec3]) -> Self {
        Self::new(points, &(0..points.len() as u32).collect::<Vec<_>>())
    }

    /// Makes the tree from arrays of any origin whose leaves have [known](vertices_known) vertices. `None` if there is
    /// no leaf, or the number of inner nodes does not match the leaves. Arrays that do not form a tree only give wrong
    /// vertices.
    pub(crate) fn of(inner: Array<Inner>, leaves: Array<Leaf>) -> Option<Self> {
        let fits = (1..MAX_LEAVES).contains(&leaves.len()) && inner.len() == inner_nodes(leaves.len());
        fits.then_some(VertexIndex { inner, leaves })
    }

    /// The arrays for [`VertexIndex::of`].
    pub(crate) fn parts(&self) -> (&[Inner], &[Leaf]) {
        (&self.inner, &self.leaves)
    }

    pub(crate) fn bytes(&self) -> usize {
        self.inner.bytes() + self.leaves.bytes()
    }

    /// The vertex nearest to a point of the caller's.
    ///
    /// # Errors
    /// [`Error::NotFinite`]; [`Error::InvalidArgument`] if the distance overflows.
    pub(crate) fn of_point(&self, point: [f32; 3], positions: &[Vec3]) -> Result<Nearest, Error> {
        let p = finite(point, || "point".into())?;
        let expected = "near enough that squared distances fit in f32";
        self.nearest(p, positions).ok_or_else(|| Error::invalid("point", p, expected))
    }

    /// The vertex with the smallest f32 squared distance, the lowest if several are equal. `None` only if the distance
    /// overflows f32.
    pub(crate) fn nearest(&self, point: Vec3, positions: &[Vec3]) -> Option<Nearest> {
        // If all squares overflow, all vertices are equally near, and vertex 0 is the lowest.
        let vertex = self.within::<1>(point, f32::MAX).first().map_or(0, |found| found.1);
        let distance = (positions[vertex as usize].as_dvec3() - point.as_dvec3()).length() as f32;
        distance.is_finite().then_some(Nearest { vertex, distance })
    }

    /// Squared distances (m²) and indices of up to `N` nearest vertices, nearest first. Ties go to the lowest index.
    pub(crate) fn several<const N: usize>(&self, point: Vec3) -> ArrayVec<(f32, u32), N> {
        self.within(point, f32::MAX)
    }

    /// The `N` nearest vertices within a squared distance of `reach`, m².
    #[inline]
    fn within<const N: usize>(&self, point: Vec3, mut reach: f32) -> ArrayVec<(f32, u32), N> {
        let (inner, leaves) = self.parts();
        let nodes = inner.len() + leaves.len();
        let q = point.to_array();
        let mut found = ArrayVec::new();
        // Stack of nodes to visit. High 32 bits: the bits of the squared distance, which sort like the distance. Low 32
        // bits: the node's number. The first entry is the root.
        let mut waiting = [0u64; WAITING];
        let mut count = 1;
        while count > 0 {
            count -= 1;
            let node = number(waiting[count]);
            if distance(waiting[count]) > reach {
                continue;
            }
            if let Some(inner) = inner.get(node) {
                let d = inner.distances(q);
                let first = WIDE * node + 1;
                let key = |i: usize| u64::from(d[i].to_bits()) << 32 | (first + i) as u64;
                let mut keys = [key(0), key(1), key(2), key(3)];
                for (a, b) in [(0, 1), (2, 3), (0, 2), (1, 3), (1, 2)] {
                    (keys[a], keys[b]) = (keys[a].max(keys[b]), keys[a].min(keys[b]));
                }
                for key in keys {
                    if distance(key) <= reach && number(key) < nodes {
                        waiting[count] = key;
                        count += 1;
                    }
                }
                continue;
            }
            let leaf = &leaves[node - inner.len()];
            let distances = leaf.distances(q);
            if least(&distances) > reach {
                continue;
            }
            for at in distances.into_iter().zip(leaf.vertex) {
                if at.0 <= reach {
                    found.insert(found.iter().rposition(|f| *f <= at).map_or(0, |i| i + 1), at);
                    if found.len() == N {
                        reach = found[N - 1].0;
                    }
                }
            }
        }
        found
    }
}

fn distance(key: u64) -> f32 {
    f32::from_bits((key >> 32) as u32)
}

fn number(key: u64) -> usize {
    (key & u64::from(u32::MAX)) as usize
}

/// A vertex while the tree is built.
#[derive(Debug, Clone, Copy)]
struct Point {
    at: [f32; 3],
    vertex: u32,
}

impl Point {
    /// Sort key: orders points along an axis, then by vertex, so that there are no ties.
    #[inline]
    fn key(&self, axis: usize) -> u64 {
        let bits = self.at[axis].to_bits();
        // Maps floats to unsigned integers in the same order: inverts negative ones, sets the sign bit of the others.
        let mask = if bits >> 31 == 1 { u32::MAX } else { 1 << 31 };
        u64::from(bits ^ mask) << 32 | u64::from(self.vertex)
    }
}

/// Number of inner nodes of a tree with `leaves` leaves.
fn inner_nodes(leaves: usize) -> usize {
    leaves.saturating_sub(1).div_ceil(WIDE - 1)
}

/// Number of nodes above level `level`. The root is on level 0.
fn above(level: u32) -> usize {
    (WIDE.pow(level) - 1) / (WIDE - 1)
}

/// The level of the last of `nodes` nodes (at least 1).
fn deepest(nodes: usize) -> u32 {
    (0..).find(|l| above(l + 1) >= nodes).unwrap_or(0)
}

/// Number of leaves that are not on the deepest level. They have the lowest numbers and are the rightmost in the tree.
fn shallow_leaves(leaves: usize) -> usize {
    let inner = inner_nodes(leaves);
    above(deepest(inner + leaves)).saturating_sub(inner)
}

/// Number of leaves below each child of the root, for a tree with at least 2 leaves. The deepest level is filled from
/// the left.
fn leaves_below(leaves: usize) -> [usize; WIDE] {
    let nodes = inner_nodes(leaves) + leaves;
    let level = deepest(nodes);
    let full = WIDE.pow(level - 1);
    let mut last = nodes - above(level);
    [0; WIDE].map(|_| {
        let own = last.min(full);
        last -= own;
        let nodes = above(level - 1) + own;
        nodes - nodes.saturating_sub(1).div_ceil(WIDE)
    })
}

/// The box around some points, m.
fn bounds(points: &[Point]) -> Aabb {
    let mut b = Aabb::EMPTY;
    points.iter().for_each(|p| b.add(Vec3::from_array(p.at)));
    b
}

/// Sorts the points of a tree with `leaves` leaves into the tree's order, from left to right.
fn arrange(points: &mut [Point], leaves: usize) {
    if leaves > 1 {
        part(points, leaves).into_iter().for_each(|(points, leaves)| arrange(points, leaves));
    } else {
        points.sort_unstable_by_key(|p| p.vertex);
    }
}

/// Splits points among the root's children. Returns the points and the number of leaves of each child.
fn part(points: &mut [Point], leaves: usize) -> [(&mut [Point], usize); WIDE] {
    let [a, b, c, d] = leaves_below(leaves);
    let (left, right) = halve(points, (a + b) * LEAF);
    let (first, second) = halve(left, a * LEAF);
    let (third, fourth) = halve(right, c * LEAF);
    [(first, a), (second, b), (third, c), (fourth, d)]
}

/// Splits off the first `n` points along the widest axis. The split does not depend on the points' order, so neither
/// does the tree.
fn halve(points: &mut [Point], n: usize) -> (&mut [Point], &mut [Point]) {
    if n >= points.len() {
        return (points, &mut []);
    }
    let b = bounds(points);
    let axis = (b.max - b.min).max_position();
    points.select_nth_unstable_by_key(n, |p| p.key(axis));
    points.split_at_mut(n)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::weld;
    use proptest::prelude::*;

    /// Squared distances and indices of all vertices, nearest first. Ties are sorted by index.
    fn compared(positions: &[Vec3], weld: &[u32], q: Vec3) -> Vec<(f32, u32)> {
        let d = |p: Vec3| (p.x - q.x) * (p.x - q.x) + (p.y - q.y) * (p.y - q.y) + (p.z - q.z) * (p.z - q.z);
        let mut all: Vec<(f32, u32)> = (0..positions.len() as u32)
            .filter(|v| weld[*v as usize] == *v)
            .map(|v| (d(positions[v as usize]), v))
            .collect();
        all.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
        all
    }

    /// Random clouds, lattices with many ties, lines, one position repeated, planes, and coordinates up to the largest
    /// allowed.
    fn clouds() -> impl Strategy<Value = Vec<Vec3>> {
        let kinds = prop_oneof![Just(0), Just(1), Just(2), Just(3), Just(4), Just(5)];
        (kinds, prop::collection::vec(prop::array::uniform3(-1.0f32..1.0), 1..400)).prop_map(|(kind, points)| {
            let place = |p: [f32; 3]| match kind {
                0 => Vec3::from_array(p),
                1 => (Vec3::from_array(p) * 4.0).round(),
                2 => Vec3::new(1.0, -2.0, 0.5) * (p[0] * 20.0).round(),
                3 => Vec3::splat(0.25),
                4 => Vec3::from_array(p) * 1e9,
                _ => Vec3::new(p[0], p[1], 0.0),
            };
            points.into_iter().map(|p| place(p) + Vec3::ZERO).collect()
        })
    }

    fn check(positions: &[Vec3], q: Vec3) -> Result<(), TestCaseError> {
        let weld = weld(positions).unwrap();
        let index = VertexIndex::new(positions, &weld);
        let all = compared(positions, &weld, q);
        let found = index.nearest(q, positions);
        let distance = (positions[all[0].1 as usize].as_dvec3() - q.as_dvec3()).length() as f32;
        prop_assert_eq!(found.map(|n| n.vertex), distance.is_finite().then_some(all[0].1));
        let finite: Vec<_> = all.iter().copied().filter(|f| f.0.is_finite()).take(4).collect();
        prop_assert_eq!(&*index.several::<4>(q), &*finite);
        Ok(())
    }

    proptest! {
        #[test]
        fn answers_are_those_of_comparing_all(points in clouds(), q in prop::array::uniform3(-1.5f32..1.5), scale in 0u32..5) {
            let q = Vec3::from_array(q);
            let q = match scale { 0 => q, 1 => (q * 4.0).round(), 2 => q * 1e9, 3 => q * 2e19, _ => points[0] };
            check(&points, q)?;
        }

        /// Whatever the arrays contain, queries end and return vertices of the mesh.
        #[test]
        fn arrays_that_are_no_tree_do_no_harm(
            leaves in 1usize..40, bits in prop::collection::vec(any::<u32>(), 64), q in prop::array::uniform3(any::<f32>()),
        ) {
            let mut next = bits.iter().copied().cycle().enumerate().map(|(i, b)| b.wrapping_mul(2 * i as u32 + 1));
            let mut word = || next.next().unwrap_or(0);
            let boxes = |word: &mut dyn FnMut() -> u32| [[0; WIDE]; 3].map(|a| a.map(|_| f32::from_bits(word())));
            let inner: Vec<Inner> = (0..inner_nodes(leaves))
                .map(|_| Inner { min: boxes(&mut word), max: boxes(&mut word) })
                .collect();
            let all: Vec<Leaf> = (0..leaves)
                .map(|_| Leaf {
                    x: [0; LEAF].map(|_| f32::from_bits(word())),
                    y: [0; LEAF].map(|_| f32::from_bits(word())),
                    z: [0; LEAF].map(|_| f32::from_bits(word())),
                    vertex: [0; LEAF].map(|_| word() % 7),
                })
                .collect();
            let of = |leaves: &[Leaf]| VertexIndex::of(inner.clone().into(), leaves.to_vec().into());
            prop_assert_eq!(vertices_known(&all, 6), all.iter().all(|l| !l.vertex.contains(&6)));
            prop_assert!(vertices_known(&all, 7));
            prop_assert!(of(&all[1..]).is_none() || leaves % 3 != 2);
            prop_assert!(of(&[]).is_none());
            let tree = of(&all).unwrap();
            let q = Vec3::from_array(q);
            prop_assert!(tree.nearest(q, &[Vec3::ONE; 7]).is_none_or(|n| n.vertex < 7));
            prop_assert!(tree.several::<4>(q).iter().all(|f| f.1 < 7));
        }
    }

    #[test]
    fn leaves_are_numbered_as_in_a_heap() {
        for leaves in 2..300 {
            let below = leaves_below(leaves);
            assert_eq!(below.iter().sum::<usize>(), leaves);
            assert!(below.is_sorted_by(|a, b| a >= b));
            let nodes = inner_nodes(leaves) + leaves;
            let count = |mut first: usize| {
                let (mut last, mut sum) = (first, 0);
                while first < nodes {
                    sum += (first..=last.min(nodes - 1)).filter(|i| *i >= nodes - leaves).count();
                    (first, last) = (WIDE * first + 1, WIDE * last + WIDE);
                }
                sum
            };
            assert_eq!(below, [1, 2, 3, 4].map(count), "{leaves}");
        }
    }
}
