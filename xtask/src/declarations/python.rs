//! The Python declarations of everything in the headers of `include`, for the standard library's `ctypes`.

use std::fmt::Write;

use anyhow::{Context, Result, bail};

use super::{Form, Item, Type, Variable, Variant, number, prefix};

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
    let writer = Writer { items };
    let mut text = HEAD.to_owned();
    for Item { name, form, .. } in items {
        if let Form::Define(value) = form {
            let value = value.replace("CRUMPLE_", "");
            writeln!(text, "{} = {value}", name.trim_start_matches("CRUMPLE_"))?;
        }
    }
    for item in items {
        match &item.form {
            Form::Enum(variants) => enumeration(&mut text, item, variants)?,
            Form::Struct(fields) => writer.structure(&mut text, &item.name, fields)?,
            Form::Callback(result, parameters) => {
                let list = writer.list(std::iter::once(result).chain(parameters.iter().map(|one| &one.kind)))?;
                writeln!(text, "\n\n{} = c.CFUNCTYPE({list})", item.name)?;
            }
            Form::Define(..) | Form::Opaque | Form::Function(..) => {}
        }
    }
    text.push_str("\n\nFUNCTIONS: dict[str, tuple[Any, list[Any]]] = {\n");
    for Item { name, form, .. } in items {
        let Form::Function(result, parameters) = form else { continue };
        let result = writer.kind(result).with_context(|| name.clone())?;
        let list = writer.list(parameters.iter().map(|one| &one.kind)).with_context(|| name.clone())?;
        writeln!(text, "    {name:?}: ({result}, [{list}]),")?;
    }
    text.push_str("}\n");
    Ok(text + TAIL)
}

/// An enum without the words that all its names begin with.
fn enumeration(text: &mut String, item: &Item, variants: &[Variant]) -> Result<()> {
    let prefix = prefix(&item.name, variants);
    writeln!(text, "\n\nclass {}(IntEnum):", item.name)?;
    writeln!(text, "    \"\"\"{}\"\"\"\n", item.docs.join("\n    "))?;
    for (name, value) in variants {
        writeln!(text, "    {} = {value}", &name[prefix.len()..])?;
    }
    Ok(())
}

struct Writer<'a> {
    items: &'a [Item],
}

impl Writer<'_> {
    fn structure(&self, text: &mut String, name: &str, fields: &[Variable]) -> Result<()> {
        writeln!(text, "\n\nclass {name}(c.Structure):\n    _fields_ = [")?;
        for Variable { name, kind } in fields {
            let one = self.kind(kind).with_context(|| name.clone())?;
            let one = kind.array.map_or(one.clone(), |length| format!("{one} * {length}"));
            writeln!(text, "        ({name:?}, {one}),")?;
        }
        text.push_str("    ]\n");
        Ok(())
    }

    fn list<'t>(&self, kinds: impl Iterator<Item = &'t Type>) -> Result<String> {
        Ok(kinds.map(|kind| self.kind(kind)).collect::<Result<Vec<_>>>()?.join(", "))
    }

    /// What a C type is for `ctypes`. A pointer to nothing that is declared is an address.
    fn kind(&self, kind: &Type) -> Result<String> {
        let form = self.items.iter().find(|item| item.name == kind.base).map(|item| &item.form);
        let (known, pointers) = match (kind.base.as_str(), kind.pointers) {
            ("void", 0) => ("None", 0),
            ("void", stars) => ("c.c_void_p", stars - 1),
            ("char", stars @ 1..) => ("c.c_char_p", stars - 1),
            ("bool", stars) => ("c.c_bool", stars),
            (name, stars) => match form {
                None => (number(name)?.1, stars),
                Some(Form::Enum(..)) => ("c.c_uint32", stars),
                Some(Form::Struct(..) | Form::Callback(..)) => (name, stars),
                Some(Form::Opaque) if stars > 0 => ("c.c_void_p", stars - 1),
                _ => bail!("{name:?} is a type that is not declared"),
            },
        };
        Ok((0..pointers).fold(known.to_owned(), |inner, _| format!("c.POINTER({inner})")))
    }
}
