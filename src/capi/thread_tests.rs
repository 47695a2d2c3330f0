//! Hits from eight threads while another deforms, saves, and makes and destroys bodies. `cargo xtask test --only
//! threads` runs this under ThreadSanitizer.

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
use crate::mesh::data::MeshData;
use std::mem::MaybeUninit;
use std::ptr::{null, null_mut};
use std::sync::Mutex;
use std::sync::atomic::{AtomicBool, AtomicPtr, Ordering};

const THREADS: u32 = 8;
const HITS: u32 = 400;
const SIDE: u32 = 9;
const N: usize = (SIDE * SIDE) as usize;

/// A baked sheet of 1 m with a dent in its middle.
fn file() -> Vec<u8> {
    let at = |i: u32| i as f32 / (SIDE - 1) as f32;
    let positions: Vec<[f32; 3]> = (0..SIDE * SIDE).map(|v| [at(v % SIDE), at(v / SIDE), 0.0]).collect();
    let quads = (0..SIDE * (SIDE - 1)).filter(|v| v % SIDE < SIDE - 1);
    let triangles = quads.flat_map(|v| [[v, v + 1, v + SIDE], [v + SIDE, v + 1, v + SIDE + 1]]).collect();
    let depth = |p: &[f32; 3]| (0.09 - (p[0] - 0.5).powi(2) - (p[1] - 0.5).powi(2)).max(0.0);
    let field = positions.iter().map(|p| [0.0, 0.0, -depth(p)]).collect();
    let mesh = MeshData { positions, triangles, ..MeshData::default() };
    let options = SetOptions::default();
    let set = ExampleSet::build(mesh, vec![ExampleData::new("dent", Deltas::Full(field))], options, &Serial).unwrap();
    set.save().unwrap()
}

fn hit(i: u32) -> CrumpleHitDef {
    let mut def = crumple_hit_def_default();
    def.kind = MaybeUninit::new(CrumpleHitKind::Displacement);
    def.point = [(i * 37 % 101) as f32 / 101.0, (i * 61 % 103) as f32 / 103.0, 0.0].into();
    def.displacement = [0.0, 0.0, -0.005 - 0.0001 * (i % 300) as f32].into();
    def.contact_id = u64::from(i % 5 / 4);
    def
}

struct Host {
    context: AtomicPtr<CrumpleContext>,
    set: CrumpleExampleSet,
}

impl Host {
    fn new() -> Self {
        let (mut context, mut set, file) = (null_mut(), CrumpleExampleSet::default(), file());
        let def = CrumpleContextDef { threads: 3, ..crumple_context_def_default() };
        let copy = MaybeUninit::new(CrumpleBytes::Copy);
        // SAFETY: everything lives across the calls.
        unsafe {
            assert_eq!(crumple_context_create(&def, &mut context), R::CrumpleOk);
            let (data, size) = (file.as_ptr().cast(), file.len());
            assert_eq!(crumple_example_set_load_baked_memory(context, data, size, copy, &mut set), R::CrumpleOk);
        }
        Self { context: context.into(), set }
    }

    fn context(&self) -> *mut CrumpleContext {
        self.context.load(Ordering::Relaxed)
    }

    /// A body that keeps every mark: then neither order nor moment of hits matters.
    fn body(&self) -> CrumpleInstance {
        let (mut id, mut def) = (CrumpleInstance::default(), crumple_instance_def_default());
        (def.set, def.mark_capacity) = (self.set, 65535);
        // SAFETY: both live across the call.
        assert_eq!(unsafe { crumple_instance_create(self.context(), &def, &mut id) }, R::CrumpleOk);
        id
    }

    fn submit(&self, body: CrumpleInstance, def: &CrumpleHitDef) -> R {
        let mut told = MaybeUninit::uninit();
        // SAFETY: both live across the call.
        unsafe { crumple_instance_submit_hit(self.context(), body, def, told.as_mut_ptr()) }
    }

    fn saved(&self, body: CrumpleInstance) -> Vec<u8> {
        let (mut bytes, mut size) = (vec![0u8; 1 << 20], 0);
        // SAFETY: as many bytes as claimed.
        let result = unsafe {
            crumple_instance_save_damage(self.context(), body, bytes.as_mut_ptr().cast(), bytes.len(), &mut size)
        };
        assert_eq!(result, R::CrumpleOk);
        bytes.truncate(size);
        bytes
    }

    /// What the thread that owns the context does in a frame.
    fn frame(&self, others: &Mutex<CrumpleInstance>) {
        let body = *others.lock().unwrap();
        let (mut memory, mut buffer, mut def) =
            (vec![[0f32; 3]; N], CrumpleBuffer::default(), crumple_host_buffer_def_default());
        def.positions = CrumpleStream { data: memory.as_mut_ptr().cast(), size: 12 * N, offset: 0, stride: 12 };
        let context = self.context();
        // SAFETY: everything lives until the buffer is unregistered with its body.
        unsafe {
            assert_eq!(crumple_buffer_register_host(context, body, &def, &mut buffer), R::CrumpleOk);
            assert_eq!(crumple_context_deform(context, null(), 0, null_mut()), R::CrumpleOk);
            self.saved(body);
            *others.lock().unwrap() = self.body();
            assert_eq!(crumple_instance_destroy(context, body), R::CrumpleOk);
        }
    }
}

#[test]
fn eight_threads_hit_while_another_deforms_saves_and_destroys() {
    let (host, alone) = (Host::new(), Host::new());
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
    for context in [host.context(), alone.context()] {
        // SAFETY: the last call.
        assert_eq!(unsafe { crumple_context_destroy(context) }, R::CrumpleOk);
    }
}
