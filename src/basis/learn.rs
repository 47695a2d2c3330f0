//! Learns a basis from displacement fields: nodes are added where vertices are wrong, until the tolerance holds.

use super::fit::{FittedTile, Fitting, add_slope, rounded, whole};
use super::nodes::{refine, spread};
use super::slopes::Slopes;
use super::{Basis, ONE, Rows, TILE, Tile};
use crate::base::error::{Error, positive};
use crate::base::math::nearest_whole;
use crate::base::tasks::{TaskSystem, map};
use crate::mesh::Mesh;
use crate::mesh::mirror::Images;
use crate::mesh::nearest::VertexIndex;
use glam::Vec3;

/// How a basis is learned.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct BasisOptions {
    /// How far a vertex may be from the fields that the basis is learned from, m.
    pub tolerance: f32,
    /// The most times that nodes are added.
    pub rounds: u32,
    /// Number of nodes to begin with, spread evenly; 0 for one for each 24 vertices, and at least 2048.
    pub nodes: usize,
}

impl BasisOptions {
    /// Options for a tolerance, m: nodes are added up to eight times.
    pub fn new(tolerance: f32) -> Self {
        BasisOptions { tolerance, rounds: 8, nodes: 0 }
    }
}

/// What a basis costs, and how well it holds the fields that it was learned from.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct BasisReport {
    /// Number of nodes.
    pub nodes: usize,
    /// Nodes that a vertex follows, in the mean: as many bytes a vertex, and twice as many more for normals.
    pub nodes_a_vertex: f32,
    /// Memory, bytes.
    pub bytes: usize,
    /// The largest error of any vertex in any field, m.
    pub worst: f32,
}

/// Vertices for each of the first nodes.
const VERTICES_A_NODE: usize = 24;
/// The least number of nodes, if there are as many positions.
const LEAST_NODES: usize = 2048;

impl Basis {
    /// Learns a basis from displacement fields of all vertices (m): examples, and copies of them elsewhere. Asks for the fields only if
    /// they matter: where every position is a node, vertices follow their own. `held` vertices follow nothing.
    ///
    /// # Errors
    /// [`Error::InvalidArgument`] naming the option.
    pub(crate) fn learn(
        images: &Images,
        fields: impl FnOnce() -> Vec<Vec<Vec3>>,
        held: &[u32],
        options: &BasisOptions,
        tasks: &dyn TaskSystem,
    ) -> Result<(Self, BasisReport), Error> {
        positive("tolerance", options.tolerance, "m")?;
        let mesh = images.mesh;
        let first = match options.nodes {
            0 => (mesh.positions().len() / VERTICES_A_NODE).max(LEAST_NODES),
            nodes => nodes,
        };
        let mut nodes = spread(images, first);
        let mut is_held = vec![false; mesh.positions().len()];
        held.iter().for_each(|v| is_held[*v as usize] = true);
        let report = |nodes: usize, rows: &Rows, worst: f32| BasisReport {
            nodes,
            nodes_a_vertex: rows.nodes.len() as f32 / rows.tiles.len().max(1) as f32,
            bytes: 4 * nodes + rows.bytes(),
            worst,
        };
        if nodes.len() == mesh.weld().iter().enumerate().filter(|(v, first)| *v == **first as usize).count() {
            let own = |v: u32| nodes.partition_point(|n| *n < mesh.weld()[v as usize]) as u32;
            let row = |v: u32| if is_held[v as usize] { Vec::new() } else { vec![(own(v), 1.0)] };
            let rows = Rows::weighted(mesh, row, tasks);
            let report = report(nodes.len(), &rows, 0.0);
            return Ok((Basis { nodes: nodes.into(), rows }, report));
        }
        let fields = fields();
        let fields: Vec<&[Vec3]> = fields.iter().map(Vec::as_slice).collect();
        // What moves only vertices between nodes gets one where it is deepest.
        for field in &fields {
            let moves = |v: &u32| field[*v as usize] != Vec3::ZERO;
            let free = (0..field.len() as u32).filter(|v| moves(v) && !is_held[*v as usize]);
            let length = |v: &u32| field[*v as usize].length_squared();
            if !nodes.iter().any(moves)
                && let Some(deepest) = free.max_by(|a, b| length(a).total_cmp(&length(b)).then(b.cmp(a)))
            {
                let deepest = mesh.weld()[deepest as usize];
                nodes.extend(std::iter::once(deepest).chain(images.of(deepest)));
            }
        }
        nodes.sort_unstable();
        nodes.dedup();
        let (nodes, rows, worst) = learned(images, nodes, (&fields, &is_held), options, tasks);
        let report = report(nodes.len(), &rows, worst);
        Ok((Basis { nodes: nodes.into(), rows }, report))
    }
}

