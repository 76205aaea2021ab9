//! Content hashes: BLAKE3, in hexadecimal.

use crate::StoreError;
use std::path::Path;

/// BLAKE3 of some bytes, hexadecimal.
pub fn hex_blake3(bytes: &[u8]) -> String {
    blake3::hash(bytes).to_hex().to_string()
}

/// BLAKE3 of a file's content, hexadecimal.
pub fn file_blake3(path: &Path) -> Result<String, StoreError> {
    std::fs::read(path).map(|bytes| hex_blake3(&bytes)).map_err(|e| StoreError::io(path, "read", &e))
}
