//! The common part of text formats: decoding.

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
    /// Latin-1, ISO 8859-1: a byte a character. People mean Windows-1252 by it where that has a letter for
    /// a control character of Latin-1 (<https://encoding.spec.whatwg.org> takes each for the other).
    #[serde(rename = "latin-1")]
    Latin1,
    /// Windows-1252, in which Excel and other programs of Windows write Western languages: Latin-1 with
    /// quotes, dashes and € in place of the second row of control characters.
    #[serde(rename = "windows-1252")]
    Windows1252,
}

/// What the bytes from 0x80 to 0x9f are in Windows-1252; the replacement character where they are
/// nothing (<https://encoding.spec.whatwg.org/index-windows-1252.txt> has control characters there).
const WINDOWS_1252: [char; 32] = [
    '€', '\u{fffd}', '‚', 'ƒ', '„', '…', '†', '‡', 'ˆ', '‰', 'Š', '‹', 'Œ', '\u{fffd}', 'Ž',
    '\u{fffd}', '\u{fffd}', '‘', '’', '“', '”', '•', '–', '—', '˜', '™', 'š', '›', 'œ', '\u{fffd}',
    'ž', 'Ÿ',
];
/// The first byte of that table, and the one behind it: control characters in Latin-1.
const C1: std::ops::Range<u8> = 0x80..0xa0;

/// The character that a byte is in Windows-1252.
fn windows_1252(byte: u8) -> char {
    match byte.checked_sub(C1.start) {
        Some(place) if C1.contains(&byte) => WINDOWS_1252[usize::from(place)],
        _ => char::from(byte),
    }
}

/// Whether bytes that are not UTF-8 are rather Windows-1252 than Latin-1: some are control characters
/// there, and all are characters here.
pub(super) fn is_windows_1252(bytes: &[u8]) -> bool {
    bytes.iter().any(|byte| C1.contains(byte))
        && bytes.iter().all(|byte| windows_1252(*byte) != char::REPLACEMENT_CHARACTER)
}

/// A note for the report on a text that the mapping calls Latin-1.
pub(super) fn latin_1_note(bytes: &[u8], encoding: Encoding) -> Option<String> {
    let is_odd = encoding == Encoding::Latin1 && is_windows_1252(bytes);
    is_odd.then(|| {
        "it is read as Windows-1252: as Latin-1 it has control characters where that has ’ “ ” – €".to_owned()
    })
}

/// First bytes of files that nothing here reads, their kind, and what to do about one.
const UNREAD: [(&[u8], &str, &str); 12] = [
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
    (
        b"TDSh",
        "the index beside a TDMS file of LabVIEW",
        "leave it out, and import the .tdms file itself",
    ),
    (b"#ROSBAG V", "a bag of ROS 1", ROS_BAG_1),
    (b"MDF     ", "an MF4 file (ASAM MDF)", MF4),
    (b"\xffBIOSEMI", "a BDF file of BioSemi", AS_CSV),
    (b"0       ", EDF, AS_CSV),
];
const EDF: &str = "an EDF file";
const JSON: &str = "one JSON array, and not JSON lines: those are one object a line";
const AS_JSON_LINES: &str = "write them: python -c \"import sys, json; [print(json.dumps(row)) for row in json.load(open(sys.argv[1]))]\" \
     IN.json > OUT.jsonl";
const AS_CSV: &str = "in the program that made it, or in Python, write its numbers as CSV (UTF-8)";
/// The line that converts an HDF5 file that is not read: its numbers by their path, as arrays of an
/// archive, fields of tables and parts of complex numbers each by itself, unpacked as its attributes say.
/// `tests/interop/foreign.py` tries it.
pub(super) const HDF5: &str = "save it from MATLAB with -v7, or convert it: python -c \"import sys, h5py, numpy as np; d = {}; \
     f = lambda n, a, s: [f(n + '.' + k, a[k], s) for k in a.dtype.names] if a.dtype.names else \
     [f(n + '.' + k, getattr(a, k), s) for k in ('real', 'imag')] if a.dtype.kind == 'c' else \
     d.update({n: np.where(np.isin(a, s.get('_FillValue', [])), np.nan, a.astype(float) * s.get('scale_factor', s.get('conversion', 1)) \
     + s.get('add_offset', s.get('offset', 0)))}) if a.dtype.kind in 'iufb' else None; \
     h5py.File(sys.argv[1]).visititems(lambda n, o: [f(n.replace('/', '.'), np.squeeze(o[()]), o.attrs)] and None \
     if hasattr(o, 'dtype') else None); np.savez(sys.argv[2], **d)\" IN OUT.npz";
