//! Every rule of the library again: naive, in f64, one vertex at a time, written from the paper and the design rather than from the code.
//! What it takes from the library is data only: the examples' displacements as stored, the stamps' grid values, and documented constants.
#![allow(dead_code)]

pub mod classic;
pub mod damage;
pub mod marks;
pub mod select;
pub mod vector;

use crumple::{ExampleSet, Placement};
use marks::Grid;
use vector::{V, from_f32, length, sub};

/// One example, in f64.
#[derive(Debug, Clone)]
pub struct Example {
    pub contact_vertex: usize,
    pub contact_point: V,
    pub contact_normal: V,
    pub placement: Placement,
    pub support_radius: f64,
    /// One displacement a vertex, m.
    pub deltas: Vec<V>,
    /// One change of the unit normal a vertex.
    pub normal_deltas: Vec<V>,
    pub grid: Option<Grid>,
}

impl Example {
    /// Length of the displacement at the contact vertex, m.
    pub fn depth(&self) -> f64 {
        length(self.deltas[self.contact_vertex])
    }
}

/// The body and its examples, in f64.
#[derive(Debug, Clone)]
pub struct Model {
    pub positions: Vec<V>,
    pub normals: Vec<V>,
    /// Normals of contacts: smooth across hard edges.
    pub contact_normals: Vec<V>,
    pub diagonal: f64,
    pub strict: bool,
    pub examples: Vec<Example>,
}

impl Model {
    pub fn of(set: &ExampleSet) -> Self {
        let mesh = set.mesh();
        let count = set.vertex_count();
        Self {
            positions: mesh.positions().iter().map(|p| from_f32(p.to_array())).collect(),
            normals: match mesh.normals() {
                Some(n) => n.iter().map(|n| from_f32(n.to_array())).collect(),
                None => vec![[0.0; 3]; count],
            },
            contact_normals: (0..count as u32)
                .map(|v| mesh.contact_normal(v).map_or([0.0; 3], |n| from_f32(n.to_array())))
                .collect(),
            diagonal: f64::from(mesh.bounds().diagonal()),
            strict: set.options().strict,
            examples: set
                .examples()
                .iter()
                .map(|e| Example {
                    contact_vertex: e.contact_vertex() as usize,
                    contact_point: from_f32(e.contact_point().to_array()),
                    contact_normal: e.contact_normal().map_or([0.0; 3], |n| from_f32(n.to_array())),
                    placement: e.placement(),
                    support_radius: f64::from(e.support_radius()),
                    normal_deltas: (0..count as u32).map(|v| from_f32(e.normal_delta(v).to_array())).collect(),
                    grid: e.stamp().map(|s| Grid::of(s, e.frame())),
                    deltas: (0..count as u32).map(|v| from_f32(e.delta(v).to_array())).collect(),
                })
                .collect(),
        }
    }

    /// The nearest base vertex and its distance; the lowest index where several are equally near.
    pub fn nearest(&self, point: V) -> (usize, f64) {
        let mut best = (0, f64::INFINITY);
        for (v, p) in self.positions.iter().enumerate() {
            let distance = length(sub(*p, point));
            if distance < best.1 {
                best = (v, distance);
            }
        }
        best
    }
}
