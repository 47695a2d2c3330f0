//! Reads a file's header and table, and its sections as arrays.

use super::layout::{ALIGN, Entry, Header, Id, MAGIC, VERSION, file_checksum, wrong};
use crate::base::array::{Array, FileBytes};
use crate::base::error::Error;
use crate::base::tasks::TaskSystem;
use bytemuck::Pod;
use std::ops::Range;

/// A file with its sections found.
pub(super) struct File<'a> {
    pub bytes: &'a FileBytes,
    /// The known sections, by id and mesh.
    sections: Vec<((Id, u32), Entry)>,
}

impl<'a> File<'a> {
    /// Reads the header, verifies the checksum and reads the table: a damaged table is first of all damaged.
    pub(super) fn read(bytes: &'a FileBytes, tasks: &dyn TaskSystem) -> Result<Self, Error> {
        let all = bytes.as_slice();
        let too_short = || wrong("its length", format!("{} bytes", all.len()), "at least the 64 of a header");
        let header: Header =
            bytemuck::pod_read_unaligned(all.get(..size_of::<Header>()).ok_or_else(
                || match all.starts_with(&MAGIC) {
                    false if !all.is_empty() => not_one(all),
                    _ => too_short(),
                },
            )?);
        if header.magic != MAGIC {
            return Err(not_one(all));
        }
        if header.version != VERSION {
            return Err(Error::Unsupported {
                what: format!("a baked set of version {}; this library reads version {VERSION}", header.version),
            });
        }
        if header.length != all.len() as u64 {
            return Err(wrong(
                "the length in its header",
                header.length,
                format!("{}, the bytes there are", all.len()),
            ));
        }
        if header.zero != [0; 32] {
            return Err(wrong("the rest of its header", "not zero", "zero"));
        }
        let table = size_of::<Header>()
            ..(header.sections as usize).saturating_mul(size_of::<Entry>()).saturating_add(size_of::<Header>());
        if all.get(table.clone()).is_none() {
            return Err(wrong("the number of sections", header.sections, "so few that their table fits into the file"));
        }
        let (stated, found) = (header.checksum, file_checksum(all, tasks));
        if stated != found {
            return Err(wrong(
                "the checksum",
                format!("{stated:#018x}"),
                format!("{found:#018x}: the file was damaged"),
            ));
        }
        File::table(bytes, &header, table)
    }

    /// Reads the table of sections, which is at `table`.
    fn table(bytes: &'a FileBytes, header: &Header, table: Range<usize>) -> Result<Self, Error> {
        let (mut end, table) = (table.end as u64, &bytes.as_slice()[table]);
        let mut file = File { bytes, sections: Vec::new() };
        for (i, e) in table.chunks_exact(size_of::<Entry>()).enumerate() {
            let e: Entry = bytemuck::pod_read_unaligned(e);
            let name = |field: &str| format!("{field} of section {i} (id {})", e.id);
            if e.flags & !Entry::OPTIONAL != 0 {
                return Err(wrong(name("flags"), e.flags, "0 or 1"));
            }
            if !e.offset.is_multiple_of(ALIGN as u64) || e.offset < end {
                return Err(wrong(name("the offset"), e.offset, format!("a multiple of 64 from {end} on")));
            }
            let last = e.offset.checked_add(e.length).filter(|last| *last <= header.length);
            end = last.ok_or_else(|| {
                wrong(name("the length"), e.length, format!("within the file: it begins at {}", e.offset))
            })?;
            match Id::of(e.id) {
                Some(id) if e.flags == id.flags() => file.sections.push(((id, e.mesh), e)),
                Some(id) => return Err(wrong(name("flags"), e.flags, id.flags())),
                None if e.flags & Entry::OPTIONAL != 0 => {}
                None => {
                    return Err(Error::Unsupported {
                        what: format!("a baked set with a section of id {}, which this library does not know", e.id),
                    });
                }
            }
        }
        file.sections.sort_by_key(|s| s.0);
        if let Some(twice) = file.sections.windows(2).find(|w| w[0].0 == w[1].0) {
            return Err(wrong(format!("section {}", twice[0].0.0.name()), "there twice", "there once"));
        }
        Ok(file)
    }

    /// Refuses sections of meshes that do not exist.
    pub(super) fn check_meshes(&self, meshes: u32) -> Result<(), Error> {
        for ((id, mesh), _) in &self.sections {
            let most = if id.of_mesh() { meshes } else { 1 };
            if *mesh >= most {
                return Err(wrong(format!("the mesh of section {}", id.name()), mesh, format!("below {most}")));
            }
        }
        Ok(())
    }

    /// The range of a section's bytes in the file; empty if the section is absent.
    pub(super) fn range(&self, id: Id, mesh: u32, element: usize) -> Result<Range<usize>, Error> {
        let Ok(at) = self.sections.binary_search_by_key(&(id, mesh), |s| s.0) else { return Ok(0..0) };
        let e = &self.sections[at].1;
        if e.element as usize != element {
            return Err(wrong(
                format!("the element size of section {}", id.name()),
                e.element,
                format!("{element} bytes"),
            ));
        }
        if !e.length.is_multiple_of(element as u64) || e.length == 0 {
            return Err(wrong(
                format!("the length of section {}", id.name()),
                e.length,
                format!("a multiple of its elements of {element} bytes, above 0"),
            ));
        }
        // Within the file, and so within the address space.
        Ok(e.offset as usize..(e.offset + e.length) as usize)
    }

    /// A section's elements, in place; empty if the section is absent.
    pub(super) fn array<T: Pod>(&self, id: Id, mesh: u32) -> Result<Array<T>, Error> {
        let range = self.range(id, mesh, size_of::<T>())?;
        if range.is_empty() { Ok(Array::default()) } else { self.part(range, id) }
    }

    /// The same for a section that must have `count` elements.
    pub(super) fn array_of<T: Pod>(&self, id: Id, mesh: u32, count: usize) -> Result<Array<T>, Error> {
        let array = self.array(id, mesh)?;
        if array.len() == count { Ok(array) } else { Err(length_of(id, array.len(), count)) }
    }

    /// The same for a section that may be absent.
    pub(super) fn some_of<T: Pod>(&self, id: Id, mesh: u32, count: usize) -> Result<Option<Array<T>>, Error> {
        let array: Array<T> = self.array(id, mesh)?;
        if array.is_empty() { Ok(None) } else { self.array_of(id, mesh, count).map(Some) }
    }

    /// The elements in a range of a section.
    pub(super) fn part<T: Pod>(&self, range: Range<usize>, id: Id) -> Result<Array<T>, Error> {
        if range.is_empty() {
            return Ok(Array::default());
        }
        Array::within(self.bytes, range.clone()).ok_or_else(|| {
            wrong(format!("a part of section {}", id.name()), format!("{range:?}"), "aligned and within the file")
        })
    }
}

pub(super) fn length_of(id: Id, len: usize, count: usize) -> Error {
    wrong(format!("the number of elements of section {}", id.name()), len, count)
}

fn not_one(all: &[u8]) -> Error {
    let start = all.get(..8).unwrap_or(all).escape_ascii().to_string();
    wrong(
        "its beginning",
        format!("'{start}'"),
        "'crumple\\n': this is no baked set, or it went through a text conversion",
    )
}
