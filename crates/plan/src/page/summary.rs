//! Stage `summary`: the page a person reads first.

use crate::compare::Comparison;
use crate::figures::drawing::Drawing;
use crate::page::methods::recorded;
use crate::shared::handle::Derived;
use crate::shared::trials::name;
use crate::{average, compare, freemotion, ladder, likert, metrics, report, tables, trade};
use rayon::prelude::*;
use serde::Serialize;
use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};
use zwidth_figures::Caption;
use zwidth_report::{
    ComparedMetric, Finding, Gallery, Made as Listed, Remark, Shown, Summary, Told, TrialNames,
    changes, findings, laddered, learned, summary_markdown, survey, traded, uneven_ranges,
};
use zwidth_results::{
    AnswerTally, Compared, JudgedStatement, LadderChoice, Learning, Mean, MetricNote,
    ModeDifference, RedrawnDifference, SessionChange, TradeChoice, TrialRemark,
};
use zwidth_runner::{Inputs, Job, JobError, Made, Making, ORIGIN, Stage, strip_root};
use zwidth_store::{Findings, Signal, StoreError, StudyData, TrialEntry};
use zwidth_study::{Kind, Scene, Setup};
use zwidth_tables::{About, Format, Measured, NoteKind, Table, TableError};

/// Its version is raised when the page would be written differently from the same data.
const STAGE: Stage = Stage { name: "summary", version: 22 };

/// The summary's file.
fn file(data: &StudyData) -> PathBuf {
    data.layout.reports().join("summary.md")
}

/// What the page depends on besides files.
#[derive(Serialize)]
pub(crate) struct Page {
    facts: Summary,
    pub(crate) planned: Setup,
    /// The figures' captions, in the order of their files.
    captions: Vec<Caption>,
    /// The metrics that are compared, the primary one first.
    compared: Vec<String>,
    /// Whether the study names no primary metric.
    pub(crate) is_primary_by_default: bool,
    /// The trials whose clock, angle or velocity is to be read with care.
    doubted: TrialNames,
    gallery: Gallery,
}

impl Page {
    /// The figure of a finding, or the table of conditions where it was not made or would be one of
    /// many sessions.
    fn shown_by(&self, shown: &Shown, made: &Summary) -> String {
        let of_session = matches!(shown, Shown::Modes(_)) && self.gallery.only_session.is_none();
        let file = self.gallery.file(shown);
        if is_made(made, &file) && !of_session {
            file
        } else {
            self.gallery.table(&Shown::Conditions)
        }
    }
}

/// The files that the page speaks of, where they are there.
pub(crate) struct Files {
    /// Averages and fits, whose notes are limits of the study.
    noted: Vec<PathBuf>,
    /// What is said of the trials of each session.
    of_trials: Vec<Derived<TrialRemark>>,
    figures: Vec<PathBuf>,
    tables: Vec<PathBuf>,
    pub(crate) metrics: Option<PathBuf>,
    tally: Option<Derived<AnswerTally>>,
    /// The thesis' statements, as judged.
    statements: Option<Derived<JudgedStatement>>,
    /// What is recommended for each scene of the study, and which terms it requires.
    trade: Option<Derived<TradeChoice>>,
    ladder: Option<Derived<LadderChoice>>,
    /// The metrics compared.
    compared: Option<Comparison>,
    /// Whether changes between sessions are told.
    are_sessions_told: bool,
}

impl Inputs for Files {
    fn files(&self) -> Vec<PathBuf> {
        let Self { metrics, tally, statements, trade, ladder, .. } = self;
        let numbers =
            [metrics.files(), tally.files(), statements.files(), trade.files(), ladder.files()]
                .concat();
        let compared = self.compared.iter().flat_map(|found| {
            let Comparison {
                metrics, means, contrasts, sessions, learning, redrawn, notes, ..
            } = found;
            let told = self.are_sessions_told.then(|| sessions.files());
            let all = [
                metrics.files(),
                means.files(),
                contrasts.files(),
                redrawn.files(),
                learning.files(),
                notes.files(),
            ];
            all.into_iter().chain(told).flatten()
        });
        let compared: Vec<PathBuf> = compared.collect();
        let of_trials = self.of_trials.files();
        [&self.noted, &of_trials, &self.figures, &self.tables, &numbers, &compared]
            .map(Clone::clone)
            .concat()
    }
}

