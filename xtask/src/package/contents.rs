//! The contents of an archive, and the places where engines look for the library in it.

use std::fs;
use std::path::Path;

use anyhow::{Context, Result, ensure};

use super::licenses::{FILE as LICENSES, STANDARD_LIBRARY};
use super::{Parts, files, git, markdown};
use crate::declarations::{HEADERS, INCLUDE};
use crate::install;
use crate::native::{self, Build};
use crate::reference;
use crate::tools::Tool;
use crate::workspace::Workspace;

/// Files and folders of the repository that archives hold under the same names.
const COPIED: &[&str] = &[
    "CHANGELOG.md",
    "LICENSE-APACHE",
    "LICENSE-MIT",
    "assets/car/car_dents.glb",
    "assets/demo",
    "bindings/unity",
    "bindings/unreal",
    "bindings/vsg",
    "docs",
    "examples-c",
];
/// Parts of these that archives leave out: the lab's 13 MB of charts, and scripts that made files.
const LEFT_OUT: &[&str] = &["docs/lab/", "docs/bench/", "assets/demo/make_demo.py"];
/// The repository's README.md gets another name, because an archive has its own.
const OVERVIEW: (&str, &str) = ("README.md", "OVERVIEW.md");
const README: &str = "xtask/package/README.md.in";
const UNITY: &str = "bindings/unity";
const UNREAL: &str = "bindings/unreal";
const UNREAL_HEADERS: &str = "bindings/unreal/Source/ThirdParty/CrumpleLibrary/Public";
/// Unity's renderer plugin in C++. Unity ignores folders that end in ~.
const UNITY_NATIVE: &str = "bindings/unity/native~";

/// Files that engines get too: a part of the target's name (empty for all), file, the engine's folder, and the place
/// in it.
const ENGINES: &[(&str, &str, &str, &str)] = &[
    ("linux", "lib/libcrumple.so.@VERSION@", UNITY, "Plugins/x86_64/libcrumple.so"),
    ("linux", "lib/@SONAME@", UNREAL, "Source/ThirdParty/CrumpleLibrary/Lib/Linux/@SONAME@"),
    ("linux", "lib/@SONAME@", UNREAL, "Source/ThirdParty/CrumpleLibrary/Lib/Linux/libcrumple.so"),
    ("windows", "bin/crumple.dll", UNITY, "Plugins/x86_64/crumple.dll"),
    ("windows", "bin/crumple.dll", UNREAL, "Source/ThirdParty/CrumpleLibrary/Lib/Win64/crumple.dll"),
    ("windows", "lib/crumple.dll.lib", UNREAL, "Source/ThirdParty/CrumpleLibrary/Lib/Win64/crumple.dll.lib"),
    ("apple", "lib/libcrumple.dylib", UNITY, "Plugins/x86_64/libcrumple.dylib"),
    ("apple", "lib/libcrumple.a", UNREAL, "Source/ThirdParty/CrumpleLibrary/Lib/Mac/libcrumple.a"),
    ("", LICENSES, UNITY, "Documentation~/THIRD-PARTY-LICENSES.txt"),
    ("", LICENSES, UNREAL, LICENSES),
    ("", STANDARD_LIBRARY, UNITY, "Documentation~/RUST-STANDARD-LIBRARY-LICENSES.html"),
    ("", STANDARD_LIBRARY, UNREAL, STANDARD_LIBRARY),
];

/// Adds everything else to `folder`, which holds libraries, headers and licenses.
pub fn copy(workspace: &Workspace, parts: &Parts, folder: &Path) -> Result<()> {
    // The installer puts licenses into share, for prefixes that many packages share.
    fs::remove_dir_all(folder.join("share")).context("the installer leaves licenses")?;
    let listed = git(workspace, &[&["ls-files", "--"], COPIED].concat())?;
    for name in listed.lines().filter(|name| !LEFT_OUT.iter().any(|out| name.starts_with(out))) {
        put(&workspace.path(name), &folder.join(name))?;
    }
    put(&workspace.path(OVERVIEW.0), &folder.join(OVERVIEW.1))?;
    readme(workspace, parts, folder)?;
    for header in HEADERS.iter().chain(&["crumple.hpp"]) {
        put(&workspace.path(INCLUDE).join(header), &folder.join(UNREAL_HEADERS).join(header))?;
    }
    fs::write(folder.join(reference::PAGE), reference::page(&workspace.path(INCLUDE))?)
        .context("writing the reference page")?;
    unity_plugin(workspace, parts, folder)?;
    engines(workspace, parts, folder)?;
    for page in files(folder)?.iter().filter(|path| path.extension().is_some_and(|extension| extension == "md")) {
        let text = fs::read_to_string(page).with_context(|| format!("reading {}", page.display()))?;
        let directory = page.parent().context("pages lie somewhere")?;
        fs::write(page, markdown::without_dead_links(&text, directory))?;
    }
    Ok(())
}

