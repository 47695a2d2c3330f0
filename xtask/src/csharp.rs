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
use crate::tools::Tool;
use crate::vulkan;
use crate::workspace::{Workspace, empty_directory};

pub const TYPES: &str = "bindings/unity/Runtime/Native/NativeTypes.g.cs";
pub const FUNCTIONS: &str = "bindings/unity/Runtime/Native/NativeMethods.g.cs";

const RUNTIME: &str = "bindings/unity/Runtime";
const TESTS: &str = "tests/csharp";
/// Makes Mono's compiler accept C# 7.2, like Unity's compiler, and fail on warnings.
const STRICT: &[&str] = &["-langversion:latest", "-unsafe", "-warnaserror", "-debug-"];
/// The offset of `e_machine` in an ELF file, and its value for ARM64.
const MACHINE: (usize, [u8; 2]) = (18, [183, 0]);

/// The texts of `TYPES` and `FUNCTIONS`.
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
    let header = declarations::read(&workspace.path(INCLUDE))?;
    let table = layouts(workspace, &prefix, &built, &header)?;
    let (sh, libraries) = (&workspace.shell, prefix.join("lib"));
    let mono = |program: &str, folder: &Path| {
        let program = built.join(program);
        // File names are UTF-8 in every locale.
        cmd!(sh, "mono {program}").env("LD_LIBRARY_PATH", folder).env("LC_ALL", "C.UTF-8").quiet()
    };
    mono("quickstart.exe", &libraries).run()?;
    mono("tests.exe", &libraries).arg(workspace.path("tests/fixtures")).arg(table).run()?;
    for (case, file) in misfits(workspace, &prefix, &built)? {
        let folder = if case == "missing" { built.join("empty") } else { built.join(case) };
        mono("library.exe", &folder).arg(case).arg(file).run()?;
    }
    let beside = built.join("libcrumple.so");
    fs::copy(libraries.join("libcrumple.so"), &beside)?;
    mono("library.exe", &built.join("empty")).arg("beside").arg(beside).run()?;
    if Tool::Vulkan.here(workspace) && Tool::VulkanHeaders.here(workspace) {
        vulkan_host(workspace, &built)?;
        // One driver is enough: drivers differ below the C# layer.
        let driver = vulkan::lavapipe()?;
        let frames = || mono("vulkan.exe", &libraries).env("VK_DRIVER_FILES", &driver).env("CRUMPLE_REQUIRE_GPU", "1");
        // Mesa's device selection layer prints errors in a session without a display.
        frames().env("NODEVICE_SELECT", "1").env("CRUMPLE_VALIDATION", "1").run()?;
        frames().env("NODEVICE_SELECT", "1").arg("device-goes-first").run()?;
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
    let alone = named(&["Quickstart.cs", "LibraryTests.cs", "VulkanTests.cs"]);
    let together = tests.iter().filter(|file| !alone.contains(file)).cloned().collect();
    for (program, files) in [
        ("quickstart", named(&["Quickstart.cs"])),
        ("tests", together),
        ("library", named(&["LibraryTests.cs", "Check.cs"])),
        ("vulkan", named(&["VulkanTests.cs", "Check.cs", "Sheet.cs"])),
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

/// Compiles the C host of the Vulkan examples to a library beside the test programs, where Mono finds it.
fn vulkan_host(workspace: &Workspace, built: &Path) -> Result<()> {
    let sh = &workspace.shell;
    let (file, examples) = (built.join("libcrumplehost.so"), workspace.path("examples-c"));
    let (host, shared) = (examples.join("vulkan_host.c"), workspace.path(TESTS).join("vulkan_shared.c"));
    let strict = ["-std=c11", "-Wall", "-Wextra", "-Werror", "-shared", "-fPIC"];
    Ok(cmd!(sh, "cc {strict...} -I {examples} {shared} {host} -o {file} -lvulkan").quiet().run()?)
}

/// Makes libraries that the C# layer must reject. Each has the name of its test case, which is also the name of its folder.
fn misfits(workspace: &Workspace, prefix: &Path, built: &Path) -> Result<Vec<(&'static str, PathBuf)>> {
    let sh = &workspace.shell;
    let right = prefix.join("lib/libcrumple.so");
    let source = workspace.path(TESTS).join("fake.c");
    let mut files = Vec::new();
    let (major, minor) = two(&workspace.version)?;
    let minor_and_patch = |minor: u32, patch: u32| Some((major * 1_000_000 + minor * 1000 + patch).to_string());
    let versions =
        [("version", minor_and_patch(minor + 1, 3)), ("patch", minor_and_patch(minor, 99)), ("foreign", None)];
    for (case, version) in versions {
        let file = place(built, case)?;
        let version = version.map(|number| format!("-DVERSION={number}"));
        cmd!(sh, "cc -shared -fPIC {version...} {source} -o {file}").quiet().run()?;
        files.push((case, file));
    }
    let file = place(built, "architecture")?;
    let mut bytes = fs::read(&right)?;
    bytes[MACHINE.0..][..2].copy_from_slice(&MACHINE.1);
    fs::write(&file, bytes)?;
    files.push(("architecture", file));
    let file = place(built, "garbage")?;
    fs::write(&file, "no library\n")?;
    files.push(("garbage", file));
    fs::create_dir(built.join("empty"))?;
    files.push(("missing", right));
    Ok(files)
}

/// The major and the minor version.
fn two(version: &str) -> Result<(u32, u32)> {
    let mut parts = version.split('.').map(str::parse);
    let mut next = || Ok::<u32, anyhow::Error>(parts.next().context("a version has three parts")??);
    Ok((next()?, next()?))
}

fn place(built: &Path, case: &str) -> Result<PathBuf> {
    let folder = built.join(case);
    fs::create_dir(&folder)?;
    Ok(folder.join("libcrumple.so"))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Finds every function, struct and enum of the header by plain search and looks for it in the C# files.
    #[test]
    fn nothing_of_the_header_is_missing() -> Result<()> {
        let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("..");
        let header = declarations::read(&root.join(INCLUDE))?;
        let (types, functions) = declarations(&header)?;
        let code = || header.lines().filter(|line| line.starts_with(|first: char| first.is_ascii_alphabetic()));
        let declared: Vec<&str> = code()
            .filter_map(|line| line.split_once('(')?.0.rsplit([' ', '*']).next())
            .filter(|name| name.starts_with("crumple_"))
            .collect();
        assert!(declared.len() > 70, "{declared:?}");
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
