//! One error type: what happened, where (file, column, row), what to do.

use std::fmt;
use std::path::{Path, PathBuf};
use zwidth_study::printable;

/// Something wrong with a file of the store, or in reading or writing one.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub struct StoreError {
    /// The file or folder.
    pub path: PathBuf,
    /// The column, where the problem is in one.
    pub column: Option<String>,
    /// The row, from 1, where the problem is in one.
    pub row: Option<usize>,
    /// What is wrong, with the value.
    pub what: String,
    /// What to do about it.
    pub remedy: String,
    /// Whether the operating system refused it: that says nothing about the file's content, and may
    /// change the next time.
    pub by_system: bool,
}

impl StoreError {
    /// Where: file, column, row.
    pub fn place(&self) -> String {
        let column = self.column.as_deref().map(|name| format!(", column {}", printable(name)));
        let row = self.row.map(|row| format!(", row {row}"));
        let path = self.path.to_string_lossy();
        [printable(&path).to_string(), column.unwrap_or_default(), row.unwrap_or_default()].concat()
    }

    /// What is wrong, and what to do about it.
    pub fn remark(&self) -> String {
        format!("{}; {}", printable(&self.what), printable(&self.remedy))
    }

    /// An error about a whole file.
    pub fn new(path: &Path, what: impl Into<String>, remedy: impl Into<String>) -> Self {
        Self {
            path: path.to_owned(),
            column: None,
            row: None,
            what: what.into(),
            remedy: remedy.into(),
            by_system: false,
        }
    }

    /// An error that nothing but a defect of this program explains.
    pub fn defect(path: &Path, error: &impl fmt::Display) -> Self {
        Self::new(path, error.to_string(), "this is a defect of zwidth, please report it")
    }

    /// The same error, in a column.
    #[must_use]
    pub fn column(mut self, column: impl Into<String>) -> Self {
        self.column = Some(column.into());
        self
    }

    /// The same error, in a row counted from 0 (shown from 1).
    #[must_use]
    pub fn row0(mut self, row: usize) -> Self {
        self.row = Some(row + 1);
        self
    }

    /// An input or output error, with a remedy for the usual causes.
    pub fn io(path: &Path, doing: &str, error: &std::io::Error) -> Self {
        use std::io::ErrorKind;
        let remedy = match error.kind() {
            ErrorKind::NotFound => "check the path",
            ErrorKind::PermissionDenied | ErrorKind::ReadOnlyFilesystem => {
                "make the folder writable for this user, or choose another with --root"
            }
            ErrorKind::StorageFull | ErrorKind::QuotaExceeded => {
                "free some space and run the command again; nothing was left half-written"
            }
            ErrorKind::InvalidInput | ErrorKind::IsADirectory => "put the file itself in its place",
            ErrorKind::FileTooLarge => "split it, or leave it out: no more is read of one file",
            ErrorKind::OutOfMemory => {
                "end other programs, raise the limit (`ulimit -v`), or read it on a larger machine"
            }
            ErrorKind::AlreadyExists => {
                "finished files never change; choose another number or folder"
            }
            _ => "see the message of the system",
        };
        // Memory that was refused has no number of the system.
        let by_system = error.raw_os_error().is_some() || error.kind() == ErrorKind::OutOfMemory;
        Self { by_system, ..Self::new(path, format!("cannot {doing}: {error}"), remedy) }
    }
}

impl fmt::Display for StoreError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}: {}", self.place(), self.remark())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_error_says_file_column_row_what_and_remedy() {
        let error = StoreError::new(Path::new("a.parquet"), "NaN", "mend it").column("t_s").row0(2);
        assert_eq!(error.to_string(), "a.parquet, column t_s, row 3: NaN; mend it");
    }

    #[test]
    fn a_name_with_a_line_feed_forges_no_line_and_one_with_escapes_steers_no_terminal() {
        let error =
            StoreError::new(Path::new("a\nb: fine"), "'\u{1b}[2J'", "mend it").column("x\u{202e}");
        assert_eq!(error.to_string(), r"a\nb: fine, column x\u{202e}: '\u{1b}[2J'; mend it");
    }
}
