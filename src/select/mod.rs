//! Selection: turns a hit into a mark.
//!
//! The default chooses the K examples that best predict a dent of the hit's place, depth and lean. [`kriging`] gives
//! their shares. They are scaled together so that the contact gets the target displacement.
//!
//! Selection uses only IEEE f32 and f64 arithmetic, `sqrt` and `libm`, so the same hit makes the same mark on every
//! platform.

pub(crate) mod hit;
pub(crate) mod kriging;
pub(crate) mod landing;
pub(crate) mod nearest;
pub(crate) mod placement;
pub(crate) mod query;
pub(crate) mod shortlist;
pub(crate) mod target;
