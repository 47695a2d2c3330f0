//! The example set: a base mesh and its examples, ready for use. It is immutable, and all instances share it.

use super::blocks::{Bytes, DeltaBlocks};
use super::example::Example;
use super::mesh_lod::MeshLod;
use super::options::{SetOptions, VertexMass};
use super::report::{LodReport, SetReport};
use super::rule::{LearnedRule, Source};
use crate::base::array::Array;
use crate::base::error::Error;
use crate::base::lists::Lists;
use crate::basis::field::GROUP;
use crate::basis::learn::BasisReport;
use crate::basis::{Rows, TILE};
use crate::mesh::Mesh;
use crate::mesh::nearest::{Nearest, VertexIndex};
use crate::mesh::rim::Rim;
use crate::mesh::surface::SurfaceIndex;
use crate::mesh::vertex_blocks::BLOCK;
use std::sync::{Arc, OnceLock};

/// A base mesh with its examples. It is immutable: the instances of the mesh and threads share it through an `Arc`.
///
/// ```
/// use crumple::{Deltas, ExampleData, ExampleSet, MeshData, Serial, SetOptions};
/// let mesh = MeshData {
///     positions: vec![[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]],
///     triangles: vec![[0, 1, 2]],
///     ..Default::default()
/// };
/// let dent = ExampleData::new("dent", Deltas::Sparse { indices: vec![0], values: vec![[0.0, 0.0, -0.1]] });
/// let set = ExampleSet::build(mesh, vec![dent], SetOptions::default(), &Serial)?;
/// assert!((set.depth_limit() - 0.1 * 3.0).abs() < 1e-6);
/// # Ok::<(), crumple::Error>(())
/// ```
#[derive(Debug)]
pub struct ExampleSet {
    base: MeshLod,
    /// Levels of detail 1 and up: other meshes that show the same damage.
    lods: Vec<MeshLod>,
    examples: Vec<Example>,
    options: SetOptions,
    depth_limit: f32,
    index: VertexIndex,
    fingerprint: u64,
    report: SetReport,
    basis_report: Option<BasisReport>,
    /// The source index of each vertex, if the mesh was [reordered](fn@crate::reorder). Only tools use it.
    source_order: Option<Array<u32>>,
    /// The nodes that vertices follow. There once the set is made.
    nodes: Option<SetNodes>,
    rule: Option<LearnedRule>,
    /// Spatial index of the base mesh's triangles, built on first use.
    surface: OnceLock<SurfaceIndex>,
}

/// The nodes that the vertices of a set follow.
#[derive(Debug)]
pub(crate) struct SetNodes {
    /// The nodes as a mesh without triangles, with the set's examples on it.
    pub lod: MeshLod,
    /// For each mesh of the set what [`followers`] returns.
    pub followers: Vec<Lists<(u32, u32)>>,
}

/// For each group of nodes the blocks that have a vertex which follows one of them, each with a bit for each node.
fn followers(rows: &Rows, nodes: usize) -> Lists<(u32, u32)> {
    let mut groups: Vec<Vec<(u32, u32)>> = vec![Vec::new(); nodes.div_ceil(GROUP)];
    for tile in 0..rows.tiles.len() {
        let block = (tile / (BLOCK / TILE)) as u32;
        for node in rows.nodes_of(tile) {
            let (group, bit) = (&mut groups[*node as usize / GROUP], 1 << (*node as usize % GROUP));
            match group.last_mut() {
                Some((last, bits)) if *last == block => *bits |= bit,
                _ => group.push((block, bit)),
            }
        }
    }
    let mut lists = Lists::default();
    groups.iter().for_each(|group| lists.push(group));
    lists
}

/// Maximum number of meshes of a set: the base mesh and its levels of detail.
pub(crate) const MAX_MESHES: usize = 64;

/// The parts of a set, built or loaded.
pub(crate) struct Parts {
    pub base: MeshLod,
    /// Levels of detail, each with its report.
    pub lods: Vec<(MeshLod, LodReport)>,
    pub examples: Vec<Example>,
    pub options: SetOptions,
    pub index: VertexIndex,
    pub fingerprint: u64,
    /// The welded vertices and the mirror planes; the rest follows from the other parts.
    pub report: SetReport,
    pub source_order: Option<Array<u32>>,
}

/// The default depth limit, over the deepest example. A panel that is hit 64 times gets 2.6 times as deep as by its hardest
/// hit.
const DEPTH_LIMIT: f32 = 3.0;

/// The longest displacement of all examples, m. Includes the contacts' displacements before rounding.
pub(crate) fn deepest(examples: &[Example]) -> f32 {
    examples.iter().map(|e| e.max_depth.max(e.depth)).fold(0.0, f32::max)
}

