//! The rule that predicts a hit from all examples of a set at once, as displacements of the set's nodes.

use crate::base::error::Error;
use crate::base::tasks::TaskSystem;
use crate::basis::field::NodeField;
use crate::mesh::mirror::Mirror;
use crate::predict::{Blow, Body, Fields, Hit, Prediction, Predictor, Sample, Scratch, Strike};
use glam::Vec3;
use std::collections::VecDeque;
use std::sync::{Arc, Mutex};

use super::blocks::DeltaBlocks;
use super::blow;
use super::example::Example;
use super::mesh_lod::MeshLod;

/// Predictions that are kept, since a hit is predicted when it is submitted and again when it is folded.
const RECENT: usize = 64;

/// What tells two predictions apart: the contact, and the hit's numbers as a mark stores them.
pub(crate) type Key = [u32; 6];

/// A learned rule, and its latest predictions.
#[derive(Debug)]
pub(crate) struct LearnedRule {
    pub predictor: Predictor,
    /// What the examples that move any node move the nodes by.
    fields: Vec<Arc<DeltaBlocks>>,
    recent: Mutex<Recent>,
}

impl Fields for Vec<Arc<DeltaBlocks>> {
    fn moved(&self, sample: usize, f: &mut dyn FnMut(usize, Vec3)) {
        self[sample].iter().for_each(|(node, u, _)| f(node as usize, u));
    }
}

/// What a hit alone is predicted to leave.
#[derive(Debug, Clone)]
pub(crate) struct Predicted {
    pub field: Arc<NodeField>,
    /// Relative L2; 1 is the error of no dent at all.
    pub expected_error: f32,
    /// Displacement of the contact if no rim were held, m.
    pub depth: f32,
}

#[derive(Debug, Default)]
struct Recent {
    predictions: VecDeque<(Key, Predicted)>,
    /// Memory of predictions: each takes a piece.
    scratch: Vec<Scratch>,
}

/// What a rule is learned from.
#[derive(Clone, Copy)]
pub(crate) struct Source<'a> {
    /// The base mesh, with the examples on it.
    pub base: &'a MeshLod,
    /// The planes in which the body is symmetric.
    pub mirror: Mirror,
    pub examples: &'a [Example],
    /// The nodes as a mesh, with the examples on it.
    pub nodes: &'a MeshLod,
}

impl Source<'_> {
    /// What the examples that move any node move the nodes by.
    fn fields(&self) -> Vec<Arc<DeltaBlocks>> {
        self.nodes.anchored.iter().filter(|moves| !moves.is_empty()).cloned().collect()
    }

    /// The nodes as the points of a body, and what they take of carried dents.
    fn body(&self) -> Body {
        let nodes = self.nodes;
        let count = nodes.vertex_count();
        let normals = nodes.mesh.normals().map_or_else(|| vec![Vec3::ZERO; count], <[Vec3]>::to_vec);
        let held = if nodes.rim.is_open() { Vec::new() } else { (0..count as u32).map(|v| nodes.rim.at(v)).collect() };
        Body::new(nodes.mesh.positions(), &normals, &held, self.mirror, self.base.mesh.bounds().centre())
    }
}

impl LearnedRule {
    /// Learns from the examples as they are on the nodes.
    pub(crate) fn learn(source: &Source<'_>, tasks: &dyn TaskSystem) -> Self {
        let (body, examples, nodes) = (source.body(), source.examples, source.nodes);
        let fields: Vec<Vec<Vec3>> = (0..examples.len()).map(|i| nodes.field(i)).collect();
        let samples: Vec<Sample<'_>> = examples
            .iter()
            .zip(&fields)
            .zip(sources(source))
            .zip(&nodes.anchored)
            .filter(|(_, moves)| !moves.is_empty())
            .map(|(((e, field), simulation), _)| Sample {
                contact: e.contact_point(),
                // Not the one that was given with it: hits have the mesh's.
                normal: source
                    .base
                    .mesh
                    .contact_normal(e.contact_vertex())
                    .unwrap_or(-e.contact_displacement() / e.depth()),
                blow: Some(known_blow(e.blow())).filter(|b| b.velocity.or(b.impulse).is_some()),
                field,
                moved: e.contact_displacement(),
                source: simulation,
            })
            .collect();
        let predictor = Predictor::learn(body, &samples, tasks);
        LearnedRule { predictor, fields: source.fields(), recent: Mutex::default() }
    }

