//! Tests of the C# layer above the generated declarations, under Mono.

use std::fmt::Write;
use std::fs;
use std::path::{Path, PathBuf};

use anyhow::Result;
use heck::ToUpperCamelCase;

use crate::declarations::csharp::HEADERS;
use crate::declarations::{self, Form, INCLUDE, Item};
use crate::files::{empty, files_of, write};
use crate::install;
use crate::workspace::{VERSION, cmd, in_root, in_target, run, said};

const RUNTIME: &str = "bindings/unity/Runtime";
const TESTS: &str = "tests/csharp";
/// Makes Mono's compiler accept C# 7.2, like Unity's compiler, and fail on warnings.
const STRICT: &[&str] = &["-langversion:latest", "-unsafe", "-warnaserror", "-debug-"];

pub fn stage() -> Result<()> {
    let (prefix, built) = (install::release_prefix()?, in_target("csharp"));
    empty(&built)?;
    compile(&built)?;
    let (table, libraries) = (layouts(&prefix, &built)?, prefix.join("lib"));
    let mono = |program: &str, folder: &Path| {
        let program = built.join(program);
        // File names are UTF-8 in every locale.
        cmd!("mono {program}").env("LD_LIBRARY_PATH", folder).env("LC_ALL", "C.UTF-8").quiet()
    };
    mono("quickstart.exe", &libraries).run()?;
    mono("tests.exe", &libraries).arg(in_root("tests/fixtures")).arg(table).run()?;
    for case in misfits(&built)? {
        mono("library.exe", &built.join(case)).arg(case).run()?;
    }
    Ok(())
}

fn compile(built: &Path) -> Result<()> {
    let (dll, xml) = (built.join("Crumple.dll"), built.join("Crumple.xml"));
    let mut own = files_of(RUNTIME, &["cs"])?;
    // These need Unity.
    own.retain(|file| !file.starts_with(Path::new(RUNTIME).join("Components")));
    run!("mcs {STRICT...} -target:library -out:{dll} -doc:{xml} {own...}")?;
    let (start, check, library) = ("Quickstart.cs", "Check.cs", "LibraryTests.cs");
    let test = |name| Path::new(TESTS).join(name);
    let mut together = files_of(TESTS, &["cs"])?;
    together.retain(|file| *file != test(start) && *file != test(library));
    for (program, files) in
        [("quickstart", vec![test(start)]), ("tests", together), ("library", vec![test(library), test(check)])]
    {
        let program = built.join(program).with_extension("exe");
        run!("mcs {STRICT...} -r:System.Core.dll -r:{dll} -out:{program} {files...}")?;
    }
    Ok(())
}

/// Writes the sizes and offsets that the C compiler uses to a file, which the tests read.
fn layouts(prefix: &Path, built: &Path) -> Result<PathBuf> {
    let (source, program, table) = (built.join("layout.c"), built.join("layout"), built.join("layout.txt"));
    let headers = declarations::read(INCLUDE, HEADERS)?;
    write(&source, layout_program(&declarations::header(&headers)?)?)?;
    let include = prefix.join("include");
    run!("cc -std=c11 -Wall -Werror -I {include} {source} -o {program}")?;
    write(&table, said!("{program}")?)?;
    Ok(table)
}

/// A C program that prints the size of every struct and the offset and size of every field, under the names of C#: `CrumpleMark 32`,
/// `CrumpleMark.Depth 4 4`, `CrumpleMark.Pairs1 20 4`.
fn layout_program(items: &[Item]) -> Result<String> {
    let mut text: String = HEADERS.iter().map(|name| format!("#include <{name}>\n")).collect();
    text += "#include <stdio.h>\n\nint main(void) {\n";
    for Item { name, form, .. } in items {
        let Form::Struct(fields) = form else { continue };
        writeln!(text, "    printf(\"{name} %zu\\n\", sizeof({name}));")?;
        for field in fields {
            // C# has no arrays of structs or enums in structs, so each element is a field.
            let apart = field.kind.array.filter(|_| declarations::declared(items, &field.kind.base).is_some());
            let element = |at| (format!("{}[{at}]", field.name), format!("{}{at}", field.name.to_upper_camel_case()));
            let elements = apart.map(|length| (0..length).map(element).collect());
            for (own, there) in elements.unwrap_or_else(|| vec![(field.name.clone(), field.name.to_upper_camel_case())])
            {
                let place = format!("offsetof({name}, {own}), sizeof((({name} *)0)->{own})");
                writeln!(text, "    printf(\"{name}.{there} %zu %zu\\n\", {place});")?;
            }
        }
    }
    Ok(text + "    return 0;\n}\n")
}

/// Makes libraries that the C# layer must judge. Each case has a folder of its name.
fn misfits(built: &Path) -> Result<[&'static str; 5]> {
    let source = format!("{TESTS}/fake.c");
    let parts: Vec<u32> = VERSION.split('.').map(str::parse).collect::<Result<_, _>>()?;
    let version = |minor: u32, patch: u32| Some(format!("-DVERSION={}", parts[0] * 1_000_000 + minor * 1000 + patch));
    let fakes = [("version", version(parts[1] + 1, 3)), ("patch", version(parts[1], 99)), ("foreign", None)];
    let cases = ["missing", "garbage", "version", "patch", "foreign"];
    cases.iter().try_for_each(|case| fs::create_dir(built.join(case)))?;
    write(built.join("garbage/libcrumple.so"), "no library\n")?;
    for (case, version) in fakes {
        let file = built.join(case).join("libcrumple.so");
        run!("cc -shared -fPIC {version...} {source} -o {file}")?;
    }
    Ok(cases)
}
