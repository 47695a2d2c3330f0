//! Selection: a hit becomes a mark.
//!
//! The default takes the K examples that say most of a hit of this place, depth and lean, in shares that extrapolate between
//! them ([`kriging`]), and scales them together so that the contact gets the target displacement.
//!
//! Everything here is IEEE f32/f64 arithmetic with `sqrt` and `libm`, so the same hit makes the same mark everywhere.

pub(crate) mod hit;
pub(crate) mod kriging;
pub(crate) mod nearest;
pub(crate) mod placement;
pub(crate) mod query;
pub(crate) mod shortlist;
pub(crate) mod target;
