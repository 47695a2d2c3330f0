//! The context: everything an engine makes, its threads, and who may be inside when.

use super::boundary::{boundary, granted};
use super::check::{Out, def, defs, zeroed};
use super::ids::Slots;
use super::result::{CrumpleResult, Failure};
use super::store::{InstanceEntry, State};
use super::tasks::{CrumpleTaskSystem, HostTasks, Quiet};
use super::types::CrumpleInstance;
use crate::base::error::Error;
use crate::base::tasks::ThreadPool;
use crate::contacts::ContactLayer;
use crate::contacts::options::ContactOptions;
use crate::instance::inbox::Inbox;
use crate::select::hit::{Hit, Outcome};
use std::collections::BTreeMap;
use std::ffi::{CString, c_char, c_void};
use std::mem::MaybeUninit;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError, RwLock, RwLockReadGuard, RwLockWriteGuard, TryLockError};

/// The severity of a log message.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum CrumpleLogLevel {
    Info = 0,
    /// Something that works but is probably a mistake.
    Warning = 1,
}

/// Receives one message, UTF-8, without a line break at its end. The text is valid only during the callback. Runs on
/// the thread that called Crumple. Must not call the same context, throw or longjmp out.
pub type CrumpleLog =
    Option<unsafe extern "C" fn(level: MaybeUninit<CrumpleLogLevel>, message: *const c_char, user: *mut c_void)>;

/// A context holds example sets, instances and buffers. Opaque.
pub struct CrumpleContext;

/// Options of a context.
#[repr(C)]
#[derive(Debug, Clone, Copy)]
pub struct CrumpleContextDef {
    pub struct_size: u32,
    /// Threads that deform, up to 1024. 0: one per core. 1: only the calling thread. Unused with tasks. Default 0.
    pub threads: u32,
    /// Receives messages. Default null: none.
    pub log: CrumpleLog,
    pub log_user: *mut c_void,
    pub tasks: CrumpleTaskSystem,
}

defs!(CrumpleContextDef);

pub(super) struct Context {
    log: CrumpleLog,
    log_user: *mut c_void,
    pub(super) tasks: Quiet,
    state: Mutex<State>,
    /// The same ids as `State::instances`, for the calls that may come from any thread. Changed only while `state` is
    /// held.
    inboxes: RwLock<Inboxes>,
    pub(super) contacts: ContactLayer,
    /// Of the last step.
    contact_hits: Mutex<Vec<StepHit>>,
}

type Inboxes = Slots<CrumpleInstance, Arc<Inbox>>;

/// A hit that a step of the contacts brought to an instance.
#[derive(Debug, Clone, Copy)]
pub(super) struct StepHit {
    pub(super) pair: u64,
    pub(super) instance: CrumpleInstance,
    pub(super) hit: Hit,
    pub(super) outcome: Outcome,
}

// SAFETY: `log_user` is only handed back to the host, on the thread that called.
unsafe impl Send for Context {}
// SAFETY: as above.
unsafe impl Sync for Context {}

/// The contexts there are. What C holds is a number that is never used twice, not an address, so that a destroyed
/// context is an error as well.
static CONTEXTS: RwLock<Contexts> = RwLock::new(Contexts { last: 0, live: BTreeMap::new() });

struct Contexts {
    last: usize,
    live: BTreeMap<usize, Arc<Context>>,
}

/// Keeps context pointers looking like pointers: never small, always aligned.
const STEP: usize = 64;

pub(super) fn find(context: *const CrumpleContext) -> Result<Arc<Context>, Failure> {
    if context.is_null() {
        return Err(Failure::null("context"));
    }
    let contexts = CONTEXTS.read().unwrap_or_else(PoisonError::into_inner);
    contexts.live.get(&context.addr()).cloned().ok_or_else(|| {
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
                "another thread is inside this context, or a callback calls back into it; take turns (only hits may be reported at any \
                 time: crumple_instance_submit_hit, _preview_hit and _end_contact)",
            )),
        }
    }

    pub(super) fn log(&self, level: CrumpleLogLevel, message: &str) {
        let Some(log) = self.log else { return };
        let text = CString::new(message.replace('\0', "\u{fffd}")).unwrap_or_default();
        // SAFETY: the host promised that its function may be called so; the text lives across the call.
        unsafe { log(MaybeUninit::new(level), text.as_ptr(), self.log_user) }
    }

    pub(super) fn inboxes(&self) -> RwLockReadGuard<'_, Inboxes> {
        self.inboxes.read().unwrap_or_else(PoisonError::into_inner)
    }

    /// The inboxes while no hit arrives: those that were selected for the bodies as they are have arrived.
    pub(super) fn no_hits(&self) -> RwLockWriteGuard<'_, Inboxes> {
        self.inboxes.write().unwrap_or_else(PoisonError::into_inner)
    }

    /// Hits of the last step.
    pub(super) fn contact_hits(&self) -> MutexGuard<'_, Vec<StepHit>> {
        self.contact_hits.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Calls `bring` with an instance's inbox. No part comes off or on meanwhile.
    pub(super) fn deliver<T>(
        &self,
        instance: CrumpleInstance,
        bring: impl FnOnce(&Inbox) -> Result<T, Error>,
    ) -> Result<T, Failure> {
        let inboxes = self.inboxes();
        Ok(bring(inboxes.get(instance, "instance")?)?)
    }
}

