//! A study that is read.

use crate::calling::{Fault, call};
use crate::results::up_to_date;
use crate::table::Table;
use crate::trial::{File, Samples, Trial, columns};
use base64::Engine as _;
use base64::engine::general_purpose::STANDARD;
use pyo3::prelude::*;
use std::collections::BTreeSet;
use std::path::PathBuf;
use std::sync::Arc;
use zwidth_likert::{Scheme, long, long_table};
use zwidth_metrics::Parameters;
use zwidth_results::{CountedTrial, ModeDifference, PeopleThreshold, PsychometricFit, Row};
use zwidth_store::{Layout, StudyData, TrialEntry, read_named};
use zwidth_study::{Channel, Known, ParticipantId, PersonValue, SessionId, StudyId};
use zwidth_tables::{Column, Field, SYNTHETIC, Table as Rows, Type, Values};

/// Largest figure that is shown, bytes.
const MOST_FIGURE: u64 = 1 << 26;
/// The figure that a notebook shows of a study.
const FIRST_FIGURE: &str = "verdicts";

/// A study as it is on the disk: its trials, samples, answers and people, and what a run made of them. Nothing is written.
///
/// Trials of sealed sessions do not count until `zwidth unseal`: their modes are codes, and their samples are not given.
#[pyclass(module = "zwidth", frozen)]
pub(crate) struct Study {
    data: Arc<StudyData>,
}

/// Reads the study `study` below `root`: its study.toml, the footers of its trials, sessions and events. Samples are read
/// when they are asked for.
#[pyfunction]
pub(crate) fn read_study(py: Python<'_>, root: PathBuf, study: &str) -> PyResult<Study> {
    let study: StudyId = study.parse().map_err(Fault::said)?;
    call(py, move |_| {
        let data = StudyData::load(&Layout::new(&root, study))?;
        Ok(Study { data: Arc::new(data) })
    })
}

#[pymethods]
impl Study {
    /// Its id, the name of its folder.
    #[getter]
    fn id(&self) -> &str {
        self.data.layout.study().as_str()
    }

    /// Its title.
    #[getter]
    fn title(&self) -> &str {
        &self.data.study.title
    }

    /// What could not be read and was left out, and what is to be read with care: a sentence each.
    #[getter]
    fn findings(&self) -> Vec<String> {
        let findings = self.data.problems.iter().chain(&self.data.warnings);
        findings.map(ToString::to_string).collect()
    }

    /// Every trial: who, when, condition, source, whether it counts (`counts`), and why not (`why_not`).
    #[getter]
    fn trials(&self) -> PyResult<Table> {
        let rows: Vec<CountedTrial> =
            self.data.trials.iter().map(|trial| self.counted(trial)).collect();
        let rows = Rows::of_rows(&rows).map_err(Fault::said)?;
        // Known after a run alone, whose file trials.parquet has it.
        Ok(Table::without(&rows, &["read_with_care"])?)
    }

    /// The samples of every trial that counts, one batch for each trial: participant, session, trial, repeat, environment,
    /// mode, source, then the columns asked for, such as `["t_s", "theta_rad", "force_ex_n"]`; all that any trial has without
    /// `columns`, null where a trial lacks one. SI units, as they were recorded, never resampled.
    #[pyo3(signature = (columns = None))]
    fn samples(&self, columns: Option<Vec<String>>) -> PyResult<Samples> {
        let counting: Vec<&TrialEntry> = self.data.counting().collect();
        let signals: BTreeSet<_> =
            counting.iter().flat_map(|t| t.said.signals.iter().copied()).collect();
        let signals: Vec<_> = signals.into_iter().collect();
        let mut channels: Vec<Channel> = Vec::new();
        for channel in counting.iter().flat_map(|trial| &trial.said.form.channels) {
            if channels.iter().all(|known| known.id != channel.id) {
                channels.push(channel.clone());
            }
        }
        let tasks = counting.iter().any(|trial| trial.meta.presented.is_some());
        let columns = self::columns(columns, &signals, &channels, tasks)?;
        let files = counting.iter().map(|t| File { path: t.path.clone(), meta: t.meta.clone() });
        Ok(Samples::new(files.collect(), columns))
    }

