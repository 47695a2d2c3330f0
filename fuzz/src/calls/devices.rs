//! Calls of render graphs, and of Vulkan without a device. Calls that need nothing.

use std::ffi::CStr;
use std::mem::MaybeUninit;
use std::ptr::{null, null_mut};

use crumple::entry_points::*;

use super::arguments::enumerator;
use super::{Host, Step, answered};

impl Host<'_> {
    /// A range for 200 vertices: interleaved values of one format for each attribute, or of any.
    fn device_buffer_def(&mut self) -> Step<CrumpleVulkanBufferDef> {
        // R32G32B32_SFLOAT, R32G32B32A32_SFLOAT, R16G16B16A16_SFLOAT, R16G16B16A16_SNORM, R8G8B8A8_SNORM, R16G16_UNORM,
        // R8G8B8A8_UNORM.
        const FORMATS: [u32; 7] = [106, 109, 97, 92, 38, 77, 37];
        const STRIDE: u64 = 40;
        let present = self.bytes.arbitrary::<u8>()?;
        let any = self.bytes.ratio(1, 2)?;
        let mut stream = |bit: u8, offset: u64, format: u32| {
            let format = if any { FORMATS[self.bytes.choose_index(FORMATS.len())?] } else { format };
            let stream = CrumpleVulkanStream { offset, stride: STRIDE, format, reserved: 0 };
            Ok(if present & bit != 0 { stream } else { CrumpleVulkanStream::default() })
        };
        let mut def = crumple_vulkan_buffer_def_default();
        (def.positions, def.normals) = (stream(!2, 0, 106)?, stream(2, 12, 106)?);
        def.tangents = stream(4, 24, 109)?;
        def.size = 200 * STRIDE;
        (def.buffer, def.buffer_size) = (1 + u64::from(present >> 6), 2 * def.size);
        def.offset = if self.bytes.arbitrary()? { def.size } else { 0 };
        self.patched(def)
    }

    /// Plans a frame, and checks that all of it lies in the memory that it names.
    ///
    /// # Safety
    /// None is needed; the calls in it are unsafe.
    unsafe fn plan(&mut self, context: *mut CrumpleContext) -> Step<CrumpleResult> {
        let ids = if self.bytes.ratio(1, 2)? { Vec::new() } else { self.some(Self::buffer)? };
        let list = if ids.is_empty() { null() } else { ids.as_ptr() };
        let (mut plan, mut report) = (MaybeUninit::<CrumpleGraphPlan>::uninit(), MaybeUninit::uninit());
        let result = crumple_graph_plan(context, list, ids.len() as u32, plan.as_mut_ptr(), report.as_mut_ptr());
        if result == CrumpleResult::CrumpleOk {
            let plan = plan.assume_init();
            // Another thread's calls do not change a plan.
            for upload in std::slice::from_raw_parts(plan.uploads, plan.upload_count as usize) {
                assert!(upload.offset + upload.size as u64 <= upload.storage_size, "{upload:?}");
                std::hint::black_box(std::slice::from_raw_parts(upload.data.cast::<u8>(), upload.size).to_vec());
            }
            for dispatch in std::slice::from_raw_parts(plan.dispatches, plan.dispatch_count as usize) {
                let mut size = 0;
                assert!(answered(crumple_graph_get_kernel(dispatch.kernel, null_mut(), 0, &mut size)), "{dispatch:?}");
                assert!(size > 0 && plan.work_size > 0 && !dispatch.groups.contains(&0), "{dispatch:?}");
            }
        }
        Ok(result)
    }

    /// # Safety
    /// None is needed; the calls in it are unsafe. No device is ever attached, so no handle is used.
    pub(super) unsafe fn device_call(&mut self, call: u8) -> Step<CrumpleResult> {
        let context = self.context()?;
        Ok(match call {
            0..=3 => {
                let (id, def, mut new) = (self.instance()?, self.device_buffer_def()?, CrumpleBuffer::default());
                let result = crumple_buffer_register_graph(context, id, &def, &mut new);
                self.buffers.push(new);
                result
            }
            4..=7 => return self.plan(context),
            8 => {
                let (kernel, mut words, mut size) = (self.word()?, vec![0u8; 64 << 10], 0);
                let capacity = words.len() >> (self.bytes.arbitrary::<u8>()? & 15);
                crumple_graph_get_kernel(kernel, words.as_mut_ptr().cast(), capacity, &mut size)
            }
            9 => {
                let mut def = crumple_vulkan_attach_def_default();
                (def.queue_family, def.workgroup_size) = (self.word()?, self.word()?);
                crumple_vulkan_attach(context, &def)
            }
            10 => {
                let def = CrumpleVulkanOpenDef { workgroup_size: self.word()?, ..crumple_vulkan_open_def_default() };
                crumple_vulkan_open(context, &def)
            }
            11 => {
                let (id, def) = (self.instance()?, self.device_buffer_def()?);
                crumple_buffer_register_vulkan(context, id, &def, &mut CrumpleBuffer::default())
            }
            12 => {
                let def = self.patched(crumple_vulkan_import_def_default())?;
                let (mut buffer, mut semaphore) = (0, 0);
                answered(crumple_vulkan_import_buffer(context, &def, &mut buffer));
                answered(crumple_vulkan_unimport_buffer(context, u64::from(self.word()?)));
                crumple_vulkan_import_semaphore(context, enumerator(self.word()?), -1, &mut semaphore)
            }
            13 => {
                let (ids, frame) = (self.some(Self::buffer)?, u64::from(self.word()?));
                let (list, count) = (ids.as_ptr(), ids.len() as u32);
                answered(crumple_vulkan_record(context, null_mut(), frame, list, count, null_mut()));
                crumple_vulkan_submit(context, list, count, null(), 0, null(), 0, null_mut(), null_mut())
            }
            14 => {
                let frame = u64::from(self.word()?);
                answered(crumple_vulkan_complete_frames(context, frame));
                answered(crumple_vulkan_discard_frames(context, frame));
                crumple_vulkan_wait_frame(context, frame, 0, MaybeUninit::uninit().as_mut_ptr())
            }
            15 => {
                answered(crumple_vulkan_get_pipeline_cache(context, null_mut(), 0, &mut 0));
                crumple_vulkan_detach(context)
            }
            16 => {
                // This build has no allocator of the host, so the def is not used.
                let def = crumple_allocator_def_default();
                crumple_allocator_set(if self.bytes.arbitrary()? { &def } else { null() })
            }
            _ => {
                for text in [crumple_result_name(enumerator(self.word()?)), crumple_version_string()] {
                    assert!(!CStr::from_ptr(text).is_empty());
                }
                assert!(crumple_version() > 0 && crumple_features() > 0);
                CrumpleResult::CrumpleOk
            }
        })
    }
}