/// The lines that convert files that are not read; `tests/interop/laboratory.py` tries them. A bag's folder has its
/// description beside it. Times of an AcqKnowledge file are the number of a sample over the rate: the reader's own
/// `time_index` is longer by a sample.
const ROS_BAG: &str = "convert its folder (pip install rosbags): rosbags-convert --src FOLDER --dst OUT --dst-storage mcap";
const ROS_BAG_1: &str =
    "convert it (pip install rosbags): rosbags-convert --src IN.bag --dst OUT --dst-storage mcap";
const ACQ: &str = "convert it (pip install bioread): python -c \"import sys, bioread, numpy as np; \
     f = bioread.read(sys.argv[1]); \
     np.savez(sys.argv[2], **{f'{k}_{i}': v for i, c in enumerate(f.channels, 1) \
     for k, v in {c.name: c.data, 't_s': np.arange(c.point_count) / c.samples_per_second}.items()})\" IN OUT.npz";
const MF4: &str = "convert it (pip install asammdf): python -c \"import sys, asammdf, numpy as np; \
     f = asammdf.MDF(sys.argv[1]); \
     np.savez(sys.argv[2], **{f'{k}_{g}_{i}': v for g, i in ((g, i) for g, group in enumerate(f.groups) for i in range(len(group.channels))) \
     for s in [f.get(group=g, index=i)] for k, v in {s.name: s.samples, 't_s': s.timestamps}.items() \
     if i != f.masters_db.get(g)})\" IN OUT.npz";
const PICKLED: &str = "a Python pickle";
/// A pickle may run any program when it is opened.
const PICKLE: &str = "where it was made, write it as CSV: frame.to_csv(\"OUT.csv\", index=False)";

/// First bytes of files for other readers, their kind, and how to ask for that reader.
const OTHER: [(&[u8], &str, &str); 11] = [
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
    // The block in which parameters begin, and the key of the format.
    (b"\x02\x50", "a C3D file", "set format = \"c3d\" in [file]"),
    (b"TDSm", "a TDMS file of LabVIEW", "set format = \"tdms\" in [file]"),
    (b"\x89MCAP0\r\n", "an MCAP file", "set format = \"mcap\" in [file]"),
    (b"\x93NUMPY", "a NumPy array", "set format = \"npy\" in [file]"),
];

/// Whether a file may be one that is read, by what it begins with.
///
/// # Errors
/// It is one that nothing here reads; the remedy says how to convert it.
pub(super) fn check_readable(path: &Path, bytes: &[u8]) -> Result<(), StoreError> {
    let extension = path.extension().unwrap_or_default();
    let unread = UNREAD.iter().find(|(begins, what, _)| {
        // Columns of text may begin with 0 and blanks too: the head of an EDF file has a date with dots.
        let date = bytes.get(168..176);
        let is_edf = matches!(date, Some([_, _, b'.', _, _, b'.', _, _]));
        bytes.starts_with(begins) && (*what != EDF || is_edf)
    });
    let mut letters = bytes.iter().filter(|byte| !byte.is_ascii_whitespace());
    let is_json_array = letters.next() == Some(&b'[') && letters.next() == Some(&b'{');
    let (what, remedy) = match (unread, bytes) {
        (Some(_), [b'S', b'Q', ..]) if extension.eq_ignore_ascii_case("db3") => {
            ("a bag of ROS 2 in SQLite", ROS_BAG)
        }
        (Some((_, what, remedy)), _) => (*what, *remedy),
        (None, [0, ..]) if extension.eq_ignore_ascii_case("acq") => {
            ("a file of AcqKnowledge (BIOPAC)", ACQ)
        }
        (None, _) if extension.eq_ignore_ascii_case("mat") && is_mat_4(bytes) => {
            ("a MAT file of version 4", "save it again with -v7")
        }
        (None, _) if is_json_array => (JSON, AS_JSON_LINES),
        (None, _) => return Ok(()),
    };
    Err(StoreError::new(path, format!("this is {what}"), remedy))
}

