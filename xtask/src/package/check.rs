//! Checks an archive as a user has it: unpacked in an empty folder. Its files match its manifest, and its examples build and run,
//! shared and static, by CMake and by pkg-config.

use std::collections::BTreeSet;
use std::fs;
use std::path::{Path, PathBuf};

use anyhow::{Context, Result, ensure};
use serde_json::Value;
use xshell::cmd;

use super::{FULL, Flavour, Packed, Parts, archive, files, manifest, markdown, pack, tested, time, within};
use crate::abi;
use crate::install::{self, Built};
use crate::native::{self, Build};
use crate::stage::Outcome;
use crate::target::{Target, launch};
use crate::wine::Wine;
use crate::workspace::Workspace;

/// A project of a user, beside the archive's examples.
const CLIENT: &[&str] = &["xtask/package/client/CMakeLists.txt", "xtask/package/client/client.cpp"];
/// Files that every archive holds.
const PRESENT: &[&str] = &[
    "README.md",
    "OVERVIEW.md",
    "CHANGELOG.md",
    "LICENSE-MIT",
    "LICENSE-APACHE",
    "THIRD-PARTY-LICENSES.txt",
    "RUST-STANDARD-LIBRARY-LICENSES.html",
    "include/crumple.h",
    "include/crumple_build.h",
    "include/crumple_graph.h",
    "include/crumple_contacts.h",
    "include/crumple_host.h",
    "include/crumple_view.h",
    "include/crumple_import.h",
    "include/crumple_parts.h",
    "include/crumple_vulkan.h",
    "include/crumple.hpp",
    "lib/static-libraries.txt",
    "lib/cmake/Crumple/CrumpleConfig.cmake",
    "docs/integration.md",
    "docs/reference.md",
    "examples-c/quickstart.c",
    "assets/demo/hood.glb",
];

/// Packs and checks the full flavour with the release library and the tests' command, which other stages build too.
pub fn stage(workspace: &Workspace) -> Result<Outcome> {
    if cfg!(windows) {
        return Ok(Outcome::NotApplicable("not done on Windows, where pkg-config is rare".into()));
    }
    let parts = tested(workspace, Target::host(workspace)?)?;
    let out = tempfile::tempdir()?;
    let packed = pack(workspace, &parts, out.path())?;
    check(workspace, &FULL, &packed)?;
    Ok(Outcome::Passed)
}

/// Packs and checks the full flavour for Windows with a library and a command that other tests use too.
pub fn windows(workspace: &Workspace, wine: &Wine<'_>, library: Built, command: PathBuf) -> Result<()> {
    let parts = Parts { flavour: &FULL, library, command: Some(command), handed_out: false };
    let out = tempfile::tempdir()?;
    let packed = pack(workspace, &parts, out.path())?;
    under_wine(workspace, &FULL, &packed, wine)
}

pub fn check(workspace: &Workspace, flavour: &Flavour, packed: &Packed) -> Result<()> {
    if cfg!(windows) {
        println!("an archive for Windows is not unpacked and tried here");
        return Ok(());
    }
    let scratch = tempfile::tempdir()?;
    let root = scratch.path();
    let folder = unpack(workspace, flavour, packed, root)?;
    if packed.target.is_linux() {
        install::stays_loaded(&install::shared(&packed.target, &folder))?;
    }
    command(workspace, flavour, &folder, &folder.join("bin/crumple"), &[])?;
    println!("by the first page:");
    first_page(workspace, packed, &folder)?;
    println!("by CMake:");
    by_cmake(workspace, root, &folder)?;
    println!("by pkg-config:");
    by_pkg_config(workspace, flavour, root, &folder)?;
    println!("{} is what it says, and its examples run", packed.name);
    Ok(())
}

/// Builds the user's project with MinGW against an archive for Windows, and runs it and the command under Wine. Stage
/// "windows" runs the examples.
pub fn under_wine(workspace: &Workspace, flavour: &Flavour, packed: &Packed, wine: &Wine<'_>) -> Result<()> {
    let (scratch, sh) = (tempfile::tempdir()?, &workspace.shell);
    let root = scratch.path();
    let folder = unpack(workspace, flavour, packed, root)?;
    install::needs_windows_alone(&install::shared(&packed.target, &folder))?;
    install::needs_windows_alone(&folder.join("bindings/unity/Plugins/x86_64/crumple_unity.dll"))?;
    let _found = wine.libraries(&[&folder.join("bin")]);
    command(workspace, flavour, &folder, &folder.join("bin/crumple.exe"), &[wine.program])?;
    let options = native::cross_options(workspace, &packed.target)?;
    let options: Vec<&str> = options.iter().map(String::as_str).collect();
    let (source, build) = (root.join("client"), root.join("client-build"));
    client(workspace, &source)?;
    native::compile(
        workspace,
        &Build { options: &options, cross: true, ..Build::new("client", &folder) },
        &source,
        &build,
    )?;
    let _only = sh.push_env("PKG_CONFIG_LIBDIR", folder.join("lib/pkgconfig"));
    let flags = cmd!(sh, "pkg-config --cflags --libs crumple").quiet().read()?;
    let (flags, program) = (flags.split_whitespace(), build.join("quickstart.exe"));
    let (compiler, file) = (packed.target.gnu("gcc"), folder.join("examples-c/quickstart.c"));
    cmd!(sh, "{compiler} {file} -o {program} {flags...}").quiet().run()?;
    for name in ["client-shared.exe", "client-static.exe", "quickstart.exe"] {
        let (wine, program) = (wine.program, build.join(name));
        cmd!(sh, "{wine} {program}").quiet().run().with_context(|| format!("{name} under Wine"))?;
    }
    println!("{} is what it says, and programs run with it", packed.name);
    Ok(())
}

