//! Deformation in a render graph of the host that takes SPIR-V, such as Godot's `RenderingDevice`. The host makes buffers,
//! pipelines and passes with its own interface. Crumple returns what to upload and what to dispatch.
//!
//! 1. [`kernel`] returns a compute shader as SPIR-V. All kernels have the same bindings:
//!
//!    | set | binding | contents |
//!    |---|---|---|
//!    | 0 | 0 | a storage of Crumple's, which the host makes: meshes and examples |
//!    | 0 | 1 | the work of the frame |
//!    | 1 | 0 | the host's vertex buffer, from its first byte on |
//!
//!    All three are storage buffers. There are 32 bytes of push constants.
//! 2. [`Graph::add_target`] says where in a buffer the vertices of one mesh lie, and in which formats.
//! 3. [`Graph::plan`] returns the passes that bring targets up to date. Call it once a frame.
//!
//! The kernels are those of [`crate::vulkan`], and so are the vertices. Classic rules are not supported.

pub use crate::gpu::{FrameReport, Job, Target as AnyTarget};
pub use ash::vk::Format;

use crate::base::error::Error;
use crate::example::set::ExampleSet;
use crate::gpu::{self, Arena, BindingLimits, Call, Plan, Variant, VertexStream, compiled};
use std::convert::Infallible;
use std::sync::Arc;

/// Invocations a workgroup. Every Vulkan device supports it.
const WORKGROUP: u32 = 128;
/// The most workgroups in a row. Every Vulkan device supports it.
const MOST_GROUPS: u32 = 65535;
/// The largest storage that every Vulkan device can bind.
const STORAGE: BindingLimits =
    BindingLimits { bytes: 128 << 20, name: "the least maxStorageBufferRange of Vulkan", alignment: 4 };

/// Returns the SPIR-V of a kernel; its entry point is `main`. A kernel's number is that of [`Dispatch::kernel`]. `None` for
/// a number above the last.
pub fn kernel(number: u32) -> Option<Vec<u32>> {
    Some(compiled(Variant::all().nth(number as usize)?, WORKGROUP))
}

/// A vertex buffer of the host's render graph.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct GraphBuffer {
    /// The host's number for it.
    pub number: u64,
    /// Its size in bytes.
    pub size: u64,
}

/// Where a buffer stores the vertices of one mesh.
pub type TargetDef = gpu::TargetDef<GraphBuffer, Format>;

/// Where a buffer stores one attribute of the vertices.
pub type Stream = VertexStream<Format>;

/// A mesh's vertices in a buffer, and what they show. Drop it to end it.
pub type Target = gpu::Target<u64, Infallible>;

/// Bytes to copy into a storage before the dispatches.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Upload {
    /// Number of the storage. Make a buffer of `storage_size` bytes when you first see a number. Numbers are not reused.
    pub storage: u32,
    /// Size of the storage in bytes.
    pub storage_size: u64,
    /// Where the words go, in bytes from the storage's start.
    pub offset: u64,
    /// What to copy.
    pub words: Vec<u32>,
}

/// A dispatch. It reads the storage and the work, and reads and writes the vertex buffer.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Dispatch {
    /// Number of the kernel, for [`kernel`].
    pub kernel: u32,
    /// Number of the storage to bind.
    pub storage: u32,
    /// Number of the vertex buffer to bind ([`GraphBuffer::number`]).
    pub buffer: u64,
    /// Workgroups along x and y; 1 along z.
    pub groups: [u32; 2],
    /// The push constants. Kernels read the first seven; some hosts, such as Godot, take multiples of 16 bytes only.
    pub constants: [u32; 8],
}

/// The passes of a frame.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct Passes {
    /// Storages that no later plan names. The host may free them once earlier frames are done. It may not know all of them.
    pub freed: Vec<u32>,
    /// Copies to storages. They are due even if the host drops the dispatches.
    pub uploads: Vec<Upload>,
    /// The work of the frame. Bind it as it is in a buffer of any size.
    pub work: Vec<u32>,
    /// Dispatches, in any order: they write different vertices. If the host drops one, it calls [`Target::invalidate`] on the
    /// targets in that buffer.
    pub dispatches: Vec<Dispatch>,
}

/// Plans passes for a host's render graph.
#[derive(Debug)]
pub struct Graph {
    /// The sizes of the storages in bytes.
    arena: Arena<u64>,
    plan: Plan<u64>,
    passes: Passes,
    /// The next passes: so far uploads, and storages that are no longer needed.
    next: Passes,
}

