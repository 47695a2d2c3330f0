//! Meshes, examples and stamps on the device: uploaded once a set and level of detail, in a few large buffers.

use super::device::Gpu;
use super::memory::{Buffer, Use};
use crate::Error;
use crate::example::mesh_lod::MeshLod;
use crate::example::set::ExampleSet;
use crate::gpu::{Place, SkinWords, StampWords};
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Arc, Weak};

/// Bytes of the first chunk; each further one is twice as large, up to …
const FIRST: u64 = 16 << 20;
/// … this. A skin that needs more has a chunk of its own.
const LARGEST: u64 = 128 << 20;

/// Chunks never grow, so that nothing that a frame in flight reads moves.
#[derive(Default)]
pub(super) struct Arena {
    chunks: Vec<Chunk>,
    residents: Vec<Resident>,
    /// Chunks made so far.
    made: u32,
}

struct Chunk {
    id: u32,
    buffer: Buffer,
    /// Words taken.
    used: u64,
    stamps: Vec<(Weak<ExampleSet>, Arc<StampWords>, u32)>,
}

/// A skin on the device.
struct Resident {
    set: Weak<ExampleSet>,
    lod: usize,
    home: Arc<Home>,
    upload: Option<Upload>,
}

/// Where a skin is.
#[derive(Debug)]
pub(super) struct Home {
    pub place: Place,
    pub chunk: u32,
    /// The last frame that reads it.
    pub used: AtomicU64,
}

/// What is still to be copied.
struct Upload {
    staging: Buffer,
    /// Bytes from the start of the staging buffer, from that of the chunk, and how many: skin, and stamps where they are new.
    copies: Vec<(u64, u64, u64)>,
    recorded: Option<u64>,
}

impl Arena {
    /// Where the skin is: where it was, or where it will be once the next frame's upload has run.
    pub(super) fn home(&mut self, gpu: &Gpu, set: &Arc<ExampleSet>, lod: usize) -> Result<Arc<Home>, Error> {
        let same = |w: &Weak<ExampleSet>| std::ptr::eq(w.as_ptr(), Arc::as_ptr(set));
        if let Some(r) = self.residents.iter().find(|r| same(&r.set) && r.lod == lod) {
            return Ok(r.home.clone());
        }
        let skin = set.lod(lod)?;
        let words = SkinWords::new(skin);
        // Where the set's stamps are, they serve this skin too.
        let with_stamps = |c: &Chunk| c.stamps.iter().find(|s| same(&s.0)).map(|s| (s.1.clone(), s.2));
        let left = |c: &Chunk| c.buffer.size / 4 - c.used;
        let found = self.chunks.iter().position(|c| with_stamps(c).is_some() && left(c) >= words.total());
        let stamps = Arc::new(StampWords::new(set));
        let both = words.total() + stamps.total();
        let index = match found.or_else(|| self.chunks.iter().position(|c| left(c) >= both)) {
            Some(index) => index,
            None => self.add_chunk(gpu, both)?,
        };
        let chunk = &mut self.chunks[index];
        let known = with_stamps(chunk);
        let new = known.is_none();
        let skin_at = chunk.used as u32;
        let (stamps, stamps_at) = known.unwrap_or((stamps, skin_at + words.total() as u32));
        let upload = upload(gpu, (skin, &words, skin_at), (set, new.then_some((&stamps, stamps_at))))?;
        if new {
            chunk.stamps.push((Arc::downgrade(set), stamps.clone(), stamps_at));
            chunk.used += stamps.total();
        }
        chunk.used += words.total();
        let place = Place { skin: words, stamps, skin_at, stamps_at };
        let home = Arc::new(Home { place, chunk: chunk.id, used: AtomicU64::new(0) });
        let set = Arc::downgrade(set);
        self.residents.push(Resident { set, lod, home: home.clone(), upload: Some(upload) });
        Ok(home)
    }

    fn add_chunk(&mut self, gpu: &Gpu, words: u64) -> Result<usize, Error> {
        let most = u64::from(gpu.limits.max_storage_buffer_range);
        let bytes = 4 * words;
        if bytes > most {
            let what =
                format!("a mesh and its examples of {bytes} bytes; maxStorageBufferRange is {most} on this device");
            return Err(Error::Unsupported { what });
        }
        let size = (FIRST << self.chunks.len().min(8)).min(LARGEST).min(most & !3).max(bytes);
        let buffer = gpu.buffer(size, Use::Storage)?;
        self.made += 1;
        self.chunks.push(Chunk { id: self.made, buffer, used: 0, stamps: Vec::new() });
        Ok(self.chunks.len() - 1)
    }

