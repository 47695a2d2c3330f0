//! Packs a folder by git, which keeps of files what an archive should: their contents, their order, and whether they are programs.

use std::path::Path;

use anyhow::{Context, Result};

use crate::files::{announce, make, name};
use crate::workspace::{git, run, said, sh};

/// Packs `folder` under its own name into a `.zip` or a `.tar.gz`. The bytes depend on the contents and the time alone.
pub fn write(folder: &Path, path: &Path) -> Result<()> {
    make(path.parent().context("archives lie in folders")?)?;
    write_at(folder, path, time()?)?;
    announce(path)
}

/// The modification time of every entry: `SOURCE_DATE_EPOCH`, or the time of the commit, s since 1970.
fn time() -> Result<u64> {
    let seconds = std::env::var("SOURCE_DATE_EPOCH").or_else(|_| git(&["log", "-1", "--format=%ct"]))?;
    seconds.trim().parse().with_context(|| format!("SOURCE_DATE_EPOCH is {seconds:?}; it must be seconds since 1970"))
}

fn write_at(folder: &Path, path: &Path, time: u64) -> Result<()> {
    let (store, prefix) = (tempfile::tempdir()?, format!("--prefix={}/", name(folder)?));
    let (out, date) = (format!("--output={}", path.display()), format!("@{time} +0000"));
    let _there = sh().push_dir(folder);
    let environment = [
        ("GIT_CONFIG_GLOBAL", "/dev/null"),
        ("GIT_CONFIG_NOSYSTEM", "1"),
        ("TZ", "UTC"),
        ("GIT_AUTHOR_NAME", "nobody"),
        ("GIT_AUTHOR_EMAIL", ""),
        ("GIT_AUTHOR_DATE", &date),
        ("GIT_COMMITTER_NAME", "nobody"),
        ("GIT_COMMITTER_EMAIL", ""),
        ("GIT_COMMITTER_DATE", &date),
    ];
    let _environment = environment.map(|(name, value)| sh().push_env(name, value));
    let _place = [sh().push_env("GIT_DIR", store.path()), sh().push_env("GIT_WORK_TREE", folder)];
    run!("git init --quiet")?;
    run!("git add --all --force .")?;
    let tree = said!("git write-tree")?;
    let commit = said!("git commit-tree {tree} -m packed")?;
    run!("git -c tar.umask=022 archive {prefix} {out} {commit}")
}

#[cfg(test)]
mod tests {
    use std::fs;

    use super::*;

    #[test]
    fn the_same_files_made_in_another_order_and_elsewhere_give_the_same_bytes() {
        for extension in ["zip", "tar.gz"] {
            let packed = |names: [&str; 4]| {
                let scratch = tempfile::tempdir().unwrap();
                let (folder, path) = (scratch.path().join("crumple-9"), scratch.path().join(extension));
                for name in names {
                    let file = folder.join(name);
                    fs::create_dir_all(file.parent().unwrap()).unwrap();
                    fs::write(file, name.repeat(1000) + "\r\n").unwrap();
                }
                let path = path.with_file_name(format!("archive.{extension}"));
                write_at(&folder, &path, 1_000_000_000).unwrap();
                fs::read(path).unwrap()
            };
            let one = packed(["b", "a/c", "a/.b", "a-b"]);
            assert!(one == packed(["a-b", "a/.b", "b", "a/c"]), "{extension}");
            // 01:46:40 on the 9th of September 2001, as the first entry of a ZIP file has it.
            assert!(extension != "zip" || one[10..14] == [0xD4, 0x0D, 0x29, 0x2B]);
        }
    }
}
