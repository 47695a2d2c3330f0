//! C#: the declarations that are written from the header, and the tests of what lies over them, under Mono.

mod parse;
mod write;

use anyhow::{Context, Result};

pub const TYPES: &str = "bindings/unity/Runtime/Native/NativeTypes.g.cs";
pub const FUNCTIONS: &str = "bindings/unity/Runtime/Native/NativeMethods.g.cs";

/// The texts of `TYPES` and `FUNCTIONS`.
pub fn declarations(header: &str) -> Result<(String, String)> {
    let items = parse::header(header).context("reading include/crumple.h")?;
    write::files(&items)
}
