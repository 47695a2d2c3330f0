//! Recordings made right: a fuzzer changes bytes, and every event has a checksum.

use std::ffi::CString;
use std::mem::MaybeUninit;
use std::ptr::{null, null_mut};

use crumple::entry_points::*;
use twox_hash::XxHash3_64;

use crate::seeds;

/// The header's length: magic, format and version.
const HEADER: usize = 16;
/// Before an event: its length and its checksum, 8 bytes each.
const HEAD: usize = 16;

/// The events of `data` with their checksums. An event that is longer than the rest ends there.
pub fn repaired(data: &[u8]) -> Vec<u8> {
    let mut file = data.to_vec();
    let mut at = HEADER;
    while at + HEAD <= file.len() {
        let length = u64::from_le_bytes(file[at..at + 8].try_into().expect("8 bytes"));
        let rest = file.len() - at - HEAD;
        let length = usize::try_from(length).map_or(rest, |length| length.min(rest));
        let (head, body) = file[at..at + HEAD + length].split_at_mut(HEAD);
        if let Some(set) = body.windows(8).position(|bytes| bytes == b"crumple\n") {
            crate::baked::repair(&mut body[set..]);
        }
        let length = length as u64;
        head[..8].copy_from_slice(&length.to_le_bytes());
        head[8..].copy_from_slice(&XxHash3_64::oneshot_with_seed(length, body).to_le_bytes());
        at += HEAD + body.len();
    }
    file
}

/// A recording of a small body to which most things happen.
pub fn of_many_calls() -> Vec<u8> {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("many.crumplerec");
    let text = CString::new(path.to_str().expect("a path in UTF-8")).expect("a path without a zero");
    let file = seeds::dented()[0].example_set().save().expect("a small set");
    let mut memory = vec![0.0f32; 3 * 200];
    // SAFETY: everything lives until the context is destroyed.
    unsafe {
        let (mut context, mut set) = (null_mut(), CrumpleExampleSet::default());
        crumple_context_create(&CrumpleContextDef { threads: 1, ..crumple_context_def_default() }, &mut context);
        crumple_recording_begin(context, text.as_ptr());
        let copy = MaybeUninit::new(CrumpleBytes::Copy);
        crumple_example_set_load_baked_memory(context, file.as_ptr().cast(), file.len(), copy, &mut set);
        let def = CrumpleInstanceDef { set, grow_time: 0.5, ..crumple_instance_def_default() };
        let mut bodies = [CrumpleInstance::default(); 2];
        for body in &mut bodies {
            crumple_instance_create(context, &def, body);
        }
        let [a, b] = bodies;
        let (mut def, mut buffer) = (crumple_host_buffer_def_default(), CrumpleBuffer::default());
        def.positions = CrumpleStream { data: memory.as_mut_ptr().cast(), size: 2400, offset: 0, stride: 12 };
        crumple_buffer_register_host(context, a, &def, &mut buffer);
        for (i, x) in [0.2, 0.5, 0.7].into_iter().enumerate() {
            let mut hit = crumple_displacement_def_default();
            (hit.point, hit.displacement) = ([x, 0.4, 0.0].into(), [0.0, 0.0, -0.03].into());
            hit.contact_id = i as u64;
            crumple_instance_submit_displacement(context, a, &hit, null_mut());
            let mut hit = crumple_impulse_def_default();
            (hit.point, hit.impulse, hit.duration, hit.mass) =
                ([x, 0.6, 0.0].into(), [0.0, 0.0, -2.0].into(), 0.01, 1.0);
            crumple_instance_preview_impulse(context, b, &hit, MaybeUninit::uninit().as_mut_ptr());
            crumple_instance_submit_impulse(context, b, &hit, null_mut());
            crumple_context_set_time(context, i as f64);
            crumple_context_deform(context, null(), 0, null_mut());
        }
        crumple_instance_end_contact(context, a, 1);
        crumple_instance_get_contact(context, a, 2, MaybeUninit::uninit().as_mut_ptr());
        crumple_instance_get_info(context, a, MaybeUninit::uninit().as_mut_ptr());
        let (mut bytes, mut size, mut count) = (vec![0u8; 4096], 0, 0);
        let (data, capacity) = (bytes.as_mut_ptr().cast(), bytes.len());
        crumple_instance_save_changes(context, a, 0, data, capacity, &mut size);
        crumple_context_save_damage(context, null(), 0, data, capacity, &mut size);
        crumple_context_load_damage(context, null(), 0, data, size);
        crumple_instance_save_damage(context, a, data, capacity, &mut size);
        crumple_instance_load_damage(context, b, data, size);
        let mut marks = [crumple::Mark::new(0, 0.0, [crumple::Pair::NONE; 4]); 8];
        crumple_instance_get_marks(context, a, marks.as_mut_ptr(), 8, &mut count);
        crumple_instance_set_marks(context, b, marks.as_ptr(), count);
        let (mut at, mut frame) = (MaybeUninit::uninit(), CrumpleFrame::default());
        crumple_example_set_attach_point(context, set, [0.3, 0.3, 0.1].into(), at.as_mut_ptr());
        crumple_instance_get_attached_frame(context, a, at.as_ptr(), &mut frame);
        crumple_instance_set_depth_limit(context, a, 0.01);
        crumple_instance_set_tolerance(context, a, 0.001);
        crumple_instance_measure_part(context, a, 0, &mut 0.0, &mut 0.0, &mut 0.0);
        let threshold = CrumpleThresholdDef { limit: 0.01, ..crumple_threshold_def_default() };
        crumple_instance_set_threshold(context, a, &threshold);
        crumple_context_get_passed(context, &mut CrumplePassed::default(), 1, &mut count);
        crumple_instance_repair_around(context, a, [0.5, 0.5, 0.0].into(), 0.3, 0.5);
        crumple_instance_repair_damage(context, a, 0.5);
        crumple_instance_copy_damage(context, b, a);
        crumple_context_set_vertex_budget(context, 10);
        crumple_buffer_set_memory(context, buffer, &def);
        crumple_buffer_invalidate(context, buffer);
        crumple_context_deform(context, &buffer, 1, null_mut());
        crumple_instance_reset_damage(context, a);
        crumple_buffer_unregister(context, buffer);
        crumple_instance_destroy(context, b);
        crumple_example_set_destroy(context, set);
        crumple_context_destroy(context);
    }
    std::fs::read(path).expect("the recording")
}