pub(crate) fn job(data: &StudyData, found: &Findings, figures: &[Drawing]) -> Job {
    let (page, files) = asked(data, found, figures);
    Job::new(STAGE, "summary", page, files, vec![file(data)], make).tolerant()
}

/// What the summary depends on.
pub(crate) fn asked(data: &StudyData, found: &Findings, figures: &[Drawing]) -> (Page, Files) {
    let compared = compare::compared(data);
    let files = Files {
        noted: average::at_onset(data).into_iter().chain(freemotion::tables(data)).collect(),
        of_trials: metrics::remarks(data),
        figures: figures.iter().map(Drawing::picture).collect(),
        tables: tables::files(data),
        metrics: metrics::of_study(data),
        tally: likert::tally(data),
        statements: report::statements(data),
        trade: trade::recommended(data),
        ladder: ladder::of_study(data),
        compared: compare::of_study(data),
        are_sessions_told: compare::are_sessions_told(data),
    };
    let page = Page {
        facts: facts(data, found),
        planned: Setup::of(&data.study),
        captions: figures.iter().map(|figure| figure.caption.clone()).collect(),
        compared,
        is_primary_by_default: !data.study.compare.is_primary_named,
        doubted: doubted(data, found),
        gallery: report::gallery(data, figures),
    };
    (page, files)
}

fn make(page: &Page, files: &Files, making: &Making) -> Result<Made, JobError> {
    let Gathered { summary, .. } = gather(page, files, making)?;
    let origin = making.from.get(ORIGIN).and_then(|origin| Format::Markdown.comment(origin));
    let text = summary_markdown(&summary) + &origin.unwrap_or_default();
    Ok(Made::of(vec![text.into_bytes()]))
}

/// The summary, and what is in it and on the page.
pub(crate) struct Gathered {
    pub(crate) summary: Summary,
    /// What was found of the metrics that are compared.
    pub(crate) compared: ReadComparison,
    /// Metrics of the trials, as far as they are looked at.
    pub(crate) metrics: Option<Measured>,
}

pub(crate) fn gather(page: &Page, files: &Files, making: &Making) -> Result<Gathered, JobError> {
    let folder = making.outputs.first().and_then(|page| page.parent()).unwrap_or(making.root);
    let mut summary = page.facts.clone();
    summary.limits.extend(notes(&files.noted, |kind| kind != NoteKind::Extent)?);
    let of_trials = remarks(&files.of_trials)?.into_iter();
    let (left_out, care): (Vec<_>, Vec<_>) =
        of_trials.partition(|remark| remark.kind == NoteKind::LeftOut);
    let listed = |all: Vec<TrialRemark>| {
        let all = all
            .into_iter()
            .map(|TrialRemark { what, why, .. }| Remark { what, why: why.to_string() });
        all.collect::<BTreeSet<_>>()
    };
    summary.left_out.extend(listed(left_out));
    summary.care.extend(listed(care));
    let listed = |(file, caption): (&PathBuf, &Caption)| match file.exists() {
        true => Ok(Listed {
            kind: caption.kind.shows.to_owned(),
            ..Listed::new(relative(file, folder), caption.text())
        }),
        false => Err(could_not_be_made(file)),
    };
    let figures: Vec<_> = files.figures.iter().zip(&page.captions).map(listed).collect();
    let missing: Vec<Remark> = figures.iter().filter_map(|f| f.as_ref().err().cloned()).collect();
    summary.figures = figures.into_iter().filter_map(Result::ok).collect();
    let (there, no_tables): (Vec<_>, Vec<_>) = files.tables.iter().partition(|f| f.exists());
    let listed = |file: &&PathBuf| table(file, &page.gallery);
    let tables = there.par_iter().map(listed).collect::<Result<Vec<_>, _>>()?;
    summary.left_out.extend(tables.iter().filter_map(|(listed, rows)| empty(listed, *rows)));
    summary.tables = tables.into_iter().map(|(listed, _)| listed).collect();
    let compared = ReadComparison::of(files)?;
    let of_compared = compared.by_metric(page.is_primary_by_default);
    summary.matrix = zwidth_report::matrix(&page.planned, &of_compared);
    let limits = compared.notes.iter().filter(|note| note.kind == NoteKind::Limit);
    let limits: BTreeSet<String> = limits.map(|note| note.note.to_string()).collect();
    summary.limits.extend(limits);
    let there = files.metrics.as_deref().filter(|file| file.exists());
    let metrics = there.map(|file| metrics::looked_at(file, &page.compared)).transpose()?;
    if let Some(metrics) = &metrics {
        summary.limits.extend(uneven_ranges(&page.planned, metrics)?);
    }
    let mut sentences = zwidth_report::contrasts(&page.planned, &of_compared);
    if let Some(primary) = of_compared.first() {
        let of_primary = |row: &Learning| row.metric == primary.metric.metric;
        sentences.extend(learned(&page.planned, primary, own(&compared.learning, of_primary)));
        sentences.extend(changes(&page.planned, primary, compared.sessions_of(primary)));
    }
    summary.shown = list_findings(page, files, metrics.as_ref(), sentences, &summary)?;
    (summary.statements, summary.judged) = list_statements(page, files, &summary)?;
    summary.runs = list_runs(page, files, &summary)?;
    summary.left_out.extend(missing);
    summary.left_out.extend(no_tables.into_iter().map(|f| could_not_be_made(f)));
    Ok(Gathered { summary, compared, metrics })
}

