//! A host of the C interface that does what bytes say: calls in any order with any arguments, ids that are null, foreign,
//! stale or invented, callbacks that break their rules, and a second thread that submits hits meanwhile.
//!
//! It keeps the one contract that no library can check: pointers are null or point to as much memory as they claim.
#![allow(unsafe_op_in_unsafe_fn)]

use std::ffi::{CStr, c_char, c_void};
use std::mem::MaybeUninit;
use std::ptr::{null, null_mut};
use std::sync::OnceLock;
use std::sync::atomic::{AtomicUsize, Ordering};

use arbitrary::Unstructured;
use crumple::entry_points::*;

use crate::seeds;

mod arguments;
mod bodies;
mod devices;
mod sets;

/// The most calls of one input.
const CALLS: usize = 64;

/// Does what the bytes say.
pub fn run(data: &[u8]) {
    let mut host = Host::new(Unstructured::new(data));
    for _ in 0..CALLS {
        if host.bytes.is_empty() || host.step().is_err() {
            break;
        }
    }
}

/// The contexts that callbacks misuse. `user` has the number of its context above the four bits of its faults.
static CONTEXTS: [AtomicUsize; 4] = [const { AtomicUsize::new(0) }; 4];

/// A parallel-for whose faults are the bits of `user`: 1 skips tasks, 2 repeats them and adds some, 4 calls back into the
/// context, 8 uses threads.
unsafe extern "C" fn parallel_for(count: u32, task: CrumpleTask, task_data: *mut c_void, user: *mut c_void) {
    let (faults, task, data) = (user.addr(), task.expect("a task"), task_data.addr());
    // SAFETY: the task may be called on any thread until this function returns.
    let call = |i| unsafe { task(i, data as *mut c_void) };
    if faults & 4 != 0 {
        call_back(user);
    }
    let skipped = |i: &u32| faults & 1 == 0 || i % 3 != 1;
    if faults & 8 != 0 {
        std::thread::scope(|scope| {
            scope.spawn(|| (0..count / 2).filter(skipped).for_each(call));
            (count / 2..count).filter(skipped).for_each(call);
        });
    } else {
        (0..count).rev().filter(skipped).for_each(call);
    }
    if faults & 2 != 0 {
        (0..count.saturating_add(3)).for_each(call);
        call(u32::MAX);
    }
}

unsafe extern "C" fn log(_: MaybeUninit<CrumpleLogLevel>, message: *const c_char, user: *mut c_void) {
    // SAFETY: the library passes a string.
    unsafe { CStr::from_ptr(message) }.to_str().expect("UTF-8");
    if user.addr() & 4 != 0 {
        call_back(user);
    }
}

/// Calls that a callback must not make. They fail, since the context is in use.
fn call_back(user: *mut c_void) {
    let context = CONTEXTS[user.addr() >> 4].load(Ordering::Relaxed) as *mut CrumpleContext;
    // SAFETY: null stands for all buffers.
    let results = unsafe { [crumple_context_deform(context, null(), 0, null_mut()), crumple_context_destroy(context)] };
    if results.contains(&CrumpleResult::CrumpleOk) {
        // A panic would say nothing here: the library keeps the terminal quiet inside its calls.
        eprintln!("a callback got into its own context: {results:?}");
        std::process::abort();
    }
}

/// What the library may answer to anything: no defect of its own, and a message with each error.
fn answered(result: CrumpleResult) -> bool {
    assert_ne!(result, CrumpleResult::CrumpleErrorInternal, "{}", message());
    let ok = result == CrumpleResult::CrumpleOk;
    assert!(ok || message().starts_with("crumple_"), "{result:?}: {:?}", message());
    ok
}

fn message() -> String {
    // SAFETY: never null, and the text stays until this thread's next failed call.
    unsafe { CStr::from_ptr(crumple_last_error()) }.to_str().expect("UTF-8").to_owned()
}

type Step<T> = arbitrary::Result<T>;

struct Host<'a> {
    bytes: Unstructured<'a>,
    contexts: Vec<*mut CrumpleContext>,
    sets: Vec<CrumpleExampleSet>,
    instances: Vec<CrumpleInstance>,
    buffers: Vec<CrumpleBuffer>,
    attachments: Vec<CrumpleAttachment>,
    /// Memory of buffers, and baked sets that are used in place. It outlives the contexts.
    memory: Vec<Vec<f32>>,
    saved: Vec<Vec<u8>>,
    /// Whether all calls came from one thread at a time so far.
    alone: bool,
}

impl Drop for Host<'_> {
    fn drop(&mut self) {
        for context in &self.contexts {
            // SAFETY: any pointer is allowed here.
            unsafe { crumple_context_destroy(*context) };
        }
    }
}

