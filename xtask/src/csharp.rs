//! C#: generates the declarations from the header, and tests the C# layer above them under Mono.

mod layout;
mod write;

use std::fs;
use std::path::{Path, PathBuf};

use anyhow::{Context, Result, ensure};
use xshell::cmd;

use crate::declarations::{self, INCLUDE};
use crate::native;
use crate::stage::Outcome;
use crate::workspace::{Workspace, empty_directory};

pub const TYPES: &str = "bindings/unity/Runtime/Native/NativeTypes.g.cs";
pub const FUNCTIONS: &str = "bindings/unity/Runtime/Native/NativeMethods.g.cs";

/// The headers that C# has. The others are for hosts with a graphics device or an allocator of their own.
pub const HEADERS: &[&str] =
    &["crumple.h", "crumple_build.h", "crumple_import.h", "crumple_parts.h", "crumple_contacts.h", "crumple_view.h"];

const RUNTIME: &str = "bindings/unity/Runtime";
const TESTS: &str = "tests/csharp";
/// Makes Mono's compiler accept C# 7.2, like Unity's compiler, and fail on warnings.
const STRICT: &[&str] = &["-langversion:latest", "-unsafe", "-warnaserror", "-debug-"];

/// The texts of `TYPES` and `FUNCTIONS` for these headers.
pub fn declarations(header: &str) -> Result<(String, String)> {
    let items = declarations::header(header).context("reading the headers")?;
    write::files(&items)
}

pub fn run(workspace: &Workspace) -> Result<Outcome> {
    if cfg!(not(target_os = "linux")) {
        return Ok(Outcome::NotApplicable("done with Debian's Mono on Linux only".into()));
    }
    let prefix = native::release_prefix(workspace)?;
    let built = workspace.target.join("csharp");
    empty_directory(&built)?;
    compile(workspace, &built)?;
    let header = declarations::read_these(&workspace.path(INCLUDE), HEADERS)?;
    let table = layouts(workspace, &prefix, &built, &header)?;
    let (sh, libraries) = (&workspace.shell, prefix.join("lib"));
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
    Ok(Outcome::Passed)
}

/// Compiles the library with its documentation, and the test programs.
fn compile(workspace: &Workspace, built: &Path) -> Result<()> {
    let sh = &workspace.shell;
    let sources = |folder: &str| -> Result<Vec<PathBuf>> {
        let mut files: Vec<PathBuf> =
            fs::read_dir(workspace.path(folder))?.map(|entry| Ok(entry?.path())).collect::<Result<Vec<_>>>()?;
        files.retain(|file| file.extension().is_some_and(|extension| extension == "cs"));
        files.sort();
        ensure!(!files.is_empty(), "{folder} holds no C#");
        Ok(files)
    };
    let library = format!("-out:{}", built.join("Crumple.dll").display());
    let documentation = format!("-doc:{}", built.join("Crumple.xml").display());
    let (own, native) = (sources(RUNTIME)?, sources(&format!("{RUNTIME}/Native"))?);
    cmd!(sh, "mcs {STRICT...} -target:library {library} {documentation} {own...} {native...}").quiet().run()?;
    let tests = sources(TESTS)?;
    let named =
        |names: &[&str]| -> Vec<PathBuf> { names.iter().map(|name| workspace.path(TESTS).join(name)).collect() };
    let alone = named(&["Quickstart.cs", "LibraryTests.cs"]);
    let together = tests.iter().filter(|file| !alone.contains(file)).cloned().collect();
    for (program, files) in [
        ("quickstart", named(&["Quickstart.cs"])),
        ("tests", together),
        ("library", named(&["LibraryTests.cs", "Check.cs"])),
    ] {
        let program = format!("-out:{}", built.join(program).with_extension("exe").display());
        let library = format!("-r:{}", built.join("Crumple.dll").display());
        cmd!(sh, "mcs {STRICT...} -r:System.Core.dll {library} {program} {files...}").quiet().run()?;
    }
    Ok(())
}

/// Writes the sizes and offsets that the C compiler uses to a file, which the tests read.
fn layouts(workspace: &Workspace, prefix: &Path, built: &Path, header: &str) -> Result<PathBuf> {
    let sh = &workspace.shell;
    let (source, program, table) = (built.join("layout.c"), built.join("layout"), built.join("layout.txt"));
    fs::write(&source, layout::program(&declarations::header(header)?)?)?;
    let include = prefix.join("include");
    cmd!(sh, "cc -std=c11 -Wall -Werror -I {include} {source} -o {program}").quiet().run()?;
    fs::write(&table, cmd!(sh, "{program}").quiet().read()?)?;
    Ok(table)
}

/// Makes libraries that the C# layer must judge. Each case has a folder of its name.
fn misfits(workspace: &Workspace, built: &Path) -> Result<Vec<&'static str>> {
    let sh = &workspace.shell;
    let source = workspace.path(TESTS).join("fake.c");
    let (major, minor) = two(&workspace.version)?;
    let minor_and_patch = |minor: u32, patch: u32| Some((major * 1_000_000 + minor * 1000 + patch).to_string());
    let versions =
        [("version", minor_and_patch(minor + 1, 3)), ("patch", minor_and_patch(minor, 99)), ("foreign", None)];
    let mut cases = vec!["missing", "garbage"];
    for case in &cases {
        fs::create_dir(built.join(case))?;
    }
    fs::write(built.join("garbage/libcrumple.so"), "no library\n")?;
    for (case, version) in versions {
        fs::create_dir(built.join(case))?;
        let file = built.join(case).join("libcrumple.so");
        let version = version.map(|number| format!("-DVERSION={number}"));
        cmd!(sh, "cc -shared -fPIC {version...} {source} -o {file}").quiet().run()?;
        cases.push(case);
    }
    Ok(cases)
}

/// The major and the minor version.
fn two(version: &str) -> Result<(u32, u32)> {
    let mut parts = version.split('.').map(str::parse);
    let mut next = || Ok::<u32, anyhow::Error>(parts.next().context("a version has three parts")??);
    Ok((next()?, next()?))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Finds every function, struct and enum of the header by plain search and looks for it in the C# files.
    #[test]
    fn nothing_of_the_header_is_missing() -> Result<()> {
        let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("..");
        let header = declarations::read_these(&root.join(INCLUDE), HEADERS)?;
        let (types, functions) = declarations(&header)?;
        let code = || header.lines().filter(|line| line.starts_with(|first: char| first.is_ascii_alphabetic()));
        let declared: Vec<&str> = code()
            .filter_map(|line| line.split_once('(')?.0.rsplit([' ', '*']).next())
            .filter(|name| name.starts_with("crumple_"))
            .collect();
        assert!(declared.len() > 60, "{declared:?}");
        for name in &declared {
            assert!(functions.contains(&format!(" {name}(")), "{name}");
        }
        assert_eq!(functions.matches("[DllImport(").count(), declared.len());
        let closed: Vec<&str> = header.lines().filter_map(|line| line.strip_prefix("} ")?.strip_suffix(';')).collect();
        for name in &closed {
            assert!(types.contains(&format!("{name}\n")), "{name}");
        }
        // The features are one enum more: C has them as numbers.
        let written = types.matches("partial struct ").count() + types.matches("public enum ").count();
        assert_eq!(written, closed.len() + 1);
        Ok(())
    }
}
