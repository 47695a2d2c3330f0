//! A device of Crumple's own, for hosts that share memory instead of a command buffer. It imports memory that the host's device
//! exported, writes it, and synchronizes through semaphores or a fence.

use super::device::Device;
use super::functions::failed;
use super::host_buffers::BufferId;
use super::own_handles::{OwnHandles, OwnInstance};
use super::shared::{ImportedBuffer, SemaphoreId};
use super::target::Target;
use super::vulkan_device::DeviceDef;
use crate::base::error::Error;
use crate::gpu::{FrameReport, Job};
use ash::vk;
use std::fmt;
use std::sync::Arc;

/// The definition of a device of Crumple's own.
#[derive(Debug, Clone)]
pub struct OwnDeviceDef<'a> {
    /// The loader's `vkGetInstanceProcAddr`. All functions are taken from it.
    pub get_instance_proc_addr: vk::PFN_vkGetInstanceProcAddr,
    /// `deviceUUID` of the host's physical device (`VkPhysicalDeviceIDProperties`). Memory can only be shared on one physical
    /// device. `None` takes the first device that supports compute.
    pub device_uuid: Option<[u8; vk::UUID_SIZE]>,
    /// As [`DeviceDef::pipeline_cache`].
    pub pipeline_cache: &'a [u8],
    /// As [`DeviceDef::workgroup_size`].
    pub workgroup_size: u32,
}

impl<'a> OwnDeviceDef<'a> {
    /// A definition of any device, with the defaults.
    pub fn new(get_instance_proc_addr: vk::PFN_vkGetInstanceProcAddr) -> Self {
        OwnDeviceDef { get_instance_proc_addr, device_uuid: None, pipeline_cache: &[], workgroup_size: 128 }
    }
}

/// A command buffer, and the fence that it signals.
struct Submission {
    commands: vk::CommandBuffer,
    fence: vk::Fence,
    /// The frame that it runs.
    pending: Option<u64>,
}

/// A Vulkan device of Crumple's own, beside the host's on the same physical device.
///
/// Import the host's buffers and semaphores with [`OwnDevice::import_buffer`] and [`OwnDevice::import_semaphore`]. Add targets to
/// [`OwnDevice::device`]. Call [`OwnDevice::submit`] instead of [`Device::record`]. Dropping it waits for the device.
pub struct OwnDevice {
    device: Device,
    pub(super) own: Arc<OwnHandles>,
    submissions: Vec<Submission>,
    pub(super) buffers: Vec<(BufferId, ImportedBuffer)>,
    pub(super) semaphores: Vec<vk::Semaphore>,
    frame: u64,
}

impl fmt::Debug for OwnDevice {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("OwnDevice").field("device", &self.device).field("frame", &self.frame).finish_non_exhaustive()
    }
}

impl OwnDevice {
    /// Makes an instance and a device. It takes from milliseconds to tenths of a second, depending on the driver.
    ///
    /// # Errors
    /// [`Error::Unsupported`] if there is no device, none has this UUID (the text lists the devices), the device cannot import
    /// memory, or the loader lacks a function; [`Error::InvalidArgument`] for a bad workgroup size; [`Error::Vulkan`],
    /// [`Error::DeviceLost`].
    ///
    /// # Safety
    /// The function is a loader's `vkGetInstanceProcAddr`, and the loader stays loaded until this is dropped.
    pub unsafe fn new(def: &OwnDeviceDef<'_>) -> Result<Self, Error> {
        // SAFETY: the caller's loader.
        let own = OwnHandles::new(unsafe { OwnInstance::new(def.get_instance_proc_addr, def.device_uuid)? })?;
        let device = DeviceDef {
            get_instance_proc_addr: def.get_instance_proc_addr,
            instance: own.instance.instance.handle(),
            physical_device: own.instance.physical_device,
            device: own.device.handle(),
            queue_family: own.instance.family,
            pipeline_cache: def.pipeline_cache,
            workgroup_size: def.workgroup_size,
        };
        // SAFETY: the handles were made just now, and are destroyed after the device is dropped.
        let device = unsafe { Device::new(&device) }?;
        let (submissions, buffers, semaphores) = (Vec::new(), Vec::new(), Vec::new());
        Ok(OwnDevice { device, own: Arc::new(own), submissions, buffers, semaphores, frame: 0 })
    }

    /// The device to add targets to, and to ask about frames and pipelines. Do not call [`Device::record`] or
    /// [`Device::completed`] on it; [`OwnDevice::submit`] does that.
    pub fn device(&mut self) -> &mut Device {
        &mut self.device
    }

    pub(super) fn id(&self) -> u64 {
        self.device.plan.id
    }

