//! The C interface, and the only place that knows C. `include/crumple.h` is generated from these files in the order
//! of the modules below, which is the order in which a user meets them.
//!
//! Every entry point runs inside [`boundary`]: pointers are checked, outputs are written only on success, errors and
//! panics become a [`result::CrumpleResult`] and a text. The types of the header hold no Rust enum or `bool` that C
//! could fill with a wrong number: such fields are `MaybeUninit`, which cbindgen writes as the type itself, and are
//! checked when read.

mod version;

mod result;

mod types;

mod allocator;

mod tasks;

mod context;

mod set;

mod load;

mod set_info;

mod instance;

mod hit;

mod damage;

mod buffer;

mod deform;

mod vulkan;

mod attach;

pub(crate) mod recording;

// Nothing below adds to the header.

mod boundary;

mod check;

mod ids;

mod memory;
