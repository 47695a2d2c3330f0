//! Builds an example set from a base mesh and examples. This happens once, at load time or offline.

pub(crate) mod basis;
pub(crate) mod build;
pub(crate) mod lod;
pub(crate) mod reorder;
