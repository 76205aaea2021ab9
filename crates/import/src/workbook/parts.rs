//! The parts of a workbook's archive, and what can be wrong with them.

use super::super::spelling::shown;
use super::super::zip;
use std::collections::BTreeMap;
use std::path::Path;
use zwidth_store::StoreError;

const REMEDY: &str = "the file may be cut off or damaged; open it and save it again, or save its sheet as CSV (UTF-8)";

pub(super) fn unreadable(path: &Path, why: &str) -> StoreError {
    StoreError::new(path, format!("not a readable workbook: {why}"), REMEDY)
}

/// The parts of a workbook's archive.
pub(super) struct Parts<'a> {
    bytes: &'a [u8],
    entries: Vec<zip::Entry>,
    /// Bytes of all that was unpacked, each part once.
    unpacked: u64,
    /// Of each part: which sheet has values is found out before that one is read.
    sizes: BTreeMap<String, u64>,
}

impl<'a> Parts<'a> {
    pub(super) fn of(path: &Path, bytes: &'a [u8]) -> Result<Self, StoreError> {
        if !bytes.starts_with(b"PK") {
            let (what, remedy) = match bytes {
                [] => ("the file is empty", "leave it out of the import"),
                [0xd0, 0xcf, 0x11, 0xe0, ..] => (
                    "not a workbook that is read: an old one (.xls), or one that a password locks",
                    "save it as .xlsx without a password, or its sheet as CSV (UTF-8)",
                ),
                _ => (
                    "not a workbook: it does not begin as an .xlsx or .ods does",
                    "if it is a text, set format = \"csv\" in [file]",
                ),
            };
            return Err(StoreError::new(path, what, remedy));
        }
        let entries = zip::entries(bytes).map_err(|why| unreadable(path, &why))?;
        Ok(Self { bytes, entries, unpacked: 0, sizes: BTreeMap::new() })
    }

    pub(super) fn has(&self, name: &str) -> bool {
        self.entries.iter().any(|entry| entry.name == name)
    }

    /// The text of a part.
    pub(super) fn text(&mut self, name: &str) -> Result<String, String> {
        let entry = self.entries.iter().find(|entry| entry.name == name);
        let entry = entry.ok_or_else(|| format!("it has no '{}'", shown(name)))?;
        // A part that is read again counts once.
        self.unpacked -= self.sizes.remove(name).unwrap_or(0);
        let bytes = zip::unpack(self.bytes, entry, &mut self.unpacked)?;
        self.sizes.insert(name.to_owned(), bytes.len() as u64);
        String::from_utf8(bytes).map_err(|_| format!("'{}' is not UTF-8 text", shown(name)))
    }
}

#[cfg(test)]
mod tests {
    use super::super::tests::archive;
    use super::*;

    #[test]
    fn a_part_that_is_read_twice_counts_once() {
        let bytes = archive(&[("a", "four"), ("b", "seven77")]);
        let mut parts = Parts::of(Path::new("x.xlsx"), &bytes).unwrap();
        for name in ["a", "b", "a", "b", "b"] {
            parts.text(name).unwrap();
        }
        assert_eq!(parts.unpacked, 4 + 7);
    }
}
