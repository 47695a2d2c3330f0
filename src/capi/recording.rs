//! Recordings: the calls of a context written to a file, from which `crumple replay` makes the same dents again.

use super::check::required_string;
use super::context::{CrumpleContext, exclusive, lean};
use super::record_file::{Event, Writer};
use super::result::{CrumpleResult, Failure};
use super::snapshot;
use super::version::CRUMPLE_VERSION;
use std::ffi::c_char;
use std::path::Path;
use std::sync::PoisonError;

/// Records the context's calls to a file. path is UTF-8. "crumple replay FILE" repeats the calls without your engine
/// and checks that every result and vertex is equal, so that a bug becomes a test. The file starts with the existing
/// sets, instances, damage and buffers. It grows by some hundred bytes per hit and frame, written immediately, so that
/// a crash loses nothing. The next deform writes every vertex of every buffer, growing dents are shown in full, and
/// contacts that ended are forgotten. Vulkan buffers are replayed on the CPU and not compared. Failed calls are recorded
/// with their message. Hits may still come from any thread, but are serialised while recording, so leave it off in
/// releases. Errors: CRUMPLE_ERROR_INVALID_ARGUMENT (a recording is running, or an instance has open contacts, parts or
/// thresholds), CRUMPLE_ERROR_IO.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn crumple_recording_begin(context: *mut CrumpleContext, path: *const c_char) -> CrumpleResult {
    exclusive("crumple_recording_begin", context, |context, state| {
        let path = required_string(path, "path")?;
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
        context.recorder.begin();
        Ok(())
    })
}

/// Ends the recording and completes the file. crumple_context_destroy() does so too. CRUMPLE_ERROR_IO: the file could
/// not be completed. Its content can still be replayed, and the recording has ended.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn crumple_recording_end(context: *mut CrumpleContext) -> CrumpleResult {
    lean("crumple_recording_end", context, |context, _| {
        let mut writer = context
            .recorder
            .end()
            .ok_or_else(|| Failure::invalid("no recording runs; crumple_recording_begin() first"))?;
        writer.write(&Event::End);
        match writer.failed.take() {
            Some(error) => Err(error.into()),
            None => Ok(()),
        }
    })
}
