//! Saved damage: a header of 24 bytes, the entries, and a checksum ([`seal`]). The header is the magic `CRDM`, u16
//! version, u16 kind, u64 fingerprint of the set, u32 number of entries, u32 zero. All numbers are little-endian.

use super::mark::Mark;
use crate::base::error::Error;
use crate::example::set::ExampleSet;
use twox_hash::XxHash3_64;

pub(crate) const MAGIC: [u8; 4] = *b"CRDM";
/// The version that is written and read.
pub(crate) const VERSION: u16 = 3;
pub(crate) const HEADER: usize = 24;
/// Entries are marks of 32 bytes.
pub(crate) const MARKS: u16 = 1;
/// Entries are vertices of a classic rule's state, of 28 bytes each.
pub(crate) const CLASSIC: u16 = 2;

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

/// The header of damage that [`seal`] ends.
pub(crate) fn header(set: &ExampleSet, kind: u16, count: usize) -> Vec<u8> {
    let mut out = Vec::with_capacity(HEADER + count * 32 + 8);
    out.extend(MAGIC);
    out.extend(VERSION.to_le_bytes());
    out.extend(kind.to_le_bytes());
    out.extend(set.fingerprint().to_le_bytes());
    out.extend((count as u32).to_le_bytes());
    out.extend(0u32.to_le_bytes());
    out
}

/// Checks the header and returns the entries of `size` bytes. Their number is checked against the header.
pub(crate) fn entries<'a>(set: &ExampleSet, bytes: &'a [u8], kind: u16, size: usize) -> Result<&'a [u8], Error> {
    let bad = |what: String| Err(Error::DamageMismatch { what });
    if bytes.len() < HEADER {
        return bad(format!("{} bytes; at least {HEADER} are needed", bytes.len()));
    }
    let u16_at = |i: usize| u16::from_le_bytes([bytes[i], bytes[i + 1]]);
    let u32_at = |i: usize| u32::from_le_bytes([bytes[i], bytes[i + 1], bytes[i + 2], bytes[i + 3]]);
    if bytes[..4] != MAGIC {
        return bad(format!("it begins with {:?}; saved damage begins with {:?}", &bytes[..4], MAGIC));
    }
    let bytes = unseal(bytes)?;
    if bytes.len() < HEADER {
        return bad(format!("{} bytes before the checksum; at least {HEADER} are needed", bytes.len()));
    }
    if u16_at(6) != kind {
        return bad(format!("kind {} (1: marks, 2: a classic rule's vertices); kind {kind} is needed here", u16_at(6)));
    }
    let mark = u64::from(u32_at(8)) | u64::from(u32_at(12)) << 32;
    if mark != set.fingerprint() {
        return bad(format!("it belongs to example set {mark:016x}; this instance's is {:016x}", set.fingerprint()));
    }
    if u32_at(20) != 0 {
        return bad(format!("bytes 20 to 23 are {:#x}; they must be 0", u32_at(20)));
    }
    let rest = &bytes[HEADER..];
    let needed = u64::from(u32_at(16)) * size as u64;
    if rest.len() as u64 != needed {
        return bad(format!("{} bytes after the header; {} entries take {needed}", rest.len(), u32_at(16)));
    }
    Ok(rest)
}

pub(crate) fn write_mark(m: &Mark, out: &mut Vec<u8>) {
    out.extend(bytemuck::bytes_of(m));
}

/// The mark of 32 bytes.
pub(crate) fn read_mark(bytes: &[u8]) -> Mark {
    bytemuck::pod_read_unaligned(bytes)
}
