//! Deformation on a graphics device: recorded into the host's own Vulkan command buffers, or submitted by a device of Crumple's.

use super::buffer::add_buffer;
use super::device::{Attached, Kind, shared};
use super::jobs::with_jobs;
use super::prelude::*;
use super::store::Memory;
use super::vulkan_types::{
    CrumpleHandleType, CrumpleRecordReport, CrumpleVulkanAttachDef, CrumpleVulkanBufferDef, CrumpleVulkanImportDef,
    CrumpleVulkanOpenDef,
};
use crate::vulkan::{Job, SemaphoreId, Target, vk, vk::Handle};

#[unsafe(no_mangle)]
pub extern "C" fn crumple_vulkan_attach_def_default() -> CrumpleVulkanAttachDef {
    CrumpleVulkanAttachDef { queue_family: u32::MAX, workgroup_size: 128, ..zeroed() }
}

/// Attaches your Vulkan device, one per context. The handles must be valid,
/// belong together, and live until crumple_vulkan_detach() or crumple_context_destroy(). Errors:
/// CRUMPLE_ERROR_INVALID_ARGUMENT (a device is already attached, a queue family that does not exist or lacks compute, a
/// bad workgroup_size), CRUMPLE_ERROR_UNSUPPORTED (below Vulkan 1.1, or a loader that lacks a function).
#[unsafe(no_mangle)]
pub unsafe extern "C" fn crumple_vulkan_attach(
    context: *mut CrumpleContext,
    def: *const CrumpleVulkanAttachDef,
) -> CrumpleResult {
    exclusive("crumple_vulkan_attach", context, |_, state| {
        let def = self::def(def, "def")?;
        attach(state, (def.pipeline_cache, def.pipeline_cache_size), |cache| Kind::hosts_own(&def, cache))
    })
}

/// Detaches the Vulkan device. Unregisters all Vulkan buffers and destroys Crumple's objects on the device. Damage
/// stays. After CRUMPLE_ERROR_DEVICE_LOST, call crumple_vulkan_complete_frames() with UINT64_MAX, then this, then
/// vkDestroyDevice. Then attach the new device and register the buffers again. CRUMPLE_ERROR_FRAMES_IN_FLIGHT: nothing
/// changed.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn crumple_vulkan_detach(context: *mut CrumpleContext) -> CrumpleResult {
    exclusive("crumple_vulkan_detach", context, |_, state| {
        attached(state)?.check_idle()?;
        let of_vulkan = state.buffers.iter().filter(|(_, entry)| matches!(entry.memory, Memory::Vulkan(_)));
        let theirs: Vec<_> = of_vulkan.map(|(id, _)| id).collect();
        theirs.into_iter().try_for_each(|id| state.remove_buffer(id))?;
        state.vulkan = None;
        Ok(())
    })
}

/// Returns pipeline cache data for the next run's crumple_vulkan_attach(). The size may grow until you have registered
/// every kind of buffer.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn crumple_vulkan_get_pipeline_cache(
    context: *mut CrumpleContext,
    data: *mut c_void,
    capacity: usize,
    out_size: *mut usize,
) -> CrumpleResult {
    exclusive("crumple_vulkan_get_pipeline_cache", context, |_, state| {
        let out = Out::new(out_size, "out_size")?;
        write_array(&attached(state)?.device.device().pipeline_cache_data()?, data.cast::<u8>(), capacity, "data", out)
    })
}

#[unsafe(no_mangle)]
pub extern "C" fn crumple_vulkan_buffer_def_default() -> CrumpleVulkanBufferDef {
    // VK_PIPELINE_STAGE_VERTEX_INPUT_BIT, VK_ACCESS_VERTEX_ATTRIBUTE_READ_BIT.
    let (stages, access) = (0x4, 0x4);
    CrumpleVulkanBufferDef {
        queue_family: u32::MAX,
        before_stages: stages,
        before_access: access,
        after_stages: stages,
        after_access: access,
        scale: CrumpleVec3 { x: 1.0, y: 1.0, z: 1.0 },
        ..zeroed()
    }
}

