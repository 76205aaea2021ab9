//! Checks a mapping file: from its tables and keys to a [`Mapping`], or every problem with its
//! line.

use super::label::{Label, LabelShape};
use super::limits::{LONG_FROM, MOST_ERRORS, MOST_MAPPING};
use super::mapping::{
    Beside, CellForm, Content, Exclusions, FileForm, Mapping, Origin, PeopleFrom, TrialFrom,
    TrialsFrom, Who,
};
use super::shape::{
    Backwards, ChannelShape, ColumnShape, ExcludeShape, FileShape, KindShape, PeopleShape, Shape,
    SignalsIn, Split, TimeShape, TrialShape, ZeroShape,
};
use super::table::ColumnRef;
use super::xdf::XdfClock;
use regex::Regex;
use std::collections::BTreeMap;
use std::path::Path;
use zwidth_store::{FirstErrors, Signal, StoreError, hex_blake3, read_named};
use zwidth_study::{StudyError, line_of, toml_error};

impl Mapping {
    /// Reads and checks a mapping file that a person named; nothing but a regular file will do.
    ///
    /// # Errors
    /// Those of reading it, and of [`Mapping::from_toml`].
    pub fn read(path: &Path) -> Result<Self, FirstErrors> {
        let bytes = read_named(path, MOST_MAPPING).map_err(|e| StoreError::io(path, "read", &e))?;
        let text = String::from_utf8(bytes).map_err(|e| {
            let what = format!("byte {} is not UTF-8", e.utf8_error().valid_up_to());
            StoreError::new(path, what, "save the mapping as UTF-8")
        })?;
        Self::from_toml(&text, path)
    }

    /// Reads and checks a mapping file's text; `path` names it in errors.
    ///
    /// # Errors
    /// Every problem found, each with its line and key: text that is not TOML, an unknown key, an
    /// unknown column of ours, a unit that does not fit, a pattern that is no regular expression, …
    pub fn from_toml(text: &str, path: &Path) -> Result<Self, FirstErrors> {
        // Some editors put a byte-order mark first.
        let text = text.strip_prefix('\u{feff}').unwrap_or(text);
        let mut check = Check { text, errors: Vec::new(), more: 0 };
        let mapping = match toml::from_str::<Shape>(text) {
            Ok(shape) => check.mapping(shape, path),
            Err(error) => {
                check.errors.push(toml_error(text, &error));
                None
            }
        };
        // A mapping may come out although something is wrong with it.
        if let Some(mapping) = mapping.filter(|_| check.errors.is_empty()) {
            return Ok(mapping);
        }
        let remedy = "mend the line; docs/import.md explains the keys";
        let errors = check.errors.iter();
        let mut errors: FirstErrors =
            errors.map(|problem| StoreError::new(path, problem.to_string(), remedy)).collect();
        errors.count(check.more);
        Err(errors)
    }
}

/// Collects problems while the shapes are checked.
pub(super) struct Check<'a> {
    text: &'a str,
    pub(super) errors: Vec<StudyError>,
    /// The number of problems beyond those.
    more: usize,
}

