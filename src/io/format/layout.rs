//! The layout of a file: header, table of sections, records. docs/format.md describes every byte.

use crate::base::error::Error;
use crate::base::tasks::{TaskSystem, map};
use bytemuck::{CheckedBitPattern, Pod, Zeroable};
use twox_hash::XxHash3_64;

/// The first bytes of every file. The last of them reveals a text conversion.
pub(super) const MAGIC: [u8; 8] = *b"crumple\n";
/// Files of other versions are refused.
pub(super) const VERSION: u32 = 6;

/// Sections begin at multiples of this; the largest alignment that any element needs is 16.
pub(super) const ALIGN: usize = 64;
/// A file is used in place if the address of its memory is a multiple of this.
pub(super) const IN_PLACE: usize = 16;
/// Bytes that one hash of the checksum covers.
pub(super) const CHUNK: usize = 1 << 20;
/// The checksum does not cover these first bytes: the magic and the checksum itself.
pub(super) const UNHASHED: usize = 16;

/// The first 64 bytes.
#[repr(C)]
#[derive(Debug, Clone, Copy, Pod, Zeroable)]
pub(super) struct Header {
    pub(super) magic: [u8; 8],
    pub(super) checksum: u64,
    /// Bytes of the whole file.
    pub(super) length: u64,
    pub(super) version: u32,
    pub(super) sections: u32,
    pub(super) zero: [u8; 32],
}

/// One entry of the table of sections, which follows the header.
#[repr(C)]
#[derive(Debug, Clone, Copy, Pod, Zeroable)]
pub(super) struct Entry {
    pub(super) id: u32,
    /// The mesh that the section belongs to, for sections of meshes; otherwise 0.
    pub(super) mesh: u32,
    /// Offset from the start of the file, a multiple of 64.
    pub(super) offset: u64,
    /// Bytes.
    pub(super) length: u64,
    /// Bytes of one element.
    pub(super) element: u32,
    pub(super) flags: u32,
}

impl Entry {
    /// A reader that does not know the section may ignore it.
    pub(super) const OPTIONAL: u32 = 1;
}

/// The content of a section.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, CheckedBitPattern)]
#[repr(u32)]
pub(super) enum Id {
    Set = 1,
    Examples = 2,
    Names = 3,
    Masses = 4,
    Rule = 7,
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
    DepthLimits = 31,
    Gives = 32,
    Tiles = 33,
    TileNodes = 34,
    Weights = 35,
    Slopes = 36,
    SlopeUnits = 37,
    SourceOrder = 64,
}

impl Id {
    /// The content of this number.
    pub(super) fn of(number: u32) -> Option<Id> {
        bytemuck::checked::try_cast(number).ok()
    }

    /// Whether each mesh has its own section of this kind.
    pub(super) fn of_mesh(self) -> bool {
        (Id::Mesh..Id::SourceOrder).contains(&self)
    }

    pub(super) fn flags(self) -> u32 {
        if self == Id::SourceOrder { Entry::OPTIONAL } else { 0 }
    }

    /// Its name in errors: that of `ContactNormals` is "contact normals".
    pub(super) fn name(self) -> String {
        let mut out = String::new();
        for c in format!("{self:?}").chars() {
            if c.is_uppercase() && !out.is_empty() {
                out.push(' ');
            }
            out.extend(c.to_lowercase());
        }
        out
    }
}

/// The one element of section `set`.
#[repr(C)]
#[derive(Debug, Clone, Copy, Pod, Zeroable)]
pub(super) struct SetRecord {
    pub(super) fingerprint: u64,
    /// Number of coincident vertices that were welded at build.
    pub(super) welded: u64,
    pub(super) examples: u32,
    pub(super) meshes: u32,
    /// m; 0: three times the depth of the deepest example.
    pub(super) depth_limit: f32,
    /// m.
    pub(super) drop_below: f32,
    /// m; 0: exact floats.
    pub(super) tolerance: f32,
    /// Degrees.
    pub(super) normal_tolerance: f32,
    /// kg, if `mass_kind` is 1.
    pub(super) mass: f32,
    /// m.
    pub(super) widest_weld: f32,
    /// 0 none, 1 uniform, 2 per vertex.
    pub(super) mass_kind: u8,
    pub(super) mirror: u8,
    pub(super) held_rims: u8,
    /// Mirror planes found: bits 0, 1, 2 for x, y, z.
    pub(super) planes: u8,
    /// Whether the base mesh has sections `anchored`, `heads` and `words`.
    pub(super) whole_examples: u8,
    pub(super) zero: [u8; 3],
}

