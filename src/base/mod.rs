//! What everything stands on: errors, vector math, parallel-for, arrays. Knows nothing of meshes.

pub(crate) mod array;
pub(crate) mod array_vec;
pub(crate) mod error;
pub(crate) mod math;
pub(crate) mod strided;
pub(crate) mod tasks;
