//! Calls from several threads, and into memory of several buffers. ThreadSanitizer and Miri run these (`xtask/src/nightly.rs`).

use super::buffer::*;
use super::context::*;
use super::damage::*;
use super::deform::*;
use super::hit::*;
use super::instance::*;
use super::result::CrumpleResult as R;
use super::set::{CrumpleBytes, crumple_example_set_load_baked_memory};
use super::types::*;
use crate::base::tasks::Serial;
use crate::example::data::{Deltas, ExampleData};
use crate::example::options::SetOptions;
use crate::example::set::ExampleSet;
use crate::instance::schedules::plates;
use crate::mesh::data::MeshData;
use std::mem::MaybeUninit;
use std::ptr::{null, null_mut};
use std::sync::Mutex;
use std::sync::atomic::{AtomicBool, AtomicPtr, Ordering};

const THREADS: u32 = 8;
const HITS: u32 = 400;

/// Vertices of the plates.
const N: usize = 50;

/// The result of a call.
macro_rules! result {
    ($call:expr) => {{
        // SAFETY: what these tests pass lives across the calls, memory of buffers until they are unregistered.
        unsafe { $call }
    }};
}

macro_rules! ok {
    ($call:expr) => {
        assert_eq!(result!($call), R::CrumpleOk)
    };
}

fn hit(i: u32) -> CrumpleHitDef {
    let mut def = crumple_hit_def_default();
    def.kind = MaybeUninit::new(CrumpleHitKind::Displacement);
    def.point = [(i * 37 % 201) as f32 / 100.0 - 1.0, (i * 61 % 101) as f32 / 100.0 - 0.5, 0.0].into();
    def.displacement = [0.0, 0.0, -0.005 - 0.0001 * (i % 300) as f32].into();
    def.contact_id = u64::from(i % 5 / 4);
    def
}

struct Host {
    context: AtomicPtr<CrumpleContext>,
    set: CrumpleExampleSet,
}

impl Host {
    fn new(threads: u32, set: &ExampleSet) -> Self {
        let (file, mut context, mut set) = (set.save().unwrap(), null_mut(), CrumpleExampleSet::default());
        let def = CrumpleContextDef { threads, ..crumple_context_def_default() };
        let copy = MaybeUninit::new(CrumpleBytes::Copy);
        ok!(crumple_context_create(&def, &mut context));
        let (data, size) = (file.as_ptr().cast(), file.len());
        ok!(crumple_example_set_load_baked_memory(context, data, size, copy, &mut set));
        Self { context: context.into(), set }
    }

    fn context(&self) -> *mut CrumpleContext {
        self.context.load(Ordering::Relaxed)
    }

    /// A body that keeps every mark: then neither order nor moment of hits matters.
    fn body(&self) -> CrumpleInstance {
        let (mut id, mut def) = (CrumpleInstance::default(), crumple_instance_def_default());
        (def.set, def.mark_capacity) = (self.set, 65535);
        ok!(crumple_instance_create(self.context(), &def, &mut id));
        id
    }

    fn submit(&self, body: CrumpleInstance, def: &CrumpleHitDef) -> R {
        let mut told = MaybeUninit::uninit();
        result!(crumple_instance_submit_hit(self.context(), body, def, told.as_mut_ptr()))
    }

    fn saved(&self, body: CrumpleInstance) -> Vec<u8> {
        let (mut bytes, mut size) = (vec![0u8; 1 << 20], 0);
        ok!(crumple_instance_save_damage(self.context(), body, bytes.as_mut_ptr().cast(), bytes.len(), &mut size));
        bytes.truncate(size);
        bytes
    }

    /// A buffer at vertex `first` of `memory`, which must live until it is unregistered.
    fn buffer(&self, body: CrumpleInstance, memory: &mut [[f32; 3]], first: usize) -> CrumpleBuffer {
        let (mut buffer, mut def) = (CrumpleBuffer::default(), crumple_host_buffer_def_default());
        let (data, size) = (memory.as_mut_ptr().cast(), size_of_val(memory));
        def.positions = CrumpleStream { data, size, offset: 12 * first, stride: 12 };
        ok!(crumple_buffer_register_host(self.context(), body, &def, &mut buffer));
        buffer
    }