/// Registers a range of a VkBuffer for an instance's deformed vertices. The first recording writes every vertex. An
/// instance may have several ranges, such as a ring. The first range of a mesh copies the mesh and its examples to a
/// staging buffer, and the next recording copies them to the device; all instances and ranges share them. The VkBuffer
/// must exist until its last range is unregistered and the frames that wrote it are complete. Errors:
/// CRUMPLE_ERROR_INVALID_ARGUMENT (no device, stages of 0, an unsupported format, overlapping attributes, a scale not
/// above 0, a VkBuffer already registered with other values), CRUMPLE_ERROR_WRONG_RULE (lod above 0 with a classic
/// rule), CRUMPLE_ERROR_UNSUPPORTED (normals or tangents that the mesh lacks; more bytes than the device can bind).
#[unsafe(no_mangle)]
pub unsafe extern "C" fn crumple_buffer_register_vulkan(
    context: *mut CrumpleContext,
    instance: CrumpleInstance,
    def: *const CrumpleVulkanBufferDef,
    out_buffer: *mut CrumpleBuffer,
) -> CrumpleResult {
    exclusive("crumple_buffer_register_vulkan", context, |_, state| {
        let (def, out) = (self::def(def, "def")?, Out::new(out_buffer, "out_buffer")?);
        let owner = &state.instances.get(instance, "instance")?.instance;
        let vulkan = state.vulkan.as_mut().ok_or_else(not_attached)?;
        let memory = Memory::Vulkan(vulkan.register(owner, &def)?);
        add_buffer(state, instance, (def.lod, def.user_data), memory, out)
    })
}

/// Records commands that write the deformed vertices of count Vulkan buffers, or of all Vulkan buffers of the context
/// if buffers is null and count 0. For the blocks that changed it records a copy of a few bytes per block, a barrier,
/// one dispatch per VkBuffer and a barrier. It submits nothing, waits for nothing, and does not allocate in steady
/// state. You may change damage right after the call.
///
/// command_buffer is a VkCommandBuffer in the recording state, outside a render pass, of the attached queue family,
/// whose pool no other thread uses. Submit it once, and submit recordings in the order in which they were recorded.
/// frame is your frame number: it starts at 1 and never decreases; recordings may share one. out_report may be null.
///
/// The commands change only the compute pipeline, compute descriptor sets 0 to 2 and the first 28 bytes of push
/// constants for compute. Errors: CRUMPLE_ERROR_INVALID_ARGUMENT (no device of crumple_vulkan_attach(), a buffer twice,
/// a host buffer, a frame that is complete or below the last), CRUMPLE_ERROR_UNSUPPORTED (more work than the device can
/// bind). Nothing was recorded.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn crumple_vulkan_record(
    context: *mut CrumpleContext,
    command_buffer: *mut c_void,
    frame: u64,
    buffers: *const CrumpleBuffer,
    count: u32,
    out_report: *mut CrumpleRecordReport,
) -> CrumpleResult {
    exclusive("crumple_vulkan_record", context, |context, state| {
        let out = Out::optional(out_report, "out_report")?;
        if command_buffer.is_null() {
            return Err(Failure::null("command_buffer"));
        }
        let report = with_device(context, state, (buffers, count), |device, jobs| {
            let commands = vk::CommandBuffer::from_raw(command_buffer.addr() as u64);
            Ok(device.hosts("crumple_vulkan_record()")?.record(commands, frame, jobs)?)
        })?;
        out.answer(report.into())
    })
}

/// Declares that the device has completed frame and all earlier ones, as a fence or timeline semaphore tells you. Their
/// resources are reused or freed. Call it once a frame. A number above the last recorded frame counts as
/// that frame.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn crumple_vulkan_complete_frames(context: *mut CrumpleContext, frame: u64) -> CrumpleResult {
    exclusive("crumple_vulkan_complete_frames", context, |_, state| {
        attached(state)?.device.hosts("crumple_vulkan_complete_frames()")?.completed(frame);
        Ok(())
    })
}

/// Declares that recordings of frame and later frames will not be submitted. The next recording writes every vertex of
/// their buffers.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn crumple_vulkan_discard_frames(context: *mut CrumpleContext, frame: u64) -> CrumpleResult {
    exclusive("crumple_vulkan_discard_frames", context, |_, state| {
        attached(state)?.device.hosts("crumple_vulkan_discard_frames()")?.discard(frame);
        for (_, entry) in state.buffers.iter_mut() {
            if let Memory::Vulkan(target) = &mut entry.memory
                && target.written_in() >= frame
            {
                target.invalidate();
            }
        }
        Ok(())
    })
}

