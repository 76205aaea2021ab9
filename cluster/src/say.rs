//! What is told on the way, and the log of the engine.

use log::{Level, LevelFilter, Log, Metadata, Record};
use std::io::Write as _;

/// How much to say.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Say {
    pub(crate) quiet: bool,
}

impl Say {
    /// What others wait for, on standard output.
    pub(crate) fn result(self, text: String) {
        // A reader that went away is no error.
        let _ = writeln!(std::io::stdout(), "{text}");
    }

    /// How far things are.
    #[allow(clippy::print_stderr)] // this is the program's voice
    pub(crate) fn progress(self, text: String) {
        if !self.quiet {
            eprintln!("{text}");
        }
    }

    /// What went wrong, and did not end the work.
    #[allow(clippy::print_stderr)]
    pub(crate) fn warn(self, text: String) {
        eprintln!("warning: {text}");
    }

    /// What ended it.
    #[allow(clippy::print_stderr)]
    pub(crate) fn error(self, error: &anyhow::Error) {
        eprintln!("error: {error:#}");
    }
}

/// The engine's own words, line by line.
struct Lines;

impl Log for Lines {
    fn enabled(&self, _: &Metadata) -> bool {
        true
    }

    #[allow(clippy::print_stderr)]
    fn log(&self, record: &Record) {
        if record.level() <= log::max_level() {
            eprintln!("{}: {}: {}", record.level(), record.target(), record.args());
        }
    }

    fn flush(&self) {}
}

/// Lets the engine log: what went wrong, or also what goes on. To a client it reports its failures
/// anyway.
pub(crate) fn log_engine(verbose: bool, serves: bool) {
    let level = match (verbose, serves) {
        (true, _) => LevelFilter::Info,
        (false, true) => Level::Warn.to_level_filter(),
        (false, false) => LevelFilter::Off,
    };
    if log::set_logger(&Lines).is_ok() {
        log::set_max_level(level);
    }
}
