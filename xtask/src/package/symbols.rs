//! Moves debug symbols out of the libraries and programs into a folder of their own.

use std::path::Path;

use anyhow::Result;

use crate::files::{copy_into, files, make, name, write};
use crate::install::Built;
use crate::workspace::{run, said};

const README: &str = "\
Debug symbols of the archive of the same name. gdb and lldb find `NAME.debug` beside the library NAME, or in a
folder `.debug` there. On macOS put `NAME.dSYM` beside it, on Windows `NAME.pdb`.
";

/// Strips the libraries and programs in `folder`, and leaves their symbols in `debug`.
pub fn separate(built: &Built, folder: &Path, debug: &Path) -> Result<()> {
    let target = &built.target;
    let (strip, objcopy) = (target.gnu("strip"), target.gnu("objcopy"));
    make(debug)?;
    write(debug.join("README.txt"), README)?;
    for file in files(folder)? {
        let name = name(&file)?;
        let program = file.parent().is_some_and(|parent| parent.ends_with("bin"));
        if target.is_windows() && !target.is_mingw() {
            // The compiler puts symbols into a file beside the library or program.
            let built = built.shared.with_file_name(&name).with_extension("pdb");
            if program && built.exists() {
                copy_into(&built, debug)?;
            }
        } else if name.ends_with(".a") && !name.ends_with(".dll.a") {
            // A static library keeps its symbols and loses its line tables, which are ten times the rest.
            let flag = if target.is_macos() { "-S" } else { "--strip-debug" };
            let strip = if target.is_mingw() { "llvm-strip" } else { &strip };
            // rustup's standard library for MinGW has empty members, which strip refuses.
            let members = if target.is_mingw() { said!("llvm-ar t {file}")? } else { String::new() };
            let empty: Vec<&str> = members.lines().filter(|member| member.ends_with(".dwo")).collect();
            if !empty.is_empty() {
                run!("llvm-ar d {file} {empty...}")?;
            }
            run!("{strip} {flag} {file}")?;
        } else if target.is_macos() && (program || name.ends_with(".dylib")) {
            let symbols = debug.join(format!("{name}.dSYM"));
            run!("dsymutil {file} -o {symbols}")?;
            run!("strip -x {file}")?;
        } else if program || name.contains(".so") {
            let symbols = debug.join(format!("{name}.debug"));
            run!("{objcopy} --only-keep-debug {file} {symbols}")?;
            run!("{strip} --strip-unneeded {file}")?;
            run!("{objcopy} --add-gnu-debuglink={symbols} {file}")?;
        }
    }
    Ok(())
}
