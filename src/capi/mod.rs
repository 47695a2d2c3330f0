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
#![cfg_attr(not(feature = "vulkan"), allow(irrefutable_let_patterns))]

// crumple.h
mod buffer;
mod contacts;
mod context;
mod damage;
mod deform;
mod hit;
mod instance;
mod result;
mod set;
mod tasks;
mod types;
mod version;

// crumple_build.h
mod authoring;
mod build;
mod memory;

// crumple_import.h
mod load;

// crumple_parts.h
mod parts;

// crumple_contacts.h
mod contact_ids;

// crumple_view.h
mod view;

// crumple_host.h
mod allocator;
mod share;

// crumple_vulkan.h
mod vulkan;
mod vulkan_types;

// crumple_graph.h
mod graph;
mod graph_types;

// No header.
mod boundary;
mod c_enum;
mod check;
#[cfg(feature = "vulkan")]
mod device;
mod ids;
mod jobs;
mod prelude;
mod store;

#[cfg(test)]
mod tests;

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
