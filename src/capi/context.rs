//! The context: everything an engine makes, its threads, and who may be inside when.

use super::boundary::boundary;
use super::buffer::BufferEntry;
use super::check::{CEnum, Def, MadeBy, Out, def};
use super::ids::Slots;
use super::instance::InstanceEntry;
use super::recording::{Log, Recorder};
use super::result::{CrumpleResult, Failure};
use super::set::SetEntry;
use super::tasks::{CrumpleTaskSystem, HostTasks};
use super::vulkan::Attached;
use crate::{Inbox, TaskSystem, ThreadPool};
use std::ffi::{CString, c_char, c_void};
use std::mem::MaybeUninit;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError, RwLock, TryLockError};

/// How much a log message matters.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum CrumpleLogLevel {
    /// What was done.
    Info = 0,
    /// Something that works but is probably not what was meant.
    Warning = 1,
}

impl CEnum for CrumpleLogLevel {
    const ALL: &'static [Self] = &[Self::Info, Self::Warning];
}

/// Receives one message, UTF-8, without a line break at its end; the text is gone when the callback returns. Called
/// from the thread that called Crumple. Must not call Crumple with the same context, throw, or jump out.
pub type CrumpleLog =
    Option<unsafe extern "C" fn(level: MaybeUninit<CrumpleLogLevel>, message: *const c_char, user: *mut c_void)>;

/// Everything that Crumple knows. Opaque.
pub struct CrumpleContext;

/// How a context works.
#[repr(C)]
#[derive(Debug, Clone, Copy)]
pub struct CrumpleContextDef {
    /// Bytes of this struct, from crumple_context_def_default().
    pub struct_size: u32,
    /// Threads that deform: 0 one for each core, 1 only the calling thread, up to 1024. Without meaning where tasks
    /// is set. Default 0.
    pub threads: u32,
    /// Receives messages. Null: none. Default null.
    pub log: CrumpleLog,
    /// Handed to log, untouched.
    pub log_user: *mut c_void,
    /// Your job system, instead of threads of Crumple's own. Default zero: none.
    pub tasks: CrumpleTaskSystem,
}

// SAFETY: `repr(C)`, starts with its size, and any bytes are a value of it.
unsafe impl Def for CrumpleContextDef {
    const DEFAULT: MadeBy<Self> = ("crumple_context_def_default", crumple_context_def_default);
}

pub(super) struct Context {
    log: CrumpleLog,
    log_user: *mut c_void,
    tasks: Box<dyn TaskSystem + Send + Sync>,
    state: Mutex<State>,
    /// The same ids as `State::instances`, for the calls that may come from any thread. Changed only while `state` is
    /// held.
    pub(super) inboxes: RwLock<Slots<Arc<Inbox>>>,
    pub(super) recorder: Recorder,
}

// SAFETY: `log_user` is only handed back to the host, on the thread that called.
unsafe impl Send for Context {}
// SAFETY: as above.
unsafe impl Sync for Context {}

/// What only one thread may touch at a time.
pub(super) struct State {
    pub(super) sets: Slots<SetEntry>,
    pub(super) instances: Slots<InstanceEntry>,
    pub(super) buffers: Slots<BufferEntry>,
    /// The host's Vulkan device.
    pub(super) vulkan: Option<Attached>,
}

/// The contexts there are. What C holds is a number that is never used twice, not an address, so that a destroyed
/// context is an error as well.
static CONTEXTS: RwLock<Contexts> = RwLock::new(Contexts { last: 0, live: Vec::new() });

struct Contexts {
    last: usize,
    live: Vec<(usize, Arc<Context>)>,
}

/// Keeps context pointers looking like pointers: never small, always aligned.
const STEP: usize = 64;

fn find(context: *const CrumpleContext) -> Result<Arc<Context>, Failure> {
    if context.is_null() {
        return Err(Failure::new(CrumpleResult::CrumpleErrorNullPointer, "context is null"));
    }
    let contexts = CONTEXTS.read().unwrap_or_else(PoisonError::into_inner);
    let found = contexts.live.iter().find(|(number, _)| *number == context.addr());
    found.map(|(_, context)| context.clone()).ok_or_else(|| {
        let message = format!("context {context:p} was destroyed or never created");
        Failure::new(CrumpleResult::CrumpleErrorInvalidId, message)
    })
}

impl Context {
    fn enter(&self) -> Result<MutexGuard<'_, State>, Failure> {
        match self.state.try_lock() {
            Ok(state) => Ok(state),
            // A panic inside left everything in a state that is safe to use, if perhaps unexpected.
            Err(TryLockError::Poisoned(state)) => Ok(state.into_inner()),
            Err(TryLockError::WouldBlock) => Err(Failure::new(
                CrumpleResult::CrumpleErrorConcurrentUse,
                "another thread is inside this context, or a callback calls back into it; take turns (only crumple_submit_ \
                 functions and crumple_instance_end_contact may be called at any time)",
            )),
        }
    }

    pub(super) fn tasks(&self) -> &dyn TaskSystem {
        &*self.tasks
    }

    pub(super) fn log(&self, level: CrumpleLogLevel, message: &str) {
        let Some(log) = self.log else { return };
        let text = CString::new(message.replace('\0', "\u{fffd}")).unwrap_or_default();
        // SAFETY: the host promised that its function may be called so; the text lives across the call.
        unsafe { log(MaybeUninit::new(level), text.as_ptr(), self.log_user) }
    }
}

