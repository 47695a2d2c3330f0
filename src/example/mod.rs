//! Examples and the set that holds them, as plain data. Later modules add the behaviour.

pub(crate) mod blocks;
pub(crate) mod blow;
pub(crate) mod data;
#[expect(clippy::module_inception, reason = "one file an idea")]
pub(crate) mod example;
pub(crate) mod mesh_lod;
pub(crate) mod options;
pub(crate) mod report;
pub(crate) mod rule;
pub(crate) mod set;