/// Whether this is a MAT file of version 4, which begins with its first variable: type, rows, columns,
/// whether it is complex, and the length of its name (MathWorks, "MAT-File Format", "Level 4").
fn is_mat_4(bytes: &[u8]) -> bool {
    let Some((head, _)) = bytes.split_first_chunk::<20>() else { return false };
    let chunks = head.as_chunks::<4>().0;
    let little: Vec<u32> = chunks.iter().map(|word| u32::from_le_bytes(*word)).collect();
    let big: Vec<u32> = chunks.iter().map(|word| u32::from_be_bytes(*word)).collect();
    [(little, 0), (big, 1)].into_iter().any(|(words, machine)| {
        let [kind, _, _, complex, name] = words[..] else { return false };
        // The last two digits of the type are the precision and whether it is a text or sparse.
        kind / 1000 == machine && kind % 1000 <= 52 && complex <= 1 && (1..=64).contains(&name)
    })
}

/// Checks that bytes whose format is not known are a text.
pub(super) fn check_is_text(path: &Path, bytes: &[u8]) -> Result<(), StoreError> {
    let begins = &bytes[..bytes.len().min(LOOKED_AT_BYTES)];
    let utf_16 = begins.starts_with(b"\xff\xfe") || begins.starts_with(b"\xfe\xff");
    // In UTF-16 of plain letters every second byte is 0, and no other is.
    let zeros = [0, 1].map(|from| begins.iter().skip(from).step_by(2).filter(|b| **b == 0).count());
    let may_be_utf_16 = utf_16 || (zeros.contains(&0) && 4 * (zeros[0] + zeros[1]) > begins.len());
    let odd = begins.iter().filter(|byte| **byte < b'\t' || (0x0e..0x20).contains(*byte));
    let is_odd = odd.count() * MOST_ODD > begins.len();
    if may_be_utf_16 || !is_odd {
        return Ok(());
    }
    let what = "this is neither text nor a format that is read here";
    Err(StoreError::new(path, what, AS_CSV))
}

/// Bytes that tell whether a file is a text.
const LOOKED_AT_BYTES: usize = 4096;
/// One in so many bytes of a text is a control character, at most.
const MOST_ODD: usize = 100;

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
            Encoding::Latin1 if !is_windows_1252(bytes) => {
                Cow::Owned(bytes.iter().map(|b| char::from(*b)).collect())
            }
            Encoding::Latin1 | Encoding::Windows1252 => {
                let text: String = bytes.iter().map(|byte| windows_1252(*byte)).collect();
                if let Some(at) = text.find(char::REPLACEMENT_CHARACTER) {
                    let line = 1 + before + count_lines(&text.as_bytes()[..at]);
                    let what = format!("line {line} is not Windows-1252 text");
                    let remedy = "set encoding = \"latin-1\" in [file], or save the file as UTF-8";
                    return Err(StoreError::new(path, what, remedy));
                }
                Cow::Owned(text)
            }
        },
    };
    if text.trim().is_empty() {
        return Err(StoreError::new(path, "the file is empty", "leave it out of the import"));
    }
    Ok(text)
}

/// The number of lines that end in a text.
pub(super) fn count_lines(text: &[u8]) -> u64 {
    // In numbers of one byte, of which a processor adds many at a time; so many do not overflow.
    let some = text.chunks(usize::from(u8::MAX));
    let ends = some.map(|some| some.iter().fold(0_u8, |n, byte| n + u8::from(*byte == b'\n')));
    ends.map(u64::from).sum()
}

fn utf_8<'a>(path: &Path, bytes: &'a [u8], before: u64) -> Result<&'a str, StoreError> {
    std::str::from_utf8(bytes).map_err(|e| {
        let line = 1 + before + count_lines(&bytes[..e.valid_up_to()]);
        let what = format!("line {line} is not UTF-8 text");
        let remedy = if is_windows_1252(bytes) {
            "set encoding = \"windows-1252\" in [file], or save the file as UTF-8"
        } else {
            "set encoding = \"latin-1\" or \"utf-16\" in [file], or save the file as UTF-8"
        };
        StoreError::new(path, what, remedy)
    })
}

