//! A context's recording: which events the calls write.

use super::ids::Id;
use super::record_call::{Call, Number};
use super::record_file::{Ended, Event, Writer};
use super::result::{CrumpleResult, Failure};
use super::snapshot;
use super::store::{BufferEntry, InstanceEntry};
use super::types::CrumpleExampleSet;
use crate::example::set::ExampleSet;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Mutex, MutexGuard, PoisonError};
use twox_hash::XxHash3_64;

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
    /// From now on calls are written.
    pub(super) fn begin(&self) {
        self.on.store(true, Ordering::Release);
    }

    /// Ends the recording; its writer, where there was one.
    pub(super) fn end(&self) -> Option<Writer> {
        self.on.store(false, Ordering::Release);
        self.lock().take()
    }

    pub(super) fn is_on(&self) -> bool {
        self.on.load(Ordering::Acquire)
    }

    pub(super) fn lock(&self) -> MutexGuard<'_, Option<Writer>> {
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

    /// One hit of several was taken.
    pub(super) fn taken(&mut self, value: u64) {
        if let Some(writer) = &mut *self.0 {
            writer.write(&Event::HitEnded(Ended { result: 0, value }));
        }
    }

    /// Hits were refused before any was taken.
    pub(super) fn refused(mut self, function: &str, failure: &Failure) {
        let Failure { result, message, .. } = failure;
        let event = Event::Refused { function: function.into(), result: *result as u32, message: message.clone() };
        if let Some(writer) = &mut *self.0 {
            writer.write(&event);
        }
    }

    /// What the writer ran into; told once.
    pub(super) fn trouble(self) -> Option<String> {
        trouble(self.0)
    }
}

/// Writes a call's last event. Answers with the failure that this, or what came before it in the call, ran into.
fn write_last(mut guard: MutexGuard<'_, Option<Writer>>, event: &Event) -> Option<String> {
    guard.as_mut()?.write(event);
    trouble(guard)
}

/// Why nothing more is recorded, the first time that this is so.
fn trouble(mut guard: MutexGuard<'_, Option<Writer>>) -> Option<String> {
    let writer = guard.as_mut()?;
    let told = writer.told;
    let failed = writer.failed.as_ref()?;
    writer.told = true;
    (!told).then(|| format!("the recording ends here: {failed}"))
}

/// A number that stands for an array.
pub(super) fn digest(bytes: &[u8]) -> u64 {
    XxHash3_64::oneshot(bytes)
}
