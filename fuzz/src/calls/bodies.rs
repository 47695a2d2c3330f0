//! Calls on instances: hits, damage, parts, buffers and frames.

use std::mem::MaybeUninit;
use std::ptr::{null, null_mut};

use bytemuck::Zeroable;
use crumple::Mark;
use crumple::entry_points::*;

use super::arguments::{boolean, enumerator};
use super::{Host, Step, answered};

impl Host<'_> {
    /// # Safety
    /// None is needed; the calls in it are unsafe.
    pub(super) unsafe fn body_call(&mut self, call: u8) -> Step<CrumpleResult> {
        let (context, id) = (self.context()?, self.instance()?);
        Ok(match call {
            0..=3 => {
                let mut def = CrumpleInstanceDef { set: self.set()?, ..crumple_instance_def_default() };
                def.rule = enumerator(self.word()? & 3);
                let (mut def, mut new) = (self.patched(def)?, CrumpleInstance::default());
                def.mark_capacity = def.mark_capacity.min(70_000);
                let result = crumple_instance_create(context, &def, &mut new);
                self.instances.push(new);
                result
            }
            4 => crumple_instance_destroy(context, id),
            5 => {
                let mut info = MaybeUninit::<CrumpleInstanceInfo>::uninit();
                crumple_instance_get_info(context, id, info.as_mut_ptr())
            }
            6 => {
                let mut matrix = crumple_instance_def_default().local_to_world;
                let at = self.bytes.choose_index(16)?;
                matrix[at] = self.number()?;
                crumple_instance_set_transform(context, id, matrix.as_ptr())
            }
            7 => crumple_instance_set_depth_limit(context, id, self.number()?),
            8 => crumple_context_set_time(context, f64::from(self.number()?)),
            9 | 10 => {
                let (pixels, distance, fov, height) = (self.number()?, self.number()?, self.number()?, self.number()?);
                crumple_instance_set_view(context, id, pixels, distance, fov, height, null_mut())
            }
            11 => {
                let mut part = CrumpleInstance::default();
                let result = crumple_instance_release_part(context, id, self.word()?, &mut part);
                self.instances.push(part);
                result
            }
            12 => {
                let (part, mounted) = (self.instance()?, self.bytes.arbitrary::<u8>()?);
                crumple_instance_mount_part(context, id, part, boolean(mounted))
            }
            13 => {
                let (part, rigid) = (self.word()?, self.bytes.arbitrary::<u8>()?);
                crumple_instance_set_part_rigid(context, id, part, boolean(rigid))
            }
            14 => crumple_instance_measure_part(context, id, self.word()?, &mut 0.0, null_mut(), &mut 0.0),
            15..=18 => {
                let def = self.hit()?;
                crumple_instance_submit_hit(context, id, &def, null_mut())
            }
            19..=22 => {
                let def = self.hit()?;
                crumple_instance_submit_hit(context, id, &def, MaybeUninit::uninit().as_mut_ptr())
            }
            23 => {
                let (ids, def) = (self.some(Self::instance)?, self.hit()?);
                let defs = vec![def; ids.len()];
                crumple_context_submit_hits(context, ids.as_ptr(), defs.as_ptr(), ids.len() as u32, null_mut())
            }
            24 => {
                let (mut user_data, valid) = (0, crumple_instance_is_valid(context, id));
                let result = crumple_instance_set_user_data(context, id, 7);
                assert!(crumple_instance_get_user_data(context, id, &mut user_data) == result || !self.alone);
                assert!(valid == (result == CrumpleResult::CrumpleOk) || !self.alone);
                result
            }
            25 => {
                let (def, told) = (self.hit()?, &mut MaybeUninit::uninit());
                crumple_instance_preview_hit(context, id, &def, told.as_mut_ptr())
            }
            26..=27 => crumple_instance_end_contact(context, id, u64::from(self.word()?)),
            28 => {
                let contact = u64::from(self.word()?);
                crumple_instance_get_contact(context, id, contact, MaybeUninit::uninit().as_mut_ptr())
            }
            29 => {
                let mut marks = [Mark::zeroed(); 4];
                let (capacity, mut count) = (self.word()?.min(4), 0);
                crumple_instance_get_marks(context, id, marks.as_mut_ptr(), capacity, &mut count)
            }
            30 => {
                let mut marks = [Mark::zeroed(); 4];
                for mark in &mut marks {
                    mark.contact = self.word()?;
                    mark.depth = self.number()?;
                    mark.energy = Mark::ONE;
                    mark.told = self.bytes.int_in_range(0..=2)?;
                    mark.direction = self.bytes.arbitrary()?;
                }
                crumple_instance_set_marks(context, id, marks.as_ptr(), self.word()?.min(4))
            }
            31 => {
                self.save(|data, capacity, size| crumple_instance_save_damage(context, id, data, capacity, size));
                CrumpleResult::CrumpleOk
            }
            32..=34 => {
                let bytes = self.saved_bytes()?;
                crumple_instance_load_damage(context, id, bytes.as_ptr().cast(), bytes.len())
            }
            35 => {
                let ids = self.some(Self::instance)?;
                let (list, count) = (ids.as_ptr(), ids.len() as u32);
                self.save(|data, capacity, size| {
                    crumple_context_save_damage(context, list, count, data, capacity, size)
                });
                CrumpleResult::CrumpleOk
            }
            36 => {
                let (ids, bytes) = (self.some(Self::instance)?, self.saved_bytes()?);
                let data = bytes.as_ptr().cast();
                crumple_context_load_damage(context, ids.as_ptr(), ids.len() as u32, data, bytes.len())
            }
            37 => crumple_instance_repair_damage(context, id, self.number()?),
            38 => crumple_instance_repair_around(context, id, self.point()?, self.number()?, self.number()?),
            39 => crumple_instance_reset_damage(context, id),
            40 => crumple_instance_copy_damage(context, id, self.instance()?),
            41..=42 => {
                let (def, mut new) = (self.buffer_def()?, CrumpleBuffer::default());
                let result = crumple_buffer_register_host(context, id, &def, &mut new);
                self.buffers.push(new);
                result
            }
            43 => crumple_buffer_unregister(context, self.buffer()?),
            44 => {
                let buffer = self.buffer()?;
                if crumple_buffer_is_valid(context, buffer) {
                    crumple_buffer_get_info(context, buffer, MaybeUninit::uninit().as_mut_ptr());
                }
                crumple_buffer_invalidate(context, buffer)
            }
            45 => {
                let (buffer, def) = (self.buffer()?, self.buffer_def()?);
                crumple_buffer_set_memory(context, buffer, &def)
            }
            46 => crumple_context_set_vertex_budget(context, u64::from(self.word()?)),
            47..=48 => {
                let ids = if self.bytes.ratio(1, 2)? { Vec::new() } else { self.some(Self::buffer)? };
                let list = if ids.is_empty() { null() } else { ids.as_ptr() };
                crumple_context_deform(context, list, ids.len() as u32, MaybeUninit::uninit().as_mut_ptr())
            }
            49 => {
                let (mut infos, mut count) = ([MaybeUninit::<CrumpleBufferInfo>::uninit(); 4], 0);
                crumple_context_get_changed_buffers(context, infos.as_mut_ptr().cast(), self.word()?.min(4), &mut count)
            }
            50 => {
                let (buffer, mut ranges, mut count) = (self.buffer()?, [CrumpleRange::default(); 4], 0);
                let capacity = self.word()?.min(4);
                let mut bounds = MaybeUninit::uninit();
                crumple_buffer_get_changes(
                    context,
                    buffer,
                    ranges.as_mut_ptr(),
                    capacity,
                    &mut count,
                    bounds.as_mut_ptr(),
                )
            }
            51 => {
                let Some(at) = self.attachments.last().copied() else { return Ok(CrumpleResult::CrumpleOk) };
                let (at, mut frame) = (self.patched(at)?, CrumplePose::default());
                crumple_instance_get_attached_pose(context, id, &at, &mut frame)
            }
            52 => {
                let mut options = crumple_contact_options_def_default();
                (options.max_points, options.max_touches) = (16, 4);
                crumple_context_set_contact_options(context, &self.patched(options)?)
            }
            53 => {
                let points = [self.contact_point(id)?, self.contact_point(id)?];
                let count = self.word()?.min(2);
                answered(crumple_context_report_contacts(context, points.as_ptr(), count));
                let step = crumple_context_step_contacts(context, self.number()?, MaybeUninit::uninit().as_mut_ptr());
                let (mut hits, mut count) = ([const { MaybeUninit::<CrumpleContactHit>::uninit() }; 4], 0);
                let room = self.word()?.min(4);
                answered(crumple_context_get_contact_hits(context, hits.as_mut_ptr().cast(), room, &mut count));
                step
            }
            54 if self.bytes.arbitrary()? => crumple_context_clear_contacts(context),
            54 => crumple_context_get_contact_totals(context, MaybeUninit::uninit().as_mut_ptr()),
            _ => {
                let (buffer, mut ranges, mut count) = (self.buffer()?, [CrumpleRange::default(); 4], 0);
                let (ranges, capacity) = (ranges.as_mut_ptr(), self.word()?.min(4));
                crumple_buffer_get_changed_triangles(context, buffer, ranges, capacity, &mut count, null_mut())
            }
        })
    }
}