/// What the trials show, each sentence with the figure or table that holds its numbers: metrics of
/// the trials, tally of the answers.
fn list_findings(
    page: &Page,
    files: &Files,
    metrics: Option<&Measured>,
    of_comparison: Vec<Finding>,
    made: &Summary,
) -> Result<Vec<Listed>, TableError> {
    let tally = match &files.tally {
        Some(tally) => tally.read_if_made()?,
        None => None,
    };
    let found = match (metrics, tally.as_deref()) {
        (Some(metrics), tally) => findings(&page.planned, metrics, tally, &page.doubted)?,
        (None, Some(tally)) => survey(&page.planned, tally),
        (None, None) => Vec::new(),
    };
    let all = of_comparison.into_iter().chain(found);
    let listed = all.map(|finding| Listed {
        question: finding.shown.question(),
        ..Listed::new(page.shown_by(&finding.shown, made), finding.text)
    });
    Ok(listed.collect())
}

/// What runs of the model show: the cheapest that could not be told from the right one, and the
/// terms that each condition requires.
fn list_runs(page: &Page, files: &Files, made: &Summary) -> Result<Vec<Listed>, TableError> {
    let mut found = Vec::new();
    if let Some(trade) = &files.trade
        && let Some(choices) = trade.read_if_made()?
    {
        found.extend(traded(&page.planned, &choices));
    }
    if let Some(ladder) = &files.ladder
        && let Some(choices) = ladder.read_if_made()?
    {
        found.extend(laddered(&page.planned, &choices));
    }
    let listed = |finding: Finding| {
        let file = page.gallery.file(&finding.shown);
        let path = if is_made(made, &file) { file } else { page.gallery.table(&finding.shown) };
        Listed::new(path, finding.text)
    };
    Ok(found.into_iter().map(listed).collect())
}

/// How the thesis' statements stand, and the judged ones with what shows them.
fn list_statements(
    page: &Page,
    files: &Files,
    made: &Summary,
) -> Result<(String, Vec<Told>), TableError> {
    let Some(statements) = files.statements.as_ref().filter(|of| of.path().exists()) else {
        return Ok(Default::default());
    };
    let (rows, notes) = statements.read_with_notes()?;
    let (counts, told) = zwidth_report::told(&rows, &notes);
    // A study that measured nothing of the thesis is of another kind.
    if told.is_empty() {
        return Ok(Default::default());
    }
    let listed = told.into_iter().map(|told| {
        let is_there = is_made(made, &told.path);
        let all = || page.gallery.table(&Shown::Statements);
        Told { path: if is_there { told.path } else { all() }, ..told }
    });
    Ok((counts, listed.collect()))
}

/// A table, where there is one and it could be made.
pub(crate) fn read(file: &Option<PathBuf>) -> Result<Option<Table>, TableError> {
    file.as_deref().filter(|f| f.exists()).map(Table::from_parquet).transpose()
}

/// Whether a figure or table was made.
fn is_made(made: &Summary, path: &str) -> bool {
    made.figures.iter().chain(&made.tables).any(|m| m.path == path)
}

