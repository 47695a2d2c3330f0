//! Baked sets: a file that holds an example set made ready, so that loading it rebuilds nothing.
//!
//! A header, a table of sections, and the sections: plain little-endian arrays that are used where they lie. docs/format.md
//! tells every byte. [`read`] finds the sections, [`check`] looks at what is in them, [`load`] makes a set of them, [`write`]
//! is the way back. Whatever a file holds, it becomes a set that keeps the library's promises, or an error.

mod check;
mod load;
mod read;
mod write;

use crate::base::array::FileBytes;
use crate::base::tasks::map;
use crate::{Error, ExampleSet, TaskSystem};
use bytemuck::{Pod, Zeroable};
use std::io::{Read, Write};
use std::path::Path;
use std::sync::Arc;
use xxhash_rust::xxh3::xxh3_64;

/// The first bytes of every file; the last one tells a file that went through a text conversion.
const MAGIC: [u8; 8] = *b"crumple\n";
/// Files of other versions are refused.
const VERSION: u32 = 2;
/// Sections begin at multiples of this; the largest alignment that any element needs is 16.
const ALIGN: usize = 64;
/// What the memory of a file must be a multiple of to be used in place.
const IN_PLACE: usize = 16;
/// Bytes that one hash of the checksum covers.
const CHUNK: usize = 1 << 20;
/// The magic and the checksum itself are not part of the checksum.
const UNHASHED: usize = 16;

/// The first 64 bytes.
#[repr(C)]
#[derive(Debug, Clone, Copy, Pod, Zeroable)]
struct Header {
    magic: [u8; 8],
    checksum: u64,
    /// Bytes of the whole file.
    length: u64,
    version: u32,
    sections: u32,
    zero: [u8; 32],
}

/// One line of the table of sections, which follows the header.
#[repr(C)]
#[derive(Debug, Clone, Copy, Pod, Zeroable)]
struct Entry {
    id: u32,
    /// Which mesh it belongs to, for the sections of meshes; else 0.
    mesh: u32,
    /// From the beginning of the file, a multiple of 64.
    offset: u64,
    /// Bytes.
    length: u64,
    /// Bytes of one element.
    element: u32,
    flags: u32,
}

impl Entry {
    /// A reader that does not know the section may go on without it.
    const OPTIONAL: u32 = 1;
}

/// What a section holds.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
#[repr(u32)]
enum Id {
    Set = 1,
    Examples = 2,
    Names = 3,
    Masses = 4,
    Stamps = 5,
    Nodes = 6,
    Mesh = 16,
    Positions = 17,
    Normals = 18,
    Tangents = 19,
    Triangles = 20,
    Weld = 21,
    ContactNormals = 22,
    RimBlocks = 23,
    RimWindows = 24,
    RimHeld = 25,
    Anchored = 26,
    Heads = 27,
    Words = 28,
    IndexInner = 29,
    IndexLeaves = 30,
    SourceOrder = 64,
}

impl Id {
    const ALL: [Id; 22] = [
        Id::Set,
        Id::Examples,
        Id::Names,
        Id::Masses,
        Id::Stamps,
        Id::Nodes,
        Id::Mesh,
        Id::Positions,
        Id::Normals,
        Id::Tangents,
        Id::Triangles,
        Id::Weld,
        Id::ContactNormals,
        Id::RimBlocks,
        Id::RimWindows,
        Id::RimHeld,
        Id::Anchored,
        Id::Heads,
        Id::Words,
        Id::IndexInner,
        Id::IndexLeaves,
        Id::SourceOrder,
    ];

    /// Whether each mesh has its own.
    fn of_mesh(self) -> bool {
        (Id::Mesh..Id::SourceOrder).contains(&self)
    }

    fn flags(self) -> u32 {
        if self == Id::SourceOrder { Entry::OPTIONAL } else { 0 }
    }

    fn name(self) -> &'static str {
        match self {
            Id::Set => "set",
            Id::Examples => "examples",
            Id::Names => "names",
            Id::Masses => "masses",
            Id::Stamps => "stamps",
            Id::Nodes => "nodes",
            Id::Mesh => "mesh",
            Id::Positions => "positions",
            Id::Normals => "normals",
            Id::Tangents => "tangents",
            Id::Triangles => "triangles",
            Id::Weld => "weld",
            Id::ContactNormals => "contact normals",
            Id::RimBlocks => "rim blocks",
            Id::RimWindows => "rim windows",
            Id::RimHeld => "rim held",
            Id::Anchored => "anchored",
            Id::Heads => "heads",
            Id::Words => "words",
            Id::IndexInner => "index inner",
            Id::IndexLeaves => "index leaves",
            Id::SourceOrder => "source order",
        }
    }
}

