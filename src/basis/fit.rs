//! Fits the weights of a tile's vertices: least squares over fields, towards kriging from the nodes where fields say little.

use super::slopes::{Entry, Slopes};
use super::{MOST_WEIGHT, ONE, TILE};
use crate::base::math::nearest_whole;
use crate::mesh::Mesh;
use crate::mesh::nearest::VertexIndex;
use glam::Vec3;

/// Nodes that each vertex of a tile brings along.
pub(crate) const NEAREST: usize = 7;
/// Nodes that a vertex follows whose position several vertices share: the same in every tile.
const SHARED: usize = 12;
/// Weights of the prior, as shares of the fields' mean square at a node. The first is taken with which weights are [`tame`], else the last.
const PRIORS: [f64; 3] = [0.1, 1.0, 10.0];
/// The largest absolute weight, and the largest sum of absolute weights, of a vertex: larger ones amplify what the fields do not show.
const TAME: (f64, f64) = (1.6, 4.0);
/// Variance of a constant field in the prior: so weights sum to 1.
const CONSTANT: f64 = 10.0;
/// How far away a vertex's nodes may be, in distances of its third nearest node or of the tile's neighbouring nodes, whichever is
/// more. Those further away are in its tile for the sake of others.
const REACH: f32 = 4.0;
/// Length of the prior's kernel, in mean distances of neighbouring nodes.
const LENGTH: f32 = 2.0;

/// What tiles are fitted to.
pub(crate) struct Fitting<'a> {
    pub mesh: &'a Mesh,
    /// Displacements of all vertices, m, field by field, and of all nodes.
    pub fields: &'a [&'a [Vec3]],
    pub at_nodes: &'a [Vec<Vec3>],
    /// The nodes' positions, m.
    pub nodes: &'a [Vec3],
    /// Their tree, by their index.
    pub index: &'a VertexIndex,
    /// Empty: only positions are fitted.
    pub slopes: &'a Slopes,
    /// Whether other vertices share the vertex's position.
    pub shared: &'a [bool],
    /// Whether the vertex follows nothing.
    pub held: &'a [bool],
}

/// The fitted weights of a tile.
#[derive(Debug, Default)]
pub(crate) struct FittedTile {
    /// Ascending.
    pub nodes: Vec<u32>,
    /// By node, then vertex.
    pub weights: Vec<[i32; TILE]>,
    /// Along both tangents, 1/m. Empty without slopes.
    pub slopes: Vec<[[f32; 2]; TILE]>,
}

impl FittedTile {
    /// Leaves out nodes that nothing follows.
    pub(crate) fn forget_unused(&mut self) {
        let turns = |slopes: &[[f32; 2]; TILE]| slopes.iter().flatten().any(|s| *s != 0.0);
        let used: Vec<bool> = (0..self.nodes.len())
            .map(|n| self.weights[n] != [0; TILE] || self.slopes.get(n).is_some_and(turns))
            .collect();
        let (mut a, mut b, mut c) = (used.iter(), used.iter(), used.iter());
        self.nodes.retain(|_| *a.next().unwrap_or(&true));
        self.weights.retain(|_| *b.next().unwrap_or(&true));
        self.slopes.retain(|_| *c.next().unwrap_or(&true));
    }
}

