//! The one place that prints.

use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};
use serde::Serialize;
use std::io::{IsTerminal as _, Write as _};

/// Where words go: results to standard output, progress and errors to standard error.
pub(crate) struct Screen {
    quiet: bool,
    pub(crate) verbose: bool,
    pub(crate) json: bool,
    bold: bool,
}

impl Screen {
    pub(crate) fn new(quiet: bool, verbose: bool, json: bool) -> Self {
        let colour =
            std::io::stderr().is_terminal() && std::env::var_os("NO_COLOR").is_none_or(|v| v.is_empty());
        Self { quiet, verbose, json, bold: colour }
    }

    /// A result, on standard output. A reader that went away (`| head`) is no error.
    pub(crate) fn result(&self, text: impl AsRef<str>) {
        let _ = writeln!(std::io::stdout(), "{}", text.as_ref().trim_end_matches('\n'));
    }

    /// A listing for machines.
    pub(crate) fn listing(&self, value: &impl Serialize) -> anyhow::Result<()> {
        self.result(serde_json::to_string_pretty(value)?);
        Ok(())
    }

    /// Something a person wants to know while the work goes on.
    pub(crate) fn say(&self, text: impl AsRef<str>) {
        if !self.quiet {
            let _ = writeln!(std::io::stderr(), "{}", text.as_ref());
        }
    }

    /// Something skipped or lost.
    pub(crate) fn warn(&self, text: impl AsRef<str>) {
        let _ = writeln!(std::io::stderr(), "{} {}", self.paint("warning:", "33"), text.as_ref());
    }

    /// What made the program fail.
    pub(crate) fn error(&self, error: &anyhow::Error) {
        let _ = writeln!(std::io::stderr(), "{} {error:#}", self.paint("error:", "31"));
    }

    /// A progress bar; none where nobody looks.
    pub(crate) fn bar(&self, length: usize) -> ProgressBar {
        let target = if self.quiet { ProgressDrawTarget::hidden() } else { ProgressDrawTarget::stderr() };
        let bar = ProgressBar::with_draw_target(Some(length as u64), target);
        let style = ProgressStyle::with_template("{bar:30} {pos}/{len} {msg}");
        bar.with_style(style.unwrap_or_else(|_| ProgressStyle::default_bar()))
    }

    fn paint(&self, text: &str, colour: &str) -> String {
        if self.bold { format!("\u{1b}[1;{colour}m{text}\u{1b}[0m") } else { text.to_owned() }
    }
}