impl Check<'_> {
    pub(super) fn error(&mut self, key: &str, problem: impl Into<String>) {
        // Each reads the text again for its line: a file of many mistakes would take for ever.
        if self.errors.len() == MOST_ERRORS {
            self.more += 1;
            return;
        }
        let line = line_of(self.text, key);
        self.errors.push(StudyError { line, key: key.to_owned(), problem: problem.into() });
    }

    /// The value, or its problem noted.
    pub(super) fn keep<T>(&mut self, key: &str, result: Result<T, String>) -> Option<T> {
        result.map_err(|problem| self.error(key, problem)).ok()
    }

    pub(super) fn required<T>(&mut self, key: &str, value: Option<T>) -> Option<T> {
        if value.is_none() {
            self.error(key, "is missing; this kind of mapping needs it");
        }
        value
    }

    fn mapping(&mut self, shape: Shape, path: &Path) -> Option<Mapping> {
        self.refuse_unused(&shape);
        let mut file = self.file("file", &shape.file);
        if let Some(time) = &shape.time {
            file.splits_at_time |= time.backwards == Some(Backwards::Split);
            file.clock = time.clock.unwrap_or_default();
            file.dejitter = time.dejitter.unwrap_or(file.clock == XdfClock::Corrected);
            // Nanoseconds since 1970 have more digits than a double holds: the file's first is subtracted
            // before they become one.
            let is_exact = time.zero.is_some() && time.unit.as_deref() == Some("ns");
            file.whole =
                is_exact || time.wrap.is_some() || time.equal.is_some() || time.counter.is_some();
        }
        file.whole |= shape.column.iter().any(|c| c.wrap.is_some());
        let zeros = shape.column.iter().map(|c| c.zero).chain(shape.channel.iter().map(|c| c.zero));
        // A zero from a stretch needs all rows of a trial, and an unwrapped angle those before it.
        file.whole |= zeros.into_iter().any(|zero| matches!(zero, Some(ZeroShape::Rest(_))));
        let has_time =
            shape.time.as_ref().is_some_and(|time| time.from.is_some() || time.counter.is_some());
        if file.splits_at_time && (shape.kind != KindShape::Trials || !has_time) {
            self.error("file.split", "needs trials with a column of time: `from` in [time]");
        }
        let name = shape.name.and_then(|n| self.regex("name.pattern", &n.pattern));
        let groups: Vec<&str> = name.iter().flat_map(Regex::capture_names).flatten().collect();
        let content = match shape.kind {
            KindShape::Trials => {
                // What is joined to it, and what of a trial is read beside its samples, needs all of its rows.
                file.whole |= shape.log.is_some()
                    || !shape.with.is_empty()
                    || shape.questions.is_some()
                    || shape.task.is_some();
                let beside = self.beside(
                    shape.log,
                    shape.with,
                    shape.questions,
                    shape.task,
                    shape.trial.as_ref(),
                    &groups,
                );
                self.trials(shape.trial, shape.time, shape.column, shape.channel, beside, &groups)
            }
            KindShape::Sweeps => {
                let quantities = [shape.command, shape.response];
                self.sweeps(shape.sweep, shape.time, quantities, shape.wide, &groups)
            }
            KindShape::Likert => {
                let questions = shape.questions.unwrap_or_default();
                self.likert(shape.trial, questions, shape.condition, &groups)
            }
            KindShape::Psychometric => self.psychometric(shape.trial, shape.task, &groups),
            KindShape::Exclusions => self.exclusions(shape.exclude, &groups),
            KindShape::Participants => self.people(shape.people, &groups),
        }?;
        if let Content::Trials(from) = &content {
            let TrialsFrom { columns, channels, .. } = &**from;
            let bits = columns.iter().filter(|column| column.to == Signal::StateBits);
            let bits = bits.filter_map(|column| match &column.origin {
                Origin::Column { column, .. } => Some(&column.from),
                Origin::Derived(_) => None,
            });
            // What a channel of the study's own holds may be whether a button was pressed.
            file.cells.truths = bits.chain(channels.iter().map(|c| &c.from)).cloned().collect();
        }
        let blake3 = hex_blake3(self.text.as_bytes());
        let drop = shape.drop;
        let simulated = shape.simulated;
        Some(Mapping { path: path.to_owned(), blake3, file, simulated, drop, content, name })
    }

    /// A table that the kind gives no meaning to is a mistake.
    fn refuse_unused(&mut self, shape: &Shape) {
        use KindShape::{Exclusions, Likert, Participants, Psychometric, Sweeps, Trials};
        let kind = shape.kind;
        for (table, is_present, is_used) in [
            ("trial", shape.trial.is_some(), matches!(kind, Trials | Likert | Psychometric)),
            ("time", shape.time.is_some(), matches!(kind, Trials | Sweeps)),
            ("column", !shape.column.is_empty(), kind == Trials),
            ("channel", !shape.channel.is_empty(), kind == Trials),
            ("sweep", shape.sweep.is_some(), kind == Sweeps),
            ("command", shape.command.is_some(), kind == Sweeps),
            ("response", shape.response.is_some(), kind == Sweeps),
            ("wide", shape.wide.is_some(), kind == Sweeps),
            ("questions", shape.questions.is_some(), matches!(kind, Likert | Trials)),
            ("condition", !shape.condition.is_empty(), kind == Likert),
            ("task", shape.task.is_some(), matches!(kind, Psychometric | Trials)),
            ("log", shape.log.is_some(), kind == Trials),
            ("with", !shape.with.is_empty(), kind == Trials),
            ("exclude", shape.exclude.is_some(), kind == Exclusions),
            ("people", shape.people.is_some(), kind == Participants),
        ] {
            if is_present && !is_used {
                self.error(table, "is not used in a mapping of this kind; remove it");
            }
        }
    }

    pub(super) fn regex(&mut self, key: &str, pattern: &str) -> Option<Regex> {
        let regex = Regex::new(pattern).map_err(|e| {
            // The reason stands in the last line, below the pattern.
            let why = e.to_string();
            let why = why.lines().next_back().unwrap_or_default();
            format!("is not a regular expression: {why}")
        });
        self.keep(key, regex)
    }

    pub(super) fn file(&mut self, at: &str, f: &FileShape) -> FileForm {
        if !['.', ','].contains(&f.decimal) {
            self.error(&format!("{at}.decimal"), format!("'{}' must be \".\" or \",\"", f.decimal));
        }
        if f.decimal == ',' && f.delimiter == Some(',') {
            self.error(
                &format!("{at}.decimal"),
                "a comma cannot stand between cells and before decimals as well",
            );
        }
        if f.rows == Some(0) {
            self.error(&format!("{at}.rows"), "0 must be at least 1");
        }
        FileForm {
            format: f.format,
            delimiter: f.delimiter.and_then(|c| self.ascii(&format!("{at}.delimiter"), c)),
            cells: CellForm {
                decimal_comma: f.decimal == ',',
                missing: f.missing,
                missing_words: f.missing_words.clone(),
                truths: Vec::new(),
            },
            header: f.header,
            comment: f.comment.and_then(|c| self.ascii(&format!("{at}.comment"), c)),
            skip: f.skip,
            rows: f.rows,
            part: f.matrix.clone(),
            turned: f.signals == SignalsIn::Rows,
            encoding: f.encoding,
            bad_lines: f.bad_lines,
            splits_at_time: f.split == Some(Split::Time),
            long_from: LONG_FROM,
            whole: false,
            clock: XdfClock::default(),
            dejitter: true,
        }
    }

    fn ascii(&mut self, key: &str, c: char) -> Option<u8> {
        let byte = u8::try_from(c).ok().filter(u8::is_ascii);
        self.keep(key, byte.ok_or_else(|| format!("'{c}' must be an ASCII character")))
    }

    pub(super) fn label(&mut self, key: &str, shape: LabelShape, groups: &[&str]) -> Option<Label> {
        self.keep(key, shape.check(groups))
    }

    pub(super) fn optional(
        &mut self,
        key: &str,
        shape: Option<LabelShape>,
        groups: &[&str],
    ) -> Option<Label> {
        shape.and_then(|shape| self.label(key, shape, groups))
    }

    pub(super) fn who(&mut self, shape: Option<TrialShape>, groups: &[&str]) -> Option<Who> {
        let shape = self.required("trial", shape)?;
        // All labels before the first `?`, so that every problem is told at once.
        let participant = self.label("trial.participant", shape.participant, groups);
        let session = self.label("trial.session", shape.session, groups);
        let environment = self.required("trial.environment", shape.environment);
        let environment = environment.and_then(|e| self.label("trial.environment", e, groups));
        let mode = self.required("trial.mode", shape.mode);
        let mode = mode.and_then(|mode| self.label("trial.mode", mode, groups));
        Some(Who {
            kind: self.optional("trial.kind", shape.kind, groups),
            repeat: self.optional("trial.repeat", shape.repeat, groups),
            trial: self.optional("trial.trial", shape.trial, groups),
            likert: self.optional("trial.likert", shape.likert, groups),
            participant: participant?,
            session: session?,
            environment: environment?,
            mode: mode?,
        })
    }

    fn people(&mut self, shape: Option<PeopleShape>, groups: &[&str]) -> Option<Content> {
        let shape = self.required("people", shape)?;
        if shape.columns.is_empty() {
            self.error("people.columns", "names no column; name those of [[people]] in study.toml");
        }
        let participant = self.label("people.participant", shape.participant, groups);
        for id in shape.units.keys().filter(|id| !shape.columns.contains_key(*id)) {
            let what = "is the unit of a column that [people.columns] does not have; add it there, or leave it out";
            self.error(&format!("people.units.{id}"), what);
        }
        let mut columns = BTreeMap::new();
        for (id, label) in shape.columns {
            let label = self.label(&format!("people.columns.{id}"), label, groups);
            columns.extend(label.map(|label| (id, label)));
        }
        Some(Content::People(PeopleFrom { participant: participant?, columns, units: shape.units }))
    }

    fn exclusions(&mut self, shape: Option<ExcludeShape>, groups: &[&str]) -> Option<Content> {
        let shape = self.required("exclude", shape)?;
        let named = [&shape.participant, &shape.session, &shape.trial];
        let is_named = named.iter().any(|label| label.is_some());
        if shape.recording.is_none() && shape.folder.is_some() {
            self.error("exclude.folder", "is where the files of `recording` lie; remove it");
        }
        let trial = match shape.recording {
            Some(column) if !is_named => {
                TrialFrom::Recording { column, folder: shape.folder.unwrap_or_default().into() }
            }
            Some(_) => {
                let what = "names the trial by its recording; participant, session and trial are not used beside it";
                self.error("exclude.recording", what);
                return None;
            }
            None => {
                let participant = self.required("exclude.participant", shape.participant);
                let session = self.required("exclude.session", shape.session);
                let trial = self.required("exclude.trial", shape.trial);
                TrialFrom::Labels(Box::new([
                    self.label("exclude.participant", participant?, groups)?,
                    self.label("exclude.session", session?, groups)?,
                    self.label("exclude.trial", trial?, groups)?,
                ]))
            }
        };
        let reason = self.label("exclude.reason", shape.reason, groups)?;
        let when = shape.when.into_iter().map(|(column, words)| (ColumnRef::Name(column), words));
        Some(Content::Exclusions(Exclusions { trial, when: when.collect(), reason }))
    }

    fn trials(
        &mut self,
        trial: Option<TrialShape>,
        time: Option<TimeShape>,
        columns: Vec<ColumnShape>,
        own: Vec<ChannelShape>,
        beside: Option<Beside>,
        groups: &[&str],
    ) -> Option<Content> {
        let who = self.who(trial, groups);
        let time = self.required("time", time).and_then(|t| self.time(t));
        if columns.is_empty() {
            self.error(
                "column",
                "is missing; a trial needs at least one [[column]] besides its time",
            );
        }
        let mut mapped = Vec::new();
        let mut above = Vec::new();
        for (i, shape) in columns.into_iter().enumerate() {
            let named = Signal::from_name(&shape.to);
            if let Some(column) = self.column(&format!("column[{i}]"), shape, &mapped, &above) {
                mapped.push(column);
            }
            // A column with an error of its own still counts for `derive`: one mistake is one error.
            above.extend(named);
        }
        let mut channels = Vec::new();
        for (i, shape) in own.into_iter().enumerate() {
            if let Some(channel) = self.channel(&format!("channel[{i}]"), shape, &channels) {
                channels.push(channel);
            }
        }
        let beside = beside?;
        let from = TrialsFrom { who: who?, time: time?, columns: mapped, channels, beside };
        self.check_files(&from);
        Some(Content::Trials(Box::new(from)))
    }
}

