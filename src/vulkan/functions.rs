//! The Vulkan functions, loaded through the host's own loader.
//!
//! ash fills a function that a loader lacks with a stub that aborts the process. Here a table is only used if the loader has all
//! of its functions, so no stub can be called. The tables hold core functions, which every device of Vulkan 1.1 has.

use crate::base::error::Error;
use ash::vk;
pub(super) use ash::{DeviceFnV1_0, InstanceFnV1_0, InstanceFnV1_1};
use std::ffi::{CStr, c_void};
use std::ptr::null;

/// Loads a table of ash's. `get` asks the loader for a function by name.
///
/// # Errors
/// [`Error::Unsupported`] naming the first function that the loader lacks.
pub(super) fn load<T>(
    table: impl FnOnce(&mut dyn FnMut(&CStr) -> *const c_void) -> T,
    get: impl Fn(&CStr) -> vk::PFN_vkVoidFunction,
) -> Result<T, Error> {
    let mut missing = None;
    let table = table(&mut |name| match get(name) {
        Some(function) => function as *const c_void,
        None => {
            missing.get_or_insert_with(|| name.to_string_lossy().into_owned());
            null()
        }
    });
    match missing {
        None => Ok(table),
        Some(name) => Err(Error::Unsupported {
            what: format!(
                "a Vulkan loader without {name}: Vulkan 1.1 has it, asked through its own instance and device"
            ),
        }),
    }
}

/// The result of a Vulkan call, as an error if it is one.
pub(super) fn checked(call: &str, result: vk::Result) -> Result<(), Error> {
    match result {
        vk::Result::SUCCESS => Ok(()),
        vk::Result::ERROR_DEVICE_LOST => Err(Error::DeviceLost { call: call.into() }),
        vk::Result::ERROR_OUT_OF_HOST_MEMORY | vk::Result::ERROR_OUT_OF_DEVICE_MEMORY => {
            Err(Error::OutOfMemory { what: call.into(), bytes: 0 })
        }
        other => Err(Error::Vulkan { call: call.into(), result: format!("{other:?}") }),
    }
}
