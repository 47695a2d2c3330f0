//! The `crumple` command, built and called as a person would call it. Each call answers what it printed.

use std::path::{Path, PathBuf};

use anyhow::Result;
use xshell::cmd;

use crate::workspace::Workspace;

pub struct Command<'a> {
    workspace: &'a Workspace,
    program: PathBuf,
}

impl<'a> Command<'a> {
    pub fn build(workspace: &'a Workspace) -> Result<Self> {
        let what = ["build", "--release", "--package", "crumple", "--bin", "crumple", "--features", "cli"];
        workspace.cargo(&what).run()?;
        let program = workspace.target.join("release").join("crumple").with_extension(std::env::consts::EXE_EXTENSION);
        Ok(Self { workspace, program })
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
