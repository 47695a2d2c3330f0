//! Recordings are made by the C functions, played again, and must give the same; and must tell where something differs.

use super::attach::*;
use super::buffer::*;
use super::context::*;
use super::damage::*;
use super::deform::*;
use super::hit::*;
use super::host_memory::*;
use super::instance::*;
use super::record_call::Call;
use super::record_file::{Event, Reader, Writer};
use super::recording::{crumple_recording_begin, crumple_recording_end};
use super::replay::{Replay, replay};
use super::result::{CrumpleResult as R, crumple_last_error};
use super::set::*;
use super::tasks::{CrumpleTask, CrumpleTaskSystem};
use super::threshold::*;
use super::types::*;
use proptest::prelude::*;
use std::ffi::{CStr, CString, c_void};
use std::mem::MaybeUninit;
use std::path::{Path, PathBuf};
use std::ptr::{null, null_mut};
use std::sync::Mutex;
use std::sync::atomic::{AtomicU32, Ordering};

const SIDE: usize = 9;
const N: usize = SIDE * SIDE;

/// A context with one set, whose memory for vertices lives as long.
struct Host {
    context: *mut CrumpleContext,
    set: CrumpleExampleSet,
    instances: Vec<CrumpleInstance>,
    buffers: Vec<(CrumpleBuffer, Box<[[f32; 6]; N]>)>,
    directory: tempfile::TempDir,
}

// SAFETY: the context may be used by several threads as its header says.
unsafe impl Sync for Host {}

impl Drop for Host {
    fn drop(&mut self) {
        // SAFETY: the last call.
        unsafe { crumple_context_destroy(self.context) };
    }
}

fn said() -> String {
    // SAFETY: as the header says.
    unsafe { CStr::from_ptr(crumple_last_error()) }.to_string_lossy().into_owned()
}

#[track_caller]
fn ok(result: R) {
    assert_eq!(result, R::CrumpleOk, "{}", said());
}

fn input<T>(values: &[T]) -> CrumpleInput {
    CrumpleInput { data: values.as_ptr().cast(), size: size_of_val(values), stride: size_of::<T>() }
}

fn mesh(positions: &[[f32; 3]], indices: &[u32]) -> CrumpleMeshDef {
    CrumpleMeshDef {
        vertex_count: positions.len() as u32,
        positions: input(positions),
        indices: input(indices),
        index_count: indices.len() as u32,
        ..crumple_lod_def_default().mesh
    }
}

/// A sheet of 1 m with a dent of `depth` in its middle, or its coarse copy.
fn sheet(side: usize, depth: f32) -> (Vec<[f32; 3]>, Vec<u32>) {
    let at = |i: usize| i as f32 / (side - 1) as f32 - 0.5;
    let positions = (0..side * side).map(|v| {
        let (x, y) = (at(v % side), at(v / side));
        let r = (x * x + y * y).sqrt() / 0.3;
        [x, y, if r < 1.0 { -depth * (1.0 - r * r) } else { 0.0 }]
    });
    let mut indices = Vec::new();
    for v in (0..side * (side - 1)).filter(|v| v % side < side - 1).map(|v| v as u32) {
        let s = side as u32;
        indices.extend([v, v + 1, v + s, v + s, v + 1, v + s + 1]);
    }
    (positions.collect(), indices)
}

impl Host {
    fn new(def: &CrumpleContextDef) -> Self {
        let mut host = Host {
            context: null_mut(),
            set: CrumpleExampleSet::default(),
            instances: Vec::new(),
            buffers: Vec::new(),
            directory: tempfile::tempdir().unwrap(),
        };
        // SAFETY: the def lives across the call.
        ok(unsafe { crumple_context_create(def, &mut host.context) });
        host
    }

    fn with_set() -> Self {
        let mut host = Self::new(&CrumpleContextDef { threads: 2, ..crumple_context_def_default() });
        host.make_set();
        host
    }

    fn make_set(&mut self) {
        let (base, indices) = sheet(SIDE, 0.0);
        let (dented, _) = sheet(SIDE, 0.05);
        let example = CrumpleExampleDef { target_positions: input(&dented), ..crumple_example_def_default() };
        let mut def = CrumpleExampleSetDef {
            mesh: mesh(&base, &indices),
            examples: &example,
            example_count: 1,
            ..crumple_example_set_def_default()
        };
        def.options.vertex_mass = 0.5;
        def.options.stamp_resolution = 8;
        let mut set = CrumpleExampleSet::default();
        // SAFETY: all arrays live across the call.
        ok(unsafe { crumple_example_set_create(self.context, &def, &mut set) });
        self.set = set;
    }

