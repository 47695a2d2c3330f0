//! The C interface, and the only place that knows C. `cargo xtask header` generates the headers in `include` from these files;
//! its list (`xtask/src/header.rs`) says which file goes into which header.
//!
//! Every entry point runs inside [`boundary`]: pointers are checked, outputs are written on success, errors and panics become a
//! [`result::CrumpleResult`] and a text. C can store any number in an enum or a `bool`: such fields are `MaybeUninit`, which
//! cbindgen writes as the type itself, and are checked when read.
//!
//! Layers, each of which uses only those before it:
//! 1. `result`, `c_enum`, `boundary`, `check`, `types`, `memory`, `ids`, `tasks`: what every call needs;
//! 2. `primitive`, `host_memory`, `vulkan_types`, `job_lists`, `graph_types`, `device`, `store`: what a context holds;
//! 3. `context`: who may be inside when;
//! 4. `jobs`, and the entry points: `set`, `build`, `instance`, `hit` and so on.
//!
//! # Safety
//! One contract holds for every `unsafe fn` below that states none of its own. Each pointer that a C caller passes, as an argument
//! or in a def, is null or points to memory as the header describes it: as many readable or writable bytes as the count or size
//! beside it says, strings that end with a zero, Vulkan handles that are valid, callbacks that keep their rules. Registered
//! memory stays there as long as the header asks. The bodies of these functions rely on nothing else.
#![allow(unsafe_op_in_unsafe_fn)]
#![cfg_attr(not(feature = "vulkan"), allow(irrefutable_let_patterns))]

// crumple.h
mod buffer;
mod contacts;
mod context;
mod damage;
mod deform;
mod hit;
mod host_memory;
mod instance;
mod result;
mod set;
mod set_info;
mod tasks;
mod types;
mod version;

// crumple_build.h
mod build;
mod example_info;
mod keep_out;
mod map_damage;
mod memory;

// crumple_import.h
mod load;
mod primitive;

// crumple_parts.h
mod attach;
mod colliders;
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
mod job_lists;
#[cfg(feature = "vulkan")]
mod jobs;
mod store;

#[cfg(test)]
mod thread_tests;

/// The entry points and what they take, for the fuzzer.
#[cfg(fuzzing)]
#[doc(hidden)]
pub mod entry_points {
    pub use super::{
        allocator::*, attach::*, buffer::*, build::*, colliders::*, contact_ids::*, contacts::*, context::*, damage::*,
        deform::*, example_info::*, graph::*, graph_types::*, hit::*, host_memory::*, instance::*, keep_out::*,
        load::*, map_damage::*, memory::*, parts::*, primitive::*, result::*, set::*, set_info::*, share::*, tasks::*,
        types::*, version::*, view::*, vulkan::*, vulkan_types::*,
    };
}
