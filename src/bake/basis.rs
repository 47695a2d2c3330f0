//! Lets a set's vertices follow nodes: learns the basis from the set's examples, and from hits all over the body.

use super::lod::rows_of;
use crate::base::error::Error;
use crate::base::tasks::{TaskSystem, map};
use crate::basis::Basis;
use crate::basis::learn::{BasisOptions, BasisReport};
use crate::damage::dent::Dent;
use crate::example::blocks::DeltaBlocks;
use crate::example::mesh_lod::MeshLod;
use crate::example::rule::LearnedRule;
use crate::example::set::{ExampleSet, deepest};
use crate::mesh::Mesh;
use crate::mesh::data::MeshData;
use crate::select::nearest::nearest_mark;
use crate::select::target::HitTarget;
use glam::Vec3;
use std::hash::Hasher;
use std::sync::Arc;
use twox_hash::XxHash3_64;

/// Hits that the basis is learned from, besides the examples.
const HITS: usize = 64;
/// The most examples that it is learned from, evenly spread over the list.
const EXAMPLES: usize = 256;
/// Examples that a hit mixes.
const MIXED: usize = 3;
/// The least depth of those hits, as a share of the deepest example.
const SHALLOW: f32 = 0.15;

/// What a set has learned of hits.
#[derive(Debug, Clone, PartialEq)]
pub struct RuleReport {
    /// For each example the relative L2 error with which the others predict it: from its blow, or from its displacement if it knows
    /// none. 1 is the error of no dent at all.
    pub errors: Vec<f32>,
    /// Whether hits told as blows are predicted.
    pub blows: bool,
    /// Whether hits told as displacements are predicted.
    pub displacements: bool,
}

impl ExampleSet {
    /// Learns again how the vertices follow *nodes*, a few of them, whose displacements alone are computed from hits
    /// (docs/model.md, "Nodes"). [`ExampleSet::build`] has done so with nodes spread evenly ([`ExampleSet::basis_report`]). Here more are
    /// added where vertices are wrong. Vertices are wrong by about the tolerance; the report says how much at worst. A rule is
    /// forgotten: [learn](ExampleSet::learn_rule) it afterwards.
    ///
    /// The basis is learned from the set's examples and from hits all over the body. Vertices that are neighbours in space should be
    /// neighbours in memory ([`reorder`](fn@crate::reorder)): 16 consecutive vertices follow the same nodes.
    ///
    /// Call it before instances are made. Instances with a classic rule do not follow nodes.
    ///
    /// # Errors
    /// [`Error::InvalidArgument`] naming the option; [`Error::Unsupported`] for a set from a file without
    /// [whole examples](crate::SetOptions::whole_examples); [`Error::OutOfMemory`]. After an error nothing has changed.
    pub fn learn_basis(&mut self, options: &BasisOptions, tasks: &dyn TaskSystem) -> Result<BasisReport, Error> {
        if !self.has_whole_examples() {
            return Err(Error::Unsupported { what: "learning the basis of a set baked without whole examples".into() });
        }
        let fields = || {
            let step = self.examples().len().div_ceil(EXAMPLES);
            let examples = (0..self.examples().len()).step_by(step).map(|i| self.base_lod().field(i));
            let thrown = map(tasks, 0..HITS, |i| self.thrown(i));
            examples.chain(thrown.into_iter().flatten()).collect()
        };
        // No example moves held vertices, and what is carried ends there.
        let (basis, report) = Basis::learn(self.mesh(), fields, &self.rim().held, options, tasks)?;
        let nodes = self.node_mesh(basis.nodes(), tasks)?;
        let of_lods = self.lods().skip(1).map(|lod| Ok(rows_of(self, &basis.rows, &lod.mesh, tasks)?.0));
        let of_lods = of_lods.collect::<Result<Vec<_>, Error>>()?;
        self.follow(nodes, std::iter::once(basis.rows).chain(of_lods).collect(), Some(report));
        Ok(report)
    }

    /// The basis of a new set.
    pub(super) fn first_basis(&mut self, tasks: &dyn TaskSystem) -> Result<(), Error> {
        // No nodes are added, whatever the tolerance.
        self.learn_basis(&BasisOptions { rounds: 0, ..BasisOptions::new(1.0) }, tasks).map(|_| ())
    }