    /// The rule of a set from [`Predictor::to_bytes`], as section rule of a file has them.
    ///
    /// # Errors
    /// [`Error::Format`].
    pub(crate) fn from_bytes(source: &Source<'_>, bytes: &[u8]) -> Result<Self, Error> {
        let predictor = Predictor::from_bytes(source.body(), bytes)?;
        let fields = source.fields();
        let samples = predictor.samples();
        if samples != fields.len() {
            let what = format!(
                "baked set: the examples of section rule are {samples}; they must be {}, those that move anything",
                fields.len()
            );
            return Err(Error::Format { what });
        }
        Ok(LearnedRule { predictor, fields, recent: Mutex::default() })
    }

    /// What is known of a blow on a surface with this unit normal. `None` if it points out of the body.
    pub(crate) fn strike(&self, blow: &blow::Blow, normal: Vec3) -> Option<Strike> {
        self.predictor.strike(&known_blow(blow), normal)
    }

    /// Predicts the displacements of the nodes by a hit alone. `key` must tell all hits apart.
    pub(crate) fn predict(&self, key: Key, hit: &Hit) -> Predicted {
        let mut scratch = {
            let mut recent = self.recent.lock().unwrap_or_else(|e| e.into_inner());
            if let Some((_, known)) = recent.predictions.iter().find(|(k, _)| *k == key) {
                return known.clone();
            }
            recent.scratch.pop().unwrap_or_default()
        };
        let (Prediction { expected_error, depth, .. }, moved) = self.predictor.predict(hit, &self.fields, &mut scratch);
        // Of a file's numbers, which may be anything finite, may follow what is not: then nothing moves.
        let predicted = Predicted { field: Arc::new(NodeField::of(moved)), expected_error, depth };
        let mut recent = self.recent.lock().unwrap_or_else(|e| e.into_inner());
        recent.scratch.push(scratch);
        recent.predictions.truncate(RECENT - 1);
        recent.predictions.push_front((key, predicted.clone()));
        predicted
    }

    /// Memory used, bytes.
    pub(crate) fn bytes(&self) -> usize {
        let recent = self.recent.lock().unwrap_or_else(|e| e.into_inner());
        let fields: usize = recent.predictions.iter().map(|(_, predicted)| predicted.field.bytes()).sum();
        self.predictor.bytes() + fields
    }
}

/// For each example the first of its simulation: images of one dent have the same depth, the same L2 and L4 norms, and the same distance from
/// the body's centre.
fn sources(source: &Source<'_>) -> Vec<u32> {
    /// Relative difference.
    const SAME: f64 = 1e-3;
    let bounds = source.base.mesh.bounds();
    let (centre, diagonal) = (bounds.centre(), bounds.diagonal());
    let dent = |(i, e): (usize, &Example)| {
        // Nodes need not lie alike around all images.
        let field = source.base.field(i);
        let squares = || field.iter().map(|u| f64::from(u.length_squared()));
        let norms = [squares().sum::<f64>().sqrt(), squares().map(|s| s * s).sum::<f64>().sqrt().sqrt()];
        let away = f64::from(e.contact_point().distance(centre) / diagonal);
        ([e.depth().into(), norms[0], norms[1]], away)
    };
    let dents: Vec<([f64; 3], f64)> = source.examples.iter().enumerate().map(dent).collect();
    let same = |(a, far): ([f64; 3], f64), (b, other): ([f64; 3], f64)| {
        a.iter().zip(b).all(|(a, b)| (a - b).abs() <= SAME * a) && (far - other).abs() <= SAME
    };
    (0..dents.len()).map(|i| (0..i).find(|j| same(dents[i], dents[*j])).unwrap_or(i) as u32).collect()
}

fn known_blow(blow: &blow::Blow) -> Blow {
    Blow {
        velocity: blow.striker.velocity.map(Vec3::from),
        impulse: blow.impulse.map(Vec3::from),
        mass: blow.striker.mass,
        radius: blow.striker.radius,
        kind: Some(u32::from(blow.striker.shape as u8)).filter(|kind| *kind > 0),
    }
}
