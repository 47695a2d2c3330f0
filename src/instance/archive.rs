//! The damage of many instances in one piece of bytes: a header of 16 bytes, then for each instance its size as a u64
//! and its saved damage ([`crate::damage::saved`]), at last a checksum like that of one instance. The header is the magic
//! `CRDA`, u16 version, u16 zero, u32 number of instances, u32 zero. All numbers are little-endian.

use super::Instance;
use crate::base::error::Error;
use crate::base::tasks::{TaskSystem, map};
use crate::damage::saved::{VERSION, seal, unseal};

const MAGIC: [u8; 4] = *b"CRDA";
const HEADER: usize = 16;

/// Returns the damage of all these instances as bytes, after folding the hits that have arrived. The same damage gives
/// the same bytes on every platform.
pub fn save_all<'a>(instances: impl IntoIterator<Item = &'a mut Instance>) -> Vec<u8> {
    pack(instances.into_iter().map(Instance::save))
}

/// Puts saved damage of many instances together.
pub(crate) fn pack(each: impl Iterator<Item = Vec<u8>>) -> Vec<u8> {
    let mut out = [&MAGIC[..], &VERSION.to_le_bytes(), &[0; HEADER - 6]].concat();
    let mut count = 0u32;
    for bytes in each {
        out.extend((bytes.len() as u64).to_le_bytes());
        out.extend(bytes);
        count += 1;
    }
    out[8..12].copy_from_slice(&count.to_le_bytes());
    seal(&mut out);
    out
}

/// Replaces the damage of all these instances by that of [`save_all`], which was given instances of the same sets in the
/// same order. Discards hits that have not been folded yet, and ends all contacts.
///
/// # Errors
/// [`Error::DamageMismatch`] for bytes that were changed, are cut short, or are of another version or number of instances; those of
/// [`Instance::load`], naming the instance. After an error nothing has changed.
pub fn load_all(instances: &mut [&mut Instance], bytes: &[u8], tasks: &dyn TaskSystem) -> Result<(), Error> {
    let each = unpack(bytes, Some(instances.len()))?;
    let read = instances.iter().zip(each).enumerate().map(|(at, (i, bytes))| i.read(bytes).map_err(|e| of(at, e)));
    let read = read.collect::<Result<Vec<_>, _>>()?;
    map(tasks, instances.iter_mut().zip(read), |(instance, saved)| instance.become_saved(saved));
    Ok(())
}

/// Whether the bytes claim to be the damage of many instances.
pub(crate) fn are_many(bytes: &[u8]) -> bool {
    bytes.starts_with(&MAGIC)
}

/// Takes the saved damage of so many instances apart. `None`: of any number.
pub(crate) fn unpack(bytes: &[u8], count: Option<usize>) -> Result<Vec<&[u8]>, Error> {
    let bad = |what: String| Error::DamageMismatch { what };
    let short = || bad(format!("{} bytes, cut short", bytes.len()));
    let (header, _) = bytes.split_first_chunk::<HEADER>().ok_or_else(short)?;
    if header[..4] != MAGIC {
        let begins = &header[..4];
        return Err(bad(format!("it begins with {begins:?}; saved damage of many instances begins with {MAGIC:?}")));
    }
    let mut rest = unseal(bytes)?.get(HEADER..).ok_or_else(short)?;
    let saved = u32::from_le_bytes([header[8], header[9], header[10], header[11]]);
    if let Some(count) = count.filter(|count| *count != saved as usize) {
        return Err(bad(format!("it is that of {saved} instances; {count} were given")));
    }
    // Each instance takes the eight bytes of its size at least.
    let mut each = Vec::with_capacity((saved as usize).min(rest.len() / 8));
    for _ in 0..saved {
        let (size, after) = rest.split_first_chunk().ok_or_else(short)?;
        let size = usize::try_from(u64::from_le_bytes(*size)).map_err(|_| short())?;
        let (one, after) = after.split_at_checked(size).ok_or_else(short)?;
        each.push(one);
        rest = after;
    }
    if header[6..8] != [0; 2] || header[12..] != [0; 4] || !rest.is_empty() {
        return Err(bad(format!("{} bytes after the last instance, or a reserved byte that is not 0", rest.len())));
    }
    Ok(each)
}

/// An error of one instance's damage, naming the instance.
pub(crate) fn of(at: usize, error: Error) -> Error {
    match error {
        Error::DamageMismatch { what } => Error::DamageMismatch { what: format!("of instance {at}: {what}") },
        Error::InvalidArgument { name, value, expected } => {
            Error::InvalidArgument { name: format!("{name} of instance {at}"), value, expected }
        }
        other => other,
    }
}
