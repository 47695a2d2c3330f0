//! A second implementation of the library's rules: naive, in f64, one vertex at a time, written from the paper and the design and not from
//! the code. It takes only data from the library: stored displacements, what one hit alone leaves, and documented constants.
#![allow(dead_code)]

pub mod classic;
pub mod damage;
pub mod marks;

use crumple::ExampleSet;
use crumple::glam::DVec3;

/// One example, in f64.
#[derive(Debug, Clone)]
pub struct Example {
    pub contact_vertex: usize,
    /// One displacement per vertex, m.
    pub deltas: Vec<DVec3>,
}

/// The body and its examples, in f64.
#[derive(Debug, Clone)]
pub struct Model {
    pub positions: Vec<DVec3>,
    pub depth_limit: f64,
    pub examples: Vec<Example>,
}

impl Model {
    pub fn of(set: &ExampleSet) -> Self {
        let mesh = set.mesh();
        let positions: Vec<DVec3> = mesh.positions().iter().map(|p| p.as_dvec3()).collect();
        let deltas = |e: &crumple::Example| (0..positions.len() as u32).map(|v| e.delta(v).as_dvec3()).collect();
        let examples: Vec<Example> = set
            .examples()
            .iter()
            .map(|e| Example { contact_vertex: e.contact_vertex() as usize, deltas: deltas(e) })
            .collect();
        Self { positions, depth_limit: f64::from(set.depth_limit()), examples }
    }
}