/// What was found of the metrics that are compared; nothing where it could not be made.
#[derive(Default)]
pub(crate) struct ReadComparison {
    metrics: Vec<Compared>,
    means: Vec<Mean>,
    contrasts: Vec<ModeDifference>,
    sessions: Vec<SessionChange>,
    learning: Vec<Learning>,
    redrawn: Vec<RedrawnDifference>,
    notes: Vec<MetricNote>,
}

impl ReadComparison {
    fn of(files: &Files) -> Result<Self, TableError> {
        let found = files.compared.as_ref().filter(|found| found.metrics.path().exists());
        let Some(found) = found else { return Ok(Self::default()) };
        let sessions = if files.are_sessions_told { found.sessions.read()? } else { Vec::new() };
        Ok(Self {
            metrics: found.metrics.read()?,
            means: found.means.read()?,
            contrasts: found.contrasts.read()?,
            sessions,
            learning: found.learning.read_if_made()?.unwrap_or_default(),
            redrawn: found.redrawn.read_if_made()?.unwrap_or_default(),
            notes: found.notes.read()?,
        })
    }

    /// Metric by metric: the rows of one stand together.
    pub(crate) fn by_metric(&self, is_primary_by_default: bool) -> Vec<ComparedMetric<'_>> {
        let of = |metric| ComparedMetric {
            metric,
            is_primary_by_default,
            means: own(&self.means, |row| row.metric == metric.metric),
            contrasts: own(&self.contrasts, |row| row.metric == metric.metric),
            redrawn: own(&self.redrawn, |row| row.metric == metric.metric),
        };
        self.metrics.iter().map(of).collect()
    }

    fn sessions_of(&self, metric: &ComparedMetric) -> &[SessionChange] {
        own(&self.sessions, |row| row.metric == metric.metric.metric)
    }
}

/// The rows that stand together because they are of the same.
fn own<R>(rows: &[R], is_own: impl Fn(&R) -> bool) -> &[R] {
    let first = rows.iter().position(&is_own).unwrap_or(rows.len());
    let after = rows[first..].iter().position(|row| !is_own(row));
    &rows[first..after.map_or(rows.len(), |more| first + more)]
}

fn facts(data: &StudyData, found: &Findings) -> Summary {
    let counting: Vec<_> = data.counting().collect();
    let recorded = recorded(data);
    let scenes = counting
        .iter()
        .filter_map(|t| data.study.environment(&t.meta.environment))
        .map(|e| e.scene);
    let no_lever =
        data.study.device.lever_m.is_none() && scenes.into_iter().any(|s| s != Scene::None);
    let limit = match has_torque_alone(data) {
        true => {
            "No lever length is known (device.lever_m), so torque stays torque: N·m on axes and in tables."
        }
        false => {
            "No lever length is known (device.lever_m): shares of the work are computed, but no energy in joules and no power, and the model is not replayed."
        }
    };
    Summary {
        title: data.study.title.clone(),
        device: data.study.device.name.clone(),
        participants: recorded.participants,
        sessions: recorded.sessions,
        trials: recorded.trials,
        sweeps: recorded.sweeps,
        undrawn: crate::figures::without_own(data),
        sources: recorded.sources,
        left_out: left_out(data, found),
        care: found.with_care.iter().map(|finding| remark(data, finding)).collect(),
        limits: no_lever
            .then(|| limit.to_owned())
            .into_iter()
            .chain(not_recorded(&counting))
            .collect(),
        plan: recorded.plan,
        ..Summary::default()
    }
}

/// The trials that count whose clock, angle or velocity is in doubt: from these a swing is told.
fn doubted(data: &StudyData, found: &Findings) -> TrialNames {
    let told_from = [Signal::Time, Signal::Theta, Signal::ThetaDot].map(Signal::name);
    let doubts = found.with_care.iter().filter(|doubt| {
        doubt.column.as_ref().is_some_and(|column| told_from.contains(&column.as_str()))
    });
    let files: BTreeSet<&Path> = doubts.map(|doubt| doubt.path.as_path()).collect();
    let trials = data.counting().filter(|trial| files.contains(&*trial.path));
    trials
        .map(|trial| {
            let meta = &trial.meta;
            (meta.participant.clone(), meta.session.clone(), meta.trial)
        })
        .collect()
}

