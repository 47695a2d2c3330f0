//! Files are written beside their place and renamed into it: nobody ever sees half of one.

use anyhow::{Context, Result, bail};
use indicatif::{ProgressBar, ProgressStyle};
use std::{
    fs::{self, File},
    io::Write,
    path::{Path, PathBuf},
    time::Duration,
};

/// A file to come. Its place is tried before the long work starts, and left as it was unless [`Output::commit`] succeeds.
pub struct Output {
    path: PathBuf,
    temporary: PathBuf,
    file: File,
}

impl Output {
    pub fn create(path: &Path) -> Result<Output> {
        let shown = path.display();
        if path.is_dir() {
            bail!("cannot write {shown}: it is a directory; name a file");
        }
        let Some(name) = path.file_name() else { bail!("cannot write '{shown}': it names no file") };
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

    /// Writes everything, but not yet in its place.
    pub fn fill(&mut self, bytes: &[u8]) -> Result<()> {
        let written = self.file.write_all(bytes).and_then(|()| self.file.sync_all());
        written.with_context(|| format!("cannot write {}", self.path.display()))
    }

    /// Puts what was written in its place.
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

/// A bar for `steps` steps of long work; drawn on a terminal only.
pub fn progress(steps: usize) -> ProgressBar {
    let bar = ProgressBar::new(steps as u64);
    if let Ok(style) = ProgressStyle::with_template("{spinner} {msg:<24} {bar:32} {pos}/{len} {elapsed}") {
        bar.set_style(style);
    }
    bar.enable_steady_tick(Duration::from_millis(120));
    bar
}

/// A line on stderr; where there is no stderr, nobody wants it.
pub fn complain(line: &str) {
    let _ = writeln!(std::io::stderr(), "{line}");
}
