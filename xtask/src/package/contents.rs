//! The contents of an archive, and the places where engines look for the library in it.

use std::path::Path;

use anyhow::{Context, Result, ensure};

use super::licenses::{FILE as LICENSES, STANDARD_LIBRARY};
use super::reference;
use crate::abi;
use crate::declarations::INCLUDE;
use crate::files::{copy, copy_tree, files_of, read, write};
use crate::install::Built;
use crate::native::{self, Build};
use crate::package::markdown;
use crate::tools::VULKAN_HEADERS;
use crate::workspace::{VERSION, git, in_target, run, sh};

/// Files and folders of the repository that archives hold under the same names.
const COPIED: &str = "CHANGELOG.md LICENSE-APACHE LICENSE-MIT assets/car/car_dents.glb assets/demo bindings/unity bindings/unreal \
                      bindings/vsg docs examples-c";
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
pub fn copy_all(built: &Built, folder: &Path) -> Result<()> {
    // The installer puts licenses into share, for prefixes that many packages share.
    sh().remove_path(folder.join("share"))?;
    let list = ["ls-files", "--error-unmatch", "--"].into_iter().chain(COPIED.split(' '));
    let listed = git(&list.collect::<Vec<_>>())?;
    for name in listed.lines().filter(|name| !LEFT_OUT.iter().any(|out| name.starts_with(out))) {
        copy(name, &folder.join(name))?;
    }
    copy(OVERVIEW.0, &folder.join(OVERVIEW.1))?;
    readme(built, folder)?;
    copy_tree(INCLUDE, &folder.join(UNREAL_HEADERS))?;
    write(folder.join(reference::PAGE), reference::page()?)?;
    unity_plugin(built, folder)?;
    engines(built, folder)?;
    for page in files_of(folder, &["md"])? {
        markdown::copy_page(&page, page.parent().context("pages lie somewhere")?)?;
    }
    Ok(())
}

/// Writes the first page. A template line that begins with `slim|` or `full|` is for that flavour alone.
fn readme(built: &Built, folder: &Path) -> Result<()> {
    let (own, features) = (format!("{}|", built.flavour.name), built.flavour.library.join(", "));
    let line = |line: &str| match line.strip_prefix(&own) {
        Some(line) => line.to_owned() + "\n",
        None if line.starts_with("slim|") || line.starts_with("full|") => String::new(),
        None => line.to_owned() + "\n",
    };
    let text: String = read(README)?.lines().map(line).collect();
    let text = text.replace("@VERSION@", VERSION).replace("@FEATURES@", &features);
    write(folder.join("README.md"), text.replace("@TARGET@", &built.target.triple))
}

/// Compiles Unity's renderer plugin against the packed library.
fn unity_plugin(built: &Built, folder: &Path) -> Result<()> {
    let (target, source) = (&built.target, folder.join(UNITY_NATIVE));
    // There is no plugin for macOS, where Unity draws with Metal.
    if target.is_macos() {
        return Ok(());
    }
    if !VULKAN_HEADERS.here() && cfg!(target_os = "linux") {
        ensure!(!built.handed_out, "Unity's plugin needs Vulkan's headers: on Debian, apt-get install libvulkan-dev");
        println!("Unity's plugin is left out");
        return Ok(());
    }
    let output = in_target(format!("package/{}/{}-unity", target.triple, built.flavour.name));
    let mut build = Build::on(target, "package", folder)?;
    build.options.push("-DCRUMPLE_TESTS=OFF".to_owned());
    native::compile(&build, &source, &output)?;
    let name = if target.is_windows() { "crumple_unity.dll" } else { "libcrumple_unity.so" };
    let plugin = folder.join(UNITY).join("Plugins/x86_64").join(name);
    // Microsoft's builds have a folder for each configuration.
    let configuration = if target.is_windows() && !target.cross { "RelWithDebInfo" } else { "." };
    copy(output.join(configuration).join(name), &plugin)?;
    if target.is_linux() || target.is_mingw() {
        let strip = target.gnu("strip");
        run!("{strip} --strip-unneeded {plugin}")?;
    }
    Ok(())
}

fn engines(built: &Built, folder: &Path) -> Result<()> {
    let fill = |path: &str| path.replace("@VERSION@", VERSION).replace("@SONAME@", &abi::soname(VERSION));
    for &(_, from, engine, to) in ENGINES.iter().filter(|engine| built.target.triple.contains(engine.0)) {
        copy(folder.join(fill(from)), &folder.join(engine).join(fill(to)))?;
    }
    // Unity warns about .meta files without a file: those of other systems' libraries.
    for settings in files_of(folder.join(UNITY).join("Plugins"), &["meta"]).unwrap_or_default() {
        if !settings.with_extension("").exists() {
            sh().remove_path(&settings)?;
        }
    }
    Ok(())
}
