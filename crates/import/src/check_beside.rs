//! Checks of what a mapping joins to recorded trials: a log, second files, answers, what a task presented.

use super::check::Check;
use super::label::{From, Label};
use super::mapping::{
    AnswerForm, At, Beside, ClockFrom, Content, FileBeside, LogFrom, Origin, Questionnaire, RowBy,
    SaidFrom, TaskFrom, Time, TrialsFrom, WithFrom,
};
use super::shape::{
    FileShape, LogShape, QuestionsShape, TaskShape, TrialShape, Unmatched, WithShape, ZeroWord,
};
use super::table::ColumnRef;
use regex::Regex;
use zwidth_store::Signal;

/// What stands in a path for a group of the pattern.
const GROUP: &str = r"\{([^{}]*)\}";
/// The name of the log behind the `@` of its columns.
pub(super) const LOG: &str = "log";

impl Check<'_> {
    /// Whatever stands beside the samples of trials, whose labels are `trial`.
    pub(super) fn beside(
        &mut self,
        log: Option<LogShape>,
        with: Vec<WithShape>,
        questions: Option<QuestionsShape>,
        task: Option<TaskShape>,
        trial: Option<&TrialShape>,
        groups: &[&str],
    ) -> Option<Beside> {
        let before = self.errors.len();
        let log = log.and_then(|log| self.log(log, groups));
        let mut joined: Vec<WithFrom> = Vec::new();
        for (i, shape) in with.into_iter().enumerate() {
            let key = format!("with[{i}]");
            if shape.id == LOG || joined.iter().any(|other| other.id == shape.id) {
                let what = format!("'{}' is the name of another file that is joined", shape.id);
                self.error(&format!("{key}.id"), what);
            }
            joined.extend(self.with(&key, shape, groups));
        }
        let questions =
            questions.and_then(|shape| self.recorded_answers(shape, trial.cloned(), groups));
        let task = task.and_then(|shape| self.recorded_task(shape, trial.cloned(), groups));
        let beside = Beside { log, with: joined, questions, task };
        (self.errors.len() == before).then_some(beside)
    }

    fn log(&mut self, shape: LogShape, groups: &[&str]) -> Option<LogFrom> {
        let file = self.file_beside("log", shape.path, &shape.file, groups);
        let by_time = [
            ("unit", shape.unit.is_some()),
            ("zero", shape.zero.is_some()),
            ("offset_s", shape.offset_s.is_some()),
            ("at", shape.at.is_some()),
            ("until", shape.until.is_some()),
        ];
        let by_number = [("number", shape.number.is_some()), ("add", shape.add.is_some())];
        let by = match (shape.trial, shape.time) {
            (Some(column), None) => {
                self.refuse("log", &by_time, "is used with `time`, not with `trial`");
                let label =
                    shape.number.and_then(|number| self.label("log.number", number, groups));
                Some(RowBy::Number { column, add: shape.add.unwrap_or(0), recording: label })
            }
            (None, Some(time)) => {
                self.refuse("log", &by_number, "is used with `trial`, not with `time`");
                let clock = self.clock("log", Some(time), None, shape.unit.as_deref(), shape.zero);
                let offset_s = self.offset("log", shape.offset_s);
                let at = shape.at.unwrap_or_default();
                if at != At::Begin && shape.until.is_some() {
                    self.error(
                        "log.until",
                        "ends trials that begin with their rows: at = \"begin\"",
                    );
                }
                clock.zip(offset_s).map(|(clock, offset_s)| RowBy::Time {
                    clock,
                    offset_s,
                    at,
                    until: shape.until,
                })
            }
            _ => {
                let what = "needs either trial (the column with the number of the trial) or time (that of when it was)";
                self.error("log", what);
                None
            }
        };
        let mut only = Vec::new();
        for (column, label) in shape.only {
            let key = format!("log.where.{column}");
            let Some(label) = self.label(&key, label, groups) else { continue };
            if label.column().is_some() {
                self.error(&key, "must be a fixed value, or { name = … } of the recording's path");
            }
            only.push((ColumnRef::Name(column), label));
        }
        let when = shape.when.into_iter().map(|(column, words)| (ColumnRef::Name(column), words));
        Some(LogFrom {
            file: file?,
            by: by?,
            only,
            when: when.collect(),
            drops_unmatched: shape.unmatched == Some(Unmatched::Drop),
        })
    }

    fn with(&mut self, key: &str, shape: WithShape, groups: &[&str]) -> Option<WithFrom> {
        let file = self.file_beside(key, shape.path, &shape.file, groups);
        let unit = shape.unit.as_deref();
        let clock = self.clock(key, shape.time, shape.rate_hz, unit, shape.zero);
        let offset_s = self.offset(key, shape.offset_s);
        if shape.id.is_empty() || !shape.id.chars().all(|c| c.is_ascii_alphanumeric() || c == '_') {
            let what = format!("'{}' must be of letters, digits and _", shape.id);
            self.error(&format!("{key}.id"), what);
        }
        Some(WithFrom {
            id: shape.id,
            file: file?,
            clock: clock?,
            offset_s: offset_s?,
            resample: shape.resample,
        })
    }

    fn refuse(&mut self, table: &str, keys: &[(&str, bool)], why: &str) {
        for (key, _) in keys.iter().filter(|(_, is_present)| *is_present) {
            self.error(&format!("{table}.{key}"), format!("{why}; remove it"));
        }
    }

    /// A path may name groups of the pattern, and no others.
    fn file_beside(
        &mut self,
        key: &str,
        path: String,
        shape: &FileShape,
        groups: &[&str],
    ) -> Option<FileBeside> {
        let named = Regex::new(GROUP).ok()?;
        let unknown = named.captures_iter(&path).find(|named| !groups.contains(&&named[1]));
        if let Some(unknown) = unknown {
            let group = &unknown[1];
            let what = format!(
                "'{{{group}}}' is not a named group (?<{group}>…) of the pattern in [name]"
            );
            self.error(&format!("{key}.path"), what);
            return None;
        }
        if path.is_empty() {
            self.error(&format!("{key}.path"), "names no file");
            return None;
        }
        if shape.split.is_some() {
            self.error(&format!("{key}.file.split"), "is not used here; remove it");
        }
        let form = self.file(&format!("{key}.file"), shape);
        Some(FileBeside { path, form })
    }

    fn clock(
        &mut self,
        key: &str,
        time: Option<ColumnRef>,
        rate_hz: Option<f64>,
        unit: Option<&str>,
        zero: Option<ZeroWord>,
    ) -> Option<ClockFrom> {
        match (time, rate_hz) {
            (Some(from), None) => {
                let unit = self.unit(&format!("{key}.unit"), unit, Signal::Time)?;
                Some(ClockFrom::Column { from, unit, from_first: zero.is_some() })
            }
            (None, Some(rate_hz)) => {
                let keys = [("unit", unit.is_some()), ("zero", zero.is_some())];
                self.refuse(key, &keys, "is not used beside rate_hz");
                self.rate(&format!("{key}.rate_hz"), rate_hz)?;
                Some(ClockFrom::Rate { rate_hz })
            }
            _ => {
                self.error(key, "needs either time (a column) or rate_hz");
                None
            }
        }
    }

    /// What is added to the times of another file is never taken for granted.
    fn offset(&mut self, key: &str, offset_s: Option<f64>) -> Option<f64> {
        let key = format!("{key}.offset_s");
        match offset_s {
            Some(offset_s) if offset_s.is_finite() => Some(offset_s),
            Some(_) => {
                self.error(&key, "must be a finite number");
                None
            }
            None => {
                let what = "is missing: what is added to these times to have those of the recording, in s; 0.0 where one \
                            clock gave both";
                self.error(&key, what);
                None
            }
        }
    }

    /// Checks that each file that a column is of is joined, that each that is joined has a column, and that rows are not
    /// found by what they themselves say.
    pub(super) fn check_files(&mut self, from: &TrialsFrom) {
        let TrialsFrom { who, time, columns, channels, beside } = from;
        let signals = columns.iter().filter_map(|column| match &column.origin {
            Origin::Column { column, .. } => Some(&column.from),
            Origin::Derived(_) => None,
        });
        let named: Vec<&ColumnRef> = signals
            .chain(channels.iter().map(|channel| &channel.from))
            .chain(who.columns())
            .chain(beside.columns())
            .collect();
        let joined = beside.with.iter().map(|with| with.id.as_str());
        let joined: Vec<&str> = joined.chain(beside.log.as_ref().map(|_| LOG)).collect();
        for file in &joined {
            if !named.iter().any(|column| of_file(column).is_some_and(|(of, _)| of == *file)) {
                let key = if *file == LOG { "log" } else { "with" };
                let what = format!("no column is of it: name one as \"NAME@{file}\", or remove it");
                self.error(key, what);
            }
        }
        if !joined.is_empty() {
            let time = match time {
                Time::Column { column, .. } => Some(&column.from),
                Time::Rate { .. } => None,
            };
            if let Some(column) = time.filter(|column| of_file(column).is_some()) {
                let what =
                    format!("'{column}' is of a file that is joined by the recording's own time");
                self.error("time.from", what);
            }
        }
        if let Some(LogFrom { by: RowBy::Number { recording: Some(label), .. }, .. }) = &beside.log
            && !is_own(label)
        {
            self.error("log.number", "must be a label of the recording itself");
        }
    }

    /// Answers to questions, in columns of the recording or of its log.
    fn recorded_answers(
        &mut self,
        shape: QuestionsShape,
        trial: Option<TrialShape>,
        groups: &[&str],
    ) -> Option<Questionnaire> {
        let keys = [("question", shape.question.is_some()), ("answer", shape.answer.is_some())];
        let is_long = keys.iter().any(|(_, is_present)| *is_present);
        self.refuse("questions", &keys, "is of a table with one row per answer");
        if shape.columns.is_empty() {
            self.error("questions.columns", "lists no column; name that of each question");
        }
        if is_long || shape.columns.is_empty() {
            return None;
        }
        let trial = trial?;
        if trial.likert.is_some() {
            self.error("trial.likert", "is not used beside [questions]; list its column there");
        }
        // Its labels were checked as those of the trial.
        let before = self.errors.len();
        let content =
            self.likert(Some(TrialShape { likert: None, ..trial }), shape, Vec::new(), groups);
        match content {
            Some(Content::Likert(questionnaire)) if self.errors.len() == before => {
                matches!(questionnaire.form, AnswerForm::Wide(_)).then_some(questionnaire)
            }
            _ => None,
        }
    }

    /// What of a task a trial presented, and what was answered.
    fn recorded_task(
        &mut self,
        shape: TaskShape,
        trial: Option<TrialShape>,
        groups: &[&str],
    ) -> Option<TaskFrom> {
        let keys =
            [("when", !shape.when.is_empty()), ("presentations", shape.presentations.is_some())];
        self.refuse(
            "task",
            &keys,
            "is of a table of answers, and each recorded trial is one presentation",
        );
        if keys.iter().any(|(_, is_present)| *is_present) {
            return None;
        }
        let trial = TrialShape { environment: None, repeat: None, likert: None, ..trial? };
        match self.psychometric(Some(trial), Some(shape), groups) {
            Some(Content::Psychometric(task)) => {
                matches!(task.said, SaidFrom::Each(_)).then_some(*task)
            }
            _ => None,
        }
    }
}

/// The file that a column's name ends in, and its name there: `rt@log` is `rt` of the log.
pub(super) fn of_file(column: &ColumnRef) -> Option<(&str, &str)> {
    match column {
        ColumnRef::Name(name) => name.rsplit_once('@').map(|(name, file)| (file, name)),
        ColumnRef::Position(_) => None,
    }
}

/// The label of a recording's own, not of a file that is joined to it.
pub(super) fn is_own(label: &Label) -> bool {
    match &label.from {
        From::Column(column) => of_file(column).is_none(),
        From::Fixed(_) | From::Name(_) => true,
    }
}