    fn add_lod(&self) {
        let (coarse, indices) = sheet(5, 0.0);
        let def = CrumpleLodDef { mesh: mesh(&coarse, &indices), ..crumple_lod_def_default() };
        let mut number = 0;
        // SAFETY: the arrays live across the call.
        ok(unsafe { crumple_example_set_add_lod(self.context, self.set, &def, &mut number) });
    }

    fn path(&self) -> PathBuf {
        self.directory.path().join("calls.crumplerec")
    }

    fn begin(&self) -> R {
        self.begin_at(&self.path())
    }

    fn begin_at(&self, path: &Path) -> R {
        let path = CString::new(path.to_str().unwrap()).unwrap();
        // SAFETY: the text lives across the call.
        unsafe { crumple_recording_begin(self.context, path.as_ptr()) }
    }

    fn end(&self) -> Vec<u8> {
        // SAFETY: the context lives.
        ok(unsafe { crumple_recording_end(self.context) });
        std::fs::read(self.path()).unwrap()
    }

    fn instance(&mut self, rule: CrumpleRule) {
        let rule = MaybeUninit::new(rule);
        let def = CrumpleInstanceDef { set: self.set, rule, mark_capacity: 6, ..crumple_instance_def_default() };
        let mut id = CrumpleInstance::default();
        // SAFETY: the def lives across the call.
        ok(unsafe { crumple_instance_create(self.context, &def, &mut id) });
        self.instances.push(id);
    }

    fn buffer(&mut self, of: CrumpleInstance, lod: u32) {
        let mut memory = Box::new([[0.0f32; 6]; N]);
        let stream = |memory: &mut [[f32; 6]; N], offset| CrumpleStream {
            data: memory.as_mut_ptr().cast(),
            size: size_of_val(memory),
            offset,
            stride: 24,
        };
        let def = CrumpleHostBufferDef {
            lod,
            positions: stream(&mut memory, 0),
            normals: stream(&mut memory, 12),
            normal_format: MaybeUninit::new(match self.buffers.len() % 2 {
                0 => CrumpleDirectionFormat::Float,
                _ => CrumpleDirectionFormat::Octahedral,
            }),
            ..crumple_host_buffer_def_default()
        };
        let mut id = CrumpleBuffer::default();
        // SAFETY: the memory goes with the host, after the context.
        ok(unsafe { crumple_buffer_register_host(self.context, of, &def, &mut id) });
        self.buffers.push((id, memory));
    }

    fn hit(&self, at: usize, (x, y): (f32, f32), strength: f32, contact_id: u64) -> R {
        let def = CrumpleImpulseDef {
            point: CrumpleVec3 { x, y, z: 0.0 },
            impulse: CrumpleVec3 { x: 0.0, y: 0.1 * strength, z: -strength },
            duration: 0.01,
            contact_id,
            ..crumple_impulse_def_default()
        };
        // SAFETY: the def lives across the call.
        unsafe { crumple_instance_submit_impulse(self.context, self.instances[at], &def, null_mut()) }
    }

    fn deform(&self) {
        // SAFETY: registered memory lives, and nobody else touches it.
        ok(unsafe { crumple_context_deform(self.context, null(), 0, null_mut()) });
    }
}

#[track_caller]
fn same(bytes: &[u8]) -> Replay {
    let [one, three] = [1, 3].map(|threads| replay(bytes, threads, &mut |_, _| {}).unwrap());
    assert_eq!(one, three);
    assert_eq!(one.first, None);
    assert!(one.complete && one.differences == 0);
    one
}

/// What a host may do next.
#[derive(Debug, Clone)]
enum Step {
    Hit(usize, (f32, f32), f32, u64),
    EndContact(usize, u64),
    Deform,
    Marks(usize, u32),
    CopyMarks(usize, usize),
    Save(usize, usize),
    Repair(usize, f32),
    Reset(usize),
    CopyDamage(usize, usize),
    Move(usize, f32),
    Limit(usize, f32),
    Tolerance(usize, f32),
    Info(usize),
    Frame(usize),
    Instance(bool),
    Buffer(usize, u32),
    Unregister(usize),
    Invalidate(usize),
    Destroy(usize),
    Refused,
}

