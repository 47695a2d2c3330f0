//! The first pass over a file: the checksum, and the checks of its large sections while their bytes are in the cache.
//! A file is read from memory once, whatever is checked.

use super::check;
use super::layout::{CHUNK, Id, MeshRecord, UNHASHED, checksum, wrong};
use super::read::File;
use crate::base::array::FileBytes;
use crate::base::error::Error;
use crate::base::tasks::{TaskSystem, map};
use crate::mesh::MAX_COORDINATE;
use bytemuck::{Pod, cast_slice, try_cast_slice};
use glam::Vec3;
use std::ops::Range;
use twox_hash::XxHash3_64;

/// Reads a file's header and table, and verifies its checksum. Also returns what is wrong in its large sections, if anything is;
/// what comes first in a file is told first, so this error may have to wait.
pub(super) fn open<'a>(bytes: &'a FileBytes, tasks: &dyn TaskSystem) -> Result<(File<'a>, Result<(), Error>), Error> {
    let (stated, file) = File::read(bytes)?;
    let all = bytes.as_slice();
    // Nothing in the table needs to be true yet.
    let checks = file.as_ref().map_or(Vec::new(), large_sections);
    let chunks = map(tasks, (UNHASHED..all.len()).step_by(CHUNK), |start| {
        let chunk = start..all.len().min(start + CHUNK);
        (XxHash3_64::oneshot(&all[chunk.clone()]), checks.iter().all(|check| check.part(all, &chunk).is_ok()))
    });
    let found = checksum(&chunks.iter().map(|c| c.0).collect::<Vec<u64>>());
    // A damaged table is first of all damaged.
    if stated != found {
        return Err(wrong("the checksum", format!("{stated:#018x}"), format!("{found:#018x}: the file was damaged")));
    }
    let sound = chunks.iter().all(|c| c.1);
    // Once more for the place of what is wrong in its section.
    let content = if sound { Ok(()) } else { checks.iter().try_for_each(|check| check.part(all, &check.section)) };
    Ok((file?, content))
}

/// A check of the elements of one section.
struct Check {
    /// The section's bytes in the file.
    section: Range<usize>,
    /// Bytes of one element.
    element: usize,
    elements: Box<Elements>,
}

/// What is wrong with some of a section's bytes.
type Elements = dyn Fn(&[u8]) -> Result<(), Error> + Sync;

impl Check {
    /// `elements` gets the section's name. A section that cannot be found has no elements; that it is absent is seen later.
    fn of<T: Pod>(
        file: &File<'_>,
        (id, mesh): (Id, u32),
        elements: impl Fn(&str, &[T]) -> Result<(), Error> + Sync + 'static,
    ) -> Self {
        let name = format!("section {}", id.name());
        let elements = move |bytes: &[u8]| {
            elements(&name, try_cast_slice(bytes).map_err(|e| wrong(&name, e, "aligned elements"))?)
        };
        let section = file.range(id, mesh, size_of::<T>()).unwrap_or_default();
        Check { section, element: size_of::<T>(), elements: Box::new(elements) }
    }

    /// Checks the elements that begin in this part of the file.
    fn part(&self, file: &[u8], part: &Range<usize>) -> Result<(), Error> {
        let Range { start, end } = self.section;
        // The first element from this byte on.
        let from = |at: usize| start + at.clamp(start, end).saturating_sub(start).next_multiple_of(self.element);
        let bytes = from(part.start).min(end)..from(part.end).min(end);
        if bytes.is_empty() { Ok(()) } else { (self.elements)(&file[bytes]) }
    }
}

/// The checks of large sections that look at one element at a time.
fn large_sections(file: &File<'_>) -> Vec<Check> {
    let mut checks = Vec::new();
    for mesh in 0.. {
        let Some(record) = file.array::<MeshRecord>(Id::Mesh, mesh).ok().and_then(|m| m.first().copied()) else {
            break;
        };
        let n = record.vertices as usize;
        checks.push(Check::of(file, (Id::Positions, mesh), |name, x: &[Vec3]| {
            check::numbers(name, cast_slice(x), MAX_COORDINATE)
        }));
        checks.push(Check::of(file, (Id::Normals, mesh), check::units));
        checks.push(Check::of(file, (Id::ContactNormals, mesh), check::units));
        checks.push(Check::of(file, (Id::Triangles, mesh), move |name, x: &[[u32; 3]]| {
            check::indices(name, x.as_flattened(), n)
        }));
        checks.push(Check::of(file, (Id::Weld, mesh), move |name, x: &[u32]| check::indices(name, x, n)));
        if mesh == 0 {
            checks.push(Check::of(file, (Id::IndexLeaves, 0), move |_, x| check::leaves(x, n)));
        }
    }
    checks
}