impl ExampleSet {
    /// Makes a set from parts as [`ExampleSet::build`] makes them.
    pub(crate) fn assemble(p: Parts) -> Self {
        let mesh = &p.base.mesh;
        let [limited_vertices, stiff_vertices, rigid_vertices] = mesh.limits().count();
        let mut report = SetReport {
            limited_vertices,
            stiff_vertices,
            rigid_vertices,
            repaired_normals: mesh.repaired_normals(),
            degenerate_triangles: mesh.degenerate_triangles(),
            held_vertices: p.base.rim.held.len(),
            lods: p.lods.iter().map(|l| l.1).collect(),
            ..p.report
        };
        for (i, e) in p.examples.iter().enumerate() {
            let bytes = e.whole.as_ref().map_or_else(Bytes::default, |whole| whole.bytes());
            report.anchored_bytes += bytes.total();
            report.normal_bytes += bytes.normals;
            report.moved_vertices += e.moved;
            report.blocks_by_width.iter_mut().zip(bytes.blocks).for_each(|(sum, n)| *sum += n);
            if e.is_empty() {
                report.empty_examples.push(i);
            }
        }
        Self {
            depth_limit: p.options.depth_limit.unwrap_or(DEPTH_LIMIT * deepest(&p.examples)),
            base: p.base,
            lods: p.lods.into_iter().map(|l| l.0).collect(),
            examples: p.examples,
            options: p.options,
            index: p.index,
            fingerprint: p.fingerprint,
            report,
            basis_report: None,
            source_order: p.source_order,
            nodes: None,
            rule: None,
            surface: OnceLock::new(),
        }
    }

    /// The base mesh.
    pub fn mesh(&self) -> &Mesh {
        &self.base.mesh
    }

    /// Number of meshes that show the damage: the base mesh and the levels of detail added.
    pub fn lod_count(&self) -> usize {
        1 + self.lods.len()
    }

    /// The mesh of a level of detail; 0 is the base mesh.
    ///
    /// # Errors
    /// [`Error::IndexOutOfRange`].
    pub fn lod_mesh(&self, lod: usize) -> Result<&Mesh, Error> {
        Ok(&self.lod(lod)?.mesh)
    }

    /// Number of vertices of the base mesh.
    pub fn vertex_count(&self) -> usize {
        self.base.vertex_count()
    }

    /// The examples, in the order given.
    pub fn examples(&self) -> &[Example] {
        &self.examples
    }

    /// The options that the set was built with.
    pub fn options(&self) -> &SetOptions {
        &self.options
    }

    /// Largest displacement of any vertex, m, unless an instance sets its own limit.
    pub fn depth_limit(&self) -> f32 {
        self.depth_limit
    }

    /// A hash of everything that marks depend on. Saved damage contains it. It is the same on every platform.
    pub fn fingerprint(&self) -> u64 {
        self.fingerprint
    }

    /// Statistics from building the set.
    pub fn report(&self) -> &SetReport {
        &self.report
    }

    /// Whether the set holds its examples whole, as the classic rules need them: one that was built, or whose file has them ([`SetOptions::whole_examples`]).
    pub fn has_whole_examples(&self) -> bool {
        !self.base.anchored.is_empty()
    }

    /// What the nodes that vertices follow cost, and how well they hold the examples; `None` for a set from a file.
    pub fn basis_report(&self) -> Option<BasisReport> {
        self.basis_report
    }

    /// Memory used by meshes and examples, bytes.
    pub fn memory_bytes(&self) -> usize {
        self.lods().map(MeshLod::bytes).sum::<usize>()
            + self.nodes().lod.bytes()
            + self.index.bytes()
            + self.rule.as_ref().map_or(0, LearnedRule::bytes)
    }

    /// The vertex nearest to `point` (mesh space, m). The lowest index if several are equally near.
    ///
    /// # Errors
    /// [`Error::NotFinite`]; [`Error::InvalidArgument`] if the distance overflows.
    pub fn nearest_vertex(&self, point: [f32; 3]) -> Result<Nearest, Error> {
        self.index.of_point(point, self.mesh().positions())
    }

    /// The source index of each vertex. `None` unless the order of a [reordered](fn@crate::reorder) mesh was
    /// [stored](ExampleSet::set_source_order).
    pub fn source_order(&self) -> Option<&[u32]> {
        self.source_order.as_deref()
    }

    /// Stores the source index of each vertex, as [`reorder`](fn@crate::reorder) returned it. It is saved with the set.
    /// Nothing else depends on it.
    ///
    /// # Errors
    /// [`Error::InvalidArgument`] unless `order` contains every number below the number of vertices exactly once.
    pub fn set_source_order(&mut self, order: Vec<u32>) -> Result<(), Error> {
        check_order(&order, self.vertex_count())
            .map_err(|(value, expected)| Error::invalid("the source order", value, &expected))?;
        self.source_order = Some(order.into());
        Ok(())
    }

    pub(crate) fn index(&self) -> &VertexIndex {
        &self.index
    }

    pub(crate) fn rim(&self) -> &Rim {
        &self.base.rim
    }

