//! What was repaired.

use std::fmt;
use std::path::PathBuf;
use zwidth_study::Status;

/// One thing that was brought in order.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Recovered {
    /// The file it is about.
    pub path: PathBuf,
    /// The repair.
    pub done: Done,
}

/// The repair that [`recover`](crate::recover) made to a file.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Done {
    /// A journal became the trial at the path.
    Trial {
        /// Complete if the journal knows its end.
        status: Status,
        /// Its number of samples.
        rows: usize,
        /// Bytes of an unfinished append at the journal's end, which were left out.
        cut_bytes: usize,
        /// Damaged frames of the journal that could be mended.
        mended: usize,
    },
    /// A journal without any sample was removed: the trial had not begun.
    Empty,
    /// The unfinished last line of a log was cut off: these words.
    Cut(String),
    /// The last line of a log got the line feed it lacked.
    Ended,
    /// A half-written file beside its final name was removed.
    Swept,
    /// A whole file that no log spoke of was taken into the log.
    Logged,
    /// What a change of several files had written when it was cut short was taken back.
    TakenBack {
        /// How many files were removed.
        files: usize,
        /// Of how many logs lines were cut off.
        logs: usize,
    },
}

impl fmt::Display for Recovered {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}: ", self.path.display())?;
        match &self.done {
            Done::Trial { status, rows, cut_bytes, mended } => {
                write!(f, "recovered from its journal: {}, {rows} samples", status.as_str())?;
                if *mended > 0 {
                    write!(f, "; damage in {mended} places was mended, so look after the disk")?;
                }
                if *cut_bytes > 0 {
                    write!(f, "; an append of {cut_bytes} bytes was cut short and is lost")?;
                }
                Ok(())
            }
            Done::Empty => write!(f, "the journal had no samples yet and was removed"),
            Done::Cut(text) => {
                write!(f, "the last line was an unfinished append and was cut off: {text}")
            }
            Done::Ended => {
                write!(f, "the last line was whole but for its line feed, which was added")
            }
            Done::Swept => write!(f, "a half-written file was removed"),
            Done::Logged => write!(f, "no log spoke of it; it is now in the log"),
            Done::TakenBack { files: 0, logs: 0 } => {
                write!(f, "a change was cut short before it wrote any file")
            }
            Done::TakenBack { files: 0, .. } => {
                write!(f, "a change was cut short, and the lines it had written were taken back")
            }
            // Only an import writes new files.
            Done::TakenBack { files: 1, .. } => {
                write!(f, "an import was cut short, and the file it had written was removed again")
            }
            Done::TakenBack { files, .. } => {
                write!(
                    f,
                    "an import was cut short, and the {files} files it had written were removed again"
                )
            }
        }
    }
}
