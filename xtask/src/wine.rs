//! Wine, which runs programs for Windows. It has a folder of its own below the target directory, and a display without a
//! screen. Its server and the display end with the stage.

use std::io::{BufRead, BufReader};
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};

use anyhow::{Context, Result};
use xshell::{PushEnv, cmd};

use crate::target::{Target, WINDOWS};
use crate::workspace::{Workspace, empty_directory};

/// Where distributions put it. Debian has it outside of PATH.
const PROGRAMS: &[&str] = &["/usr/lib/wine/wine64", "/usr/bin/wine64", "/usr/bin/wine"];
const SERVERS: &[&str] = &["/usr/lib/wine/wineserver64", "/usr/bin/wineserver64", "/usr/bin/wineserver"];
/// What Wine lacks.
const SUPPLIED: &str = "xtask/platforms/bcryptprimitives.c";

pub fn program() -> Option<&'static str> {
    PROGRAMS.iter().copied().find(|path| Path::new(path).exists())
}

pub struct Wine<'a> {
    pub program: &'static str,
    workspace: &'a Workspace,
    server: &'static str,
    supplied: PathBuf,
    display: Child,
    _environment: [PushEnv<'a>; 3],
}

impl<'a> Wine<'a> {
    pub fn start(workspace: &'a Workspace) -> Result<Self> {
        let program = program().context("Wine is not installed")?;
        let server = SERVERS.iter().copied().find(|path| Path::new(path).exists()).context("Wine has no wineserver")?;
        let (sh, folder) = (&workspace.shell, workspace.target.join("wine"));
        let supplied = folder.join("supplied");
        empty_directory(&folder)?;
        empty_directory(&supplied)?;
        empty_directory(&folder.join("prefix"))?;
        let (gcc, source) = (Target::other(WINDOWS).gnu("gcc"), workspace.path(SUPPLIED));
        let library = supplied.join("bcryptprimitives.dll");
        cmd!(sh, "{gcc} -shared {source} -o {library} -ladvapi32").quiet().run()?;
        let (display, number) = display()?;
        let environment = [
            sh.push_env("WINEPREFIX", folder.join("prefix")),
            sh.push_env("WINEDEBUG", "-all"),
            sh.push_env("DISPLAY", format!(":{number}")),
        ];
        let wine = Self { program, workspace, server, supplied, display, _environment: environment };
        // Otherwise a test would start the server, which keeps the pipe of the test's output open after its end.
        cmd!(sh, "{server} --persistent").quiet().run()?;
        // Without the windows that offer to install Mono and Gecko.
        cmd!(sh, "{program} wineboot --init").env("WINEDLLOVERRIDES", "mscoree,mshtml=").quiet().run()?;
        Ok(wine)
    }

    /// Programs find the libraries of these folders while the result lives.
    pub fn libraries(&self, folders: &[&Path]) -> PushEnv<'a> {
        let folders = folders.iter().copied().chain([&*self.supplied]);
        let path: Vec<String> = folders.map(|folder| format!("Z:{}", folder.display())).collect();
        self.workspace.shell.push_env("WINEPATH", path.join(";"))
    }
}

impl Drop for Wine<'_> {
    fn drop(&mut self) {
        let server = self.server;
        let _ = cmd!(self.workspace.shell, "{server} --kill").quiet().ignore_stderr().run();
        let _ = self.display.kill();
        let _ = self.display.wait();
    }
}

/// Starts a display, and returns its number.
pub fn display() -> Result<(Child, String)> {
    let mut server = Command::new("Xvfb");
    let server = server.args(["-displayfd", "1", "-nolisten", "tcp"]).stdin(Stdio::null()).stderr(Stdio::null());
    let mut child = server.stdout(Stdio::piped()).spawn().context("starting Xvfb")?;
    let mut number = String::new();
    BufReader::new(child.stdout.take().context("Xvfb has an output")?).read_line(&mut number)?;
    Ok((child, number.trim().to_owned()))
}