fn step() -> impl Strategy<Value = Step> {
    let at = 0usize..4;
    let spot = (-0.5f32..0.5, -0.5f32..0.5);
    prop_oneof![
        8 => (at.clone(), spot, 0.0f32..6.0, 0u64..3).prop_map(|(a, p, s, id)| Step::Hit(a, p, s, id)),
        1 => (at.clone(), 1u64..3).prop_map(|(a, id)| Step::EndContact(a, id)),
        4 => Just(Step::Deform),
        1 => (at.clone(), 0u32..9).prop_map(|(a, room)| Step::Marks(a, room)),
        1 => (at.clone(), at.clone()).prop_map(|(a, b)| Step::CopyMarks(a, b)),
        1 => (at.clone(), at.clone()).prop_map(|(a, b)| Step::Save(a, b)),
        1 => (at.clone(), 0.0f32..1.5).prop_map(|(a, k)| Step::Repair(a, k)),
        1 => at.clone().prop_map(Step::Reset),
        1 => (at.clone(), at.clone()).prop_map(|(a, b)| Step::CopyDamage(a, b)),
        1 => (at.clone(), -2.0f32..2.0).prop_map(|(a, x)| Step::Move(a, x)),
        1 => (at.clone(), -0.01f32..0.1).prop_map(|(a, l)| Step::Limit(a, l)),
        1 => (at.clone(), -0.01f32..0.01).prop_map(|(a, t)| Step::Tolerance(a, t)),
        1 => at.clone().prop_map(Step::Info),
        1 => at.clone().prop_map(Step::Frame),
        1 => any::<bool>().prop_map(Step::Instance),
        1 => (at.clone(), 0u32..3).prop_map(|(a, l)| Step::Buffer(a, l)),
        1 => at.clone().prop_map(Step::Unregister),
        1 => at.clone().prop_map(Step::Invalidate),
        1 => at.prop_map(Step::Destroy),
        1 => Just(Step::Refused),
    ]
}

