//! What a context keeps of the host's Vulkan device and buffers.

use super::check::{boolean, enumerator, finite};
use super::memory::check_lod;
use super::result::{CrumpleResult, Failure};
use super::vulkan_types::{
    CrumpleHandleType, CrumpleVulkanAttachDef, CrumpleVulkanBufferDef, CrumpleVulkanFunction, CrumpleVulkanImportDef,
    CrumpleVulkanOpenDef, CrumpleVulkanStream,
};
use crate::gpu::TargetDef;
use crate::instance::Instance;
use crate::vulkan::vk::{self, Handle};
use crate::vulkan::{
    Access, BufferDef, BufferId, Device, DeviceDef, ImportDef, OwnDevice, OwnDeviceDef, Shared, Stream, Target,
};
use std::collections::HashMap;

/// The device, and the VkBuffers that ranges lie in.
pub(super) struct Attached {
    pub(super) device: Kind,
    /// By handle: its id, and how many ranges lie in it.
    hosts: HashMap<u64, (BufferId, usize)>,
}

pub(super) enum Kind {
    Hosts(Box<Device>),
    Own(Box<OwnDevice>),
}

impl Kind {
    pub(super) unsafe fn hosts_own(def: &CrumpleVulkanAttachDef, pipeline_cache: &[u8]) -> Result<Self, Failure> {
        let handles =
            [("def.instance", def.instance), ("def.physical_device", def.physical_device), ("def.device", def.device)];
        if let Some((name, _)) = handles.iter().find(|(_, handle)| handle.is_null()) {
            return Err(Failure::null(name));
        }
        let [instance, physical_device, device] = handles.map(|(_, handle)| handle.addr() as u64);
        let def = DeviceDef {
            get_instance_proc_addr: loader(def.get_instance_proc_addr)?,
            instance: vk::Instance::from_raw(instance),
            physical_device: vk::PhysicalDevice::from_raw(physical_device),
            device: vk::Device::from_raw(device),
            queue_family: def.queue_family,
            pipeline_cache,
            workgroup_size: def.workgroup_size,
        };
        Ok(Kind::Hosts(Box::new(Device::new(&def)?)))
    }

    pub(super) unsafe fn open(def: &CrumpleVulkanOpenDef, pipeline_cache: &[u8]) -> Result<Self, Failure> {
        let def = OwnDeviceDef {
            get_instance_proc_addr: loader(def.get_instance_proc_addr)?,
            device_uuid: Some(def.device_uuid).filter(|uuid| *uuid != [0; 16]),
            pipeline_cache,
            workgroup_size: def.workgroup_size,
        };
        Ok(Kind::Own(Box::new(OwnDevice::new(&def)?)))
    }

    pub(super) fn device(&mut self) -> &mut Device {
        match self {
            Kind::Hosts(device) => device,
            Kind::Own(own) => own.device(),
        }
    }

    /// The host's own, which `call` works with.
    pub(super) fn hosts(&mut self, call: &str) -> Result<&mut Device, Failure> {
        let Kind::Hosts(device) = self else {
            return Err(Failure::invalid(format!(
                "the device is Crumple's own, from crumple_vulkan_open(); {call} is for one of crumple_vulkan_attach()"
            )));
        };
        Ok(device)
    }

    /// Crumple's own, which `call` works with.
    pub(super) fn own(&mut self, call: &str) -> Result<&mut OwnDevice, Failure> {
        let Kind::Own(own) = self else {
            return Err(Failure::invalid(format!(
                "the device is yours, from crumple_vulkan_attach(); {call} is for one of crumple_vulkan_open()"
            )));
        };
        Ok(own)
    }
}

impl Attached {
    pub(super) fn new(device: Kind) -> Self {
        Self { device, hosts: HashMap::new() }
    }

    /// Fails while a frame is in flight that will not be waited for.
    pub(super) fn check_idle(&self) -> Result<(), Failure> {
        let Kind::Hosts(device) = &self.device else { return Ok(()) };
        let (recorded, completed) = (device.recorded(), device.last_completed());
        if recorded > completed {
            let message = format!(
                "frame {recorded} was recorded, and crumple_vulkan_complete_frames() was told of {completed} at last: wait for the \
                 device and tell it of frame {recorded}"
            );
            return Err(Failure::new(CrumpleResult::CrumpleErrorFramesInFlight, message));
        }
        Ok(())
    }

