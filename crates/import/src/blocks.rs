//! A long text block by block: each block has whole records and the header before them, so it is
//! read like a separate file.

use super::csv::{Dialect, record_ends, whole_records};
use super::format::Format;
use super::limits::{LONGEST_FILE, MOST_LINE, long_line};
use super::mapping::FileForm;
use super::plain::LABCHART;
use super::text::{Encoding, check_readable, count_lines};
use std::fs::File;
use std::io::{self, Read as _};
use std::path::{Path, PathBuf};
use zwidth_store::{StoreError, open_named};

/// Bytes that are read at a time (2 MiB): as texts and numbers some ten times as many. Tests have
/// many blocks in little text.
const BLOCK: usize = if cfg!(test) { 1 << 12 } else { 1 << 21 };

/// Room for a block, and for the look behind its end at whether there is more.
const ROOM: usize = BLOCK + 64;

/// Whether a recording is read block by block: a text with a header that is longer than most. What
/// a mapping asks for that looks at rows from the file's beginning to its end keeps it whole.
pub(super) fn is_long(path: &Path, form: &FileForm) -> bool {
    let text = matches!(form.format_of(path), Ok(Format::Csv | Format::Tsv | Format::Txt));
    let plain = text
        && form.header
        && form.bad_lines == 0
        && form.rows.is_none()
        && !form.whole
        && form.encoding != Encoding::Utf16;
    // A file that cannot be opened counts as short: reading it whole reports the error.
    plain && opened(path, form).unwrap_or(false)
}

fn opened(path: &Path, form: &FileForm) -> io::Result<bool> {
    let mut file = open_named(path)?;
    let long = file.metadata()?.len() > form.long_from;
    if !long {
        return Ok(false);
    }
    let mut begins = Vec::new();
    (&mut file).take(MOST_LINE as u64).read_to_end(&mut begins)?;
    let utf_16 = begins.starts_with(b"\xff\xfe") || begins.starts_with(b"\xfe\xff");
    // Its heads may lie behind skipped lines, and lines of old end in a carriage return alone.
    let labchart = begins.windows(LABCHART.len()).any(|part| part == LABCHART.as_bytes());
    Ok(!utf_16 && !labchart && begins.contains(&b'\n'))
}

/// A long text on its way.
pub(super) struct Blocks {
    path: PathBuf,
    file: File,
    dialect: Dialect,
    hasher: blake3::Hasher,
    /// The header, with what stands before it but skipped lines; behind it the bytes that were read and
    /// are in no block yet, which begin with a record.
    text: Vec<u8>,
    /// Bytes of the header.
    header: usize,
    /// Lines of the header.
    header_lines: u64,
    /// Lines of the file before the first record that is in no block yet.
    lines: u64,
    ended: bool,
}

/// Whole records of a text, behind its header.
pub(super) struct Block {
    pub(super) text: Vec<u8>,
    /// The dialect of the text, with the number of lines before it.
    pub(super) dialect: Dialect,
    /// Bytes of the header.
    pub(super) header: usize,
}

