//! Small texts beside the data: regular files only, of a size that a text has.

use anyhow::{Context as _, anyhow};
use std::io;
use std::path::Path;
use zwidth_store::{StoreError, read_named, read_regular};

/// Bytes of a calibration, of the simulated device's parameters, or of a session's record (32 MiB).
const MOST_BESIDE: u64 = 1 << 25;
/// Bytes of a scene (64 MiB): one may hold a recorded series.
const MOST_SCENE: u64 = 1 << 26;

/// The text of a file beside `study.toml`, if anything stands there. A link is refused, not
/// followed.
pub(crate) fn read_beside(path: &Path) -> anyhow::Result<Option<String>> {
    // Not `exists`, which follows a link: a dangling one would pass for no file at all.
    if path.symlink_metadata().is_err() {
        return Ok(None);
    }
    text(path, read_regular(path, MOST_BESIDE)).map(Some)
}

/// The text of a scene that a person named.
pub(crate) fn scene(path: &Path) -> anyhow::Result<String> {
    text(path, read_named(path, MOST_SCENE))
}

fn text(path: &Path, read: io::Result<Vec<u8>>) -> anyhow::Result<String> {
    let bytes = read.map_err(|e| StoreError::io(path, "read", &e))?;
    String::from_utf8(bytes)
        .map_err(|e| {
            anyhow!("byte {} is not UTF-8; save the file as UTF-8", e.utf8_error().valid_up_to())
        })
        .with_context(|| format!("cannot read {}", path.display()))
}
