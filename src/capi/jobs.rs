//! The buffers that a deform, a recording or a plan writes, as jobs for what writes them.

use super::check::array;
use super::result::Failure;
use super::store::{BufferEntry, Buffers, Instances, JobList, Memory};
use super::types::CrumpleBuffer;
use crate::base::memory::may_fail;
use crate::base::tasks::TaskSystem;
use crate::gpu::Job;
use crate::instance::Instance;
use crate::instance::deform::{DeformJob, fold_all};

/// A job that writes a kind of buffer.
pub(super) trait BufferJob {
    type Of<'a>;
    /// Whether it writes such memory.
    fn writes(memory: &Memory) -> bool;
    /// A job for memory of this kind.
    fn new<'a>(instance: &'a Instance, entry: &'a mut BufferEntry) -> Result<Option<Self::Of<'a>>, Failure>;
}

impl BufferJob for DeformJob<'static, 'static> {
    type Of<'a> = DeformJob<'a, 'static>;

    fn writes(memory: &Memory) -> bool {
        matches!(memory, Memory::Host(..))
    }

    fn new<'a>(instance: &'a Instance, entry: &'a mut BufferEntry) -> Result<Option<Self::Of<'a>>, Failure> {
        let Memory::Host(memory, tracker) = &mut entry.memory else { return Ok(None) };
        // SAFETY: the header asks that the memory is there until the buffer is unregistered, and left alone during the call.
        let memory = unsafe { memory.vertices()? };
        Ok(Some(DeformJob { lod: entry.lod, instance, tracker, memory }))
    }
}

impl BufferJob for Job<'static, crate::vulkan::Target> {
    type Of<'a> = Job<'a, crate::vulkan::Target>;

    fn writes(memory: &Memory) -> bool {
        matches!(memory, Memory::Vulkan(_))
    }

    fn new<'a>(instance: &'a Instance, entry: &'a mut BufferEntry) -> Result<Option<Self::Of<'a>>, Failure> {
        let Memory::Vulkan(target) = &mut entry.memory else { return Ok(None) };
        Ok(Some(Job { instance, target }))
    }
}

impl BufferJob for Job<'static, crate::graph::Target> {
    type Of<'a> = Job<'a, crate::graph::Target>;

    fn writes(memory: &Memory) -> bool {
        matches!(memory, Memory::Graph(_))
    }

    fn new<'a>(instance: &'a Instance, entry: &'a mut BufferEntry) -> Result<Option<Self::Of<'a>>, Failure> {
        let Memory::Graph(target) = &mut entry.memory else { return Ok(None) };
        Ok(Some(Job { instance, target }))
    }
}

/// Calls `f` with a job for each buffer that a call names, those of an array or, where it is null, all of a kind.
/// Hits that wait become damage first: of all instances where all buffers are named, so that the damage of a body does not depend on
/// whether it has a buffer; else of the instances that own these buffers.
pub(super) unsafe fn with_jobs<J: BufferJob, R>(
    tasks: &dyn TaskSystem,
    (instances, entries): (&mut Instances, &mut Buffers),
    list: &mut JobList<J>,
    (buffers, count): (*const CrumpleBuffer, u32),
    f: impl FnOnce(&mut [J::Of<'_>]) -> Result<R, Failure>,
) -> Result<R, Failure> {
    let (all, given) = (buffers.is_null(), array(buffers, count as usize, "buffers")?);
    let chosen = &mut list.chosen;
    chosen.clear();
    may_fail(|| chosen.try_reserve(given.len())).map_err(|_| Failure::out_of_memory("the list of buffers"))?;
    for (i, &id) in given.iter().enumerate() {
        let name = format!("buffers[{i}]");
        let memory = &entries.get(id, &name)?.memory;
        if !J::writes(memory) {
            return Err(memory.written_elsewhere(&name));
        }
        chosen.push(id);
    }
    chosen.sort_unstable_by_key(|id| id.index);
    if let Some([twice, _]) = chosen.array_windows().find(|[a, b]| a == b) {
        return Err(Failure::invalid(format!("buffers names buffer {} twice; name each once", twice.index)));
    }
    let named = |id: CrumpleBuffer| all || chosen.binary_search_by_key(&id.index, |c| c.index).is_ok();
    let of_kind = |(id, entry): &(CrumpleBuffer, &BufferEntry)| J::writes(&entry.memory) && named(*id);
    if cfg!(debug_assertions) {
        apart(entries.iter().filter(of_kind))?;
    }
    if all {
        fold_all(instances.iter_mut().map(|(_, entry)| &mut entry.instance), tasks);
    } else {
        for (_, entry) in entries.iter().filter(of_kind) {
            instances.get_mut(entry.owner, "instance")?.instance.fold();
        }
    }
    let mut jobs = recycled(std::mem::take(&mut list.jobs));
    let most = if all { entries.len() } else { given.len() };
    may_fail(|| jobs.try_reserve(most)).map_err(|_| Failure::out_of_memory("the list of jobs"))?;
    for (_, entry) in entries.iter_mut().filter(|(id, _)| named(*id)) {
        jobs.extend(J::new(&instances.get(entry.owner, "instance")?.instance, entry)?);
    }
    let result = f(&mut jobs);
    list.jobs = recycled(jobs);
    if result.is_ok() {
        for (id, entry) in entries.iter_mut().filter(|(_, entry)| J::writes(&entry.memory)) {
            entry.included = named(id);
        }
    }
    result
}

/// Refuses host buffers that share memory.
fn apart<'a>(entries: impl Iterator<Item = (CrumpleBuffer, &'a BufferEntry)>) -> Result<(), Failure> {
    let mut layouts = Vec::new();
    for (id, entry) in entries {
        if let Memory::Host(memory, _) = &entry.memory {
            layouts.extend(memory.streams().map(|stream| (stream.layout, id.index)));
        }
    }
    layouts.sort_unstable_by_key(|(layout, _)| layout.first);
    for (i, (a, x)) in layouts.iter().enumerate() {
        for (b, y) in layouts[i + 1..].iter().take_while(|(b, _)| b.first < a.span().end) {
            if x != y && a.overlaps(b) {
                return Err(Failure::invalid(format!(
                    "the memory of buffers {x} and {y} overlaps; each needs its own"
                )));
            }
        }
    }
    Ok(())
}

/// The same list, empty, for elements that differ in their lifetimes.
fn recycled<A, B>(mut list: Vec<A>) -> Vec<B> {
    list.clear();
    // Collecting in place keeps the allocation.
    list.into_iter().map(|_| -> B { unreachable!("the list is empty") }).collect()
}