fn put(from: &Path, to: &Path) -> Result<()> {
    fs::create_dir_all(to.parent().context("files lie somewhere")?)?;
    fs::copy(from, to).with_context(|| format!("copying {}", from.display())).map(drop)
}

/// Writes the first page. A template line that begins with `slim|` or `full|` is for that flavour alone.
fn readme(workspace: &Workspace, parts: &Parts, folder: &Path) -> Result<()> {
    let template = fs::read_to_string(workspace.path(README)).with_context(|| format!("reading {README}"))?;
    let own = format!("{}|", parts.flavour.name);
    let mut text = String::new();
    for line in template.lines() {
        if let Some(line) = line.strip_prefix(&own) {
            text += line;
        } else if line.starts_with("slim|") || line.starts_with("full|") {
            continue;
        } else {
            text += line;
        }
        text.push('\n');
    }
    let features = parts.flavour.library.join(", ");
    for (key, value) in
        [("@VERSION@", &workspace.version), ("@TARGET@", &parts.library.target.triple), ("@FEATURES@", &features)]
    {
        text = text.replace(key, value);
    }
    fs::write(folder.join("README.md"), text).context("writing the first page")
}

/// Compiles Unity's renderer plugin against the packed library.
fn unity_plugin(workspace: &Workspace, parts: &Parts, folder: &Path) -> Result<()> {
    let target = &parts.library.target;
    let source = folder.join(UNITY_NATIVE);
    // There is no plugin for macOS, where Unity draws with Metal.
    if !source.join("CMakeLists.txt").exists() || target.is_macos() {
        return Ok(());
    }
    if !Tool::VulkanHeaders.here(workspace) && cfg!(target_os = "linux") {
        ensure!(!parts.handed_out, "Unity's plugin needs Vulkan's headers: on Debian, apt-get install libvulkan-dev");
        println!("Unity's plugin is left out");
        return Ok(());
    }
    let directory = workspace.target.join("package").join(&target.triple).join(format!("{}-unity", parts.flavour.name));
    let cross = if target.cross { native::cross_options(workspace, target)? } else { Vec::new() };
    let options: Vec<&str> = cross.iter().map(String::as_str).chain(["-DCRUMPLE_TESTS=OFF"]).collect();
    let build = Build { options: &options, cross: target.cross, ..Build::new("package", folder) };
    native::compile(workspace, &build, &source, &directory)?;
    let built = match () {
        // Microsoft's builds have a folder for each configuration.
        () if target.is_windows() && !target.cross => "RelWithDebInfo/crumple_unity.dll",
        () if target.is_windows() => "crumple_unity.dll",
        () => "libcrumple_unity.so",
    };
    let built = directory.join(built);
    let to = folder.join(UNITY).join("Plugins/x86_64").join(built.file_name().context("plugins have names")?);
    put(&built, &to)?;
    if target.is_linux() || target.is_mingw() {
        let strip = target.gnu("strip");
        xshell::cmd!(workspace.shell, "{strip} --strip-unneeded {to}").quiet().run()?;
    }
    Ok(())
}

/// Checks that the archive has the library files that Unreal's build rules name.
fn unreal_has_what_it_links(plugin: &Path) -> Result<()> {
    let library = plugin.join("Source/ThirdParty/CrumpleLibrary");
    let rules = library.join("CrumpleLibrary.Build.cs");
    let rules = fs::read_to_string(&rules).with_context(|| format!("reading {}", rules.display()))?;
    let named = rules.split('"').skip(1).step_by(2).filter(|name| name.starts_with("libcrumple.so"));
    for name in named {
        let file = library.join("Lib/Linux").join(name);
        ensure!(file.is_file(), "the rules of Unreal's build name {name}, and the archive has no {}", file.display());
    }
    Ok(())
}

fn engines(workspace: &Workspace, parts: &Parts, folder: &Path) -> Result<()> {
    let target = &parts.library.target;
    let soname = if target.is_linux() { install::soname(&parts.library.shared)? } else { String::new() };
    let fill = |path: &str| path.replace("@VERSION@", &workspace.version).replace("@SONAME@", &soname);
    for &(system, from, engine, to) in ENGINES {
        let engine = folder.join(engine);
        if engine.exists() && (system.is_empty() || target.triple.contains(system)) {
            put(&folder.join(fill(from)), &engine.join(fill(to)))?;
        }
    }
    if target.is_linux() {
        unreal_has_what_it_links(&folder.join(UNREAL))?;
    }
    // Unity warns about .meta files without a file: those of other systems' libraries.
    let plugins = folder.join(UNITY).join("Plugins");
    for settings in if plugins.exists() { files(&plugins)? } else { Vec::new() } {
        if settings.extension().is_some_and(|extension| extension == "meta") && !settings.with_extension("").exists() {
            fs::remove_file(&settings).with_context(|| format!("removing {}", settings.display()))?;
        }
    }
    Ok(())
}
