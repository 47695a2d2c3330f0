//! Recordings: the calls of a context written to a file, from which `crumple replay` makes the same dents anew.

mod calls;
mod file;
mod replay;
mod snapshot;
#[cfg(test)]
mod tests;

use super::buffer::BufferEntry;
use super::check::{CEnum, string};
use super::context::{CrumpleContext, exclusive};
use super::hit::{CrumpleHitResult, CrumpleHitStatus};
use super::ids::Id;
use super::instance::{CrumpleInstanceInfo, InstanceEntry};
use super::result::{CrumpleResult, Failure};
use super::types::CrumpleExampleSet;
use super::version::CRUMPLE_VERSION;
use crate::ExampleSet;
pub(super) use calls::{Bytes, Call, Number};
use file::{Ended, Event, Writer};
pub use replay::{Difference, Replay, replay};
use std::ffi::c_char;
use std::path::Path;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Mutex, MutexGuard, PoisonError};
use xxhash_rust::xxh3::xxh3_64;

/// Of a context: its recording, where there is one.
///
/// Hits come from any thread, and calls that have the context for themselves take all that have arrived. Whoever does either
/// holds the writer's lock meanwhile, so that the file tells which of them came first.
#[derive(Debug, Default)]
pub(super) struct Recorder {
    on: AtomicBool,
    writer: Mutex<Option<Writer>>,
}

impl Recorder {
    pub(super) fn is_on(&self) -> bool {
        self.on.load(Ordering::Acquire)
    }

    fn lock(&self) -> MutexGuard<'_, Option<Writer>> {
        self.writer.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// For a call that has the context for itself.
    pub(super) fn log(&self) -> Log<'_> {
        Log { recorder: self, guard: None, called: false, value: 0 }
    }

    /// For a hit; nothing where nothing is recorded. While it is held, no call takes the hits that have arrived.
    pub(super) fn hit(&self) -> Option<HitLog<'_>> {
        let guard = self.is_on().then(|| self.lock())?;
        guard.is_some().then_some(HitLog(guard))
    }
}

/// What one call writes.
pub(super) struct Log<'a> {
    recorder: &'a Recorder,
    guard: Option<MutexGuard<'a, Option<Writer>>>,
    called: bool,
    value: u64,
}

impl Log<'_> {
    /// Writes the call. Comes when its arguments have been read and before it does anything, so that one that crashes is in the
    /// file. From here on no hit arrives, until `open` or the call's end.
    pub(super) fn call(&mut self, call: impl FnOnce() -> Call) {
        if !self.recorder.is_on() {
            return;
        }
        let mut guard = self.recorder.lock();
        if let Some(writer) = &mut *guard {
            writer.write(&Event::Call(call()));
            self.called = true;
            self.guard = Some(guard);
        }
    }

    /// Lets hits arrive: this call has taken those that count for it, and what it does now may take its time or call the host,
    /// who may report hits.
    pub(super) fn open(&mut self) {
        self.guard = None;
    }

    /// Writes a set that is new, or has changed.
    pub(super) fn set(&mut self, id: CrumpleExampleSet, set: &ExampleSet) {
        if !self.recorder.is_on() {
            return;
        }
        match snapshot::set(id, set) {
            Ok(call) => self.call(|| call),
            // The set is there, and the host's; only the recording cannot go on.
            Err(error) => {
                self.called = true;
                if let Some(writer) = &mut *self.recorder.lock() {
                    writer.failed.get_or_insert(error);
                }
            }
        }
        self.gave_id(id);
    }

    /// Writes an instance that is made.
    pub(super) fn instance(&mut self, entry: &InstanceEntry) {
        self.call(|| snapshot::create(entry));
    }

    /// Writes a buffer that is registered.
    pub(super) fn buffer(&mut self, entry: &BufferEntry, set: &ExampleSet) {
        self.call(|| snapshot::register(entry, set));
    }

    /// Keeps what the call gave.
    pub(super) fn gave(&mut self, value: impl FnOnce() -> u64) {
        if self.called {
            self.value = value();
        }
    }

    /// Keeps the id of what the call made.
    pub(super) fn gave_id<I: Id>(&mut self, id: I) {
        self.gave(|| Number::of(id).0);
    }

    /// Writes how the call ended. Answers why nothing more is recorded, the first time that this is so.
    pub(super) fn ended(mut self, function: &str, result: &Result<(), Failure>) -> Option<String> {
        let event = match (self.called, result) {
            (true, result) => {
                let result = result.as_ref().map_or_else(|failure| failure.result, |()| CrumpleResult::CrumpleOk);
                Event::Ended(Ended { result: result as u32, value: self.value })
            }
            (false, Err(failure)) if self.recorder.is_on() => Event::Refused {
                function: function.into(),
                result: failure.result as u32,
                message: failure.message.clone(),
            },
            _ => return None,
        };
        let guard = self.guard.take().unwrap_or_else(|| self.recorder.lock());
        write_last(guard, &event)
    }
}

/// Of a hit.
pub(super) struct HitLog<'a>(MutexGuard<'a, Option<Writer>>);

impl HitLog<'_> {
    pub(super) fn call(&mut self, call: Call) {
        if let Some(writer) = &mut *self.0 {
            writer.write(&Event::Hit(call));
        }
    }

    pub(super) fn ended(self, result: CrumpleResult, value: u64) -> Option<String> {
        write_last(self.0, &Event::HitEnded(Ended { result: result as u32, value }))
    }
}

