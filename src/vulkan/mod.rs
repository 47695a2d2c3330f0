//! Straight into the host's vertex buffers: deformation recorded into the host's own Vulkan command buffers.
//!
//! 1. [`Device::new`]: from the host's instance, device and loader. libvulkan is never opened here.
//! 2. [`Device::add_buffer`]: a VkBuffer of the host that vertices are written to, and who else uses it.
//! 3. [`Device::add_target`]: where in it one mesh's vertices lie, and in which formats.
//! 4. [`Device::record`], once a frame, into a command buffer outside a render pass: everything that changed since, of all
//!    targets. It records a copy, a barrier, a dispatch for each VkBuffer, a barrier; it submits nothing and waits for nothing.
//! 5. [`Device::completed`], when the host knows that the device is done with a frame: what the frame used is used again.
//!
//! Nothing beyond Vulkan 1.1 is needed: no feature, no extension. Vertices are what [`crate::deform`] writes, by bits where
//! the device rounds additions, multiplications, divisions and square roots as IEEE 754 says (lavapipe and SwiftShader do);
//! Vulkan allows divisions to be off by 2.5 units in the last place, and numbers below 1.2e-38 to count as 0.
//!
//! Instances with a classic rule have a state of 24 bytes a vertex on the device, for each target that shows one (12 where it
//! has positions alone), and a dispatch of their own. Hits are applied to it in order, as the CPU applies them to its own.
//!
//! A host that cannot hand out command buffers, or not in this process, shares memory instead: see [`OwnDevice`].
//!
//! # Frames
//! The host numbers its frames from 1 on. The command buffers of a frame are submitted once each, in the order of recording,
//! on one queue of the family that the device was made with (or with semaphores that order them so).
//!
//! # Threads
//! A [`Device`] may go from thread to thread; `&mut self` says what must not happen at once. The command buffer's pool is the
//! host's to synchronize.
//!
//! # Order of destruction
//! The host's VkBuffers outlive the frames that write them. Before the VkDevice is destroyed the [`Device`] is dropped, and
//! before that all its frames are done and told by [`Device::completed`]: what a frame in flight may use is leaked rather than
//! destroyed.

mod arena;
mod classic;
mod device;
mod frames;
mod functions;
mod host;
mod import;
mod memory;
mod own;
mod pipelines;
mod record;

pub use ash::vk;
pub use device::{Device, DeviceDef};
pub use host::{Access, BufferDef, BufferId, Stream, Target, TargetDef};
pub use import::{ImportDef, SemaphoreId, Shared};
pub use own::{OwnDevice, OwnDeviceDef};
pub use record::{RecordJob, RecordReport};

#[doc(hidden)]
pub use crate::gpu::{Attribute, Encoding, encode};