impl Fitting<'_> {
    fn position(&self, node: u32) -> Vec3 {
        self.nodes[node as usize]
    }

    /// The nodes of a tile: those nearest to each of its vertices.
    fn tile_nodes(&self, vertices: std::ops::Range<usize>) -> Vec<u32> {
        let mut nodes = Vec::new();
        for v in vertices {
            let p = self.mesh.positions()[v];
            if self.shared[v] {
                nodes.extend(self.index.several::<SHARED>(p).iter().map(|(_, n)| *n));
            } else {
                nodes.extend(self.index.several::<NEAREST>(p).iter().map(|(_, n)| *n));
            }
        }
        nodes.sort_unstable();
        nodes.dedup();
        nodes
    }

    /// Fits a tile.
    pub(crate) fn tile(&self, tile: usize) -> FittedTile {
        let weld = self.mesh.weld();
        let vertices = tile * TILE..((tile + 1) * TILE).min(weld.len());
        let nodes = self.tile_nodes(vertices.clone());
        // The tile's positions and, for slopes, those around them.
        let mut targets: Vec<u32> = vertices.clone().map(|v| weld[v]).collect();
        targets.extend(vertices.clone().flat_map(|v| self.slopes.entries(v)).map(|(neighbour, _)| *neighbour));
        targets.sort_unstable();
        targets.dedup();
        let solved = self.solve(&nodes, &targets);
        let spacing = self.spacing(&nodes.iter().map(|n| self.position(*n)).collect::<Vec<_>>());
        let mut out = FittedTile {
            weights: vec![[0; TILE]; nodes.len()],
            slopes: vec![[[0.0; 2]; TILE]; if self.slopes.is_empty() { 0 } else { nodes.len() }],
            nodes,
        };
        for (i, v) in vertices.enumerate() {
            if self.shared[v] {
                self.shared_vertex(v, i, &mut out);
            } else {
                let far = self.far(v, &out.nodes, spacing);
                let row = |target: u32| {
                    let mut row = solved[targets.partition_point(|t| *t < target)].clone();
                    row.iter_mut().zip(&far).filter(|(_, far)| **far).for_each(|(w, _)| *w = 0.0);
                    row
                };
                if !self.held[v] {
                    out.weights.iter_mut().zip(rounded(&row(weld[v]), ONE)).for_each(|(to, w)| to[i] = w);
                }
                for (neighbour, along) in self.moving(v) {
                    for (to, w) in out.slopes.iter_mut().zip(row(*neighbour)) {
                        add_slope(&mut to[i], *along, w);
                    }
                }
            }
        }
        out
    }

    /// Which of a tile's nodes are out of a vertex's reach. `spacing` is that of the tile's nodes, m.
    fn far(&self, v: usize, nodes: &[u32], spacing: f32) -> Vec<bool> {
        let p = self.mesh.positions()[v];
        let third = self.index.several::<3>(p).last().map_or(0.0, |(squared, _)| squared.sqrt());
        let reach = REACH * third.max(spacing);
        nodes.iter().map(|n| self.position(*n).distance(p) > reach).collect()
    }

    /// The weights of a vertex whose position others share: over its own nodes, the same in every tile.
    fn shared_vertex(&self, v: usize, i: usize, tile: &mut FittedTile) {
        let own = self.mesh.weld()[v];
        let near = self.index.several::<SHARED>(self.mesh.positions()[v]);
        let mut nodes: Vec<u32> = near.iter().map(|(_, n)| *n).collect();
        nodes.sort_unstable();
        // Alone: what else is solved for decides on the prior, and differs between vertices at one position.
        let weights = self.solve(&nodes, &[own]);
        let targets: Vec<u32> = self.moving(v).map(|(n, _)| *n).collect();
        let solved = self.solve(&nodes, &targets);
        let at = |n: &u32| tile.nodes.binary_search(n).unwrap_or(0);
        let places: Vec<usize> = nodes.iter().map(at).collect();
        if !self.held[v] {
            for (place, w) in places.iter().zip(rounded(&weights[0], ONE)) {
                tile.weights[*place][i] = w;
            }
        }
        for ((_, along), row) in self.moving(v).zip(&solved) {
            for (place, w) in places.iter().zip(row) {
                add_slope(&mut tile.slopes[*place][i], *along, *w);
            }
        }
    }

    /// The entries of a vertex's slopes, but for held neighbours.
    fn moving(&self, v: usize) -> impl Iterator<Item = &Entry> {
        self.slopes.entries(v).iter().filter(|(neighbour, _)| !self.held[*neighbour as usize])
    }

    /// For each target vertex, the weights of the nodes: with the weakest prior that keeps them tame.
    fn solve(&self, nodes: &[u32], targets: &[u32]) -> Vec<Vec<f64>> {
        if targets.is_empty() {
            return Vec::new();
        }
        let (fields, prior) = (self.products(nodes, targets), self.prior(nodes, targets));
        let mut solved = Vec::new();
        for weight in PRIORS {
            solved = fields.solve(weight, &prior);
            if solved.iter().all(|weights| tame(weights)) {
                break;
            }
        }
        solved
    }

    /// What the fields say.
    fn products(&self, nodes: &[u32], targets: &[u32]) -> Covariance {
        let (m, n) = (nodes.len(), targets.len());
        let mut sums = Covariance { gram: vec![0.0; m * m], right: vec![0.0; m * n], nodes: m, targets: n };
        let mut at_nodes = [vec![0.0f64; m], vec![0.0f64; m], vec![0.0f64; m]];
        let mut at_targets = [vec![0.0f64; n], vec![0.0f64; n], vec![0.0f64; n]];
        for (field, there) in self.fields.iter().zip(self.at_nodes) {
            if nodes.iter().all(|node| there[*node as usize] == Vec3::ZERO) {
                continue;
            }
            by_axis(&mut at_nodes, nodes, there);
            by_axis(&mut at_targets, targets, field);
            for i in 0..m {
                let u = [0, 1, 2].map(|k| at_nodes[k][i]);
                if u != [0.0; 3] {
                    let (later, all) = (at_nodes.each_ref().map(|a| &a[i..]), at_targets.each_ref().map(|a| &a[..]));
                    add_products(&mut sums.gram[i * m + i..(i + 1) * m], u, later);
                    add_products(&mut sums.right[i * n..(i + 1) * n], u, all);
                }
            }
        }
        sums
    }

    /// What is expected where the fields say little.
    fn prior(&self, nodes: &[u32], targets: &[u32]) -> Covariance {
        let (m, n) = (nodes.len(), targets.len());
        let mut out = Covariance { gram: vec![0.0; m * m], right: Vec::with_capacity(m * n), nodes: m, targets: n };
        let positions: Vec<Vec3> = nodes.iter().map(|n| self.position(*n)).collect();
        let length = (LENGTH * self.spacing(&positions)).max(f32::MIN_POSITIVE);
        for (i, p) in positions.iter().enumerate() {
            for (j, q) in positions.iter().enumerate().skip(i) {
                out.gram[i * m + j] = prior(*p, *q, length);
            }
            out.right.extend(targets.iter().map(|t| prior(self.mesh.positions()[*t as usize], *p, length)));
        }
        out
    }

    /// The mean distance of a few nodes from their nearest neighbours, m.
    fn spacing(&self, positions: &[Vec3]) -> f32 {
        let nearest = |p: &Vec3| self.index.several::<3>(*p).get(2).map_or(0.0, |(d, _)| d.sqrt());
        positions.iter().map(nearest).sum::<f32>() / positions.len().max(1) as f32
    }
}