    /// A trial that counts, by participant, session and number: `study.trial("P01", "S01", 3)`.
    fn trial(
        &self,
        py: Python<'_>,
        participant: &str,
        session: &str,
        number: u32,
    ) -> PyResult<Trial> {
        let participant: ParticipantId = participant.parse().map_err(Fault::said)?;
        let session: SessionId = session.parse().map_err(Fault::said)?;
        let found = self.data.trials.iter().find(|trial| {
            let meta = &trial.meta;
            (&meta.participant, &meta.session, meta.trial) == (&participant, &session, number)
        });
        let Some(trial) = found else {
            let what = format!("there is no trial {number} of {participant} in {session}");
            return Err(Fault::new(what, "look at study.trials").into());
        };
        if let Some(why) = trial.why_not() {
            let what =
                format!("trial {number} of {participant} in {session} does not count: {why}");
            return Err(Fault::new(what, "take one whose `counts` is true in study.trials").into());
        }
        let study = &self.data.study;
        let environment = study.environments.iter().find(|e| e.id == trial.meta.environment);
        let mode = study.modes.iter().find(|mode| mode.id == trial.meta.mode);
        let parameters = environment.zip(mode).map(|(e, mode)| Parameters::of(study, e, mode));
        let (path, meta) = (trial.path.clone(), trial.meta.clone());
        call(py, move |_| Trial::read(&path, Some(meta), parameters))
    }

    /// Every answer as it was given, one row each; `counts` says whether it enters anything.
    fn answers(&self) -> PyResult<Table> {
        let rows = long(&self.data.answers, &self.data.answers_left_out);
        let table = long_table(&rows, &Scheme::of(&self.data.study)).map_err(Fault::said)?;
        Ok(Table::new(table)?)
    }

    /// Everybody who has a trial or a row in the participants' file, with what that file says of them.
    fn participants(&self) -> PyResult<Table> {
        let recorded = self.data.trials.iter().map(|trial| &trial.meta.participant);
        let people: BTreeSet<&ParticipantId> =
            recorded.chain(self.data.people.iter().map(|(who, _)| who)).collect();
        let counting = |who: &ParticipantId| {
            self.data.counting().filter(|trial| trial.meta.participant == *who).count()
        };
        let mut columns = vec![
            Column::text("participant", "who", people.iter().map(|who| Some(who.to_string()))),
            Column::integer(
                "trials",
                "1",
                "trials that count",
                people.iter().map(|who| i64::try_from(counting(who)).ok()),
            ),
        ];
        for known in &self.data.study.people {
            let value = |who: &&ParticipantId| self.data.people.row(who)?.get(&known.id).cloned();
            let values = people.iter().map(value);
            let (unit, values, kind) = match &known.known {
                Known::Level { .. } => {
                    let texts = values.map(|value| value.map(|value| value.to_string().into()));
                    ("1".to_owned(), Values::Text(texts.collect()), Type::Text)
                }
                Known::Number { unit } => {
                    let numbers = values.map(|value| match value {
                        Some(PersonValue::Number(number)) => Some(number),
                        _ => None,
                    });
                    (unit.clone(), Values::Float(numbers.collect()), Type::Float)
                }
            };
            let field = Field {
                name: known.id.to_string().into(),
                unit: unit.into(),
                description: "of the participants' file".into(),
                kind,
            };
            columns.push(Column { field, values });
        }
        Ok(Table::new(Rows::new("participants", "Participants", columns).map_err(Fault::said)?)?)
    }

    /// The metrics of every trial that counts, as the last run wrote them: one row a trial, SI units. Refused unless they are
    /// up to date.
    fn metrics(&self, py: Python<'_>) -> PyResult<Table> {
        self.table(py, "metrics.parquet".to_owned(), true)
    }

    /// Every difference between modes with its interval, test and verdict, as the last run wrote them. Numbers are in the
    /// unit that the column `unit` names. Refused unless they are up to date.
    fn contrasts(&self, py: Python<'_>) -> PyResult<Table> {
        self.table(py, format!("compare/{}.parquet", ModeDifference::NAME), true)
    }

    /// Thresholds and JNDs as the last run wrote them: of everybody in each session and mode, or with `over_people=True` those
    /// over people. Refused unless they are up to date; a study without tasks has none.
    #[pyo3(signature = (*, over_people = false))]
    fn thresholds(&self, py: Python<'_>, over_people: bool) -> PyResult<Table> {
        if self.data.study.tasks.is_empty() {
            let remedy = "docs/session.md says how a task is added to study.toml";
            return Err(Fault::new("the study has no tasks, and so no thresholds", remedy).into());
        }
        let name = if over_people { PeopleThreshold::NAME } else { PsychometricFit::NAME };
        self.table(py, format!("thresholds/{name}.parquet"), false)
    }