    /// The buffer of a chunk that a home is in.
    pub(super) fn chunk(&self, id: u32) -> &Buffer {
        let chunk = self.chunks.iter().find(|c| c.id == id);
        &chunk.expect("a chunk lives as long as any home in it").buffer
    }

    /// Calls `copy` with staging buffer, chunk and ranges of everything that has not been uploaded.
    pub(super) fn record(&mut self, frame: u64, mut copy: impl FnMut(&Buffer, &Buffer, &[(u64, u64, u64)])) {
        for r in &mut self.residents {
            let Some(upload) = r.upload.as_mut().filter(|u| u.recorded.is_none()) else { continue };
            let chunk = self.chunks.iter().find(|c| c.id == r.home.chunk).expect("as above");
            copy(&upload.staging, &chunk.buffer, &upload.copies);
            upload.recorded = Some(frame);
            r.home.used.fetch_max(frame, Ordering::Relaxed);
        }
    }

    /// Frees what frames up to `done` needed; calls `freed` with each chunk that is no more.
    pub(super) fn completed(&mut self, gpu: &Gpu, done: u64, mut freed: impl FnMut(u32)) {
        self.residents.retain_mut(|r| {
            if let Some(upload) = r.upload.take_if(|u| u.recorded.is_some_and(|frame| frame <= done)) {
                // SAFETY: the frame that copied from it is done.
                unsafe { gpu.destroy(&upload.staging) };
            }
            let kept = Arc::strong_count(&r.home) > 1 || r.home.used.load(Ordering::Relaxed) > done;
            if !kept && let Some(upload) = &r.upload {
                // SAFETY: nothing was recorded with it.
                unsafe { gpu.destroy(&upload.staging) };
            }
            kept
        });
        self.chunks.retain(|c| {
            let kept = self.residents.iter().any(|r| r.home.chunk == c.id);
            if !kept {
                freed(c.id);
                // SAFETY: the frames that read it are done.
                unsafe { gpu.destroy(&c.buffer) };
            }
            kept
        });
    }

    pub(super) fn discard(&mut self, frame: u64) {
        let uploads = self.residents.iter_mut().filter_map(|r| r.upload.as_mut());
        uploads.filter(|u| u.recorded.is_some_and(|f| f >= frame)).for_each(|u| u.recorded = None);
    }

    /// # Safety
    /// Nothing uses it any more.
    pub(super) unsafe fn destroy(&self, gpu: &Gpu) {
        let staging = self.residents.iter().filter_map(|r| r.upload.as_ref()).map(|u| &u.staging);
        for buffer in staging.chain(self.chunks.iter().map(|c| &c.buffer)) {
            // SAFETY: passed on.
            unsafe { gpu.destroy(buffer) };
        }
    }
}

/// Fills a staging buffer with a skin, and with its set's stamps where they are new.
fn upload(
    gpu: &Gpu,
    (skin, words, skin_at): (&MeshLod, &SkinWords, u32),
    (set, stamps): (&ExampleSet, Option<(&Arc<StampWords>, u32)>),
) -> Result<Upload, Error> {
    let (skin_words, stamp_words) = (words.total(), stamps.map_or(0, |(s, _)| s.total()));
    let mut staging = gpu.buffer(4 * (skin_words + stamp_words), Use::Staging)?;
    let mut copies = vec![(0, 4 * u64::from(skin_at), 4 * skin_words)];
    if let Some((_, at)) = stamps.filter(|_| stamp_words > 0) {
        copies.push((4 * skin_words, 4 * u64::from(at), 4 * stamp_words));
    }
    let written = gpu.write(&mut staging, (skin_words + stamp_words) as usize, |to| {
        let (first, second) = to.split_at_mut(skin_words as usize);
        words.write(skin, first);
        if let Some((stamps, _)) = stamps {
            stamps.write(set, second);
        }
    });
    if written.is_err() {
        // SAFETY: nothing uses it yet.
        unsafe { gpu.destroy(&staging) };
    }
    written?;
    Ok(Upload { staging, copies, recorded: None })
}
