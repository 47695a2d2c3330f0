//! Buffers: memory of the host that deformed vertices are written to.

use super::boundary::succeeds;
use super::context::look_into;
use super::memory::{CrumpleHostBufferDef, HostMemory};
use super::prelude::*;
use super::store::{BufferEntry, Memory};
use crate::base::memory::may_fail;
use crate::deform::Tracker;

/// Adds a buffer to those of its owner.
pub(super) fn add_buffer(
    state: &mut State,
    owner: CrumpleInstance,
    (lod, user_data): (u32, u64),
    memory: Memory,
    out: Out<CrumpleBuffer>,
) -> Result<(), Failure> {
    let theirs = &mut state.instances.get_mut(owner, "instance")?.buffers;
    state.buffers.reserve()?;
    may_fail(|| theirs.try_reserve(1)).map_err(|_| Failure::out_of_memory("one more buffer"))?;
    granted()?;
    let id = state.buffers.insert(BufferEntry { owner, lod: lod as usize, memory, user_data, included: false });
    theirs.push(id);
    out.answer(id)
}

/// What a buffer shows.
#[repr(C)]
#[derive(Debug, Clone, Copy)]
pub struct CrumpleBufferInfo {
    pub buffer: CrumpleBuffer,
    pub instance: CrumpleInstance,
    /// The user_data of the buffer's def, and of the instance.
    pub user_data: u64,
    pub instance_user_data: u64,
    /// Which mesh of the set.
    pub lod: u32,
    pub reserved: [u32; 3],
}

#[unsafe(no_mangle)]
pub extern "C" fn crumple_host_buffer_def_default() -> CrumpleHostBufferDef {
    zeroed()
}

/// Registers your memory for an instance's deformed vertices. The first deform writes every vertex. An instance may
/// have several buffers, such as a ring. Only crumple_context_deform() touches the memory, which must exist until the
/// buffer is unregistered or gets other memory, or its instance or context is destroyed, and must not overlap that of
/// other buffers. Errors: CRUMPLE_ERROR_MESH (normals or tangents that the mesh lacks), CRUMPLE_ERROR_WRONG_RULE (lod above
/// 0 with a classic rule).
#[unsafe(no_mangle)]
pub unsafe extern "C" fn crumple_buffer_register_host(
    context: *mut CrumpleContext,
    instance: CrumpleInstance,
    def: *const CrumpleHostBufferDef,
    out_buffer: *mut CrumpleBuffer,
) -> CrumpleResult {
    exclusive("crumple_buffer_register_host", context, |_, state| {
        let (def, out) = (self::def(def, "def")?, Out::new(out_buffer, "out_buffer")?);
        let memory = Memory::Host(HostMemory::new(&def, state.body(instance)?)?, Tracker::new());
        add_buffer(state, instance, (def.lod, def.user_data), memory, out)
    })
}

/// Unregisters a buffer. You may then free its memory, or its VkBuffer once the frames that wrote it are complete.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn crumple_buffer_unregister(
    context: *mut CrumpleContext,
    buffer: CrumpleBuffer,
) -> CrumpleResult {
    exclusive("crumple_buffer_unregister", context, |_, state| state.remove_buffer(buffer))
}

/// Returns whether an id is that of a buffer of the context. False while another thread is inside the context.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn crumple_buffer_is_valid(context: *mut CrumpleContext, buffer: CrumpleBuffer) -> bool {
    succeeds(|| look_into(context, |state| state.buffers.get(buffer, "buffer").map(drop)))
}

/// Returns what a buffer shows.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn crumple_buffer_get_info(
    context: *mut CrumpleContext,
    buffer: CrumpleBuffer,
    out_info: *mut CrumpleBufferInfo,
) -> CrumpleResult {
    exclusive("crumple_buffer_get_info", context, |_, state| {
        Out::new(out_info, "out_info")?.answer(info(buffer, state.buffers.get(buffer, "buffer")?, state)?)
    })
}

/// What an entry shows.
pub(super) fn info(buffer: CrumpleBuffer, entry: &BufferEntry, state: &State) -> Result<CrumpleBufferInfo, Failure> {
    Ok(CrumpleBufferInfo {
        buffer,
        instance: entry.owner,
        user_data: entry.user_data,
        instance_user_data: state.instances.get(entry.owner, "instance")?.user_data,
        lod: entry.lod as u32,
        reserved: [0; 3],
    })
}

/// Declares a buffer's contents lost or overwritten. The next deform or recording writes every vertex.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn crumple_buffer_invalidate(
    context: *mut CrumpleContext,
    buffer: CrumpleBuffer,
) -> CrumpleResult {
    exclusive("crumple_buffer_invalidate", context, |_, state| {
        state.buffers.get_mut(buffer, "buffer")?.memory.invalidate();
        Ok(())
    })
}

/// Gives a host buffer other memory, perhaps for another level of detail, and invalidates it. Errors: those of
/// crumple_buffer_register_host(), and CRUMPLE_ERROR_INVALID_ARGUMENT (not a host buffer).
#[unsafe(no_mangle)]
pub unsafe extern "C" fn crumple_buffer_set_memory(
    context: *mut CrumpleContext,
    buffer: CrumpleBuffer,
    def: *const CrumpleHostBufferDef,
) -> CrumpleResult {
    exclusive("crumple_buffer_set_memory", context, |_, state| {
        let def = self::def(def, "def")?;
        let entry = state.buffers.get_mut(buffer, "buffer")?;
        let Memory::Host(memory, tracker) = &mut entry.memory else {
            return Err(Failure::invalid(
                "buffer is not a host buffer; register another one with the new vertex buffer",
            ));
        };
        *memory = HostMemory::new(&def, &state.instances.get(entry.owner, "instance")?.instance)?;
        entry.lod = def.lod as usize;
        entry.user_data = def.user_data;
        tracker.invalidate();
        Ok(())
    })
}
