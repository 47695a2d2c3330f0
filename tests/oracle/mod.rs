//! A second implementation of every rule of the library: naive, in f64, one vertex at a time, written from the paper
//! and the design and not from the code. It takes only data from the library: stored displacements, grid values of
//! stamps, and documented constants.
#![allow(dead_code)]

pub mod body;
pub mod classic;
pub mod damage;
pub mod kriging;
pub mod learn;
pub mod marks;
pub mod response;
pub mod select;
pub mod vector;

use crumple::{ExampleSet, Placement};
use marks::Chart;
use vector::{V, from_f32, length, sub};

/// One example, in f64.
#[derive(Debug, Clone)]
pub struct Example {
    pub contact_vertex: usize,
    pub contact_point: V,
    pub contact_normal: V,
    pub placement: Placement,
    /// Whether the set learned that the example stays in place for hits around it.
    pub stays: bool,
    pub support_radius: f64,
    /// One displacement per vertex, m.
    pub deltas: Vec<V>,
    pub grid: Option<Chart>,
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
    /// Normals at contacts; they are smooth across hard edges.
    pub contact_normals: Vec<V>,
    pub diagonal: f64,
    /// The point where the mirror planes meet, and the planes that exist: bit 0 for x, 1 for y, 2 for z.
    pub centre: V,
    pub planes: u8,
    /// Vertices on held rims (every copy at a seam), and the factor of each vertex towards them.
    pub held: Vec<usize>,
    pub windows: Vec<f64>,
    pub depth_limit: f64,
    /// Learned width of the place axes, as a share of the diagonal.
    pub place_width: f64,
    pub examples: Vec<Example>,
    pub response: Option<response::Response>,
    /// Whether rounding decides something about the body: whether a rim is held, or which images coincide.
    pub close: bool,
    pub images: Vec<select::Image>,
}

impl Model {
    pub fn of(set: &ExampleSet) -> Self {
        let mesh = set.mesh();
        let count = set.vertex_count();
        let positions: Vec<V> = mesh.positions().iter().map(|p| from_f32(p.to_array())).collect();
        let examples: Vec<Example> = set
            .examples()
            .iter()
            .enumerate()
            .map(|(i, e)| Example {
                contact_vertex: e.contact_vertex() as usize,
                contact_point: from_f32(e.contact_point().to_array()),
                contact_normal: e.contact_normal().map_or([0.0; 3], |n| from_f32(n.to_array())),
                placement: e.placement(),
                stays: set.learned().anchored[i],
                support_radius: f64::from(e.support_radius()),
                grid: e.stamp().map(|s| Chart::of(s, e.frame())),
                deltas: (0..count as u32).map(|v| from_f32(e.delta(v).to_array())).collect(),
            })
            .collect();
        let (planes, centre, diagonal) = body::mirror_planes(&positions);
        let mut close = false;
        let fields: Vec<&[V]> = examples.iter().map(|e| e.deltas.as_slice()).collect();
        let held = if set.options().held_rims {
            body::held_vertices(&positions, mesh.triangles(), &fields, &mut close)
        } else {
            Vec::new()
        };
        let windows = positions.iter().map(|p| body::window(*p, &positions, &held, diagonal)).collect();
        let mut model = Self {
            positions,
            normals: match mesh.normals() {
                Some(n) => n.iter().map(|n| from_f32(n.to_array())).collect(),
                None => vec![[0.0; 3]; count],
            },
            contact_normals: (0..count as u32)
                .map(|v| mesh.contact_normal(v).map_or([0.0; 3], |n| from_f32(n.to_array())))
                .collect(),
            diagonal,
            centre,
            planes: if set.options().mirror { planes } else { 0 },
            held,
            windows,
            depth_limit: f64::from(set.depth_limit()),
            place_width: f64::from(set.learned().place_width),
            examples,
            response: None,
            close,
            images: Vec::new(),
        };
        let blows: Vec<_> = set.examples().iter().map(|e| response::Known::of(e.blow())).collect();
        model.response = response::Response::learn(&model, &blows);
        model.images = select::images(&model, &mut close);
        model.close |= close;
        model
    }

    /// The nearest base vertex and its distance; among equally near vertices the lowest index.
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
