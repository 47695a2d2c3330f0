//! The first pass over a file: the checksum, and quick checks of its large sections while their bytes are in the cache.
//! A file is read from memory once, whatever is checked.

use super::check;
use super::layout::{CHUNK, Id, MeshRecord, UNHASHED, checksum, wrong};
use super::read::File;
use crate::base::array::FileBytes;
use crate::base::error::Error;
use crate::base::tasks::{TaskSystem, map};
use crate::mesh::MAX_COORDINATE;
use crate::mesh::nearest::{Leaf, vertices_known};
use bytemuck::{AnyBitPattern, try_cast_slice};
use glam::Vec3;
use std::ops::Range;
use twox_hash::XxHash3_64;

/// Reads a file's header and table, and verifies its checksum. Also returns whether all of the content that
/// [`quick_checks`] looks at is right. If not, [`super::load`] finds out what is wrong.
pub(super) fn open<'a>(bytes: &'a FileBytes, tasks: &dyn TaskSystem) -> Result<(File<'a>, bool), Error> {
    let (stated, file) = File::read(bytes)?;
    let all = bytes.as_slice();
    // Nothing in the table needs to be true yet.
    let checks = file.as_ref().map_or(Vec::new(), quick_checks);
    let chunks = map(tasks, (UNHASHED..all.len()).step_by(CHUNK), |start| {
        let chunk = start..all.len().min(start + CHUNK);
        (XxHash3_64::oneshot(&all[chunk.clone()]), checks.iter().all(|check| check.holds(all, &chunk)))
    });
    let found = checksum(&chunks.iter().map(|c| c.0).collect::<Vec<u64>>());
    // A damaged table is first of all damaged.
    if stated != found {
        return Err(wrong("the checksum", format!("{stated:#018x}"), format!("{found:#018x}: the file was damaged")));
    }
    Ok((file?, chunks.iter().all(|c| c.1)))
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
