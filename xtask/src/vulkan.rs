//! The tests of Vulkan recording and of wgpu on two software drivers under validation: Mesa's lavapipe, which Debian packages, and SwiftShader, which it
//! packages inside Chromium.

use std::fs;
use std::path::{Path, PathBuf};

use anyhow::{Context, Result};
use xshell::cmd;

use crate::stage::Outcome;
use crate::tools;
use crate::workspace::{Workspace, empty_directory};

const MANIFESTS: &str = "/usr/share/vulkan/icd.d";
/// Debian's package that holds SwiftShader, and where in it.
const PACKAGE: &str = "chromium-common";
const PACKAGED: &str = "usr/lib/chromium/libvk_swiftshader.so";

pub fn run(workspace: &Workspace) -> Result<Outcome> {
    let lavapipe = lavapipe()?;
    let swiftshader = swiftshader(workspace);
    let tests = ["test", "--package", "crumple", "--all-features", "--test", "vulkan", "--test", "wgpu"];
    let tests = |drivers: &[&Path]| -> Result<xshell::Cmd<'_>> {
        Ok(workspace.cargo(&tests).env("VK_DRIVER_FILES", std::env::join_paths(drivers)?))
    };
    match swiftshader {
        Ok(swiftshader) => {
            tests(&[&lavapipe, &swiftshader])?.env("CRUMPLE_REQUIRE_GPU", "1").run()?;
            Ok(Outcome::Passed)
        }
        Err(error) => {
            tests(&[&lavapipe])?.run()?;
            Ok(Outcome::InPart(format!("SwiftShader: {error:#}")))
        }
    }
}

/// The manifest of Mesa's driver; its name tells the processor or not.
fn lavapipe() -> Result<PathBuf> {
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
    let mut files = fs::read_dir(&directory)?.filter_map(|e| Some(e.ok()?.path()));
    let package = files.find(|p| p.extension().is_some_and(|e| e == "deb")).context("no package was downloaded")?;
    let unpacked = directory.join("package");
    cmd!(sh, "dpkg-deb -x {package} {unpacked}").run()?;
    let library = directory.join("libvk_swiftshader.so");
    fs::rename(unpacked.join(PACKAGED), &library).with_context(|| format!("{PACKAGE} holds no {PACKAGED}"))?;
    fs::remove_dir_all(unpacked)?;
    fs::remove_file(package)?;
    // The package's own manifest names its library relative to itself, which the loader takes as relative to where it runs.
    let text = format!(
        r#"{{"file_format_version": "1.0.0", "ICD": {{"library_path": "{}", "api_version": "1.1.0"}}}}"#,
        library.display()
    );
    fs::write(&manifest, text).with_context(|| format!("writing {}", manifest.display()))?;
    Ok(manifest)
}
