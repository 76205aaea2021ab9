//! The folder that is written, and what is known of each file in it. Without a folder, what would be
//! written is only listed.

use crate::ExportError;
use serde_json::json;
use sha2::{Digest as _, Sha256};
use std::fmt::Write as _;
use std::io::{self, Write};
use zwidth_store::NewFolder;

/// A file of an export.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Written {
    /// Its path in the export, with `/`.
    pub path: String,
    /// What it is, a phrase.
    pub about: String,
    /// Bytes; 0 if it was only listed.
    pub bytes: u64,
    /// SHA-256, hexadecimal; empty if it was only listed.
    pub sha256: String,
}

/// The folder, and the files that it has so far.
pub(crate) struct Folder<'f> {
    new: Option<NewFolder<'f>>,
    pub(crate) files: Vec<Written>,
}

impl<'f> Folder<'f> {
    pub(crate) fn new(new: Option<NewFolder<'f>>) -> Self {
        Self { new, files: Vec::new() }
    }

    /// Whether files are only listed.
    pub(crate) fn is_listed(&self) -> bool {
        self.new.is_none()
    }

    /// Writes a file, part by part.
    pub(crate) fn write(
        &mut self,
        path: &str,
        about: &str,
        write: impl FnOnce(&mut (dyn Write + Send)) -> Result<(), ExportError>,
    ) -> Result<(), ExportError> {
        let mut bytes = 0;
        let mut sha256 = String::new();
        if let Some(new) = &mut self.new {
            new.write(path, |out| {
                let mut hashed = Hashed { out, hasher: Sha256::new(), bytes: 0 };
                write(&mut hashed)?;
                bytes = hashed.bytes;
                sha256 = hexadecimal(&hashed.hasher.finalize());
                Ok::<(), ExportError>(())
            })??;
        }
        let (path, about) = (path.to_owned(), about.to_owned());
        self.files.push(Written { path, about, bytes, sha256 });
        Ok(())
    }

    /// Writes a text.
    pub(crate) fn text(&mut self, path: &str, about: &str, text: &str) -> Result<(), ExportError> {
        self.write(path, about, |out| Ok(out.write_all(text.as_bytes())?))
    }

    /// Writes JSON, ended by a line feed.
    pub(crate) fn json(
        &mut self,
        path: &str,
        about: &str,
        value: &serde_json::Value,
    ) -> Result<(), ExportError> {
        let text = serde_json::to_string_pretty(value).map_err(io::Error::from)?;
        self.text(path, about, &(text + "\n"))
    }

    /// What a Data Package says of a file that was written.
    pub(crate) fn sealed(&self, path: &str) -> serde_json::Value {
        match self.files.iter().find(|file| file.path == path) {
            Some(file) => json!({ "bytes": file.bytes, "hash": format!("sha256:{}", file.sha256) }),
            None => json!({}),
        }
    }

    /// Gives the folder its name; the files that it has.
    pub(crate) fn publish(self) -> Result<Vec<Written>, ExportError> {
        if let Some(new) = self.new {
            new.publish()?;
        }
        Ok(self.files)
    }

    /// Removes what was written.
    pub(crate) fn discard(self) {
        if let Some(new) = self.new {
            new.discard();
        }
    }
}

/// Hashes and counts what goes through it.
struct Hashed<'o> {
    out: &'o mut (dyn Write + Send),
    hasher: Sha256,
    bytes: u64,
}

impl Write for Hashed<'_> {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        let written = self.out.write(bytes)?;
        self.hasher.update(&bytes[..written]);
        self.bytes += written as u64;
        Ok(written)
    }

    fn flush(&mut self) -> io::Result<()> {
        self.out.flush()
    }
}

fn hexadecimal(digest: &[u8]) -> String {
    digest.iter().fold(String::new(), |mut text, byte| {
        // Writing to a text does not fail.
        let _ = write!(text, "{byte:02x}");
        text
    })
}
