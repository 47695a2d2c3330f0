//! What many stages do with files and folders. Errors name the path.

use std::fs;
use std::path::{Path, PathBuf};

use anyhow::{Context, Result, ensure};

use crate::workspace::{git, sh};

/// The folder, emptied or created.
pub fn empty<P: AsRef<Path>>(folder: P) -> Result<P> {
    sh().remove_path(&folder)?;
    make(&folder)?;
    Ok(folder)
}

pub fn make(folder: impl AsRef<Path>) -> Result<()> {
    sh().create_dir(folder)?;
    Ok(())
}

pub fn announce(file: &Path) -> Result<()> {
    println!("{} ({:.1} MB)", file.display(), fs::metadata(file)?.len() as f64 / 1e6);
    Ok(())
}

/// The files below a folder in order, without symbolic links.
pub fn files(folder: impl AsRef<Path>) -> Result<Vec<PathBuf>> {
    let (folder, mut found) = (folder.as_ref(), Vec::new());
    for entry in fs::read_dir(folder).with_context(|| format!("reading {}", folder.display()))? {
        let entry = entry?;
        let kind = entry.file_type()?;
        if kind.is_dir() {
            found.extend(files(entry.path())?);
        } else if kind.is_file() {
            found.push(entry.path());
        }
    }
    found.sort();
    Ok(found)
}

/// Those of them whose names end with one of these extensions.
pub fn files_of(folder: impl AsRef<Path>, extensions: &[&str]) -> Result<Vec<PathBuf>> {
    let mut found = files(folder)?;
    found.retain(|file| file.extension().is_some_and(|own| extensions.iter().any(|extension| own == *extension)));
    Ok(found)
}

/// A path relative to a folder, with slashes on every system.
pub fn within(folder: &Path, path: &Path) -> Result<String> {
    let inner =
        path.strip_prefix(folder).with_context(|| format!("{} is not in {}", path.display(), folder.display()))?;
    Ok(inner.iter().map(|part| part.to_string_lossy()).collect::<Vec<_>>().join("/"))
}

pub fn bytes(path: impl AsRef<Path>) -> Result<Vec<u8>> {
    Ok(sh().read_binary_file(path)?)
}

/// The text of a file, with one kind of line ends.
pub fn read(path: impl AsRef<Path>) -> Result<String> {
    Ok(String::from_utf8_lossy(&bytes(path)?).replace("\r\n", "\n"))
}

/// Writes a file, and makes the folder for it.
pub fn write(path: impl AsRef<Path>, contents: impl AsRef<[u8]>) -> Result<()> {
    Ok(sh().write_file(path, contents)?)
}

/// A page has `text` between two passages. With `fix` it gets it.
pub fn passage(fix: bool, page: &str, [begin, end]: [&str; 2], text: &str) -> Result<()> {
    let whole = read(page)?;
    let (before, rest) = whole.split_once(begin).with_context(|| format!("{page} lacks the lines {begin:?}"))?;
    let (_, after) = rest.split_once(end).with_context(|| format!("{page} lacks the lines {end:?}"))?;
    renew(fix, page, &whole, &[before, begin, text, end, after].concat())
}

/// A page is as it should be, or becomes so.
pub fn renew(fix: bool, page: &str, whole: &str, right: &str) -> Result<()> {
    if whole != right && fix {
        return write(page, right);
    }
    let line = whole.lines().zip(right.lines()).find(|(one, other)| one != other);
    ensure!(whole == right, "{page} is out of date: {line:?}; type: cargo xtask repo --fix");
    Ok(())
}

pub fn name(path: &Path) -> Result<String> {
    let name = path.file_name().with_context(|| format!("{} has no file name", path.display()))?;
    Ok(name.to_string_lossy().into_owned())
}

/// Copies a file, and makes the folder for it.
pub fn copy(from: impl AsRef<Path>, to: &Path) -> Result<()> {
    make(to.parent().context("files lie in folders")?)?;
    // A running program keeps the old file: overwriting it would change the program's memory.
    sh().remove_path(to)?;
    Ok(sh().copy_file(from, to)?)
}

pub fn copy_into(file: impl AsRef<Path>, folder: &Path) -> Result<()> {
    copy(&file, &folder.join(name(file.as_ref())?))
}

/// Copies the files of a folder into another, with the folders between.
pub fn copy_tree(from: impl AsRef<Path>, to: &Path) -> Result<()> {
    let from = from.as_ref();
    files(from)?.iter().try_for_each(|file| copy(file, &to.join(within(from, file)?)))
}

/// Copies those files of `parts` of a folder into another that git does not ignore.
pub fn copy_sources(folder: &str, parts: &[&str], to: &Path) -> Result<()> {
    let list = ["-C", folder, "ls-files", "--cached", "--others", "--exclude-standard", "--"];
    let listed = git(&[&list[..], parts].concat())?;
    listed.lines().try_for_each(|name| copy(Path::new(folder).join(name), &to.join(name)))
}

pub fn copy_licenses(to: &Path) -> Result<()> {
    ["LICENSE-MIT", "LICENSE-APACHE"].iter().try_for_each(|license| copy_into(license, to))
}