/// Unpacks an archive, compares it with its manifest, and returns its folder.
fn unpack(workspace: &Workspace, flavour: &Flavour, packed: &Packed, root: &Path) -> Result<PathBuf> {
    let packed_file = &packed.archive;
    if packed.target.is_windows() {
        zip::ZipArchive::new(fs::File::open(packed_file)?)?.extract(root)?;
    } else {
        cmd!(workspace.shell, "tar -xzf {packed_file} -C {root} --no-same-owner -m").quiet().run()?;
    }
    let inside: Vec<_> = fs::read_dir(root)?.collect::<Result<_, _>>()?;
    ensure!(
        inside.len() == 1 && inside[0].file_name() == *packed.name,
        "{} holds more than one folder",
        packed_file.display()
    );
    let folder = root.join(&packed.name);

    // Packing the unpacked files again gives the same bytes.
    let again = root.join("again");
    fs::create_dir(&again)?;
    let same = fs::read(archive::pack(&folder, &again, time(workspace)?, &packed.target)?)? == fs::read(packed_file)?;
    ensure!(same, "what {} holds, packed again, makes another archive", packed_file.display());

    said(workspace, flavour, packed, &folder)?;
    pages(&folder)?;
    abi::exported(&folder.join("include"), &install::shared(&packed.target, &folder))?;
    Ok(folder)
}

/// The manifest lists every file with its size and digest, and no other file.
fn said(workspace: &Workspace, flavour: &Flavour, packed: &Packed, folder: &Path) -> Result<()> {
    let text = fs::read_to_string(folder.join(manifest::FILE)).context("reading the manifest")?;
    let manifest: Value = serde_json::from_str(&text).context("reading the manifest")?;
    let said = |key: &str| manifest[key].as_str().unwrap_or_default().to_owned();
    let named = format!("{}-{}-{}{}", said("name"), said("version"), said("target"), flavour.suffix);
    ensure!(named == packed.name && said("flavour") == flavour.name, "the manifest of {} is of {named}", packed.name);
    ensure!(said("version") == workspace.version, "the manifest is of version {}", said("version"));
    let mut listed = BTreeSet::new();
    for entry in manifest["files"].as_array().context("the manifest lists files")? {
        let path = entry["path"].as_str().context("files have paths")?;
        let bytes = fs::read(folder.join(path)).with_context(|| format!("the manifest names {path}"))?;
        let same = entry["size"] == bytes.len() && entry["sha256"] == *manifest::sha256(&bytes);
        ensure!(same, "{path} is not what the manifest says");
        listed.insert(path.to_owned());
    }
    let mut there: BTreeSet<String> = files(folder)?.iter().map(|file| within(folder, file)).collect::<Result<_>>()?;
    there.remove(manifest::FILE);
    ensure!(there == listed, "the manifest does not name {:?}", there.difference(&listed).collect::<Vec<_>>());
    let absent: Vec<_> = PRESENT.iter().filter(|path| !there.contains(**path)).collect();
    ensure!(absent.is_empty(), "{} lacks {absent:?}", packed.name);
    Ok(())
}

/// Every link of every page leads to a file.
fn pages(folder: &Path) -> Result<()> {
    for page in files(folder)?.iter().filter(|path| path.extension().is_some_and(|extension| extension == "md")) {
        for target in markdown::targets(&fs::read_to_string(page)?) {
            let there = page.parent().context("pages lie somewhere")?.join(&target).exists();
            ensure!(there, "{} leads to {target}, which is not there", within(folder, page)?);
        }
    }
    Ok(())
}

/// `runner` runs the command, if it is for another system.
fn command(workspace: &Workspace, flavour: &Flavour, folder: &Path, program: &Path, runner: &[&str]) -> Result<()> {
    ensure!(program.exists() == flavour.command, "the {} flavour and its command do not fit", flavour.name);
    if program.exists() {
        let hood = folder.join("assets/demo/hood.glb");
        let said = launch(&workspace.shell, runner, program).arg("info").arg(hood).read()?;
        ensure!(said.contains("24616 vertices"), "crumple info says: {said}");
    }
    Ok(())
}

