//! Registers the host's buffers and adds targets in them.

use super::device::Device;
use super::host_buffers::{BufferDef, BufferId};
use super::target::{Target, TargetDef};
use crate::base::error::Error;
use crate::deform::Tracker;
use crate::example::set::ExampleSet;
use crate::gpu::{Case, TargetState, Variant};
use ash::vk::{self, Handle};
use std::sync::Arc;

impl Device {
    /// Registers a buffer of the host. It may hold any number of targets; one dispatch writes all targets in one buffer.
    ///
    /// # Errors
    /// [`Error::InvalidArgument`] for a null buffer, a size of 0, a usage without `STORAGE_BUFFER`, or an access without stages.
    ///
    /// # Safety
    /// The buffer belongs to this device, is bound to memory, and has this size and usage. It lives until it is removed and all
    /// frames that wrote it are done.
    pub unsafe fn add_buffer(&mut self, def: &BufferDef) -> Result<BufferId, Error> {
        if def.buffer.is_null() {
            return Err(Error::invalid("the VkBuffer", "null", "a valid handle"));
        }
        if def.size < 4 {
            return Err(Error::invalid("the buffer's size", def.size, "at least 4 bytes"));
        }
        if !def.usage.contains(vk::BufferUsageFlags::STORAGE_BUFFER) {
            let value = format!("{:?}", def.usage);
            return Err(Error::invalid("the buffer's usage", value, "with STORAGE_BUFFER among its flags"));
        }
        for (name, access) in [("the stages before", def.before), ("the stages after", def.after)] {
            if access.stages.is_empty() {
                return Err(Error::invalid(
                    name,
                    "none",
                    "at least one stage (TOP_OF_PIPE or BOTTOM_OF_PIPE for none)",
                ));
            }
        }
        Ok(self.hosts.add(def))
    }

    /// Removes a buffer. Its targets can no longer be recorded. The host may destroy it once the frames that wrote it are done.
    ///
    /// # Errors
    /// [`Error::InvalidArgument`] for a stale id.
    pub fn remove_buffer(&mut self, id: BufferId) -> Result<(), Error> {
        let host = self.hosts.remove(id)?;
        self.garbage.extend(host.windows.into_iter().map(|w| (host.used, w.set)));
        Ok(())
    }

    /// The handle of a buffer.
    #[cfg(feature = "capi")]
    pub(crate) fn handle_of(&self, id: BufferId) -> Result<u64, Error> {
        Ok(self.hosts.get(id)?.def.buffer.as_raw())
    }

    /// Adds a target: a place for the vertices of one of the set's meshes. The first target of a mesh copies the mesh and its
    /// examples into a staging buffer; the next recording copies them to the device.
    ///
    /// # Errors
    /// [`Error::InvalidArgument`] for a stale buffer, a format that the attribute cannot have, a stride that is too small, attributes
    /// that overlap, or a bad scale; [`Error::Misaligned`] for offsets and strides that are not multiples of 4;
    /// [`Error::BufferTooSmall`]; [`Error::IndexOutOfRange`] for a level of detail that the set lacks; [`Error::Unsupported`] for
    /// normals or tangents that the mesh lacks, or more bytes than the device can bind;
    /// [`Error::OutOfMemory`], [`Error::Vulkan`], [`Error::DeviceLost`].
    pub fn add_target(&mut self, set: &Arc<ExampleSet>, def: &TargetDef) -> Result<Target, Error> {
        let mesh = set.lod(def.lod)?;
        let size = self.hosts.get(def.buffer)?.def.size;
        let (layout, kernel, written) = def.layout(&mesh.mesh, size)?;
        let limits = self.gpu.binding_limits();
        let host = self.hosts.get_mut(def.buffer)?;
        let window = host.window(&self.gpu, &self.pipelines, &written)?;
        let (handle, first) = (host.def.buffer, def.offset.wrapping_sub(host.windows[window].range.start));
        let variant = Variant { kernel, case: Case::Nodes, packed: layout.packed() };
        self.gpu.add_pipeline(&mut self.pipelines, variant)?;
        let mesh = self.arena.mesh(&self.gpu, &limits, set, def.lod)?;
        let (device, set, tracker) = (self.id, Arc::downgrade(set), Tracker::new());
        let state = TargetState { device, set, lod: def.lod, kernel, layout, first, mesh, tracker };
        Ok(Target { state, handle, buffer: def.buffer, window, classic: None, written_in: 0 })
    }
}
