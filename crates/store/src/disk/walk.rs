//! What is below a folder of the data: files, and things that zwidth did not make.

use crate::disk::atomic::is_unfinished;
use crate::{Entry, Files, StoreError};
use std::io;
use std::path::{Path, PathBuf};

/// The things below a folder, at any depth. Linked folders are not entered.
#[derive(Debug, Default)]
pub(crate) struct Below {
    /// Regular files, sorted.
    pub(crate) files: Vec<PathBuf>,
    /// Links, pipes, sockets and devices: a finding each.
    pub(crate) strange: Vec<StoreError>,
}

/// Lists what lies below `folder`. There is nothing below a missing folder.
///
/// # Errors
/// A folder that cannot be listed.
pub(crate) fn below(files: &dyn Files, folder: &Path) -> Result<Below, StoreError> {
    let mut below = Below::default();
    // Names come sorted, and what is below a folder before the next name: paths are in order.
    let mut waiting = vec![(folder.to_owned(), Entry::Folder)];
    while let Some((path, kind)) = waiting.pop() {
        match kind {
            Entry::File => below.files.push(path),
            Entry::Link | Entry::Special => below.strange.push(strange(&path, kind)),
            Entry::Folder => match files.list(&path) {
                // Removed since its name was read, or never there.
                Err(e) if e.kind() == io::ErrorKind::NotFound => {}
                listed => {
                    let entries = listed.map_err(|e| StoreError::io(&path, "list", &e))?;
                    // The last one in is the first one out.
                    waiting.extend(entries.into_iter().rev());
                }
            },
        }
    }
    Ok(below)
}

/// The finding that something is neither file nor folder.
pub(crate) fn strange(path: &Path, kind: Entry) -> StoreError {
    let (what, remedy) = match kind {
        Entry::Link => (
            "it is a link, which is not followed",
            "put the file or folder itself here; if the data lie on another disk, name it with --root",
        ),
        _ => ("it is a pipe, socket or device", "move it elsewhere; only files belong here"),
    };
    StoreError::new(path, what, remedy)
}

/// Whether a name is hidden: an unfinished write, or the lock.
pub(crate) fn is_hidden(path: &Path) -> bool {
    path.file_name().is_some_and(|name| name.to_string_lossy().starts_with('.'))
}

/// Every file below a folder but hidden ones, sorted. Anything that is neither file nor folder is
/// skipped: it is a finding of the study as a whole.
///
/// # Errors
/// A folder that cannot be listed.
pub fn files_below(files: &dyn Files, folder: &Path) -> Result<Vec<PathBuf>, StoreError> {
    let mut paths = below(files, folder)?.files;
    paths.retain(|path| !is_hidden(path));
    Ok(paths)
}

/// The Parquet files below a folder, sorted. What else lies there is a finding of `verify`.
pub(crate) fn parquet_below(files: &dyn Files, folder: &Path) -> Result<Vec<PathBuf>, StoreError> {
    let mut paths = files_below(files, folder)?;
    paths.retain(|path| path.extension().is_some_and(|e| e == "parquet"));
    Ok(paths)
}

/// The left-overs of unfinished writes below a folder, at any depth; linked folders are not
/// entered.
pub fn unfinished_below(files: &dyn Files, folder: &Path) -> Vec<PathBuf> {
    let mut paths = below(files, folder).unwrap_or_default().files;
    paths.retain(|path| is_unfinished(path));
    paths
}
