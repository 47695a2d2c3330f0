//! What nearly every entry point uses.

pub(super) use super::boundary::granted;
pub(super) use super::c_enum::c_enums;
pub(super) use super::check::{
    Out, array, boolean, def, defs, enumerator, finite, positive_or, required_string, string, write_array, zeroed,
};
pub(super) use super::context::{Context, CrumpleContext, CrumpleLogLevel, concurrent, exclusive};
pub(super) use super::result::{CrumpleResult, Failure};
pub(super) use super::store::State;
pub(super) use super::types::{CrumpleBuffer, CrumpleExampleSet, CrumpleInstance, CrumpleVec3};
pub(super) use std::ffi::{c_char, c_void};
pub(super) use std::mem::MaybeUninit;
