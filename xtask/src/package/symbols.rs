//! Moves debug symbols out of the libraries and programs into a folder of their own.

use std::path::Path;

use anyhow::Result;
use xshell::cmd;

use super::Parts;
use crate::files::{copy_into, files, make, name, write};
use crate::workspace::Workspace;

const README: &str = "\
Debug symbols of the archive of the same name. gdb and lldb find `NAME.debug` beside the library NAME, or in a
folder `.debug` there. On macOS put `NAME.dSYM` beside it, on Windows `NAME.pdb`.
";

/// Strips the libraries and programs in `folder`, and leaves their symbols in `debug`.
pub fn separate(workspace: &Workspace, parts: &Parts, folder: &Path, debug: &Path) -> Result<()> {
    let (sh, target) = (&workspace.shell, &parts.library.target);
    let (strip, objcopy) = (target.gnu("strip"), target.gnu("objcopy"));
    make(debug)?;
    write(&debug.join("README.txt"), README)?;
    for file in files(folder)? {
        let name = name(&file)?;
        let program = file.parent().is_some_and(|parent| parent.ends_with("bin"));
        if target.is_windows() && !target.is_mingw() {
            // The compiler puts symbols into a file beside the library or program.
            let built = parts.library.shared.with_file_name(&name).with_extension("pdb");
            if program && built.exists() {
                copy_into(&built, debug)?;
            }
        } else if name.ends_with(".a") && !name.ends_with(".dll.a") {
            // A static library keeps its symbols and loses its line tables, which are ten times the rest.
            let flag = if target.is_macos() { "-S" } else { "--strip-debug" };
            let mut strip = strip.as_str();
            if target.is_mingw() {
                // rustup's standard library has empty members, which strip refuses.
                let members = cmd!(sh, "llvm-ar t {file}").quiet().read()?;
                let empty: Vec<&str> = members.lines().filter(|member| member.ends_with(".dwo")).collect();
                if !empty.is_empty() {
                    cmd!(sh, "llvm-ar d {file} {empty...}").quiet().run()?;
                }
                strip = "llvm-strip";
            }
            cmd!(sh, "{strip} {flag} {file}").quiet().run()?;
        } else if target.is_macos() && (program || name.ends_with(".dylib")) {
            let symbols = debug.join(format!("{name}.dSYM"));
            cmd!(sh, "dsymutil {file} -o {symbols}").quiet().run()?;
            cmd!(sh, "strip -x {file}").quiet().run()?;
        } else if program || name.contains(".so") {
            let symbols = debug.join(format!("{name}.debug"));
            cmd!(sh, "{objcopy} --only-keep-debug {file} {symbols}").quiet().run()?;
            cmd!(sh, "{strip} --strip-unneeded {file}").quiet().run()?;
            cmd!(sh, "{objcopy} --add-gnu-debuglink={symbols} {file}").quiet().run()?;
        }
    }
    Ok(())
}
