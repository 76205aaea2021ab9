//! The readers of other people's formats as functions of bytes; they take the first columns.

use super::csv::{Dialect, WHITE_SPACE};
use super::format::{Format, FormatOptions};
use super::limits::{Budget, Take};
use super::table::{Cells, ColumnRef, Table};
use super::text::Encoding;
use super::xdf::XdfClock;
use std::path::Path;
use zwidth_store::StoreError;

/// Columns that are taken.
const TAKEN: usize = 8;

/// The reader of a format.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct FormatReader(Format);

/// Every reader.
pub fn readers() -> impl Iterator<Item = FormatReader> {
    // Tabs are read as commas are.
    Format::ALL.into_iter().filter(|format| *format != Format::Tsv).map(FormatReader)
}

impl FormatReader {
    /// The format's word.
    pub fn word(self) -> &'static str {
        self.0.word()
    }

    /// The common name of a file of this format.
    pub fn name(self) -> &'static str {
        self.0.name()
    }

    /// Whether a file may unpack to more than its size.
    pub fn is_packed(self) -> bool {
        self.0.is_packed()
    }

    /// Reads a file; the number of rows. Of a MAT file, a NumPy archive and an MCAP file the part `data` is read before the
    /// others, of a C3D file each of its parts.
    ///
    /// # Errors
    /// Why it cannot be read.
    pub fn read(self, bytes: &[u8]) -> Result<usize, StoreError> {
        // Parts that the seeds have.
        let parts: &[&str] = match self.0 {
            Format::Mat | Format::Npz | Format::Mcap => &["data"],
            Format::C3d => &["points", "analog", "events"],
            _ => &[],
        };
        for part in parts {
            let _: Result<Table, StoreError> = self.table(bytes.to_vec(), Some(part));
        }
        Ok(self.table(bytes.to_vec(), None)?.lines.len())
    }

    /// Reads a file, or a part of it; the sum of all numbers in its first columns.
    ///
    /// # Errors
    /// Why it cannot be read.
    pub fn sum(self, bytes: Vec<u8>, part: Option<&str>) -> Result<f64, StoreError> {
        let table = self.table(bytes, part)?;
        let numbers = table.columns.iter().map(|cells| match cells {
            Cells::Numbers(cells) => cells.iter().flatten().sum(),
            _ => 0.0,
        });
        Ok(numbers.sum())
    }

    fn table(self, bytes: Vec<u8>, part: Option<&str>) -> Result<Table, StoreError> {
        let columns: Vec<ColumnRef> = (1..=TAKEN).map(ColumnRef::Position).collect();
        let dialect = Dialect {
            delimiter: if self.0 == Format::Txt { WHITE_SPACE } else { b',' },
            header: true,
            comment: Some(b'#'),
            skip: 0,
            encoding: Encoding::Utf8,
            bad_lines: 1,
            before: 0,
        };
        let budget = Budget::default();
        let take = Take::of(columns.iter().collect(), &budget);
        let options = FormatOptions { dialect, part, clock: XdfClock::Corrected, dejitter: true };
        self.0.read(Path::new("input"), bytes, options, &take)
    }
}