/// The one element of section `set`.
#[repr(C)]
#[derive(Debug, Clone, Copy, Pod, Zeroable)]
struct SetRecord {
    fingerprint: u64,
    /// Coincident vertices that were welded at build.
    welded: u64,
    examples: u32,
    meshes: u32,
    /// m; 0: the deepest example.
    depth_limit: f32,
    /// m.
    drop_below: f32,
    /// m; 0: exact floats.
    tolerance: f32,
    /// Degrees.
    normal_tolerance: f32,
    /// kg, where `mass_kind` is 1.
    mass: f32,
    stamp_resolution: u32,
    /// Learned: share of the bounds' diagonal.
    place_width: f32,
    /// m.
    widest_weld: f32,
    /// 0 sum, 1 energies, 2 deepest.
    combine: u8,
    strict: u8,
    /// 0 weld, 1 keep.
    seams: u8,
    /// 0 none, 1 uniform, 2 one a vertex.
    mass_kind: u8,
    mirror: u8,
    held_rims: u8,
    /// Mirror planes found: bits 0, 1, 2 for x, y, z.
    planes: u8,
    zero: u8,
}

/// One element of section `examples`.
#[repr(C)]
#[derive(Debug, Clone, Copy, Pod, Zeroable)]
struct ExampleRecord {
    /// Bytes of its name, which follows that of the example before it.
    name: u32,
    contact_vertex: u32,
    /// Vertices it moves.
    moved: u32,
    /// m.
    support_radius: f32,
    /// Zero where there is none.
    contact_normal: [f32; 3],
    /// As given, m.
    contact_displacement: [f32; 3],
    /// Learned; not a number where not known.
    carried_error: f32,
    /// Learned; not a number where not known.
    anchored_error: f32,
    /// 0 automatic, 1 anchored, 2 carried.
    placement: u8,
    /// Learned: stays in place.
    stays: u8,
    /// Whether it has a stamp: the next one of section `stamps`.
    stamp: u8,
    zero: u8,
}

/// One element of section `stamps`.
#[repr(C)]
#[derive(Debug, Clone, Copy, Pod, Zeroable)]
struct StampRecord {
    /// Nodes along x and y.
    dims: [u32; 2],
    /// m.
    origin: [f32; 2],
    /// m.
    cell: [f32; 2],
    /// What displacements (m), heights (m) and changes of normals are multiples of.
    displacement: [f32; 3],
    height: f32,
    normal: [f32; 3],
    /// m.
    fade: f32,
    /// m.
    error_max: f32,
    /// m.
    error_rms: f32,
}

/// The one element of section `mesh`.
#[repr(C)]
#[derive(Debug, Clone, Copy, Pod, Zeroable)]
struct MeshRecord {
    vertices: u32,
    repaired_normals: u32,
    degenerate_triangles: u32,
    /// m; 0 of the base mesh.
    farthest: f32,
}

/// One element of section `anchored`: how much of `heads` and `words` is one example's.
#[repr(C)]
#[derive(Debug, Clone, Copy, Pod, Zeroable)]
struct AnchoredRecord {
    heads: u32,
    words: u32,
}

// docs/format.md tells these.
const _: () = assert!(size_of::<Header>() == 64 && size_of::<Entry>() == 32);
const _: () = assert!(size_of::<SetRecord>() == 64 && size_of::<ExampleRecord>() == 52);
const _: () = assert!(size_of::<StampRecord>() == 64 && size_of::<MeshRecord>() == 16);
const _: () =
    assert!(size_of::<crate::example::blocks::Head>() == 20 && size_of::<crate::mesh::rim::WindowBlock>() == 2048);

/// 64 bytes of a file, aligned.
#[repr(C, align(64))]
#[derive(Debug, Clone, Copy, Pod, Zeroable)]
struct Line([u8; ALIGN]);

/// An aligned copy of a file.
struct Aligned {
    lines: Vec<Line>,
    length: usize,
}

impl Aligned {
    fn new(length: usize) -> Result<Self, Error> {
        let mut lines = crate::base::error::reserve(length.div_ceil(ALIGN), "a baked set")?;
        lines.resize(length.div_ceil(ALIGN), Line([0; ALIGN]));
        Ok(Aligned { lines, length })
    }

    fn as_mut(&mut self) -> &mut [u8] {
        &mut bytemuck::cast_slice_mut(&mut self.lines)[..self.length]
    }
}

impl AsRef<[u8]> for Aligned {
    fn as_ref(&self) -> &[u8] {
        &bytemuck::cast_slice(&self.lines)[..self.length]
    }
}

/// The checksum of a file: XXH3 of the XXH3s of its pieces.
fn checksum(hashes: &[u64]) -> u64 {
    let bytes: Vec<u8> = hashes.iter().flat_map(|h| h.to_le_bytes()).collect();
    xxh3_64(&bytes)
}

