//! What text formats share: decoding.

use std::path::Path;
use zwidth_store::StoreError;

/// The text of a file, without a byte-order mark.
///
/// # Errors
/// An empty file, or bytes that are not UTF-8, with the line.
pub(super) fn decode<'a>(path: &Path, bytes: &'a [u8]) -> Result<&'a str, StoreError> {
    let bytes = bytes.strip_prefix("\u{feff}".as_bytes()).unwrap_or(bytes);
    let text = std::str::from_utf8(bytes).map_err(|e| {
        let line = 1 + bytes[..e.valid_up_to()].iter().filter(|b| **b == b'\n').count();
        let what = format!("line {line} is not UTF-8 text");
        StoreError::new(path, what, "save the file as UTF-8, or name its format in [file]")
    })?;
    if text.trim().is_empty() {
        return Err(StoreError::new(path, "the file is empty", "leave it out of the import"));
    }
    Ok(text)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn text_that_is_empty_or_not_utf_8_is_refused() {
        let check = |bytes: &[u8], words: &str| {
            let error = decode(Path::new("x"), bytes).unwrap_err();
            assert!(error.what.contains(words), "{error}");
        };
        check(b"", "empty");
        check("\u{feff}\r\n".as_bytes(), "empty");
        check(b"a\nb\n\xe9\n", "line 3 is not UTF-8");
    }
}
