//! The `crumple` command, built and called as a person would call it. Each call answers what it printed.

use std::path::{Path, PathBuf};

use anyhow::Result;
use xshell::cmd;

use crate::install::Profile;
use crate::workspace::{TESTED, Workspace};

pub struct Command<'a> {
    workspace: &'a Workspace,
    program: PathBuf,
}

impl<'a> Command<'a> {
    /// A debug build is the one that the tests use.
    pub fn build(workspace: &'a Workspace, profile: Profile) -> Result<Self> {
        let release = ["--package", "crumple", "--features", "cli"];
        let what = if profile == Profile::Debug { TESTED } else { &release };
        workspace.cargo(&["build", "--bin", "crumple"]).args(what).args(profile.flags()).run()?;
        let program = workspace.target.join(profile.directory()).join("crumple");
        Ok(Self { workspace, program: program.with_extension(std::env::consts::EXE_EXTENSION) })
    }

    pub fn info(&self, file: &Path) -> Result<String> {
        let program = &self.program;
        Ok(cmd!(self.workspace.shell, "{program} info {file}").quiet().read()?)
    }

    /// Writes `count` impacts on `file`'s mesh, the same ones at every call.
    pub fn sample(&self, file: &Path, impacts: &Path, count: &str) -> Result<String> {
        let program = &self.program;
        Ok(cmd!(self.workspace.shell, "{program} sample {file} --count {count} -o {impacts}").quiet().read()?)
    }

    pub fn apply(&self, file: &Path, impacts: &Path, dented: &Path, pictures: Option<&Path>) -> Result<String> {
        let program = &self.program;
        let pictures = pictures.map(|directory| ["--png".as_ref(), directory.as_os_str()]).into_iter().flatten();
        let apply = cmd!(self.workspace.shell, "{program} apply {file} --impacts {impacts} -o {dented} {pictures...}");
        Ok(apply.quiet().read()?)
    }
}
