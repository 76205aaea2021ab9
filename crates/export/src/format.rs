//! The forms that are written only if they are asked for.

/// A form of samples or tables that is written if it is asked for.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Format {
    /// BIDS, its part on motion.
    Bids,
    /// MCAP, as robotics' tools read it.
    Mcap,
    /// MAT files of version 5.
    Mat,
    /// All samples as one CSV.
    SamplesCsv,
    /// The tables as a workbook.
    Xlsx,
}

impl Format {
    /// All of them.
    pub const ALL: [Self; 5] = [Self::Bids, Self::Mcap, Self::Mat, Self::SamplesCsv, Self::Xlsx];

    /// The word by which it is asked for.
    pub const fn as_str(self) -> &'static str {
        match self {
            Self::Bids => "bids",
            Self::Mcap => "mcap",
            Self::Mat => "mat",
            Self::SamplesCsv => "samples-csv",
            Self::Xlsx => "xlsx",
        }
    }

    /// What it is, for a help text.
    pub const fn about(self) -> &'static str {
        match self {
            Self::Bids => "samples as a BIDS dataset (motion)",
            Self::Mcap => "samples as MCAP, a file for each trial (Foxglove, PlotJuggler)",
            Self::Mat => "samples and tables as MAT files (MATLAB, Octave)",
            Self::SamplesCsv => "all samples as one CSV",
            Self::Xlsx => "the tables as a workbook",
        }
    }
}