/// How the displacements of a few nodes go with each other's, and with those of other vertices.
struct Covariance {
    /// The upper half of a square of nodes, row by row.
    gram: Vec<f64>,
    /// For each node a row of targets.
    right: Vec<f64>,
    nodes: usize,
    targets: usize,
}

impl Covariance {
    /// For each target the weights of the nodes, with a prior of this weight.
    fn solve(&self, weight: f64, prior: &Covariance) -> Vec<Vec<f64>> {
        let (m, n) = (self.nodes, self.targets);
        let squares: f64 = (0..m).map(|i| self.gram[i * m + i]).sum();
        let scale = if squares > 0.0 { weight * squares / m as f64 } else { 1.0 };
        let with = |(a, b): (&f64, &f64)| a + scale * b;
        let mut gram: Vec<f64> = self.gram.iter().zip(&prior.gram).map(with).collect();
        (0..m).for_each(|i| gram[i * m + i] += scale * 1e-5);
        let mut right: Vec<f64> = self.right.iter().zip(&prior.right).map(with).collect();
        factor(&mut gram, m);
        substitute(&gram, m, &mut right, n);
        (0..n).map(|t| (0..m).map(|i| right[i * n + t]).collect()).collect()
    }
}

fn tame(weights: &[f64]) -> bool {
    weights.iter().all(|w| w.abs() <= TAME.0) && weights.iter().map(|w| w.abs()).sum::<f64>() <= TAME.1
}

pub(super) fn add_slope(to: &mut [f32; 2], along: [f32; 2], weight: f64) {
    to[0] += along[0] * weight as f32;
    to[1] += along[1] * weight as f32;
}

/// The prior covariance of the displacements of two points: Matérn 5/2, and a constant.
fn prior(a: Vec3, b: Vec3, length: f32) -> f64 {
    let d = 5.0f64.sqrt() * f64::from(a.distance(b) / length);
    (1.0 + d + d * d / 3.0) * libm::exp(-d) + CONSTANT
}

/// The displacements of some vertices, axis by axis.
fn by_axis(to: &mut [Vec<f64>; 3], vertices: &[u32], field: &[Vec3]) {
    for (i, v) in vertices.iter().enumerate() {
        let u = field[*v as usize].as_dvec3().to_array();
        to.iter_mut().zip(u).for_each(|(to, u)| to[i] = u);
    }
}

/// Adds the products of a vector with each of some others.
fn add_products(to: &mut [f64], u: [f64; 3], others: [&[f64]; 3]) {
    let [x, y, z] = others;
    for (((to, x), y), z) in to.iter_mut().zip(x).zip(y).zip(z) {
        *to += u[0] * x + u[1] * y + u[2] * z;
    }
}

/// The Cholesky factor (upper: `a = f^T f`) of a symmetric, positive definite matrix, of which the upper half is given, in place.
/// Row by row, so that the inner loops are over independent numbers.
fn factor(a: &mut [f64], n: usize) {
    let mut sums = vec![0.0f64; n];
    for j in 0..n {
        let (above, rest) = a.split_at_mut(j * n);
        let sums = &mut sums[j..];
        sums.fill(0.0);
        for row in above.chunks_exact(n) {
            let at = row[j];
            sums.iter_mut().zip(&row[j..]).for_each(|(sum, x)| *sum += at * x);
        }
        let row = &mut rest[j..n];
        row.iter_mut().zip(&*sums).for_each(|(x, sum)| *x -= sum);
        row[0] = row[0].max(1e-300).sqrt();
        let diagonal = row[0];
        row[1..].iter_mut().for_each(|x| *x /= diagonal);
    }
}

