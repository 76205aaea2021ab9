//! The one place that prints.

use indicatif::{MultiProgress, ProgressBar, ProgressDrawTarget, ProgressStyle};
use serde::Serialize;
use std::collections::BTreeMap;
use std::io::{self, ErrorKind, IsTerminal as _, Write as _};
use std::path::PathBuf;
use std::sync::{Mutex, PoisonError};
use zwidth_study::{printable, printable_lines};

/// Where words go: results to standard output, progress and errors to standard error.
pub(crate) struct Screen {
    pub(crate) quiet: bool,
    pub(crate) verbose: bool,
    pub(crate) json: bool,
    bold: bool,
    /// Why standard output could not be written.
    unwritten: Mutex<Option<io::Error>>,
}

impl Screen {
    pub(crate) fn new(quiet: bool, verbose: bool, json: bool) -> Self {
        let colour = std::io::stderr().is_terminal()
            && std::env::var_os("NO_COLOR").is_none_or(|v| v.is_empty());
        Self { quiet, verbose, json, bold: colour, unwritten: Mutex::default() }
    }

    /// Letters in a line of standard output, where it is a terminal.
    pub(crate) fn width(&self) -> Option<usize> {
        std::io::stdout().is_terminal().then(zwidth_acquire::terminal_width).flatten()
    }

    /// A result, on standard output.
    pub(crate) fn result(&self, text: impl AsRef<str>) {
        self.print(&printable_lines(text.as_ref().trim_end_matches('\n')));
    }

    /// Prints on standard output. A reader that went away (`| head`) is no error; any other is kept for
    /// [`Self::check`].
    fn print(&self, text: &str) {
        let mut out = io::stdout().lock();
        let Err(error) = writeln!(out, "{text}").and_then(|()| out.flush()) else { return };
        // The first error stays: those after it follow from it.
        if error.kind() != ErrorKind::BrokenPipe {
            self.unwritten.lock().unwrap_or_else(PoisonError::into_inner).get_or_insert(error);
        }
    }

    /// Whether all results could be printed.
    ///
    /// # Errors
    /// Standard output could not be written: a full disk.
    pub(crate) fn check(&self) -> anyhow::Result<()> {
        match self.unwritten.lock().unwrap_or_else(PoisonError::into_inner).take() {
            Some(error) => anyhow::bail!(
                "what is printed could not be written: {error}; what came is cut off, and the command must be given \
                 again"
            ),
            None => Ok(()),
        }
    }

    /// A file's text, on standard output: as it is for a program that reads it, safe on a terminal.
    pub(crate) fn file(&self, text: &str) {
        if std::io::stdout().is_terminal() {
            return self.result(text);
        }
        self.print(text.trim_end_matches('\n'));
    }

    /// A listing for machines.
    pub(crate) fn listing(&self, value: &impl Serialize) -> anyhow::Result<()> {
        self.file(&serde_json::to_string_pretty(value)?);
        Ok(())
    }

    /// What a command gives: a listing for machines, or what `tell` says to people.
    pub(crate) fn give(&self, value: &impl Serialize, tell: impl FnOnce()) -> anyhow::Result<()> {
        if self.json {
            return self.listing(value);
        }
        tell();
        Ok(())
    }

    /// Something a person wants to know while the work goes on.
    pub(crate) fn say(&self, text: impl AsRef<str>) {
        if !self.quiet {
            let _ = writeln!(std::io::stderr(), "{}", printable_lines(text.as_ref()));
        }
    }

    /// Something skipped or lost.
    pub(crate) fn warn(&self, text: impl AsRef<str>) {
        self.marked("warning:", "33", text.as_ref());
    }

    /// What made the program fail.
    pub(crate) fn error(&self, error: &anyhow::Error) {
        self.marked("error:", "31", &format!("{error:#}"));
    }

    /// A text after a word in colour.
    fn marked(&self, word: &str, colour: &str, text: &str) {
        let word = match self.bold {
            true => format!("\u{1b}[1;{colour}m{word}\u{1b}[0m"),
            false => word.to_owned(),
        };
        let _ = writeln!(std::io::stderr(), "{word} {}", printable_lines(text));
    }

    /// The paths of those of the files that have one of the extensions, indented.
    pub(crate) fn files(&self, files: &[PathBuf], extensions: &[&str], indent: &str) {
        for path in files {
            let extension = path.extension().and_then(|extension| extension.to_str());
            if extension.is_some_and(|extension| extensions.contains(&extension)) {
                self.result(format!("{indent}{}", path.display()));
            }
        }
    }

    /// A progress bar; none where nobody looks.
    pub(crate) fn bar(&self, length: usize) -> ProgressBar {
        let bar = ProgressBar::with_draw_target(Some(length as u64), self.target());
        bar.with_style(style("{bar:30} {pos}/{len} {eta} left {msg}"))
    }

    /// A progress bar over bytes; none where there are none, or nobody looks.
    pub(crate) fn bytes(&self, length: u64) -> ProgressBar {
        let target = if length > 0 { self.target() } else { ProgressDrawTarget::hidden() };
        let bar = ProgressBar::with_draw_target(Some(length), target);
        bar.with_style(style("{bar:30} {bytes}/{total_bytes} {eta} left"))
    }

