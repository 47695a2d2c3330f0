//! Which kernel writes a target, and what every backend keeps of a target.

use super::arena::ResidentMesh;
use super::vertices::VertexLayout;
use crate::mesh::Mesh;
use crate::{Error, ExampleSet, Tracker};
use std::sync::{Arc, Weak};

/// The attributes that a kernel writes. Each kernel writes those of the kernels before it too.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) enum Kernel {
    Positions,
    Normals,
    Tangents,
}

impl Kernel {
    /// The kernel for a layout.
    ///
    /// # Errors
    /// [`Error::Unsupported`] if the mesh lacks an attribute.
    pub(crate) fn of(layout: &VertexLayout, mesh: &Mesh) -> Result<Self, Error> {
        let kernel = match (layout.normals, layout.tangents) {
            (_, Some(_)) => Kernel::Tangents,
            (Some(_), None) => Kernel::Normals,
            (None, None) => Kernel::Positions,
        };
        if kernel > Kernel::Positions && mesh.normals().is_none() {
            let what = "a normal or tangent output: the mesh has neither normals nor triangles to compute them from";
            return Err(Error::Unsupported { what: what.into() });
        }
        if kernel == Kernel::Tangents && mesh.tangents().is_none() {
            return Err(Error::Unsupported { what: "a tangent output: the mesh has no tangents".into() });
        }
        Ok(kernel)
    }

    /// Index among all kernels: three for marks, then three for the classic rules.
    pub(crate) fn number(self, classic: bool) -> usize {
        self as usize + if classic { 3 } else { 0 }
    }

    /// Bytes a vertex of a classic rule's state.
    pub(crate) fn state_bytes(self) -> u64 {
        if self > Kernel::Positions { 24 } else { 12 }
    }
}

/// What every backend keeps of a target.
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
