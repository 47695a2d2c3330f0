//! The file of a recording: a header, and events one after the other, each with a checksum, written as they happen, so that
//! what a crash leaves behind can be replayed up to the call that crashed.

use super::calls::{Call, Field};
use crate::Error;
use std::fs::File;
use std::io::Write;
use std::path::{Path, PathBuf};
use xxhash_rust::xxh3::xxh3_64;

const MAGIC: [u8; 8] = *b"CRUMPREC";
/// Grows when old readers could not read new files.
const FORMAT: u32 = 1;
/// Before an event: kind, nothing, length; behind it a checksum.
const HEAD: usize = 16;

/// How a call ended: a `CrumpleResult`, and a number that stands for what it gave.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(super) struct Ended {
    pub(super) result: u32,
    pub(super) value: u64,
}

/// One thing that happened.
#[derive(Clone, PartialEq, Debug)]
pub(super) enum Event {
    /// A call that had the context for itself begins.
    Call(Call),
    /// It ended.
    Ended(Ended),
    /// A hit arrives, perhaps while such a call runs.
    Hit(Call),
    /// It was taken.
    HitEnded(Ended),
    /// A call was refused before it did anything.
    Refused { function: String, result: u32, message: String },
    /// The recording ended as it should.
    End,
}

impl Event {
    fn bytes(&self) -> Vec<u8> {
        // The head is filled in last.
        let mut out = vec![0; HEAD];
        let text = |text: &str, out: &mut Vec<u8>| {
            (text.len() as u64).put(out);
            out.extend_from_slice(text.as_bytes());
        };
        let kind: u32 = match self {
            Event::Call(call) => {
                call.put(&mut out);
                1
            }
            Event::Ended(ended) => {
                ended.result.put(&mut out);
                ended.value.put(&mut out);
                2
            }
            Event::Hit(call) => {
                call.put(&mut out);
                3
            }
            Event::HitEnded(ended) => {
                ended.result.put(&mut out);
                ended.value.put(&mut out);
                4
            }
            Event::Refused { function, result, message } => {
                text(function, &mut out);
                result.put(&mut out);
                text(message, &mut out);
                5
            }
            Event::End => 6,
        };
        let length = (out.len() - HEAD) as u64;
        out[..4].copy_from_slice(&kind.to_le_bytes());
        out[8..HEAD].copy_from_slice(&length.to_le_bytes());
        let sum = xxh3_64(&out);
        sum.put(&mut out);
        out
    }

    fn take(kind: u32, mut body: &[u8]) -> Option<Self> {
        let bytes = &mut body;
        let text = |bytes: &mut &[u8]| -> Option<String> {
            let length = usize::try_from(u64::take(bytes)?).ok()?;
            let (head, rest) = bytes.split_at_checked(length)?;
            *bytes = rest;
            String::from_utf8(head.to_vec()).ok()
        };
        let ended = |bytes: &mut &[u8]| Some(Ended { result: u32::take(bytes)?, value: u64::take(bytes)? });
        let event = match kind {
            1 => return Call::take(body).map(Event::Call),
            2 => Event::Ended(ended(bytes)?),
            3 => return Call::take(body).map(Event::Hit),
            4 => Event::HitEnded(ended(bytes)?),
            5 => Event::Refused { function: text(bytes)?, result: u32::take(bytes)?, message: text(bytes)? },
            6 => Event::End,
            _ => return None,
        };
        bytes.is_empty().then_some(event)
    }
}

/// A file that grows.
#[derive(Debug)]
pub(super) struct Writer {
    file: File,
    path: PathBuf,
    /// Why nothing more is written.
    pub(super) failed: Option<Error>,
    /// Whether the host knows of that.
    pub(super) told: bool,
    ended: bool,
}

impl Writer {
    /// # Errors
    /// [`Error::Io`]; [`Error::Unsupported`] on a processor whose numbers are not little-endian.
    pub(super) fn create(path: &Path, version: u32) -> Result<Self, Error> {
        if cfg!(target_endian = "big") {
            let what = "recording on a big-endian processor; recordings hold little-endian numbers as they are";
            return Err(Error::Unsupported { what: what.into() });
        }
        let io = |e: std::io::Error| Error::Io { path: path.display().to_string(), message: e.to_string() };
        let mut file = File::create(path).map_err(io)?;
        let mut head = MAGIC.to_vec();
        FORMAT.put(&mut head);
        version.put(&mut head);
        file.write_all(&head).map_err(io)?;
        Ok(Self { file, path: path.into(), failed: None, told: false, ended: false })
    }

    pub(super) fn path(&self) -> &Path {
        &self.path
    }

    /// Writes an event, in one piece. The first failure is kept, and ends the recording.
    pub(super) fn write(&mut self, event: &Event) {
        if self.failed.is_none()
            && !self.ended
            && let Err(e) = self.file.write_all(&event.bytes())
        {
            self.failed = Some(Error::Io { path: self.path.display().to_string(), message: e.to_string() });
        }
        self.ended |= *event == Event::End;
    }
}

