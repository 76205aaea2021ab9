//! What text formats share: decoding.

use serde::Deserialize;
use std::borrow::Cow;
use std::path::Path;
use zwidth_store::StoreError;

/// How the bytes of a text spell its characters. A byte-order mark says so itself, whatever the
/// mapping says.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Deserialize)]
pub(super) enum Encoding {
    /// UTF-8.
    #[default]
    #[serde(rename = "utf-8")]
    Utf8,
    /// UTF-16; without a byte-order mark the low byte comes first, as Windows writes it.
    #[serde(rename = "utf-16")]
    Utf16,
    /// Latin-1, ISO 8859-1: a byte a character.
    #[serde(rename = "latin-1")]
    Latin1,
}

/// What files begin with that nothing here reads, and what to do about one.
const UNREAD: [(&[u8], &str, &str); 7] = [
    (
        b"\xd0\xcf\x11\xe0",
        "an old Excel workbook (.xls), or one that a password locks",
        "save it as .xlsx without a password, or its sheet as CSV (UTF-8)",
    ),
    (b"\x1f\x8b", "compressed with gzip", "unpack it with gunzip"),
    (b"\x80\x03", PICKLED, PICKLE),
    (b"\x80\x04", PICKLED, PICKLE),
    (b"\x80\x05", PICKLED, PICKLE),
    (b"SQLite format 3", "an SQLite database", "write its table as CSV"),
    (b"%PDF", "a PDF", "ask for the numbers themselves"),
];
/// The line that converts an HDF5 file that is not read: its numbers by their path, as arrays of an
/// archive. `tests/interop/foreign.py` tries it.
pub(super) const HDF5: &str = "save it from MATLAB with -v7, or convert it: python -c \"import sys, h5py, numpy as np; d = {}; \
     h5py.File(sys.argv[1]).visititems(lambda n, o: d.update({n.replace('/', '.'): np.squeeze(o).astype(float)}) \
     if hasattr(o, 'dtype') and o.dtype.kind in 'iuf' else None); np.savez(sys.argv[2], **d)\" IN OUT.npz";
const PICKLED: &str = "a Python pickle";
/// A pickle may run any program when it is opened.
const PICKLE: &str = "where it was made, write it as CSV: frame.to_csv(\"OUT.csv\", index=False)";

/// What files begin with that other readers read, and how to ask for them.
const OTHER: [(&[u8], &str, &str); 8] = [
    (
        b"PK\x03\x04",
        "a packed file: an .xlsx or .ods workbook, or a ZIP",
        "set format = \"xlsx\" or \"ods\" in [file], or unpack it",
    ),
    (b"MATLAB 5.0", "a MAT file", "set format = \"mat\" in [file]"),
    (b"MATLAB 7.3", "a MAT file of version 7.3", "set format = \"mat\" in [file]"),
    (b"\x89HDF\r\n", "an HDF5 file", "set format = \"h5\" in [file]"),
    (b"PAR1", "a Parquet file", "set format = \"parquet\" in [file]"),
    (b"ARROW1", "an Arrow file", "set format = \"arrow\" in [file]"),
    (b"XDF:", "an XDF file", "set format = \"xdf\" in [file]"),
    (b"\x93NUMPY", "a NumPy array", "set format = \"npy\" in [file]"),
];

/// Whether a file may be one that is read, by what it begins with.
///
/// # Errors
/// It is one that nothing here reads; the remedy says how to convert it.
pub(super) fn check_readable(path: &Path, bytes: &[u8]) -> Result<(), StoreError> {
    match UNREAD.iter().find(|(begins, ..)| bytes.starts_with(begins)) {
        Some((_, what, remedy)) => Err(StoreError::new(path, format!("this is {what}"), *remedy)),
        None => Ok(()),
    }
}

/// The text of a file, without a byte-order mark.
///
/// # Errors
/// An empty file, one that is no text, or bytes that the encoding does not have, with the line.
pub(super) fn decode<'a>(
    path: &Path,
    bytes: &'a [u8],
    encoding: Encoding,
) -> Result<Cow<'a, str>, StoreError> {
    decode_from(path, bytes, encoding, 0)
}