/// The checksum that a file should have, whatever its own says; for tests that damage files on purpose.
#[doc(hidden)]
pub fn file_checksum(file: &[u8], tasks: &dyn TaskSystem) -> u64 {
    checksum(&map(tasks, file.get(UNHASHED..).unwrap_or_default().chunks(CHUNK), xxh3_64))
}

fn little_endian() -> Result<(), Error> {
    if cfg!(target_endian = "little") {
        Ok(())
    } else {
        Err(Error::Unsupported { what: "baked sets on a big-endian processor: their numbers are little-endian".into() })
    }
}

/// "malformed: `name` is `value`; it must be `expected`".
fn wrong(name: impl std::fmt::Display, value: impl std::fmt::Display, expected: impl std::fmt::Display) -> Error {
    Error::Format { what: format!("baked set: {name} is {value}; it must be {expected}") }
}

impl ExampleSet {
    /// The set as the bytes of a `.crumple` file, from which [`ExampleSet::load`] makes the same set again. A set always
    /// gives the same bytes, and so does one that was loaded.
    ///
    /// # Errors
    /// [`Error::OutOfMemory`]; [`Error::Unsupported`] on a big-endian processor.
    pub fn save(&self) -> Result<Vec<u8>, Error> {
        little_endian()?;
        let file = write::File::new(self);
        let mut out = crate::base::error::reserve(file.length(), "a baked set")?;
        // Into memory that is there nothing can fail.
        let _ = file.write(&mut out);
        Ok(out)
    }

    /// Writes what [`ExampleSet::save`] returns, without holding it in memory.
    ///
    /// # Errors
    /// Those of `out`; `Unsupported` on a big-endian processor.
    pub fn save_to(&self, out: &mut impl Write) -> std::io::Result<()> {
        little_endian().map_err(|e| std::io::Error::new(std::io::ErrorKind::Unsupported, e.to_string()))?;
        write::File::new(self).write(out)
    }

    /// Bytes of what [`ExampleSet::save`] returns.
    pub fn saved_bytes(&self) -> usize {
        write::File::new(self).length()
    }

    /// A set from the bytes of a `.crumple` file: a buffer, a `&'static [u8]`, or a memory map of yours, which the set keeps.
    ///
    /// Nothing is rebuilt, and the arrays are not copied but used where they lie, as long as the memory begins at a multiple
    /// of 16 bytes; otherwise one aligned copy is made, and `bytes` is let go. The bytes must not change while the set or
    /// anything made of it is alive: see to that where other processes may write to a mapped file.
    ///
    /// Everything is checked, so that no file, whatever is in it, does worse than a set that its maker did not mean. `tasks`
    /// runs the checks.
    ///
    /// # Errors
    /// [`Error::Format`] naming what is wrong; [`Error::Unsupported`] for a file of another version, and on a big-endian
    /// processor; [`Error::OutOfMemory`].
    pub fn load<B>(bytes: B, tasks: &dyn TaskSystem) -> Result<Self, Error>
    where
        B: AsRef<[u8]> + Send + Sync + 'static,
    {
        little_endian()?;
        let file = FileBytes::new(Arc::new(bytes));
        if !file.as_slice().as_ptr().addr().is_multiple_of(IN_PLACE) {
            return Self::load_copy(file.as_slice(), tasks);
        }
        load::set(&file, tasks)
    }

    /// [`ExampleSet::load`] from a copy of the bytes.
    ///
    /// # Errors
    /// Those of [`ExampleSet::load`].
    pub fn load_copy(bytes: &[u8], tasks: &dyn TaskSystem) -> Result<Self, Error> {
        little_endian()?;
        let mut copy = Aligned::new(bytes.len())?;
        copy.as_mut().copy_from_slice(bytes);
        load::set(&FileBytes::new(Arc::new(copy)), tasks)
    }

    /// A set from a `.crumple` file, which is read into one allocation.
    ///
    /// # Errors
    /// [`Error::Io`], and those of [`ExampleSet::load`].
    pub fn load_file(path: impl AsRef<Path>, tasks: &dyn TaskSystem) -> Result<Self, Error> {
        let path = path.as_ref();
        let io = |e: std::io::Error| Error::Io { path: path.display().to_string(), message: e.to_string() };
        let mut file = std::fs::File::open(path).map_err(io)?;
        let length = file.metadata().map_err(io)?.len();
        // A pipe or a device has no length to tell.
        if length == 0 {
            let mut all = Vec::new();
            file.read_to_end(&mut all).map_err(io)?;
            return Self::load(all, tasks);
        }
        let length = usize::try_from(length)
            .map_err(|_| Error::OutOfMemory { what: path.display().to_string(), bytes: length })?;
        let mut bytes = Aligned::new(length)?;
        file.read_exact(bytes.as_mut()).map_err(io)?;
        Self::load(bytes, tasks)
    }

    /// Whether bytes begin as a `.crumple` file does.
    pub fn is_saved(bytes: &[u8]) -> bool {
        bytes.starts_with(&MAGIC)
    }
}
