//! Damage: marks, their dents, and the blocks that they changed.

pub(crate) mod changes;
pub(crate) mod dent;
pub(crate) mod energy;
pub(crate) mod list;
pub(crate) mod mark;
pub(crate) mod saved;
pub(crate) mod told;
