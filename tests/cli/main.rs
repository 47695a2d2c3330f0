//! The `crumple` command, run as a user runs it: its reports, its messages for bad input, and files as people have them.

mod commands;
mod compare;
mod errors;
mod files;
mod sweep;

use std::path::{Path, PathBuf};
use std::process::{Command, Output};
use tempfile::TempDir;

pub const PANEL: &str = "assets/solver/panel.glb";

/// The result of a run of the command.
pub struct Run {
    pub code: Option<i32>,
    pub stdout: String,
    pub stderr: String,
}

/// Runs `crumple` with these arguments in the repository's root.
pub fn crumple(arguments: &[&str]) -> Run {
    crumple_in(Path::new(env!("CARGO_MANIFEST_DIR")), arguments)
}

/// The same in a folder.
pub fn crumple_in(folder: &Path, arguments: &[&str]) -> Run {
    let command = Command::new(env!("CARGO_BIN_EXE_crumple")).args(arguments).current_dir(folder).output();
    let Output { status, stdout, stderr } = command.expect("the command starts");
    let text = |bytes| String::from_utf8(bytes).expect("UTF-8");
    Run { code: status.code(), stdout: text(stdout), stderr: text(stderr) }
}

impl Run {
    pub fn is_good(&self) -> bool {
        self.code == Some(0)
    }

    /// All that it printed.
    pub fn text(&self) -> String {
        [&*self.stdout, &*self.stderr].concat()
    }

    /// The report of a run, which must have succeeded.
    #[track_caller]
    pub fn report(self) -> String {
        assert_eq!(self.code, Some(0), "{}", self.stderr);
        assert_eq!(self.stderr, "", "nothing on stderr where it is no terminal");
        self.stdout
    }

    /// The one-line message of a run, which must have failed.
    #[track_caller]
    pub fn complaint(self) -> String {
        assert_eq!(self.code, Some(1), "{}", self.stderr);
        assert_eq!(self.stdout, "");
        let line = self.stderr.strip_suffix('\n').expect("a line");
        assert!(!line.contains('\n') && !line.contains("panicked"), "{line}");
        line.strip_prefix("error: ").expect("error: …").to_owned()
    }
}

/// A temporary folder for a test's files.
pub struct Folder(TempDir);

impl Folder {
    pub fn empty() -> Folder {
        Folder(tempfile::tempdir().expect("a directory"))
    }

    /// The path of a file in the folder.
    pub fn at(&self, name: &str) -> String {
        self.0.path().join(name).to_str().expect("UTF-8").to_owned()
    }

    /// Writes a file and returns its path.
    pub fn write(&self, name: &str, bytes: impl AsRef<[u8]>) -> String {
        std::fs::write(self.at(name), bytes).expect("written");
        self.at(name)
    }

    pub fn names(&self) -> Vec<String> {
        names(self.0.path())
    }
}

/// Asserts that a text has all these parts.
#[track_caller]
pub fn has(text: &str, parts: &[&str]) {
    for part in parts {
        assert!(text.contains(part), "'{part}' is not in: {text}");
    }
}

/// The path of a file of the repository.
pub fn asset(path: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join(path)
}

/// The names in a directory, sorted.
pub fn names(folder: &Path) -> Vec<String> {
    let mut names: Vec<String> = std::fs::read_dir(folder)
        .expect("readable")
        .map(|e| e.expect("entry").file_name().into_string().expect("UTF-8"))
        .collect();
    names.sort();
    names
}