/// One element of section `examples`.
#[repr(C)]
#[derive(Debug, Clone, Copy, Pod, Zeroable)]
pub(super) struct ExampleRecord {
    /// Length of its name, bytes. The names follow each other in the order of the examples.
    pub(super) name: u32,
    pub(super) contact_vertex: u32,
    /// Number of vertices that it moves.
    pub(super) moved: u32,
    /// m.
    pub(super) support_radius: f32,
    /// Longest displacement, m.
    pub(super) max_depth: f32,
    /// Zero if there is none.
    pub(super) contact_normal: [f32; 3],
    /// As given, m.
    pub(super) contact_displacement: [f32; 3],
    /// Shape of its striker: 0 unknown, 1 ball, 2 pole, 3 corner, 4 wall.
    pub(super) shape: u32,
    pub(super) blow: BlowRecord,
}

/// What is known of an example's blow; NaN if unknown.
#[repr(C)]
#[derive(Debug, Clone, Copy, Pod, Zeroable)]
pub(super) struct BlowRecord {
    /// On the body, N·s.
    pub(super) impulse: [f32; 3],
    /// s.
    pub(super) duration: f32,
    /// Out of the body, unit.
    pub(super) normal: [f32; 3],
    /// kg.
    pub(super) striker_mass: f32,
    /// Relative to the body, m/s.
    pub(super) striker_velocity: [f32; 3],
    /// m.
    pub(super) striker_radius: f32,
}

/// The one element of section `mesh`.
#[repr(C)]
#[derive(Debug, Clone, Copy, Pod, Zeroable)]
pub(super) struct MeshRecord {
    pub(super) vertices: u32,
    pub(super) repaired_normals: u32,
    pub(super) degenerate_triangles: u32,
    /// m; 0 for the base mesh.
    pub(super) farthest: f32,
}

/// One element of section `anchored`: how much of `heads` and `words` belongs to one example.
#[repr(C)]
#[derive(Debug, Clone, Copy, Pod, Zeroable)]
pub(super) struct AnchoredRecord {
    pub(super) heads: u32,
    pub(super) words: u32,
}

// docs/format.md states these sizes.
const _: () = assert!(size_of::<Header>() == 64 && size_of::<Entry>() == 32);
const _: () = assert!(size_of::<SetRecord>() == 56 && size_of::<ExampleRecord>() == 96);
const _: () = assert!(size_of::<MeshRecord>() == 16);
const _: () =
    assert!(size_of::<crate::example::blocks::Head>() == 20 && size_of::<crate::mesh::rim::WindowBlock>() == 512);

/// The checksum of a file: XXH3 of its chunks' XXH3 hashes.
pub(super) fn checksum(hashes: &[u64]) -> u64 {
    let bytes: Vec<u8> = hashes.iter().flat_map(|h| h.to_le_bytes()).collect();
    XxHash3_64::oneshot(&bytes)
}

/// Returns the checksum that a file should have, whatever it says itself. For tests that damage files on purpose.
#[doc(hidden)]
pub fn file_checksum(file: &[u8], tasks: &dyn TaskSystem) -> u64 {
    checksum(&map(tasks, file.get(UNHASHED..).unwrap_or_default().chunks(CHUNK), XxHash3_64::oneshot))
}

/// "malformed: `name` is `value`; it must be `expected`".
pub(super) fn wrong(
    name: impl std::fmt::Display,
    value: impl std::fmt::Display,
    expected: impl std::fmt::Display,
) -> Error {
    Error::Format { what: format!("baked set: {name} is {value}; it must be {expected}") }
}
