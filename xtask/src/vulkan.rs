//! Runs the Vulkan and wgpu tests under validation on Mesa's lavapipe and, with `--all`, on SwiftShader from Debian's Chromium.

use std::fs;
use std::path::PathBuf;

use anyhow::{Context, Result};
use xshell::cmd;

use crate::stage::{Outcome, all_passed};
use crate::tools;
use crate::workspace::{Workspace, empty_directory};

const MANIFESTS: &str = "/usr/share/vulkan/icd.d";
/// Debian's package that holds SwiftShader.
const PACKAGE: &str = "chromium-common";
const PACKAGED: &str = "usr/lib/chromium/libvk_swiftshader.so";

/// Manifests of the software drivers, and the reason if one is left out.
pub struct Drivers {
    pub manifests: Vec<PathBuf>,
    pub left_out: Option<String>,
}

impl Drivers {
    /// The outcome of a stage that passed on all of them.
    pub fn passed(self) -> Outcome {
        self.left_out.map_or(Outcome::Passed, Outcome::InPart)
    }
}

pub fn run(workspace: &Workspace) -> Result<Outcome> {
    let drivers = drivers(workspace)?;
    let manifests = std::env::join_paths(&drivers.manifests)?;
    // The tests fail if one of these drivers or the validation layer is missing.
    let required = match (&drivers.left_out, workspace.all) {
        (None, true) => "llvmpipe,SwiftShader",
        (None, false) => "llvmpipe",
        (Some(_), _) => "0",
    };
    // The library's tests, and the lab's workloads at their smallest.
    let tests = |programs: &[&str]| -> Result<()> {
        let tests = workspace.tests(programs).env("VK_DRIVER_FILES", &manifests);
        // Mesa's device selection layer prints errors in a session without a display.
        let tests = tests.env("NODEVICE_SELECT", "1");
        Ok(tests.env("CRUMPLE_REQUIRE_GPU", required).run()?)
    };
    if !workspace.all {
        tests(&["--test", "vulkan"])?;
        return Ok(drivers.passed());
    }
    all_passed(vec![
        ("the library", tests(&["--test", "vulkan", "--test", "wgpu"])),
        ("the lab", tests(&["--bin", "crumple-lab", "--", "gpu::"])),
    ])?;
    Ok(drivers.passed())
}

/// Everybody's tests run on lavapipe alone: SwiftShader's package is large.
pub fn drivers(workspace: &Workspace) -> Result<Drivers> {
    let lavapipe = lavapipe()?;
    if !workspace.all {
        return Ok(Drivers { manifests: vec![lavapipe], left_out: None });
    }
    Ok(match swiftshader(workspace) {
        Ok(swiftshader) => Drivers { manifests: vec![lavapipe, swiftshader], left_out: None },
        Err(error) => Drivers { manifests: vec![lavapipe], left_out: Some(format!("SwiftShader: {error:#}")) },
    })
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
    let mut files = fs::read_dir(&directory)?.filter_map(|e| Some(e.ok()?.path()));
    let package = files.find(|p| p.extension().is_some_and(|e| e == "deb")).context("no package was downloaded")?;
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
    fs::write(&manifest, text).with_context(|| format!("writing {}", manifest.display()))?;
    Ok(manifest)
}