/// Adds nodes until the fields are met or the rounds are over. Returns the nodes, the rows and the largest error, m.
fn learned(
    images: &Images,
    mut nodes: Vec<u32>,
    (fields, held): (&[&[Vec3]], &[bool]),
    options: &BasisOptions,
    tasks: &dyn TaskSystem,
) -> (Vec<u32>, Rows, f32) {
    let mesh = images.mesh;
    let shared = shared(mesh.weld());
    let (slopes, none) = (Slopes::of(mesh), Slopes::default());
    let count = mesh.positions().len().div_ceil(TILE);
    let mut round = 0;
    loop {
        let positions = pick(&nodes, mesh.positions());
        let tree = VertexIndex::of_points(&positions);
        let at_nodes: Vec<Vec<Vec3>> = fields.iter().map(|field| pick(&nodes, field)).collect();
        let is_last = round == options.rounds;
        let fitting = Fitting {
            mesh,
            fields,
            at_nodes: &at_nodes,
            nodes: &positions,
            index: &tree,
            slopes: if is_last { &slopes } else { &none },
            shared: &shared,
            held,
        };
        let fitted = map(tasks, 0..count, |t| fitting.tile(t));
        let errors = map(tasks, fitted.iter().enumerate(), |(t, fitted)| errors(&fitting, t, fitted)).concat();
        let worst = errors.iter().fold(0.0, |a: f32, b| a.max(*b));
        if is_last {
            return (nodes, rows(mesh, fitted), worst);
        }
        let mut more = nodes.clone();
        if worst > options.tolerance {
            let nearest = |p: &Vec3| tree.several::<1>(*p).first().map_or(0.0, |(squared, _)| squared.sqrt());
            let distances: Vec<f32> = mesh.positions().iter().map(nearest).collect();
            refine(images, &mut more, &errors, &distances, options.tolerance);
        }
        if more.len() == nodes.len() {
            let fitting = Fitting { slopes: &slopes, ..fitting };
            return (nodes, rows(mesh, map(tasks, 0..count, |t| fitting.tile(t))), worst);
        }
        (nodes, round) = (more, round + 1);
    }
}

/// Whether other vertices share each vertex's position.
fn shared(weld: &[u32]) -> Vec<bool> {
    let mut shared = vec![false; weld.len()];
    for (v, w) in weld.iter().enumerate().filter(|(v, w)| *v != **w as usize) {
        shared[v] = true;
        shared[*w as usize] = true;
    }
    shared
}

impl Rows {
    /// How the vertices of another mesh of the body follow the same nodes: each as a point of the base mesh does, that is as a mean of
    /// three of its vertices (`at`: vertices and their shares). A vertex that is at one of them has its weights.
    pub(crate) fn of_other_mesh(
        mesh: &Mesh,
        base: &Rows,
        at: impl Fn(u32) -> [(u32, f64); 3] + Sync,
        tasks: &dyn TaskSystem,
    ) -> Self {
        let row = |v: u32| {
            let mut row: Vec<(u32, f64)> = Vec::new();
            for (corner, share) in at(v).into_iter().filter(|(_, share)| *share != 0.0) {
                row.extend(base.of(corner).map(|(node, w)| (node, f64::from(w) / f64::from(ONE) * share)));
            }
            row.sort_by_key(|(node, _)| *node);
            row
        };
        Rows::weighted(mesh, row, tasks)
    }