/// Makes room for one more instance.
pub(super) fn reserve_instance(state: &mut State, inboxes: &mut Inboxes) -> Result<(), Failure> {
    state.instances.reserve()?;
    inboxes.reserve()
}

/// Gives an instance an id, for which there is room.
pub(super) fn add_instance(state: &mut State, inboxes: &mut Inboxes, entry: InstanceEntry) -> CrumpleInstance {
    let inbox = inboxes.insert(entry.instance.inbox().clone());
    let id = state.instances.insert(entry);
    assert_eq!(inbox, id, "the two lists of instances went apart");
    id
}

/// Looks into another context than the one that a call is inside.
pub(super) fn look_into<T>(
    context: *const CrumpleContext,
    look: impl FnOnce(&State) -> Result<T, Failure>,
) -> Result<T, Failure> {
    let context = find(context)?;
    let state = context.enter()?;
    look(&state)
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

/// Runs an entry point that any number of threads may be inside at once.
pub(super) fn concurrent(
    call: &'static str,
    context: *const CrumpleContext,
    body: impl FnOnce(&Context) -> Result<(), Failure>,
) -> CrumpleResult {
    boundary(call, || body(&*find(context)?))
}

/// Keeps the module that holds this function loaded until the process ends: a destroyed context's threads may still be
/// ending when the host unloads the library. On Linux a flag of the file does this (build.rs).
#[cfg(windows)]
fn stay_loaded() {
    unsafe extern "system" {
        fn GetModuleHandleExW(flags: u32, inside: *const u16, module: *mut *mut c_void) -> i32;
    }
    const PIN: u32 = 1;
    const FROM_ADDRESS: u32 = 4;
    let mut module = std::ptr::null_mut();
    // SAFETY: with FROM_ADDRESS the second argument is any address in the module.
    unsafe { GetModuleHandleExW(PIN | FROM_ADDRESS, stay_loaded as *const u16, &mut module) };
}

#[unsafe(no_mangle)]
pub extern "C" fn crumple_context_def_default() -> CrumpleContextDef {
    zeroed()
}

/// Creates a context. Any thread may call this. Errors: CRUMPLE_ERROR_INVALID_ARGUMENT (more than 1024 threads, or
/// 65535 contexts alive), CRUMPLE_ERROR_OUT_OF_MEMORY (the system cannot start the threads).
#[unsafe(no_mangle)]
pub unsafe extern "C" fn crumple_context_create(
    def: *const CrumpleContextDef,
    out_context: *mut *mut CrumpleContext,
) -> CrumpleResult {
    boundary("crumple_context_create", || {
        let (def, out) = (self::def(def, "def")?, Out::new(out_context, "out_context")?);
        #[cfg(windows)]
        stay_loaded();
        let tasks = match def.tasks.parallel_for {
            Some(call) => Quiet(Box::new(HostTasks::new(call, def.tasks.user, def.tasks.workers))),
            None => Quiet(Box::new(ThreadPool::new(def.threads as usize)?)),
        };
        let mut contexts = CONTEXTS.write().unwrap_or_else(PoisonError::into_inner);
        let taken = |tag: u16| contexts.live.keys().any(|number| tag_of(*number) == tag);
        let number = (1..=usize::from(u16::MAX) + 1)
            .map(|i| contexts.last + i)
            .find(|&number| tag_of(number * STEP) != 0 && !taken(tag_of(number * STEP)))
            .ok_or_else(|| Failure::invalid("65535 contexts are alive; destroy one first"))?;
        let tag = tag_of(number * STEP);
        let context = Context {
            log: def.log,
            log_user: def.log_user,
            tasks,
            state: Mutex::new(State::new(tag)),
            inboxes: RwLock::new(Slots::new(tag)),
            contacts: ContactLayer::new(ContactOptions::default())?,
            contact_hits: Mutex::default(),
        };
        granted()?;
        contexts.last = number;
        contexts.live.insert(number * STEP, Arc::new(context));
        out.write(std::ptr::without_provenance_mut(number * STEP));
        Ok(())
    })
}

/// The tag in the ids of a context; 0 is no tag.
fn tag_of(number: usize) -> u16 {
    (number / STEP) as u16
}

/// Destroys a context and everything in it, but neither frees nor touches your own memory. No other call may be running
/// with this context. An attached Vulkan device must still exist. CRUMPLE_ERROR_FRAMES_IN_FLIGHT: nothing was
/// destroyed; see crumple_vulkan_complete_frames().
#[unsafe(no_mangle)]
pub unsafe extern "C" fn crumple_context_destroy(context: *mut CrumpleContext) -> CrumpleResult {
    boundary("crumple_context_destroy", || {
        let found = find(context)?;
        let state = found.enter()?;
        state.vulkan.as_ref().map_or(Ok(()), super::device::Attached::check_idle)?;
        drop(state);
        let mut contexts = CONTEXTS.write().unwrap_or_else(PoisonError::into_inner);
        contexts.live.remove(&context.addr());
        if contexts.live.is_empty() {
            contexts.live = BTreeMap::new(); // nothing stays behind
        }
        Ok(())
    })
}
