//! The file of a recording: a header, then one event after the other. Each event is written when it happens and has a checksum,
//! so that a replay can follow the file of a crashed program up to the call that crashed.

use super::record_call::Call;
use crate::base::error::Error;
use serde::{Deserialize, Serialize};
use std::fs::File;
use std::io::Write;
use std::path::{Path, PathBuf};
use twox_hash::XxHash3_64;

const MAGIC: [u8; 8] = *b"CRUMPREC";
/// Grows when old readers could not read new files.
const FORMAT: u32 = 4;
/// The magic bytes, the format and the library's version.
const HEADER: usize = 16;
/// Before an event: its length and its checksum, 8 bytes each.
const HEAD: usize = 16;

/// How a call ended: a `CrumpleResult`, and a number that stands for its outputs.
#[derive(Clone, Copy, PartialEq, Eq, Debug, Serialize, Deserialize)]
pub(super) struct Ended {
    pub(super) result: u32,
    pub(super) value: u64,
}

/// One thing that happened.
#[derive(Clone, PartialEq, Debug, Serialize, Deserialize)]
pub(super) enum Event {
    /// A call that has the context for itself begins.
    Call(Call),
    /// It ended.
    Ended(Ended),
    /// A hit arrives, perhaps while such a call runs.
    Hit(Call),
    /// The hit was taken.
    HitEnded(Ended),
    /// A call was refused before it did anything.
    Refused { function: String, result: u32, message: String },
    /// The recording ended as it should.
    End,
}

/// The length and checksum of an event, which is written as postcard.
fn head(event: &[u8]) -> [u8; HEAD] {
    let length = event.len() as u64;
    let mut head = [0; HEAD];
    head[..8].copy_from_slice(&length.to_le_bytes());
    head[8..].copy_from_slice(&XxHash3_64::oneshot_with_seed(length, event).to_le_bytes());
    head
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
    /// [`Error::Io`].
    pub(super) fn create(path: &Path, version: u32) -> Result<Self, Error> {
        let io = |e: std::io::Error| Error::Io { path: path.display().to_string(), message: e.to_string() };
        let mut file = File::create(path).map_err(io)?;
        let header = [&MAGIC[..], &FORMAT.to_le_bytes(), &version.to_le_bytes()].concat();
        file.write_all(&header).map_err(io)?;
        Ok(Self { file, path: path.into(), failed: None, told: false, ended: false })
    }

    pub(super) fn path(&self) -> &Path {
        &self.path
    }

    /// Writes an event in one piece. The first failure is kept, and ends the recording.
    pub(super) fn write(&mut self, event: &Event) {
        if self.failed.is_none()
            && !self.ended
            && let Err(message) = self.append(event)
        {
            self.failed = Some(Error::Io { path: self.path.display().to_string(), message });
        }
        self.ended |= *event == Event::End;
    }

    fn append(&mut self, event: &Event) -> Result<(), String> {
        let mut bytes = postcard::to_extend(event, vec![0; HEAD]).map_err(|e| e.to_string())?;
        let head = head(&bytes[HEAD..]);
        bytes[..HEAD].copy_from_slice(&head);
        self.file.write_all(&bytes).map_err(|e| e.to_string())
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
    /// Version of the library that wrote it, as `crumple_version()` gives it.
    pub(super) version: u32,
}

impl<'a> Reader<'a> {
    /// # Errors
    /// [`Error::Format`], [`Error::Unsupported`].
    pub(super) fn new(bytes: &'a [u8]) -> Result<Self, Error> {
        let Some((&MAGIC, rest)) = bytes.split_first_chunk() else {
            let what = "this is no recording: it does not begin with CRUMPREC";
            return Err(Error::Format { what: what.into() });
        };
        let Some([format, version]) = rest.as_chunks().0.first_chunk().map(|w| w.map(u32::from_le_bytes)) else {
            return Err(Error::Format { what: "this is no recording: its header is cut short".into() });
        };
        if format != FORMAT {
            let what = format!("a recording of format {format}; this library reads format {FORMAT}");
            return Err(Error::Unsupported { what });
        }
        Ok(Self { bytes, at: HEADER, count: 0, version })
    }

    /// The next event; `None` at the end, also where the file ends within an event, as after a crash.
    ///
    /// # Errors
    /// [`Error::Format`] where an event is damaged.
    pub(super) fn next(&mut self) -> Result<Option<Event>, Error> {
        let rest = &self.bytes[self.at..];
        let Some((found, rest)) = rest.split_first_chunk::<HEAD>() else { return Ok(None) };
        let length = u64::from_le_bytes(*found.first_chunk().expect("a head has 16 bytes"));
        let Some(body) = usize::try_from(length).ok().and_then(|length| rest.get(..length)) else { return Ok(None) };
        let damaged = |why: &str| Error::Format {
            what: format!("event {} of the recording, at byte {}, {why}", self.count + 1, self.at),
        };
        if *found != head(body) {
            return Err(damaged("is damaged: its checksum is wrong"));
        }
        let event = match postcard::take_from_bytes(body) {
            Ok((event, [])) => event,
            _ => return Err(damaged("is unknown to this library")),
        };
        self.at += HEAD + body.len();
        self.count += 1;
        Ok(Some(event))
    }
}

#[cfg(test)]
mod tests {
    use super::super::record_call::{Bytes, Number};
    use super::*;
    use proptest::prelude::*;

    fn events() -> Vec<Event> {
        let bytes = Bytes(vec![1, 2, 3]);
        vec![
            Event::Call(Call::Deform { all: false, buffers: vec![Number(1), Number(2)] }),
            Event::Hit(Call::EndContact { instance: Number(3), contact_id: 4 }),
            Event::HitEnded(Ended { result: 0, value: 0 }),
            Event::Ended(Ended { result: 0, value: 77 }),
            Event::Call(Call::SetMarks { instance: Number(u64::MAX), marks: bytes }),
            Event::Call(Call::SetTransform { instance: Number(0), local_to_world: [-0.0; 16] }),
            Event::Refused { function: "crumple_context_deform".into(), result: 66, message: "buffers[0]".into() },
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
        for cut in HEADER..bytes.len() {
            let some = all(&bytes[..cut]).unwrap();
            assert_eq!(some, whole[..some.len()]);
        }
        for place in HEADER..bytes.len() {
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

    proptest! {
        /// Whatever the bytes are: an event or an error, and no more memory than a small multiple of them.
        #[test]
        fn any_bytes_with_a_checksum_are_an_event_or_refused(kind in 0u8..7, call in 0u8..30, junk: Vec<u8>) {
            let body = [&[kind, call][..], &junk].concat();
            let header = [&MAGIC[..], &FORMAT.to_le_bytes(), &1000u32.to_le_bytes()].concat();
            let file = [&header[..], &head(&body), &body].concat();
            if let Err(e) = all(&file) {
                prop_assert!(e.to_string().contains("unknown"), "{e}");
            }
        }
    }
}
