//! What every backend keeps of a target.

use super::arena::ResidentMesh;
use super::kernel::{Case, Kernel, Variant};
use super::vertices::VertexLayout;
use crate::deform::Tracker;
use crate::example::set::ExampleSet;
use std::sync::{Arc, Weak};

/// The part of a target that is the same in every backend.
#[derive(Debug)]
pub(crate) struct TargetState {
    /// Id of the backend's device.
    pub device: u64,
    pub set: Weak<ExampleSet>,
    pub lod: usize,
    pub kernel: Kernel,
    pub layout: VertexLayout,
    /// Bytes from the start of the binding to the target, modulo 2^64: only what is written lies within the binding.
    pub first: u64,
    pub mesh: Arc<ResidentMesh>,
    pub tracker: Tracker,
}

impl TargetState {
    /// The variant that writes it.
    pub(crate) fn variant(&self, case: Case) -> Variant {
        Variant { kernel: self.kernel, case, packed: self.layout.packed() }
    }
}
