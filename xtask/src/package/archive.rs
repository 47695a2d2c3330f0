//! Packs a folder. The archive's bytes depend on the folder's contents and a time alone: entries are sorted and have no owner.

use std::fs::{self, File};
use std::io::{BufWriter, Write};
use std::path::{Path, PathBuf};

use anyhow::{Context, Result};
use flate2::{Compression, GzBuilder};
use tar::{EntryType, Header};
use zip::write::SimpleFileOptions;

use super::within;
use crate::target::Target;

/// Packs `folder` under its own name into `out/NAME.tar.gz`, or `.zip` on Windows.
pub fn pack(folder: &Path, out: &Path, time: u64, target: &Target) -> Result<PathBuf> {
    let name = folder.file_name().context("folders have names")?.to_string_lossy();
    let path = out.join(format!("{name}.{}", if target.is_windows() { "zip" } else { "tar.gz" }));
    let file = File::create(&path).with_context(|| format!("creating {}", path.display()))?;
    let written = if target.is_windows() { zip(folder, file) } else { tar_gz(folder, file, time) };
    written.with_context(|| format!("packing {}", path.display()))?;
    Ok(path)
}

enum Kind {
    Folder,
    File { executable: bool },
    Link(PathBuf),
}

/// Everything below a folder, sorted by name as bytes. A folder comes before its contents.
fn entries(folder: &Path) -> Result<Vec<(PathBuf, Kind)>> {
    let mut found = Vec::new();
    for entry in fs::read_dir(folder).with_context(|| format!("reading {}", folder.display()))? {
        let path = entry?.path();
        let metadata = fs::symlink_metadata(&path)?;
        if metadata.is_dir() {
            found.extend(entries(&path)?);
            found.push((path, Kind::Folder));
        } else if metadata.is_symlink() {
            let to = fs::read_link(&path)?;
            found.push((path, Kind::Link(to)));
        } else {
            found.push((path, Kind::File { executable: executable(&metadata) }));
        }
    }
    found.sort_by_cached_key(|(path, _)| within(folder, path).unwrap_or_default());
    Ok(found)
}

#[cfg(unix)]
fn executable(metadata: &fs::Metadata) -> bool {
    std::os::unix::fs::PermissionsExt::mode(&metadata.permissions()) & 0o100 != 0
}

#[cfg(windows)]
fn executable(_: &fs::Metadata) -> bool {
    false
}

fn tar_gz(folder: &Path, file: File, time: u64) -> Result<()> {
    let above = folder.parent().context("the folder lies somewhere")?;
    let compressed = GzBuilder::new().mtime(0).write(BufWriter::new(file), Compression::default());
    let mut archive = tar::Builder::new(compressed);
    let mut all = entries(folder)?;
    all.insert(0, (folder.to_path_buf(), Kind::Folder));
    for (path, kind) in all {
        let name = within(above, &path)?;
        let mut header = Header::new_gnu();
        header.set_mtime(time);
        header.set_uid(0);
        header.set_gid(0);
        header.set_size(0);
        match kind {
            Kind::Folder => {
                header.set_entry_type(EntryType::Directory);
                header.set_mode(0o755);
                archive.append_data(&mut header, format!("{name}/"), std::io::empty())?;
            }
            Kind::Link(to) => {
                header.set_entry_type(EntryType::Symlink);
                header.set_mode(0o777);
                archive.append_link(&mut header, name, to)?;
            }
            Kind::File { executable } => {
                let bytes = fs::read(&path)?;
                header.set_size(bytes.len() as u64);
                header.set_mode(if executable { 0o755 } else { 0o644 });
                archive.append_data(&mut header, name, &*bytes)?;
            }
        }
    }
    archive.into_inner()?.finish()?.flush()?;
    Ok(())
}

/// Every entry has the format's first time, in 1980: the format has no time zones.
pub fn zip(folder: &Path, file: File) -> Result<()> {
    let above = folder.parent().context("the folder lies somewhere")?;
    let mut archive = zip::ZipWriter::new(BufWriter::new(file));
    for (path, kind) in entries(folder)? {
        let mode = if matches!(kind, Kind::File { executable: true }) { 0o755 } else { 0o644 };
        let options = SimpleFileOptions::default().unix_permissions(mode).last_modified_time(zip::DateTime::default());
        let name = within(above, &path)?;
        match kind {
            Kind::Folder => archive.add_directory(name, options)?,
            // Archives for Windows hold the file in place of a link.
            Kind::Link(_) | Kind::File { .. } => {
                archive.start_file(name, options)?;
                archive.write_all(&fs::read(&path)?)?;
            }
        }
    }
    archive.finish()?.flush()?;
    Ok(())
}

#[cfg(test)]
mod tests {
    use std::io::Read;

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

    fn packed(write: impl Fn(&Path, File) -> Result<()>, names: &[&str]) -> Vec<u8> {
        let scratch = tempfile::tempdir().unwrap();
        let path = scratch.path().join("archive");
        write(&folder(scratch.path(), names), File::create(&path).unwrap()).unwrap();
        fs::read(path).unwrap()
    }

    fn tar(folder: &Path, file: File) -> Result<()> {
        tar_gz(folder, file, 1_000_000_000)
    }

    #[test]
    fn the_order_of_files_on_disk_is_not_seen() {
        let (one, other) = (["b", "a/c", "a/b", "a-b"], ["a-b", "a/b", "b", "a/c"]);
        assert_eq!(packed(tar, &one), packed(tar, &other));
        assert_eq!(packed(zip, &one), packed(zip, &other));
    }

    #[test]
    fn entries_come_in_order_and_are_nobodys() {
        let bytes = packed(tar, &["b", "a/b", "a-b", &("long/".repeat(40) + "file")]);
        let mut archive = ::tar::Archive::new(flate2::read::GzDecoder::new(&*bytes));
        let mut names = Vec::new();
        for entry in archive.entries().unwrap() {
            let mut entry = entry.unwrap();
            let header = entry.header();
            assert_eq!((header.uid().unwrap(), header.gid().unwrap(), header.mtime().unwrap()), (0, 0, 1_000_000_000));
            let name = entry.path().unwrap().to_string_lossy().into_owned();
            let mut text = String::new();
            entry.read_to_string(&mut text).unwrap();
            let inner = name.trim_start_matches("crumple-9/");
            assert!(name.ends_with('/') || text == inner.repeat(1000), "{name}");
            names.push(name);
        }
        assert_eq!(names[..5], ["crumple-9/", "crumple-9/a/", "crumple-9/a-b", "crumple-9/a/b", "crumple-9/b"]);
    }

    #[test]
    fn a_zip_holds_the_files() {
        let bytes = packed(zip, &["b", "a/c"]);
        let mut archive = zip::ZipArchive::new(std::io::Cursor::new(bytes)).unwrap();
        let names: Vec<_> = archive.file_names().map(|name| name.unwrap().into_owned()).collect();
        assert_eq!(names, ["crumple-9/a/", "crumple-9/a/c", "crumple-9/b"]);
        let mut text = String::new();
        archive.by_name("crumple-9/a/c").unwrap().read_to_string(&mut text).unwrap();
        assert_eq!(text, "a/c".repeat(1000));
    }
}
