//! Lets a set's vertices follow nodes: learns the basis from the set's examples, and from hits all over the body.

use super::options::{InstanceOptions, Rule};
use super::selection::{Effect, select};
use crate::base::error::Error;
use crate::base::math::Aabb;
use crate::base::tasks::{TaskSystem, map};
use crate::basis::Basis;
use crate::basis::learn::{BasisOptions, BasisReport};
use crate::damage::changes::Changes;
use crate::damage::list::Damage;
use crate::deform::evaluate::{self, BlockJob, Scratch};
use crate::deform::view::DamageView;
use crate::example::blocks::DeltaBlocks;
use crate::example::mesh_lod::MeshLod;
use crate::example::rule::LearnedRule;
use crate::example::set::ExampleSet;
use crate::mesh::Mesh;
use crate::mesh::data::MeshData;
use crate::mesh::vertex_blocks::block_range;
use crate::select::hit::Hit;
use crate::select::target::HitParams;
use glam::{DMat3, DVec3, Vec3};
use std::hash::Hasher;
use std::sync::Arc;
use twox_hash::XxHash3_64;

/// Hits that the basis is learned from, besides the examples.
const HITS: usize = 64;
/// The most examples that it is learned from, evenly spread over the list.
const EXAMPLES: usize = 256;
/// The least depth of those hits, as a share of the depth limit.
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
    /// Lets the vertices of the base mesh follow *nodes*, a few of them, whose displacements alone are then computed from marks
    /// (docs/model.md, "Nodes"). A hit and a frame cost less, the more so the more examples and marks there
    /// are. Vertices are wrong by about the tolerance; the report says how much at worst. Marks, contacts and saved damage do not
    /// change. Levels of detail follow the same nodes: their vertices at positions of base vertices exactly like these.
    ///
    /// The basis is learned from the set's examples and from hits all over the body. Vertices that are neighbours in space should be
    /// neighbours in memory ([`reorder`](fn@crate::reorder)): 64 consecutive vertices follow the same nodes.
    ///
    /// Call it before instances are made. Instances with a classic rule do not follow nodes.
    ///
    /// # Errors
    /// [`Error::InvalidArgument`] naming the option; [`Error::OutOfMemory`]. After an error nothing has changed.
    pub fn learn_basis(&mut self, options: &BasisOptions, tasks: &dyn TaskSystem) -> Result<BasisReport, Error> {
        let unlimited = self.unlimited(tasks);
        let step = self.examples().len().div_ceil(EXAMPLES);
        let examples = (0..self.examples().len()).step_by(step).map(|i| self.base_lod().field(i));
        let thrown = map(tasks, 0..HITS, |i| self.thrown(&unlimited, i));
        let fields: Vec<Vec<Vec3>> = examples.chain(thrown.into_iter().flatten()).collect();
        let fields: Vec<&[Vec3]> = fields.iter().map(Vec::as_slice).collect();
        let (basis, report) = Basis::learn(self.mesh(), &fields, options, tasks)?;
        let nodes = self.node_mesh(basis.nodes(), tasks)?;
        let others = self.lods().skip(1).map(|lod| self.rows_by((&nodes, &basis.rows), lod, tasks));
        let rows = others.collect::<Vec<_>>();
        self.follow(nodes, std::iter::once(basis.rows).chain(rows).collect());
        Ok(report)
    }

    /// Lets the set predict hits from all of its examples at once, instead of mixing a few of them
    /// (docs/model.md, "The learned rule"). The more examples there are, the nearer it is to what they would show: more examples cost
    /// memory, and a hit or a frame hardly more. Marks then hold the hit itself, and have no pairs.
    ///
    /// Vertices must follow nodes ([`ExampleSet::learn_basis`]). The fingerprint changes, because saved damage looks different now. Call it
    /// before instances are made. Instances with a classic rule are not affected.
    ///
    /// With each example left out in turn, the set compares the rule with what the nearest examples say. Hits are predicted only where the
    /// rule is better, which the report tells: with few examples of a smooth body it often is not.
    ///
    /// # Errors
    /// [`Error::Unsupported`] if vertices do not follow nodes, or the mesh has no normals. After an error nothing has changed.
    pub fn learn_rule(&mut self, tasks: &dyn TaskSystem) -> Result<RuleReport, Error> {
        let needs = |what: &str| Error::Unsupported { what: format!("learning the rule {what}") };
        let Some(nodes) = self.nodes() else { return Err(needs("of a set without a basis: call learn_basis first")) };
        if self.mesh().normals().is_none() {
            return Err(needs("of a mesh without normals"));
        }
        let rule = LearnedRule::learn(&self.rule_source(&nodes.lod), tasks)?;
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

    /// The base mesh without limits of its vertices, which hold for what follows and not for nodes.
    fn unlimited(&self, tasks: &dyn TaskSystem) -> MeshLod {
        let mesh = self.mesh().clone().without_limits();
        let rim = self.rim().on(self.mesh(), &mesh, tasks);
        MeshLod::new(mesh, rim, self.base_lod().anchored.clone())
    }

    /// The displacements that a hit leaves, the `i`-th of a sequence that fills the body and the depths evenly. `None` if no example
    /// answers it.
    fn thrown(&self, mesh: &MeshLod, i: usize) -> Option<Vec<Vec3>> {
        /// Multiples of them are spread evenly over 0 to 1 (Roberts' sequence in two dimensions).
        const STEPS: [f64; 2] = [0.754_877_666_246_692_7, 0.569_840_290_998_053_3];
        let at = |k: usize| (0.5 + STEPS[k] * (i + 1) as f64).fract();
        let v = ((at(0) * self.vertex_count() as f64) as u32).min(self.vertex_count() as u32 - 1);
        let depth = self.depth_limit() * (SHALLOW + (1.0 - SHALLOW) * at(1) as f32);
        let normal = self.mesh().contact_normal(v)?;
        let hit = Hit::displacement(self.mesh().positions()[v as usize].to_array(), (normal * -depth).to_array());
        let options = InstanceOptions::default();
        let params = HitParams {
            selection: options.selection,
            examples_per_hit: options.examples_per_hit as usize,
            depth_limit: self.depth_limit(),
            yield_impulse: 0.0,
            yield_displacement: 0.0,
            compliance: None,
            max_distance: f32::MAX,
            world_to_local: DMat3::IDENTITY,
            local_origin_in_world: DVec3::ZERO,
            landing: None,
        };
        let (_, Effect::Mark(mark)) = select(self, Rule::Marks, &params, &hit).ok()? else { return None };
        let mut damage = Damage::default();
        damage.add(self, vec![mark], 1, &mut |_| ());
        let changes = Changes { instance: 0, epoch: 0, coarse: 1.0, follows: false, blocks: Vec::new() };
        let view = DamageView {
            set: self,
            damage: &damage,
            depth_limit: f32::MAX,
            threshold: 0.0,
            tolerance: 0.0,
            coarse: 1.0,
            changes: &changes,
            vertices: None,
            nodes: None,
        };
        let mut scratch = Scratch::new();
        let mut field = vec![Vec3::ZERO; self.vertex_count()];
        for block in 0..mesh.blocks() {
            let range = block_range(block, field.len());
            let to = &mut field[range.clone()];
            let job = BlockJob { view: &view, lod: mesh, block };
            evaluate::block(job, &mut scratch, None, bytemuck::cast_slice_mut(to), None, &mut Aabb::EMPTY.clone());
            to.iter_mut().zip(&mesh.mesh.positions()[range]).for_each(|(u, base)| *u -= *base);
        }
        Some(field)
    }

    /// The nodes as a mesh, with the set's examples on it.
    fn node_mesh(&self, nodes: &[u32], tasks: &dyn TaskSystem) -> Result<MeshLod, Error> {
        let base = self.mesh();
        let data = MeshData {
            positions: nodes.iter().map(|v| base.positions()[*v as usize].to_array()).collect(),
            normals: base.normals().map(|normals| nodes.iter().map(|v| normals[*v as usize].to_array()).collect()),
            ..MeshData::default()
        };
        let (mesh, _) = Mesh::new(data)?;
        let rim = self.rim().on(base, &mesh, tasks);
        let anchored = map(tasks, self.examples().iter().enumerate(), |(i, example)| {
            let field = self.base_lod().field(i);
            let moved: Vec<Vec3> = nodes.iter().map(|v| field[*v as usize]).collect();
            Arc::new(DeltaBlocks::new(&moved, None, example.anchored.steps))
        });
        Ok(MeshLod::new(mesh, rim, anchored))
    }
}