    /// Lets the set predict hits from all of its examples at once, instead of mixing a few of them
    /// (docs/model.md, "The learned rule"). The more examples there are, the nearer it is to what they would show: more examples cost
    /// memory, and a hit or a frame hardly more. Marks then hold the hit itself, and have no pairs.
    ///
    /// The fingerprint changes, because saved damage looks different now. Call it before instances are made. Instances with a classic
    /// rule are not affected.
    ///
    /// With each example left out in turn, the set compares the rule with what the nearest examples say. Hits are predicted only where the
    /// rule is better, which the report tells: with few examples of a smooth body it often is not.
    ///
    /// # Errors
    /// [`Error::Unsupported`] if the mesh has no normals. After an error nothing has changed.
    pub fn learn_rule(&mut self, tasks: &dyn TaskSystem) -> Result<RuleReport, Error> {
        if self.mesh().normals().is_none() {
            return Err(Error::Unsupported { what: "learning the rule of a mesh without normals".into() });
        }
        let rule = LearnedRule::learn(&self.rule_source(&self.nodes().lod), tasks)?;
        let mut errors = rule.errors().iter().copied();
        let errors = self.examples().iter().map(|e| if e.is_empty() { 0.0 } else { errors.next().unwrap_or(1.0) });
        let [blows, displacements] = rule.predicts();
        let report = RuleReport { errors: errors.collect(), blows, displacements };
        if blows || displacements {
            let mut hash = XxHash3_64::new();
            hash.write(&self.fingerprint().to_le_bytes());
            hash.write(&rule.to_bytes()?);
            self.set_fingerprint(hash.finish());
            self.set_rule(rule);
        }
        Ok(report)
    }

    /// The displacements that a hit leaves, the `i`-th of a sequence that fills the body and the depths evenly. `None` if no example
    /// answers it.
    fn thrown(&self, i: usize) -> Option<Vec<Vec3>> {
        /// Multiples of them are spread evenly over 0 to 1 (Roberts' sequence in two dimensions).
        const STEPS: [f64; 2] = [0.754_877_666_246_692_7, 0.569_840_290_998_053_3];
        let at = |k: usize| (0.5 + STEPS[k] * (i + 1) as f64).fract();
        let contact = ((at(0) * self.vertex_count() as f64) as u32).min(self.vertex_count() as u32 - 1);
        let size = deepest(self.examples()) * (SHALLOW + (1.0 - SHALLOW) * at(1) as f32);
        let normal = self.mesh().contact_normal(contact)?;
        let target = HitTarget { contact, normal: Some(normal), direction: -normal, size, strike: None, told: None };
        let (_, mark) = nearest_mark(self, MIXED, &target)?;
        let mut field = vec![Vec3::ZERO; self.vertex_count()];
        let dent = Dent::of_one_hit(self, &mark);
        dent.alone_on(self, self.base_lod()).into_iter().for_each(|(v, u)| field[v as usize] = u);
        Some(field)
    }

    /// The nodes as a mesh, with the set's examples on it.
    fn node_mesh(&self, nodes: &[u32], tasks: &dyn TaskSystem) -> Result<MeshLod, Error> {
        let base = self.mesh();
        let data = MeshData {
            positions: nodes.iter().map(|v| base.positions()[*v as usize].to_array()).collect(),
            normals: nodes.iter().map(|v| Some(base.outward_normal(*v)?.to_array())).collect(),
            ..MeshData::default()
        };
        let (mesh, _) = Mesh::new(data)?;
        let rim = self.rim().on(base, &mesh, tasks);
        let anchored = map(tasks, 0..self.examples().len(), |i| {
            let steps = self.base_lod().anchored[i].steps;
            let field = self.base_lod().field(i);
            let moved: Vec<Vec3> = nodes.iter().map(|v| field[*v as usize]).collect();
            Arc::new(DeltaBlocks::new(&moved, None, steps))
        });
        Ok(MeshLod::new(mesh, rim, anchored))
    }
}
