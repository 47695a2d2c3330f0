//! Files into plain arrays.
