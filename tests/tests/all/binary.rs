//! The program under test.

use serde_json::Value;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};

/// What a run of the program said, and how it ended.
#[derive(Debug)]
pub(crate) struct Ran {
    pub(crate) code: Option<i32>,
    pub(crate) out: String,
    pub(crate) err: String,
}

/// Runs `zwidth --root ROOT ARGUMENTS…`.
pub(crate) fn zwidth(root: &Path, arguments: &[&str]) -> Ran {
    let mut command = Command::new(binary());
    command.arg("--root").arg(root).args(arguments).env_remove("ZWIDTH_ROOT");
    ran(&command.output().unwrap())
}

/// The same, of a line whose words have no spaces.
pub(crate) fn zwidth_line(root: &Path, line: &str) -> Ran {
    zwidth(root, &line.split(' ').collect::<Vec<_>>())
}

/// What a finished process said.
pub(crate) fn ran(output: &Output) -> Ran {
    let text = |bytes: &[u8]| String::from_utf8(bytes.to_vec()).unwrap();
    Ran { code: output.status.code(), out: text(&output.stdout), err: text(&output.stderr) }
}

/// The program, beside this test's own binary: `target/<profile>/zwidth`.
pub(crate) fn binary() -> PathBuf {
    let deps = std::env::current_exe().unwrap();
    let folder = deps.ancestors().nth(2).unwrap();
    let path = folder.join(format!("zwidth{}", std::env::consts::EXE_SUFFIX));
    assert!(
        path.exists(),
        "{} is not built; `cargo test --workspace` builds it, and so does `cargo build -p zwidth`",
        path.display()
    );
    path
}

impl Ran {
    /// The exit code must be this one.
    #[track_caller]
    pub(crate) fn exits(self, code: i32) -> Self {
        assert_eq!(self.code, Some(code), "{self:#?}");
        self
    }

    /// Each of these words must stand on standard error.
    #[track_caller]
    pub(crate) fn says(self, words: &[&str]) -> Self {
        for word in words {
            assert!(self.err.contains(word), "'{word}' is not in {self:#?}");
        }
        self
    }

    /// Each of these words must stand on standard output.
    #[track_caller]
    pub(crate) fn prints(self, words: &[&str]) -> Self {
        for word in words {
            assert!(self.out.contains(word), "'{word}' is not in {self:#?}");
        }
        self
    }

    /// Standard error must be one message: a line that begins with `error:`, and no other.
    #[track_caller]
    pub(crate) fn one_error(self) -> Self {
        assert!(self.err.starts_with("error: ") && self.err.lines().count() == 1, "{self:#?}");
        self
    }

    /// Standard output as JSON.
    #[track_caller]
    pub(crate) fn json(&self) -> Value {
        serde_json::from_str(&self.out).unwrap_or_else(|e| panic!("not JSON ({e}): {self:#?}"))
    }

    /// The names of what `run --json` made, sorted.
    #[track_caller]
    pub(crate) fn made(&self) -> Vec<String> {
        let made = self.json()[0]["made"].as_array().unwrap().clone();
        let mut names: Vec<String> =
            made.iter().map(|e| e["name"].as_str().unwrap().to_owned()).collect();
        names.sort();
        names
    }

    /// What `run --json` left out.
    #[track_caller]
    pub(crate) fn left_out(&self) -> Vec<String> {
        let lines = self.json()[0]["left_out"].as_array().unwrap().clone();
        lines.iter().map(|l| l.as_str().unwrap().to_owned()).collect()
    }
}