impl Host {
    /// Takes a step; whether it is refused is part of what is compared.
    fn take(&mut self, step: &Step) {
        let c = self.context;
        let some = |at: &usize| self.instances.get(*at % self.instances.len().max(1)).copied().unwrap_or_default();
        // SAFETY: every pointer is to something that lives across the call, or as long as the host.
        unsafe {
            match step {
                Step::Hit(at, spot, strength, contact) => {
                    if !self.instances.is_empty() {
                        self.hit(at % self.instances.len(), *spot, *strength, *contact);
                    }
                }
                Step::EndContact(at, id) => drop(crumple_instance_end_contact(c, some(at), *id)),
                Step::Deform => self.deform(),
                Step::Marks(at, room) => {
                    let (mut marks, mut count) =
                        ([crate::damage::mark::Mark::new(0, 1.0, [crate::damage::mark::Pair::NONE; 4]); 8], 0);
                    crumple_instance_get_marks(c, some(at), marks.as_mut_ptr(), (*room).min(8), &mut count);
                }
                Step::CopyMarks(from, to) => {
                    let (mut marks, mut count) =
                        ([crate::damage::mark::Mark::new(0, 1.0, [crate::damage::mark::Pair::NONE; 4]); 8], 0);
                    if crumple_instance_get_marks(c, some(from), marks.as_mut_ptr(), 8, &mut count) == R::CrumpleOk {
                        crumple_instance_set_marks(c, some(to), marks.as_ptr(), count);
                    }
                }
                Step::Save(from, to) => {
                    let (mut bytes, mut size) = ([0u8; 4096], 0);
                    if crumple_instance_save_damage(c, some(from), bytes.as_mut_ptr().cast(), 4096, &mut size)
                        == R::CrumpleOk
                    {
                        crumple_instance_load_damage(c, some(to), bytes.as_ptr().cast(), size);
                    }
                }
                Step::Repair(at, keep) => drop(crumple_instance_repair_damage(c, some(at), *keep)),
                Step::Reset(at) => drop(crumple_instance_reset_damage(c, some(at))),
                Step::CopyDamage(to, from) => drop(crumple_instance_copy_damage(c, some(to), some(from))),
                Step::Move(at, x) => {
                    let mut matrix = glam::Mat4::IDENTITY.to_cols_array();
                    matrix[12] = *x;
                    crumple_instance_set_transform(c, some(at), matrix.as_ptr());
                }
                Step::Limit(at, limit) => drop(crumple_instance_set_depth_limit(c, some(at), *limit)),
                Step::Tolerance(at, tolerance) => drop(crumple_instance_set_tolerance(c, some(at), *tolerance)),
                Step::Info(at) => {
                    let mut info = MaybeUninit::uninit();
                    crumple_instance_get_info(c, some(at), info.as_mut_ptr());
                }
                Step::Frame(at) => {
                    let (mut point, mut frame) = (CrumpleAttachment::default(), CrumpleFrame::default());
                    let spot = CrumpleVec3 { x: 0.1, y: 0.1, z: 0.2 };
                    if crumple_example_set_attach_point(c, self.set, spot, &mut point) == R::CrumpleOk {
                        crumple_instance_get_attached_frame(c, some(at), &point, &mut frame);
                    }
                }
                Step::Instance(marks) => {
                    if self.instances.len() < 6 {
                        self.instance(if *marks { CrumpleRule::Marks } else { CrumpleRule::MostDisplaced });
                    }
                }
                Step::Buffer(at, lod) => {
                    let (of, mut info) = (some(at), MaybeUninit::uninit());
                    let there = crumple_instance_get_info(c, of, info.as_mut_ptr()) == R::CrumpleOk;
                    let marks = there && {
                        let (mut marks, mut count) =
                            ([crate::damage::mark::Mark::new(0, 1.0, [crate::damage::mark::Pair::NONE; 4]); 8], 0);
                        crumple_instance_get_marks(c, of, marks.as_mut_ptr(), 8, &mut count) == R::CrumpleOk
                    };
                    if there {
                        self.buffer(of, if marks { lod / 2 } else { 0 });
                    }
                }
                Step::Unregister(at) => {
                    if !self.buffers.is_empty() {
                        let (id, _) = self.buffers.remove(at % self.buffers.len());
                        crumple_buffer_unregister(c, id);
                    }
                }
                Step::Invalidate(at) => {
                    if let Some((id, _)) = self.buffers.get(*at) {
                        crumple_buffer_invalidate(c, *id);
                    }
                }
                Step::Destroy(at) => {
                    if self.instances.len() > 1 {
                        let id = self.instances.remove(at % self.instances.len());
                        crumple_instance_destroy(c, id);
                    }
                }
                Step::Refused => drop(crumple_instance_load_damage(c, some(&0), b"junk".as_ptr().cast(), 4)),
            }
        }
    }
}

proptest! {
    #[test]
    fn whatever_was_called_gives_the_same_again_from_any_moment_on(
        before in prop::collection::vec(step(), 0..25), after in prop::collection::vec(step(), 1..40), stale: bool
    ) {
        let mut host = Host::with_set();
        host.add_lod();
        host.instance(CrumpleRule::Marks);
        host.instance(CrumpleRule::Blend);
        let first = host.instances[0];
        host.buffer(first, 1);
        before.iter().for_each(|s| host.take(s));
        for instance in host.instances.clone() {
            for contact in 1..3 {
                // SAFETY: plain values. With a classic rule there is none to end.
                unsafe { crumple_instance_end_contact(host.context, instance, contact) };
            }
        }
        if stale {
            // SAFETY: plain values.
            ok(unsafe { crumple_example_set_destroy(host.context, host.set) });
        }
        ok(host.begin());
        if stale {
            host.make_set();
            host.add_lod();
        }
        after.iter().for_each(|s| host.take(s));
        host.deform();
        let bytes = host.end();
        let report = same(&bytes);
        prop_assert!(report.deforms >= 1);
        // What a crash leaves behind can be played up to there.
        let cut = &bytes[..bytes.len() - bytes.len() / 5];
        let part = replay(cut, 1, &mut |_, _| {}).unwrap();
        prop_assert!(!part.complete && part.differences == 0 && part.calls <= report.calls);
    }
}

/// A job system whose tasks are run here, and which reports a hit before them, as a physics engine on the same workers would.
extern "C" fn parallel_for(count: u32, task: CrumpleTask, data: *mut c_void, user: *mut c_void) {
    // SAFETY: what was given with the context.
    let host = unsafe { &*user.cast::<Mutex<Option<&Host>>>() };
    if let Some(host) = *host.lock().unwrap() {
        ok(host.hit(0, (0.2, 0.1), 1.0, 0));
    }
    for i in 0..count {
        // SAFETY: as its type says.
        unsafe { task.unwrap()(i, data) };
    }
}

