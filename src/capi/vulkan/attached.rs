//! What a context keeps of the host's Vulkan device and buffers.

use super::super::buffer::{BufferEntry, Memory};
use super::super::deform::Chosen;
use super::super::ids::Slots;
use super::super::instance::InstanceEntry;
use super::super::result::{CrumpleResult, Failure};
use super::super::types::CrumpleBuffer;
use super::{CrumpleRecordReport, CrumpleVulkanBufferDef, CrumpleVulkanDef, CrumpleVulkanStream};
use crate::vulkan::vk::{self, Handle};
use crate::vulkan::{Access, BufferDef, BufferId, Device, DeviceDef, RecordJob, Stream, Target, TargetDef};
use crate::{Aabb, Instance, Rule};
use std::collections::HashMap;
use std::ffi::c_void;
use std::ops::Range;

/// The device, and the VkBuffers that ranges lie in.
pub(in super::super) struct Attached {
    device: Device,
    /// By handle.
    hosts: HashMap<u64, Host>,
    /// Lists of one recording, used over and over.
    chosen: Vec<CrumpleBuffer>,
    jobs: Vec<RecordJob<'static>>,
}

struct Host {
    def: BufferDef,
    id: BufferId,
    /// Ranges in it.
    ranges: usize,
}

/// A range of a VkBuffer.
pub(in super::super) struct VulkanMemory {
    target: Target,
    handle: u64,
}

impl Attached {
    /// # Safety
    /// The handles are valid, belong together, and stay valid while this lives.
    pub(super) unsafe fn new(def: &CrumpleVulkanDef, pipeline_cache: &[u8]) -> Result<Self, Failure> {
        let Some(loader) = def.get_instance_proc_addr else {
            return Err(Failure::new(CrumpleResult::CrumpleErrorNullPointer, "def.get_instance_proc_addr is null"));
        };
        let handles =
            [("def.instance", def.instance), ("def.physical_device", def.physical_device), ("def.device", def.device)];
        if let Some((name, _)) = handles.iter().find(|(_, handle)| handle.is_null()) {
            return Err(Failure::new(CrumpleResult::CrumpleErrorNullPointer, format!("{name} is null")));
        }
        let [instance, physical_device, device] = handles.map(|(_, handle)| handle.addr() as u64);
        let def = DeviceDef {
            // SAFETY: by the caller's word it is this function.
            get_instance_proc_addr: unsafe {
                std::mem::transmute::<unsafe extern "C" fn(), vk::PFN_vkGetInstanceProcAddr>(loader)
            },
            instance: vk::Instance::from_raw(instance),
            physical_device: vk::PhysicalDevice::from_raw(physical_device),
            device: vk::Device::from_raw(device),
            queue_family: def.queue_family,
            pipeline_cache,
            workgroup_size: def.workgroup_size,
        };
        // SAFETY: the caller's.
        let device = unsafe { Device::new(&def) }?;
        Ok(Self { device, hosts: HashMap::new(), chosen: Vec::new(), jobs: Vec::new() })
    }

    /// Fails while a frame is in flight.
    pub(in super::super) fn check_idle(&self) -> Result<(), Failure> {
        let (recorded, completed) = (self.device.recorded(), self.device.last_completed());
        if recorded > completed {
            let message = format!(
                "frame {recorded} was recorded, and crumple_complete_frames() was told of {completed} at last: wait for the \
                 device and tell it of frame {recorded}"
            );
            return Err(Failure::new(CrumpleResult::CrumpleErrorFramesInFlight, message));
        }
        Ok(())
    }

    pub(super) fn pipeline_cache(&self) -> Result<Vec<u8>, Failure> {
        Ok(self.device.pipeline_cache_data()?)
    }

    /// # Safety
    /// The VkBuffer is as the def says, and lives until it is removed and the frames that wrote it are done.
    pub(super) unsafe fn register(
        &mut self,
        instance: &Instance,
        def: &CrumpleVulkanBufferDef,
    ) -> Result<VulkanMemory, Failure> {
        if def.lod > 0 && instance.options().rule != Rule::Marks {
            return Err(instance.needs_marks("a buffer of another level of detail than 0").into());
        }
        let positions = stream(&def.positions)
            .ok_or_else(|| Failure::invalid("def.positions is absent (format 0); a buffer needs positions"))?;
        let access = |stages, access| Access {
            stages: vk::PipelineStageFlags::from_raw(stages),
            access: vk::AccessFlags::from_raw(access),
        };
        let buffer = BufferDef {
            buffer: vk::Buffer::from_raw(def.buffer),
            size: def.buffer_size,
            usage: vk::BufferUsageFlags::from_raw(def.usage),
            queue_family: def.queue_family,
            before: access(def.before_stages, def.before_access),
            after: access(def.after_stages, def.after_access),
        };
        let id = match self.hosts.get(&def.buffer) {
            Some(known) => known.def.same(&buffer).map(|()| known.id)?,
            None => {
                // SAFETY: the caller's.
                let id = unsafe { self.device.add_buffer(&buffer) }?;
                self.hosts.insert(def.buffer, Host { def: buffer, id, ranges: 0 });
                id
            }
        };
        let target = TargetDef {
            lod: def.lod as usize,
            buffer: id,
            offset: def.offset,
            size: def.size,
            positions,
            normals: stream(&def.normals),
            tangents: stream(&def.tangents),
            scale: def.scale.array(),
            bias: def.bias.array(),
        };
        let target = self.device.add_target(instance.example_set(), &target);
        let host = self.hosts.get_mut(&def.buffer).expect("it was found or inserted");
        host.ranges += usize::from(target.is_ok());
        if host.ranges == 0 {
            self.forget(def.buffer)?;
        }
        Ok(VulkanMemory { target: target?, handle: def.buffer })
    }