impl Blocks {
    /// Opens a text and reads its header.
    ///
    /// # Errors
    /// Those of `csv::read` for a file that cannot be read whole.
    pub(super) fn open(path: &Path, dialect: Dialect) -> Result<Self, StoreError> {
        let opened = open_named(path).and_then(|file| Ok((file.metadata()?.len(), file)));
        let (length, file) = opened.map_err(|e| StoreError::io(path, "read", &e))?;
        if length > LONGEST_FILE {
            let what = format!("it has {length} bytes, and at most {LONGEST_FILE} are read");
            return Err(StoreError::new(path, what, "split it"));
        }
        let mut blocks = Self {
            path: path.to_owned(),
            file,
            // Lines are skipped once, below, and not again in each block.
            dialect: Dialect { skip: 0, ..dialect },
            hasher: blake3::Hasher::new(),
            text: Vec::with_capacity(ROOM),
            header: 0,
            header_lines: 0,
            lines: 0,
            ended: false,
        };
        blocks.fill(BLOCK)?;
        check_readable(path, &blocks.text)?;
        if blocks.text.starts_with(b"\xef\xbb\xbf") {
            blocks.text.drain(..3);
            blocks.dialect.encoding = Encoding::Utf8;
        }
        let mut skipped = 0;
        for passed in 0..dialect.skip {
            let Some(end) = blocks.text[skipped..].iter().position(|b| *b == b'\n') else {
                let skip = dialect.skip;
                let what = format!(
                    "skip = {skip} passes more by than the file's first {BLOCK} bytes: {passed} lines"
                );
                return Err(StoreError::new(path, what, "mend skip in [file]"));
            };
            skipped += end + 1;
            blocks.lines += 1;
        }
        blocks.text.drain(..skipped);
        let end = header_end(&blocks.text, blocks.dialect);
        let end = end.or(blocks.ended.then_some(blocks.text.len()));
        blocks.header = end.ok_or_else(|| long_line(path, 1 + blocks.lines))?;
        blocks.header_lines = count_lines(&blocks.text[..blocks.header]);
        blocks.lines += blocks.header_lines;
        Ok(blocks)
    }

    /// The next block, if there is one.
    ///
    /// # Errors
    /// The disk's.
    pub(super) fn next(&mut self) -> Result<Option<Block>, StoreError> {
        let mut wanted = BLOCK;
        let end = loop {
            self.fill(self.header + wanted)?;
            let records = &self.text[self.header..];
            let end = if self.ended { records.len() } else { whole_records(records, self.dialect) };
            if end > 0 || self.ended {
                break self.header + end;
            }
            // No record may be that long; a shorter one only lies across the end of a block.
            if records.len() > BLOCK + MOST_LINE {
                return Err(long_line(&self.path, 1 + self.lines));
            }
            wanted += BLOCK;
        };
        let header = self.header;
        if end == header {
            return Ok(None);
        }
        let mut next = Vec::with_capacity(header + ROOM);
        next.extend_from_slice(&self.text[..header]);
        next.extend_from_slice(&self.text[end..]);
        let mut text = std::mem::replace(&mut self.text, next);
        text.truncate(end);
        // The header stands before the records of every block: its lines count once.
        let dialect = Dialect { before: self.lines - self.header_lines, ..self.dialect };
        self.lines += count_lines(&text[header..]);
        Ok(Some(Block { text, dialect, header }))
    }

    /// BLAKE3 of all that was read, hexadecimal.
    pub(super) fn blake3(&self) -> String {
        self.hasher.finalize().to_hex().to_string()
    }

    /// Reads on until so many bytes are there, or the file ends.
    fn fill(&mut self, wanted: usize) -> Result<(), StoreError> {
        let missing = wanted.saturating_sub(self.text.len());
        if self.ended || missing == 0 {
            return Ok(());
        }
        let from = self.text.len();
        let read = (&mut self.file).take(missing as u64).read_to_end(&mut self.text);
        let read = read.map_err(|e| StoreError::io(&self.path, "read", &e))?;
        self.hasher.update(&self.text[from..]);
        // A file gives fewer bytes than it is asked for only at its end.
        self.ended = read < missing;
        Ok(())
    }
}

/// The end of the first record that is neither empty nor a comment.
fn header_end(text: &[u8], dialect: Dialect) -> Option<usize> {
    let mut begins = 0;
    for ends in record_ends(text, dialect) {
        let record = &text[begins..ends];
        let is_comment = dialect.comment.is_some() && record.first().copied() == dialect.comment;
        if !is_comment && !record.trim_ascii().is_empty() {
            return Some(ends);
        }
        begins = ends;
    }
    None
}

/// BLAKE3 of a recording, hexadecimal.
///
/// # Errors
/// It cannot be read.
pub(super) fn blake3_of(path: &Path) -> Result<String, StoreError> {
    let mut hasher = blake3::Hasher::new();
    let read = open_named(path).and_then(|file| hasher.update_reader(file).map(|_| ()));
    read.map_err(|e| StoreError::io(path, "read", &e))?;
    Ok(hasher.finalize().to_hex().to_string())
}
