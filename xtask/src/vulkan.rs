//! Runs the Vulkan and wgpu tests under validation on Mesa's lavapipe and, with `--all`, on SwiftShader from Debian's Chromium.

use std::fs;
use std::path::PathBuf;

use anyhow::{Context, Result};
use xshell::cmd;

use crate::files::{empty_directory, files_of, write};
use crate::stage::all_passed;
use crate::tools;
use crate::workspace::Workspace;

const MANIFESTS: &str = "/usr/share/vulkan/icd.d";
/// Debian's package that holds SwiftShader.
const PACKAGE: &str = "chromium-common";
const PACKAGED: &str = "usr/lib/chromium/libvk_swiftshader.so";

pub fn run(workspace: &Workspace) -> Result<()> {
    let drivers = drivers(workspace)?;
    let manifests = std::env::join_paths(&drivers)?;
    // The tests fail if one of these drivers or the validation layer is missing.
    let required = match (drivers.len(), workspace.all) {
        (2, true) => "llvmpipe,SwiftShader",
        (_, false) => "llvmpipe",
        _ => "0",
    };
    // The library's tests, and the lab's workloads at their smallest.
    let tests = |programs: &[&str]| -> Result<()> {
        let tests = workspace.tests(programs).env("VK_DRIVER_FILES", &manifests);
        // Mesa's device selection layer prints errors in a session without a display.
        let tests = tests.env("NODEVICE_SELECT", "1");
        Ok(tests.env("CRUMPLE_REQUIRE_GPU", required).run()?)
    };
    if !workspace.all {
        return tests(&["--test", "vulkan"]);
    }
    all_passed(vec![
        ("the library", tests(&["--test", "vulkan", "--test", "wgpu"])),
        ("the lab", tests(&["--bin", "crumple-lab", "--", "gpu::"])),
    ])
}

/// Manifests of the software drivers. Everybody's tests run on lavapipe alone: SwiftShader's package is large.
pub fn drivers(workspace: &Workspace) -> Result<Vec<PathBuf>> {
    let mut drivers = vec![lavapipe()?];
    if workspace.all {
        match swiftshader(workspace) {
            Ok(swiftshader) => drivers.push(swiftshader),
            Err(error) => workspace.leave_out(format!("SwiftShader: {error:#}")),
        }
    }
    Ok(drivers)
}

/// The manifest of Mesa's driver. Some releases put the processor into its name.
pub fn lavapipe() -> Result<PathBuf> {
    let entries = fs::read_dir(MANIFESTS).with_context(|| format!("reading {MANIFESTS}"))?;
    let mut found = entries.filter_map(|e| Some(e.ok()?.path()));
    let name = |p: &PathBuf| p.file_name().is_some_and(|n| n.to_string_lossy().starts_with("lvp_icd"));
    found.find(name).with_context(|| format!("{MANIFESTS} holds no lvp_icd…json"))
}

/// The manifest of SwiftShader, taken out of Chromium's package without installing it.
fn swiftshader(workspace: &Workspace) -> Result<PathBuf> {
    let directory = workspace.target.join("swiftshader");
    let manifest = directory.join("vk_swiftshader_icd.json");
    if manifest.exists() {
        return Ok(manifest);
    }
    empty_directory(&directory)?;
    let sh = workspace.shell.clone();
    sh.change_dir(&directory);
    let download = || cmd!(sh, "apt-get -q download {PACKAGE}").run();
    if download().is_err() {
        tools::refresh(workspace);
        download()?;
    }
    let package = files_of(&directory, &["deb"])?.pop().context("no package was downloaded")?;
    let unpacked = directory.join("package");
    cmd!(sh, "dpkg-deb -x {package} {unpacked}").run()?;
    let library = directory.join("libvk_swiftshader.so");
    fs::rename(unpacked.join(PACKAGED), &library).with_context(|| format!("{PACKAGE} holds no {PACKAGED}"))?;
    fs::remove_dir_all(unpacked)?;
    fs::remove_file(package)?;
    // The package's manifest has a relative path, which the loader resolves against the current folder.
    let text = format!(
        r#"{{"file_format_version": "1.0.0", "ICD": {{"library_path": "{}", "api_version": "1.1.0"}}}}"#,
        library.display()
    );
    write(&manifest, text)?;
    Ok(manifest)
}