    /// The rows of a mesh each of whose vertices follows nodes with given weights, ascending by node; a node may come several times.
    fn weighted(mesh: &Mesh, row: impl Fn(u32) -> Vec<(u32, f64)> + Sync, tasks: &dyn TaskSystem) -> Self {
        let slopes = Slopes::of(mesh);
        rows(
            mesh,
            map(tasks, 0..mesh.positions().len().div_ceil(TILE), |t| {
                let range = t * TILE..((t + 1) * TILE).min(mesh.positions().len());
                // The vertices whose rows the tile needs, and these.
                let mut needed: Vec<u32> = range.clone().map(|v| v as u32).collect();
                needed.extend(range.clone().flat_map(|v| slopes.entries(v)).map(|(neighbour, _)| *neighbour));
                needed.sort_unstable();
                needed.dedup();
                let found: Vec<Vec<(u32, f64)>> = needed.iter().map(|v| row(*v)).collect();
                let row = |v: u32| &found[needed.partition_point(|n| *n < v)];
                let mut nodes: Vec<u32> = found.iter().flatten().map(|(node, _)| *node).collect();
                nodes.sort_unstable();
                nodes.dedup();
                let place = |node: u32| nodes.partition_point(|n| *n < node);
                let mut weights = vec![[0; TILE]; nodes.len()];
                let mut turns = vec![[[0.0; 2]; TILE]; if slopes.is_empty() { 0 } else { nodes.len() }];
                for (lane, v) in range.enumerate() {
                    let mut own = vec![0.0; nodes.len()];
                    row(v as u32).iter().for_each(|(node, w)| own[place(*node)] += w);
                    // Less than 1 near held vertices.
                    let total = own.iter().sum::<f64>() * f64::from(ONE);
                    weights.iter_mut().zip(rounded(&own, libm::round(total) as i32)).for_each(|(to, w)| to[lane] = w);
                    for (neighbour, along) in slopes.entries(v) {
                        for (node, w) in row(*neighbour) {
                            add_slope(&mut turns[place(*node)][lane], *along, *w);
                        }
                    }
                }
                let mut tile = FittedTile { nodes, weights, slopes: turns };
                tile.forget_unused();
                tile
            }),
        )
    }

    /// The nodes that a vertex follows, with their weights in units of 1 / [`ONE`].
    pub(crate) fn of(&self, v: u32) -> impl Iterator<Item = (u32, i32)> {
        let (tile, lane) = (v as usize / TILE, v as usize % TILE);
        let weights = self.weights_of(tile).chunks_exact(2 * TILE).flat_map(move |p| [p[2 * lane], p[2 * lane + 1]]);
        self.nodes_of(tile).iter().copied().zip(weights.map(i32::from)).filter(|(_, w)| *w != 0)
    }

    /// What a vertex is displaced by where its nodes are by `of_node`, m.
    pub(crate) fn at_vertex(&self, v: u32, mut of_node: impl FnMut(u32) -> Vec3) -> Vec3 {
        self.of(v).fold(Vec3::ZERO, |sum, (node, w)| sum + of_node(node) * (w as f32 / ONE as f32))
    }
}

/// The elements of these vertices.
fn pick(vertices: &[u32], of: &[Vec3]) -> Vec<Vec3> {
    vertices.iter().map(|v| of[*v as usize]).collect()
}

