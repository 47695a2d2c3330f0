//! The data of a frame as words, and the calls of its dispatches.

use super::wgpu_device::WgpuDevice;
use crate::base::error::Error;
use crate::gpu::Plan;

/// The lists of an encoding. They are reused.
#[derive(Default)]
pub(super) struct FrameEncoding {
    pub plan: Plan<u64>,
    /// The frame's data, and behind it a call for each dispatch.
    pub words: Vec<u32>,
    pub calls: Vec<EncodedCall>,
}

/// A dispatch's call and size.
pub(super) struct EncodedCall {
    /// Bytes before the call in the words.
    pub at: u32,
    /// Workgroups in a row, and rows.
    pub groups: [u32; 2],
}

impl FrameEncoding {
    /// Writes the frame's data into words, and a call for each dispatch behind it.
    pub(super) fn write(&mut self, gpu: &WgpuDevice, workgroup: u32) -> Result<(), Error> {
        let offsets = self.plan.offsets()?;
        let align = gpu.limits.min_uniform_buffer_offset_alignment.max(4) as usize / 4;
        let most = gpu.limits.max_compute_workgroups_per_dimension;
        self.words.clear();
        self.words.resize(offsets.words(), 0);
        self.plan.write(&mut self.words);
        self.calls.clear();
        for d in self.plan.dispatches() {
            let (call, groups) = offsets.call(&d.blocks, d.variant.vertices(workgroup), most);
            self.words.resize(self.words.len().next_multiple_of(align), 0);
            self.calls.push(EncodedCall { at: (4 * self.words.len()) as u32, groups });
            self.words.extend_from_slice(bytemuck::cast_slice(&[call]));
        }
        Ok(())
    }
}