    /// The names of the figures that the last run drew.
    #[getter]
    fn figures(&self) -> PyResult<Vec<String>> {
        let folder = self.data.layout.reports().join("figures");
        let listed = std::fs::read_dir(folder).into_iter().flatten().flatten();
        let paths = listed.map(|entry| entry.path());
        let svg = paths.filter(|path| path.extension().is_some_and(|end| end == "svg"));
        let mut names: Vec<String> =
            svg.filter_map(|path| Some(path.file_stem()?.to_str()?.to_owned())).collect();
        names.sort();
        Ok(names)
    }

    /// A figure of the last run as SVG, by its name. Refused unless it is up to date.
    fn figure(&self, py: Python<'_>, name: &str) -> PyResult<String> {
        let data = self.data.clone();
        let file = format!("reports/{}/figures/{name}.svg", self.id());
        call(py, move |_| figure(&data, &file))
    }

    fn __repr__(&self) -> String {
        let counting = self.data.counting().count();
        format!("<zwidth.Study {:?}: {counting} trials that count>", self.id())
    }

    /// The study as a notebook shows it: its matrix of means, and the figure of every difference.
    fn _repr_html_(&self, py: Python<'_>) -> PyResult<String> {
        let title = escaped(self.title());
        let mut html = format!(
            "<h3>{title}</h3>\n<p>{} trials that count</p>\n",
            self.data.counting().count()
        );
        if self.data.counting().any(|trial| trial.meta.source.is_simulated()) {
            html += &format!("<p><strong>{SYNTHETIC}</strong></p>\n");
        }
        let data = self.data.clone();
        let file = format!("reports/{}/figures/{FIRST_FIGURE}.svg", self.id());
        html += &call(py, move |_| {
            Ok(match matrix(&data).and_then(|matrix| Ok((matrix, figure(&data, &file)?))) {
                // As an image: an SVG in the page could run scripts.
                Ok((matrix, svg)) => format!(
                    "{matrix}\n<img alt=\"every difference between modes\" style=\"max-width: 100%\" src=\"data:image/svg+xml;base64,{}\">",
                    STANDARD.encode(svg)
                ),
                Err(fault) => format!("<p>{}</p>", escaped(&fault.text())),
            })
        })?;
        Ok(html)
    }
}

impl Study {
    fn counted(&self, trial: &TrialEntry) -> CountedTrial {
        let meta = trial.meta.clone();
        let path = self.data.layout.shown(&trial.path).to_string_lossy().replace('\\', "/");
        CountedTrial {
            path,
            participant: meta.participant,
            session: meta.session,
            trial: meta.trial,
            repeat: meta.repeat,
            environment: meta.environment,
            mode: meta.mode,
            kind: meta.kind,
            status: meta.status,
            source: meta.source,
            counts: trial.counts(),
            why_not: trial.why_not(),
            read_with_care: false,
        }
    }

    /// A derived table, by its path below `derived/<study>`.
    fn table(&self, py: Python<'_>, file: String, of_all_trials: bool) -> PyResult<Table> {
        let data = self.data.clone();
        call(py, move |_| Table::of_study(derived(&data, &file, of_all_trials)?, &data.study))
    }
}

fn derived(data: &StudyData, file: &str, of_all_trials: bool) -> Result<Rows, Fault> {
    let result = format!("derived/{}/{file}", data.layout.study());
    let path = up_to_date(data, &result, of_all_trials)?;
    Rows::from_parquet(&path).map_err(Fault::said)
}

/// The matrix of means, as HTML.
fn matrix(data: &StudyData) -> Result<String, Fault> {
    let rows = derived(data, "compare/comparison.parquet", true)?;
    Table::of_study(rows, &data.study)?.html()
}

fn figure(data: &StudyData, file: &str) -> Result<String, Fault> {
    let path = up_to_date(data, file, false)?;
    let shown = path.to_string_lossy().into_owned();
    let bytes = read_named(&path, MOST_FIGURE).map_err(|e| Fault::said(e).in_file(&shown))?;
    String::from_utf8(bytes).map_err(|e| Fault::said(e).in_file(shown))
}

/// A text in HTML.
fn escaped(text: &str) -> String {
    text.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;").replace('"', "&quot;")
}
