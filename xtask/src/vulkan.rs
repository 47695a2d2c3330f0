//! Runs the Vulkan and wgpu tests under validation on Mesa's lavapipe and, with `--all`, on SwiftShader from Debian's Chromium.

use std::path::PathBuf;

use anyhow::{Context, Result};

use crate::files::{files, name, write};
use crate::stage::all_passed;
use crate::tools::{SWIFTSHADER, SWIFTSHADER_LIBRARY, VULKAN};
use crate::workspace::{all, in_target, tests};

const MANIFESTS: &str = "/usr/share/vulkan/icd.d";

pub fn stage() -> Result<()> {
    let drivers = drivers()?;
    let manifests = std::env::join_paths(&drivers)?;
    // The tests fail if one of these drivers or the validation layer is missing.
    let required = match (drivers.len(), all()) {
        (2, true) => "llvmpipe,SwiftShader",
        (_, false) => "llvmpipe",
        _ => "0",
    };
    // The library's tests, and the lab's workloads at their smallest.
    let tests = |programs: &[&str]| -> Result<()> {
        // Mesa's device selection layer prints errors in a session without a display.
        let tests = tests(programs).env("VK_DRIVER_FILES", &manifests).env("NODEVICE_SELECT", "1");
        Ok(tests.env("CRUMPLE_REQUIRE_GPU", required).run()?)
    };
    if !all() {
        return tests(&["--test", "vulkan"]);
    }
    all_passed(vec![
        ("the library", tests(&["--test", "vulkan", "--test", "wgpu"])),
        ("the lab", tests(&["--bin", "crumple-lab", "--", "gpu::"])),
    ])
}

/// Manifests of the software drivers. Everybody's tests run on lavapipe alone: SwiftShader's package is large.
pub fn drivers() -> Result<Vec<PathBuf>> {
    let mut drivers = vec![lavapipe()?];
    if all() && SWIFTSHADER.here() {
        // The package's manifest has a relative path, which the loader resolves against the current folder.
        let text = format!(
            r#"{{"file_format_version": "1.0.0", "ICD": {{"library_path": "{SWIFTSHADER_LIBRARY}", "api_version": "1.1.0"}}}}"#
        );
        let manifest = in_target("vk_swiftshader_icd.json");
        write(&manifest, text)?;
        drivers.push(manifest);
    }
    Ok(drivers)
}

/// The manifest of Mesa's driver. Some releases put the processor into its name.
pub fn lavapipe() -> Result<PathBuf> {
    let mut found = files(MANIFESTS)?.into_iter();
    found
        .find(|file| name(file).is_ok_and(|name| name.starts_with("lvp_icd")))
        .with_context(|| format!("{MANIFESTS} holds no lvp_icd…json"))
}

/// Mesa's driver alone, for the slow stages. Valgrind does not know some instructions in Chromium's build of SwiftShader.
pub fn one_driver() -> Result<Vec<PathBuf>> {
    VULKAN.here().then(lavapipe).into_iter().collect()
}
