//! What a hit asks of a body: which vertex is displaced, in which direction and how far.
//!
//! Uses only IEEE f32 and f64 arithmetic, `sqrt` and `libm`, so the same hit makes the same mark on every
//! platform.

pub(crate) mod hit;
pub(crate) mod options;
pub(crate) mod target;
