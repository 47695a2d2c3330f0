//! Makes the calls of a recording again, through the C interface as the host did, and compares what they give.

use super::attach::*;
use super::buffer::*;
use super::context::*;
use super::damage::*;
use super::deform::{
    CrumpleDeformReport, crumple_context_deform, crumple_context_set_vertex_budget, fold_all, vertices_digest,
};
use super::hit::*;
use super::host_memory::CrumpleHostBufferDef;
use super::instance::*;
use super::load::{CrumpleBytes, crumple_example_set_load_baked_memory};
use super::record_call::{Bytes, Call, DisplacementHit, ImpulseHit, Number, Written};
use super::record_file::{Ended, Event, Reader};
use super::recorder::digest;
use super::result::{CrumpleResult, crumple_last_error, crumple_result_name};
use super::set::crumple_example_set_destroy;
use super::threshold::*;
use super::types::{CrumpleBuffer, CrumpleExampleSet, CrumpleInstance, CrumpleStream, CrumpleStriker};
use crate::base::error::Error;
use crate::damage::mark::Mark;
use std::collections::HashMap;
use std::ffi::{CStr, c_void};
use std::fmt;
use std::mem::MaybeUninit;
use std::ptr::null_mut;

/// What a replay found.
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub struct Replay {
    /// Version of the library that was recorded, as `crumple_version()` gives it. Another one may well deform otherwise.
    pub recorded_by: u32,
    /// Whether the recording has its end. Without it the program ended, perhaps in the recording's last call.
    pub complete: bool,
    /// Calls that were made again, hits among them.
    pub calls: u64,
    /// Hits among them.
    pub hits: u64,
    /// Deforms among them, and vertices that they wrote.
    pub deforms: u64,
    /// See `deforms`.
    pub vertices_written: u64,
    /// Calls that were refused before they did anything, each with the message that it gave.
    pub refused: Vec<String>,
    /// How many calls gave something else than was recorded.
    pub differences: u64,
    /// The first of them.
    pub first: Option<Difference>,
}

/// A call that gave something else than was recorded.
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub struct Difference {
    /// Which call of the recording, from 1 on.
    pub call: u64,
    /// The C function.
    pub function: String,
    /// What was recorded, and what it gave now.
    pub what: String,
}