#[cfg(test)]
pub(super) mod tests {
    use super::super::mapping::Mapping;
    use super::super::world::{FORCE, ONE, trials_map};
    use std::path::Path;

    /// `text` with `from` replaced by `to` is refused in this line with these words.
    pub(in super::super) fn check(text: &str, from: &str, to: &str, line: usize, words: &str) {
        assert!(text.contains(from), "{from}");
        let errors =
            Mapping::from_toml(&text.replacen(from, to, 1), Path::new("map.toml")).unwrap_err();
        let shown = errors.iter().map(ToString::to_string).collect::<Vec<_>>().join("\n");
        assert!(shown.contains(&format!("map.toml: line {line}: ")), "{shown}");
        assert!(shown.contains(words), "{shown}");
    }

    #[test]
    fn unknown_keys_and_values_that_make_no_sense_are_refused_with_key_and_line() {
        let good = trials_map(&[ONE, FORCE]);
        assert!(Mapping::from_toml(&good, Path::new("map.toml")).is_ok());
        let other_unit = "column[0].unit: the unit 'mV' does not fit force_ex_n, which is in N; use one of N, mN";
        let no_column = "'force' is not a column of a trial; use one of t_device_s, theta_rad";
        let time = "from = \"t\"\nunit = \"s\"";
        for (from, to, line, words) in [
            ("mode = ", "mod = ", 7, "unknown field `mod`"),
            ("unit = \"N\"", "unti = \"N\"", 15, "unknown field `unti`"),
            ("[time]", "[times]", 9, "unknown field `times`"),
            ("\"trials\"", "\"trial\"", 1, "unknown variant `trial`"),
            ("mode = \"hybrid\"", "mode = { colum = 1 }", 7, "expected a fixed value"),
            ("mode = \"hybrid\"", "", 3, "trial.mode: is missing"),
            ("from = \"f\"", "from = -1", 14, "expected a column's name"),
            ("= \"N\"", "= ", 15, "string values must be quoted"),
            ("\"N\"", "\"mV\"", 15, other_unit),
            ("\"N\"", "\"furlong\"", 15, "the unit 'furlong' is unknown"),
            ("unit = \"N\"", "", 12, "column[0].unit: is missing"),
            ("\"force_ex_n\"", "\"force\"", 13, no_column),
            ("\"force_ex_n\"", "\"t_s\"", 13, "mapped in [time]"),
            ("\"N\"", "\"N\"\nsign = 2", 16, "column[0].sign: 2 must be 1 or -1"),
            ("\"N\"", "\"N\"\nscale = 0", 16, "other than 0"),
            ("\"N\"", "\"N\"\noffset = nan", 16, "finite"),
            ("from = \"f\"", "", 12, "needs either from (a column) or derive"),
            (time, "", 9, "needs either from (a column) or rate_hz"),
            ("[time]", "[file]\ndecimal = \";\"\n[time]", 10, "must be \".\" or \",\""),
            ("[time]", "[name]\npattern = '('\n[time]", 10, "not a regular expression"),
            ("\"hybrid\"", "{ name = \"mode\" }", 7, "not a named group (?<mode>…)"),
            ("[time]", "[questions]\n[time]", 9, "questions.columns: lists no column"),
        ] {
            check(&good, from, to, line, words);
        }
        for rate in ["0", "-1", "nan", "1e-300", "1e300"] {
            let words = "must be a number from 0.001 to 1000000";
            check(&good, time, &format!("rate_hz = {rate}"), 10, words);
        }
    }

    #[test]
    fn every_problem_is_reported_not_only_the_first() {
        let bad = trials_map(&[ONE, FORCE]).replace("\"N\"", "\"mV\"").replace("\"s\"", "\"deg\"");
        assert_eq!(Mapping::from_toml(&bad, Path::new("map.toml")).unwrap_err().len(), 2);
    }
}
