//! The nearest base vertex to a contact point, through an R*-tree. Ties go to the lowest index.

use glam::Vec3;
use rstar::{RTree, primitives::GeomWithData};

/// The vertex nearest to a point.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Nearest {
    /// Its index; the lowest where several are equally near.
    pub vertex: u32,
    /// Its distance, m.
    pub distance: f32,
}

#[derive(Debug)]
pub(crate) struct VertexIndex(RTree<GeomWithData<[f32; 3], u32>>);

impl VertexIndex {
    /// Of vertices at one position only the lowest (`weld[v] == v`) is kept: it is the answer for all of them.
    pub(crate) fn new(positions: &[Vec3], weld: &[u32]) -> Self {
        let points = (0..positions.len() as u32)
            .filter(|v| weld[*v as usize] == *v)
            .map(|v| GeomWithData::new(positions[v as usize].to_array(), v))
            .collect();
        Self(RTree::bulk_load(points))
    }

    /// `None` only where the distance overflows f32.
    pub(crate) fn nearest(&self, point: Vec3, positions: &[Vec3]) -> Option<Nearest> {
        let vertex = self.0.nearest_neighbors(&point.to_array()).into_iter().map(|g| g.data).min()?;
        let distance = (positions[vertex as usize].as_dvec3() - point.as_dvec3()).length() as f32;
        distance.is_finite().then_some(Nearest { vertex, distance })
    }

    /// Up to four nearest vertices with their squared distances (m²), nearest first.
    pub(crate) fn four(&self, point: Vec3) -> impl Iterator<Item = (u32, f32)> + '_ {
        self.0.nearest_neighbor_iter_with_distance_2(point.to_array()).take(4).map(|(g, d)| (g.data, d))
    }
}
