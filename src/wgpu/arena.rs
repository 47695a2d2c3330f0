//! Meshes, examples and stamps on the device: uploaded once a set and level of detail, in a few large buffers.

use super::device::Gpu;
use crate::Error;
use crate::example::set::ExampleSet;
use crate::gpu::{Place, SkinWords, StampWords};
use std::sync::{Arc, Weak};

/// Bytes of the first chunk; each further one is twice as large, up to …
const FIRST: u64 = 16 << 20;
/// … this. A skin that needs more has a chunk of its own.
const LARGEST: u64 = 128 << 20;

/// Homes keep their chunk, targets their home; wgpu keeps what command buffers use. Chunks never grow.
#[derive(Default)]
pub(super) struct Arena {
    chunks: Vec<Slice>,
    residents: Vec<Resident>,
    /// Chunks made so far.
    made: u32,
}

/// A buffer of several meshes.
#[derive(Debug)]
pub(super) struct Chunk {
    pub id: u32,
    pub buffer: wgpu::Buffer,
}

/// How far a chunk is used.
struct Slice {
    chunk: Weak<Chunk>,
    words: u64,
    used: u64,
    stamps: Vec<(Weak<ExampleSet>, Arc<StampWords>, u32)>,
}

/// A skin on the device.
struct Resident {
    set: Weak<ExampleSet>,
    lod: usize,
    home: Weak<Home>,
}

/// Where a skin is.
#[derive(Debug)]
pub(super) struct Home {
    pub place: Place,
    pub chunk: Arc<Chunk>,
}

impl Arena {
    /// Where the skin is; where it is not, it is uploaded before the next submission runs.
    pub(super) fn home(&mut self, gpu: &Gpu, set: &Arc<ExampleSet>, lod: usize) -> Result<Arc<Home>, Error> {
        self.residents.retain(|r| r.home.strong_count() > 0);
        self.chunks.retain(|c| c.chunk.strong_count() > 0);
        let same = |w: &Weak<ExampleSet>| std::ptr::eq(w.as_ptr(), Arc::as_ptr(set));
        let known = self.residents.iter().find(|r| same(&r.set) && r.lod == lod);
        if let Some(home) = known.and_then(|r| r.home.upgrade()) {
            return Ok(home);
        }
        let skin = set.lod(lod)?;
        let words = SkinWords::new(skin);
        // Where the set's stamps are, they serve this skin too.
        let with_stamps = |c: &Slice| c.stamps.iter().find(|s| same(&s.0)).map(|s| (s.1.clone(), s.2));
        let left = |c: &Slice| c.words - c.used;
        let found = self.chunks.iter().position(|c| with_stamps(c).is_some() && left(c) >= words.total());
        let stamps = Arc::new(StampWords::new(set));
        let both = words.total() + stamps.total();
        let found = found.or_else(|| self.chunks.iter().position(|c| left(c) >= both));
        let (index, chunk) = match found.and_then(|index| Some((index, self.chunks[index].chunk.upgrade()?))) {
            Some(found) => found,
            None => self.add_chunk(gpu, both)?,
        };
        let slice = &mut self.chunks[index];
        let known = with_stamps(slice);
        let new = known.is_none();
        let skin_at = slice.used as u32;
        let (stamps, stamps_at) = known.unwrap_or((stamps, skin_at + words.total() as u32));
        upload(gpu, &chunk, (skin_at, words.total()), |to| words.write(skin, to))?;
        if new && stamps.total() > 0 {
            upload(gpu, &chunk, (stamps_at, stamps.total()), |to| stamps.write(set, to))?;
        }
        if new {
            slice.stamps.push((Arc::downgrade(set), stamps.clone(), stamps_at));
            slice.used += stamps.total();
        }
        slice.used += words.total();
        let place = Place { skin: words, stamps, skin_at, stamps_at };
        let home = Arc::new(Home { place, chunk });
        self.residents.push(Resident { set: Arc::downgrade(set), lod, home: Arc::downgrade(&home) });
        Ok(home)
    }

    fn add_chunk(&mut self, gpu: &Gpu, words: u64) -> Result<(usize, Arc<Chunk>), Error> {
        let most = gpu.most_bound().min(gpu.limits.max_buffer_size & !3);
        let bytes = 4 * words;
        if bytes > most {
            let what = format!(
                "a mesh and its examples of {bytes} bytes; max_storage_buffer_binding_size and max_buffer_size allow {most} on this device"
            );
            return Err(Error::Unsupported { what });
        }
        let size = (FIRST << self.chunks.len().min(8)).min(LARGEST).min(most).max(bytes);
        let usage = wgpu::BufferUsages::STORAGE | wgpu::BufferUsages::COPY_DST;
        self.made += 1;
        let chunk = Arc::new(Chunk { id: self.made, buffer: gpu.buffer("meshes and examples", size, usage)? });
        let slice = Slice { chunk: Arc::downgrade(&chunk), words: size / 4, used: 0, stamps: Vec::new() };
        self.chunks.push(slice);
        Ok((self.chunks.len() - 1, chunk))
    }

    /// Whether any target still needs a chunk.
    pub(super) fn has(&self, chunk: u32) -> bool {
        self.chunks.iter().any(|c| c.chunk.upgrade().is_some_and(|c| c.id == chunk))
    }
}

/// Has words written into a chunk before the next submission runs.
fn upload(gpu: &Gpu, chunk: &Chunk, (at, words): (u32, u64), write: impl FnOnce(&mut [u32])) -> Result<(), Error> {
    let mut all: Vec<u32> = crate::base::error::reserve(words as usize, "a mesh and its examples")?;
    all.resize(words as usize, 0);
    write(&mut all);
    let bytes = bytemuck::cast_slice(&all);
    gpu.checked("uploading a mesh and its examples", 4 * words, || {
        gpu.queue.write_buffer(&chunk.buffer, 4 * u64::from(at), bytes)
    })
}