    pub(in super::super) fn remove(&mut self, memory: VulkanMemory) -> Result<(), Failure> {
        let Some(host) = self.hosts.get_mut(&memory.handle) else { return Ok(()) };
        host.ranges -= 1;
        if host.ranges == 0 { self.forget(memory.handle) } else { Ok(()) }
    }

    fn forget(&mut self, handle: u64) -> Result<(), Failure> {
        let host = self.hosts.remove(&handle);
        Ok(host.map_or(Ok(()), |host| self.device.remove_buffer(host.id))?)
    }

    /// # Safety
    /// As [`Device::record`].
    pub(super) unsafe fn record(
        &mut self,
        (command_buffer, frame): (*mut c_void, u64),
        (pointer, given): (*const CrumpleBuffer, &[CrumpleBuffer]),
        (entries, instances): (&mut Slots<BufferEntry>, &mut Slots<InstanceEntry>),
    ) -> Result<CrumpleRecordReport, Failure> {
        let chosen = Chosen::new(pointer, given, &mut self.chosen, |id, name| match entries.get(id, name)?.memory {
            Memory::Vulkan(_) => Ok(()),
            Memory::Host(..) => {
                Err(Failure::invalid(format!("{name} is a host buffer; crumple_deform() writes those")))
            }
        })?;
        let of_vulkan = |entry: &BufferEntry| matches!(entry.memory, Memory::Vulkan(_));
        for (id, entry) in entries.iter::<CrumpleBuffer>() {
            if of_vulkan(entry) && chosen.names(id) {
                instances.get_mut(entry.owner, "instance")?.instance.fold();
            }
        }
        let mut jobs = recycled(std::mem::take(&mut self.jobs));
        let full = |_| Failure::new(CrumpleResult::CrumpleErrorOutOfMemory, "no memory for the list of jobs");
        jobs.try_reserve(chosen.most(entries.len())).map_err(full)?;
        for (id, entry) in entries.iter_mut::<CrumpleBuffer>() {
            let Memory::Vulkan(memory) = &mut entry.memory else { continue };
            if chosen.names(id) {
                let instance = &instances.get(entry.owner, "instance")?.instance;
                jobs.push(RecordJob { instance, target: &mut memory.target });
            }
        }
        let commands = vk::CommandBuffer::from_raw(command_buffer.addr() as u64);
        // SAFETY: the caller's.
        let report = unsafe { self.device.record(commands, frame, &mut jobs) };
        self.jobs = recycled(jobs);
        let report = report?;
        Ok(CrumpleRecordReport {
            vertices_written: report.vertices_written,
            blocks_written: report.blocks_written,
            blocks_skipped: report.blocks_skipped,
            parts_skipped: report.parts_skipped,
            bytes_copied: report.bytes_copied,
            dispatches: report.dispatches,
            ..CrumpleRecordReport::default()
        })
    }

    pub(super) fn complete(&mut self, frame: u64) {
        self.device.completed(frame);
    }

    pub(super) fn discard(&mut self, frame: u64) {
        self.device.discard(frame);
    }
}

/// The same room, empty, for another lifetime.
fn recycled<'b>(mut jobs: Vec<RecordJob<'_>>) -> Vec<RecordJob<'b>> {
    jobs.clear();
    // Collecting in place keeps the allocation.
    jobs.into_iter().map(|_| -> RecordJob<'b> { unreachable!("the list is empty") }).collect()
}

fn stream(s: &CrumpleVulkanStream) -> Option<Stream> {
    let format = vk::Format::from_raw(s.format as i32);
    (*s != CrumpleVulkanStream::default()).then_some(Stream { offset: s.offset, stride: s.stride, format })
}

impl VulkanMemory {
    pub(in super::super) fn invalidate(&mut self) {
        self.target.invalidate();
    }

    pub(in super::super) fn changed(&self) -> &[Range<u32>] {
        self.target.changed()
    }

    pub(in super::super) fn bounds(&self) -> Option<Aabb> {
        self.target.bounds()
    }

    /// What was recorded for `frame` or later will not run.
    pub(super) fn discard(&mut self, frame: u64) {
        if self.target.written_in() >= frame {
            self.target.invalidate();
        }
    }
}
