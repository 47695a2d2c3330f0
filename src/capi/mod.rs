//! The C interface, and the only place that knows C. `cargo xtask header` generates the headers in `include` from these files;
//! its list (`xtask/src/header.rs`) says which file goes into which header.
//!
//! Every entry point runs inside [`boundary`]: pointers are checked, outputs are written on success, errors and panics become a
//! [`result::CrumpleResult`] and a text. C can store any number in an enum or a `bool`: such fields are `MaybeUninit`, which
//! cbindgen writes as the type itself, and are checked when read.
//!
//! Layers, each of which uses only those before it:
//! 1. `result`, `c_enum`, `boundary`, `check`, `types`, `memory`, `ids`, `tasks`: what every call needs;
//! 2. `vulkan_types`, `graph_types`, `device`, `store`, `jobs`: what a context holds;
//! 3. `context`: who may be inside when, and `prelude`: what nearly every entry point uses of all that;
//! 4. the entry points: `set`, `build`, `instance`, `hit` and so on.
//!
//! # Safety
//! One contract holds for every `unsafe fn` below that states none of its own. Each pointer that a C caller passes, as an argument
//! or in a def, is null or points to memory as the header describes it: as many readable or writable bytes as the count or size
//! beside it says, every pattern of which is a value, strings that end with a zero, Vulkan handles that are valid, callbacks that keep
//! their rules. It does not change during the call. Registered memory, devices and what they load stay as long as the header asks.
//! The bodies of these functions rely on nothing else.
#![allow(unsafe_op_in_unsafe_fn)]

mod allocator;
mod authoring;
mod boundary;
mod buffer;
mod build;
mod c_enum;
mod check;
mod contact_ids;
mod contacts;
mod context;
mod damage;
mod deform;
mod device;
mod graph;
mod graph_types;
mod hit;
mod ids;
mod instance;
mod jobs;
mod load;
mod memory;
mod parts;
mod prelude;
mod result;
mod set;
mod share;
mod store;
mod tasks;
#[cfg(test)]
mod tests;
mod types;
mod version;
mod view;
mod vulkan;
mod vulkan_types;

/// The entry points and what they take, for the fuzzer.
#[cfg(fuzzing)]
#[doc(hidden)]
pub mod entry_points {
    pub use super::{
        allocator::*, authoring::*, buffer::*, build::*, contact_ids::*, contacts::*, context::*, damage::*, deform::*,
        graph::*, graph_types::*, hit::*, instance::*, load::*, memory::*, parts::*, result::*, set::*, share::*,
        store::*, tasks::*, types::*, version::*, view::*, vulkan::*, vulkan_types::*,
    };
}