    /// Deforms these buffers, or all.
    fn deform(&self, buffers: &[CrumpleBuffer]) -> R {
        let pointer = if buffers.is_empty() { null() } else { buffers.as_ptr() };
        result!(crumple_context_deform(self.context(), pointer, buffers.len() as u32, null_mut()))
    }

    /// What the thread that owns the context does in a frame.
    fn frame(&self, others: &Mutex<CrumpleInstance>) {
        let (body, mut memory) = (*others.lock().unwrap(), vec![[0f32; 3]; N]);
        self.buffer(body, &mut memory, 0);
        assert_eq!(self.deform(&[]), R::CrumpleOk);
        self.saved(body);
        *others.lock().unwrap() = self.body();
        ok!(crumple_instance_destroy(self.context(), body));
    }
}

impl Drop for Host {
    fn drop(&mut self) {
        ok!(crumple_context_destroy(self.context()));
    }
}

#[test]
fn eight_threads_hit_while_another_deforms_saves_and_destroys() {
    let (host, alone) = (Host::new(3, &plates()), Host::new(3, &plates()));
    let (kept, others, running) = (host.body(), Mutex::new(host.body()), AtomicBool::new(true));
    std::thread::scope(|scope| {
        scope.spawn(|| {
            loop {
                host.frame(&others);
                if !running.load(Ordering::Relaxed) {
                    break;
                }
            }
        });
        let hitting: Vec<_> = (0..THREADS)
            .map(|thread| {
                let (host, others) = (&host, &others);
                scope.spawn(move || {
                    for i in (thread..HITS).step_by(THREADS as usize) {
                        // A body that is destroyed meanwhile refuses the hit; another one is never touched by it.
                        let other = *others.lock().unwrap();
                        assert!(matches!(host.submit(other, &hit(i)), R::CrumpleOk | R::CrumpleErrorInvalidId));
                        let def = CrumpleHitDef { contact_id: 0, ..hit(i) };
                        assert_eq!(host.submit(kept, &def), R::CrumpleOk);
                    }
                })
            })
            .collect();
        hitting.into_iter().for_each(|thread| thread.join().unwrap());
        running.store(false, Ordering::Relaxed);
    });
    let body = alone.body();
    for i in 0..HITS {
        let def = CrumpleHitDef { contact_id: 0, ..hit(i) };
        assert_eq!(alone.submit(body, &def), R::CrumpleOk);
    }
    assert!(host.saved(kept) == alone.saved(body), "the moment of a hit changed the damage");
}

#[test]
fn memory_of_two_buffers_must_not_overlap_in_debug_builds() {
    // Without triangles, whose normals Miri cannot compute.
    let mesh = MeshData { positions: vec![[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]], ..MeshData::default() };
    let dent = ExampleData::new("dent", Deltas::Sparse { indices: vec![0], values: vec![[0.0, 0.0, -0.1]] });
    let set = ExampleSet::build(mesh, vec![dent], SetOptions::default(), &Serial).unwrap();
    let (host, mut memory) = (Host::new(1, &set), [[1f32; 3]; 9]);
    let body = host.body();
    let [first, beside, across] = [0, 3, 2].map(|vertex| host.buffer(body, &mut memory, vertex));
    assert_eq!(host.deform(&[first, beside]), R::CrumpleOk);
    let refused = if cfg!(debug_assertions) { R::CrumpleErrorInvalidArgument } else { R::CrumpleOk };
    assert_eq!(host.deform(&[]), refused);
    ok!(crumple_buffer_unregister(host.context(), across));
    assert_eq!(host.deform(&[]), R::CrumpleOk);
    assert!(!cfg!(debug_assertions) || memory[..3] == memory[3..6], "a buffer that was refused was written");
    assert_eq!(memory[6..], [[1.0; 3]; 3]);
}