    pub(super) unsafe fn register(
        &mut self,
        instance: &Instance,
        def: &CrumpleVulkanBufferDef,
    ) -> Result<Target, Failure> {
        check_lod(instance, def.lod)?;
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
        let id = match (self.hosts.get(&def.buffer), &mut self.device) {
            (Some((id, _)), Kind::Own(_)) => *id,
            (Some((id, _)), Kind::Hosts(device)) => device.buffer_def(*id)?.same(&buffer).map(|()| *id)?,
            (None, Kind::Own(_)) => {
                let message = "def.buffer is none of crumple_vulkan_import_buffer(); import it first";
                return Err(Failure::invalid(message));
            }
            (None, Kind::Hosts(device)) => device.add_buffer(&buffer)?,
        };
        let device = self.device.device();
        let target = def.target(id).and_then(|target| Ok(device.add_target(instance.example_set(), &target)?));
        self.hosts.entry(def.buffer).or_insert((id, 0)).1 += usize::from(target.is_ok());
        self.forget(def.buffer)?;
        target
    }

    pub(super) fn remove(&mut self, target: Target) -> Result<(), Failure> {
        let handle = target.binding.handle.as_raw();
        let Some((_, ranges)) = self.hosts.get_mut(&handle) else { return Ok(()) };
        *ranges -= 1;
        self.forget(handle)
    }

    /// Forgets a buffer of the host's device that no range lies in.
    fn forget(&mut self, handle: u64) -> Result<(), Failure> {
        if let (Kind::Hosts(device), Some((id, 0))) = (&mut self.device, self.hosts.get(&handle)) {
            device.remove_buffer(*id)?;
            self.hosts.remove(&handle);
        }
        Ok(())
    }

    pub(super) unsafe fn import_buffer(&mut self, def: &CrumpleVulkanImportDef) -> Result<u64, Failure> {
        let own = self.device.own("crumple_vulkan_import_buffer()")?;
        let def = ImportDef {
            memory: shared(enumerator(def.handle_type, "def.handle_type")?, def.handle),
            memory_size: def.memory_size,
            memory_type: def.memory_type,
            dedicated: boolean(def.dedicated),
            offset: def.offset,
            size: def.size,
            usage: vk::BufferUsageFlags::from_raw(def.usage),
        };
        let id = own.import_buffer(&def)?;
        let handle = own.device().buffer_def(id)?.buffer.as_raw();
        self.hosts.insert(handle, (id, 0));
        Ok(handle)
    }

    pub(super) fn release_buffer(&mut self, buffer: u64) -> Result<(), Failure> {
        let own = self.device.own("crumple_vulkan_unimport_buffer()")?;
        let (id, ranges) = *self.hosts.get(&buffer).ok_or_else(|| {
            Failure::invalid(format!("buffer is {buffer:#x}; it must be one of crumple_vulkan_import_buffer()"))
        })?;
        if ranges > 0 {
            let message = format!("{ranges} ranges of buffer {buffer:#x} are registered; unregister them first");
            return Err(Failure::invalid(message));
        }
        own.remove_buffer(id)?;
        self.hosts.remove(&buffer);
        Ok(())
    }
}

unsafe fn loader(function: CrumpleVulkanFunction) -> Result<vk::PFN_vkGetInstanceProcAddr, Failure> {
    let function = function.ok_or_else(|| Failure::null("def.get_instance_proc_addr"))?;
    Ok(std::mem::transmute::<unsafe extern "C" fn(), vk::PFN_vkGetInstanceProcAddr>(function))
}

pub(super) fn shared(kind: CrumpleHandleType, handle: i64) -> Shared {
    match kind {
        // What is no file descriptor becomes one that is refused.
        CrumpleHandleType::OpaqueFd => Shared::OpaqueFd(i32::try_from(handle).unwrap_or(-1)),
        CrumpleHandleType::OpaqueWin32 => Shared::OpaqueWin32(handle as isize),
    }
}

impl CrumpleVulkanBufferDef {
    /// Where the vertices lie in a buffer.
    pub(super) fn target<B>(&self, buffer: B) -> Result<TargetDef<B, vk::Format>, Failure> {
        finite(self.scale.array(), "def.scale")?;
        finite(self.bias.array(), "def.bias")?;
        let positions = stream(&self.positions, "positions")?
            .ok_or_else(|| Failure::invalid("def.positions is absent (format 0); a buffer needs positions"))?;
        Ok(TargetDef {
            lod: self.lod as usize,
            buffer,
            offset: self.offset,
            size: self.size,
            positions,
            normals: stream(&self.normals, "normals")?,
            tangents: stream(&self.tangents, "tangents")?,
            scale: self.scale.array(),
            bias: self.bias.array(),
        })
    }
}

fn stream(s: &CrumpleVulkanStream, name: &str) -> Result<Option<Stream>, Failure> {
    if s.reserved != 0 {
        return Err(Failure::invalid(format!("def.{name}.reserved is {}; it must be 0", s.reserved)));
    }
    let format = vk::Format::from_raw(s.format as i32);
    let stream = Stream { offset: s.offset, stride: s.stride, format };
    Ok((*s != CrumpleVulkanStream::default()).then_some(stream))
}
