//! The report on an import: for people (`Display`) and for machines (`Serialize`).

use serde::Serialize;
use std::collections::BTreeSet;
use std::fmt;
use std::path::Path;
use zwidth_store::Signal;
use zwidth_study::{StudyId, printable};

/// Columns that a line names: a file may have thousands. For machines all are listed.
const MOST_NAMED: usize = 20;

/// What an import read, made, and left out.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
pub struct Report {
    /// The study that was imported into.
    pub study: StudyId,
    /// One entry a file, in the order of their names.
    pub files: Vec<FileReport>,
    /// Trial files written.
    pub trials: usize,
    /// Sweep files written.
    pub sweeps: usize,
    /// New sessions.
    pub sessions: usize,
    /// Answers written as events.
    pub answers: usize,
    /// Trials that were excluded.
    pub exclusions: usize,
    /// Rows that were added to the participants' file.
    pub participants: usize,
    /// Differences of the new sessions from the plan in study.toml.
    pub against_plan: Vec<Unplanned>,
}

/// Something that is more, less or other than planned.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
pub struct Unplanned {
    /// The session's record, or the trial's file.
    pub file: String,
    /// The finding, and what to do.
    pub what: String,
}

/// The report on one file.
#[derive(Debug, Clone, PartialEq, Eq, Default, Serialize)]
pub struct FileReport {
    /// The file, as it was given.
    pub file: String,
    /// Rows in the file.
    pub rows_read: usize,
    /// Rows that went into the results.
    pub rows_kept: usize,
    /// Rows left out, and why.
    pub rows_dropped: Vec<RowsDropped>,
    /// Columns left out, and why.
    pub columns_dropped: Vec<ColumnDropped>,
    /// Columns that were taken, each with unit and conversion.
    pub converted: Vec<String>,
    /// What the recording does not have and was computed; the files made say it too.
    pub computed: Vec<String>,
    /// Columns of ours that the recording lacks: null, never invented.
    pub null: Vec<String>,
    /// The trials, sweeps or answers that the file became.
    pub made: Vec<String>,
    /// Assumptions made in reading it.
    pub told: Vec<String>,
    /// The trials that the study has of it already: nothing was made of it.
    pub there: Option<String>,
    /// The parts that could not be read: its results are to be read with care, and say so.
    pub lost: Option<String>,
    /// What its trials say against their units, signs, clock and sensors: they were imported, and
    /// are to be read with care.
    pub care: Vec<String>,
}

/// Rows left out.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
pub struct RowsDropped {
    /// Their number.
    pub rows: usize,
    /// Why.
    pub why: String,
}

/// A column left out.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
pub struct ColumnDropped {
    /// Its name, or its position.
    pub column: String,
    /// Why.
    pub why: String,
}

/// The signals that are not among these, by name. Those of space are missed where some of them are there.
pub(super) fn null_columns(present: &[Signal]) -> Vec<String> {
    let schema = present.iter().map(|signal| signal.schema()).max().unwrap_or_default();
    Signal::of(schema).filter(|s| !present.contains(s)).map(|s| s.name().to_owned()).collect()
}

impl Report {
    /// Whether something that was imported is to be read with care.
    pub fn is_doubtful(&self) -> bool {
        !self.against_plan.is_empty() || self.files.iter().any(FileReport::is_doubtful)
    }
}

impl fmt::Display for Report {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        for (i, file) in self.files.iter().enumerate() {
            // Forty-eight files of one kind are told once.
            let is_as_above =
                i > 0 && file.there.is_none() && self.files[i - 1].form() == file.form();
            let lines = if is_as_above { file.brief() } else { file.lines() };
            // Names of others stand in each line.
            lines.iter().try_for_each(|line| writeln!(f, "{}", printable(line)))?;
            let ends = self.files.get(i + 1).is_none_or(|next| next.form() != file.form());
            if ends {
                writeln!(f)?;
            }
        }
        let mut alike: Vec<(&str, Vec<&str>)> = Vec::new();
        for Unplanned { file, what } in &self.against_plan {
            match alike.iter_mut().find(|(other, _)| other == what) {
                Some((_, files)) => files.push(file),
                None => alike.push((what, vec![file])),
            }
        }
        for (what, files) in alike {
            writeln!(f, "read with care: {}: {}", printable(files[0]), printable(what))?;
            if files.len() > 1 {
                writeln!(
                    f,
                    "  likewise {} others (`zwidth verify {}` lists them)",
                    files.len() - 1,
                    self.study
                )?;
            }
        }
        if !self.against_plan.is_empty() {
            writeln!(f)?;
        }
        let counts = [
            (self.trials, "trial"),
            (self.sweeps, "sweep"),
            (self.sessions, "session"),
            (self.answers, "answer"),
            (self.exclusions, "exclusion"),
            (self.participants, "participant"),
        ];
        let results = counts.iter().filter(|(n, _)| *n > 0).map(|(n, what)| count_of(*n, what));
        let left_out = self.files.iter().filter(|file| file.there.is_some()).count();
        let new = self.files.len() - left_out;
        let files = count_of(new, "file");
        match new {
            0 => write!(f, "nothing new for study {}", self.study)?,
            _ => write!(
                f,
                "{files} imported into study {}: {}",
                self.study,
                results.collect::<Vec<_>>().join(", ")
            )?,
        }
        match left_out {
            0 => {}
            1 => write!(f, "; 1 was there already")?,
            n => write!(f, "; {n} were there already")?,
        }
        match self.files.iter().filter(|file| file.is_doubtful()).count() {
            0 => Ok(()),
            n if n == new => write!(f, "; all have warnings, listed above"),
            n => write!(f, "; {n} of {files} have warnings, listed above"),
        }
    }
}

