//! What the graphics backends share: the plan of a frame, the layout of its data, the placement of meshes on the device, and the
//! formats of vertices. The CPU decides which example moves which block and makes every matrix. The kernels beside this file
//! (`*.wgsl`) evaluate the vertices with the operations of [`crate::deform`], in the same order.

mod arena;
mod format;
mod kernel;
mod layout;
mod limits;
mod mesh;
mod plan;
mod target;
mod vertices;
mod work;

pub use crate::deform::Encoding;
pub(crate) use arena::Arena;
#[cfg(feature = "vulkan")]
pub(crate) use arena::ResidentMesh;
pub use format::Attribute;
#[cfg(feature = "wgpu")]
pub(crate) use kernel::Module;
pub(crate) use kernel::Variant;
#[cfg(feature = "vulkan")]
pub(crate) use kernel::{Case, compiled};
pub(crate) use layout::Call;
pub(crate) use limits::{BindingLimits, check_workgroup_size};
pub(crate) use plan::Plan;
pub use plan::{FrameReport, Job};
pub use target::Target;
pub(crate) use vertices::binding_range;
pub use vertices::{HostFormat, TargetDef, VertexStream};

use layout::BLOCK as BLOCK_VERTICES;
