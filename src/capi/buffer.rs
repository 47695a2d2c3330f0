//! Buffers: memory of the host that deformed vertices are written to.

use super::check::{Def, MadeBy, Out, def};
use super::context::{CrumpleContext, State, recorded};
use super::memory::{Stream, disjoint};
use super::recording::{Call, Log, Number};
use super::result::{CrumpleResult, Failure};
use super::types::{CrumpleBuffer, CrumpleInstance, CrumpleStream};
use super::vulkan::VulkanMemory;
use crate::{Aabb, Attribute, Instance, RawStream, Rule, Tracker, VertexMemory};
use std::ops::Range;

/// Memory for the deformed vertices of one instance, in the mesh's order and space.
#[repr(C)]
#[derive(Debug, Clone, Copy)]
pub struct CrumpleHostBufferDef {
    /// Bytes of this struct, from crumple_host_buffer_def_default().
    pub struct_size: u32,
    /// The mesh whose vertices are written: 0 the base mesh, else a number from crumple_example_set_add_lod(). Counts of
    /// vertices are that mesh's. Default 0.
    pub lod: u32,
    /// Positions: 3 floats a vertex, m. Required.
    pub positions: CrumpleStream,
    /// Unit normals: 3 floats a vertex. Absent: none are written.
    pub normals: CrumpleStream,
    /// Tangents: 4 floats a vertex, xyz of unit length and orthogonal to the normal, w as in the base mesh. Absent:
    /// none are written.
    pub tangents: CrumpleStream,
}

// SAFETY: `repr(C)`, starts with its size, and any bytes are a value of it.
unsafe impl Def for CrumpleHostBufferDef {
    const DEFAULT: MadeBy<Self> = ("crumple_host_buffer_def_default", crumple_host_buffer_def_default);
}

/// What a context keeps of a buffer.
pub(super) struct BufferEntry {
    pub(super) owner: CrumpleInstance,
    pub(super) lod: usize,
    pub(super) memory: Memory,
}

/// Where a buffer's vertices are.
#[cfg_attr(not(feature = "vulkan"), expect(clippy::large_enum_variant, reason = "the other one is never made then"))]
pub(super) enum Memory {
    Host(HostMemory, Tracker),
    Vulkan(VulkanMemory),
}

impl BufferEntry {
    pub(super) fn invalidate(&mut self) {
        match &mut self.memory {
            Memory::Host(_, tracker) => tracker.invalidate(),
            Memory::Vulkan(memory) => memory.invalidate(),
        }
    }

    /// What the last deform or recording wrote.
    pub(super) fn changed(&self) -> &[Range<u32>] {
        match &self.memory {
            Memory::Host(_, tracker) => tracker.changed(),
            Memory::Vulkan(memory) => memory.changed(),
        }
    }

    pub(super) fn bounds(&self) -> Option<Aabb> {
        match &self.memory {
            Memory::Host(_, tracker) => tracker.bounds(),
            Memory::Vulkan(memory) => memory.bounds(),
        }
    }
}

impl State {
    /// Adds a buffer to those of its owner.
    pub(super) fn add_buffer(
        &mut self,
        log: &mut Log<'_>,
        entry: BufferEntry,
        out: Out<CrumpleBuffer>,
    ) -> Result<(), Failure> {
        let owner = self.instances.get_mut(entry.owner, "instance")?;
        self.buffers.reserve::<CrumpleBuffer>()?;
        let full = |_| Failure::new(CrumpleResult::CrumpleErrorOutOfMemory, "no memory for one more buffer");
        owner.buffers.try_reserve(1).map_err(full)?;
        log.buffer(&entry, owner.instance.example_set());
        let id = self.buffers.insert(entry);
        log.gave_id(id);
        owner.buffers.push(id);
        out.write(id);
        Ok(())
    }

    /// Removes a buffer, but not from those of its owner.
    pub(super) fn remove_buffer(&mut self, buffer: CrumpleBuffer) -> Result<CrumpleInstance, Failure> {
        let entry = self.buffers.remove(buffer, "buffer")?;
        if let (Memory::Vulkan(memory), Some(vulkan)) = (entry.memory, &mut self.vulkan) {
            vulkan.remove(memory)?;
        }
        Ok(entry.owner)
    }
}

