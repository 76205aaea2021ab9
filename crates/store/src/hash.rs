//! Content hashes: BLAKE3, in hexadecimal.

use crate::{Files, MOST_BYTES, RealFiles, StoreError};
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
    let bytes = files.read(path, MOST_BYTES).map_err(|e| StoreError::io(path, "read", &e))?;
    Ok(hex_blake3(&bytes))
}
