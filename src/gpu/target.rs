//! A target: the place of a mesh's vertices in a buffer of the host, and what they show.

use super::arena::ResidentMesh;
use super::vertices::VertexLayout;
use crate::base::math::Aabb;
use crate::deform::Tracker;
use std::ops::Range;
use std::sync::Arc;

/// A mesh's vertices in a buffer, and what they show. Drop it to end it.
#[derive(Debug)]
pub struct Target<B, S, X = ()> {
    pub(crate) state: TargetState,
    /// The part of the host's buffer that a dispatch binds. Targets with equal bindings share dispatches.
    pub(crate) binding: B,
    /// States of the vertices on the device, for an instance with a classic rule.
    pub(crate) classic: Option<S>,
    /// What else the backend keeps of it.
    #[cfg_attr(not(feature = "wgpu"), allow(dead_code))]
    pub(crate) own: X,
}

/// The part of a target that is of one type in every backend.
#[derive(Debug)]
pub(crate) struct TargetState {
    /// Id of the plan of its device.
    pub device: u64,
    pub layout: VertexLayout,
    /// Bytes from the start of the binding to the target, modulo 2^64: only what is written lies within the binding.
    pub first: u64,
    pub mesh: Arc<ResidentMesh>,
    pub tracker: Tracker,
    /// The last frame that writes it, on backends that number frames.
    pub written_in: u64,
}

impl<B, S, X> Target<B, S, X> {
    /// A target of the device whose plan has this id. It begins `first` bytes after its binding.
    pub(crate) fn new(
        device: u64,
        (layout, first): (VertexLayout, u64),
        mesh: Arc<ResidentMesh>,
        (binding, own): (B, X),
    ) -> Self {
        let state = TargetState { device, layout, first, mesh, tracker: Tracker::new(), written_in: 0 };
        Target { state, binding, classic: None, own }
    }

    /// Forgets what the memory holds, so that the next recording, encoding or plan writes every vertex. Call it if anyone else wrote
    /// to the memory, or if what was recorded, encoded or planned was not executed.
    pub fn invalidate(&mut self) {
        self.state.tracker.invalidate();
    }

    /// A box around all vertices as of the last recording, encoding or plan, m; `None` before the first. It may be too large, since the
    /// CPU only knows how far each block can have moved, but never too small.
    pub fn bounds(&self) -> Option<Aabb> {
        self.state.tracker.bounds()
    }

    /// Vertices that the last recording, encoding or plan wrote, as increasing ranges with gaps between them.
    pub fn changed(&self) -> &[Range<u32>] {
        self.state.tracker.changed()
    }
}