/// Runs an entry point that needs the context for itself.
pub(super) fn exclusive(
    call: &'static str,
    context: *const CrumpleContext,
    body: impl FnOnce(&Context, &mut State) -> Result<(), Failure>,
) -> CrumpleResult {
    boundary(call, || {
        let context = find(context)?;
        let mut state = context.enter()?;
        body(&context, &mut state)
    })
}

/// The same for one that a recording holds: which says so once its arguments are read, and what it gave.
pub(super) fn recorded(
    call: &'static str,
    context: *const CrumpleContext,
    body: impl FnOnce(&Context, &mut State, &mut Log<'_>) -> Result<(), Failure>,
) -> CrumpleResult {
    exclusive(call, context, |context, state| {
        let mut log = context.recorder.log();
        let result = body(context, state, &mut log);
        if let Some(trouble) = log.ended(call, &result) {
            context.log(CrumpleLogLevel::Warning, &trouble);
        }
        result
    })
}

/// Runs an entry point that any number of threads may be inside at once.
pub(super) fn concurrent(
    call: &'static str,
    context: *const CrumpleContext,
    body: impl FnOnce(&Context) -> Result<(), Failure>,
) -> CrumpleResult {
    boundary(call, || body(&*find(context)?))
}

/// The defaults: threads of Crumple's own, one for each core; no log. Never fails; any thread.
#[unsafe(no_mangle)]
pub extern "C" fn crumple_context_def_default() -> CrumpleContextDef {
    CrumpleContextDef {
        struct_size: size_of::<CrumpleContextDef>() as u32,
        threads: 0,
        log: None,
        log_user: std::ptr::null_mut(),
        tasks: CrumpleTaskSystem { parallel_for: None, user: std::ptr::null_mut(), workers: 0 },
    }
}

/// Creates a context. def is copied; what its callbacks need must live until the context is destroyed.
///
/// Any thread; contexts know nothing of each other. Errors: CRUMPLE_ERROR_NULL_POINTER, CRUMPLE_ERROR_MISALIGNED,
/// CRUMPLE_ERROR_STRUCT_SIZE, CRUMPLE_ERROR_INVALID_ARGUMENT (more than 1024 threads; 65535 contexts are alive),
/// CRUMPLE_ERROR_OUT_OF_MEMORY (the system starts no more threads).
#[unsafe(no_mangle)]
pub unsafe extern "C" fn crumple_context_create(
    def: *const CrumpleContextDef,
    out_context: *mut *mut CrumpleContext,
) -> CrumpleResult {
    boundary("crumple_context_create", || {
        // SAFETY: the caller's.
        let (def, out) = unsafe { (self::def(def, "def")?, Out::new(out_context, "out_context")?) };
        let tasks: Box<dyn TaskSystem + Send + Sync> = match def.tasks.parallel_for {
            Some(call) => Box::new(HostTasks::new(call, def.tasks.user, def.tasks.workers)),
            None => Box::new(ThreadPool::new(def.threads as usize)?),
        };
        let mut contexts = CONTEXTS.write().unwrap_or_else(PoisonError::into_inner);
        let taken = |tag: u16| contexts.live.iter().any(|(number, _)| tag_of(*number) == tag);
        let number = (1..=usize::from(u16::MAX) + 1)
            .map(|i| contexts.last + i)
            .find(|&number| tag_of(number * STEP) != 0 && !taken(tag_of(number * STEP)))
            .ok_or_else(|| Failure::invalid("65535 contexts are alive; destroy one first"))?;
        let tag = tag_of(number * STEP);
        let (sets, instances, buffers) = (Slots::new(tag), Slots::new(tag), Slots::new(tag));
        let state = State { sets, instances, buffers, vulkan: None };
        let context = Context {
            log: def.log,
            log_user: def.log_user,
            tasks,
            state: Mutex::new(state),
            inboxes: RwLock::new(Slots::new(tag)),
            recorder: Recorder::default(),
        };
        contexts.last = number;
        contexts.live.push((number * STEP, Arc::new(context)));
        out.write(std::ptr::without_provenance_mut(number * STEP));
        Ok(())
    })
}

/// The tag in the ids of a context; 0 is no tag.
fn tag_of(number: usize) -> u16 {
    (number / STEP) as u16
}

/// Destroys a context and everything made in it. Your own memory is never freed, and is not touched afterwards. Every
/// id of the context, and the context itself, is an error from then on.
///
/// No other call with this context may be running. Where a Vulkan device is attached, it must still be there. Errors:
/// CRUMPLE_ERROR_NULL_POINTER, CRUMPLE_ERROR_INVALID_ID (destroyed already), CRUMPLE_ERROR_FRAMES_IN_FLIGHT (see
/// crumple_vulkan_complete_frames()), CRUMPLE_ERROR_CONCURRENT_USE. Nothing was destroyed then.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn crumple_context_destroy(context: *mut CrumpleContext) -> CrumpleResult {
    boundary("crumple_context_destroy", || {
        let found = find(context)?;
        found.enter()?.vulkan.as_ref().map_or(Ok(()), Attached::check_idle)?;
        let mut contexts = CONTEXTS.write().unwrap_or_else(PoisonError::into_inner);
        contexts.live.retain(|(number, _)| *number != context.addr());
        if contexts.live.is_empty() {
            contexts.live = Vec::new(); // nothing stays behind
        }
        Ok(())
    })
}
