//! What the memory allows at best: copies of a buffer by the device.

use std::time::Duration;

use anyhow::{Result, ensure};

use super::buffer::Buffer;
use super::check::Agreement;
use super::engine::Gpu;

/// A copy within the device's memory.
pub struct Copy<'g> {
    gpu: &'g Gpu,
    words: Vec<u32>,
    from: Buffer<'g>,
    to: Buffer<'g>,
}

impl<'g> Copy<'g> {
    /// That reads and writes so many bytes together: a buffer of half of them.
    pub fn moving(gpu: &'g Gpu, bytes: f64) -> Result<Self> {
        Self::of(gpu, (bytes / 8.0).ceil() as usize)
    }

    /// Of so many words.
    pub fn of(gpu: &'g Gpu, words: usize) -> Result<Self> {
        let words: Vec<u32> = (0..words.max(1) as u32).map(|i| i.wrapping_mul(0x9E37_79B1)).collect();
        let (from, to) = (Buffer::filled(gpu, &words)?, gpu.local(4 * words.len() as u64)?);
        Ok(Copy { gpu, words, from, to })
    }

    pub fn run(&mut self) -> Duration {
        let copy = self.gpu.timed(|commands| self.gpu.copy(commands, &self.from, &self.to, self.from.size));
        copy.unwrap_or_else(|e| panic!("{e:#}"))
    }

    /// Holds the copy against what was to be copied.
    pub fn check(&self) -> Result<Agreement> {
        let (got, wanted) = (self.to.read()?, bytemuck::cast_slice::<u32, f32>(&self.words));
        let same = got.iter().zip(wanted).all(|(g, w)| g.to_bits() == w.to_bits());
        ensure!(same && got.len() == wanted.len(), "the copy on {} is no copy", self.gpu.name);
        Ok(Agreement::same(&got))
    }
}
