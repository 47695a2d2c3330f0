//! Writes files under a temporary name and renames them when they are complete.

use anyhow::{Context, Result, bail};
use indicatif::{ProgressBar, ProgressStyle};
use std::fs::{self, File};
use std::io::Write;
use std::path::{Path, PathBuf};
use std::time::Duration;

/// A file that is written under a temporary name. Creating it before the long work starts shows whether the destination
/// can be written. The destination does not change unless [`Output::commit`] succeeds.
pub struct Output {
    path: PathBuf,
    temporary: PathBuf,
    file: File,
}

impl Output {
    /// Creates an output for a command that writes one format only; the path must have that format's ending.
    pub fn create_as(path: &Path, ending: &str, format: &str) -> Result<Output> {
        if path.extension().is_some_and(|e| e.eq_ignore_ascii_case(ending)) {
            return Output::create(path);
        }
        bail!("cannot write {}: this command writes {format}; name a file that ends in .{ending}", path.display());
    }

    pub fn create(path: &Path) -> Result<Output> {
        let shown = path.display();
        if path.is_dir() {
            bail!("cannot write {shown}: it is a directory; name a file");
        }
        let Some(name) = path.file_name() else { bail!("cannot write '{shown}': it is not the name of a file") };
        let folder = match path.parent() {
            Some(p) if !p.as_os_str().is_empty() => p,
            _ => Path::new("."),
        };
        if !folder.is_dir() {
            bail!("cannot write {shown}: there is no directory {}", folder.display());
        }
        let mut hidden = std::ffi::OsString::from(".");
        hidden.push(name);
        hidden.push(format!(".{}.part", std::process::id()));
        let temporary = folder.join(hidden);
        let file = File::create(&temporary).with_context(|| format!("cannot write {shown}"))?;
        Ok(Output { path: path.to_owned(), temporary, file })
    }

    /// Writes the bytes under the temporary name.
    pub fn fill(&mut self, bytes: &[u8]) -> Result<()> {
        let written = self.file.write_all(bytes).and_then(|()| self.file.sync_all());
        written.with_context(|| format!("cannot write {}", self.path.display()))
    }

    /// Renames the file into its place.
    pub fn commit(self) -> Result<()> {
        fs::rename(&self.temporary, &self.path).with_context(|| format!("cannot write {}", self.path.display()))
    }
}

impl Drop for Output {
    fn drop(&mut self) {
        // After a commit there is nothing left to remove.
        let _ = fs::remove_file(&self.temporary);
    }
}

/// A progress bar of `steps` steps, drawn only on a terminal.
pub fn progress(steps: usize) -> ProgressBar {
    let bar = ProgressBar::new(steps as u64);
    if let Ok(style) = ProgressStyle::with_template("{spinner} {msg:<24} {bar:32} {pos}/{len} {elapsed}") {
        bar.set_style(style);
    }
    bar.enable_steady_tick(Duration::from_millis(120));
    bar
}

/// Writes a line to stderr, if it exists.
pub fn complain(line: &str) {
    let _ = writeln!(std::io::stderr(), "{line}");
}

/// Prints a report. It is no error if the reader has closed the pipe (`| head`).
pub fn print(text: &str) -> Result<()> {
    match std::io::stdout().lock().write_all(text.as_bytes()) {
        Err(e) if e.kind() != std::io::ErrorKind::BrokenPipe => Err(e.into()),
        _ => Ok(()),
    }
}