/// Whether trials recorded the user's torque, and none a force.
pub(crate) fn has_torque_alone(data: &StudyData) -> bool {
    let any = |signal| data.counting().any(|trial| trial.said.signals.contains(&signal));
    any(Signal::TorqueEx) && !any(Signal::ForceEx)
}

/// Every trial of the experiment that does not count, and whatever else was found and is in no
/// result.
fn left_out(data: &StudyData, found: &Findings) -> Vec<Remark> {
    let mut found_of: BTreeMap<&Path, Vec<Remark>> = BTreeMap::new();
    for finding in &found.left_out {
        found_of.entry(&finding.path).or_default().push(remark(data, finding));
    }
    let mut all = Vec::new();
    for trial in data.trials.iter().filter(|t| t.meta.kind == Kind::Trial) {
        let Some(why) = trial.why_not() else { continue };
        let found = found_of.remove(&*trial.path).unwrap_or_default();
        let found: Vec<String> = found.into_iter().map(|remark| remark.why).collect();
        let why = if found.is_empty() { why } else { found.join("; ") };
        all.push(Remark { what: name(&trial.meta), why });
    }
    all.extend(found_of.into_values().flatten());
    all
}

/// A finding as the page has it.
fn remark(data: &StudyData, finding: &StoreError) -> Remark {
    let path = data.layout.shown(&finding.path).to_string_lossy().replace('\\', "/");
    let column =
        finding.column.as_ref().map(|column| format!(", column {column}")).unwrap_or_default();
    let row = finding.row.map(|row| format!(", row {row}")).unwrap_or_default();
    Remark {
        what: format!("{path}{column}{row}"),
        why: strip_root(data.layout.root(), &finding.what),
    }
}

/// The remark that a table is empty, if it has no rows.
fn empty(table: &Listed, rows: usize) -> Option<Remark> {
    (rows == 0).then(|| Remark {
        what: table.path.clone(),
        why: "the table has no row: no trial has what it is made of".to_owned(),
    })
}

/// What figures and metrics must do without, because some trial was recorded without it.
fn not_recorded(counting: &[&TrialEntry]) -> Vec<String> {
    let force = [Signal::ForceEx, Signal::TorqueEx];
    let needed: [(&str, &[Signal], &str); 3] = [
        (
            "angle",
            &[Signal::Theta],
            "there is no panel of θ, no force against θ, and no metric of either",
        ),
        ("velocity", &[Signal::ThetaDot], "there is no onset, and so no average over time"),
        ("force and no torque", &force, "there is no force panel"),
    ];
    let mut sentences = Vec::new();
    for (what, signals, so) in needed {
        let without =
            counting.iter().filter(|t| !signals.iter().any(|s| t.said.signals.contains(s)));
        let n = without.count();
        let all = counting.len();
        if n > 0 {
            sentences
                .push(format!("No {what} was recorded in {n} of {all} trials: for them {so}."));
        }
    }
    sentences
}

/// The notes of these kinds below tables, each once, in order.
fn notes(tables: &[PathBuf], of: fn(NoteKind) -> bool) -> Result<BTreeSet<String>, TableError> {
    let mut notes = BTreeSet::new();
    for path in tables.iter().filter(|p| p.exists()) {
        let found = Table::about(path)?.notes;
        notes.extend(found.into_iter().filter(|(kind, _)| of(*kind)).map(|(_, note)| note));
    }
    Ok(notes)
}

/// What is said of trials, by sessions.
pub(crate) fn remarks(of: &[Derived<TrialRemark>]) -> Result<Vec<TrialRemark>, TableError> {
    let mut all = Vec::new();
    for session in of {
        all.extend(session.read_if_made()?.unwrap_or_default());
    }
    Ok(all)
}

/// A table, and how many rows it has.
fn table(file: &Path, gallery: &Gallery) -> Result<(Listed, usize), TableError> {
    let About { title, rows, .. } = Table::about(file)?;
    Ok((Listed::new(gallery.table_file(&stem(file)), title), rows))
}

fn could_not_be_made(file: &Path) -> Remark {
    Remark { what: stem(file), why: "it could not be made; `zwidth run` says why".to_owned() }
}

fn stem(file: &Path) -> String {
    file.file_stem().unwrap_or_default().to_string_lossy().into_owned()
}

fn relative(path: &Path, folder: &Path) -> String {
    path.strip_prefix(folder).unwrap_or(path).to_string_lossy().replace('\\', "/")
}
