//! The formats of other people's files: the one list.

use super::csv::Dialect;
use super::limits::Take;
use super::spelling::shown;
use super::table::Table;
use super::xdf::XdfClock;
use super::{csv, feather, hdf5, jsonl, mat, npy, parquet, workbook, xdf};
use serde::Deserialize;
use std::path::Path;
use zwidth_store::StoreError;

/// The formats that can be read.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "snake_case")]
pub(super) enum Format {
    Csv,
    Tsv,
    Txt,
    Jsonl,
    Parquet,
    Arrow,
    Mat,
    #[serde(rename = "h5")]
    Hdf5,
    Npy,
    Npz,
    Xdf,
    Xlsx,
    Ods,
}

/// Options that a format needs besides the bytes.
#[derive(Debug, Clone, Copy)]
pub(super) struct FormatOptions<'a> {
    /// How delimited text is written.
    pub(super) dialect: Dialect,
    /// The part of the file whose columns are meant: a matrix of a MAT file, an array of a NumPy
    /// archive, a stream, a sheet.
    pub(super) part: Option<&'a str>,
    /// Which times of an XDF stream are taken.
    pub(super) clock: XdfClock,
    /// Whether those of a steady stream are put on a straight line.
    pub(super) dejitter: bool,
}

/// The first bytes of a MAT file of version 7.3.
const MATLAB_7_3: &[u8] = b"MATLAB 7.3";

impl Format {
    /// Every format.
    pub(super) const ALL: [Self; 13] = [
        Self::Csv,
        Self::Tsv,
        Self::Txt,
        Self::Jsonl,
        Self::Parquet,
        Self::Arrow,
        Self::Mat,
        Self::Hdf5,
        Self::Npy,
        Self::Npz,
        Self::Xdf,
        Self::Xlsx,
        Self::Ods,
    ];

    /// The extensions of its files, in small letters; the first is its word in a mapping file.
    pub(super) fn extensions(self) -> &'static [&'static str] {
        match self {
            Self::Csv => &["csv"],
            Self::Tsv => &["tsv"],
            Self::Txt => &["txt", "dat", "asc"],
            Self::Jsonl => &["jsonl", "ndjson"],
            Self::Parquet => &["parquet"],
            Self::Arrow => &["arrow", "feather", "ipc"],
            Self::Mat => &["mat"],
            Self::Hdf5 => &["h5", "hdf5"],
            Self::Npy => &["npy"],
            Self::Npz => &["npz"],
            Self::Xdf => &["xdf"],
            Self::Xlsx => &["xlsx", "xlsm"],
            Self::Ods => &["ods"],
        }
    }

    /// Its word in a mapping file.
    pub(super) fn word(self) -> &'static str {
        self.extensions()[0]
    }

    /// The common name of a file of this format.
    pub(super) fn name(self) -> &'static str {
        match self {
            Self::Csv => "a CSV",
            Self::Tsv => "a TSV",
            Self::Txt => "columns of text",
            Self::Jsonl => "JSON lines",
            Self::Parquet => "a Parquet file",
            Self::Arrow => "an Arrow file",
            Self::Mat => "a MAT file",
            Self::Hdf5 => "an HDF5 file",
            Self::Npy => "a NumPy array",
            Self::Npz => "a NumPy archive",
            Self::Xdf => "an XDF file",
            Self::Xlsx => "an Excel workbook",
            Self::Ods => "an OpenDocument workbook",
        }
    }

    /// Whether a file may unpack to more than its size.
    pub(super) fn is_packed(self) -> bool {
        matches!(
            self,
            Self::Parquet
                | Self::Arrow
                | Self::Mat
                | Self::Hdf5
                | Self::Npz
                | Self::Xlsx
                | Self::Ods
        )
    }

    /// The key that names a part of a file; `None` if a file has only one part.
    fn part_key(self) -> Option<&'static str> {
        match self {
            Self::Mat | Self::Hdf5 | Self::Npz => Some("matrix"),
            Self::Xdf => Some("stream"),
            Self::Xlsx | Self::Ods => Some("sheet"),
            _ => None,
        }
    }

    /// Reads the columns that are taken.
    ///
    /// # Errors
    /// Why the file cannot be read.
    pub(super) fn read(
        self,
        path: &Path,
        bytes: Vec<u8>,
        options: FormatOptions,
        take: &Take,
    ) -> Result<Table, StoreError> {
        if let Some(part) = options.part.filter(|_| self.part_key().is_none()) {
            let what = format!("'{}' is named, and {} has no parts", shown(part), self.name());
            return Err(StoreError::new(path, what, "remove matrix, sheet or stream from [file]"));
        }
        // An array that has a file to itself needs no name.
        if take.turned && options.part.is_none() && self != Self::Npy {
            let what = "signals = \"rows\" is of a matrix, and none is named";
            let remedy = match self.part_key() {
                Some("matrix") => "name it as matrix in [file]",
                _ => "remove it from [file]",
            };
            return Err(StoreError::new(path, what, remedy));
        }
        match self {
            Self::Csv | Self::Tsv | Self::Txt => csv::read(path, &bytes, options.dialect, take),
            Self::Jsonl => jsonl::read(path, &bytes, options.dialect.encoding, take),
            Self::Parquet => parquet::read(path, bytes, take),
            Self::Arrow => feather::read(path, &bytes, take),
            Self::Mat if bytes.starts_with(MATLAB_7_3) => {
                hdf5::read(path, bytes, options.part, hdf5::Order::Columns, take)
            }
            // Of version 7.3 without the text that MATLAB puts first: what MATLAB wrote says so itself.
            Self::Mat if hdf5::is_hdf5(&bytes) => {
                hdf5::read(path, bytes, options.part, hdf5::Order::Rows, take)
            }
            Self::Mat => mat::read(path, &bytes, options.part, take),
            Self::Hdf5 => hdf5::read(path, bytes, options.part, hdf5::Order::Rows, take),
            Self::Npy => npy::read(path, &bytes, take),
            Self::Npz => npy::read_archive(path, &bytes, options.part, take),
            Self::Xdf => {
                xdf::read(path, &bytes, options.part, options.clock, options.dejitter, take)
            }
            Self::Xlsx => workbook::read_xlsx(path, &bytes, options.dialect, options.part, take),
            Self::Ods => workbook::read_ods(path, &bytes, options.dialect, options.part, take),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_format_goes_by_its_own_word_and_no_extension_means_two() {
        let mut seen = std::collections::BTreeSet::new();
        for format in Format::ALL {
            let word =
                serde::de::value::StrDeserializer::<serde::de::value::Error>::new(format.word());
            assert_eq!(Format::deserialize(word).unwrap(), format);
            assert!(format.extensions().iter().all(|extension| seen.insert(*extension)));
        }
    }
}