#[test]
fn hits_from_other_threads_and_from_tasks_are_played_where_they_counted() {
    let reported: Mutex<Option<&Host>> = Mutex::new(None);
    let user = (&raw const reported).cast_mut().cast();
    let tasks = CrumpleTaskSystem { parallel_for: Some(parallel_for), user, workers: 2 };
    let mut host = Host::new(&CrumpleContextDef { tasks, ..crumple_context_def_default() });
    host.make_set();
    host.instance(CrumpleRule::MostDisplaced); // which tells every order of folds apart
    host.instance(CrumpleRule::Marks);
    for instance in host.instances.clone() {
        host.buffer(instance, 0);
    }
    ok(host.begin());
    let shared: *const Host = &host;
    // SAFETY: the host outlives every call that could reach it; the reference is taken back below.
    *reported.lock().unwrap() = Some(unsafe { &*shared });
    let turn = AtomicU32::new(0);
    std::thread::scope(|scope| {
        for t in 0..3 {
            let (host, turn) = (&host, &turn);
            scope.spawn(move || {
                for i in 0..60 {
                    let x = (i * 7 + t * 13) % 20;
                    ok(host.hit(t % 2, (x as f32 / 20.0 - 0.5, 0.1 * t as f32), 1.0 + t as f32, 0));
                }
                turn.fetch_add(1, Ordering::Relaxed);
            });
        }
        while turn.load(Ordering::Relaxed) < 3 {
            host.deform();
        }
    });
    host.deform();
    *reported.lock().unwrap() = None;
    let report = same(&host.end());
    assert!(report.hits >= 180, "{report:?}");
}

#[test]
fn another_hit_than_the_one_recorded_is_told() {
    let mut host = Host::with_set();
    host.instance(CrumpleRule::Marks);
    let first = host.instances[0];
    host.buffer(first, 0);
    ok(host.begin());
    ok(host.hit(0, (0.1, 0.0), 2.0, 0));
    host.deform();
    let bytes = host.end();
    same(&bytes);

    let forged = host.directory.path().join("forged");
    let mut reader = Reader::new(&bytes).unwrap();
    let mut writer = Writer::create(&forged, reader.version).unwrap();
    while let Some(mut event) = reader.next().unwrap() {
        if let Event::Hit(Call::SubmitImpulse { hit, .. }) = &mut event {
            hit.impulse[2] *= 1.5;
        }
        writer.write(&event);
    }
    drop(writer);
    let mut calls = Vec::new();
    let found =
        replay(&std::fs::read(forged).unwrap(), 1, &mut |number, text| calls.push((number, text.to_string()))).unwrap();
    // The hit's answer, and the vertices.
    assert_eq!(found.differences, 2);
    let first = found.first.unwrap();
    assert_eq!(first.function, "crumple_instance_submit_impulse");
    assert!(calls.iter().any(|(n, text)| *n == first.call && text.contains("duration: 0.01")), "{calls:?}");
}

#[test]
fn a_recording_says_why_it_cannot_begin_or_go_on() {
    let mut host = Host::with_set();
    host.instance(CrumpleRule::Marks);
    // SAFETY: the context lives.
    assert_eq!(unsafe { crumple_recording_end(host.context) }, R::CrumpleErrorInvalidArgument);
    assert!(said().contains("crumple_recording_begin() first"), "{}", said());
    // SAFETY: as above.
    assert_eq!(unsafe { crumple_recording_begin(host.context, null()) }, R::CrumpleErrorNullPointer);
    let nowhere = host.directory.path().join("no/such/folder");
    assert_eq!(host.begin_at(&nowhere), R::CrumpleErrorIo);
    assert!(said().contains("no/such/folder"), "{}", said());

    ok(host.hit(0, (0.0, 0.0), 1.0, 7));
    assert_eq!(host.begin(), R::CrumpleErrorInvalidArgument);
    assert!(said().contains("instance 1 has 1 open contacts"), "{}", said());
    assert!(!host.path().exists());
    // SAFETY: plain values.
    ok(unsafe { crumple_instance_end_contact(host.context, host.instances[0], 7) });
    ok(host.begin());
    assert_eq!(host.begin(), R::CrumpleErrorInvalidArgument);
    assert!(said().contains("calls.crumplerec runs already"), "{}", said());
    // A call that is refused is noted, with what it said.
    // SAFETY: as above.
    unsafe { crumple_instance_repair_damage(host.context, host.instances[0], f32::NAN) };
    let report = same(&host.end());
    assert_eq!(report.refused.len(), 1);
    assert!(report.refused[0].contains("CRUMPLE_ERROR_NOT_FINITE: keep is NaN"), "{:?}", report.refused);
    // Another one is another file.
    ok(host.begin());
    same(&host.end());
}

