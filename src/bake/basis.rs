//! Lets a set's vertices follow nodes: learns the basis from the set's examples, and from hits all over the body.

use crate::base::error::Error;
use crate::base::math::rotation_between;
use crate::base::tasks::{TaskSystem, map};
use crate::basis::Basis;
use crate::basis::learn::BasisOptions;
use crate::example::blocks::DeltaBlocks;
use crate::example::mesh_lod::MeshLod;
use crate::example::rule::LearnedRule;
use crate::example::set::{ExampleSet, deepest};
use crate::mesh::Mesh;
use crate::mesh::data::MeshData;
use crate::mesh::mirror::Images;
use glam::Vec3;
use std::hash::Hasher;
use std::sync::Arc;
use twox_hash::XxHash3_64;

/// Hits that the basis is learned from, besides the examples.
const HITS: usize = 64;
/// The most examples that it is learned from, evenly spread over the list.
const EXAMPLES: usize = 256;
/// The least depth of those hits, as a share of the deepest example.
const SHALLOW: f32 = 0.15;
/// How much narrower and wider than its example a hit may be.
const WIDTHS: (f32, f32) = (0.25, 4.0);

impl ExampleSet {
    /// Learns how the vertices follow nodes, and then the rule that predicts those.
    pub(super) fn learn(&mut self, tasks: &dyn TaskSystem) -> Result<(), Error> {
        // No nodes are added to those that are spread evenly, whatever the tolerance.
        let even = BasisOptions { rounds: 0, ..BasisOptions::new(1.0) };
        let options = self.options().basis.unwrap_or(even);
        // No example moves held vertices, and what is carried ends there.
        let images = Images { mesh: self.mesh(), index: self.index(), planes: self.report().mirror_planes };
        let (basis, report) = Basis::learn(&images, || self.fields(tasks), &self.rim().held, &options, tasks)?;
        let nodes = self.node_mesh(&basis.nodes, tasks)?;
        let rule = LearnedRule::learn(&self.rule_source(&nodes), tasks);
        let mut hash = XxHash3_64::new();
        hash.write(&self.fingerprint().to_le_bytes());
        hash.write(&rule.predictor.to_bytes()?);
        self.set_fingerprint(hash.finish());
        self.follow(nodes, vec![basis.rows], Some(report));
        self.set_rule(rule);
        Ok(())
    }

    /// The fields that the basis is learned from, m: examples, and round dents like them that fill the body and the depths evenly.
    fn fields(&self, tasks: &dyn TaskSystem) -> Vec<Vec<Vec3>> {
        let moving: Vec<usize> = (0..self.examples().len()).filter(|i| !self.examples()[*i].is_empty()).collect();
        let step = moving.len().div_ceil(EXAMPLES);
        let mut fields: Vec<Vec<Vec3>> = moving.iter().step_by(step).map(|i| self.base_lod().field(*i)).collect();
        fields.extend(map(tasks, 0..HITS, |i| self.thrown(i, &moving)));
        fields
    }

    /// A round dent as wide as an example leaves one, turned to where it lies: the `i`-th of a sequence.
    fn thrown(&self, i: usize, of: &[usize]) -> Vec<Vec3> {
        /// Multiples of them are spread evenly over 0 to 1 (Roberts' sequence in two dimensions).
        const STEPS: [f64; 2] = [0.754_877_666_246_692_7, 0.569_840_290_998_053_3];
        let at = |k: usize| (0.5 + STEPS[k] * (i + 1) as f64).fract();
        let contact = ((at(0) * self.vertex_count() as f64) as u32).min(self.vertex_count() as u32 - 1);
        let depth = deepest(self.examples()) * (SHALLOW + (1.0 - SHALLOW) * at(1) as f32);
        let e = &self.examples()[of[i * of.len().max(HITS) / HITS % of.len()]];
        let radius = e.support_radius() * (depth / e.max_depth()).sqrt().clamp(WIDTHS.0, WIDTHS.1);
        let facing = |v: u32| self.mesh().contact_normal(v).unwrap_or(Vec3::Z);
        let along = rotation_between(facing(e.contact_vertex()), facing(contact)) * e.contact_displacement();
        let (centre, most) = (self.mesh().positions()[contact as usize], along * (depth / e.depth()));
        let dent = |(v, p): (u32, &Vec3)| {
            // NaN where a point has no radius.
            let inside = (1.0 - p.distance_squared(centre) / (radius * radius)).max(0.0);
            most * (inside * inside * self.rim().at(v))
        };
        (0..).zip(self.mesh().positions()).map(dent).collect()
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
        let rim = self.rim().on(base, &mesh);
        let anchored = map(tasks, 0..self.examples().len(), |i| {
            let steps = self.base_lod().anchored[i].steps;
            let field = self.base_lod().field(i);
            let moved: Vec<Vec3> = nodes.iter().map(|v| field[*v as usize]).collect();
            Arc::new(DeltaBlocks::new(&moved, None, steps))
        });
        Ok(MeshLod::new(mesh, rim, anchored))
    }
}
