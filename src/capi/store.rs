//! What a context holds: example sets, instances and buffers, by id.

#[cfg(feature = "vulkan")]
use super::device::{Attached, VulkanMemory};
#[cfg(feature = "vulkan")]
use super::graph_types::GraphState;
use super::host_memory::HostMemory;
use super::ids::Slots;
use super::primitive::{CrumplePrimitive, PartEntry};
use super::result::Failure;
use super::types::{CrumpleBuffer, CrumpleExampleSet, CrumpleInstance};
use crate::base::math::Aabb;
use crate::deform::Tracker;
use crate::example::set::ExampleSet;
use crate::instance::Instance;
use crate::instance::deform::DeformJob;
use std::ffi::CString;
use std::ops::Range;
use std::sync::Arc;

/// What a context keeps of a set.
pub(super) struct SetEntry {
    pub(super) set: Arc<ExampleSet>,
    /// The mesh's name in the file it came from.
    pub(super) name: CString,
    /// The examples' names.
    pub(super) names: Vec<CString>,
    pub(super) primitives: Vec<CrumplePrimitive>,
    /// What `primitives` points to.
    pub(super) materials: Vec<CString>,
    pub(super) node_transform: Option<[f32; 16]>,
    /// The parts of a glTF body: lods 1 and up.
    pub(super) parts: Vec<PartEntry>,
}

impl SetEntry {
    /// The same set for another context.
    pub(super) fn shared(&self) -> Self {
        let materials = self.materials.clone();
        let moved = |primitive: &CrumplePrimitive| {
            let at = self.materials.iter().position(|material| material.as_ptr() == primitive.material);
            CrumplePrimitive { material: at.map_or(std::ptr::null(), |at| materials[at].as_ptr()), ..*primitive }
        };
        SetEntry {
            set: self.set.clone(),
            name: self.name.clone(),
            names: self.names.clone(),
            primitives: self.primitives.iter().map(moved).collect(),
            materials,
            node_transform: self.node_transform,
            parts: self.parts.clone(),
        }
    }
}

/// What a context keeps of an instance.
pub(super) struct InstanceEntry {
    pub(super) instance: Instance,
    pub(super) set: CrumpleExampleSet,
    pub(super) buffers: Vec<CrumpleBuffer>,
    pub(super) user_data: u64,
}

/// What a context keeps of a buffer.
pub(super) struct BufferEntry {
    pub(super) owner: CrumpleInstance,
    pub(super) lod: usize,
    pub(super) memory: Memory,
    pub(super) user_data: u64,
    /// Whether the last deform, or recording, of any buffer included this one.
    pub(super) included: bool,
}

/// Where a buffer's vertices are.
pub(super) enum Memory {
    Host(HostMemory, Tracker),
    #[cfg(feature = "vulkan")]
    Vulkan(VulkanMemory),
    #[cfg(feature = "vulkan")]
    Graph(crate::graph::Target),
}

impl Memory {
    /// The error of a call that does not write this kind of buffer.
    pub(super) fn written_elsewhere(&self, name: &str) -> Failure {
        let what = match self {
            Memory::Host(..) => "is a host buffer; crumple_context_deform() writes those",
            #[cfg(feature = "vulkan")]
            Memory::Vulkan(_) => "is a Vulkan buffer; crumple_vulkan_record() writes those",
            #[cfg(feature = "vulkan")]
            Memory::Graph(_) => "is a buffer of a render graph; crumple_graph_plan() writes those",
        };
        Failure::invalid(format!("{name} {what}"))
    }
}

impl BufferEntry {
    pub(super) fn new(owner: CrumpleInstance, lod: u32, memory: Memory, user_data: u64) -> Self {
        BufferEntry { owner, lod: lod as usize, memory, user_data, included: false }
    }

    pub(super) fn invalidate(&mut self) {
        match &mut self.memory {
            Memory::Host(_, tracker) => tracker.invalidate(),
            #[cfg(feature = "vulkan")]
            Memory::Vulkan(memory) => memory.invalidate(),
            #[cfg(feature = "vulkan")]
            Memory::Graph(target) => target.invalidate(),
        }
    }

    /// What the last deform or recording wrote.
    pub(super) fn changed(&self) -> &[Range<u32>] {
        match &self.memory {
            Memory::Host(_, tracker) => tracker.changed(),
            #[cfg(feature = "vulkan")]
            Memory::Vulkan(memory) => memory.changed(),
            #[cfg(feature = "vulkan")]
            Memory::Graph(target) => target.changed(),
        }
    }

    pub(super) fn bounds(&self) -> Option<Aabb> {
        match &self.memory {
            Memory::Host(_, tracker) => tracker.bounds(),
            #[cfg(feature = "vulkan")]
            Memory::Vulkan(memory) => memory.bounds(),
            #[cfg(feature = "vulkan")]
            Memory::Graph(target) => target.bounds(),
        }
    }
}

/// What only one thread may touch at a time.
pub(super) struct State {
    pub(super) sets: Slots<SetEntry>,
    pub(super) instances: Slots<InstanceEntry>,
    pub(super) buffers: Slots<BufferEntry>,
    /// 0: none.
    pub(super) vertex_budget: u64,
    /// The time for dents that grow, s.
    pub(super) time: f64,
    /// The room of a deform's list, empty between calls.
    pub(super) jobs: Vec<DeformJob<'static, 'static>>,
    #[cfg(feature = "vulkan")]
    pub(super) vulkan: Option<Attached>,
    #[cfg(feature = "vulkan")]
    pub(super) graph: GraphState,
}

impl State {
    /// Nothing; `tag` is the context's in its ids.
    pub(super) fn new(tag: u16) -> Self {
        Self {
            sets: Slots::new(tag),
            instances: Slots::new(tag),
            buffers: Slots::new(tag),
            vertex_budget: 0,
            time: 0.0,
            jobs: Vec::new(),
            #[cfg(feature = "vulkan")]
            vulkan: None,
            #[cfg(feature = "vulkan")]
            graph: GraphState::default(),
        }
    }

    /// The most vertices that a call writes.
    pub(super) fn vertex_budget(&self) -> u64 {
        if self.vertex_budget == 0 { u64::MAX } else { self.vertex_budget }
    }

    /// Removes a buffer, but not from those of its owner.
    pub(super) fn remove_buffer(&mut self, buffer: CrumpleBuffer) -> Result<CrumpleInstance, Failure> {
        let entry = self.buffers.remove(buffer, "buffer")?;
        #[cfg(feature = "vulkan")]
        if let (Memory::Vulkan(memory), Some(vulkan)) = (entry.memory, &mut self.vulkan) {
            vulkan.remove(memory)?;
        }
        Ok(entry.owner)
    }
}
