//! The inputs in `fuzz/corpus`, with which every run of the fuzzer begins: those of a large corpus that reach most new code for
//! their size.

use std::collections::HashMap;
use std::fs;
use std::path::Path;

use anyhow::{Context, Result};
use xshell::cmd;

use crate::files::{copy_into, empty_directory, read};
use crate::workspace::Workspace;

/// Bytes and files for each target. Every clone carries them.
const LIMIT: u64 = 30_000;
const FILES: u32 = 64;

/// Replaces the inputs of a target in `kept` by some of `corpus`.
pub fn keep(workspace: &Workspace, program: &Path, corpus: &Path, kept: &Path) -> Result<()> {
    let (merged, control) = (corpus.with_extension("merged"), corpus.with_extension("control"));
    empty_directory(&merged)?;
    let _ = fs::remove_file(&control);
    cmd!(workspace.shell, "{program} -merge=1 -merge_control_file={control} {merged} {corpus}").quiet().run()?;
    let text = read(&control).context("libFuzzer's control file")?;
    let mut best: Vec<(u64, u64, &str)> = new_code(&text)
        .into_iter()
        .map(|(file, edges)| Ok((fs::metadata(file)?.len().max(1), edges, file)))
        .collect::<Result<_>>()?;
    best.sort_by_key(|(size, edges, file)| (std::cmp::Reverse(edges * LIMIT / size), *file));
    empty_directory(kept)?;
    let (mut total, mut files) = (0, 0);
    for (size, _, file) in best {
        if total + size <= LIMIT && files < FILES {
            (total, files) = (total + size, files + 1);
            copy_into(Path::new(file), kept)?;
        }
    }
    println!("{} holds {files} files of {total} bytes", kept.display());
    Ok(())
}

/// The files of a control file, each with the number of edges that no smaller file reaches.
fn new_code(control: &str) -> HashMap<&str, u64> {
    let files: Vec<&str> = control.lines().skip(2).take_while(|line| !line.starts_with("STARTED ")).collect();
    let edges = |line: &'_ str| {
        let mut words = line.strip_prefix("COV ")?.split(' ');
        Some((words.next()?.parse::<usize>().ok()?, words.count() as u64))
    };
    control.lines().filter_map(edges).filter_map(|(i, n)| Some((*files.get(i)?, n))).filter(|(_, n)| *n > 0).collect()
}

#[cfg(test)]
mod tests {
    #[test]
    fn files_with_new_edges_are_found_in_a_control_file() {
        let control = "2\n0\na\nb\nSTARTED 0 5\nFT 0 1 2\nCOV 0 7 8\nSTARTED 1 6\nFT 1 3\nCOV 1\n";
        assert_eq!(super::new_code(control).into_iter().collect::<Vec<_>>(), [("a", 2)]);
    }
}