    /// One progress bar per stage, one below the other, in the order given; none where nobody
    /// looks.
    pub(crate) fn bars(&self, stages: impl IntoIterator<Item = (&'static str, usize)>) -> Bars {
        Bars::new(stages, self.target())
    }

    /// Where bars go: indicatif draws none where standard error is no terminal, or one that cannot
    /// move its cursor.
    fn target(&self) -> ProgressDrawTarget {
        if self.quiet { ProgressDrawTarget::hidden() } else { ProgressDrawTarget::stderr() }
    }
}

/// In characters of one colour alone, so that `NO_COLOR` has nothing to take away.
fn style(template: &str) -> ProgressStyle {
    ProgressStyle::with_template(template).unwrap_or_else(|_| ProgressStyle::default_bar())
}

/// One progress bar per stage.
pub(crate) struct Bars {
    all: MultiProgress,
    stages: BTreeMap<&'static str, ProgressBar>,
    /// All jobs together, with the time left: stages go on side by side, and those that wait for
    /// others cannot tell theirs.
    whole: ProgressBar,
}

impl Bars {
    fn new(
        stages: impl IntoIterator<Item = (&'static str, usize)>,
        target: ProgressDrawTarget,
    ) -> Self {
        let all = MultiProgress::with_draw_target(target);
        let stages: Vec<(&'static str, usize)> = stages.into_iter().collect();
        let jobs: usize = stages.iter().map(|(_, length)| length).sum();
        let mut bars = BTreeMap::new();
        for (stage, length) in stages {
            let bar = all.add(ProgressBar::new(length as u64)).with_prefix(stage);
            let style = style("{prefix:>13}  {bar:30} {pos}/{len} {msg}");
            bars.insert(stage, bar.with_style(style));
        }
        // Added last, so that it stands below the stages.
        let whole = all.add(ProgressBar::new(jobs as u64)).with_prefix("all");
        let whole = whole.with_style(style("{prefix:>13}  {bar:30} {pos}/{len} {eta} left"));
        Self { stages: bars, whole, all }
    }

    /// One job of the stage is done; `what` it was.
    pub(crate) fn done(&self, stage: &str, what: &str) {
        let Some(bar) = self.stages.get(stage) else { return };
        bar.set_message(printable(what).into_owned());
        bar.inc(1);
        self.whole.inc(1);
        if bar.length() == Some(bar.position()) {
            bar.finish_with_message("");
        }
    }

    /// Takes the bars off the screen again.
    pub(crate) fn clear(&self) {
        // Whoever cannot be drawn to sees no bars either.
        let _ = self.all.clear();
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use indicatif::TermLike;
    use std::io;
    use std::sync::{Arc, Mutex};

    /// A terminal that remembers what was written to it.
    #[derive(Debug, Clone, Default)]
    struct Paper(Arc<Mutex<String>>);

    impl Paper {
        fn text(&self) -> String {
            self.0.lock().unwrap().clone()
        }
    }

    impl TermLike for Paper {
        fn width(&self) -> u16 {
            100
        }
        fn move_cursor_up(&self, _: usize) -> io::Result<()> {
            Ok(())
        }
        fn move_cursor_down(&self, _: usize) -> io::Result<()> {
            Ok(())
        }
        fn move_cursor_right(&self, _: usize) -> io::Result<()> {
            Ok(())
        }
        fn move_cursor_left(&self, _: usize) -> io::Result<()> {
            Ok(())
        }
        fn write_line(&self, text: &str) -> io::Result<()> {
            self.write_str(&format!("{text}\n"))
        }
        fn write_str(&self, text: &str) -> io::Result<()> {
            self.0.lock().unwrap().push_str(text);
            Ok(())
        }
        fn clear_line(&self) -> io::Result<()> {
            Ok(())
        }
        fn flush(&self) -> io::Result<()> {
            Ok(())
        }
    }

    #[test]
    fn every_stage_has_a_line_of_its_own_without_colour() {
        let paper = Paper::default();
        let bars = Bars::new(
            [("metrics", 2), ("figures", 1)],
            ProgressDrawTarget::term_like(Box::new(paper.clone())),
        );
        bars.done("metrics", "metrics P01 S01");
        bars.done("figures", "figure likert");
        bars.done("no such stage", "nothing");
        bars.done("metrics", "metrics of the study");
        let text = paper.text();
        let line = |words: &[&str]| text.lines().any(|l| words.iter().all(|w| l.contains(w)));
        assert!(line(&["      metrics  ", "2/2"]) && line(&["      figures  ", "1/1"]), "{text:?}");
        assert!(line(&["          all  ", "3/3", " left"]), "{text:?}");
        assert!(!text.contains("\u{1b}["), "neither colours nor anything else but text: {text:?}");
    }

    #[test]
    fn nothing_is_drawn_for_quiet_people() {
        let screen = Screen::new(true, false, false);
        let bars = screen.bars([("metrics", 1)]);
        bars.done("metrics", "metrics P01 S01");
        assert!(bars.all.is_hidden());
    }
}
