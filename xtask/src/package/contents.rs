//! What of the repository goes into an archive, and where engines look for the library in it.

use std::fs;
use std::path::Path;

use anyhow::{Context, Result, ensure};

use super::licenses::{FILE as LICENSES, STANDARD_LIBRARY};
use super::{Parts, files, git, markdown};
use crate::header::HEADER;
use crate::install;
use crate::native::{self, Build};
use crate::reference;
use crate::tools::Tool;
use crate::workspace::Workspace;

/// Files and folders, under their own names, of which archives hold what git knows.
const COPIED: &[&str] = &[
    "CHANGELOG.md",
    "LICENSE-APACHE",
    "LICENSE-MIT",
    "assets/demo",
    "bindings/unity",
    "bindings/unreal",
    "bindings/vsg",
    "docs",
    "examples-c",
];
/// What of these stays: the lab's 13 MB of charts, and how files were made.
const LEFT_OUT: &[&str] = &["docs/lab/", "docs/bench/", "assets/demo/make_demo.py"];
/// The repository's own page, under another name, since an archive has one of its own.
const OVERVIEW: (&str, &str) = ("README.md", "OVERVIEW.md");
const README: &str = "xtask/package/README.md.in";
const UNITY: &str = "bindings/unity";
const UNREAL: &str = "bindings/unreal";
/// Unity's renderer plugin, in C++; folders that end in ~ are none of Unity's business.
const UNITY_NATIVE: &str = "bindings/unity/native~";

/// By operating system: a file of the archive, the folder of the engine that gets it too, and its place there.
const ENGINES: &[(&str, &str, &str, &str)] = &[
    ("linux", "lib/libcrumple.so.@VERSION@", UNITY, "Plugins/x86_64/libcrumple.so"),
    ("linux", "lib/@SONAME@", UNREAL, "Source/ThirdParty/CrumpleLibrary/Lib/Linux/@SONAME@"),
    ("linux", "lib/@SONAME@", UNREAL, "Source/ThirdParty/CrumpleLibrary/Lib/Linux/libcrumple.so"),
    ("windows", "bin/crumple.dll", UNITY, "Plugins/x86_64/crumple.dll"),
    ("windows", "bin/crumple.dll", UNREAL, "Source/ThirdParty/CrumpleLibrary/Lib/Win64/crumple.dll"),
    ("windows", "lib/crumple.dll.lib", UNREAL, "Source/ThirdParty/CrumpleLibrary/Lib/Win64/crumple.dll.lib"),
    ("macos", "lib/libcrumple.dylib", UNITY, "Plugins/x86_64/libcrumple.dylib"),
    ("macos", "lib/libcrumple.a", UNREAL, "Source/ThirdParty/CrumpleLibrary/Lib/Mac/libcrumple.a"),
    ("", "include/crumple.h", UNREAL, "Source/ThirdParty/CrumpleLibrary/Public/crumple.h"),
    ("", "include/crumple.hpp", UNREAL, "Source/ThirdParty/CrumpleLibrary/Public/crumple.hpp"),
    ("", LICENSES, UNITY, "Documentation~/THIRD-PARTY-LICENSES.txt"),
    ("", LICENSES, UNREAL, LICENSES),
    ("", STANDARD_LIBRARY, UNITY, "Documentation~/RUST-STANDARD-LIBRARY-LICENSES.html"),
    ("", STANDARD_LIBRARY, UNREAL, STANDARD_LIBRARY),
];

/// Copies into `folder`, which holds libraries, headers and licenses.
pub fn copy(workspace: &Workspace, parts: &Parts, folder: &Path) -> Result<()> {
    // The installer's place for licenses is for prefixes that many share.
    fs::remove_dir_all(folder.join("share")).context("the installer leaves licenses")?;
    let listed = git(workspace, &[&["ls-files", "--"], COPIED].concat())?;
    for name in listed.lines().filter(|name| !LEFT_OUT.iter().any(|out| name.starts_with(out))) {
        put(&workspace.path(name), &folder.join(name))?;
    }
    put(&workspace.path(OVERVIEW.0), &folder.join(OVERVIEW.1))?;
    readme(workspace, parts, folder)?;
    let header = fs::read_to_string(workspace.path(HEADER)).with_context(|| format!("reading {HEADER}"))?;
    fs::write(folder.join(reference::PAGE), reference::page(&header)?).context("writing the reference page")?;
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

/// The first page: lines that begin with a flavour's name and a bar are that flavour's.
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
    for (key, value) in [("@VERSION@", &workspace.version), ("@TARGET@", &parts.target), ("@FEATURES@", &features)] {
        text = text.replace(key, value);
    }
    fs::write(folder.join("README.md"), text).context("writing the first page")
}

/// Compiles Unity's renderer plugin against what is packed.
fn unity_plugin(workspace: &Workspace, parts: &Parts, folder: &Path) -> Result<()> {
    let source = folder.join(UNITY_NATIVE);
    // On macOS Unity draws with Metal, and there is no plugin.
    if !source.join("CMakeLists.txt").exists() || cfg!(target_os = "macos") {
        return Ok(());
    }
    if !Tool::VulkanHeaders.here(workspace) && cfg!(target_os = "linux") {
        ensure!(!parts.handed_out, "Unity's plugin needs Vulkan's headers: on Debian, apt-get install libvulkan-dev");
        println!("Unity's plugin is left out");
        return Ok(());
    }
    let directory = workspace.target.join("package").join(format!("{}-unity", parts.flavour.name));
    let build = Build { options: &["-DCRUMPLE_TESTS=OFF"], ..Build::new("package", folder) };
    native::compile(workspace, &build, &source, &directory)?;
    let built = directory.join(if cfg!(windows) { "RelWithDebInfo/crumple_unity.dll" } else { "libcrumple_unity.so" });
    let to = folder.join(UNITY).join("Plugins/x86_64").join(built.file_name().context("plugins have names")?);
    put(&built, &to)?;
    if cfg!(target_os = "linux") {
        xshell::cmd!(workspace.shell, "strip --strip-unneeded {to}").quiet().run()?;
    }
    Ok(())
}

/// Unreal's build rules name files of the library, which its build then needs.
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
    let soname = if cfg!(target_os = "linux") { install::soname(&parts.library.shared)? } else { String::new() };
    let fill = |path: &str| path.replace("@VERSION@", &workspace.version).replace("@SONAME@", &soname);
    for &(system, from, engine, to) in ENGINES {
        let engine = folder.join(engine);
        if engine.exists() && ["", std::env::consts::OS].contains(&system) {
            put(&folder.join(fill(from)), &engine.join(fill(to)))?;
        }
    }
    if cfg!(target_os = "linux") {
        unreal_has_what_it_links(&folder.join(UNREAL))?;
    }
    // Unity complains of settings of files that are not there: those of other systems' libraries.
    let plugins = folder.join(UNITY).join("Plugins");
    for settings in if plugins.exists() { files(&plugins)? } else { Vec::new() } {
        if settings.extension().is_some_and(|extension| extension == "meta") && !settings.with_extension("").exists() {
            fs::remove_file(&settings).with_context(|| format!("removing {}", settings.display()))?;
        }
    }
    Ok(())
}
