//! Tests of the C# layer above the generated declarations, under Mono.

use std::fmt::Write;
use std::fs;
use std::path::{Path, PathBuf};

use anyhow::{Result, ensure};
use xshell::cmd;

use crate::declarations::csharp::{HEADERS, pascal};
use crate::declarations::{self, Form, INCLUDE, Item};
use crate::files::{empty_directory, files_of, write};
use crate::native;
use crate::workspace::Workspace;

const RUNTIME: &str = "bindings/unity/Runtime";
const TESTS: &str = "tests/csharp";
/// Makes Mono's compiler accept C# 7.2, like Unity's compiler, and fail on warnings.
const STRICT: &[&str] = &["-langversion:latest", "-unsafe", "-warnaserror", "-debug-"];

pub fn run(workspace: &Workspace) -> Result<()> {
    let (sh, prefix) = (&workspace.shell, native::release_prefix(workspace)?);
    let built = workspace.target.join("csharp");
    empty_directory(&built)?;
    compile(workspace, &built)?;
    let table = layouts(workspace, &prefix, &built)?;
    let libraries = prefix.join("lib");
    let mono = |program: &str, folder: &Path| {
        let program = built.join(program);
        // File names are UTF-8 in every locale.
        cmd!(sh, "mono {program}").env("LD_LIBRARY_PATH", folder).env("LC_ALL", "C.UTF-8").quiet()
    };
    mono("quickstart.exe", &libraries).run()?;
    mono("tests.exe", &libraries).arg(workspace.path("tests/fixtures")).arg(table).run()?;
    for case in misfits(workspace, &built)? {
        mono("library.exe", &built.join(case)).arg(case).run()?;
    }
    Ok(())
}

/// Compiles the library with its documentation, and the test programs.
fn compile(workspace: &Workspace, built: &Path) -> Result<()> {
    let sh = &workspace.shell;
    let sources = |folder: &str| -> Result<Vec<PathBuf>> {
        let files = files_of(&workspace.path(folder), &["cs"])?;
        ensure!(!files.is_empty(), "{folder} holds no C#");
        Ok(files)
    };
    let (dll, xml) = (built.join("Crumple.dll"), built.join("Crumple.xml"));
    let (library, documentation) = (format!("-out:{}", dll.display()), format!("-doc:{}", xml.display()));
    let mut own = sources(RUNTIME)?;
    // These need Unity.
    own.retain(|file| !file.starts_with(workspace.path(RUNTIME).join("Components")));
    cmd!(sh, "mcs {STRICT...} -target:library {library} {documentation} {own...}").quiet().run()?;
    let test = |name: &str| workspace.path(TESTS).join(name);
    let alone = [test("Quickstart.cs"), test("LibraryTests.cs")];
    let together = sources(TESTS)?.into_iter().filter(|file| !alone.contains(file)).collect();
    for (program, files) in [
        ("quickstart", vec![test("Quickstart.cs")]),
        ("tests", together),
        ("library", vec![test("LibraryTests.cs"), test("Check.cs")]),
    ] {
        let program = format!("-out:{}", built.join(program).with_extension("exe").display());
        let library = format!("-r:{}", dll.display());
        cmd!(sh, "mcs {STRICT...} -r:System.Core.dll {library} {program} {files...}").quiet().run()?;
    }
    Ok(())
}

/// Writes the sizes and offsets that the C compiler uses to a file, which the tests read.
fn layouts(workspace: &Workspace, prefix: &Path, built: &Path) -> Result<PathBuf> {
    let sh = &workspace.shell;
    let (source, program, table) = (built.join("layout.c"), built.join("layout"), built.join("layout.txt"));
    let headers = declarations::read_these(&workspace.path(INCLUDE), HEADERS)?;
    write(&source, layout_program(&declarations::header(&headers)?)?)?;
    let include = prefix.join("include");
    cmd!(sh, "cc -std=c11 -Wall -Werror -I {include} {source} -o {program}").quiet().run()?;
    write(&table, cmd!(sh, "{program}").quiet().read()?)?;
    Ok(table)
}

/// A C program that prints the size of every struct and the offset and size of every field, under the names of C#: `CrumpleMark 32`,
/// `CrumpleMark.Depth 4 4`, `CrumpleMark.Pairs1 20 4`.
fn layout_program(items: &[Item]) -> Result<String> {
    let declared = |name: &str| items.iter().any(|item| item.name == name);
    let mut text: String = HEADERS.iter().map(|name| format!("#include <{name}>\n")).collect();
    text.push_str("#include <stdio.h>\n\nint main(void) {\n");
    for Item { name, form, .. } in items {
        let Form::Struct(fields) = form else { continue };
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
    Ok(text + "    return 0;\n}\n")
}

/// Makes libraries that the C# layer must judge. Each case has a folder of its name.
fn misfits(workspace: &Workspace, built: &Path) -> Result<Vec<&'static str>> {
    let sh = &workspace.shell;
    let source = workspace.path(TESTS).join("fake.c");
    let parts: Vec<u32> = workspace.version.split('.').map(str::parse).collect::<Result<_, _>>()?;
    let version = |minor: u32, patch: u32| Some(format!("-DVERSION={}", parts[0] * 1_000_000 + minor * 1000 + patch));
    let fakes = [("version", version(parts[1] + 1, 3)), ("patch", version(parts[1], 99)), ("foreign", None)];
    let mut cases = vec!["missing", "garbage"];
    cases.extend(fakes.iter().map(|(case, _)| case));
    for case in &cases {
        fs::create_dir(built.join(case))?;
    }
    write(&built.join("garbage/libcrumple.so"), "no library\n")?;
    for (case, version) in fakes {
        let file = built.join(case).join("libcrumple.so");
        cmd!(sh, "cc -shared -fPIC {version...} {source} -o {file}").quiet().run()?;
    }
    Ok(cases)
}
