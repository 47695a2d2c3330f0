//! The lists of jobs that a deform, a recording or a plan keeps between frames.

#[cfg(feature = "vulkan")]
use super::types::CrumpleBuffer;
#[cfg(feature = "vulkan")]
use crate::gpu::Job;

#[cfg(feature = "vulkan")]
pub(super) struct JobLists<T: 'static> {
    pub(super) chosen: Vec<CrumpleBuffer>,
    /// Empty between calls.
    pub(super) jobs: Vec<Job<'static, T>>,
}

#[cfg(feature = "vulkan")]
impl<T> Default for JobLists<T> {
    fn default() -> Self {
        JobLists { chosen: Vec::new(), jobs: Vec::new() }
    }
}

/// The same list, empty, for elements that differ in their lifetimes.
pub(super) fn recycled<A, B>(mut list: Vec<A>) -> Vec<B> {
    list.clear();
    // Collecting in place keeps the allocation.
    list.into_iter().map(|_| -> B { unreachable!("the list is empty") }).collect()
}
