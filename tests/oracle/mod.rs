//! A second implementation of the library's rules: naive, in f64, one vertex at a time, written from the paper and the design and not from
//! the code. It takes only data from the library: stored displacements, what one hit alone leaves, and documented constants.
#![allow(dead_code)]

pub mod body;
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
    /// The mirror planes that exist: bit 0 for x, 1 for y, 2 for z.
    pub planes: u8,
    /// Vertices on held rims (every copy at a seam).
    pub held: Vec<usize>,
    pub depth_limit: f64,
    pub examples: Vec<Example>,
    /// Whether rounding decides whether a rim is held.
    pub close: bool,
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
        let mut close = false;
        let fields: Vec<&[DVec3]> = examples.iter().map(|e| e.deltas.as_slice()).collect();
        let held = if set.options().held_rims {
            body::held_vertices(&positions, mesh.triangles(), &fields, &mut close)
        } else {
            Vec::new()
        };
        let planes = if set.options().mirror { body::mirror_planes(&positions) } else { 0 };
        Self { positions, planes, held, depth_limit: f64::from(set.depth_limit()), examples, close }
    }
}