#[unsafe(no_mangle)]
pub extern "C" fn crumple_vulkan_open_def_default() -> CrumpleVulkanOpenDef {
    CrumpleVulkanOpenDef { workgroup_size: 128, ..zeroed() }
}

/// Creates a Vulkan device of Crumple's own, for engines that can share memory but cannot hand out a command buffer.
/// It may take long. Use it instead of crumple_vulkan_attach(): import buffers, register them,
/// and write them with crumple_vulkan_submit(). crumple_vulkan_detach() and crumple_context_destroy() wait for the
/// device and destroy it. Errors: CRUMPLE_ERROR_INVALID_ARGUMENT (a device is already attached, a bad workgroup_size),
/// CRUMPLE_ERROR_UNSUPPORTED (no such device, or one that cannot import memory).
#[unsafe(no_mangle)]
pub unsafe extern "C" fn crumple_vulkan_open(
    context: *mut CrumpleContext,
    def: *const CrumpleVulkanOpenDef,
) -> CrumpleResult {
    exclusive("crumple_vulkan_open", context, |_, state| {
        let def = self::def(def, "def")?;
        attach(state, (def.pipeline_cache, def.pipeline_cache_size), |cache| Kind::open(&def, cache))
    })
}

#[unsafe(no_mangle)]
pub extern "C" fn crumple_vulkan_import_def_default() -> CrumpleVulkanImportDef {
    CrumpleVulkanImportDef { handle: -1, ..zeroed() }
}

/// Imports a buffer of your device into Crumple's device. Use out_buffer as the buffer field of CrumpleVulkanBufferDef;
/// its buffer_size, usage, queue_family, stages and accesses are then ignored. Before each submit, release the VkBuffer
/// to VK_QUEUE_FAMILY_EXTERNAL on your queue. Acquire it afterwards. The memory must exist until
/// crumple_vulkan_unimport_buffer(), crumple_vulkan_detach() or crumple_context_destroy(). Errors:
/// CRUMPLE_ERROR_INVALID_ARGUMENT (no device of crumple_vulkan_open(), a bad handle, an unsuitable memory type or
/// usage), CRUMPLE_ERROR_UNSUPPORTED (a handle type of another system, or a buffer that the device cannot import).
#[unsafe(no_mangle)]
pub unsafe extern "C" fn crumple_vulkan_import_buffer(
    context: *mut CrumpleContext,
    def: *const CrumpleVulkanImportDef,
    out_buffer: *mut u64,
) -> CrumpleResult {
    exclusive("crumple_vulkan_import_buffer", context, |_, state| {
        let (def, out) = (self::def(def, "def")?, Out::new(out_buffer, "out_buffer")?);
        out.answer(attached(state)?.import_buffer(&def)?)
    })
}

/// Releases an imported buffer once the device is done with it. CRUMPLE_ERROR_INVALID_ARGUMENT: it still has ranges.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn crumple_vulkan_unimport_buffer(context: *mut CrumpleContext, buffer: u64) -> CrumpleResult {
    exclusive("crumple_vulkan_unimport_buffer", context, |_, state| attached(state)?.release_buffer(buffer))
}

/// Imports a binary semaphore of your device, exported with this handle type. Pass out_semaphore to
/// crumple_vulkan_submit(). It lives until crumple_vulkan_detach() or crumple_context_destroy(). Errors:
/// CRUMPLE_ERROR_INVALID_ARGUMENT (no device of crumple_vulkan_open(), a bad handle), CRUMPLE_ERROR_UNSUPPORTED (a
/// driver without external semaphores; use fences and crumple_vulkan_wait_frame()).
#[unsafe(no_mangle)]
pub unsafe extern "C" fn crumple_vulkan_import_semaphore(
    context: *mut CrumpleContext,
    handle_type: MaybeUninit<CrumpleHandleType>,
    handle: i64,
    out_semaphore: *mut u64,
) -> CrumpleResult {
    exclusive("crumple_vulkan_import_semaphore", context, |_, state| {
        let out = Out::new(out_semaphore, "out_semaphore")?;
        let shared = shared(enumerator(handle_type, "handle_type")?, handle);
        let own = attached(state)?.device.own("crumple_vulkan_import_semaphore()")?;
        out.answer(own.import_semaphore(shared)?.0)
    })
}