/// [`decode`] of a part of a file, before which so many lines lie.
///
/// # Errors
/// Those of [`decode`].
pub(super) fn decode_from<'a>(
    path: &Path,
    bytes: &'a [u8],
    encoding: Encoding,
    before: u64,
) -> Result<Cow<'a, str>, StoreError> {
    check_readable(path, bytes)?;
    if let Some((_, what, remedy)) = OTHER.iter().find(|(begins, ..)| bytes.starts_with(begins)) {
        return Err(StoreError::new(path, format!("this is not a text but {what}"), *remedy));
    }
    let text = match bytes {
        [0xff, 0xfe, rest @ ..] => Cow::Owned(utf_16(path, rest, u16::from_le_bytes)?),
        [0xfe, 0xff, rest @ ..] => Cow::Owned(utf_16(path, rest, u16::from_be_bytes)?),
        [0xef, 0xbb, 0xbf, rest @ ..] => Cow::Borrowed(utf_8(path, rest, before)?),
        bytes => match encoding {
            Encoding::Utf8 => Cow::Borrowed(utf_8(path, bytes, before)?),
            Encoding::Utf16 => Cow::Owned(utf_16(path, bytes, u16::from_le_bytes)?),
            Encoding::Latin1 => Cow::Owned(bytes.iter().map(|b| char::from(*b)).collect()),
        },
    };
    if text.trim().is_empty() {
        return Err(StoreError::new(path, "the file is empty", "leave it out of the import"));
    }
    Ok(text)
}

fn utf_8<'a>(path: &Path, bytes: &'a [u8], before: u64) -> Result<&'a str, StoreError> {
    std::str::from_utf8(bytes).map_err(|e| {
        let lines = bytes[..e.valid_up_to()].iter().filter(|b| **b == b'\n').count() as u64;
        let line = 1 + before + lines;
        let what = format!("line {line} is not UTF-8 text");
        let remedy =
            "set encoding = \"latin-1\" or \"utf-16\" in [file], or save the file as UTF-8";
        StoreError::new(path, what, remedy)
    })
}

fn utf_16(path: &Path, bytes: &[u8], pair: fn([u8; 2]) -> u16) -> Result<String, StoreError> {
    let refused = |line: usize, what: &str| {
        let what = format!("line {line} is not UTF-16 text: {what}");
        StoreError::new(path, what, "mend encoding in [file], or save the file as UTF-8")
    };
    let (pairs, rest) = bytes.as_chunks::<2>();
    let mut text = String::with_capacity(pairs.len());
    let mut line = 1;
    for letter in char::decode_utf16(pairs.iter().map(|bytes| pair(*bytes))) {
        let letter = letter.map_err(|_| refused(line, "half of a character stands alone"))?;
        line += usize::from(letter == '\n');
        text.push(letter);
    }
    if rest.is_empty() { Ok(text) } else { Err(refused(line, "the file ends in mid-character")) }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn check(bytes: &[u8], words: &str) {
        let error = decode(Path::new("x"), bytes, Encoding::Utf8).unwrap_err();
        assert!(error.to_string().contains(words), "{error}");
    }

    #[test]
    fn text_that_is_empty_or_in_another_encoding_is_refused_with_the_remedy() {
        check(b"", "empty");
        check("\u{feff}\r\n".as_bytes(), "empty");
        check(b"a\nb\n\xe9\n", "line 3 is not UTF-8 text; set encoding = \"latin-1\"");
        check(b"\xff\xfea\0\n\0b", "line 2 is not UTF-16 text: the file ends");
        check(b"\xff\xfe\x00\xd8a\0", "line 1 is not UTF-16 text: half");
    }

    #[test]
    fn a_workbook_and_other_files_that_are_no_text_are_called_by_their_name() {
        check(b"PK\x03\x04rest", "an .xlsx or .ods workbook, or a ZIP; set format = \"xlsx\"");
        check(b"\x89HDF\r\n\x1a\n", "an HDF5 file; set format = \"h5\" in [file]");
    }

    #[test]
    fn every_encoding_gives_the_same_text() {
        let text = "Winkel (°);größe\n1;2\n";
        let little: Vec<u8> = text.encode_utf16().flat_map(u16::to_le_bytes).collect();
        let big: Vec<u8> = text.encode_utf16().flat_map(u16::to_be_bytes).collect();
        let latin: Vec<u8> = text.chars().map(|c| u8::try_from(u32::from(c)).unwrap()).collect();
        let read =
            |bytes: &[u8], encoding| decode(Path::new("x"), bytes, encoding).unwrap().into_owned();
        assert_eq!(read(&[b"\xff\xfe", little.as_slice()].concat(), Encoding::Utf8), text);
        assert_eq!(read(&[b"\xfe\xff", big.as_slice()].concat(), Encoding::Utf8), text);
        assert_eq!(read(&little, Encoding::Utf16), text);
        assert_eq!(read(&latin, Encoding::Latin1), text);
        assert_eq!(read(text.as_bytes(), Encoding::Utf8), text);
    }
}
