//! Builds the `crumple` command and calls it as a user does. Each call returns what the command printed.

use std::path::{Path, PathBuf};

use anyhow::Result;
use xshell::cmd;

use crate::install::Profile;
use crate::target::Target;
use crate::workspace::Workspace;

/// The features of the released command, beside the default ones.
pub const FEATURES: &str = "cli,wgpu";

pub struct Command<'a> {
    workspace: &'a Workspace,
    program: PathBuf,
    /// Deform on the GPU whose name contains this.
    gpu: Option<String>,
}

impl<'a> Command<'a> {
    /// A debug build is the one that the tests use. A release build has GPU support only if `gpu` is given.
    pub fn build(workspace: &'a Workspace, profile: Profile, gpu: Option<&str>) -> Result<Self> {
        let release = ["--package", "crumple", "--features", if gpu.is_some() { FEATURES } else { "cli" }];
        match profile {
            Profile::Debug => workspace.build_as_tested(&["--bin", "crumple"]).run()?,
            Profile::Dist => return Self::handed_out(workspace, &Target::host(workspace)?),
            Profile::Release => {
                workspace.cargo_anywhere(&["build", "--release", "--bin", "crumple"])?.args(release).run()?
            }
        }
        let program = workspace.target.join(profile.directory()).join("crumple");
        let program = program.with_extension(std::env::consts::EXE_EXTENSION);
        Ok(Self { workspace, program, gpu: gpu.map(str::to_owned) })
    }

    /// The command of a release archive.
    pub fn handed_out(workspace: &'a Workspace, target: &Target) -> Result<Self> {
        let dist = ["build", "--profile", "dist", "--bin", "crumple", "--package", "crumple"];
        target.cargo(workspace, &dist)?.args(["--features", FEATURES]).run()?;
        let program = target.directory(workspace, Profile::Dist.directory()).join(target.program("crumple"));
        Ok(Self { workspace, program, gpu: None })
    }

    pub fn program(&self) -> &Path {
        &self.program
    }

    /// Writes `count` impacts on `file`'s mesh. Every call writes the same ones.
    pub fn sample(&self, file: &Path, impacts: &Path, count: &str) -> Result<String> {
        let program = &self.program;
        Ok(cmd!(self.workspace.shell, "{program} sample {file} --count {count} -o {impacts}").quiet().read()?)
    }

    /// `options` are further ones of the command, such as `--join`.
    pub fn apply(
        &self,
        file: &Path,
        impacts: &Path,
        dented: &Path,
        pictures: Option<&Path>,
        options: &[&str],
    ) -> Result<String> {
        let program = &self.program;
        let pictures = pictures.map(|directory| ["--png".as_ref(), directory.as_os_str()]).into_iter().flatten();
        let gpu = self.gpu.as_ref().map(|name| format!("--gpu={name}"));
        let files = ["--impacts".as_ref(), impacts.as_os_str(), "-o".as_ref(), dented.as_os_str()];
        let apply = cmd!(self.workspace.shell, "{program} apply {file} {files...} {pictures...} {gpu...} {options...}");
        Ok(apply.quiet().read()?)
    }
}
