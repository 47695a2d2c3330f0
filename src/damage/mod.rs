//! What is kept of hits: marks, the dents that they stand for, and which blocks they changed.

pub(crate) mod changes;
pub(crate) mod dent;
pub(crate) mod list;
pub(crate) mod mark;
pub(crate) mod saved;
