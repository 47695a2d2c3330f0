//! A target: the place of a mesh's vertices in a buffer of the host's render graph.

use crate::base::math::Aabb;
use crate::gpu::{self, PlanTarget, TargetState, VertexStream};
use ash::vk::Format;
use std::ops::Range;

/// A vertex buffer of the host's render graph.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct GraphBuffer {
    /// The host's number for it.
    pub number: u64,
    /// Its size in bytes.
    pub size: u64,
}

/// Where a buffer stores the vertices of one mesh.
pub type TargetDef = gpu::TargetDef<GraphBuffer, Format>;

/// Where a buffer stores one attribute of the vertices.
pub type Stream = VertexStream<Format>;

/// A mesh's vertices in a buffer, and what they show. Drop it to end it.
#[derive(Debug)]
pub struct Target {
    pub(super) state: TargetState,
    /// The host's number of the buffer.
    pub(super) buffer: u64,
}

impl Target {
    /// Forgets what the memory holds, so that the next plan writes every vertex. Call it if anyone else wrote to the memory,
    /// or if a dispatch was not executed.
    pub fn invalidate(&mut self) {
        self.state.tracker.invalidate();
    }

    /// A box around all vertices as of the last plan, m; `None` before the first. It may be too large, never too small.
    pub fn bounds(&self) -> Option<Aabb> {
        self.state.tracker.bounds()
    }

    /// Vertices that the last plan wrote, as increasing ranges with gaps between them.
    pub fn changed(&self) -> &[Range<u32>] {
        self.state.tracker.changed()
    }
}

impl PlanTarget for Target {
    type Binding = u64;

    fn binding(&self) -> u64 {
        self.buffer
    }

    fn state(&self) -> &TargetState {
        &self.state
    }

    fn state_mut(&mut self) -> &mut TargetState {
        &mut self.state
    }
}
