//! The nearest base vertices to a point: an implicit, balanced tree of boxes in two flat arrays. Ties go to the lowest index.
//!
//! # Layout
//! Of vertices at one position only the lowest is in the tree. They fill leaves of [`LEAF`] points. Nodes are numbered as in a
//! heap of four children: 0 is the root, the children of inner node `i` are `4 i + 1` to `4 i + 4`, as far as there are so many.
//! With `L` leaves the `I = ceil((L - 1) / 3)` inner nodes come first; node `I + i` is leaf `i`.
//!
//! - `inner`, `I` of them: of each child the box around its points.
//! - `leaves`, `L` of them: coordinates and vertices, vertices increasing. All are full but the one that is last from left to
//!   right, whose empty slots have infinite coordinates and vertex 0.
//!
//! The two arrays are all there is, and a query reads nothing else: whatever they hold, it ends after at most `I + L` nodes and
//! answers with vertices that are in them.
//!
//! Distances are the f32 sums `(x² + y²) + z²`. Those to boxes are made by the same operations on nearer coordinates, which
//! round monotonously, so that no point in a box is nearer: answers are those of comparing all vertices.

use crate::TaskSystem;
use crate::array::Array;
use crate::math::Aabb;
use crate::tasks::map;
use bytemuck::{Pod, Zeroable};
use glam::Vec3;

/// Points a leaf.
pub(crate) const LEAF: usize = 16;
/// Children of an inner node.
const WIDE: usize = 4;
/// Leaves are fewer than this.
const MAX_LEAVES: usize = 1 << 30;
/// Nodes that can wait: each of at most 16 levels on the way down leaves its other children behind.
const WAITING: usize = 16 * (WIDE - 1) + 1;
/// Leaves that one task fills.
const LEAVES_A_TASK: usize = 1024;

/// The vertex nearest to a point.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Nearest {
    /// Its index; the lowest where several are equally near.
    pub vertex: u32,
    /// Its distance, m.
    pub distance: f32,
}

/// The boxes around the points of an inner node's children, by axis; where there is no child, an empty one.
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

    /// Around all children.
    fn bounds(&self) -> Aabb {
        let fold = |of: &[[f32; WIDE]; 3], f: fn(f32, f32) -> f32| {
            Vec3::from_array([0, 1, 2].map(|axis| of[axis].into_iter().fold(of[axis][0], f)))
        };
        Aabb { min: fold(&self.min, f32::min), max: fold(&self.max, f32::max) }
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

/// The least of a leaf's distances, in a tree of comparisons that compilers make vector operations of.
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

/// What a query collects.
trait Found {
    /// Points further than this (squared, m²) are of no use.
    fn reach(&self) -> f32;
    fn add(&mut self, leaf: &Leaf, distances: &[f32; LEAF]);
}

/// The tree's arrays, wherever they are.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Tree<'a> {
    inner: &'a [Inner],
    leaves: &'a [Leaf],
}

impl<'a> Tree<'a> {
    /// The tree in arrays of any origin, for a mesh of `vertices`: `None` unless there is a leaf, there are as many inner nodes
    /// as that takes, and all vertices are the mesh's. Arrays that are no tree give wrong vertices, nothing worse.
    pub(crate) fn new(inner: &'a [Inner], leaves: &'a [Leaf], vertices: usize) -> Option<Self> {
        let fits = (1..MAX_LEAVES).contains(&leaves.len()) && inner.len() == inner_nodes(leaves.len());
        let known = || leaves.iter().all(|l| l.vertex.iter().all(|v| (*v as usize) < vertices));
        (fits && known()).then_some(Tree { inner, leaves })
    }

    /// The lowest of the vertices with the least f32 squared distance. `None` only where the distance overflows f32.
    pub(crate) fn nearest(&self, point: Vec3, positions: &[Vec3]) -> Option<Nearest> {
        let mut found = One { d: f32::MAX, vertex: u32::MAX };
        self.search(point, &mut found);
        // Where all squares overflow, all are equally near, and the lowest is the first.
        let vertex = if found.vertex == u32::MAX { 0 } else { found.vertex };
        let distance = (positions[vertex as usize].as_dvec3() - point.as_dvec3()).length() as f32;
        distance.is_finite().then_some(Nearest { vertex, distance })
    }

    /// Up to four nearest vertices with their squared distances (m²), nearest first; of equally near ones the lowest.
    pub(crate) fn four(&self, point: Vec3) -> Four {
        self.four_within(point, f32::MAX)
    }

