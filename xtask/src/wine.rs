//! Wine, which runs programs for Windows. It has a folder of its own below the target directory, and a display without a
//! screen. Its server and the display end with the stage.

use std::path::{Path, PathBuf};

use anyhow::{Context, Result};
use xshell::PushEnv;

use crate::files::{empty, make};
use crate::target::{Target, WINDOWS};
use crate::workspace::{Display, cmd, in_target, run, sh};

/// Where distributions put it. Debian has it outside of PATH.
pub const PROGRAMS: &[&str] = &["/usr/lib/wine/wine64", "/usr/bin/wine64", "/usr/bin/wine"];
const SERVERS: &[&str] = &["/usr/lib/wine/wineserver64", "/usr/bin/wineserver64", "/usr/bin/wineserver"];
/// What Wine lacks.
const SUPPLIED: &str = "xtask/platforms/bcryptprimitives.c";

pub struct Wine {
    pub program: &'static str,
    server: &'static str,
    supplied: PathBuf,
    _display: Display,
    _environment: [PushEnv<'static>; 2],
}

impl Wine {
    pub fn start() -> Result<Self> {
        let first = |paths: &[&'static str]| paths.iter().copied().find(|path| Path::new(path).exists());
        let program = first(PROGRAMS).context("Wine is not installed")?;
        let server = first(SERVERS).context("Wine has no wineserver")?;
        let folder = empty(in_target("wine"))?;
        let (gcc, supplied) = (Target::other(WINDOWS).gnu("gcc"), empty(folder.join("supplied"))?);
        make(folder.join("prefix"))?;
        run!("{gcc} -shared {SUPPLIED} -o {supplied}/bcryptprimitives.dll -ladvapi32")?;
        let environment = [sh().push_env("WINEPREFIX", folder.join("prefix")), sh().push_env("WINEDEBUG", "-all")];
        let wine = Self { program, server, supplied, _display: Display::start()?, _environment: environment };
        // Otherwise a test would start the server, which keeps the pipe of the test's output open after its end.
        run!("{server} --persistent")?;
        // Without the windows that offer to install Mono and Gecko.
        cmd!("{program} wineboot --init").env("WINEDLLOVERRIDES", "mscoree,mshtml=").quiet().run()?;
        Ok(wine)
    }

    /// Programs find the libraries of these folders while the result lives.
    pub fn libraries(&self, folders: &[&Path]) -> PushEnv<'static> {
        let folders = folders.iter().copied().chain([&*self.supplied]);
        let path: Vec<String> = folders.map(|folder| format!("Z:{}", folder.display())).collect();
        sh().push_env("WINEPATH", path.join(";"))
    }
}

impl Drop for Wine {
    fn drop(&mut self) {
        let server = self.server;
        let _ = cmd!("{server} --kill").quiet().ignore_stderr().run();
    }
}
