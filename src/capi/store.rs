//! What a context holds: example sets, instances and buffers, by id.

use super::device::Attached;
use super::graph_types::GraphState;
use super::ids::Slots;
use super::memory::HostMemory;
use super::result::Failure;
use super::types::{CrumpleBuffer, CrumpleExampleSet, CrumpleInstance};
use crate::deform::Tracker;
use crate::example::set::ExampleSet;
use crate::gpu::Job;
use crate::instance::Instance;
use crate::instance::deform::DeformJob;
use std::ffi::{CString, c_char};
use std::sync::Arc;

/// What contexts keep of a set.
pub(super) struct SetEntry {
    pub(super) set: Arc<ExampleSet>,
    /// The mesh's name in the file it came from.
    pub(super) name: CString,
    /// The examples' names.
    pub(super) names: Vec<CString>,
    pub(super) primitives: Vec<CrumplePrimitive>,
    /// The parts of a glTF body: lods 1 and up.
    pub(super) parts: Vec<CrumplePart>,
    /// What primitives and parts point to.
    #[cfg(feature = "gltf")]
    pub(super) texts: Vec<CString>,
    pub(super) node_transform: [f32; 16],
}

// SAFETY: its pointers are to strings that it owns and does not change.
unsafe impl Send for SetEntry {}
// SAFETY: as above.
unsafe impl Sync for SetEntry {}

/// A stretch of the mesh with one material. material is its name (UTF-8, valid until the set is destroyed) or null.
#[repr(C)]
#[derive(Debug, Clone, Copy)]
pub struct CrumplePrimitive {
    pub material: *const c_char,
    pub first_vertex: u32,
    pub vertex_count: u32,
    /// First triangle. Its first index is 3 * first_triangle.
    pub first_triangle: u32,
    pub triangle_count: u32,
    pub reserved: [u32; 2],
}

/// What a part of a body does when it is hit.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[allow(dead_code)] // made with glTF
pub enum CrumplePartKind {
    /// It dents.
    Dents = 0,
    /// It never moves, such as a wheel.
    Rigid = 1,
    /// It follows dents around it. See crumple_instance_set_part_rigid().
    Glass = 2,
}

/// A part of a body that was loaded with join_nodes. It is a mesh of its own, and a stretch of the base mesh with the same
/// vertices and triangles in the same order.
#[repr(C)]
#[derive(Debug, Clone, Copy)]
pub struct CrumplePart {
    /// As crumple_example_set_find_part() takes it, UTF-8, valid until the set is destroyed. Never null.
    pub name: *const c_char,
    pub kind: CrumplePartKind,
    pub first_vertex: u32,
    pub vertex_count: u32,
    /// First triangle. Its first index is 3 * first_triangle.
    pub first_triangle: u32,
    pub triangle_count: u32,
    pub reserved: [u32; 3],
}

impl SetEntry {
    /// A set that came without a file's names: one primitive, and no parts.
    pub(super) fn new(set: ExampleSet) -> Self {
        let whole = CrumplePrimitive {
            material: std::ptr::null(),
            first_vertex: 0,
            vertex_count: set.vertex_count() as u32,
            first_triangle: 0,
            triangle_count: set.mesh().triangles().len() as u32,
            reserved: [0; 2],
        };
        SetEntry {
            name: CString::default(),
            names: set.examples().iter().map(|example| c_string(example.name())).collect(),
            primitives: vec![whole],
            parts: Vec::new(),
            #[cfg(feature = "gltf")]
            texts: Vec::new(),
            node_transform: glam::Mat4::IDENTITY.to_cols_array(),
            set: Arc::new(set),
        }
    }
}

/// A text of any origin as one that C can read.
pub(super) fn c_string(text: &str) -> CString {
    CString::new(text.replace('\0', "\u{fffd}")).unwrap_or_default()
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
    Vulkan(crate::vulkan::Target),
    Graph(crate::graph::Target),
}

impl Memory {
    /// The error of a call that does not write this kind of buffer.
    pub(super) fn written_elsewhere(&self, name: &str) -> Failure {
        let what = match self {
            Memory::Host(..) => "is a host buffer; crumple_context_deform() writes those",
            Memory::Vulkan(_) => "is a Vulkan buffer; crumple_vulkan_record() writes those",
            Memory::Graph(_) => "is a buffer of a render graph; crumple_graph_plan() writes those",
        };
        Failure::invalid(format!("{name} {what}"))
    }

    /// What the memory holds, and what the last deform or recording wrote.
    pub(super) fn tracker(&self) -> &Tracker {
        match self {
            Memory::Host(_, tracker) => tracker,
            Memory::Vulkan(target) => &target.state.tracker,
            Memory::Graph(target) => &target.state.tracker,
        }
    }

    /// Forgets what the memory holds.
    pub(super) fn invalidate(&mut self) {
        match self {
            Memory::Host(_, tracker) => tracker.invalidate(),
            Memory::Vulkan(target) => target.invalidate(),
            Memory::Graph(target) => target.invalidate(),
        }
    }
}

pub(super) type Instances = Slots<CrumpleInstance, InstanceEntry>;
pub(super) type Buffers = Slots<CrumpleBuffer, BufferEntry>;

/// The room for a call's lists of buffers and of jobs, which is kept between frames.
pub(super) struct JobList<J> {
    pub(super) chosen: Vec<CrumpleBuffer>,
    /// Empty between calls.
    pub(super) jobs: Vec<J>,
}

impl<J> Default for JobList<J> {
    fn default() -> Self {
        JobList { chosen: Vec::new(), jobs: Vec::new() }
    }
}

/// What only one thread may touch at a time.
pub(super) struct State {
    pub(super) sets: Slots<CrumpleExampleSet, Arc<SetEntry>>,
    pub(super) instances: Instances,
    pub(super) buffers: Buffers,
    /// The most vertices that a call writes.
    pub(super) vertex_budget: u64,
    /// The time for dents that grow, s.
    pub(super) time: f64,
    pub(super) host_jobs: JobList<DeformJob<'static, 'static>>,
    pub(super) vulkan: Option<Attached>,
    pub(super) vulkan_jobs: JobList<Job<'static, crate::vulkan::Target>>,
    pub(super) graph: GraphState,
    pub(super) graph_jobs: JobList<Job<'static, crate::graph::Target>>,
}

impl State {
    /// Nothing; `tag` is the context's in its ids.
    pub(super) fn new(tag: u16) -> Self {
        Self {
            sets: Slots::new(tag),
            instances: Slots::new(tag),
            buffers: Slots::new(tag),
            vertex_budget: u64::MAX,
            time: 0.0,
            host_jobs: JobList::default(),
            vulkan: None,
            vulkan_jobs: JobList::default(),
            graph: GraphState::default(),
            graph_jobs: JobList::default(),
        }
    }

    /// An instance, by the argument `instance`.
    pub(super) fn body(&mut self, instance: CrumpleInstance) -> Result<&mut Instance, Failure> {
        Ok(&mut self.instances.get_mut(instance, "instance")?.instance)
    }

    /// Removes a buffer, also from those of its owner, if that is still there.
    pub(super) fn remove_buffer(&mut self, buffer: CrumpleBuffer) -> Result<(), Failure> {
        let entry = self.buffers.remove(buffer, "buffer")?;
        if let Ok(owner) = self.instances.get_mut(entry.owner, "instance") {
            owner.buffers.retain(|b| *b != buffer);
        }
        if let (Memory::Vulkan(target), Some(vulkan)) = (entry.memory, &mut self.vulkan) {
            vulkan.remove(target)?;
        }
        Ok(())
    }
}
