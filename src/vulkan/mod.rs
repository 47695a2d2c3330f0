//! Deformation recorded into the host's own Vulkan command buffers, straight into its vertex buffers.
//!
//! 1. [`Device::new`] takes the host's instance, device and loader. It never opens libvulkan.
//! 2. [`Device::add_buffer`] registers a VkBuffer of the host, and who else uses it.
//! 3. [`Device::add_target`] says where in it the vertices of one mesh lie, and in which formats.
//! 4. [`Device::record`] records everything that changed, of all targets, into a command buffer outside a render pass. Call it
//!    once a frame. It records a copy, a barrier, a dispatch for each VkBuffer and a barrier. It submits nothing and does not wait.
//! 5. [`Device::completed`] reports that the device is done with a frame, so that its memory can be reused.
//!
//! It needs Vulkan 1.1, and no feature or extension. On devices that round additions, multiplications, divisions and square roots
//! as IEEE 754 says (lavapipe and SwiftShader do), the vertices have the bits of [`crate::deform`]. Vulkan allows a division to be
//! off by 2.5 units in the last place, a square root by 4.5, and numbers below 1.2e-38 to count as 0.
//!
//! A target of an instance with a classic rule has a state of 24 bytes a vertex on the device (12 if it has positions alone), and
//! a dispatch of its own. Hits are applied to the state in order, as the CPU applies them to its own.
//!
//! A host that cannot hand out command buffers, or runs in another process, shares memory instead: see [`OwnDevice`].
//!
//! # Frames
//! The host numbers its frames from 1 on. The command buffers of a frame are submitted once each, in the order of recording, on
//! one queue of the device's family, or on several queues with semaphores that keep this order.
//!
//! # Threads
//! A [`Device`] may move between threads. The host synchronizes the command buffer's pool.
//!
//! # Order of destruction
//! The host's VkBuffers outlive the frames that write them. The [`Device`] is dropped before the VkDevice is destroyed, and after
//! [`Device::completed`] was called for all frames. If a frame is in flight, everything that it may use is leaked.

mod device;
mod functions;
mod host_buffers;
mod import;
mod memory;
mod own;
mod own_handles;
mod pipelines;
mod record;
mod shared;
mod staging;
mod target;
mod vulkan_device;

pub use crate::gpu::{FrameReport, Job, Target as AnyTarget};
pub use ash::vk;
pub use device::Device;
pub use host_buffers::{Access, BufferDef, BufferId};
pub use import::ImportDef;
pub use own::{OwnDevice, OwnDeviceDef};
pub use shared::{SemaphoreId, Shared};
pub use target::{Stream, Target, TargetDef};
pub use vulkan_device::DeviceDef;

#[doc(hidden)]
pub use crate::gpu::{Attribute, Encoding};
#[doc(hidden)]
pub use pipelines::kernels;