impl Drop for Writer {
    fn drop(&mut self) {
        self.write(&Event::End);
    }
}

/// The events of a recording.
pub(super) struct Reader<'a> {
    bytes: &'a [u8],
    at: usize,
    count: u64,
    /// Of the library that wrote it, as `crumple_version()`.
    pub(super) version: u32,
}

impl<'a> Reader<'a> {
    /// # Errors
    /// [`Error::Format`], [`Error::Unsupported`].
    pub(super) fn new(bytes: &'a [u8]) -> Result<Self, Error> {
        let no = || Error::Format { what: "this is no recording: it does not begin with CRUMPREC".into() };
        let mut head = bytes.strip_prefix(&MAGIC).ok_or_else(no)?;
        let (format, version) = u32::take(&mut head).zip(u32::take(&mut head)).ok_or_else(no)?;
        if format != FORMAT {
            let what = format!("a recording of format {format}; this library reads format {FORMAT}");
            return Err(Error::Unsupported { what });
        }
        Ok(Self { bytes, at: bytes.len() - head.len(), count: 0, version })
    }

    /// The next event; nothing at the end, also where the file ends within an event, as a crash leaves it.
    ///
    /// # Errors
    /// [`Error::Format`] where an event is damaged.
    pub(super) fn next(&mut self) -> Result<Option<Event>, Error> {
        let rest = &self.bytes[self.at..];
        let Some(head) = rest.get(..HEAD) else { return Ok(None) };
        let mut words = head;
        let (kind, zero, length) = (u32::take(&mut words), u32::take(&mut words), u64::take(&mut words));
        let end = length.and_then(|l| usize::try_from(l).ok()).and_then(|l| l.checked_add(HEAD));
        let Some((end, sum)) = end.and_then(|end| Some((end, rest.get(end..end.checked_add(8)?)?))) else {
            return Ok(None);
        };
        let damaged = |why: &str| {
            let what = format!("event {} of the recording, at byte {}, {why}", self.count + 1, self.at);
            Err(Error::Format { what })
        };
        if xxh3_64(&rest[..end]).to_le_bytes() != sum || zero != Some(0) {
            return damaged("is damaged: its checksum is another");
        }
        let Some(event) = kind.and_then(|kind| Event::take(kind, &rest[HEAD..end])) else {
            return damaged("is nothing that this library knows");
        };
        self.at += end + 8;
        self.count += 1;
        Ok(Some(event))
    }
}

#[cfg(test)]
mod tests {
    use super::super::calls::Number;
    use super::*;

    fn events() -> Vec<Event> {
        vec![
            Event::Call(Call::Deform { buffers: vec![Number(1), Number(2)] }),
            Event::Hit(Call::EndContact { instance: Number(3), contact_id: 4 }),
            Event::HitEnded(Ended { result: 0, value: 0 }),
            Event::Ended(Ended { result: 0, value: 77 }),
            Event::Refused {
                function: "crumple_context_deform".into(),
                result: 66,
                message: "buffers[0] is null".into(),
            },
        ]
    }

    fn written() -> Vec<u8> {
        let directory = tempfile::tempdir().unwrap();
        let path = directory.path().join("a.crumplerec");
        let mut writer = Writer::create(&path, 1000).unwrap();
        events().iter().for_each(|e| writer.write(e));
        drop(writer);
        std::fs::read(path).unwrap()
    }

    fn all(bytes: &[u8]) -> Result<Vec<Event>, Error> {
        let mut reader = Reader::new(bytes)?;
        assert_eq!(reader.version, 1000);
        let mut all = Vec::new();
        while let Some(event) = reader.next()? {
            all.push(event);
        }
        Ok(all)
    }

    #[test]
    fn events_come_back_and_the_end_is_marked() {
        let mut expected = events();
        expected.push(Event::End);
        assert_eq!(all(&written()).unwrap(), expected);
    }

    #[test]
    fn a_file_that_was_cut_short_ends_there_and_a_damaged_one_is_refused() {
        let bytes = written();
        let whole = all(&bytes).unwrap();
        for cut in 16..bytes.len() {
            let some = all(&bytes[..cut]).unwrap();
            assert_eq!(some, whole[..some.len()]);
        }
        for place in 16..bytes.len() {
            let mut damaged = bytes.clone();
            damaged[place] ^= 0x10;
            // A damaged length may also look like a file that was cut.
            match all(&damaged) {
                Ok(some) => assert!(some.len() < whole.len() && some == whole[..some.len()], "byte {place}"),
                Err(e) => assert!(e.to_string().contains("at byte"), "{e}"),
            }
        }
        assert!(all(b"glTF").unwrap_err().to_string().contains("no recording"));
        let mut newer = bytes;
        newer[8] = 9;
        assert!(all(&newer).unwrap_err().to_string().contains("format 9"));
    }
}