/// Makes the calls of a recording of `crumple_recording_begin` again, on so many threads (0: one a core; the results do not
/// depend on it), and compares what they give with what they gave. `each` hears of every call, before it is made, with its
/// number and its text.
///
/// What was written for a Vulkan device is made on the CPU and not compared, since nobody read it.
///
/// # Errors
/// [`Error::Format`] for bytes that are no recording, or damaged; [`Error::Unsupported`] for a recording of another format;
/// [`Error::OutOfMemory`] where no context can be made. A file that is cut short is no error: see [`Replay::complete`].
pub fn replay(bytes: &[u8], threads: u32, each: &mut dyn FnMut(u64, fmt::Arguments<'_>)) -> Result<Replay, Error> {
    let mut reader = Reader::new(bytes)?;
    let mut report = Replay {
        recorded_by: reader.version,
        complete: false,
        calls: 0,
        hits: 0,
        deforms: 0,
        vertices_written: 0,
        refused: Vec::new(),
        differences: 0,
        first: None,
    };
    let mut player = Player::new(threads)?;
    let mut open = None;
    while let Some(event) = reader.next()? {
        match event {
            Event::Call(call) => {
                possible(&call, bytes.len())?;
                open = Some(player.play(call, &mut report, each));
            }
            Event::Ended(then) => match open.take() {
                Some(now) => player.compare(now, then, &mut report),
                None => return Err(Error::Format { what: "the recording ends a call that it did not begin".into() }),
            },
            Event::Hit(call) => {
                report.hits += u64::from(!matches!(call, Call::SetTransform { .. }));
                let now = player.play(call, &mut report, each);
                if let Some(Event::HitEnded(then)) = reader.next()? {
                    player.compare(now, then, &mut report);
                }
            }
            Event::HitEnded(_) => {
                return Err(Error::Format { what: "the recording ends a hit that it did not begin".into() });
            }
            Event::Refused { function, result, message } => {
                report.refused.push(format!("{function}: {}: {message}", name_of(result)));
            }
            Event::End => {
                report.complete = true;
                break;
            }
        }
    }
    Ok(report)
}

/// Refuses memory for more vertices than the sets in so many bytes can have.
fn possible(call: &Call, bytes: usize) -> Result<(), Error> {
    match call {
        Call::RegisterBuffer { vertices, .. }
        | Call::RegisterWornBuffer { vertices, .. }
        | Call::RegisterPackedBuffer { vertices, .. }
        | Call::SetBufferMemory { vertices, .. }
        | Call::SetWornBufferMemory { vertices, .. }
        | Call::SetPackedBufferMemory { vertices, .. }
            if *vertices as usize > bytes / size_of::<[f32; 3]>() =>
        {
            let what = format!("the recording registers a buffer of {vertices} vertices, more than its sets can have");
            Err(Error::Format { what })
        }
        _ => Ok(()),
    }
}

/// What a call gave, and what that is the answer to.
struct Played {
    number: u64,
    function: &'static str,
    now: Ended,
    message: Option<String>,
    /// Something that the recording knows by a number of its own.
    made: Option<Made>,
    compared: Compared,
}

/// Whether the recording knows what a call gives.
#[derive(Clone, Copy, PartialEq)]
enum Compared {
    Yes,
    WhereItWasGiven,
    No,
}

enum Made {
    Set(CrumpleExampleSet),
    Instance(CrumpleInstance),
    Buffer(CrumpleBuffer, Memory),
}

/// Memory in the host's place.
struct Memory {
    /// Positions, normals, tangents and wear, with the words of a value.
    streams: [(Vec<u32>, usize); 4],
    written: Written,
}

impl Memory {
    fn new(vertices: u32, written: Written) -> Self {
        let stream = |there: bool, words: usize| (vec![0; if there { words * vertices as usize } else { 0 }], words);
        let words = |octahedral: bool, floats: usize| if octahedral { 1 } else { floats };
        let streams = [
            stream(true, 3),
            stream(written.normals, words(written.octahedral_normals, 3)),
            stream(written.tangents, words(written.octahedral_tangents, 4)),
            stream(written.wear, 4),
        ];
        Self { streams, written }
    }

    fn def(&mut self, lod: u32) -> CrumpleHostBufferDef {
        let [positions, normals, tangents, wear] = self.streams.each_mut().map(|(values, words)| {
            if values.is_empty() {
                return CrumpleStream { data: null_mut(), size: 0, offset: 0, stride: 0 };
            }
            let data = values.as_mut_ptr().cast();
            CrumpleStream { data, size: size_of_val(values.as_slice()), offset: 0, stride: 4 * *words }
        });
        CrumpleHostBufferDef {
            lod,
            positions,
            normals,
            tangents,
            wear,
            normal_format: enumerator(self.written.octahedral_normals.into()),
            tangent_format: enumerator(self.written.octahedral_tangents.into()),
            ..crumple_host_buffer_def_default()
        }
    }
}

/// A context, and what the recording's numbers stand for in it.
struct Player {
    context: *mut CrumpleContext,
    sets: HashMap<Number, CrumpleExampleSet>,
    instances: HashMap<Number, CrumpleInstance>,
    /// Memory goes only after the context.
    buffers: HashMap<Number, (CrumpleBuffer, Memory)>,
}

impl Drop for Player {
    fn drop(&mut self) {
        // SAFETY: nothing else uses it.
        unsafe { crumple_context_destroy(self.context) };
    }
}

impl Player {
    fn new(threads: u32) -> Result<Self, Error> {
        let def = CrumpleContextDef { threads, ..crumple_context_def_default() };
        let mut context = null_mut();
        // SAFETY: both live across the call.
        let result = unsafe { crumple_context_create(&def, &mut context) };
        if result != CrumpleResult::CrumpleOk {
            return Err(Error::OutOfMemory { what: last_error(), bytes: 0 });
        }
        Ok(Self { context, sets: HashMap::new(), instances: HashMap::new(), buffers: HashMap::new() })
    }

    /// An id that the recording names; one that never was where it does not.
    fn instance(&self, number: Number) -> CrumpleInstance {
        self.instances.get(&number).copied().unwrap_or_default()
    }

    fn buffer(&self, number: Number) -> CrumpleBuffer {
        self.buffers.get(&number).map_or_else(CrumpleBuffer::default, |(id, _)| *id)
    }

    fn play(&mut self, call: Call, report: &mut Replay, each: &mut dyn FnMut(u64, fmt::Arguments<'_>)) -> Played {
        report.calls += 1;
        let number = report.calls;
        each(number, format_args!("{}: {call:?}", call.function()));
        let function = call.function();
        let compared = match call {
            // What the device writes is not read. How far changes go back depends on calls before the recording.
            Call::Record { .. } | Call::SaveChanges { .. } => Compared::No,
            // Whether it fits depends on memory of the host's, in whose place there is enough.
            Call::GetMarks { .. } | Call::SaveDamage { .. } | Call::SaveAll { .. } => Compared::WhereItWasGiven,
            _ => Compared::Yes,
        };
        let mut played =
            Played { number, function, now: Ended { result: 0, value: 0 }, message: None, made: None, compared };
        // SAFETY: the context lives and no other thread is here. Each pointer is to something that lives across the call;
        // registered memory lives in `buffers` until the buffer or the context is gone.
        let result = unsafe { self.make(call, &mut played, report) };
        played.now.result = result as u32;
        played.message = (result != CrumpleResult::CrumpleOk).then(last_error);
        played
    }

    /// Makes a call; what it made and what stands for its outputs go into `played`.
    unsafe fn make(&mut self, call: Call, played: &mut Played, report: &mut Replay) -> CrumpleResult {
        let context = self.context;
        let (made, value) = (&mut played.made, &mut played.now.value);
        match call {
            Call::Set { set, bytes: Bytes(bytes) } => {
                let (mut new, copy) = (CrumpleExampleSet::default(), MaybeUninit::new(CrumpleBytes::Copy));
                let data = bytes.as_ptr().cast();
                let result = crumple_example_set_load_baked_memory(context, data, bytes.len(), copy, &mut new);
                if result == CrumpleResult::CrumpleOk {
                    if let Some(old) = self.sets.remove(&set) {
                        crumple_example_set_destroy(context, old);
                    }
                    *made = Some(Made::Set(new));
                }
                result
            }
            Call::DestroySet { set } => {
                crumple_example_set_destroy(context, self.sets.remove(&set).unwrap_or_default())
            }
            Call::CreateInstance { .. } => {
                let mut new = CrumpleInstance::default();
                let result = crumple_instance_create(context, &self.instance_def(&call), &mut new);
                *made = (result == CrumpleResult::CrumpleOk).then_some(Made::Instance(new));
                result
            }
            Call::DestroyInstance { instance } => crumple_instance_destroy(context, self.instance(instance)),
            Call::SetTransform { instance, local_to_world } => {
                crumple_instance_set_transform(context, self.instance(instance), local_to_world.as_ptr())
            }
            Call::SetDepthLimit { instance, depth_limit } => {
                crumple_instance_set_depth_limit(context, self.instance(instance), depth_limit)
            }
            Call::SetTolerance { instance, tolerance } => {
                crumple_instance_set_tolerance(context, self.instance(instance), tolerance)
            }
            Call::SetVertexBudget { vertices } => crumple_context_set_vertex_budget(context, vertices),
            Call::SubmitImpulse { instance, hit } => {
                let (id, def) = (self.instance(instance), impulse_def(hit));
                answered(value, |out| crumple_instance_submit_impulse(context, id, &def, out))
            }
            Call::PreviewImpulse { instance, hit } => {
                let (id, def) = (self.instance(instance), impulse_def(hit));
                answered(value, |out| crumple_instance_preview_impulse(context, id, &def, out))
            }
            Call::SubmitDisplacement { instance, hit } => {
                let (id, def) = (self.instance(instance), displacement_def(hit));
                answered(value, |out| crumple_instance_submit_displacement(context, id, &def, out))
            }
            Call::PreviewDisplacement { instance, hit } => {
                let (id, def) = (self.instance(instance), displacement_def(hit));
                answered(value, |out| crumple_instance_preview_displacement(context, id, &def, out))
            }
            Call::EndContact { instance, contact_id } => {
                crumple_instance_end_contact(context, self.instance(instance), contact_id)
            }
            Call::GetMarks { instance } => {
                let (id, mut count) = (self.instance(instance), 0);
                let mut result = crumple_instance_get_marks(context, id, null_mut(), 0, &mut count);
                if result == CrumpleResult::CrumpleOk {
                    let mut marks: Vec<Mark> = vec![bytemuck::Zeroable::zeroed(); count as usize];
                    result = crumple_instance_get_marks(context, id, marks.as_mut_ptr(), count, &mut count);
                    *value = digest(bytemuck::cast_slice(&marks));
                }
                result
            }
            Call::SetMarks { instance, marks: Bytes(bytes) } => {
                let marks: Vec<Mark> = bytemuck::pod_collect_to_vec(&bytes);
                crumple_instance_set_marks(context, self.instance(instance), marks.as_ptr(), marks.len() as u32)
            }
            Call::SaveDamage { instance } => {
                let id = self.instance(instance);
                filled(value, |data, capacity, size| crumple_instance_save_damage(context, id, data, capacity, size))
            }
            Call::SaveChanges { instance, since } => {
                let id = self.instance(instance);
                filled(value, |data, capacity, size| {
                    crumple_instance_save_changes(context, id, since, data, capacity, size)
                })
            }
            Call::SaveAll { instances } => {
                let ids: Vec<_> = instances.iter().map(|&number| self.instance(number)).collect();
                filled(value, |data, capacity, size| {
                    crumple_context_save_damage(context, ids.as_ptr(), ids.len() as u32, data, capacity, size)
                })
            }
            Call::LoadAll { instances, bytes: Bytes(bytes) } => {
                let ids: Vec<_> = instances.iter().map(|&number| self.instance(number)).collect();
                let (data, size) = (bytes.as_ptr().cast(), bytes.len());
                crumple_context_load_damage(context, ids.as_ptr(), ids.len() as u32, data, size)
            }
            Call::LoadDamage { instance, bytes: Bytes(bytes) } => {
                crumple_instance_load_damage(context, self.instance(instance), bytes.as_ptr().cast(), bytes.len())
            }
            Call::RepairDamage { instance, keep } => {
                crumple_instance_repair_damage(context, self.instance(instance), keep)
            }
            Call::ReleasePart { instance, part } => {
                let mut new = CrumpleInstance::default();
                let result = crumple_instance_release_part(context, self.instance(instance), part, &mut new);
                *made = (result == CrumpleResult::CrumpleOk).then_some(Made::Instance(new));
                result
            }
            Call::MountPart { instance, part, mounted } => {
                let (id, part) = (self.instance(instance), self.instance(part));
                crumple_instance_mount_part(context, id, part, MaybeUninit::new(mounted))
            }
            Call::SetPartRigid { instance, part, rigid } => {
                crumple_instance_set_part_rigid(context, self.instance(instance), part, MaybeUninit::new(rigid))
            }
            Call::MeasurePart { instance, lod } => {
                let (mut deepest, mut mean) = (0.0, 0.0);
                let id = self.instance(instance);
                let result = crumple_instance_measure_part(context, id, lod, &mut deepest, &mut mean, null_mut());
                *value = measured_number(deepest, mean);
                result
            }
            Call::SetThreshold { instance, number, measure, lod, vertices, weights, point, limit } => {
                let attachment = CrumpleAttachment { vertices, weights, point: point.into(), reserved: [0; 3] };
                let measure = enumerator(measure);
                let default = crumple_threshold_def_default();
                let def = CrumpleThresholdDef { number, measure, lod, attachment, limit, ..default };
                crumple_instance_set_threshold(context, self.instance(instance), &def)
            }
            Call::GetPassed { capacity } => {
                // A recording is not trusted, and no host has room for a million.
                let mut passed = vec![CrumplePassed::default(); capacity.min(1 << 20) as usize];
                let (room, mut count) = (passed.len() as u32, 0);
                let result = crumple_context_get_passed(context, passed.as_mut_ptr(), room, &mut count);
                *value = passed_digest(&passed[..count as usize]);
                result
            }
            Call::RepairAround { instance, point, radius, keep } => {
                crumple_instance_repair_around(context, self.instance(instance), point.into(), radius, keep)
            }
            Call::SetTime { time } => crumple_context_set_time(context, time),
            Call::ResetDamage { instance } => crumple_instance_reset_damage(context, self.instance(instance)),
            Call::CopyDamage { instance, source } => {
                crumple_instance_copy_damage(context, self.instance(instance), self.instance(source))
            }
            Call::RegisterBuffer { instance, lod, vertices, normals, tangents } => {
                let written = Written::floats([normals, tangents, false]);
                self.register(instance, lod, Memory::new(vertices, written), made)
            }
            Call::RegisterWornBuffer { instance, lod, vertices, normals, tangents } => {
                let written = Written::floats([normals, tangents, true]);
                self.register(instance, lod, Memory::new(vertices, written), made)
            }
            Call::RegisterPackedBuffer { instance, lod, vertices, written } => {
                self.register(instance, lod, Memory::new(vertices, written), made)
            }
            Call::UnregisterBuffer { buffer } => {
                let result = crumple_buffer_unregister(context, self.buffer(buffer));
                self.buffers.remove(&buffer);
                result
            }
            Call::InvalidateBuffer { buffer } => crumple_buffer_invalidate(context, self.buffer(buffer)),
            Call::SetBufferMemory { buffer, lod, vertices, normals, tangents } => {
                self.set_memory(buffer, lod, Memory::new(vertices, Written::floats([normals, tangents, false])))
            }
            Call::SetWornBufferMemory { buffer, lod, vertices, normals, tangents } => {
                self.set_memory(buffer, lod, Memory::new(vertices, Written::floats([normals, tangents, true])))
            }
            Call::SetPackedBufferMemory { buffer, lod, vertices, written } => {
                self.set_memory(buffer, lod, Memory::new(vertices, written))
            }
            Call::Deform { all, buffers } | Call::Record { all, buffers } => self.deform(all, &buffers, value, report),
            Call::AttachedFrame { instance, vertices, weights, point } => {
                let attachment = CrumpleAttachment { vertices, weights, point: point.into(), reserved: [0; 3] };
                let (id, mut frame) = (self.instance(instance), CrumpleFrame::default());
                let result = crumple_instance_get_attached_frame(context, id, &attachment, &mut frame);
                if result == CrumpleResult::CrumpleOk {
                    *value = frame_digest(&frame);
                }
                result
            }
            Call::GetContact { instance, contact_id } => {
                let mut found = MaybeUninit::<CrumpleHitResult>::uninit();
                let id = self.instance(instance);
                let result = crumple_instance_get_contact(context, id, contact_id, found.as_mut_ptr());
                if result == CrumpleResult::CrumpleOk {
                    *value = hit_digest(found.assume_init_ref());
                }
                result
            }
            Call::InstanceInfo { instance } => {
                let mut info = MaybeUninit::<CrumpleInstanceInfo>::uninit();
                let result = crumple_instance_get_info(context, self.instance(instance), info.as_mut_ptr());
                if result == CrumpleResult::CrumpleOk {
                    *value = info_number(info.assume_init_ref());
                }
                result
            }
        }
    }

    fn instance_def(&self, call: &Call) -> CrumpleInstanceDef {
        let mut def = crumple_instance_def_default();
        if let &Call::CreateInstance {
            set,
            rule,
            selection,
            examples_per_hit,
            mark_capacity,
            depth_limit,
            yield_impulse,
            yield_displacement,
            max_contact_distance,
            blend_constant,
            tolerance,
            compliance,
            grow_time,
            local_to_world,
        } = call
        {
            def = CrumpleInstanceDef {
                examples_per_hit,
                set: self.sets.get(&set).copied().unwrap_or_default(),
                rule: enumerator(rule),
                selection: enumerator(selection),
                mark_capacity,
                depth_limit,
                yield_impulse,
                yield_displacement,
                max_contact_distance,
                blend_constant,
                tolerance,
                compliance,
                grow_time,
                local_to_world,
                ..def
            };
        }
        def
    }

    unsafe fn register(
        &self,
        instance: Number,
        lod: u32,
        mut memory: Memory,
        made: &mut Option<Made>,
    ) -> CrumpleResult {
        let mut new = CrumpleBuffer::default();
        let result = crumple_buffer_register_host(self.context, self.instance(instance), &memory.def(lod), &mut new);
        *made = (result == CrumpleResult::CrumpleOk).then_some(Made::Buffer(new, memory));
        result
    }

    unsafe fn set_memory(&mut self, buffer: Number, lod: u32, mut memory: Memory) -> CrumpleResult {
        let result = crumple_buffer_set_memory(self.context, self.buffer(buffer), &memory.def(lod));
        if let (CrumpleResult::CrumpleOk, Some(entry)) = (result, self.buffers.get_mut(&buffer)) {
            entry.1 = memory;
        }
        result
    }

    unsafe fn deform(&mut self, all: bool, buffers: &[Number], value: &mut u64, report: &mut Replay) -> CrumpleResult {
        if all {
            // The buffers that the recording names may be fewer than there are by now; its instances are all.
            let folded = exclusive("crumple_context_deform", self.context, |_, state| fold_all(&mut state.instances));
            if folded != CrumpleResult::CrumpleOk {
                return folded;
            }
        }
        // The pointer of an empty vector is not null, so that no buffer does not become all.
        let ids: Vec<CrumpleBuffer> = buffers.iter().map(|&number| self.buffer(number)).collect();
        let mut told = CrumpleDeformReport::default();
        let result = crumple_context_deform(self.context, ids.as_ptr(), ids.len() as u32, &mut told);
        if result != CrumpleResult::CrumpleOk {
            return result;
        }
        report.deforms += 1;
        report.vertices_written += told.vertices_written;
        exclusive("crumple_context_deform", self.context, |_, state| {
            let entries = ids.iter().map(|&id| state.buffers.get(id, "buffer")).collect::<Result<Vec<_>, _>>()?;
            *value = vertices_digest(entries.into_iter());
            Ok(())
        })
    }

    /// Notes what the recording calls what was made, and whether the call gave the same.
    fn compare(&mut self, played: Played, then: Ended, report: &mut Replay) {
        let known = played.made.is_some();
        match played.made {
            Some(Made::Set(id)) => drop(self.sets.insert(Number(then.value), id)),
            Some(Made::Instance(id)) => drop(self.instances.insert(Number(then.value), id)),
            Some(Made::Buffer(id, memory)) => drop(self.buffers.insert(Number(then.value), (id, memory))),
            None => {}
        }
        let Ended { result, value } = played.now;
        let compared = match played.compared {
            Compared::Yes => true,
            Compared::WhereItWasGiven => then.result == 0,
            Compared::No => false,
        };
        let what = if result != then.result && compared {
            let message = played.message.map(|message| format!(" ({message})")).unwrap_or_default();
            format!("recorded {}, now {}{message}", name_of(then.result), name_of(result))
        } else if value != then.value && !known && compared && result == 0 {
            format!("recorded {:016x}, now {value:016x}", then.value)
        } else {
            return;
        };
        report.differences += 1;
        let function = played.function.to_owned();
        report.first.get_or_insert(Difference { call: played.number, function, what });
    }
}

fn impulse_def(hit: ImpulseHit) -> CrumpleImpulseDef {
    CrumpleImpulseDef {
        space: enumerator(hit.space),
        point: hit.point.into(),
        impulse: hit.impulse.into(),
        duration: hit.duration,
        mass: hit.mass,
        normal: hit.normal.into(),
        striker: CrumpleStriker {
            mass: hit.striker_mass,
            radius: hit.striker_radius,
            velocity: hit.striker_velocity.into(),
        },
        contact_id: hit.contact_id,
        ..crumple_impulse_def_default()
    }
}

fn displacement_def(hit: DisplacementHit) -> CrumpleDisplacementDef {
    CrumpleDisplacementDef {
        space: enumerator(hit.space),
        point: hit.point.into(),
        displacement: hit.displacement.into(),
        contact_id: hit.contact_id,
        ..crumple_displacement_def_default()
    }
}

/// Reports a hit; a number that stands for its result goes into `value`.
fn answered(value: &mut u64, report: impl FnOnce(*mut CrumpleHitResult) -> CrumpleResult) -> CrumpleResult {
    let mut out = MaybeUninit::<CrumpleHitResult>::uninit();
    let result = report(out.as_mut_ptr());
    if result == CrumpleResult::CrumpleOk {
        // SAFETY: written, since the call succeeded.
        *value = hit_digest(unsafe { out.assume_init_ref() });
    }
    result
}

/// Asks a call for bytes, first for their number. What stands for them goes into `value`.
fn filled(value: &mut u64, mut save: impl FnMut(*mut c_void, usize, *mut usize) -> CrumpleResult) -> CrumpleResult {
    let mut size = 0;
    let mut result = save(null_mut(), 0, &mut size);
    if result == CrumpleResult::CrumpleOk {
        let mut bytes = vec![0u8; size];
        result = save(bytes.as_mut_ptr().cast(), size, &mut size);
        *value = digest(&bytes);
    }
    result
}

/// An enum with any number, as C can pass it; the call checks it.
fn enumerator<E>(number: u32) -> MaybeUninit<E> {
    const { assert!(size_of::<E>() == 4) };
    let mut value = MaybeUninit::<E>::uninit();
    // SAFETY: four bytes, as asserted, of memory that is ours.
    unsafe { value.as_mut_ptr().cast::<u32>().write(number) };
    value
}

fn name_of(result: u32) -> String {
    // SAFETY: never null, ends with a zero, lives for ever.
    unsafe { CStr::from_ptr(crumple_result_name(enumerator(result))) }.to_string_lossy().into_owned()
}

fn last_error() -> String {
    // SAFETY: never null, ends with a zero, and no other call of this thread changes it meanwhile.
    unsafe { CStr::from_ptr(crumple_last_error()) }.to_string_lossy().into_owned()
}