/// The fuzzer found that a replay did not know it.
#[test]
fn a_contact_that_ended_before_a_recording_is_forgotten() {
    let mut host = Host::with_set();
    host.instance(CrumpleRule::Marks);
    let (context, body) = (host.context, host.instances[0]);
    let depth = || {
        let mut told = MaybeUninit::uninit();
        // SAFETY: the context lives, and the call writes the result if it succeeds.
        unsafe {
            ok(crumple_instance_get_contact(context, body, 7, told.as_mut_ptr()));
            told.assume_init().achieved.z
        }
    };
    ok(host.hit(0, (0.0, 0.0), 1.0, 7));
    // SAFETY: plain values.
    ok(unsafe { crumple_instance_end_contact(context, body, 7) });
    assert!(depth() < 0.0);
    ok(host.begin());
    assert_eq!(depth(), 0.0);
    same(&host.end());
}

#[test]
fn parts_come_off_and_go_on_again_as_recorded() {
    let mut host = Host::with_set();
    host.add_lod();
    host.instance(CrumpleRule::Marks);
    let body = host.instances[0];
    host.buffer(body, 0);
    host.buffer(body, 1);
    ok(host.begin());
    ok(host.hit(0, (0.1, 0.1), 1.0, 0));
    host.deform();
    let mut part = CrumpleInstance::default();
    // SAFETY: all outputs live across the calls.
    unsafe {
        ok(crumple_instance_release_part(host.context, body, 1, &mut part));
        assert_eq!(crumple_instance_release_part(host.context, body, 1, &mut part), R::CrumpleErrorInvalidArgument);
        host.instances.push(part);
        ok(host.hit(1, (-0.2, 0.1), 1.0, 0));
        host.deform();
        ok(crumple_instance_mount_part(host.context, body, part, MaybeUninit::new(true)));
        ok(host.hit(0, (0.0, -0.2), 1.0, 3));
        host.deform();
        let (mut deepest, mut mean) = (0.0, 0.0);
        ok(crumple_instance_measure_part(host.context, part, 1, &mut deepest, &mut mean, null_mut()));
        assert!(mean > 0.0 && mean < deepest);
        ok(crumple_instance_mount_part(host.context, body, part, MaybeUninit::new(false)));
        let off = MaybeUninit::new(false);
        assert_eq!(crumple_instance_set_part_rigid(host.context, part, 1, off), R::CrumpleErrorInvalidArgument);
        ok(crumple_instance_set_part_rigid(host.context, body, 1, MaybeUninit::new(true)));
    }
    ok(host.hit(0, (0.3, 0.3), 1.0, 0));
    host.deform();
    let report = same(&host.end());
    assert_eq!((report.hits, report.deforms), (4, 4));
    assert_eq!(host.begin(), R::CrumpleErrorInvalidArgument);
    assert!(said().contains("instance 1 has parts"), "{}", said());
}

