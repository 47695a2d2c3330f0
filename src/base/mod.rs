//! Base utilities: errors, vector math, parallel-for and arrays. They do not depend on meshes.

pub(crate) mod array;
pub(crate) mod array_vec;
pub(crate) mod error;
pub(crate) mod lists;
pub(crate) mod math;
pub(crate) mod memory;
pub(crate) mod pairs;
pub(crate) mod simd;
pub(crate) mod strided;
pub(crate) mod sync;
pub(crate) mod tasks;