/// Checked memory of the host.
#[derive(Debug, Clone, Copy)]
pub(super) struct HostMemory {
    positions: Stream,
    normals: Option<Stream>,
    tangents: Option<Stream>,
}

impl HostMemory {
    fn new(def: &CrumpleHostBufferDef, instance: &Instance) -> Result<Self, Failure> {
        if def.lod > 0 && instance.options().rule != Rule::Marks {
            return Err(instance.needs_marks("a buffer of another level of detail than 0").into());
        }
        let mesh = instance.example_set().lod_mesh(def.lod as usize)?;
        let n = mesh.positions().len();
        let positions = Stream::new(def.positions, 12, n, "def.positions")?;
        let normals = Stream::new(def.normals, 12, n, "def.normals")?;
        let tangents = Stream::new(def.tangents, 16, n, "def.tangents")?;
        disjoint(&[("def.positions", positions), ("def.normals", normals), ("def.tangents", tangents)])?;
        let lacks = |what: &str, why: &str| -> Failure {
            crate::Error::Mesh { what: format!("it has no {what} to deform{why}") }.into()
        };
        if normals.is_some() && mesh.normals().is_none() {
            return Err(lacks("normals", ", nor triangles to compute them from"));
        }
        if tangents.is_some() && mesh.tangents().is_none() {
            return Err(lacks("tangents", ""));
        }
        let positions = positions.ok_or_else(|| {
            Failure::new(CrumpleResult::CrumpleErrorNullPointer, "def.positions.data is null; a buffer needs positions")
        })?;
        Ok(Self { positions, normals, tangents })
    }

    /// The memory as the deformer sees it.
    ///
    /// # Safety
    /// The host's memory is still there, and nobody else touches it while a deform runs.
    pub(super) unsafe fn vertices(&self) -> Result<VertexMemory<'static>, Failure> {
        let raw = |s: &Stream| RawStream {
            data: s.data,
            size: s.layout.span().len(),
            layout: Attribute { offset: 0, stride: s.layout.stride },
        };
        let (normals, tangents) = (self.normals.as_ref().map(raw), self.tangents.as_ref().map(raw));
        // SAFETY: the caller's; `new` checked sizes, alignment, strides and that the streams are disjoint.
        Ok(unsafe { VertexMemory::from_raw(raw(&self.positions), normals, tangents) }?)
    }

    /// Whether normals and tangents are written.
    pub(super) fn written(&self) -> (bool, bool) {
        (self.normals.is_some(), self.tangents.is_some())
    }

    /// Hands over what vertices were given.
    ///
    /// # Safety
    /// As for `vertices`.
    pub(super) unsafe fn read(&self, vertices: &Range<u32>, mut to: impl FnMut(&[u8])) {
        for stream in self.streams() {
            for v in vertices.clone() {
                // SAFETY: inside the memory, as `new` checked; the caller vouches for the rest.
                to(unsafe {
                    std::slice::from_raw_parts(
                        stream.data.add(v as usize * stream.layout.stride),
                        stream.layout.element,
                    )
                });
            }
        }
    }

    pub(super) fn streams(&self) -> impl Iterator<Item = Stream> {
        [Some(self.positions), self.normals, self.tangents].into_iter().flatten()
    }
}

/// A buffer without memory; set its streams. Never fails; any thread.
#[unsafe(no_mangle)]
pub extern "C" fn crumple_host_buffer_def_default() -> CrumpleHostBufferDef {
    CrumpleHostBufferDef {
        struct_size: size_of::<CrumpleHostBufferDef>() as u32,
        lod: 0,
        positions: CrumpleStream::ABSENT,
        normals: CrumpleStream::ABSENT,
        tangents: CrumpleStream::ABSENT,
    }
}