fn utf_16(path: &Path, bytes: &[u8], pair: fn([u8; 2]) -> u16) -> Result<String, StoreError> {
    let (pairs, rest) = bytes.as_chunks::<2>();
    let mut text = String::with_capacity(pairs.len());
    let mut line = 1;
    let mut problem = (!rest.is_empty()).then_some("the file ends in mid-character");
    for letter in char::decode_utf16(pairs.iter().map(|bytes| pair(*bytes))) {
        let Ok(letter) = letter else {
            problem = Some("half of a character stands alone");
            break;
        };
        line += usize::from(letter == '\n');
        text.push(letter);
    }
    let Some(problem) = problem else { return Ok(text) };
    let what = format!("line {line} is not UTF-16 text: {problem}");
    Err(StoreError::new(path, what, "mend encoding in [file], or save the file as UTF-8"))
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
        check(b"TDSm\x0e\0\0\0", "a TDMS file of LabVIEW; set format = \"tdms\" in [file]");
        check(b"\x02\x50\0\x01", "a C3D file; set format = \"c3d\" in [file]");
    }

    #[test]
    fn files_of_other_programs_are_called_by_their_name() {
        let edf = [b"0       ".as_slice(), &[b' '; 160], b"31.01.26", &[b' '; 80]].concat();
        let mat_4: Vec<u8> = [0_u32, 3, 1, 0, 2].into_iter().flat_map(u32::to_le_bytes).collect();
        let mat_4_big: Vec<u8> =
            [1000_u32, 3, 1, 0, 2].into_iter().flat_map(u32::to_be_bytes).collect();
        for (name, bytes, words) in [
            ("a.tdms_index", b"TDSh\x0e\0\0\0".as_slice(), "the index beside a TDMS file"),
            ("a.acq", b"\0\0\x54\0\0\0", "AcqKnowledge"),
            ("a.bag", b"#ROSBAG V2.0\n", "a bag of ROS 1"),
            ("a.bdf", b"\xffBIOSEMI", "a BDF file"),
            ("a.edf", &edf, "an EDF file"),
            ("a.mat", &mat_4, "a MAT file of version 4; save it again with -v7"),
            ("a.mat", &mat_4_big, "a MAT file of version 4"),
        ] {
            let error = check_readable(Path::new(name), bytes).unwrap_err().to_string();
            assert!(error.contains(words), "{error}");
        }
        for (name, bytes) in
            [("a.txt", b"0       1.5\n1       2.5\n".as_slice()), ("a.csv", b"2P,1\n")]
        {
            check_readable(Path::new(name), bytes).unwrap();
        }
    }

    #[test]
    fn bytes_that_are_no_text_are_told_from_utf_16() {
        let utf_16: Vec<u8> = "t,f\n0,1\n".encode_utf16().flat_map(u16::to_le_bytes).collect();
        for text in [b"t,f\n0,1\n".as_slice(), &utf_16, b"\xff\xfet\0", b"na\xefve\n", b""] {
            check_is_text(Path::new("x"), text).unwrap();
        }
        let numbers: Vec<u8> =
            [1.5_f32, 2.25, -3.0].into_iter().flat_map(f32::to_le_bytes).collect();
        let error = check_is_text(Path::new("x"), &numbers).unwrap_err().to_string();
        assert!(error.contains("neither text nor a format that is read here"), "{error}");
    }

    #[test]
    fn bytes_that_windows_1252_lacks_are_refused_with_their_line() {
        let read = |bytes: &[u8]| {
            let text = decode(Path::new("x"), bytes, Encoding::Windows1252);
            text.map(Cow::into_owned).map_err(|e| e.to_string())
        };
        assert_eq!(read(b"can\x92t \x93x\x94 \x80 \xe9"), Ok("can’t “x” € é".to_owned()));
        for byte in [0x81, 0x8d, 0x8f, 0x90, 0x9d] {
            let error = read(&[b'a', b'\n', byte]).unwrap_err();
            assert!(error.contains("line 2 is not Windows-1252 text"), "{error}");
        }
        check(b"a\ncan\x92t\n", "line 2 is not UTF-8 text; set encoding = \"windows-1252\"");
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
        assert_eq!(read(&latin, Encoding::Windows1252), text);
        assert_eq!(read(text.as_bytes(), Encoding::Utf8), text);
    }
}
