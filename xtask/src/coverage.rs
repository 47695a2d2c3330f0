//! Which lines of `src` the fuzz targets reach: each target runs its corpus once, and binutils' addr2line names the lines of the
//! places where the compiler counts.

use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};

use anyhow::{Context, Result, ensure};
use xshell::cmd;

use crate::workspace::Workspace;

/// Whether any target reached a line, by file and line.
type Lines = BTreeMap<(PathBuf, u32), bool>;

/// Runs the corpus of each program, and prints for each room how many of the lines where the compiler counts were reached.
pub fn run(workspace: &Workspace, programs: &[(PathBuf, PathBuf)]) -> Result<()> {
    let mut lines = Lines::new();
    for (program, corpus) in programs {
        fs::create_dir_all(corpus)?;
        let places = corpus.with_extension("places");
        cmd!(workspace.shell, "{program}").env("CRUMPLE_SEEDS", corpus).env("CRUMPLE_COVERAGE", &places).run()?;
        add(workspace, program, &fs::read_to_string(&places)?, &mut lines)?;
    }
    let mut rooms: BTreeMap<PathBuf, (usize, usize)> = BTreeMap::new();
    for ((file, _), reached) in &lines {
        let room = file.parent().filter(|room| room != &Path::new("")).unwrap_or(Path::new("."));
        let top = room.components().next().context("a folder has a name")?;
        for key in [PathBuf::from(top.as_os_str()), PathBuf::from("all")] {
            let (hit, all) = rooms.entry(key).or_default();
            (*hit, *all) = (*hit + usize::from(*reached), *all + 1);
        }
    }
    println!("| room | lines reached | lines where the compiler counts | |\n|---|---|---|---|");
    for (room, (hit, all)) in rooms {
        println!("| `{}` | {hit} | {all} | {:.0} % |", room.display(), 100.0 * hit as f64 / all as f64);
    }
    Ok(())
}

/// Adds a target's places that lie in `src`.
fn add(workspace: &Workspace, program: &Path, places: &str, lines: &mut Lines) -> Result<()> {
    let (addresses, reached): (Vec<&str>, Vec<bool>) =
        places.lines().filter_map(|line| line.split_once(' ')).map(|(address, hit)| (address, hit == "1")).unzip();
    let named = cmd!(workspace.shell, "addr2line -e {program}").stdin(addresses.join("\n")).read()?;
    ensure!(named.lines().count() == reached.len(), "addr2line named another number of lines");
    let source = workspace.path("src");
    for (line, reached) in named.lines().zip(reached) {
        // FILE:LINE, and sometimes " (discriminator 2)".
        let Some((file, number)) = line.split(' ').next().and_then(|place| place.rsplit_once(':')) else { continue };
        let (Ok(file), Ok(number)) = (Path::new(file).strip_prefix(&source), number.parse()) else { continue };
        *lines.entry((file.to_owned(), number)).or_default() |= reached;
    }
    Ok(())
}
