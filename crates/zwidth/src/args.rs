//! What can be typed. Parsed here, resolved into work by the commands.

use clap::{Parser, Subcommand, ValueEnum};
use std::path::PathBuf;
use zwidth_study::StudyId;
use zwidth_tables::Format;

/// Force-feedback studies: from raw recordings to figures, tables and a summary.
///
/// Exit codes: 0 fine, 1 failed, 2 bad arguments, 3 done but something was skipped or lost (and listed).
#[derive(Debug, Parser)]
#[command(name = "zwidth", version, max_term_width = 100)]
pub(crate) struct Args {
    /// Folder that holds raw/, derived/ and reports/
    #[arg(long, global = true, env = "ZWIDTH_ROOT", default_value = ".", value_name = "DIR")]
    pub(crate) root: PathBuf,
    /// Listings as JSON, for machines
    #[arg(long, global = true)]
    pub(crate) json: bool,
    /// Number of threads [default: all cores]
    #[arg(long, global = true, value_name = "N")]
    pub(crate) threads: Option<usize>,
    /// Only results, warnings and errors
    #[arg(long, short, global = true)]
    pub(crate) quiet: bool,
    /// Say why each thing is made again
    #[arg(long, short, global = true)]
    pub(crate) verbose: bool,
    #[command(subcommand)]
    pub(crate) command: Command,
}

#[derive(Debug, Subcommand)]
pub(crate) enum Command {
    /// The main job: raw data to every figure, table and summary; does only what changed
    Run(Run),
    /// Write a commented study.toml for a new study
    New {
        /// The study's id: a folder's name under raw/
        study: StudyId,
    },
    /// Bring in recordings of other rigs, as a mapping file says
    Import(Import),
    /// Check studies: every finding, with file, column, row and remedy
    Verify {
        /// Studies to check [default: all under raw/]
        studies: Vec<StudyId>,
    },
    /// Studies, sessions and trials; what is missing
    List {
        /// A study [default: all]
        study: Option<StudyId>,
    },
    /// Print a table of a study, or list its tables
    Table(Table),
    /// Completions for a shell
    Completions {
        /// The shell
        shell: clap_complete::Shell,
    },
    /// The manual page
    Man,
}

#[derive(Debug, clap::Args)]
pub(crate) struct Run {
    /// Studies to run [default: all under raw/]
    pub(crate) studies: Vec<StudyId>,
    /// Make everything again
    #[arg(long)]
    pub(crate) fresh: bool,
    /// Only this stage, figure or table, and what it needs
    #[arg(long, value_name = "STAGE|FIGURE|TABLE")]
    pub(crate) only: Option<String>,
    /// Say what would be made, and why; make nothing
    #[arg(long)]
    pub(crate) dry_run: bool,
}

#[derive(Debug, clap::Args)]
pub(crate) struct Import {
    /// The study the recordings belong to; its study.toml must exist
    pub(crate) study: StudyId,
    /// The mapping file: their columns to ours
    #[arg(long, value_name = "MAP.toml")]
    pub(crate) map: PathBuf,
    /// The recordings
    #[arg(required = true)]
    pub(crate) files: Vec<PathBuf>,
}

#[derive(Debug, clap::Args)]
pub(crate) struct Table {
    /// The study
    pub(crate) study: StudyId,
    /// The table; without it the tables there are get listed
    pub(crate) name: Option<String>,
    /// The form in which to print it
    #[arg(long, value_enum, default_value_t = TableFormat::Md)]
    pub(crate) format: TableFormat,
}

/// Forms in which a table can be printed.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub(crate) enum TableFormat {
    /// LaTeX (booktabs, siunitx)
    Tex,
    /// Typst
    Typ,
    /// Markdown
    Md,
    /// CSV, full precision
    Csv,
    /// HTML
    Html,
}

impl From<TableFormat> for Format {
    fn from(format: TableFormat) -> Self {
        match format {
            TableFormat::Tex => Self::Latex,
            TableFormat::Typ => Self::Typst,
            TableFormat::Md => Self::Markdown,
            TableFormat::Csv => Self::Csv,
            TableFormat::Html => Self::Html,
        }
    }
}
