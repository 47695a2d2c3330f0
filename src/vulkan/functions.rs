//! The Vulkan functions, loaded through the host's own loader, and their errors.
//!
//! ash fills a function that a loader lacks with a stub that aborts the process. Here a table is only used if the loader has all
//! of its functions, so no stub can be called. The tables hold core functions, which every device of Vulkan 1.1 has.

use crate::base::error::Error;
use ash::vk;
use ash::{DeviceFnV1_0, DeviceFnV1_1, DeviceFnV1_2, DeviceFnV1_3, InstanceFnV1_0, InstanceFnV1_1, InstanceFnV1_3};
use std::ffi::{CStr, c_void};
use std::ptr::null;

/// The functions of an instance of Vulkan 1.0 or, with `of_1_1`, of 1.1. Others must not be called. `get` asks the loader for a
/// function by name.
///
/// # Errors
/// [`Error::Unsupported`] naming the first function that the loader lacks.
pub(super) fn instance(
    instance: vk::Instance,
    get: impl Fn(&CStr) -> vk::PFN_vkVoidFunction,
    of_1_1: bool,
) -> Result<ash::Instance, Error> {
    let tables = load(get, |get| {
        let first = InstanceFnV1_0::load(&mut *get);
        (first, InstanceFnV1_1::load(|name| if of_1_1 { get(name) } else { null() }))
    })?;
    Ok(ash::Instance::from_parts_1_3(instance, tables.0, tables.1, InstanceFnV1_3::load(nothing)))
}

/// The functions of a device of Vulkan 1.0. Others must not be called.
///
/// # Errors
/// As [`instance`].
pub(super) fn device(device: vk::Device, get: impl Fn(&CStr) -> vk::PFN_vkVoidFunction) -> Result<ash::Device, Error> {
    let table = load(get, |get| DeviceFnV1_0::load(get))?;
    let (a, b, c) = (DeviceFnV1_1::load(nothing), DeviceFnV1_2::load(nothing), DeviceFnV1_3::load(nothing));
    Ok(ash::Device::from_parts_1_3(device, table, a, b, c))
}

fn nothing(_: &CStr) -> *const c_void {
    null()
}

fn load<T>(
    get: impl Fn(&CStr) -> vk::PFN_vkVoidFunction,
    table: impl FnOnce(&mut dyn FnMut(&CStr) -> *const c_void) -> T,
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

/// The error of a Vulkan call.
pub(super) fn failed(call: &str) -> impl Fn(vk::Result) -> Error {
    move |result| match result {
        vk::Result::ERROR_DEVICE_LOST => Error::DeviceLost { call: call.into() },
        vk::Result::ERROR_OUT_OF_HOST_MEMORY | vk::Result::ERROR_OUT_OF_DEVICE_MEMORY => {
            Error::OutOfMemory { what: call.into(), bytes: 0 }
        }
        other => Error::Vulkan { call: call.into(), result: format!("{other:?}") },
    }
}

/// The error of a Vulkan call that makes `what` of so many bytes.
pub(super) fn not_made(what: &str, call: &str, bytes: u64) -> impl Fn(vk::Result) -> Error {
    move |result| match failed(call)(result) {
        Error::OutOfMemory { .. } => Error::OutOfMemory { what: format!("{what} ({call})"), bytes },
        other => other,
    }
}
