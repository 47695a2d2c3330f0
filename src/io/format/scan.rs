//! The first pass over a file: the checksum, and quick checks of its large sections while their bytes are in the cache.
//! A file is read from memory once, whatever is checked.

use super::check;
use super::layout::{CHUNK, Id, MeshRecord, UNHASHED, checksum};
use super::read::File;
use crate::base::tasks::{TaskSystem, map};
use crate::mesh::MAX_COORDINATE;
use crate::mesh::nearest::{Leaf, vertices_known};
use bytemuck::{AnyBitPattern, try_cast_slice};
use glam::Vec3;
use std::ops::Range;
use twox_hash::XxHash3_64;

/// What the pass found.
pub(super) struct Scan {
    pub checksum: u64,
    /// Whether all of the content that [`quick_checks`] looks at is right. If not, [`super::load`] finds out what is
    /// wrong.
    pub sound: bool,
}

/// Scans a file. `table` is the file with its table of sections, if that could be read; nothing in it needs to be true.
pub(super) fn scan(file: &[u8], table: Option<&File<'_>>, tasks: &dyn TaskSystem) -> Scan {
    let checks = table.map_or(Vec::new(), quick_checks);
    let chunks = map(tasks, (UNHASHED..file.len()).step_by(CHUNK), |start| {
        let chunk = start..file.len().min(start + CHUNK);
        (XxHash3_64::oneshot(&file[chunk.clone()]), checks.iter().all(|check| check.holds(file, &chunk)))
    });
    let hashes: Vec<u64> = chunks.iter().map(|c| c.0).collect();
    Scan { checksum: checksum(&hashes), sound: table.is_some() && chunks.iter().all(|c| c.1) }
}

/// A check of the elements of one section.
struct Check {
    /// The section's bytes in the file.
    section: Range<usize>,
    /// Bytes of one element.
    element: usize,
    holds: Box<Holds>,
}

/// Whether a section's bytes are right.
type Holds = dyn Fn(&[u8]) -> bool + Sync;

impl Check {
    fn of<T: AnyBitPattern>(section: Range<usize>, holds: impl Fn(&[T]) -> bool + Sync + 'static) -> Self {
        // Memory that is not aligned counts as wrong here.
        let holds = move |bytes: &[u8]| try_cast_slice(bytes).is_ok_and(&holds);
        Check { section, element: size_of::<T>(), holds: Box::new(holds) }
    }

    /// Checks the elements that begin in this part of the file.
    fn holds(&self, file: &[u8], part: &Range<usize>) -> bool {
        let Range { start, end } = self.section;
        // The first element from this byte on.
        let from = |at: usize| start + at.clamp(start, end).saturating_sub(start).next_multiple_of(self.element);
        let bytes = from(part.start).min(end)..from(part.end).min(end);
        bytes.is_empty() || (self.holds)(&file[bytes])
    }
}

/// The checks of [`super::check`] that go over large sections. Sections that cannot be found are checked later.
fn quick_checks(file: &File<'_>) -> Vec<Check> {
    let mut checks = Vec::new();
    for mesh in 0.. {
        let Some(record) = file.array::<MeshRecord>(Id::Mesh, mesh).ok().and_then(|m| m.first().copied()) else {
            break;
        };
        let n = record.vertices as usize;
        let range = |id, element: usize| file.range(id, mesh, element).unwrap_or_default();
        let below = move |x: &[u32]| check::indices_below(x, n);
        let vectors = size_of::<Vec3>();
        checks.push(Check::of(range(Id::Positions, vectors), |x| check::numbers_within(x, MAX_COORDINATE)));
        checks.push(Check::of(range(Id::Normals, vectors), check::all_units));
        checks.push(Check::of(range(Id::ContactNormals, vectors), check::all_units));
        checks.push(Check::of(range(Id::Triangles, size_of::<[u32; 3]>()), below));
        checks.push(Check::of(range(Id::Weld, size_of::<u32>()), below));
        if mesh == 0 {
            checks.push(Check::of(range(Id::IndexLeaves, size_of::<Leaf>()), move |x| vertices_known(x, n)));
        }
    }
    checks
}