/// Registers memory of yours that crumple_context_deform() writes an instance's vertices to. An instance may have several,
/// such as the members of a ring, each of which gets what it lacks. Nothing is written yet; the first deform writes
/// every vertex. The memory is touched by crumple_context_deform() only, and must stay until the buffer is unregistered,
/// given other memory, or its instance or context is destroyed. Memory of different buffers must not overlap (debug
/// builds of the library check it).
///
/// Externally synchronised. Errors: CRUMPLE_ERROR_NULL_POINTER, CRUMPLE_ERROR_MISALIGNED, CRUMPLE_ERROR_STRUCT_SIZE,
/// CRUMPLE_ERROR_INVALID_ID, CRUMPLE_ERROR_INVALID_ARGUMENT (a stride smaller than an element, streams that overlap),
/// CRUMPLE_ERROR_INDEX_OUT_OF_RANGE (def.lod), CRUMPLE_ERROR_WRONG_RULE (def.lod above 0 for an instance with one of the
/// literature's rules), CRUMPLE_ERROR_BUFFER_TOO_SMALL, CRUMPLE_ERROR_MESH (normals or tangents of a mesh that has none),
/// CRUMPLE_ERROR_OUT_OF_MEMORY, CRUMPLE_ERROR_CONCURRENT_USE.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn crumple_buffer_register_host(
    context: *mut CrumpleContext,
    instance: CrumpleInstance,
    def: *const CrumpleHostBufferDef,
    out_buffer: *mut CrumpleBuffer,
) -> CrumpleResult {
    recorded("crumple_buffer_register_host", context, |_, state, log| {
        // SAFETY: the caller's.
        let (def, out) = unsafe { (self::def(def, "def")?, Out::new(out_buffer, "out_buffer")?) };
        let memory = HostMemory::new(&def, &state.instances.get(instance, "instance")?.instance)?;
        let memory = Memory::Host(memory, Tracker::new());
        state.add_buffer(log, BufferEntry { owner: instance, lod: def.lod as usize, memory }, out)
    })
}

/// Forgets a buffer. The memory stays as it is, yours alone again; a VkBuffer once the frames that wrote it are done.
///
/// Externally synchronised. Errors: CRUMPLE_ERROR_NULL_POINTER, CRUMPLE_ERROR_INVALID_ID,
/// CRUMPLE_ERROR_CONCURRENT_USE.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn crumple_buffer_unregister(
    context: *mut CrumpleContext,
    buffer: CrumpleBuffer,
) -> CrumpleResult {
    recorded("crumple_buffer_unregister", context, |_, state, log| {
        log.call(|| Call::UnregisterBuffer { buffer: Number::of(buffer) });
        let owner = state.remove_buffer(buffer)?;
        state.instances.get_mut(owner, "instance")?.buffers.retain(|b| *b != buffer);
        Ok(())
    })
}

/// Says that somebody else wrote to a buffer's memory, or that its contents were lost: the next deform, or recording, writes
/// every vertex.
///
/// Externally synchronised. Errors: CRUMPLE_ERROR_NULL_POINTER, CRUMPLE_ERROR_INVALID_ID,
/// CRUMPLE_ERROR_CONCURRENT_USE.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn crumple_buffer_invalidate(
    context: *mut CrumpleContext,
    buffer: CrumpleBuffer,
) -> CrumpleResult {
    recorded("crumple_buffer_invalidate", context, |_, state, log| {
        log.call(|| Call::InvalidateBuffer { buffer: Number::of(buffer) });
        state.buffers.get_mut(buffer, "buffer")?.invalidate();
        Ok(())
    })
}

/// Gives a buffer other memory, such as a newly mapped one, perhaps for another level of detail, and invalidates it.
///
/// Externally synchronised. Errors: as for crumple_buffer_register_host(), and CRUMPLE_ERROR_INVALID_ARGUMENT for a Vulkan
/// buffer; the buffer keeps its memory then.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn crumple_buffer_set_memory(
    context: *mut CrumpleContext,
    buffer: CrumpleBuffer,
    def: *const CrumpleHostBufferDef,
) -> CrumpleResult {
    recorded("crumple_buffer_set_memory", context, |_, state, log| {
        // SAFETY: the caller's.
        let def = unsafe { self::def(def, "def") }?;
        let entry = state.buffers.get_mut(buffer, "buffer")?;
        let Memory::Host(memory, tracker) = &mut entry.memory else {
            return Err(Failure::invalid("buffer is a Vulkan buffer; register another one with the new VkBuffer"));
        };
        *memory = HostMemory::new(&def, &state.instances.get(entry.owner, "instance")?.instance)?;
        let (normals, tangents) = memory.written();
        let vertices = memory.positions.layout.count as u32;
        log.call(|| Call::SetBufferMemory { buffer: Number::of(buffer), lod: def.lod, vertices, normals, tangents });
        entry.lod = def.lod as usize;
        tracker.invalidate();
        Ok(())
    })
}