    /// Brings the targets up to date: records the blocks that changed since each was last written, and submits them. The submission
    /// waits for each semaphore in `wait` and signals each in `signal`, even if nothing changed. Returns the number of the frame,
    /// for [`OwnDevice::wait`], and what was recorded. The call itself does not wait.
    ///
    /// # Errors
    /// As [`Device::record`], and [`Error::InvalidArgument`] for an unknown semaphore. After an error nothing was submitted.
    pub fn submit(
        &mut self,
        jobs: &mut [Job<'_, Target>],
        wait: &[SemaphoreId],
        signal: &[SemaphoreId],
    ) -> Result<(u64, FrameReport), Error> {
        let wait = self.handles(wait)?;
        let signal = self.handles(signal)?;
        self.poll()?;
        let slot = self.submission()?;
        let (commands, fence) = (self.submissions[slot].commands, self.submissions[slot].fence);
        let device = &self.own.device;
        let begin = vk::CommandBufferBeginInfo::default().flags(vk::CommandBufferUsageFlags::ONE_TIME_SUBMIT);
        // SAFETY: the fence of the command buffer's last use has signalled.
        unsafe {
            device.reset_fences(&[fence]).map_err(failed("vkResetFences"))?;
            device.begin_command_buffer(commands, &begin).map_err(failed("vkBeginCommandBuffer"))?;
        }
        let frame = self.frame + 1;
        // SAFETY: the command buffer is recording.
        let recorded = unsafe { self.device.record(commands, frame, jobs) };
        // SAFETY: it was begun.
        let ended = unsafe { device.end_command_buffer(commands) }.map_err(failed("vkEndCommandBuffer"));
        let report = recorded?;
        let stages = vec![vk::PipelineStageFlags::ALL_COMMANDS; wait.len()];
        let all = [commands];
        let submit = vk::SubmitInfo::default()
            .command_buffers(&all)
            .wait_semaphores(&wait)
            .wait_dst_stage_mask(&stages)
            .signal_semaphores(&signal);
        let submitted = ended.and_then(|()| {
            // SAFETY: the queue is used here alone.
            unsafe { device.queue_submit(self.own.queue, &[submit], fence) }.map_err(failed("vkQueueSubmit"))
        });
        if let Err(error) = submitted {
            // The recording will not run.
            self.device.discard(frame);
            jobs.iter_mut().filter(|j| j.target.written_in() == frame).for_each(|j| j.target.invalidate());
            return Err(error);
        }
        self.frame = frame;
        self.submissions[slot].pending = Some(frame);
        Ok((frame, report))
    }

    /// The last frame that was submitted, or 0.
    pub fn last_submitted(&self) -> u64 {
        self.frame
    }

    /// Waits until the device is done with a frame, at most for `nanoseconds` (`u64::MAX`: without limit). Returns whether it is
    /// done.
    ///
    /// # Errors
    /// [`Error::InvalidArgument`] for a frame that was not submitted; [`Error::Vulkan`], [`Error::DeviceLost`].
    pub fn wait(&mut self, frame: u64, nanoseconds: u64) -> Result<bool, Error> {
        if frame > self.frame {
            return Err(Error::invalid("frame", frame, &format!("at most {}, the last submitted", self.frame)));
        }
        let awaited = |s: &&Submission| s.pending.is_some_and(|pending| pending <= frame);
        let fences: Vec<vk::Fence> = self.submissions.iter().filter(awaited).map(|s| s.fence).collect();
        if !fences.is_empty() {
            // SAFETY: fences of this device.
            match unsafe { self.own.device.wait_for_fences(&fences, true, nanoseconds) } {
                Err(vk::Result::TIMEOUT) => return Ok(false),
                waited => waited.map_err(failed("vkWaitForFences"))?,
            }
        }
        self.poll()?;
        Ok(true)
    }

    /// Asks which submissions are done.
    fn poll(&mut self) -> Result<(), Error> {
        for s in self.submissions.iter_mut().filter(|s| s.pending.is_some()) {
            // SAFETY: a fence of this device.
            if unsafe { self.own.device.get_fence_status(s.fence) }.map_err(failed("vkGetFenceStatus"))? {
                s.pending = None;
            }
        }
        // Fences of one queue signal in order.
        let oldest = self.submissions.iter().filter_map(|s| s.pending).min();
        self.device.completed(oldest.map_or(self.frame, |frame| frame - 1));
        Ok(())
    }

    /// The handles of semaphores.
    fn handles(&self, ids: &[SemaphoreId]) -> Result<Vec<vk::Semaphore>, Error> {
        let one = |id: &SemaphoreId| {
            let place = (id.0 as u32).wrapping_sub(1) as usize;
            let found = self.semaphores.get(place).filter(|_| id.0 >> 32 == self.id());
            found.copied().ok_or_else(|| Error::invalid("semaphore", id.0, "one that this device imported"))
        };
        ids.iter().map(one).collect()
    }

    /// A submission that is not pending.
    fn submission(&mut self) -> Result<usize, Error> {
        if let Some(free) = self.submissions.iter().position(|s| s.pending.is_none()) {
            return Ok(free);
        }
        let device = &self.own.device;
        let info = vk::CommandBufferAllocateInfo::default().command_pool(self.own.pool).command_buffer_count(1);
        // SAFETY: a pool of this device. Its command buffers are freed with it.
        let commands =
            unsafe { device.allocate_command_buffers(&info) }.map_err(failed("vkAllocateCommandBuffers"))?[0];
        // SAFETY: as above.
        let fence =
            unsafe { device.create_fence(&vk::FenceCreateInfo::default(), None) }.map_err(failed("vkCreateFence"))?;
        self.submissions.push(Submission { commands, fence, pending: None });
        Ok(self.submissions.len() - 1)
    }
}

impl Drop for OwnDevice {
    fn drop(&mut self) {
        let device = &self.own.device;
        // SAFETY: everything was made with this device. The device is idle or lost, so nothing runs.
        unsafe {
            let _ = device.device_wait_idle();
            self.semaphores.iter().for_each(|s| device.destroy_semaphore(*s, None));
            self.submissions.iter().for_each(|s| device.destroy_fence(s.fence, None));
        }
        // What is dropped after this is not leaked.
        self.device.completed(u64::MAX);
    }
}