impl Default for Graph {
    fn default() -> Self {
        let (passes, next) = Default::default();
        Graph { arena: Arena::new(), plan: Plan::new(WORKGROUP, MOST_GROUPS), passes, next }
    }
}

impl Graph {
    /// Sets the most vertices that a plan writes; see [`crate::deform_within`]. At first there is no limit (`u64::MAX`).
    pub fn set_vertex_budget(&mut self, vertices: u64) {
        self.plan.budget = vertices;
    }

    /// Adds a target: a place for the vertices of one of the set's meshes. The first target of a mesh adds uploads to the
    /// next plan.
    ///
    /// # Errors
    /// [`Error::InvalidArgument`] for a format that the attribute cannot have, a stride that is too small, attributes that
    /// overlap, or a bad scale; [`Error::Misaligned`] for offsets and strides that are not multiples of 4;
    /// [`Error::BufferTooSmall`]; [`Error::IndexOutOfRange`] for a level of detail that the set lacks; [`Error::Unsupported`]
    /// for normals or tangents that the mesh lacks, or a mesh with examples of more than 128 MiB; [`Error::OutOfMemory`].
    pub fn add_target(&mut self, set: &Arc<ExampleSet>, def: &TargetDef) -> Result<Target, Error> {
        let mesh = set.lod(def.lod)?;
        let (layout, _) = def.layout(&mesh.mesh, def.buffer.size)?;
        self.free_meshes();
        let uploads = &mut self.next.uploads;
        uploads.try_reserve(1).map_err(|_| Error::OutOfMemory { what: "one more upload".into(), bytes: 0 })?;
        let mesh = self.arena.mesh((set, def.lod), &STORAGE, Ok, |storage_size, mesh, words| {
            let (storage, storage_size, offset) = (mesh.chunk, *storage_size, mesh.offset());
            uploads.push(Upload { storage, storage_size, offset, words });
            Ok(())
        })?;
        Ok(Target::new(self.plan.id, (layout, def.offset), mesh, (def.buffer.number, ())))
    }

    /// Plans what brings the targets up to date: only the blocks that changed since each was last written. If nothing
    /// changed, there are no dispatches.
    ///
    /// # Errors
    /// [`Error::InvalidArgument`] for a target of another graph or set; [`Error::WrongRule`] for an instance with a classic
    /// rule; [`Error::Unsupported`] for more than 4 GiB of work. After an error targets hold what they held, and the next
    /// plan has the uploads.
    pub fn plan(&mut self, jobs: &mut [Job<'_, Target>]) -> Result<(FrameReport, &Passes), Error> {
        self.plan.check(jobs)?;
        jobs.iter().try_for_each(|job| job.instance.only_marks("a target of a render graph"))?;
        self.free_meshes();
        let mut report = self.plan.fill(jobs)?;
        let Passes { uploads, work, dispatches, .. } = &mut self.next;
        work.clear();
        dispatches.clear();
        if report.blocks_written > 0 {
            let (words, bytes) = (self.plan.words, 4 * self.plan.words as u64);
            let failed = |_| Error::OutOfMemory { what: "the work of a frame".into(), bytes };
            work.try_reserve(words).map_err(failed)?;
            work.resize(words, 0);
            self.plan.write(jobs, work);
            for d in &self.plan.dispatches {
                let mut constants = [0; 8];
                constants[..7].copy_from_slice(&bytemuck::cast::<Call, [u32; 7]>(d.call));
                let (kernel, storage, buffer, groups) = (d.variant.number(), d.key.chunk, d.key.binding, d.groups);
                dispatches.push(Dispatch { kernel, storage, buffer, groups, constants });
            }
        }
        let uploaded: usize = uploads.iter().map(|upload| upload.words.len()).sum();
        report.bytes_copied = 4 * (uploaded + work.len()) as u64;
        report.vertices_written = self.plan.commit(jobs, 0);
        std::mem::swap(&mut self.passes, &mut self.next);
        self.next.uploads.clear();
        self.next.freed.clear();
        Ok((report, &self.passes))
    }

    /// Frees meshes that no target shows.
    fn free_meshes(&mut self) {
        let Graph { arena, next: Passes { uploads, freed, .. }, .. } = self;
        arena.collect(0, |storage| {
            freed.push(storage);
            uploads.retain(|upload| upload.storage != storage);
        });
    }
}
