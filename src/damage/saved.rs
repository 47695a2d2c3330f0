//! Saved damage: a header of 24 bytes, the entries, and a checksum ([`seal`]). The header is the magic `CRDM`, u16
//! version, u16 kind, u64 fingerprint of the set, u32 number of entries, u32 zero. All numbers are little-endian.

use super::mark::Mark;
use crate::base::error::{Error, reserve};
use crate::example::set::ExampleSet;
use bytemuck::{Pod, Zeroable};
use twox_hash::XxHash3_64;

const MAGIC: [u8; 4] = *b"CRDM";
/// The version that is written and read.
pub(crate) const VERSION: u16 = 3;
const HEADER: usize = size_of::<Header>();
/// Entries are marks of 32 bytes.
const MARKS: u16 = 1;
/// Entries are vertices of a classic rule's state, of 28 bytes each.
pub(crate) const CLASSIC: u16 = 2;

#[repr(C)]
#[derive(Clone, Copy, Pod, Zeroable)]
struct Header {
    magic: [u8; 4],
    version: u16,
    kind: u16,
    /// The fingerprint, the lower half first.
    set: [u32; 2],
    count: u32,
    zero: u32,
}

/// Whether the bytes claim to be damage of this set.
pub(crate) fn belongs_to(set: &ExampleSet, bytes: &[u8]) -> bool {
    bytes.len() >= HEADER && bytes[..4] == MAGIC && bytes[8..16] == set.fingerprint().to_le_bytes()
}

/// Appends the checksum: the XXH3-64 of all bytes before it.
pub(crate) fn seal(bytes: &mut Vec<u8>) {
    bytes.extend(XxHash3_64::oneshot(bytes).to_le_bytes());
}

/// Checks the version and the checksum, and returns the bytes without the latter. `bytes` are at least a header.
pub(crate) fn unseal(bytes: &[u8]) -> Result<&[u8], Error> {
    let bad = |what: String| Err(Error::DamageMismatch { what });
    match u16::from_le_bytes([bytes[4], bytes[5]]) {
        VERSION => match bytes.split_last_chunk() {
            Some((sealed, checksum)) if XxHash3_64::oneshot(sealed) == u64::from_le_bytes(*checksum) => Ok(sealed),
            _ => bad(format!(
                "{} bytes do not have the checksum at their end; they were changed or cut short",
                bytes.len()
            )),
        },
        other => bad(format!("version {other}; this library reads version {VERSION}")),
    }
}

/// The entries as bytes, with a header and the checksum.
pub(crate) fn write<T: Pod>(set: &ExampleSet, kind: u16, entries: &[T]) -> Vec<u8> {
    let [low, high] = [set.fingerprint() as u32, (set.fingerprint() >> 32) as u32];
    let header =
        Header { magic: MAGIC, version: VERSION, kind, set: [low, high], count: entries.len() as u32, zero: 0 };
    let mut out = [bytemuck::bytes_of(&header), bytemuck::cast_slice(entries)].concat();
    seal(&mut out);
    out
}

/// Checks the header and returns the entries of [`write()`]. Their number is checked against the header.
pub(crate) fn read<T: Pod>(set: &ExampleSet, kind: u16, bytes: &[u8]) -> Result<Vec<T>, Error> {
    let bad = |what: String| Err(Error::DamageMismatch { what });
    if bytes.len() < HEADER {
        return bad(format!("{} bytes; at least {HEADER} are needed", bytes.len()));
    }
    let header: Header = bytemuck::pod_read_unaligned(&bytes[..HEADER]);
    if header.magic != MAGIC {
        return bad(format!("it begins with {:?}; saved damage begins with {:?}", header.magic, MAGIC));
    }
    let bytes = unseal(bytes)?;
    if bytes.len() < HEADER {
        return bad(format!("{} bytes before the checksum; at least {HEADER} are needed", bytes.len()));
    }
    if header.kind != kind {
        let kinds = "1: marks, 2: a classic rule's vertices";
        return bad(format!("kind {} ({kinds}); kind {kind} is needed here", header.kind));
    }
    let [low, high] = header.set.map(u64::from);
    let of = low | high << 32;
    if of != set.fingerprint() {
        return bad(format!("it belongs to example set {of:016x}; this instance's is {:016x}", set.fingerprint()));
    }
    if header.zero != 0 {
        return bad(format!("bytes 20 to 23 are {:#x}; they must be 0", header.zero));
    }
    let rest = &bytes[HEADER..];
    let needed = u64::from(header.count) * size_of::<T>() as u64;
    if rest.len() as u64 != needed {
        return bad(format!("{} bytes after the header; {} entries take {needed}", rest.len(), header.count));
    }
    let mut entries = reserve(header.count as usize, "damage")?;
    entries.extend(rest.chunks_exact(size_of::<T>()).map(bytemuck::pod_read_unaligned::<T>));
    Ok(entries)
}

/// The marks as bytes.
pub(crate) fn of_marks(set: &ExampleSet, marks: &[Mark]) -> Vec<u8> {
    write(set, MARKS, marks)
}

/// The marks of [`of_marks`], which the set can have.
pub(crate) fn marks(set: &ExampleSet, bytes: &[u8]) -> Result<Vec<Mark>, Error> {
    let marks = read(set, MARKS, bytes)?;
    Mark::check_all(&marks, set)?;
    Ok(marks)
}
