//! What is below a folder of the data: files, and things that zwidth did not make.

use crate::disk::atomic::is_unfinished;
use crate::{Entry, Files, Layout, StoreError};
use std::io;
use std::path::{Path, PathBuf};

/// What lies below a folder, at any depth. Linked folders are not entered.
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
    let mut found = Below::default();
    // Names come sorted, and what is below a folder before the next name: paths are in order.
    let mut waiting = vec![(folder.to_owned(), Entry::Folder)];
    while let Some((path, kind)) = waiting.pop() {
        match kind {
            Entry::File => found.files.push(path),
            Entry::Link | Entry::Special => found.strange.push(strange(&path, kind)),
            Entry::Folder => match files.list(&path) {
                Err(e) if e.kind() == io::ErrorKind::NotFound => {}
                listed => {
                    let entries = listed.map_err(|e| StoreError::io(&path, "list", &e))?;
                    waiting.extend(entries.into_iter().rev());
                }
            },
        }
    }
    Ok(found)
}

/// The finding that something is neither file nor folder.
pub(crate) fn strange(path: &Path, kind: Entry) -> StoreError {
    match kind {
        Entry::Link => StoreError::new(
            path,
            "it is a link, which is not followed",
            "put the file or folder itself here; if the data lie on another disk, name it with --root",
        ),
        _ => StoreError::new(
            path,
            "it is a pipe, socket or device",
            "move it elsewhere; only files belong here",
        ),
    }
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
    let mut found = below(files, folder)?.files;
    found.retain(|path| !is_hidden(path));
    Ok(found)
}

/// The Parquet files below a folder, sorted. What else lies there is a finding of `verify`.
pub(crate) fn parquet_below(files: &dyn Files, folder: &Path) -> Result<Vec<PathBuf>, StoreError> {
    let mut found = files_below(files, folder)?;
    found.retain(|path| path.extension().is_some_and(|e| e == "parquet"));
    Ok(found)
}

/// The left-overs of unfinished writes below `raw/<study>`, at any depth.
pub(crate) fn unfinished(files: &dyn Files, layout: &Layout) -> Vec<PathBuf> {
    unfinished_below(files, &layout.raw())
}

/// The left-overs of unfinished writes below a folder, at any depth; linked folders are not
/// entered.
pub fn unfinished_below(files: &dyn Files, folder: &Path) -> Vec<PathBuf> {
    let mut found = below(files, folder).unwrap_or_default().files;
    found.retain(|path| is_unfinished(path));
    found
}