    /// The same; only those within a squared distance of `reach`, m².
    fn four_within(&self, point: Vec3, reach: f32) -> Four {
        let mut found = Four { d: [f32::INFINITY; 4], vertex: [0; 4], count: 0, reach };
        self.search(point, &mut found);
        found
    }

    /// The same as [`Tree::four`] where the nearest lies nearer than `reach` (m); none, sooner, where it does not.
    pub(crate) fn four_if_near(&self, point: Vec3, reach: f32) -> Four {
        // A little more, so that rounding cuts nothing off.
        let found = self.four_within(point, (reach * reach * 1.00001 + f32::MIN_POSITIVE).min(f32::MAX));
        if (1..4).contains(&found.count) { self.four(point) } else { found }
    }

    #[inline]
    fn search(&self, point: Vec3, found: &mut impl Found) {
        let q = point.to_array();
        let nodes = self.inner.len() + self.leaves.len();
        // Nodes that were passed by: the bits of their squared distance (which order as it does) above their number.
        let mut waiting = [0u64; WAITING];
        let mut count = 0;
        let mut node = 0;
        loop {
            if let Some(inner) = self.inner.get(node) {
                let d = inner.distances(q);
                let first = WIDE * node + 1;
                let key = |i: usize| u64::from(d[i].to_bits()) << 32 | (first + i) as u64;
                let mut keys = [key(0), key(1), key(2), key(3)];
                for (a, b) in [(0, 1), (2, 3), (0, 2), (1, 3), (1, 2)] {
                    (keys[a], keys[b]) = (keys[a].max(keys[b]), keys[a].min(keys[b]));
                }
                for key in keys {
                    if distance(key) <= found.reach() && number(key) < nodes {
                        waiting[count] = key;
                        count += 1;
                    }
                }
            } else {
                let leaf = &self.leaves[node - self.inner.len()];
                found.add(leaf, &leaf.distances(q));
            }
            loop {
                if count == 0 {
                    return;
                }
                count -= 1;
                if distance(waiting[count]) <= found.reach() {
                    node = number(waiting[count]);
                    break;
                }
            }
        }
    }
}

fn distance(key: u64) -> f32 {
    f32::from_bits((key >> 32) as u32)
}

fn number(key: u64) -> usize {
    (key & u64::from(u32::MAX)) as usize
}

struct One {
    d: f32,
    vertex: u32,
}

impl Found for One {
    #[inline]
    fn reach(&self) -> f32 {
        self.d
    }

    #[inline]
    fn add(&mut self, leaf: &Leaf, distances: &[f32; LEAF]) {
        let d = least(distances);
        if d <= self.d {
            let vertex = distances.iter().position(|x| *x == d).map_or(0, |i| leaf.vertex[i]);
            if d < self.d || vertex < self.vertex {
                (self.d, self.vertex) = (d, vertex);
            }
        }
    }
}

/// Up to four vertices, nearest first.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Four {
    d: [f32; 4],
    vertex: [u32; 4],
    count: usize,
    reach: f32,
}

impl Four {
    pub(crate) fn is_empty(&self) -> bool {
        self.count == 0
    }

    /// Vertices and squared distances, m².
    pub(crate) fn iter(&self) -> impl Iterator<Item = (u32, f32)> + '_ {
        self.vertex.iter().copied().zip(self.d.iter().copied()).take(self.count)
    }
}

impl Found for Four {
    #[inline]
    fn reach(&self) -> f32 {
        self.reach
    }

    #[inline]
    fn add(&mut self, leaf: &Leaf, distances: &[f32; LEAF]) {
        if least(distances) > self.reach {
            return;
        }
        for (d, vertex) in distances.iter().copied().zip(leaf.vertex) {
            if d <= self.reach {
                self.insert(d, vertex);
            }
        }
    }
}

impl Four {
    fn insert(&mut self, d: f32, vertex: u32) {
        let before = |i: usize| (self.d[i], self.vertex[i]) <= (d, vertex);
        let at = (0..self.count).rev().find(|i| before(*i)).map_or(0, |i| i + 1);
        if at == 4 {
            return;
        }
        self.count = (self.count + 1).min(4);
        for i in (at + 1..self.count).rev() {
            (self.d[i], self.vertex[i]) = (self.d[i - 1], self.vertex[i - 1]);
        }
        (self.d[at], self.vertex[at]) = (d, vertex);
        if self.count == 4 {
            self.reach = self.d[3];
        }
    }
}