/// Like crumple_vulkan_record(), but submits the work to Crumple's own device. The device first waits for the
/// wait_count semaphores at waits, and last signals the signal_count semaphores at signals, even without changes. The
/// call itself does not wait. out_frame receives the frame number for crumple_vulkan_wait_frame(). out_frame and
/// out_report may be null. After an error nothing was submitted.
#[unsafe(no_mangle)]
#[allow(clippy::too_many_arguments)] // three arrays
pub unsafe extern "C" fn crumple_vulkan_submit(
    context: *mut CrumpleContext,
    buffers: *const CrumpleBuffer,
    count: u32,
    waits: *const u64,
    wait_count: u32,
    signals: *const u64,
    signal_count: u32,
    out_frame: *mut u64,
    out_report: *mut CrumpleRecordReport,
) -> CrumpleResult {
    exclusive("crumple_vulkan_submit", context, |context, state| {
        let outs = (Out::optional(out_frame, "out_frame")?, Out::optional(out_report, "out_report")?);
        let waits = array(waits, wait_count as usize, "waits")?;
        let signals = array(signals, signal_count as usize, "signals")?;
        let ids = |all: &[u64]| all.iter().map(|id| SemaphoreId(*id)).collect::<Vec<_>>();
        let (frame, report) = with_device(context, state, (buffers, count), |device, jobs| {
            Ok(device.own("crumple_vulkan_submit()")?.submit(jobs, &ids(waits), &ids(signals))?)
        })?;
        outs.0.write(frame);
        outs.1.answer(report.into())
    })
}

/// Waits until Crumple's own device has completed a frame and all earlier ones, at most timeout nanoseconds
/// (UINT64_MAX: no limit). out_done receives whether the frame is complete. The context is in use while the call waits.
/// CRUMPLE_ERROR_INVALID_ARGUMENT: the frame was not submitted.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn crumple_vulkan_wait_frame(
    context: *mut CrumpleContext,
    frame: u64,
    timeout: u64,
    out_done: *mut bool,
) -> CrumpleResult {
    exclusive("crumple_vulkan_wait_frame", context, |_, state| {
        let out = Out::new(out_done, "out_done")?;
        out.answer(attached(state)?.device.own("crumple_vulkan_wait_frame()")?.wait(frame, timeout)?)
    })
}

/// Attaches the device that `make` makes with the data of a pipeline cache.
unsafe fn attach(
    state: &mut State,
    (cache, size): (*const c_void, usize),
    make: impl FnOnce(&[u8]) -> Result<Kind, Failure>,
) -> Result<(), Failure> {
    if state.vulkan.is_some() {
        return Err(Failure::invalid("a device is attached already; crumple_vulkan_detach() first"));
    }
    state.vulkan = Some(Attached::new(make(array(cache.cast::<u8>(), size, "def.pipeline_cache")?)?));
    Ok(())
}

/// Calls `f` with the device and a job for each of the chosen buffers.
unsafe fn with_device<R>(
    context: &Context,
    state: &mut State,
    given: (*const CrumpleBuffer, u32),
    f: impl FnOnce(&mut Kind, &mut [Job<'_, Target>]) -> Result<R, Failure>,
) -> Result<R, Failure> {
    let State { instances, buffers: entries, vulkan, vulkan_jobs, vertex_budget, .. } = state;
    let device = &mut vulkan.as_mut().ok_or_else(not_attached)?.device;
    device.device().set_vertex_budget(*vertex_budget);
    with_jobs(&context.tasks, (instances, entries), vulkan_jobs, given, |jobs| f(device, jobs))
}

fn attached(state: &mut State) -> Result<&mut Attached, Failure> {
    state.vulkan.as_mut().ok_or_else(not_attached)
}

fn not_attached() -> Failure {
    Failure::invalid("no Vulkan device is attached; crumple_vulkan_attach() or crumple_vulkan_open() first")
}
