//! A vector for each vertex that is zero in most blocks. What reads it skips those blocks, so small examples on a large
//! mesh stay cheap.

use super::vertex_blocks::{BLOCK, block_range};
use crate::base::error::Error;
use bytemuck::Zeroable;
use glam::Vec3;
use std::ops::Deref;

/// `n` zeros, whose memory the system provides only where it is written. An error calls it `what`.
pub(crate) fn zeros<T: Zeroable>(n: usize, what: &str) -> Result<Vec<T>, Error> {
    bytemuck::allocation::try_zeroed_vec(n)
        .map_err(|()| Error::OutOfMemory { what: what.into(), bytes: (n as u64).saturating_mul(size_of::<T>() as u64) })
}

/// One vector per vertex.
#[derive(Debug, Clone)]
pub(crate) struct Field {
    values: Vec<Vec3>,
    /// The blocks that may have values other than zero, increasing.
    blocks: Vec<u32>,
}

impl Field {
    /// A field of `n` zeros.
    pub(crate) fn zero(n: usize, what: &str) -> Result<Self, Error> {
        Ok(Field { values: zeros(n, what)?, blocks: Vec::new() })
    }

    /// Sets values at vertices in any order.
    pub(crate) fn set(&mut self, values: impl IntoIterator<Item = (usize, Vec3)>) {
        for (v, value) in values {
            self.values[v] = value;
            let block = (v / BLOCK) as u32;
            if self.blocks.last() != Some(&block) {
                self.blocks.push(block);
            }
        }
        if !self.blocks.is_sorted_by(|a, b| a < b) {
            self.blocks.sort_unstable();
            self.blocks.dedup();
        }
    }

    /// Drops blocks that have only zeros.
    pub(crate) fn prune(&mut self) {
        let Field { values, blocks } = self;
        blocks.retain(|b| values[block_range(*b as usize, values.len())].iter().any(|v| *v != Vec3::ZERO));
    }

    /// The blocks that may have values other than zero, increasing.
    pub(crate) fn blocks(&self) -> &[u32] {
        &self.blocks
    }

    /// The vertices of [`Field::blocks`], increasing.
    pub(crate) fn vertices(&self) -> impl Iterator<Item = usize> + Clone + '_ {
        self.blocks.iter().flat_map(|b| block_range(*b as usize, self.values.len()))
    }

    /// Vertices and their values where they are not zero, increasing.
    pub(crate) fn moved(&self) -> impl Iterator<Item = (usize, Vec3)> + Clone + '_ {
        self.vertices().map(|v| (v, self.values[v])).filter(|(_, value)| *value != Vec3::ZERO)
    }

    /// Applies `f`, which must keep zero, to each value.
    pub(crate) fn map(&self, what: &str, f: impl Fn(Vec3) -> Vec3) -> Result<Self, Error> {
        let mut mapped = Field { values: zeros(self.values.len(), what)?, blocks: self.blocks.clone() };
        self.vertices().for_each(|v| mapped.values[v] = f(self.values[v]));
        Ok(mapped)
    }

    /// Length of the longest vector.
    pub(crate) fn longest(&self) -> f32 {
        self.vertices().map(|v| self.values[v].length()).fold(0.0, f32::max)
    }
}

impl Deref for Field {
    type Target = [Vec3];

    fn deref(&self) -> &[Vec3] {
        &self.values
    }
}