#[test]
fn thresholds_are_passed_as_recorded() {
    let mut host = Host::with_set();
    host.instance(CrumpleRule::Marks);
    host.instance(CrumpleRule::Marks);
    ok(host.begin());
    let mut passed = [CrumplePassed::default(); 2];
    let mut count = 0;
    let mut point = CrumpleAttachment::default();
    // SAFETY: all pointers are to what lives across the calls.
    unsafe {
        let at = CrumpleVec3 { x: 0.1, y: 0.1, z: 0.0 };
        ok(crumple_example_set_attach_point(host.context, host.set, at, &mut point));
        for (number, of) in [(7, 1), (5, 0), (6, 1)] {
            let measure = if number == 6 { CrumpleMeasure::Displacement } else { CrumpleMeasure::Deepest };
            let default = crumple_threshold_def_default();
            let measure = MaybeUninit::new(measure);
            let def = CrumpleThresholdDef { number, measure, attachment: point, limit: 1e-4, ..default };
            ok(crumple_instance_set_threshold(host.context, host.instances[of], &def));
        }
        for hit in 0..2 {
            ok(host.hit(hit, (0.1, 0.1), 1.0, 0));
        }
        // No room is no loss.
        ok(crumple_context_get_passed(host.context, null_mut(), 0, &mut count));
        assert_eq!(count, 0);
        let null = crumple_context_get_passed(host.context, null_mut(), 2, &mut count);
        assert_eq!(null, R::CrumpleErrorNullPointer);
        for expected in [&[5u32, 6][..], &[7]] {
            ok(crumple_context_get_passed(host.context, passed.as_mut_ptr(), 2, &mut count));
            let numbers: Vec<u32> = passed[..count as usize].iter().map(|p| p.number).collect();
            assert_eq!(numbers, expected);
        }
        assert!(passed[0].instance == host.instances[1] && passed[0].value > 1e-4);
    }
    same(&host.end());
    assert_eq!(host.begin(), R::CrumpleErrorInvalidArgument);
    assert!(said().contains("instance 1 has thresholds"), "{}", said());
}

#[test]
fn a_transform_may_be_set_while_the_context_is_in_use_and_is_recorded() {
    let mut host = Host::with_set();
    host.instance(CrumpleRule::Marks);
    ok(host.begin());
    let mut matrix = glam::Mat4::IDENTITY.to_cols_array();
    matrix[12] = 0.5;
    let in_use = exclusive("crumple_test", host.context, |_, _| {
        // SAFETY: 16 floats.
        ok(unsafe { crumple_instance_set_transform(host.context, host.instances[0], matrix.as_ptr()) });
        Ok(())
    });
    ok(in_use);
    ok(host.hit(0, (0.1, 0.0), 2.0, 0));
    assert_eq!(same(&host.end()).hits, 1);
}

/// Gathers warnings.
#[cfg(target_os = "linux")]
extern "C" fn note(level: MaybeUninit<CrumpleLogLevel>, message: *const std::ffi::c_char, user: *mut c_void) {
    // SAFETY: one of the enumerators, a text, and what was given with the context.
    let (level, text, all) =
        unsafe { (level.assume_init(), CStr::from_ptr(message), &*user.cast::<Mutex<Vec<String>>>()) };
    if level == CrumpleLogLevel::Warning {
        all.lock().unwrap().push(text.to_string_lossy().into_owned());
    }
}

#[cfg(target_os = "linux")]
#[test]
fn a_file_that_takes_no_more_ends_the_recording_and_nothing_else() {
    use std::os::fd::AsRawFd;
    let warnings = Mutex::new(Vec::<String>::new());
    let log_user = (&raw const warnings).cast_mut().cast();
    let mut host = Host::new(&CrumpleContextDef { log: Some(note), log_user, ..crumple_context_def_default() });
    let (reader, writer) = std::io::pipe().unwrap();
    ok(host.begin_at(Path::new(&format!("/proc/self/fd/{}", writer.as_raw_fd()))));
    drop(reader);
    host.make_set();
    host.instance(CrumpleRule::Marks);
    ok(host.hit(0, (0.0, 0.0), 1.0, 0));
    assert_eq!(warnings.lock().unwrap().len(), 1, "{warnings:?}");
    assert!(warnings.lock().unwrap()[0].starts_with("the recording ends here: /proc/self/fd/"), "{warnings:?}");
    // SAFETY: the context lives.
    assert_eq!(unsafe { crumple_recording_end(host.context) }, R::CrumpleErrorIo);
    ok(host.begin());
    same(&host.end());
}

/// A bug that somebody recorded becomes a test by being put there.
#[test]
fn recordings_that_were_kept_give_what_they_gave() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/fixtures");
    let files = std::fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path());
    let kept: Vec<PathBuf> = files.filter(|path| path.extension().is_some_and(|e| e == "crumplerec")).collect();
    assert!(!kept.is_empty());
    for path in kept {
        let report = replay(&std::fs::read(&path).unwrap(), 0, &mut |_, _| {}).unwrap();
        assert_eq!(report.first, None, "{}", path.display());
    }
}
