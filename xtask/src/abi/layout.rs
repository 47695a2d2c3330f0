//! What a compiler makes of a header: a program is written that prints every size and offset, compiled, and run.

use std::fs;
use std::path::Path;

use anyhow::{Context, Result};
use xshell::cmd;

use super::declarations::{self, Declaration};
use super::table::Table;
use crate::workspace::Workspace;

/// By `compiler`, `cc` or `c++`.
pub fn of(workspace: &Workspace, header: &Path, compiler: &str) -> Result<Table> {
    let declared = declarations::of(header)?;
    let scratch = tempfile::tempdir()?;
    let source = scratch.path().join(if compiler == "cc" { "layout.c" } else { "layout.cpp" });
    let program = scratch.path().join("layout");
    fs::write(&source, program_text(header, &declared))?;
    let sh = &workspace.shell;
    cmd!(sh, "{compiler} {source} -o {program}")
        .quiet()
        .run()
        .with_context(|| format!("compiling {}", header.display()))?;
    Ok(Table::from_text(&cmd!(sh, "{program}").quiet().read()?))
}

/// A shared library with the header's functions, which do nothing, and debug information about their types.
pub fn stand_in(workspace: &Workspace, header: &Path, library: &Path) -> Result<()> {
    let mut text = format!("#include \"{}\"\n", header.display());
    for declaration in declarations::of(header)? {
        if let Declaration::Function { text: function, .. } = declaration {
            text += &format!("{function} {{ for (;;) {{}} }}\n");
        }
    }
    let source = library.with_extension("c");
    fs::write(&source, text)?;
    Ok(cmd!(workspace.shell, "cc -g -fPIC -shared {source} -o {library}").quiet().run()?)
}

fn program_text(header: &Path, declared: &[Declaration]) -> String {
    let mut prints = String::new();
    let mut print = |line: String, values: &[String]| {
        let values: String = values.iter().map(|value| format!(", (long)({value})")).collect();
        prints += &format!("    printf(\"{line}\\n\"{values});\n");
    };
    for declaration in declared {
        match declaration {
            Declaration::Constant { name } => print(format!("constant {name} = %ld"), &[name.clone()]),
            Declaration::Enum { name, enumerators } => {
                print(format!("enum {name} size %ld"), &[format!("sizeof({name})")]);
                for enumerator in enumerators {
                    print(format!("enum {name} value {enumerator} = %ld"), &[enumerator.clone()]);
                }
            }
            Declaration::Struct { name, fields } => {
                let values = [format!("sizeof({name})"), format!("ALIGN({name})")];
                print(format!("struct {name} size %ld align %ld"), &values);
                for field in fields {
                    let (field, kind) = (&field.name, &field.kind);
                    let values = [format!("offsetof({name}, {field})"), format!("sizeof((({name} *)0)->{field})")];
                    print(format!("struct {name} field {field} offset %ld size %ld {kind}"), &values);
                }
            }
            Declaration::Opaque { name } => print(format!("opaque {name}"), &[]),
            Declaration::Callback { name, signature } => print(format!("callback {name} {signature}"), &[]),
            Declaration::Function { name, signature, .. } => print(format!("function {name} {signature}"), &[]),
        }
    }
    let aligned = "#ifdef __cplusplus\n#define ALIGN(T) alignof(T)\n#else\n#define ALIGN(T) _Alignof(T)\n#endif\n";
    let header = header.display().to_string().replace('\\', "/");
    format!(
        "#include \"{header}\"\n#include <stddef.h>\n#include <stdio.h>\n{aligned}int main(void) {{\n{prints}    return 0;\n}}\n"
    )
}
