//! Speed, measured beside peers in one run: `cargo bench -p zwidth-benches`. No test asserts a
//! time.

pub mod sweep;

use std::io;
use std::path::{Path, PathBuf};

/// The Parquet files below a folder.
///
/// # Errors
/// A folder that cannot be read.
pub fn gather(folder: &Path, files: &mut Vec<PathBuf>) -> io::Result<()> {
    for entry in std::fs::read_dir(folder)? {
        let path = entry?.path();
        if path.is_dir() {
            gather(&path, files)?;
        } else if path.extension().is_some_and(|extension| extension == "parquet") {
            files.push(path);
        }
    }
    Ok(())
}
