//! From base mesh and examples to an example set, once, while loading.

pub(crate) mod build;
pub(crate) mod learn;
pub(crate) mod lod;
pub(crate) mod reorder;
