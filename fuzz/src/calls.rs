//! A host of the C interface that does what bytes say: calls in any order with any arguments, ids that are null, foreign,
//! stale or invented, callbacks that break their rules, and a second thread that submits hits meanwhile.
//!
//! It keeps the one contract that no library can check: pointers are null or point to as much memory as they claim.
#![allow(unsafe_op_in_unsafe_fn)]

use std::ffi::{CStr, CString, c_char, c_void};
use std::mem::MaybeUninit;
use std::ptr::{null, null_mut};
use std::sync::OnceLock;
use std::sync::atomic::{AtomicUsize, Ordering};

use arbitrary::Unstructured;
use crumple::entry_points::*;
use crumple::{Deltas, Mark};

use crate::seeds;

/// The most calls of one input.
const CALLS: usize = 64;

/// Does what the bytes say. A recording that was complete is replayed and must give the same.
pub fn run(data: &[u8]) {
    static FOLDER: OnceLock<tempfile::TempDir> = OnceLock::new();
    let folder = FOLDER.get_or_init(|| tempfile::tempdir().expect("a folder for recordings"));
    let path = folder.path().join("calls.crumplerec").to_str().expect("a path in UTF-8").to_owned();
    let recording = CString::new(path.clone()).expect("a path without a zero");
    let _ = std::fs::remove_file(&path);
    let mut host = Host::new(Unstructured::new(data), recording);
    for _ in 0..CALLS {
        if host.bytes.is_empty() || host.step().is_err() {
            break;
        }
    }
    let compare = host.comparable;
    drop(host);
    if compare && let Ok(bytes) = std::fs::read(&path) {
        let replay = crumple::replay(&bytes, 1, &mut |_, _| ()).expect("a recording of this library");
        assert!(replay.complete && replay.differences == 0, "{replay:?}");
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
    recording: CString,
    /// Whether a replay of the recording must give the same: its calls came from one thread at a time.
    comparable: bool,
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
    fn new(bytes: Unstructured<'a>, recording: CString) -> Self {
        let mut host = Self {
            bytes,
            contexts: Vec::new(),
            sets: Vec::new(),
            instances: Vec::new(),
            buffers: Vec::new(),
            attachments: Vec::new(),
            memory: Vec::new(),
            saved: vec![baked_set().clone()],
            recording,
            comparable: true,
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
        // SAFETY: both live across the call, and the callbacks for ever.
        if answered(unsafe { crumple_context_create(&def, &mut context) }) {
            self.contexts.push(context);
            CONTEXTS[number].store(context.addr(), Ordering::Relaxed);
        }
        Ok(())
    }

    /// One of these, the null id or an invented one.
    fn pick<T: Copy + bytemuck::Pod>(bytes: &mut Unstructured<'_>, list: &[T]) -> Step<T> {
        Ok(match bytes.arbitrary::<u8>()? {
            255 => bytemuck::pod_read_unaligned(&bytes.arbitrary::<[u8; 8]>()?),
            254 => T::zeroed(),
            i if list.is_empty() => bytemuck::pod_read_unaligned(&[i, 0, 0, 0, 1, 0, 1, 0]),
            i => list[usize::from(i) % list.len()],
        })
    }

    fn context(&mut self) -> Step<*mut CrumpleContext> {
        Ok(match self.bytes.arbitrary::<u8>()? {
            255 => self.bytes.arbitrary::<usize>()? as *mut CrumpleContext,
            254 => null_mut(),
            i if i < 224 => self.contexts[0],
            i => self.contexts[usize::from(i) % self.contexts.len()],
        })
    }

    fn set(&mut self) -> Step<CrumpleExampleSet> {
        Self::pick(&mut self.bytes, &self.sets)
    }

    fn instance(&mut self) -> Step<CrumpleInstance> {
        Self::pick(&mut self.bytes, &self.instances)
    }

    fn buffer(&mut self) -> Step<CrumpleBuffer> {
        Self::pick(&mut self.bytes, &self.buffers)
    }

    /// Up to four ids, or null.
    fn some<T>(&mut self, one: fn(&mut Self) -> Step<T>) -> Step<Vec<T>> {
        let count = self.bytes.int_in_range(0..=4)?;
        (0..count).map(|_| one(self)).collect()
    }

    /// A number that is at the edge of something more often than by chance.
    fn word(&mut self) -> Step<u32> {
        const EDGES: &[f32] = &[0.0, -0.0, 1.0, -1.0, 0.5, 0.01, -0.03, 1e-12, 1e30, f32::MAX, f32::INFINITY, f32::NAN];
        let kind = self.bytes.arbitrary::<u8>()?;
        Ok(match usize::from(kind & 31) {
            i if i < EDGES.len() => EDGES[i].to_bits(),
            12..=15 => u32::MAX >> (kind >> 5),
            i @ 16..=23 => i as u32 - 16,
            _ => self.bytes.arbitrary()?,
        })
    }

    fn number(&mut self) -> Step<f32> {
        Ok(f32::from_bits(self.word()?))
    }

    /// A point near the sheet, or any.
    fn point(&mut self) -> Step<CrumpleVec3> {
        let [x, y, any, _] = self.bytes.arbitrary::<[u8; 4]>()?;
        if any < 224 {
            return Ok([f32::from(x) / 255.0, f32::from(y) / 255.0, 0.0].into());
        }
        Ok([self.number()?, self.number()?, self.number()?].into())
    }

    /// Overwrites some words. The caller writes the pointers afterwards.
    fn patched<T: Copy>(&mut self, mut def: T) -> Step<T> {
        for _ in 0..self.bytes.arbitrary::<u8>()? & 3 {
            let at = self.bytes.choose_index(size_of::<T>() / 4)?;
            let word = self.word()?;
            // SAFETY: within the def, of which every pattern of bytes is a value.
            unsafe { (&raw mut def).cast::<u32>().add(at).write_unaligned(word) };
        }
        Ok(def)
    }

    /// An array to read, or less of it than there is, or none.
    fn input<T>(&mut self, values: &[T]) -> Step<CrumpleInput> {
        let mut input =
            CrumpleInput { data: values.as_ptr().cast(), size: size_of_val(values), stride: size_of::<T>() };
        match self.bytes.arbitrary::<u8>()? {
            255 => input.data = null(),
            254 => input.size /= 2,
            253 => input.stride = self.word()? as usize,
            252 => (input.data, input.size) = (input.data.wrapping_byte_add(2), input.size - 2),
            _ => {}
        }
        Ok(input)
    }

    fn no_input() -> CrumpleInput {
        CrumpleInput { data: null(), size: 0, stride: 0 }
    }

    /// A mesh of the given arrays. The def's own pointers are overwritten.
    fn mesh(&mut self, def: &mut CrumpleMeshDef, mesh: &crumple::MeshData, values: &[f32]) -> Step<()> {
        def.positions = self.input(&mesh.positions)?;
        def.indices = self.input(&mesh.triangles.as_flattened())?;
        let present = self.bytes.arbitrary::<u8>()?;
        let n = mesh.positions.len();
        for (bit, field, width) in [
            (1, &raw mut def.normals, 3),
            (2, &raw mut def.tangents, 4),
            (4, &raw mut def.depth_limits, 1),
            (8, &raw mut def.stiffness, 1),
        ] {
            let input = if present & bit != 0 { self.input(&values[..width * n])? } else { Self::no_input() };
            let stride = if input.stride == 4 { 4 * width } else { input.stride };
            // SAFETY: a field of the def.
            unsafe { field.write(CrumpleInput { stride, ..input }) };
        }
        Ok(())
    }

    fn mesh_def(&mut self, mesh: &crumple::MeshData, def: CrumpleMeshDef) -> Step<CrumpleMeshDef> {
        let def = CrumpleMeshDef {
            vertex_count: mesh.positions.len() as u32,
            index_count: 3 * mesh.triangles.len() as u32,
            ..def
        };
        self.patched(def)
    }

    fn create_set(&mut self) -> Step<()> {
        let context = self.context()?;
        let mut mesh = seeds::sheet(2 + 2 * u32::from(self.bytes.arbitrary::<u8>()? & 1));
        if self.bytes.ratio(1, 8)? {
            let at = self.bytes.choose_index(mesh.positions.len())?;
            mesh.positions[at][2] = self.number()?;
        }
        if self.bytes.ratio(1, 8)? {
            let at = self.bytes.choose_index(mesh.triangles.len())?;
            mesh.triangles[at][0] = self.word()?;
        }
        let mut values = vec![0.5; 4 * mesh.positions.len()];
        let at = self.bytes.choose_index(values.len())?;
        values[at] = self.number()?;
        let dents = seeds::dents(&mesh, 2);
        let add = |(p, d): (&[f32; 3], &[f32; 3])| [0, 1, 2].map(|k| p[k] + d[k]);
        let targets: Vec<Vec<[f32; 3]>> = dents
            .iter()
            .map(|dent| {
                let Deltas::Full(deltas) = &dent.positions else { unreachable!("dents are full") };
                mesh.positions.iter().zip(deltas).map(add).collect()
            })
            .collect();
        let indices = [0u32, 1, 3];
        let name = CString::new("d\u{e9}lle").expect("no zero");
        let mut examples = Vec::new();
        for target in &targets {
            let mut def = self.patched(crumple_example_def_default())?;
            def.name = if self.bytes.ratio(1, 2)? { name.as_ptr() } else { null() };
            let empty = Self::no_input();
            (def.target_positions, def.target_normals) = (self.input(target)?, empty);
            (def.delta_indices, def.position_deltas, def.normal_deltas) = (empty, empty, empty);
            if self.bytes.ratio(1, 4)? {
                def.target_positions = empty;
                def.delta_count = 3;
                def.delta_indices = self.input(&indices)?;
                def.position_deltas = self.input(&target[..3])?;
            }
            examples.push(def);
        }
        let mut def = crumple_example_set_def_default();
        def.mesh = self.mesh_def(&mesh, def.mesh)?;
        (def.example_count, def.options.stamp_resolution) = (2, 4);
        def = self.patched(def)?;
        let masses = self.bytes.ratio(1, 4)?;
        def.options.vertex_masses =
            if masses { self.input(&values[..mesh.positions.len()])? } else { Self::no_input() };
        self.mesh(&mut def.mesh, &mesh, &values)?;
        def.examples = examples.as_ptr();
        def.example_count = def.example_count.min(2);
        let mut set = CrumpleExampleSet::default();
        // SAFETY: the arrays live across the call.
        if answered(unsafe { crumple_example_set_create(context, &def, &mut set) }) {
            self.sets.push(set);
        }
        Ok(())
    }

    fn add_lod(&mut self) -> Step<()> {
        let (context, set) = (self.context()?, self.set()?);
        let mesh = seeds::sheet(4);
        let values = vec![0.5; 4 * mesh.positions.len()];
        let mut def = crumple_lod_def_default();
        def.mesh = self.mesh_def(&mesh, def.mesh)?;
        self.mesh(&mut def.mesh, &mesh, &values)?;
        let mut lod = 0;
        // SAFETY: the arrays live across the call.
        answered(unsafe { crumple_example_set_add_lod(context, set, &def, &mut lod) });
        Ok(())
    }

    /// Memory for vertices, in one array for each stream or interleaved.
    fn buffer_def(&mut self) -> Step<CrumpleHostBufferDef> {
        const VERTICES: usize = 200;
        let mut memory = vec![0.0f32; 14 * VERTICES];
        let (data, size) = (memory.as_mut_ptr().cast::<c_void>(), size_of_val(memory.as_slice()));
        self.memory.push(memory);
        let mut def = self.patched(crumple_host_buffer_def_default())?;
        let (present, interleaved) = (self.bytes.arbitrary::<u8>()?, self.bytes.ratio(1, 2)?);
        let stream = |first: usize, width: usize| {
            let (offset, stride) = if interleaved { (4 * first, 56) } else { (4 * first * VERTICES, 4 * width) };
            CrumpleStream { data, size, offset, stride }
        };
        let none = CrumpleStream { data: null_mut(), size: 0, offset: 0, stride: 0 };
        let either = |bit: u8, stream| if present & bit != 0 { stream } else { none };
        def.positions = either(!1 & 0xff, stream(0, 3));
        def.normals = either(2, stream(3, 3));
        def.tangents = either(4, stream(6, 4));
        def.wear = either(8, stream(10, 4));
        if self.bytes.ratio(1, 8)? {
            def.positions.stride = self.word()? as usize;
            def.positions.offset = self.word()? as usize;
            def.positions.size /= 1 + usize::from(self.bytes.arbitrary::<u8>()?);
        }
        Ok(def)
    }

    fn impulse(&mut self) -> Step<CrumpleImpulseDef> {
        let mut def = crumple_impulse_def_default();
        (def.point, def.duration, def.mass) = (self.point()?, 0.01, 1.0);
        def.impulse = [0.0, 0.0, -f32::from(self.bytes.arbitrary::<u8>()?) / 40.0].into();
        def.contact_id = u64::from(self.bytes.arbitrary::<u8>()? / 64);
        self.patched(def)
    }

    fn displacement(&mut self) -> Step<CrumpleDisplacementDef> {
        let mut def = crumple_displacement_def_default();
        def.point = self.point()?;
        def.displacement = [0.0, 0.0, -f32::from(self.bytes.arbitrary::<u8>()?) / 2000.0].into();
        def.contact_id = u64::from(self.bytes.arbitrary::<u8>()? / 64);
        self.patched(def)
    }

    /// Saved bytes, perhaps with one of them changed.
    fn saved_bytes(&mut self) -> Step<Vec<u8>> {
        let at = self.bytes.choose_index(self.saved.len())?;
        let mut bytes = self.saved[at].clone();
        if !bytes.is_empty() && self.bytes.ratio(1, 4)? {
            let at = self.bytes.choose_index(bytes.len())?;
            bytes[at] = self.bytes.arbitrary()?;
        }
        Ok(bytes)
    }

    /// Keeps what `save` fills, asked first for its size. Hits of another thread may merge marks meanwhile, and so make
    /// it smaller.
    fn save(&mut self, mut save: impl FnMut(*mut c_void, usize, *mut usize) -> CrumpleResult) {
        let mut size = 0;
        if answered(save(null_mut(), 0, &mut size)) {
            let mut bytes = vec![0u8; size];
            let alone = self.comparable;
            assert!(size == 0 || !answered(save(bytes.as_mut_ptr().cast(), size - 1, &mut size)) || !alone);
            if answered(save(bytes.as_mut_ptr().cast(), bytes.len(), &mut size)) {
                assert!(size == bytes.len() || (size < bytes.len() && !alone));
                bytes.truncate(size);
                self.saved.push(bytes);
            }
        }
    }

    /// Submits hits from another thread while this one goes on.
    fn meanwhile(&mut self) -> Step<()> {
        let (context, instance, hit) = (self.context()?.addr(), self.instance()?, self.displacement()?);
        self.comparable = false;
        let submit = move || {
            for _ in 0..20 {
                let mut told = MaybeUninit::uninit();
                let context = context as *mut CrumpleContext;
                // SAFETY: both live across the call.
                answered(unsafe { crumple_instance_submit_displacement(context, instance, &hit, told.as_mut_ptr()) });
            }
        };
        std::thread::scope(|scope| {
            scope.spawn(submit);
            (0..4).try_for_each(|_| self.step())
        })
    }

    fn step(&mut self) -> Step<()> {
        let call = self.bytes.int_in_range(0..=72u8)?;
        // SAFETY: every pointer is null or points to what the call may read or write.
        unsafe { self.call(call) }
    }

    /// # Safety
    /// None is needed; the calls in it are unsafe.
    unsafe fn call(&mut self, call: u8) -> Step<()> {
        // These make something, or are not calls of one context.
        match call {
            0 if self.contexts.len() < 4 => return self.create_context(),
            1 => return self.create_set(),
            2 => return self.add_lod(),
            3 => return self.meanwhile(),
            _ => {}
        }
        let context = self.context()?;
        let id = self.instance()?;
        let result = match call {
            4 => crumple_context_destroy(context),
            5 => {
                let (set, other, mut new) = (self.set()?, self.context()?, CrumpleExampleSet::default());
                let result = crumple_example_set_share(context, set, other, &mut new);
                self.sets.push(new);
                result
            }
            6 => crumple_example_set_destroy(context, self.set()?),
            7 => {
                let (bytes, mut new) = (self.saved_bytes()?, CrumpleExampleSet::default());
                let (data, kind) = (bytes.as_ptr().cast(), enumerator(self.word()? & 1));
                let size = bytes.len();
                self.saved.push(bytes); // it may be kept
                let result = crumple_example_set_load_baked_memory(context, data, size, kind, &mut new);
                self.sets.push(new);
                result
            }
            8 => {
                let (bytes, mut new) = (self.saved_bytes()?, CrumpleExampleSet::default());
                let mut def = self.patched(crumple_gltf_def_default())?;
                (def.path, def.mesh_name, def.options.vertex_masses) = (null(), null(), Self::no_input());
                crumple_example_set_load_gltf_memory(context, bytes.as_ptr().cast(), bytes.len(), &def, &mut new)
            }
            9 => {
                let mut new = CrumpleExampleSet::default();
                crumple_example_set_load_baked(context, c"/nowhere/\xff".as_ptr(), &mut new)
            }
            10 => {
                let set = self.set()?;
                self.save(|data, capacity, size| crumple_example_set_save_baked(context, set, data, capacity, size));
                return Ok(());
            }
            11 => {
                let (set, mut info) = (self.set()?, MaybeUninit::<CrumpleExampleSetInfo>::uninit());
                let result = crumple_example_set_get_info(context, set, info.as_mut_ptr());
                if result == CrumpleResult::CrumpleOk {
                    CStr::from_ptr(info.assume_init_ref().name).to_str().expect("UTF-8");
                }
                result
            }
            12 => {
                let (set, which) = (self.set()?, self.word()?);
                crumple_example_set_get_example(context, set, which, MaybeUninit::uninit().as_mut_ptr())
            }
            13 => {
                let (set, which) = (self.set()?, self.word()?);
                crumple_example_set_get_primitive(context, set, which, MaybeUninit::uninit().as_mut_ptr())
            }
            14 => {
                let (set, streams) = (self.set()?, self.buffer_def()?);
                let def = CrumpleMeshCopyDef {
                    lod: streams.lod,
                    positions: streams.positions,
                    normals: streams.normals,
                    tangents: streams.tangents,
                    ..crumple_mesh_copy_def_default()
                };
                crumple_example_set_copy_mesh(context, set, &def)
            }
            15 => {
                let (set, point, mut vertex) = (self.set()?, self.point()?, 0);
                crumple_example_set_find_nearest_vertex(context, set, point, &mut vertex, null_mut())
            }
            16..=19 => {
                let mut def = CrumpleInstanceDef { set: self.set()?, ..crumple_instance_def_default() };
                def.rule = enumerator(self.word()? & 3);
                let (mut def, mut new) = (self.patched(def)?, CrumpleInstance::default());
                def.mark_capacity = def.mark_capacity.min(70_000);
                let result = crumple_instance_create(context, &def, &mut new);
                self.instances.push(new);
                result
            }
            20 => crumple_instance_destroy(context, id),
            21 => {
                let mut info = MaybeUninit::<CrumpleInstanceInfo>::uninit();
                crumple_instance_get_info(context, id, info.as_mut_ptr())
            }
            22 => {
                let mut matrix = crumple_instance_def_default().local_to_world;
                let at = self.bytes.choose_index(16)?;
                matrix[at] = self.number()?;
                crumple_instance_set_transform(context, id, matrix.as_ptr())
            }
            23 => crumple_instance_set_depth_limit(context, id, self.number()?),
            24 => crumple_context_set_time(context, f64::from(self.number()?)),
            25 => crumple_instance_set_tolerance(context, id, self.number()?),
            26 => {
                let (pixels, distance, fov, height) = (self.number()?, self.number()?, self.number()?, self.number()?);
                crumple_instance_set_view(context, id, pixels, distance, fov, height, null_mut())
            }
            27 => {
                let mut part = CrumpleInstance::default();
                let result = crumple_instance_release_part(context, id, self.word()?, &mut part);
                self.instances.push(part);
                result
            }
            28 => {
                let (part, mounted) = (self.instance()?, self.bytes.arbitrary::<u8>()?);
                crumple_instance_mount_part(context, id, part, boolean(mounted))
            }
            29 => {
                let (part, rigid) = (self.word()?, self.bytes.arbitrary::<u8>()?);
                crumple_instance_set_part_rigid(context, id, part, boolean(rigid))
            }
            30 => crumple_instance_measure_part(context, id, self.word()?, &mut 0.0, null_mut(), &mut 0.0),
            31..=34 => {
                let def = self.impulse()?;
                crumple_instance_submit_impulse(context, id, &def, null_mut())
            }
            35..=38 => {
                let def = self.displacement()?;
                crumple_instance_submit_displacement(context, id, &def, MaybeUninit::uninit().as_mut_ptr())
            }
            39 => {
                let (ids, def) = (self.some(Self::instance)?, self.impulse()?);
                let defs = vec![def; ids.len()];
                crumple_context_submit_impulses(context, ids.as_ptr(), defs.as_ptr(), ids.len() as u32, null_mut())
            }
            40 => {
                let (ids, def) = (self.some(Self::instance)?, self.displacement()?);
                let defs = vec![def; ids.len()];
                crumple_context_submit_displacements(context, ids.as_ptr(), defs.as_ptr(), ids.len() as u32, null_mut())
            }
            41 => {
                let def = self.impulse()?;
                crumple_instance_preview_impulse(context, id, &def, MaybeUninit::uninit().as_mut_ptr())
            }
            42 => {
                let n = 200;
                let (joints, weights) = (vec![[0u16, 1, 0, 0]; n], vec![[0.5f32, 0.5, 0.0, 0.0]; n]);
                let mut matrices = vec![crumple_instance_def_default().local_to_world; 2];
                let at = self.bytes.choose_index(16)?;
                matrices[1][at] = self.number()?;
                let skin = CrumpleSkinDef {
                    matrix_count: 2,
                    joints: self.input(&joints)?,
                    weights: self.input(&weights)?,
                    matrices: self.input(&matrices)?,
                    ..crumple_skin_def_default()
                };
                let mut def = self.displacement()?;
                crumple_instance_unpose_displacement(context, id, &skin, &mut def)
            }
            43 => crumple_instance_end_contact(context, id, u64::from(self.word()?)),
            44 => {
                let contact = u64::from(self.word()?);
                crumple_instance_get_contact(context, id, contact, MaybeUninit::uninit().as_mut_ptr())
            }
            45 => {
                let mut marks = [Mark::new(0, 0.0, [crumple::Pair::NONE; 4]); 4];
                let (capacity, mut count) = (self.word()?.min(4), 0);
                crumple_instance_get_marks(context, id, marks.as_mut_ptr(), capacity, &mut count)
            }
            46 => {
                let mut marks = [Mark::new(0, 0.0, [crumple::Pair::NONE; 4]); 4];
                for mark in &mut marks {
                    mark.contact = self.word()?;
                    mark.depth = self.number()?;
                    mark.energy = Mark::ONE;
                    mark.pairs[0] = bytemuck::pod_read_unaligned(&self.bytes.arbitrary::<[u8; 4]>()?);
                }
                crumple_instance_set_marks(context, id, marks.as_ptr(), self.word()?.min(4))
            }
            47 => {
                self.save(|data, capacity, size| crumple_instance_save_damage(context, id, data, capacity, size));
                return Ok(());
            }
            48 => {
                let since = u64::from(self.word()?);
                self.save(|data, capacity, size| {
                    crumple_instance_save_changes(context, id, since, data, capacity, size)
                });
                return Ok(());
            }
            49..=50 => {
                let bytes = self.saved_bytes()?;
                crumple_instance_load_damage(context, id, bytes.as_ptr().cast(), bytes.len())
            }
            51 => {
                let ids = self.some(Self::instance)?;
                let (list, count) = (ids.as_ptr(), ids.len() as u32);
                self.save(|data, capacity, size| {
                    crumple_context_save_damage(context, list, count, data, capacity, size)
                });
                return Ok(());
            }
            52 => {
                let (ids, bytes) = (self.some(Self::instance)?, self.saved_bytes()?);
                let data = bytes.as_ptr().cast();
                crumple_context_load_damage(context, ids.as_ptr(), ids.len() as u32, data, bytes.len())
            }
            53 => crumple_instance_repair_damage(context, id, self.number()?),
            54 => crumple_instance_repair_around(context, id, self.point()?, self.number()?, self.number()?),
            55 => crumple_instance_reset_damage(context, id),
            56 => crumple_instance_copy_damage(context, id, self.instance()?),
            57..=58 => {
                let (def, mut new) = (self.buffer_def()?, CrumpleBuffer::default());
                let result = crumple_buffer_register_host(context, id, &def, &mut new);
                self.buffers.push(new);
                result
            }
            59 => crumple_buffer_unregister(context, self.buffer()?),
            60 => crumple_buffer_invalidate(context, self.buffer()?),
            61 => {
                let (buffer, def) = (self.buffer()?, self.buffer_def()?);
                crumple_buffer_set_memory(context, buffer, &def)
            }
            62 => crumple_context_set_vertex_budget(context, u64::from(self.word()?)),
            63..=64 => {
                let ids = if self.bytes.ratio(1, 2)? { Vec::new() } else { self.some(Self::buffer)? };
                let list = if ids.is_empty() { null() } else { ids.as_ptr() };
                crumple_context_deform(context, list, ids.len() as u32, null_mut())
            }
            65 => {
                let (mut ids, mut count) = ([CrumpleBuffer::default(); 4], 0);
                crumple_context_get_changed_buffers(context, ids.as_mut_ptr(), self.word()?.min(4), &mut count)
            }
            66 => {
                let (buffer, mut ranges, mut count) = (self.buffer()?, [CrumpleRange::default(); 4], 0);
                let capacity = self.word()?.min(4);
                crumple_buffer_get_changes(context, buffer, ranges.as_mut_ptr(), capacity, &mut count, null_mut())
            }
            67 => {
                let (set, point, mut new) = (self.set()?, self.point()?, MaybeUninit::uninit());
                let result = crumple_example_set_attach_point(context, set, point, new.as_mut_ptr());
                if result == CrumpleResult::CrumpleOk {
                    self.attachments.push(new.assume_init());
                }
                result
            }
            68 => {
                let Some(at) = self.attachments.last().copied() else { return Ok(()) };
                let (at, mut frame) = (self.patched(at)?, CrumpleFrame::default());
                crumple_instance_get_attached_frame(context, id, &at, &mut frame)
            }
            69 => {
                let mut def = CrumpleThresholdDef { limit: 0.01, ..crumple_threshold_def_default() };
                if let Some(at) = self.attachments.last() {
                    def.attachment = *at;
                }
                def.measure = enumerator(self.word()? & 3);
                let def = self.patched(def)?;
                crumple_instance_set_threshold(context, id, &def)
            }
            70 => {
                let (mut passed, mut count) = ([CrumplePassed::default(); 4], 0);
                crumple_context_get_passed(context, passed.as_mut_ptr(), self.word()?.min(4), &mut count)
            }
            71 => {
                let (buffer, mut ranges, mut count) = (self.buffer()?, [CrumpleRange::default(); 4], 0);
                let (ranges, capacity) = (ranges.as_mut_ptr(), self.word()?.min(4));
                crumple_buffer_get_changed_triangles(context, buffer, ranges, capacity, &mut count, null_mut())
            }
            _ => {
                // Two contexts that write one file would be the host's own fault.
                let first = self.contexts[0];
                if self.bytes.ratio(1, 4)? {
                    crumple_recording_end(first)
                } else {
                    crumple_recording_begin(first, self.recording.as_ptr())
                }
            }
        };
        answered(result);
        Ok(())
    }
}

/// A set of a sheet with four dents, as C gets it from a file.
fn baked_set() -> &'static Vec<u8> {
    static FILE: OnceLock<Vec<u8>> = OnceLock::new();
    FILE.get_or_init(|| seeds::dented()[0].example_set().save().expect("a small set"))
}

/// An enumerator or any other number.
fn enumerator<E>(number: u32) -> MaybeUninit<E> {
    const { assert!(size_of::<E>() == 4) };
    let mut value = MaybeUninit::<E>::uninit();
    // SAFETY: four bytes, as asserted.
    unsafe { value.as_mut_ptr().cast::<u32>().write(number) };
    value
}

/// A byte that C passes as a `bool`.
fn boolean(byte: u8) -> MaybeUninit<bool> {
    let mut value = MaybeUninit::<bool>::uninit();
    // SAFETY: one byte.
    unsafe { value.as_mut_ptr().cast::<u8>().write(byte) };
    value
}