/// Writes a call's last event. Answers with the failure that this, or what came before it in the call, ran into.
fn write_last(mut guard: MutexGuard<'_, Option<Writer>>, event: &Event) -> Option<String> {
    let writer = guard.as_mut()?;
    let told = writer.told;
    writer.write(event);
    let failed = writer.failed.as_ref()?;
    writer.told = true;
    (!told).then(|| format!("the recording ends here: {failed}"))
}

/// A number that stands for an array.
pub(super) fn digest(bytes: &[u8]) -> u64 {
    xxh3_64(bytes)
}

/// A number that stands for what of an instance's state hits decide.
pub(super) fn info_number(info: &CrumpleInstanceInfo) -> u64 {
    u64::from(info.mark_count) | u64::from(info.contact_count) << 32
}

/// A number that stands for what a hit was answered.
pub(super) fn hit_digest(hit: &CrumpleHitResult) -> u64 {
    let status = CrumpleHitStatus::read(hit.status).map_or(u32::MAX, |status| status as u32);
    let mut all = Vec::with_capacity(256);
    let mut put = |bytes: &[u8]| all.extend_from_slice(bytes);
    put(bytemuck::bytes_of(&[status, hit.contact_vertex, hit.chosen_count, u32::from(hit.clamped)]));
    put(bytemuck::bytes_of(&hit.contact_distance));
    put(bytemuck::bytes_of(&[hit.target, hit.achieved]));
    for chosen in &hit.chosen {
        put(bytemuck::bytes_of(&[chosen.example, u32::from(chosen.anchored), u32::from(chosen.mirror)]));
        put(bytemuck::bytes_of(&[chosen.share, chosen.scale]));
    }
    put(bytemuck::bytes_of(&hit.mark));
    xxh3_64(&all)
}

/// Begins to write what is called with this context to a file, so that it can be played again: "crumple replay FILE" makes the
/// same calls in the same order without your engine, tells whether every result and every vertex is the same, and is how a bug
/// that you see becomes a test that we can run. The file, path (UTF-8), is made new; it first gets what there is: the example
/// sets, whole, the instances with their damage, the buffers. It grows by some hundred bytes a hit and a frame, written at once,
/// so that a crash loses nothing. Every buffer is written whole by the next deform, as after crumple_buffer_invalidate().
///
/// What Vulkan calls write is not compared, but made on the CPU; calls that are refused, other than hits, are noted with their
/// message. Hits wait for each other and for calls that take them meanwhile, so leave it off in what you ship, or keep it for when a
/// player asks.
///
/// Externally synchronised; hits may arrive meanwhile. Errors: CRUMPLE_ERROR_NULL_POINTER, CRUMPLE_ERROR_INVALID_ID,
/// CRUMPLE_ERROR_INVALID_ARGUMENT (path is not UTF-8; a recording runs already; an instance has open contacts: end them first),
/// CRUMPLE_ERROR_IO, CRUMPLE_ERROR_UNSUPPORTED (a big-endian processor), CRUMPLE_ERROR_OUT_OF_MEMORY,
/// CRUMPLE_ERROR_CONCURRENT_USE. Nothing is recorded then.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn crumple_recording_begin(context: *mut CrumpleContext, path: *const c_char) -> CrumpleResult {
    exclusive("crumple_recording_begin", context, |context, state| {
        // SAFETY: the caller's.
        let path = unsafe { string(path, "path") }?;
        let path = path.ok_or_else(|| Failure::new(CrumpleResult::CrumpleErrorNullPointer, "path is null"))?;
        if let Some(writer) = &*context.recorder.lock() {
            let runs = writer.path().display();
            return Err(Failure::invalid(format!("a recording to {runs} runs already; crumple_recording_end() first")));
        }
        // Hits that are under way arrive before the snapshot, those that come now wait for the recording.
        let _none_arrives = context.inboxes.write().unwrap_or_else(PoisonError::into_inner);
        let mut recording = context.recorder.lock();
        snapshot::check(state)?;
        let mut writer = Writer::create(Path::new(path), CRUMPLE_VERSION)?;
        snapshot::write(state, &mut writer)?;
        if let Some(error) = writer.failed.take() {
            return Err(error.into());
        }
        *recording = Some(writer);
        context.recorder.on.store(true, Ordering::Release);
        Ok(())
    })
}

/// Ends a recording: the file is whole. crumple_context_destroy() does so too.
///
/// Externally synchronised; hits may arrive meanwhile. Errors: CRUMPLE_ERROR_NULL_POINTER, CRUMPLE_ERROR_INVALID_ID,
/// CRUMPLE_ERROR_INVALID_ARGUMENT (no recording runs), CRUMPLE_ERROR_IO (the file could not be written to its end: what is there
/// can be replayed; the recording has ended), CRUMPLE_ERROR_CONCURRENT_USE.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn crumple_recording_end(context: *mut CrumpleContext) -> CrumpleResult {
    exclusive("crumple_recording_end", context, |context, _| {
        context.recorder.on.store(false, Ordering::Release);
        let writer = context.recorder.lock().take();
        let mut writer =
            writer.ok_or_else(|| Failure::invalid("no recording runs; crumple_recording_begin() first"))?;
        writer.write(&Event::End);
        match writer.failed.take() {
            Some(error) => Err(error.into()),
            None => Ok(()),
        }
    })
}