/// A tree of its own.
#[derive(Debug)]
pub(crate) struct VertexIndex {
    inner: Array<Inner>,
    leaves: Array<Leaf>,
}

impl VertexIndex {
    /// Of vertices at one position only the lowest (`weld[v] == v`) is kept: it is the answer for all of them. There is at
    /// least one; all are finite. The tree is the same for any number of threads.
    pub(crate) fn new(positions: &[Vec3], weld: &[u32], tasks: &dyn TaskSystem) -> Self {
        let mut points: Vec<Point> = (0..)
            .zip(positions.iter().zip(weld))
            .filter(|(v, (_, w))| v == *w)
            .map(|(vertex, (p, _))| Point { at: p.to_array(), vertex })
            .collect();
        let count = points.len().div_ceil(LEAF).max(1);
        arrange(&mut points, count, tasks);
        let mut leaves = vec![(Leaf::EMPTY, Aabb::EMPTY); count];
        let (late, early) = leaves.split_at_mut(shallow_leaves(count));
        let (start, rest) = points.split_at((early.len() * LEAF).min(points.len()));
        let pieces = [(early, start), (late, rest)]
            .into_iter()
            .flat_map(|(l, p)| l.chunks_mut(LEAVES_A_TASK).zip(p.chunks(LEAVES_A_TASK * LEAF)));
        map(tasks, pieces, |(leaves, points)| {
            leaves.iter_mut().zip(points.chunks(LEAF)).for_each(|(l, p)| *l = (Leaf::of(p), bounds(p)));
        });
        let mut inner = vec![Inner::EMPTY; inner_nodes(count)];
        for i in (0..inner.len()).rev() {
            for child in 0..WIDE {
                let at = WIDE * i + 1 + child;
                let b = inner.get(at).map(Inner::bounds).or_else(|| leaves.get(at - inner.len()).map(|l| l.1));
                if let Some(b) = b {
                    inner[i].set(child, &b);
                }
            }
        }
        let leaves: Vec<Leaf> = leaves.into_iter().map(|l| l.0).collect();
        VertexIndex { inner: inner.into(), leaves: leaves.into() }
    }

    /// The tree in arrays of any origin, for a mesh of `vertices`; `None` as [`Tree::new`] says.
    pub(crate) fn of(inner: Array<Inner>, leaves: Array<Leaf>, vertices: usize) -> Option<Self> {
        Tree::new(&inner, &leaves, vertices)?;
        Some(VertexIndex { inner, leaves })
    }

    pub(crate) fn tree(&self) -> Tree<'_> {
        Tree { inner: &self.inner, leaves: &self.leaves }
    }

    /// [`Tree::nearest`].
    pub(crate) fn nearest(&self, point: Vec3, positions: &[Vec3]) -> Option<Nearest> {
        self.tree().nearest(point, positions)
    }

    /// [`Tree::four`].
    pub(crate) fn four(&self, point: Vec3) -> Four {
        self.tree().four(point)
    }

    /// [`Tree::four_if_near`].
    pub(crate) fn four_if_near(&self, point: Vec3, reach: f32) -> Four {
        self.tree().four_if_near(point, reach)
    }

    /// The arrays, as [`Tree::new`] takes them.
    pub(crate) fn parts(&self) -> (&[Inner], &[Leaf]) {
        (&self.inner, &self.leaves)
    }

    pub(crate) fn bytes(&self) -> usize {
        size_of_val(&self.inner[..]) + size_of_val(&self.leaves[..])
    }

    /// All vertices in the tree's order, in which neighbours in space are near each other; vertices at one position in a row.
    #[allow(dead_code, reason = "for an option that puts vertices in this order")]
    pub(crate) fn order(&self, weld: &[u32]) -> Vec<u32> {
        // The next vertex at the same position.
        let (mut last, mut next) = (weld.to_vec(), vec![u32::MAX; weld.len()]);
        for (v, w) in (0..).zip(weld).filter(|(v, w)| v != *w) {
            next[last[*w as usize] as usize] = v;
            last[*w as usize] = v;
        }
        let (late, early) = self.leaves.split_at(shallow_leaves(self.leaves.len()));
        let mut order = Vec::with_capacity(weld.len());
        for leaf in early.iter().chain(late) {
            for (v, _) in leaf.vertex.iter().zip(leaf.x).filter(|(_, x)| x.is_finite()) {
                let mut v = *v;
                while v != u32::MAX {
                    order.push(v);
                    v = next[v as usize];
                }
            }
        }
        order
    }
}

