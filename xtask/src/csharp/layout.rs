//! Writes a C program that prints the size of every struct and the offset and size of every field, under the names of C#. The C# tests
//! compare them.

use std::fmt::Write;

use anyhow::Result;

use super::write::pascal;
use crate::declarations::{Form, HEADERS, Item};

/// Its lines: `CrumpleMark 32`, `CrumpleMark.Depth 4 4`, `CrumpleMark.Pairs1 20 4`.
pub fn program(items: &[Item]) -> Result<String> {
    let declared = |name: &str| items.iter().any(|item| item.name == name);
    let mut text: String = HEADERS.iter().map(|name| format!("#include <{name}>\n")).collect();
    text.push_str("#include <stdio.h>\n\nint main(void) {\n");
    for Item { name, form, .. } in items {
        let Form::Struct { fields } = form else { continue };
        writeln!(text, "    printf(\"{name} %zu\\n\", sizeof({name}));")?;
        for field in fields {
            let (own, there) = (&field.name, pascal(&field.name));
            let size = format!("sizeof((({name} *)0)->{own}");
            match field.kind.array {
                // C# has no arrays of structs or enums in structs, so each element is a field.
                Some(length) if declared(&field.kind.base) => {
                    for index in 0..length {
                        let offset = format!("offsetof({name}, {own}) + {index} * {size}[0])");
                        writeln!(text, "    printf(\"{name}.{there}{index} %zu %zu\\n\", {offset}, {size}[0]));")?;
                    }
                }
                _ => writeln!(text, "    printf(\"{name}.{there} %zu %zu\\n\", offsetof({name}, {own}), {size}));")?,
            }
        }
    }
    text.push_str("    return 0;\n}\n");
    Ok(text)
}
