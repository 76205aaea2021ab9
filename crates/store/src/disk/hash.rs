//! Content hashes: BLAKE3, in hexadecimal.

use crate::{Files, MOST_RECORDING, RealFiles, StoreError};
use std::path::Path;

/// BLAKE3 of some bytes, hexadecimal.
pub fn hex_blake3(bytes: &[u8]) -> String {
    blake3::hash(bytes).to_hex().to_string()
}

/// BLAKE3 of a file's content, hexadecimal.
pub fn file_blake3(path: &Path) -> Result<String, StoreError> {
    blake3_of(&RealFiles, path)
}

pub(crate) fn blake3_of(files: &dyn Files, path: &Path) -> Result<String, StoreError> {
    let hash = files.open(path, MOST_RECORDING).and_then(|content| content.blake3());
    hash.map_err(|e| StoreError::io(path, "read", &e))
}