    /// The base mesh with the data for evaluation.
    pub(crate) fn base_lod(&self) -> &MeshLod {
        &self.base
    }

    /// All meshes that show the damage, the base mesh first.
    pub(crate) fn lods(&self) -> impl Iterator<Item = &MeshLod> {
        std::iter::once(&self.base).chain(&self.lods)
    }

    /// A level of detail; 0 is the base mesh.
    pub(crate) fn lod(&self, lod: usize) -> Result<&MeshLod, Error> {
        self.lods().nth(lod).ok_or_else(|| Error::IndexOutOfRange {
            name: "the level of detail".into(),
            index: lod as u64,
            len: self.lod_count() as u64,
        })
    }

    /// The nodes that vertices follow.
    pub(crate) fn nodes(&self) -> &SetNodes {
        self.nodes.as_ref().expect("whoever makes a set lets it follow nodes")
    }

    /// Lets all meshes follow nodes, with rows for each of them. The rule is to be learned again.
    pub(crate) fn follow(&mut self, lod: MeshLod, rows: Vec<Rows>, report: Option<BasisReport>) {
        let followers = rows.iter().map(|rows| followers(rows, lod.vertex_count())).collect();
        self.rule = None;
        self.basis_report = report;
        for (mesh, rows) in std::iter::once(&mut self.base).chain(&mut self.lods).zip(rows) {
            mesh.rows = Arc::new(rows);
        }
        for (example, moves) in self.examples.iter_mut().zip(&lod.anchored) {
            example.followed = Some((moves.clone(), self.base.rows.clone()));
        }
        self.nodes = Some(SetNodes { lod, followers });
        self.report.lods.iter_mut().zip(&self.lods).for_each(|(report, lod)| report.bytes = lod.bytes());
    }

    /// What predicts hits from all examples.
    pub(crate) fn rule(&self) -> &LearnedRule {
        self.rule.as_ref().expect("whoever makes a set lets it learn")
    }

    /// Whether a hit may be told as a blow: some example knows its own. Otherwise a displacement is made of its impulse.
    pub fn predicts_blows(&self) -> bool {
        self.rule().predictor.knows_blows()
    }

    /// For each example the relative L2 error with which the others predict it: from its blow, or from its displacement if it knows none.
    /// 1 is the error of no dent at all; 0 for an example that moves nothing.
    pub fn example_errors(&self) -> Vec<f32> {
        let mut errors = self.rule().predictor.errors().into_iter();
        let error = |(e, moves): (&Example, &Arc<DeltaBlocks>)| match (e.is_empty(), moves.is_empty()) {
            (true, _) => 0.0,
            // It lies between the nodes, so that nobody knows of it.
            (_, true) => 1.0,
            _ => errors.next().unwrap_or(1.0),
        };
        self.examples.iter().zip(&self.nodes().lod.anchored).map(error).collect()
    }

    /// What a rule is learned from, with these nodes.
    pub(crate) fn rule_source<'a>(&'a self, nodes: &'a MeshLod) -> Source<'a> {
        Source { base: self.base_lod(), mirror: self.report.mirror_planes, examples: &self.examples, nodes }
    }

    /// Lets hits be predicted.
    pub(crate) fn set_rule(&mut self, rule: LearnedRule) {
        self.rule = Some(rule);
    }

    pub(crate) fn set_fingerprint(&mut self, fingerprint: u64) {
        self.fingerprint = fingerprint;
    }

    /// Adds a mesh that follows the set's nodes.
    pub(crate) fn push_lod(&mut self, lod: MeshLod, report: LodReport) {
        if let Some(nodes) = &mut self.nodes {
            nodes.followers.push(followers(&lod.rows, nodes.lod.vertex_count()));
        }
        self.lods.push(lod);
        self.report.lods.push(report);
    }

    /// Spatial index of the base mesh's triangles. The first call builds it.
    pub(crate) fn surface(&self) -> &SurfaceIndex {
        self.surface.get_or_init(|| SurfaceIndex::new(self.mesh()))
    }

    /// Mass of vertex `v`, kg. `None` if unknown.
    pub(crate) fn mass(&self, v: u32) -> Option<f32> {
        match &self.options.mass {
            VertexMass::None => None,
            VertexMass::Uniform(m) => Some(*m),
            VertexMass::PerVertex(m) => Some(m[v as usize]),
        }
    }
}

/// Checks that `order` contains every number below `n` once. Otherwise returns the wrong value and what is expected.
pub(crate) fn check_order(order: &[u32], n: usize) -> Result<(), (String, String)> {
    if order.len() != n {
        return Err((format!("{} numbers", order.len()), format!("{n} numbers, one a vertex")));
    }
    let mut seen = vec![false; n];
    for (at, v) in order.iter().enumerate() {
        match seen.get_mut(*v as usize) {
            Some(s) if !*s => *s = true,
            _ => return Err((format!("{v} at {at}"), format!("every number below {n} once"))),
        }
    }
    Ok(())
}
