//! The formats of other people's files: the one list.

use super::csv::Dialect;
use super::limits::{LARGEST_WHOLE, MOST_FILE, Take};
use super::spelling::shown;
use super::table::Table;
use super::xdf::XdfClock;
use super::{
    c3d, csv, feather, hdf5, jsonl, mat, mcap, npy, opensim, parquet, tdms, workbook, xdf,
};
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
    Tdms,
    C3d,
    Sto,
    Mcap,
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
    pub(super) const ALL: [Self; 17] = [
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
        Self::Tdms,
        Self::C3d,
        Self::Sto,
        Self::Mcap,
        Self::Xlsx,
        Self::Ods,
    ];

    /// The extensions of its files, in small letters, of which the first is its word in a mapping file; the common
    /// name of one; whether it may unpack to more than its size; the key that names a part of it, if it has parts.
    fn row(self) -> (&'static [&'static str], &'static str, bool, Option<&'static str>) {
        match self {
            Self::Csv => (&["csv"], "a CSV", false, None),
            Self::Tsv => (&["tsv"], "a TSV", false, None),
            Self::Txt => (&["txt", "dat", "asc"], "columns of text", false, None),
            Self::Jsonl => (&["jsonl", "ndjson"], "JSON lines", false, None),
            Self::Parquet => (&["parquet"], "a Parquet file", true, None),
            Self::Arrow => (&["arrow", "feather", "ipc"], "an Arrow file", true, None),
            Self::Mat => (&["mat"], "a MAT file", true, Some("matrix")),
            Self::Hdf5 => (&["h5", "hdf5"], "an HDF5 file", true, Some("matrix")),
            Self::Npy => (&["npy"], "a NumPy array", false, None),
            Self::Npz => (&["npz"], "a NumPy archive", true, Some("matrix")),
            Self::Xdf => (&["xdf"], "an XDF file", false, Some("stream")),
            Self::Tdms => (&["tdms"], "a TDMS file", false, Some("group")),
            Self::C3d => (&["c3d"], "a C3D file", false, Some("group")),
            Self::Sto => (&["sto", "mot"], "an OpenSim file", false, None),
            Self::Mcap => (&["mcap"], "an MCAP file", true, Some("topic")),
            Self::Xlsx => (&["xlsx", "xlsm"], "an Excel workbook", true, Some("sheet")),
            Self::Ods => (&["ods"], "an OpenDocument workbook", true, Some("sheet")),
        }
    }

    /// The extensions of its files, in small letters; the first is its word in a mapping file.
    pub(super) fn extensions(self) -> &'static [&'static str] {
        self.row().0
    }

    /// Its word in a mapping file.
    pub(super) fn word(self) -> &'static str {
        self.extensions()[0]
    }

    /// The common name of a file of this format.
    pub(super) fn name(self) -> &'static str {
        self.row().1
    }

    /// Whether a file may unpack to more than its size.
    pub(super) fn is_packed(self) -> bool {
        self.row().2
    }

    /// The bytes of a file that are read at most.
    pub(super) fn most_bytes(self) -> u64 {
        match self {
            Self::Tdms | Self::C3d | Self::Mcap => LARGEST_WHOLE,
            _ => MOST_FILE,
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
        let (.., part_key) = self.row();
        if let Some(part) = options.part.filter(|_| part_key.is_none()) {
            let what = format!("'{}' is named, and {} has no parts", shown(part), self.name());
            return Err(StoreError::new(
                path,
                what,
                "remove matrix, sheet, stream, group or topic from [file]",
            ));
        }
        // An array that has a file to itself needs no name.
        if take.turned && options.part.is_none() && self != Self::Npy {
            let what = "signals = \"rows\" is of a matrix, and none is named";
            let remedy = match part_key {
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
            Self::Mat if !hdf5::is_hdf5(&bytes) => mat::read(path, &bytes, options.part, take),
            // Of version 7.3 without the text that MATLAB puts first: what MATLAB wrote says so itself.
            Self::Mat | Self::Hdf5 => {
                hdf5::read(path, bytes, options.part, hdf5::Order::Rows, take)
            }
            Self::Npy => npy::read(path, &bytes, take),
            Self::Npz => npy::read_archive(path, &bytes, options.part, take),
            Self::Xdf => {
                xdf::read(path, &bytes, options.part, options.clock, options.dejitter, take)
            }
            Self::Tdms => tdms::read(path, &bytes, options.part, take),
            Self::C3d => c3d::read(path, &bytes, options.part, take),
            Self::Sto => opensim::read(path, &bytes, options.dialect, take),
            Self::Mcap => mcap::read(path, &bytes, options.part, take),
            Self::Xlsx | Self::Ods => {
                let is_ods = self == Self::Ods;
                workbook::read(path, &bytes, is_ods, options.dialect, options.part, take)
            }
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
