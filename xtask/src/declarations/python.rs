//! The Python declarations of everything in the headers of `include`, for the standard library's `ctypes`.

use std::fmt::Write;

use anyhow::{Context, Result, bail};

use super::{Form, Item, Type, Variable, declared, number, prefix};

const HEAD: &str = "\
# Generated from the headers in include by `cargo xtask header`; do not edit it. They document what is declared here.
import ctypes as c
from enum import IntEnum
from typing import Any

";
const TAIL: &str = "

def declare(library: Any) -> None:
    \"\"\"Tells ctypes the results and parameters of every function of the library.\"\"\"
    for name, (result, parameters) in FUNCTIONS.items():
        function = getattr(library, name)
        function.restype = result
        function.argtypes = parameters
";

/// The module `crumple._native`.
pub fn module(items: &[Item]) -> Result<String> {
    let mut text = HEAD.to_owned();
    for Item { name, form, .. } in items {
        if let Form::Define(value) = form {
            writeln!(text, "{} = {}", name.trim_start_matches("CRUMPLE_"), value.replace("CRUMPLE_", ""))?;
        }
    }
    let mut functions = String::new();
    for Item { name, form, docs, .. } in items {
        match form {
            // Without the words that all its names begin with.
            Form::Enum(variants) => {
                let (docs, prefix) = (docs.join("\n    "), prefix(name, variants));
                writeln!(text, "\n\nclass {name}(IntEnum):\n    \"\"\"{docs}\"\"\"\n")?;
                variants
                    .iter()
                    .try_for_each(|(name, value)| writeln!(text, "    {} = {value}", &name[prefix.len()..]))?;
            }
            Form::Struct(fields) => {
                writeln!(text, "\n\nclass {name}(c.Structure):\n    _fields_ = [")?;
                for Variable { name, kind: field } in fields {
                    let (one, many) = (kind(items, field)?, field.array.map(|length| format!(" * {length}")));
                    writeln!(text, "        ({name:?}, {one}{}),", many.unwrap_or_default())?;
                }
                text += "    ]\n";
            }
            Form::Callback(result, parameters) => {
                let (result, list) = (kind(items, result)?, list(items, parameters)?);
                writeln!(
                    text,
                    "\n\n{name} = c.CFUNCTYPE({})",
                    [result].into_iter().chain(list).collect::<Vec<_>>().join(", ")
                )?;
            }
            Form::Function(result, parameters) => {
                let list = list(items, parameters).with_context(|| name.clone())?.join(", ");
                writeln!(functions, "    {name:?}: ({}, [{list}]),", kind(items, result)?)?;
            }
            Form::Define(..) | Form::Opaque => {}
        }
    }
    Ok(format!("{text}\n\nFUNCTIONS: dict[str, tuple[Any, list[Any]]] = {{\n{functions}}}\n{TAIL}"))
}

fn list(items: &[Item], parameters: &[Variable]) -> Result<Vec<String>> {
    parameters.iter().map(|one| kind(items, &one.kind)).collect()
}

/// What a C type is for `ctypes`. A pointer to nothing that is declared is an address.
fn kind(items: &[Item], kind: &Type) -> Result<String> {
    let (known, inner) = match (kind.base.as_str(), declared(items, &kind.base)) {
        ("void", _) if kind.pointers == 0 => ("None".into(), 0),
        ("void", _) => ("c.c_void_p".into(), 1),
        ("char", _) if kind.pointers > 0 => ("c.c_char_p".into(), 1),
        ("bool", _) => ("c.c_bool".into(), 0),
        (name, None) => (number(name)?.1, 0),
        (_, Some(Form::Enum(..))) => ("c.c_uint32".into(), 0),
        (name, Some(Form::Struct(..) | Form::Callback(..))) => (name.to_owned(), 0),
        (_, Some(Form::Opaque)) if kind.pointers > 0 => ("c.c_void_p".into(), 1),
        (name, _) => bail!("{name:?} is a type that is not declared"),
    };
    Ok((inner..kind.pointers).fold(known, |known, _| format!("c.POINTER({known})")))
}