fn count_of(n: usize, what: &str) -> String {
    format!("{n} {what}{}", if n == 1 { "" } else { "s" })
}

impl FileReport {
    /// The report on a file of which the study has the trials already.
    pub(super) fn there_already(path: &Path, trials: &str) -> Self {
        Self {
            file: printable(&path.to_string_lossy()).into_owned(),
            there: Some(format!("it is in the study already, as {trials}: left out")),
            ..Self::default()
        }
    }

    /// Whether something that was made of it is to be read with care.
    fn is_doubtful(&self) -> bool {
        self.lost.is_some() || !self.care.is_empty()
    }

    /// Adds the empty rows between the first row with a value and the last.
    pub(super) fn add_empty(&mut self, rows: usize, why: &str) {
        if rows > 0 {
            self.rows_read = self.rows_read.saturating_add(rows);
            self.rows_dropped.push(RowsDropped { rows, why: why.to_owned() });
        }
    }

    /// Adds the rows of a questionnaire that are its header once more.
    pub(super) fn add_headers(&mut self, rows: usize) {
        if rows > 0 {
            let why = "the header, which comes again".to_owned();
            self.rows_dropped.push(RowsDropped { rows, why });
        }
    }

    /// The lines that its report shares with those of files of the same kind.
    fn form(&self) -> Vec<String> {
        let rest = Self { made: Vec::new(), care: Vec::new(), ..self.clone() };
        // The first line names the file.
        rest.lines().split_off(1)
    }

    /// The lines of its report that other files do not share.
    fn brief(&self) -> Vec<String> {
        let Self { file, rows_read, rows_kept, made, care, .. } = self.clone();
        let own = Self { file, rows_read, rows_kept, made, care, ..Self::default() };
        let mut lines = own.lines();
        lines[0] += "; otherwise as above";
        lines
    }

    fn lines(&self) -> Vec<String> {
        if let Some(there) = &self.there {
            return vec![format!("{}: {there}", self.file)];
        }
        let read = count_of(self.rows_read, "row");
        let mut lines = vec![format!("{}: {read} read, {} kept", self.file, self.rows_kept)];
        for RowsDropped { rows, why } in &self.rows_dropped {
            lines.push(format!("  dropped   {}: {why}", count_of(*rows, "row")));
        }
        lines.extend(self.told.iter().map(|line| format!("  noted     {line}")));
        // Forty questionnaire columns with one reason are one line.
        for why in self.columns_dropped.iter().map(|c| &c.why).collect::<BTreeSet<_>>() {
            let same =
                self.columns_dropped.iter().filter(|c| c.why == *why).map(|c| c.column.as_str());
            let same: Vec<&str> = same.collect();
            let what = if same.len() == 1 { "column" } else { "columns" };
            let named = same.iter().take(MOST_NAMED).copied().collect::<Vec<_>>().join(", ");
            let more = match same.len().saturating_sub(MOST_NAMED) {
                0 => String::new(),
                n => format!(" and {n} more"),
            };
            lines.push(format!("  dropped   {what} {named}{more}: {why}"));
        }
        for (head, what) in
            [("converted", &self.converted), ("computed", &self.computed), ("made", &self.made)]
        {
            lines.extend(what.iter().map(|line| format!("  {head:<9} {line}")));
        }
        let care = self.lost.iter().chain(&self.care);
        lines.extend(care.map(|line| format!("  read with care: {line}")));
        if !self.null.is_empty() {
            lines.push(format!("  null      {}", self.null.join(", ")));
        }
        lines
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn of_thousands_of_columns_the_first_are_named_and_the_others_counted() {
        let why = "not mapped".to_owned();
        let column = |i| ColumnDropped { column: format!("c{i}"), why: why.clone() };
        let columns_dropped: Vec<_> = (1..=16_000).map(column).collect();
        let lines = FileReport { columns_dropped, ..FileReport::default() }.lines();
        assert!(lines[1].ends_with("c19, c20 and 15980 more: not mapped"), "{}", lines[1]);
    }

    #[test]
    fn the_report_reads_as_a_list_a_file() {
        let why = "not mapped".to_owned();
        let column = |column: &str| ColumnDropped { column: column.to_owned(), why: why.clone() };
        let file = FileReport {
            file: "K_1.csv".to_owned(),
            rows_read: 10,
            rows_kept: 9,
            rows_dropped: vec![RowsDropped { rows: 1, why: "a mapped cell is empty".to_owned() }],
            columns_dropped: vec![column("a"), column("b")],
            converted: vec!["theta_rad ← x (mm)".to_owned()],
            null: vec!["flags".to_owned()],
            made: vec!["trial 1".to_owned()],
            told: vec!["cells stand between tabs".to_owned()],
            care: vec!["column t_s: it jumps; mend it".to_owned()],
            ..FileReport::default()
        };
        let study = StudyId::new("demo").unwrap();
        let report = Report {
            study,
            files: vec![file],
            trials: 1,
            sweeps: 0,
            sessions: 1,
            answers: 0,
            exclusions: 0,
            participants: 0,
            against_plan: vec![],
        };
        let expect = "\
K_1.csv: 10 rows read, 9 kept
  dropped   1 row: a mapped cell is empty
  noted     cells stand between tabs
  dropped   columns a, b: not mapped
  converted theta_rad ← x (mm)
  made      trial 1
  read with care: column t_s: it jumps; mend it
  null      flags

1 file imported into study demo: 1 trial, 1 session; all have warnings, listed above";
        assert_eq!(report.to_string(), expect);
        assert!(serde_json::to_string(&report).unwrap().contains("\"rows_read\":10"));
    }
}