/// Runs the commands that the first page shows, which build the examples with the shared library.
fn first_page(workspace: &Workspace, packed: &Packed, folder: &Path) -> Result<()> {
    let page = fs::read_to_string(folder.join("README.md"))?;
    let sh = workspace.shell.clone();
    sh.change_dir(folder);
    let blocks: Vec<&str> = page.split("```sh\n").skip(1).filter_map(|rest| rest.split("```").next()).collect();
    ensure!(blocks.len() >= 2, "the first page has {} blocks of commands", blocks.len());
    let slow = |block: &&str| !packed.handed_out && block.starts_with("bin/crumple");
    for block in blocks.into_iter().filter(|block| !slow(block)) {
        println!("{}", block.trim_end());
        cmd!(sh, "sh -e -c {block}").quiet().ignore_stdout().run().context("typing what README.md says")?;
    }
    ensure!(folder.join("build/quickstart").exists(), "the first page builds no quickstart");
    Ok(())
}

/// Builds the user's project, and the archive's examples with the static library. Examples that need more than a compiler are left out.
fn by_cmake(workspace: &Workspace, root: &Path, folder: &Path) -> Result<()> {
    let sh = &workspace.shell;
    let (examples, build) = (folder.join("examples-c"), root.join("static"));
    let plain = ["-DCMAKE_DISABLE_FIND_PACKAGE_Vulkan=ON", "-DCMAKE_DISABLE_FIND_PACKAGE_PkgConfig=ON"];
    cmd!(sh, "cmake -S {examples} -B {build} -DCMAKE_PREFIX_PATH={folder} -DCRUMPLE_STATIC=ON {plain...}")
        .quiet()
        .ignore_stdout()
        .run()?;
    cmd!(sh, "cmake --build {build} --parallel 2").ignore_stdout().run()?;
    cmd!(sh, "ctest --test-dir {build} --parallel 2 --output-on-failure --no-tests=error").run()?;
    let (source, build) = (root.join("client"), root.join("client-build"));
    client(workspace, &source)?;
    native::compile(workspace, &Build::new("client", folder), &source, &build)?;
    for name in ["client-shared", "client-static"] {
        let program = build.join(name);
        cmd!(sh, "{program}").quiet().run().with_context(|| format!("{name}, built by CMake"))?;
    }
    Ok(())
}

/// Copies the user's project.
fn client(workspace: &Workspace, to: &Path) -> Result<()> {
    fs::create_dir(to)?;
    for file in CLIENT {
        let name = Path::new(file).file_name().context("files have names")?;
        fs::copy(workspace.path(file), to.join(name)).with_context(|| format!("copying {file}"))?;
    }
    Ok(())
}

fn by_pkg_config(workspace: &Workspace, flavour: &Flavour, root: &Path, folder: &Path) -> Result<()> {
    let sh = &workspace.shell;
    // pkg-config finds nothing but the archive.
    let _found = sh.push_env("PKG_CONFIG_LIBDIR", folder.join("lib/pkgconfig"));
    let _nothing_else = sh.push_env("PKG_CONFIG_PATH", "");
    let ask = |arguments: &[&str]| -> Result<Vec<String>> {
        let said = cmd!(sh, "pkg-config {arguments...} crumple").quiet().read()?;
        Ok(said.split_whitespace().map(str::to_owned).collect())
    };
    let version = ask(&["--modversion"])?.concat();
    ensure!(version == workspace.version, "pkg-config says version {version}");
    let features = ask(&["--variable=features"])?;
    ensure!(features == flavour.library, "pkg-config says the library was built with {features:?}");

    let (examples, hood, dented) =
        (folder.join("examples-c"), folder.join("assets/demo/hood.glb"), root.join("hood.obj"));
    let files = [hood.into_os_string(), dented.into_os_string()];
    let client = root.join("client/client.cpp");
    let mut programs = vec![("cc", examples.join("quickstart.c"), &files[..0]), ("c++", client, &files[..0])];
    if flavour.library.contains(&"gltf") {
        programs.push(("cc", examples.join("dent_gltf.c"), &files));
    }
    for (compiler, file, arguments) in programs {
        let name = file.file_stem().context("programs have names")?.to_string_lossy();
        let shared = root.join(format!("{name}-shared"));
        let flags = ask(&["--cflags", "--libs"])?;
        cmd!(sh, "{compiler} {file} -o {shared} {flags...} -lm").quiet().run()?;
        let loader = if cfg!(target_os = "macos") { "DYLD_LIBRARY_PATH" } else { "LD_LIBRARY_PATH" };
        cmd!(sh, "{shared} {arguments...}").env(loader, folder.join("lib")).quiet().run()?;

        // `--static` adds the system libraries. The file is named because the linker would take the shared library beside it.
        let fixed = root.join(format!("{name}-static"));
        let compile = ask(&["--cflags"])?;
        let archive = ask(&["--variable=staticlibrary"])?;
        let libraries: Vec<String> =
            ask(&["--libs", "--static"])?.into_iter().filter(|flag| flag != "-lcrumple").collect();
        cmd!(sh, "{compiler} {file} -o {fixed} {compile...} {archive...} {libraries...} -lm").quiet().run()?;
        cmd!(sh, "{fixed} {arguments...}").quiet().run()?;
    }
    Ok(())
}
