//! The one way into the library: panics stop here, and say so in the result instead of on the terminal.

use super::result::{CrumpleResult, Failure, remember};
use crate::base::memory::{begin_call, was_refused};
use std::cell::Cell;
use std::panic::{self, AssertUnwindSafe};
use std::sync::Once;

/// Runs the body of the entry point `call`. What it answers, or how it fails, becomes the result and the last error's
/// text.
pub(super) fn boundary(call: &'static str, body: impl FnOnce() -> Result<(), Failure>) -> CrumpleResult {
    match quietly(body) {
        Ok(Ok(())) => CrumpleResult::CrumpleOk,
        Ok(Err(failure)) => {
            remember(call, &failure.message);
            failure.result
        }
        Err(message) => {
            remember(call, &format!("internal error: {message}"));
            CrumpleResult::CrumpleErrorInternal
        }
    }
}

/// An entry point that needs a feature: `enter` runs its body if the library was built with it, else it fails.
macro_rules! built_with {
    ($feature:tt, $enter:ident, $call:literal $(, $argument:expr)+ $(,)?) => {{
        #[cfg(feature = $feature)]
        let result = $enter($call $(, $argument)+);
        #[cfg(not(feature = $feature))]
        let result = $crate::capi::boundary::boundary($call, || Err(Failure::not_built($feature)));
        result
    }};
}
pub(super) use built_with;

/// Fails if the host's allocator refused a block since the call began. The block is the system's then: not every allocation of
/// Rust may fail. Calls ask before they keep what they have made, so that a full heap does not fill the system's memory.
pub(super) fn granted() -> Result<(), Failure> {
    if was_refused() { Err(Failure::out_of_memory("the call: the host's allocator refused a block")) } else { Ok(()) }
}

/// Whether `body` succeeds. The last error's text stays.
pub(super) fn succeeds(body: impl FnOnce() -> Result<(), Failure>) -> bool {
    quietly(body).is_ok_and(|result| result.is_ok())
}

/// Runs `body`; a panic in it prints nothing and comes back as its message.
pub(super) fn quietly<T>(body: impl FnOnce() -> T) -> Result<T, String> {
    silence_panics();
    if DEPTH.get() == 0 {
        begin_call();
    }
    DEPTH.set(DEPTH.get() + 1);
    let result = panic::catch_unwind(AssertUnwindSafe(body));
    DEPTH.set(DEPTH.get() - 1);
    result.map_err(|payload| {
        let text = payload.downcast_ref::<String>().cloned();
        text.or_else(|| payload.downcast_ref::<&str>().map(|text| text.to_string())).unwrap_or_else(|| {
            std::mem::forget(payload); // its drop might panic, and nothing would catch it
            "a panic without a message".into()
        })
    })
}

thread_local! {
    /// How many entry points or tasks of this library the thread is inside.
    static DEPTH: Cell<u32> = const { Cell::new(0) };
}

/// std prints every panic before it unwinds. Puts a hook before the one there is, once: it stays silent where the
/// panicking thread is inside this library, and passes all others on, so a Rust program's own hook keeps working.
fn silence_panics() {
    static HOOK: Once = Once::new();
    if HOOK.is_completed() || std::thread::panicking() {
        return;
    }
    HOOK.call_once(|| {
        let before = panic::take_hook();
        panic::set_hook(Box::new(move |info| {
            if DEPTH.get() == 0 {
                before(info);
            }
        }));
    });
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::ffi::CStr;

    fn last_error() -> String {
        // SAFETY: never null, ends with a zero, and no other call of this thread changes it meanwhile.
        unsafe { CStr::from_ptr(super::super::result::crumple_last_error()) }.to_string_lossy().into_owned()
    }

    #[test]
    fn a_panic_becomes_an_internal_error_with_its_message() {
        let result = boundary("crumple_test", || panic!("seven is {}", 8));
        assert_eq!(result, CrumpleResult::CrumpleErrorInternal);
        assert_eq!(last_error(), "crumple_test: internal error: seven is 8");
        assert_eq!(boundary("crumple_test", || Ok(())), CrumpleResult::CrumpleOk);
    }

    #[test]
    fn a_long_text_is_cut_at_a_character() {
        boundary("crumple_test", || Err(Failure::invalid("ü\0".repeat(2000))));
        let text = last_error();
        assert!(text.len() <= 1023 && text.ends_with(['ü', '\u{fffd}']), "{text}");
    }
}
