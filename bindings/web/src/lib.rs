//! Crumple as a WebAssembly module. `crumple.js` is the interface; it alone calls these functions.
//!
//! Sets and bodies are pointers. Text and numbers cross the border in memory that [`alloc`] returns. A function that fails
//! returns null or -1, and [`error`] then describes why. There is one thread.

use std::cell::RefCell;
use std::sync::Arc;

use crumple::{Blow, Error, ExampleSet, Hit, Instance, InstanceOptions, Serial, Striker, StrikerShape, Tracker, VertexMemory};

/// Bytes at a multiple of 16, in which a set's arrays are used in place.
struct Bytes(Vec<u128>, usize);

impl AsRef<[u8]> for Bytes {
    fn as_ref(&self) -> &[u8] {
        &bytemuck::cast_slice(&self.0)[..self.1]
    }
}

/// An instance, and the vertices that the page draws.
pub struct Body {
    instance: Instance,
    tracker: Tracker,
    positions: Vec<[f32; 3]>,
    normals: Vec<[f32; 3]>,
    /// First vertex and number of vertices of each range that the last deform wrote.
    changed: Vec<[u32; 2]>,
    saved: Vec<u8>,
}

thread_local! {
    static ERROR: RefCell<String> = const { RefCell::new(String::new()) };
}

fn told<T>(result: Result<T, Error>) -> Option<T> {
    result.map_err(|e| ERROR.with_borrow_mut(|text| *text = e.to_string())).ok()
}

fn code<T>(result: Result<T, Error>, value: impl FnOnce(T) -> i32) -> i32 {
    told(result).map_or(-1, value)
}

/// Memory for `bytes` bytes, at a multiple of 16.
#[unsafe(no_mangle)]
pub extern "C" fn alloc(bytes: usize) -> *mut u128 {
    let words = vec![0u128; bytes.div_ceil(16)].into_boxed_slice();
    Box::into_raw(words).cast()
}

/// # Safety
/// `at` is from [`alloc`] with the same number of bytes, and nothing else owns it.
unsafe fn owned(at: *mut u128, bytes: usize) -> Bytes {
    let words = std::ptr::slice_from_raw_parts_mut(at, bytes.div_ceil(16));
    // SAFETY: the caller's promise.
    Bytes(unsafe { Box::from_raw(words) }.into_vec(), bytes)
}

/// Frees memory from [`alloc`].
///
/// # Safety
/// As [`owned`].
#[unsafe(no_mangle)]
pub unsafe extern "C" fn free(at: *mut u128, bytes: usize) {
    // SAFETY: the caller's promise.
    drop(unsafe { owned(at, bytes) });
}

/// The text of the last error, UTF-8.
#[unsafe(no_mangle)]
pub extern "C" fn error() -> *const u8 {
    ERROR.with_borrow(|text| text.as_ptr())
}

#[unsafe(no_mangle)]
pub extern "C" fn error_bytes() -> usize {
    ERROR.with_borrow(String::len)
}

/// A set from the bytes of a `.crumple` file. Takes the memory over.
///
/// # Safety
/// As [`owned`].
#[unsafe(no_mangle)]
pub unsafe extern "C" fn set_load(at: *mut u128, bytes: usize) -> *const ExampleSet {
    // SAFETY: the caller's promise.
    let file = unsafe { owned(at, bytes) };
    told(ExampleSet::load(file, &Serial)).map_or(std::ptr::null(), |set| Arc::into_raw(Arc::new(set)))
}

/// # Safety
/// A set of [`set_load`], which is not used afterwards. Bodies keep it alive.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn set_free(set: *const ExampleSet) {
    // SAFETY: the caller's promise.
    drop(unsafe { Arc::from_raw(set) });
}

/// # Safety
/// A set that was not freed; so below.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn set_vertices(set: *const ExampleSet) -> usize {
    // SAFETY: the caller's promise, here and below.
    unsafe { &*set }.vertex_count()
}

/// # Safety
/// As [`set_vertices`].
#[unsafe(no_mangle)]
pub unsafe extern "C" fn set_depth_limit(set: *const ExampleSet) -> f32 {
    unsafe { &*set }.depth_limit()
}

/// # Safety
/// As [`set_vertices`].
#[unsafe(no_mangle)]
pub unsafe extern "C" fn set_triangles(set: *const ExampleSet) -> *const u32 {
    unsafe { &*set }.mesh().triangles().as_ptr().cast()
}

/// # Safety
/// As [`set_vertices`].
#[unsafe(no_mangle)]
pub unsafe extern "C" fn set_triangle_count(set: *const ExampleSet) -> usize {
    unsafe { &*set }.mesh().triangles().len()
}

/// An undamaged body.
///
/// # Safety
/// As [`set_vertices`].
#[unsafe(no_mangle)]
pub unsafe extern "C" fn body_new(set: *const ExampleSet) -> *mut Body {
    // SAFETY: the caller's promise; the count grows by the one that the instance holds.
    let set = unsafe {
        Arc::increment_strong_count(set);
        Arc::from_raw(set)
    };
    let count = set.vertex_count();
    let normals = if set.mesh().normals().is_some() { vec![[0.0; 3]; count] } else { Vec::new() };
    let Some(instance) = told(Instance::new(set, InstanceOptions::default())) else { return std::ptr::null_mut() };
    let (tracker, positions) = (Tracker::new(), vec![[0.0; 3]; count]);
    Box::into_raw(Box::new(Body { instance, tracker, positions, normals, changed: Vec::new(), saved: Vec::new() }))
}

