//! Meshes, examples and stamps on the device, and their way there through staging buffers.

use super::memory::{BufferUse, OwnBuffer};
use super::vulkan_device::VulkanDevice;
use crate::base::error::Error;
use crate::example::set::ExampleSet;
use crate::gpu::{Arena, BindingLimits, ResidentMesh};
use std::sync::{Arc, Weak};

/// The arena's buffers, and what is still to be copied into them.
pub(super) struct MeshArena {
    arena: Arena<OwnBuffer>,
    uploads: Vec<StagedMesh>,
}

/// A mesh in a staging buffer.
struct StagedMesh {
    mesh: Weak<ResidentMesh>,
    staging: OwnBuffer,
    /// Bytes from the start of the chunk.
    at: u64,
    bytes: u64,
    /// The frame that copies it.
    recorded: Option<u64>,
}

impl MeshArena {
    pub(super) fn new() -> Self {
        MeshArena { arena: Arena::new(), uploads: Vec::new() }
    }

    /// Returns a mesh of the set. A new one is in a staging buffer until the next frame copies it.
    pub(super) fn mesh(
        &mut self,
        gpu: &VulkanDevice,
        limits: &BindingLimits,
        set: &Arc<ExampleSet>,
        lod: usize,
    ) -> Result<Arc<ResidentMesh>, Error> {
        let mut staged = None;
        let make = |bytes| gpu.buffer(bytes, BufferUse::Storage);
        let mesh = self.arena.mesh((set, lod), limits, make, |_, upload| {
            let (at, bytes) = (4 * u64::from(upload.at), 4 * upload.words);
            let mut staging = gpu.buffer(bytes, BufferUse::Staging)?;
            let mut written = Ok(());
            let flushed = gpu.write(&mut staging, upload.words as usize, |to| written = upload.write(to));
            if let Err(error) = written.and(flushed) {
                // SAFETY: nothing uses it yet.
                unsafe { gpu.destroy(&staging) };
                return Err(error);
            }
            staged = Some(StagedMesh { mesh: Weak::new(), staging, at, bytes, recorded: None });
            Ok(())
        })?;
        self.uploads.extend(staged.map(|s| StagedMesh { mesh: Arc::downgrade(&mesh), ..s }));
        Ok(mesh)
    }

    /// The buffer of the chunk that holds a resident mesh.
    pub(super) fn buffer(&self, chunk: u32) -> &OwnBuffer {
        self.arena.buffer(chunk)
    }

    /// Calls `copy` with staging buffer, chunk, bytes from the chunk's start and size of each mesh that was not copied yet.
    pub(super) fn record(&mut self, frame: u64, mut copy: impl FnMut(&OwnBuffer, &OwnBuffer, u64, u64)) {
        for u in self.uploads.iter_mut().filter(|u| u.recorded.is_none()) {
            let Some(mesh) = u.mesh.upgrade() else { continue };
            copy(&u.staging, self.arena.buffer(mesh.chunk), u.at, u.bytes);
            u.recorded = Some(frame);
            mesh.used_in(frame);
        }
    }

    /// Frees what frames up to `done` needed. Calls `freed` with each chunk that is no more.
    pub(super) fn completed(&mut self, gpu: &VulkanDevice, done: u64, mut freed: impl FnMut(u32)) {
        self.arena.collect(done, |chunk, buffer| {
            freed(chunk);
            // SAFETY: the frames that read it are done.
            unsafe { gpu.destroy(buffer) };
        });
        self.uploads.retain(|u| {
            let kept = u.mesh.strong_count() > 0 && u.recorded.is_none_or(|frame| frame > done);
            if !kept {
                // SAFETY: the frame that copied from it is done, or there is none.
                unsafe { gpu.destroy(&u.staging) };
            }
            kept
        });
    }

    /// Notes that frames from `frame` on will not run.
    pub(super) fn discard(&mut self, frame: u64) {
        let lost = self.uploads.iter_mut().filter(|u| u.recorded.is_some_and(|f| f >= frame));
        lost.for_each(|u| u.recorded = None);
    }

    /// # Safety
    /// Nothing uses it any more.
    pub(super) unsafe fn destroy(&self, gpu: &VulkanDevice) {
        for buffer in self.uploads.iter().map(|u| &u.staging).chain(self.arena.buffers()) {
            // SAFETY: the caller's promise.
            unsafe { gpu.destroy(buffer) };
        }
    }
}