/// Solves for `m` right sides, the columns of `x`, in place.
fn substitute(factor: &[f64], n: usize, x: &mut [f64], m: usize) {
    let mut sums = vec![0.0f64; m];
    for i in 0..n {
        let (before, rest) = x.split_at_mut(i * m);
        sums.fill(0.0);
        for (k, earlier) in before.chunks_exact(m).enumerate() {
            let at = factor[k * n + i];
            sums.iter_mut().zip(earlier).for_each(|(sum, x)| *sum += at * x);
        }
        let diagonal = factor[i * n + i];
        rest[..m].iter_mut().zip(&sums).for_each(|(x, sum)| *x = (*x - sum) / diagonal);
    }
    for i in (0..n).rev() {
        let (before, rest) = x.split_at_mut(i * m);
        let diagonal = factor[i * n + i];
        rest[..m].iter_mut().for_each(|x| *x /= diagonal);
        for (k, earlier) in before.chunks_exact_mut(m).enumerate() {
            let at = factor[k * n + i];
            earlier.iter_mut().zip(&rest[..m]).for_each(|(x, solved)| *x -= at * solved);
        }
    }
}

/// Weights as whole numbers of 1 / [`ONE`] with this sum; smaller where their absolute sum would be too large.
pub(super) fn rounded(weights: &[f64], total: i32) -> Vec<i32> {
    let mut whole = whole(weights.iter().map(|w| w * f64::from(ONE)).collect(), total);
    while whole.iter().map(|w| w.abs()).sum::<i32>() > MOST_WEIGHT {
        // Rare: nearer to the nearest nodes' mean.
        whole.iter_mut().for_each(|w| *w = *w * 3 / 4);
        let rest = total - whole.iter().sum::<i32>();
        let Some(largest) = (0..whole.len()).max_by_key(|i| whole[*i]) else { break };
        whole[largest] = (whole[largest] + rest).clamp(-MOST, MOST);
    }
    whole
}

/// The largest 8-bit number in use.
const MOST: i32 = 127;

/// Rounds numbers to 8 bits with the least change by which they sum to `total`. Zeros stay.
pub(super) fn whole(numbers: Vec<f64>, total: i32) -> Vec<i32> {
    let limit = f64::from(MOST);
    let mut whole: Vec<i32> = numbers.iter().map(|x| nearest_whole(x.clamp(-limit, limit))).collect();
    let mut rest = total - whole.iter().sum::<i32>();
    while rest != 0 {
        let sign = rest.signum();
        // The one that gets nearer to its number, or less further from it, than any other.
        let gain = |i: usize| (numbers[i] - f64::from(whole[i])) * f64::from(sign);
        let free = |i: &usize| numbers[*i] != 0.0 && (whole[*i] + sign).abs() <= MOST;
        let Some(best) = (0..whole.len()).filter(free).reduce(|a, b| if gain(b) > gain(a) { b } else { a }) else {
            break;
        };
        whole[best] += sign;
        rest -= sign;
    }
    whole
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_factor_solves() {
        let mut a = vec![4.0, 2.0, -2.0, 0.0, 5.0, 1.0, 0.0, 0.0, 6.0];
        let full = [[4.0, 2.0, -2.0], [2.0, 5.0, 1.0], [-2.0, 1.0, 6.0]];
        factor(&mut a, 3);
        // Two right sides, the second ten times the first.
        let right = [2.0, 8.0, 5.0];
        let mut x = right.map(|r| [r, 10.0 * r]).concat();
        substitute(&a, 3, &mut x, 2);
        for (row, right) in full.iter().zip(right) {
            for (side, times) in [1.0, 10.0].into_iter().enumerate() {
                let sum: f64 = row.iter().zip(x.chunks_exact(2)).map(|(a, x)| a * x[side]).sum();
                assert!((sum - times * right).abs() < 1e-11, "{sum} {right}");
            }
        }
    }

    #[test]
    fn rounded_weights_sum_to_one() {
        assert_eq!(rounded(&[0.335, 0.335, 0.33], ONE), [22, 21, 21]);
        assert_eq!(rounded(&[1.0, 0.0], ONE), [64, 0]);
        for weights in [vec![1.9, -0.5, -0.4], vec![0.07; 14], vec![9.0, -8.0]] {
            let whole = rounded(&weights, ONE);
            assert_eq!(whole.iter().sum::<i32>(), ONE, "{whole:?}");
            assert!(whole.iter().map(|w| w.abs()).sum::<i32>() <= MOST_WEIGHT);
        }
    }
}