/// # Safety
/// A body of [`body_new`], which is not used afterwards.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn body_free(body: *mut Body) {
    // SAFETY: the caller's promise.
    drop(unsafe { Box::from_raw(body) });
}

/// Three floats a vertex.
///
/// # Safety
/// A body that was not freed; so below.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn body_positions(body: *const Body) -> *const f32 {
    // SAFETY: the caller's promise, here and below.
    unsafe { &*body }.positions.as_ptr().cast()
}

/// Three floats a vertex; null if the mesh has no normals.
///
/// # Safety
/// As [`body_positions`].
#[unsafe(no_mangle)]
pub unsafe extern "C" fn body_normals(body: *const Body) -> *const f32 {
    let normals = &unsafe { &*body }.normals;
    if normals.is_empty() { std::ptr::null() } else { normals.as_ptr().cast() }
}

/// A hit by a displacement, m. Returns the status ([`crumple::HitStatus`]), or -1.
///
/// # Safety
/// As [`body_positions`]; `numbers` are six floats: point and displacement.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn body_displace(body: *mut Body, numbers: *const [f32; 6]) -> i32 {
    let [x, y, z, dx, dy, dz] = unsafe { *numbers };
    let hit = Hit::displacement([x, y, z], [dx, dy, dz]);
    code(unsafe { &*body }.instance.submit(&hit), |outcome| outcome.status as i32)
}

/// A hit by a blow. What is not known is NaN. Returns the status, or -1.
///
/// # Safety
/// As [`body_positions`]; `numbers` are 16 floats: point, m; normal; impulse, N s; duration, s; the striker's mass, kg,
/// velocity, m/s, radius, m, and the number of its shape.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn body_blow(body: *mut Body, numbers: *const [f32; 16]) -> i32 {
    let n = unsafe { *numbers };
    let known = |at: usize| Some(n[at]).filter(|x| !x.is_nan());
    let vector = |at: usize| known(at).map(|x| [x, n[at + 1], n[at + 2]]);
    let shape = known(15).and_then(|shape| StrikerShape::ALL.get(shape as usize)).copied().unwrap_or_default();
    let striker = Striker { mass: known(10), velocity: vector(11), radius: known(14), shape };
    let blow = Blow { impulse: vector(6), duration: known(9), normal: vector(3), striker };
    let hit = Hit::blow([n[0], n[1], n[2]], blow);
    code(unsafe { &*body }.instance.submit(&hit), |outcome| outcome.status as i32)
}

/// Writes what changed into positions and normals. Returns the number of ranges that changed, or -1.
///
/// # Safety
/// As [`body_positions`].
#[unsafe(no_mangle)]
pub unsafe extern "C" fn body_deform(body: *mut Body) -> i32 {
    let Body { instance, tracker, positions, normals, changed, .. } = unsafe { &mut *body };
    let normals = (!normals.is_empty()).then_some(&mut normals[..]);
    let memory = VertexMemory::separate(positions, normals, None);
    let done = memory.and_then(|memory| instance.deform(tracker, memory, &Serial));
    changed.clear();
    code(done, |_| {
        changed.extend(tracker.changed().iter().map(|r| [r.start, r.end - r.start]));
        changed.len() as i32
    })
}

/// The ranges that the last deform wrote, as pairs of the first vertex and a number of vertices.
///
/// # Safety
/// As [`body_positions`].
#[unsafe(no_mangle)]
pub unsafe extern "C" fn body_changed(body: *const Body) -> *const u32 {
    unsafe { &*body }.changed.as_ptr().cast()
}

/// Scales the depth of every dent by `keep`, 0 to 1. Returns 0, or -1.
///
/// # Safety
/// As [`body_positions`].
#[unsafe(no_mangle)]
pub unsafe extern "C" fn body_repair(body: *mut Body, keep: f32) -> i32 {
    code(unsafe { &mut *body }.instance.repair(keep), |()| 0)
}

/// Keeps the damage as bytes, until the next call. Returns their number.
///
/// # Safety
/// As [`body_positions`].
#[unsafe(no_mangle)]
pub unsafe extern "C" fn body_save(body: *mut Body) -> usize {
    let body = unsafe { &mut *body };
    body.saved = body.instance.save();
    body.saved.len()
}

/// The bytes of [`body_save`].
///
/// # Safety
/// As [`body_positions`].
#[unsafe(no_mangle)]
pub unsafe extern "C" fn body_saved(body: *const Body) -> *const u8 {
    unsafe { &*body }.saved.as_ptr()
}

/// Replaces the damage by saved damage. Returns 0, or -1.
///
/// # Safety
/// As [`body_positions`]; `at` has so many bytes.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn body_load(body: *mut Body, at: *const u8, bytes: usize) -> i32 {
    let saved = unsafe { std::slice::from_raw_parts(at, bytes) };
    code(unsafe { &mut *body }.instance.load(saved), |()| 0)
}
