//! Packs a folder. The archive's bytes depend on the folder's contents and a time alone: entries are sorted and have no owner.

use std::fs::{self, File};
use std::io::{BufWriter, Write};
use std::path::{Path, PathBuf};

use anyhow::{Context, Result};
use flate2::{Compression, GzBuilder};
use tar::{Header, HeaderMode};
use zip::write::SimpleFileOptions;

use crate::files::{bytes, name, within};
use crate::target::Target;

/// Packs `folder` under its own name into `out/NAME.tar.gz`, or `.zip` on Windows.
pub fn pack(folder: &Path, out: &Path, time: u64, target: &Target) -> Result<PathBuf> {
    let (name, windows) = (name(folder)?, target.is_windows());
    let path = out.join(format!("{name}.{}", if windows { "zip" } else { "tar.gz" }));
    if windows {
        zip(folder, &path)?
    } else {
        tar_gz(folder, &path, time)?
    }
    Ok(path)
}

/// Everything below a folder, sorted by name as bytes. A folder comes before its contents.
fn entries(folder: &Path) -> Result<Vec<(PathBuf, fs::Metadata)>> {
    let mut found = Vec::new();
    for entry in fs::read_dir(folder).with_context(|| format!("reading {}", folder.display()))? {
        let path = entry?.path();
        let metadata = fs::symlink_metadata(&path)?;
        if metadata.is_dir() {
            found.extend(entries(&path)?);
        }
        found.push((path, metadata));
    }
    found.sort_by_cached_key(|(path, _)| within(folder, path).unwrap_or_default());
    Ok(found)
}

/// The kind, the size, and a mode of 644, or 755 for folders and programs. Nobody's.
fn header(metadata: &fs::Metadata) -> Header {
    let mut header = Header::new_gnu();
    header.set_metadata_in_mode(metadata, HeaderMode::Deterministic);
    header
}

fn create(path: &Path) -> Result<BufWriter<File>> {
    Ok(BufWriter::new(File::create(path).with_context(|| format!("creating {}", path.display()))?))
}

fn tar_gz(folder: &Path, path: &Path, time: u64) -> Result<()> {
    let above = folder.parent().context("the folder lies somewhere")?;
    let mut archive = tar::Builder::new(GzBuilder::new().mtime(0).write(create(path)?, Compression::default()));
    let own = [(folder.to_path_buf(), fs::metadata(folder)?)];
    for (path, metadata) in own.into_iter().chain(entries(folder)?) {
        let name = within(above, &path)?;
        let mut header = header(&metadata);
        header.set_mtime(time);
        if metadata.is_dir() {
            archive.append_data(&mut header, format!("{name}/"), std::io::empty())?;
        } else if metadata.is_symlink() {
            archive.append_link(&mut header, name, fs::read_link(&path)?)?;
        } else {
            archive.append_data(&mut header, name, File::open(&path)?)?;
        }
    }
    archive.into_inner()?.finish()?.flush()?;
    Ok(())
}

/// Packs `folder` under its own name into a file. Every entry has the format's first time, in 1980: the format has no time zones.
pub fn zip(folder: &Path, path: &Path) -> Result<()> {
    let above = folder.parent().context("the folder lies somewhere")?;
    let mut archive = zip::ZipWriter::new(create(path)?);
    for (path, metadata) in entries(folder)? {
        // Archives for Windows hold the file in place of a link.
        let mode = if metadata.is_file() { header(&metadata).mode()? } else { 0o644 };
        let options = SimpleFileOptions::default().unix_permissions(mode).last_modified_time(zip::DateTime::default());
        let name = within(above, &path)?;
        if metadata.is_dir() {
            archive.add_directory(name, options)?;
        } else {
            archive.start_file(name, options)?;
            archive.write_all(&bytes(&path)?)?;
        }
    }
    archive.finish()?.flush()?;
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The same files, made in another order, at another time, by another hand.
    fn folder(at: &Path, names: &[&str]) -> PathBuf {
        let folder = at.join("crumple-9");
        for name in names {
            let path = folder.join(name);
            fs::create_dir_all(path.parent().unwrap()).unwrap();
            fs::write(&path, name.repeat(1000)).unwrap();
        }
        folder
    }

    fn packed(write: impl Fn(&Path, &Path) -> Result<()>, names: &[&str]) -> Vec<u8> {
        let scratch = tempfile::tempdir().unwrap();
        let path = scratch.path().join("archive");
        write(&folder(scratch.path(), names), &path).unwrap();
        fs::read(path).unwrap()
    }

    fn tar(folder: &Path, path: &Path) -> Result<()> {
        tar_gz(folder, path, 1_000_000_000)
    }

    #[test]
    fn the_order_of_files_on_disk_is_not_seen() {
        let (one, other) = (["b", "a/c", "a/b", "a-b"], ["a-b", "a/b", "b", "a/c"]);
        assert_eq!(packed(tar, &one), packed(tar, &other));
        assert_eq!(packed(zip, &one), packed(zip, &other));
    }

    #[test]
    fn entries_come_in_order_and_are_nobodys() {
        let bytes = packed(tar, &["b", "a/b", "a-b"]);
        let mut archive = ::tar::Archive::new(flate2::read::GzDecoder::new(&*bytes));
        let mut names = Vec::new();
        for entry in archive.entries().unwrap().map(Result::unwrap) {
            let header = entry.header();
            assert_eq!((header.uid().unwrap(), header.gid().unwrap(), header.mtime().unwrap()), (0, 0, 1_000_000_000));
            names.push(entry.path().unwrap().to_string_lossy().into_owned());
        }
        assert_eq!(names, ["crumple-9/", "crumple-9/a/", "crumple-9/a-b", "crumple-9/a/b", "crumple-9/b"]);
    }
}
