//! A scratch folder and the command to run in it.

use std::path::{Path, PathBuf};
use std::process::{Command, Output};

/// A folder that is deleted when the test ends.
pub(crate) struct Scratch {
    dir: tempfile::TempDir,
}

/// What a command printed, and how it ended.
pub(crate) struct Ran {
    pub(crate) code: i32,
    pub(crate) out: String,
    pub(crate) err: String,
}

impl Scratch {
    pub(crate) fn new() -> Self {
        Self {
            dir: tempfile::tempdir().expect("a temporary folder"),
        }
    }

    pub(crate) fn path(&self, name: &str) -> PathBuf {
        self.dir.path().join(name)
    }

    pub(crate) fn write(&self, name: &str, bytes: impl AsRef<[u8]>) -> PathBuf {
        let path = self.path(name);
        std::fs::write(&path, bytes).expect("writing into the temporary folder");
        path
    }

    pub(crate) fn read(&self, name: &str) -> String {
        std::fs::read_to_string(self.path(name)).unwrap_or_else(|e| panic!("{name}: {e}"))
    }

    /// Runs `foveasim` with these words in the folder.
    pub(crate) fn run(&self, words: &[&str]) -> Ran {
        let Output {
            status,
            stdout,
            stderr,
        } = Command::new(env!("CARGO_BIN_EXE_foveasim"))
            .args(words)
            .current_dir(self.dir.path())
            .output()
            .expect("the binary runs");
        Ran {
            code: status.code().expect("it exits by itself"),
            out: String::from_utf8(stdout).expect("UTF-8 output"),
            err: String::from_utf8(stderr).expect("UTF-8 errors"),
        }
    }

    /// As [`Scratch::run`], for a command that must succeed.
    pub(crate) fn ok(&self, words: &[&str]) -> String {
        let ran = self.run(words);
        assert_eq!(ran.code, 0, "{words:?}: {}", ran.err);
        ran.out
    }

    /// Names of everything in a folder, hidden files too.
    pub(crate) fn names(&self, folder: &str) -> Vec<String> {
        let entries = std::fs::read_dir(self.path(folder)).expect("a folder");
        let mut names: Vec<_> = entries
            .map(|e| e.unwrap().file_name().to_string_lossy().into_owned())
            .collect();
        names.sort();
        names
    }
}

/// A CSV text as rows of named fields.
pub(crate) fn rows(csv: &str) -> Vec<std::collections::HashMap<String, String>> {
    csv::Reader::from_reader(csv.as_bytes())
        .deserialize()
        .map(|r| r.expect("a CSV row"))
        .collect()
}

/// A field as a number.
pub(crate) fn number(row: &std::collections::HashMap<String, String>, field: &str) -> f64 {
    let text = row
        .get(field)
        .unwrap_or_else(|| panic!("no column {field}"));
    text.parse().unwrap_or_else(|_| panic!("{field} = {text}"))
}

/// Recordings kept beside the checkout; `None`, with a message, where they are not there.
#[expect(clippy::print_stderr, reason = "a test that checks nothing says so")]
pub(crate) fn shared(path: &str) -> Option<PathBuf> {
    let full = Path::new(env!("CARGO_MANIFEST_DIR"))
        .join("../shared/data")
        .join(path);
    if full.exists() {
        return Some(full);
    }
    eprintln!("skipped: {path} is not beside this checkout");
    None
}