/// A vertex on its way into the tree.
#[derive(Debug, Clone, Copy)]
struct Point {
    at: [f32; 3],
    vertex: u32,
}

impl Point {
    /// Orders points along an axis and, so that there are no ties, by vertex.
    #[inline]
    fn key(&self, axis: usize) -> u64 {
        let bits = self.at[axis].to_bits();
        // The order of unsigned integers for that of floats: negative ones are turned over.
        let mask = if bits >> 31 == 1 { u32::MAX } else { 1 << 31 };
        u64::from(bits ^ mask) << 32 | u64::from(self.vertex)
    }
}

/// Inner nodes of a tree with so many leaves.
fn inner_nodes(leaves: usize) -> usize {
    leaves.saturating_sub(1).div_ceil(WIDE - 1)
}

/// Nodes on all levels above level `level`, the root's being 0.
fn above(level: u32) -> usize {
    (WIDE.pow(level) - 1) / (WIDE - 1)
}

/// The level of the last of so many nodes (one or more).
fn deepest(nodes: usize) -> u32 {
    (0..).find(|l| above(l + 1) >= nodes).unwrap_or(0)
}

/// Of so many leaves, how many are not on the deepest level. These come first by number, and last from left to right.
fn shallow_leaves(leaves: usize) -> usize {
    let inner = inner_nodes(leaves);
    above(deepest(inner + leaves)).saturating_sub(inner)
}

/// Leaves below each child of the root of a tree with so many leaves (two or more): the deepest level is filled from the left.
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

/// Brings the points of a tree with so many leaves into its order, from left to right.
fn arrange(points: &mut [Point], leaves: usize, tasks: &dyn TaskSystem) {
    let mut branches = vec![(points, leaves)];
    // Level by level until there is enough to do for all; then each branch to its end.
    let enough = if tasks.workers() > 1 { tasks.workers() * 4 } else { 1 };
    while branches.len() < enough && branches.iter().any(|b| b.1 > 1) {
        let parted =
            map(
                tasks,
                branches,
                |(points, leaves)| {
                    if leaves > 1 { part(points, leaves).into() } else { vec![(points, leaves)] }
                },
            );
        branches = parted.into_iter().flatten().collect();
    }
    map(tasks, branches, |(points, leaves)| finish(points, leaves));
}

/// Parts points down to leaves.
fn finish(points: &mut [Point], leaves: usize) {
    if leaves > 1 {
        part(points, leaves).into_iter().for_each(|(points, leaves)| finish(points, leaves));
    } else {
        points.sort_unstable_by_key(|p| p.vertex);
    }
}

/// The points and numbers of leaves of the root's children.
fn part(points: &mut [Point], leaves: usize) -> [(&mut [Point], usize); WIDE] {
    let [a, b, c, d] = leaves_below(leaves);
    let (left, right) = halve(points, (a + b) * LEAF);
    let (first, second) = halve(left, a * LEAF);
    let (third, fourth) = halve(right, c * LEAF);
    [(first, a), (second, b), (third, c), (fourth, d)]
}