impl<'a> Host<'a> {
    fn new(bytes: Unstructured<'a>) -> Self {
        let mut host = Self {
            bytes,
            contexts: Vec::new(),
            sets: Vec::new(),
            instances: Vec::new(),
            buffers: Vec::new(),
            attachments: Vec::new(),
            memory: Vec::new(),
            saved: vec![sheet_file().clone()],
            alone: true,
        };
        // Most inputs would not get far without these.
        let _ = host.create_context();
        let context = host.contexts[0];
        let mut set = CrumpleExampleSet::default();
        let file = &host.saved[0];
        // SAFETY: the bytes are there during the call.
        let loaded = unsafe {
            let kind = MaybeUninit::new(CrumpleBytes::Copy);
            crumple_example_set_load_baked_memory(context, file.as_ptr().cast(), file.len(), kind, &mut set)
        };
        assert!(answered(loaded));
        host.sets.push(set);
        let def = CrumpleInstanceDef { set, ..crumple_instance_def_default() };
        let mut instance = CrumpleInstance::default();
        // SAFETY: both live across the call.
        assert!(answered(unsafe { crumple_instance_create(context, &def, &mut instance) }));
        host.instances.push(instance);
        host
    }

    fn create_context(&mut self) -> Step<()> {
        let faults: u8 = self.bytes.arbitrary().unwrap_or_default();
        let number = self.contexts.len();
        let user = (usize::from(faults & 15) | number << 4) as *mut c_void;
        let mut def = CrumpleContextDef { threads: 1, log: Some(log), log_user: user, ..crumple_context_def_default() };
        if faults & 0x30 == 0x10 {
            def.tasks = CrumpleTaskSystem { parallel_for: Some(parallel_for), user, workers: 3 };
        } else if faults & 0x30 == 0x20 {
            def.threads = 2;
        }
        let mut context = null_mut();
        // An earlier input's context may have had the address of one that lives now.
        CONTEXTS[number].store(0, Ordering::Relaxed);
        // SAFETY: both live across the call, and the callbacks for ever.
        if answered(unsafe { crumple_context_create(&def, &mut context) }) {
            self.contexts.push(context);
            CONTEXTS[number].store(context.addr(), Ordering::Relaxed);
        }
        Ok(())
    }

    /// Keeps what `save` fills, asked first for its size. Hits of another thread may merge marks meanwhile, and so make
    /// it smaller.
    fn save(&mut self, mut save: impl FnMut(*mut c_void, usize, *mut usize) -> CrumpleResult) {
        let mut size = 0;
        if answered(save(null_mut(), 0, &mut size)) {
            let mut bytes = vec![0u8; size];
            let alone = self.alone;
            assert!(size == 0 || !answered(save(bytes.as_mut_ptr().cast(), size - 1, &mut size)) || !alone);
            if answered(save(bytes.as_mut_ptr().cast(), bytes.len(), &mut size)) {
                assert!(size == bytes.len() || (size < bytes.len() && !alone));
                bytes.truncate(size);
                self.saved.push(bytes);
            }
        }
    }

    /// Calls that any thread may make, from another thread while this one goes on.
    fn meanwhile(&mut self) -> Step<()> {
        let (context, instance, hit) = (self.context()?.addr(), self.instance()?, self.hit()?);
        let (blow, mut matrix) = (self.hit()?, crumple_instance_def_default().local_to_world);
        matrix[12] = self.number()?;
        self.alone = false;
        let submit = move || {
            for _ in 0..20 {
                let mut told = MaybeUninit::uninit();
                let context = context as *mut CrumpleContext;
                // SAFETY: everything lives across the calls.
                unsafe {
                    answered(crumple_instance_submit_hit(context, instance, &hit, told.as_mut_ptr()));
                    answered(crumple_instance_submit_hit(context, instance, &blow, told.as_mut_ptr()));
                    answered(crumple_instance_preview_hit(context, instance, &blow, told.as_mut_ptr()));
                    answered(crumple_instance_set_transform(context, instance, matrix.as_ptr()));
                    answered(crumple_instance_end_contact(context, instance, hit.contact_id));
                }
            }
        };
        std::thread::scope(|scope| {
            scope.spawn(submit);
            (0..4).try_for_each(|_| self.step())
        })
    }

    fn step(&mut self) -> Step<()> {
        let call = self.bytes.int_in_range(0..=99u8)?;
        // SAFETY: every pointer is null or points to what the call may read or write.
        let result = unsafe {
            match call {
                0 if self.contexts.len() < CONTEXTS.len() => return self.create_context(),
                0..=1 => crumple_context_destroy(self.context()?),
                2..=3 => return self.meanwhile(),
                4..=24 => self.set_call(call - 4)?,
                25..=80 => self.body_call(call - 25)?,
                _ => self.device_call(call - 81)?,
            }
        };
        answered(result);
        Ok(())
    }
}

/// A set of a sheet with four dents, as C gets it from a file.
fn sheet_file() -> &'static Vec<u8> {
    static FILE: OnceLock<Vec<u8>> = OnceLock::new();
    FILE.get_or_init(|| seeds::dented()[0].example_set().save().expect("a small set"))
}
