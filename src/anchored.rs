//! An example where the artist made it: displacements of the vertices it moves, found by block.
//!
//! Everything else sees this storage through [`Anchored::add`], [`Anchored::delta`] and [`Anchored::blocks`].

use glam::Vec3;
use std::ops::Range;

/// Vertices a block. Vertices keep the engine's order and are cut every `BLOCK`.
pub(crate) const BLOCK: usize = 128;

/// The vertices of block `b` in a mesh of `n`.
pub(crate) fn block_range(b: usize, n: usize) -> Range<usize> {
    b * BLOCK..((b + 1) * BLOCK).min(n)
}

#[derive(Debug, Clone, Default)]
pub(crate) struct Anchored {
    /// Vertices whose position or normal changes, increasing.
    indices: Vec<u32>,
    /// Displacement of each, m.
    deltas: Vec<Vec3>,
    /// Change of the unit normal of each; empty where the mesh has no normals.
    normals: Vec<Vec3>,
    /// Block and its range in the arrays, increasing.
    blocks: Vec<(u32, Range<u32>)>,
}

impl Anchored {
    /// From one displacement (and normal change) a vertex; vertices where both are zero are not stored.
    pub(crate) fn new(deltas: &[Vec3], normals: Option<&[Vec3]>) -> Self {
        let mut a = Anchored::default();
        for (v, d) in deltas.iter().enumerate() {
            let n = normals.map_or(Vec3::ZERO, |n| n[v]);
            if *d == Vec3::ZERO && n == Vec3::ZERO {
                continue;
            }
            let (at, block) = (a.indices.len() as u32, (v / BLOCK) as u32);
            match a.blocks.last_mut() {
                Some((b, r)) if *b == block => r.end = at + 1,
                _ => a.blocks.push((block, at..at + 1)),
            }
            a.indices.push(v as u32);
            a.deltas.push(*d);
            if normals.is_some() {
                a.normals.push(n);
            }
        }
        a
    }

    /// The blocks it touches, increasing.
    pub(crate) fn blocks(&self) -> impl Iterator<Item = u32> + '_ {
        self.blocks.iter().map(|(b, _)| *b)
    }

    /// Whether it touches block `b`.
    pub(crate) fn touches(&self, b: u32) -> bool {
        self.blocks.binary_search_by_key(&b, |(b, _)| *b).is_ok()
    }

    /// Adds `scale` times the displacements of the vertices in `r` (all of one block) to `u`, and of the normal changes to
    /// `n` (both indexed from `r.start`; `n` may be empty).
    pub(crate) fn add(&self, r: Range<usize>, scale: f32, u: &mut [Vec3], n: &mut [Vec3]) {
        let block = (r.start / BLOCK) as u32;
        let Ok(at) = self.blocks.binary_search_by_key(&block, |(b, _)| *b) else { return };
        let stored = self.blocks[at].1.start as usize..self.blocks[at].1.end as usize;
        let indices = &self.indices[stored.clone()];
        let from = stored.start + indices.partition_point(|v| (*v as usize) < r.start);
        let to = stored.start + indices.partition_point(|v| (*v as usize) < r.end);
        for (v, d) in self.indices[from..to].iter().zip(&self.deltas[from..to]) {
            u[*v as usize - r.start] += *d * scale;
        }
        if !n.is_empty() && !self.normals.is_empty() {
            for (v, d) in self.indices[from..to].iter().zip(&self.normals[from..to]) {
                n[*v as usize - r.start] += *d * scale;
            }
        }
    }

    /// Displacement of vertex `v`, m.
    pub(crate) fn delta(&self, v: u32) -> Vec3 {
        self.indices.binary_search(&v).map_or(Vec3::ZERO, |i| self.deltas[i])
    }

    /// Change of the unit normal of vertex `v`.
    pub(crate) fn normal_delta(&self, v: u32) -> Vec3 {
        self.indices.binary_search(&v).map_or(Vec3::ZERO, |i| self.normals.get(i).copied().unwrap_or(Vec3::ZERO))
    }

    /// Vertex, displacement and normal change of everything stored.
    pub(crate) fn iter(&self) -> impl Iterator<Item = (u32, Vec3, Vec3)> + '_ {
        self.indices
            .iter()
            .enumerate()
            .map(|(i, v)| (*v, self.deltas[i], self.normals.get(i).copied().unwrap_or(Vec3::ZERO)))
    }

    pub(crate) fn bytes(&self) -> usize {
        self.indices.len() * 4 + (self.deltas.len() + self.normals.len()) * 12 + self.blocks.len() * 12
    }
}