/// The first `n` points along the widest axis, and the others. Which those are does not depend on their order: nor does the
/// tree, in the end.
fn halve(points: &mut [Point], n: usize) -> (&mut [Point], &mut [Point]) {
    if n >= points.len() {
        return (points, &mut []);
    }
    let b = bounds(points);
    let extent = (b.max - b.min).to_array();
    let axis =
        if extent[0] >= extent[1] && extent[0] >= extent[2] { 0 } else { 1 + usize::from(extent[2] > extent[1]) };
    points.select_nth_unstable_by_key(n, |p| p.key(axis));
    points.split_at_mut(n)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Serial, ThreadPool};
    use proptest::prelude::*;

    fn weld(positions: &[Vec3]) -> Vec<u32> {
        let first = |p: &Vec3| positions.iter().position(|q| q == p).unwrap() as u32;
        positions.iter().map(first).collect()
    }

    /// All vertices with their squared distances, nearest first, lowest first among equals.
    fn compared(positions: &[Vec3], weld: &[u32], q: Vec3) -> Vec<(u32, f32)> {
        let d = |p: Vec3| (p.x - q.x) * (p.x - q.x) + (p.y - q.y) * (p.y - q.y) + (p.z - q.z) * (p.z - q.z);
        let mut all: Vec<(u32, f32)> = (0..positions.len() as u32)
            .filter(|v| weld[*v as usize] == *v)
            .map(|v| (v, d(positions[v as usize])))
            .collect();
        all.sort_by(|a, b| a.1.total_cmp(&b.1).then(a.0.cmp(&b.0)));
        all
    }

    /// Random clouds, lattices with many ties, lines, one place many times, and coordinates up to the greatest allowed.
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
        let weld = weld(positions);
        let index = VertexIndex::new(positions, &weld, &Serial);
        let all = compared(positions, &weld, q);
        let found = index.nearest(q, positions);
        let distance = (positions[all[0].0 as usize].as_dvec3() - q.as_dvec3()).length() as f32;
        prop_assert_eq!(found.map(|n| n.vertex), distance.is_finite().then_some(all[0].0));
        let finite: Vec<_> = all.iter().copied().filter(|(_, d)| d.is_finite()).take(4).collect();
        prop_assert_eq!(index.four(q).iter().collect::<Vec<_>>(), finite.clone());
        for reach in [0.0, 0.1, 1.0, 1e9] {
            let near = index.four_if_near(q, reach);
            if finite.first().is_some_and(|f| f.1.sqrt() < reach) {
                prop_assert_eq!(near.iter().collect::<Vec<_>>(), finite.clone());
            }
        }
        Ok(())
    }

    proptest! {
        #[test]
        fn answers_are_those_of_comparing_all(points in clouds(), q in prop::array::uniform3(-1.5f32..1.5), scale in 0u32..5) {
            let q = Vec3::from_array(q);
            let q = match scale { 0 => q, 1 => (q * 4.0).round(), 2 => q * 1e9, 3 => q * 2e19, _ => points[0] };
            check(&points, q)?;
        }

        #[test]
        fn the_tree_does_not_depend_on_threads(points in clouds()) {
            let weld = weld(&points);
            let serial = VertexIndex::new(&points, &weld, &Serial);
            let parallel = VertexIndex::new(&points, &weld, &ThreadPool::new(3).unwrap());
            prop_assert_eq!(bytemuck::cast_slice::<_, u8>(&serial.inner), bytemuck::cast_slice::<_, u8>(&parallel.inner));
            prop_assert_eq!(bytemuck::cast_slice::<_, u8>(&serial.leaves), bytemuck::cast_slice::<_, u8>(&parallel.leaves));
            let mut order = serial.order(&weld);
            order.sort_unstable();
            prop_assert_eq!(order, (0..points.len() as u32).collect::<Vec<_>>());
        }

        /// Whatever the arrays hold, queries end with vertices of the mesh.
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
            prop_assert!(Tree::new(&inner, &all, 6).is_none() || all.iter().all(|l| !l.vertex.contains(&6)));
            prop_assert!(Tree::new(&inner, &all[1..], 7).is_none() || leaves % 3 != 2);
            prop_assert!(Tree::new(&inner, &[], 7).is_none());
            let tree = Tree::new(&inner, &all, 7).unwrap();
            let q = Vec3::from_array(q);
            prop_assert!(tree.nearest(q, &[Vec3::ONE; 7]).is_none_or(|n| n.vertex < 7));
            prop_assert!(tree.four(q).iter().all(|(v, _)| v < 7));
            prop_assert!(tree.four_if_near(q, 1.0).iter().all(|(v, _)| v < 7));
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

    #[test]
    fn neighbours_in_the_trees_order_are_near() {
        let positions: Vec<Vec3> = (0..10_000u32)
            .map(|i| i.wrapping_mul(2_654_435_761) % 10_000)
            .map(|i| Vec3::new((i % 100) as f32, (i / 100) as f32, 0.0))
            .collect();
        let weld = weld(&positions);
        let order = VertexIndex::new(&positions, &weld, &Serial).order(&weld);
        let step =
            |o: &[u32]| o.windows(2).map(|w| positions[w[0] as usize].distance(positions[w[1] as usize])).sum::<f32>();
        let all: Vec<u32> = (0..10_000).collect();
        assert!(step(&order) < 0.1 * step(&all), "{} of {}", step(&order), step(&all));
    }
}