/// For each vertex of a tile, the largest difference from any field, m.
fn errors(fitting: &Fitting<'_>, tile: usize, fitted: &FittedTile) -> Vec<f32> {
    let vertices = fitting.mesh.positions().len();
    let range = tile * TILE..((tile + 1) * TILE).min(vertices);
    let mut errors = vec![0.0f32; range.len()];
    let one = 1.0 / ONE as f32;
    for (field, at_nodes) in fitting.fields.iter().zip(fitting.at_nodes) {
        let mut sums = [Vec3::ZERO; TILE];
        for (node, weights) in fitted.nodes.iter().zip(&fitted.weights) {
            let u = at_nodes[*node as usize] * one;
            if u != Vec3::ZERO {
                sums.iter_mut().zip(weights).for_each(|(sum, w)| *sum += u * *w as f32);
            }
        }
        for ((error, sum), u) in errors.iter_mut().zip(&sums).zip(&field[range.clone()]) {
            *error = error.max(sum.distance_squared(*u));
        }
    }
    errors.iter_mut().for_each(|e| *e = e.sqrt());
    errors
}

/// The unit of each vertex's slopes. Vertices at one position have the same, so that their normals have the same bits.
fn slope_units(mesh: &Mesh, fitted: &[FittedTile]) -> Vec<f32> {
    let own = |v: usize| {
        let slopes = fitted[v / TILE].slopes.iter().flat_map(|of_node| of_node[v % TILE]);
        slopes.fold(0.0, |a: f32, b| a.max(b.abs()))
    };
    let mut steepest: Vec<f32> = (0..TILE * fitted.len()).map(own).collect();
    for (v, w) in mesh.weld().iter().enumerate() {
        steepest[*w as usize] = steepest[*w as usize].max(steepest[v]);
    }
    for (v, w) in mesh.weld().iter().enumerate() {
        steepest[v] = steepest[*w as usize];
    }
    let unit = |steepest: f32| {
        if steepest > 0.0 && steepest.is_finite() { (steepest / 127.0).max(f32::MIN_POSITIVE) } else { 1.0 }
    };
    steepest.into_iter().map(unit).collect()
}

/// Packs fitted tiles of a mesh.
fn rows(mesh: &Mesh, fitted: Vec<FittedTile>) -> Rows {
    let slope_units = if mesh.normals().is_some() { slope_units(mesh, &fitted) } else { Vec::new() };
    let (mut tiles, mut nodes) = (Vec::with_capacity(fitted.len()), Vec::new());
    let (mut weights, mut slopes) = (Vec::new(), Vec::new());
    for (at, mut tile) in fitted.into_iter().enumerate() {
        let with_slopes = !tile.slopes.is_empty();
        if tile.nodes.len() % 2 == 1 {
            tile.nodes.extend(tile.nodes.last().copied());
            tile.weights.push([0; TILE]);
            tile.slopes.extend(with_slopes.then_some([[0.0; 2]; TILE]));
        }
        let most = (0..TILE).map(|v| tile.weights.iter().map(|w| w[v].unsigned_abs()).sum::<u32>()).max();
        tiles.push(Tile { first: nodes.len() as u32, count: tile.nodes.len() as u32, most: most.unwrap_or(0) });
        for pair in tile.weights.chunks_exact(2) {
            weights.extend((0..TILE).flat_map(|v| [pair[0][v] as i8, pair[1][v] as i8]));
        }
        for k in 0..if with_slopes { 2 } else { 0 } {
            let units = &slope_units[at * TILE..(at + 1) * TILE];
            let of_vertex = |v: usize| {
                let numbers: Vec<f64> = tile.slopes.iter().map(|s| f64::from(s[v][k] / units[v])).collect();
                // 0 but beside held vertices, so that what moves as a whole does not turn.
                let total = nearest_whole(numbers.iter().sum());
                whole(numbers, total)
            };
            let numbers: Vec<Vec<i32>> = (0..TILE).map(of_vertex).collect();
            for pair in (0..tile.nodes.len()).step_by(2) {
                slopes.extend(numbers.iter().flat_map(|of| [of[pair] as i8, of[pair + 1] as i8]));
            }
        }
        nodes.append(&mut tile.nodes);
    }
    Rows {
        tiles: tiles.into(),
        nodes: nodes.into(),
        weights: weights.into(),
        slopes: slopes.into(),
        slope_units: slope_units.into(),
    }
}
