//! Stage `summary`: the page a person reads first.

use crate::compare::Comparison;
use crate::curves::OfCurves;
use crate::figures::drawing::Drawing;
use crate::page::methods::recorded;
use crate::shared::handle::Derived;
use crate::shared::own_stages::shown;
use crate::shared::trials::name;
use crate::{
    average, compare, curves, freemotion, ladder, likert, metrics, report, tables, thresholds,
    trade,
};
use rayon::prelude::*;
use serde::Serialize;
use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};
use zwidth_figures::Caption;
use zwidth_report::{
    ComparedMetric, Finding, Gallery, Made as Listed, Primaries, Remark, Shown, Summary,
    TrialNames, changes, curve_answers, curve_differences, findings, laddered, learned,
    primary_first, summary_markdown, survey, traded, uneven_ranges,
};
use zwidth_results::{
    AnswerTally, Compared, EffectDifference, FactorTest, GroupDifference, GroupMember,
    JudgedStatement, LadderChoice, Learning, Mean, MetricNote, ModeDifference, PeopleThreshold,
    PersonValue, PsychometricFit, RedrawnDifference, Role, Row, SessionChange, TradeChoice,
    TrialRemark,
};
use zwidth_runner::{Inputs, Job, JobError, Made, Making, ORIGIN, Stage, strip_root};
use zwidth_store::{Findings, Signal, StoreError, StudyData};
use zwidth_study::{Axes, Kind, MetricId, Scene, Setup, Task};
use zwidth_tables::{About, Format, Measured, NoteKind, Table, TableError};

/// Its version is raised when the page would be written differently from the same data.
const STAGE: Stage = Stage { name: "summary", version: 26 };

/// What the page depends on besides files.
#[derive(Serialize)]
pub(crate) struct Page {
    facts: Summary,
    pub(crate) planned: Setup,
    /// The figures' captions, in the order of their files.
    captions: Vec<Caption>,
    /// The metrics of trials that are compared, the primary ones first.
    of_trials: Vec<String>,
    pub(crate) primary: Primaries,
    /// The tasks whose thresholds are told.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    tasks: Vec<Task>,
    /// The level below which p values count.
    alpha: f64,
    /// The trials whose clock, angle or velocity is to be read with care.
    doubted: TrialNames,
    gallery: Gallery,
}

impl Page {
    /// The figure of a finding, or the table of conditions if the figure was not made or would be that
    /// of one session among many.
    fn shown_by(&self, shown: &Shown, summary: &Summary) -> String {
        let of_session = matches!(shown, Shown::Modes(_)) && self.gallery.only_session.is_none();
        let file = self.gallery.file(shown);
        if is_listed(summary, &file) && !of_session {
            file
        } else {
            self.gallery.table(&Shown::Conditions)
        }
    }
}

/// The files that the page speaks of, if they exist.
pub(crate) struct Files {
    /// Averages and fits, whose notes are limits of the study.
    noted: Vec<PathBuf>,
    /// The remarks on the trials of each session.
    remarks: Vec<Derived<TrialRemark>>,
    figures: Vec<PathBuf>,
    /// Those of the study's own stages.
    own_figures: Vec<PathBuf>,
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
    /// The curves compared.
    curves: Option<OfCurves>,
    /// Everybody's thresholds, and those over people.
    thresholds: Option<(Derived<PsychometricFit>, Option<Derived<PeopleThreshold>>)>,
    /// Whether changes between sessions are listed.
    has_session_changes: bool,
}

impl Inputs for Files {
    fn files(&self) -> Vec<PathBuf> {
        let mut files = [self.noted.as_slice(), &self.figures, &self.tables].concat();
        files.extend(self.own_figures.files());
        files.extend([self.remarks.files(), self.metrics.files(), self.tally.files()].concat());
        if let Some(curves) = &self.curves {
            files.extend([curves.tests.path(), curves.runs.path()].map(ToOwned::to_owned));
        }
        files.extend([self.statements.files(), self.trade.files(), self.ladder.files()].concat());
        if let Some((fits, over)) = &self.thresholds {
            files.extend([fits.files(), over.files()].concat());
        }
        if let Some(comparison) = &self.compared {
            let names = [
                Compared::NAME,
                Mean::NAME,
                ModeDifference::NAME,
                RedrawnDifference::NAME,
                Learning::NAME,
                MetricNote::NAME,
            ];
            files.extend(names.map(|name| comparison.file(name)));
            if comparison.has_groups {
                files.push(comparison.file(GroupDifference::NAME));
                files.push(comparison.file(GroupMember::NAME));
            }
            if comparison.has_person_values() {
                files.push(comparison.file(PersonValue::NAME));
            }
            if comparison.has_effects {
                files.extend(
                    [EffectDifference::NAME, FactorTest::NAME].map(|name| comparison.file(name)),
                );
            }
            if self.has_session_changes {
                files.push(comparison.file(SessionChange::NAME));
            }
        }
        files
    }
}

pub(crate) fn job(data: &StudyData, findings: &Findings, figures: &[Drawing]) -> Job {
    let (page, files) = inputs(data, findings, figures);
    let output = data.layout.reports().join("summary.md");
    Job::new(STAGE, "summary", page, files, vec![output], make).tolerant()
}

/// What the summary depends on.
pub(crate) fn inputs(data: &StudyData, findings: &Findings, figures: &[Drawing]) -> (Page, Files) {
    let mut compared = compare::compared(data);
    // Scores and thresholds are in tables of their own.
    compared.retain(|metric| !zwidth_metrics::is_of_answers(&data.study, metric));
    let files = Files {
        noted: [average::at_onset(data), freemotion::tables(data)].concat(),
        remarks: metrics::remarks(data),
        figures: figures.iter().map(Drawing::picture).collect(),
        own_figures: shown(data)
            .iter()
            .map(|figure| data.layout.reports().join(&figure.path))
            .collect(),
        tables: tables::files(data),
        metrics: metrics::of_study(data),
        tally: likert::tally(data),
        statements: report::statements(data),
        trade: trade::recommended(data),
        ladder: ladder::of_study(data),
        compared: compare::of_study(data),
        curves: curves::of_study(data),
        thresholds: thresholds::fits(data).map(|fits| (fits, thresholds::over_people(data))),
        has_session_changes: compare::has_session_changes(data),
    };
    let page = Page {
        facts: facts(data, findings),
        planned: Setup::of(&data.study),
        captions: figures.iter().map(|figure| figure.caption.clone()).collect(),
        of_trials: compared,
        primary: Primaries::of(&data.study),
        tasks: data.study.tasks.clone(),
        alpha: data.study.compare.alpha,
        doubted: doubted(data, findings),
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
    /// The results on the metrics that are compared.
    pub(crate) compared: ReadComparison,
    /// Those metrics of the trials that the page needs.
    pub(crate) metrics: Option<Measured>,
}

pub(crate) fn gather(page: &Page, files: &Files, making: &Making) -> Result<Gathered, JobError> {
    let folder = making.outputs.first().and_then(|page| page.parent()).unwrap_or(making.root);
    let mut summary = page.facts.clone();
    // Sets: averages of many conditions have one note in common, and trials one remark.
    let mut limits = BTreeSet::new();
    for path in files.noted.iter().filter(|path| path.exists()) {
        let notes = Table::about(path)?.notes.into_iter();
        limits.extend(notes.filter(|(kind, _)| *kind != NoteKind::Extent).map(|(_, note)| note));
    }
    summary.limits.extend(limits);
    let (mut left_out, mut care) = (BTreeSet::new(), BTreeSet::new());
    for TrialRemark { kind, what, why, .. } in remarks(&files.remarks)? {
        let list = if kind == NoteKind::LeftOut { &mut left_out } else { &mut care };
        list.insert(Remark { what, why: why.to_string() });
    }
    summary.left_out.extend(left_out);
    summary.care.extend(care);
    let mut missing = Vec::new();
    for (file, caption) in files.figures.iter().zip(&page.captions) {
        if !file.exists() {
            missing.push(could_not_be_made(file));
            continue;
        }
        let path = file.strip_prefix(folder).unwrap_or(file).to_string_lossy().replace('\\', "/");
        let kind = caption.kind.shows.to_owned();
        summary.figures.push(Listed { kind, ..Listed::new(path, caption.text()) });
    }
    summary.own_figures.retain(|figure| folder.join(&figure.path).exists());
    let own_figures = files.own_figures.iter().filter(|file| !file.exists());
    missing.extend(own_figures.map(|file| could_not_be_made(file)));
    let (existing, no_tables): (Vec<_>, Vec<_>) = files.tables.iter().partition(|f| f.exists());
    let tables = existing.par_iter().map(|file| {
        let About { title, rows, notes, .. } = Table::about(file)?;
        let why = notes.into_iter().find(|(kind, _)| *kind == NoteKind::LeftOut);
        Ok((Listed::new(page.gallery.table_file(&stem(file)), title), rows, why))
    });
    for (table, rows, why) in tables.collect::<Result<Vec<_>, TableError>>()? {
        if rows == 0 {
            let what = table.path.clone();
            let unknown = || "the table has no row: no trial has what it is made of".to_owned();
            let why = why.map_or_else(unknown, |(_, note)| note);
            summary.left_out.push(Remark { what, why });
        }
        summary.tables.push(table);
    }
    let compared = ReadComparison::of(files)?;
    let of_compared = compared.by_metric(page.primary);
    summary.matrix = zwidth_report::matrix(&page.planned, &of_compared);
    let limits = compared.notes.iter().filter(|note| note.kind == NoteKind::Limit);
    let limits: BTreeSet<String> = limits.map(|note| note.note.to_string()).collect();
    summary.limits.extend(limits);
    let metrics = files.metrics.as_deref().filter(|file| file.exists());
    let metrics =
        metrics.map(|file| metrics::read_for_report(file, &page.of_trials)).transpose()?;
    if let Some(metrics) = &metrics {
        summary.limits.extend(uneven_ranges(&page.planned, metrics)?);
    }
    // JNDs are told as ratios, and thresholds in sentences of their own.
    let is_of_tasks = |own: &ComparedMetric| {
        let mut all = page.tasks.iter().flat_map(|task| {
            task.quantities().into_iter().filter_map(|quantity| task.metric(quantity).ok())
        });
        all.any(|metric| metric == own.metric.metric)
    };
    let (of_tasks, of_compared) =
        of_compared.into_iter().partition::<Vec<ComparedMetric>, _>(|own| is_of_tasks(own));
    let primary = of_tasks.iter().filter(|own| own.metric.role == Role::Primary);
    let felt =
        felt(page, files, &primary.map(|own| own.metric.metric.clone()).collect::<Vec<_>>())?;
    let mut sentences = zwidth_report::contrasts(&page.planned, &of_compared);
    let [primary, others] = primary_first(&of_compared);
    for primary in primary {
        sentences.extend(zwidth_report::group_differences(&page.planned, primary));
        sentences.extend(zwidth_report::factor_effects(&page.planned, primary));
        let learning = own(&compared.learning, |row| row.metric == primary.metric.metric);
        sentences.extend(learned(&page.planned, primary, learning));
        let sessions = own(&compared.sessions, |row| row.metric == primary.metric.metric);
        sentences.extend(changes(&page.planned, primary, sessions));
    }
    let (mut primary_curves, mut other_curves) = (Vec::new(), Vec::new());
    if let Some(curves) = &files.curves
        && let (Some(tests), Some(runs)) =
            (curves.tests.read_if_made()?, curves.runs.read_if_made()?)
    {
        let (primary, others) =
            tests.into_iter().partition::<Vec<_>, _>(|test| test.role == Role::Primary);
        primary_curves = curve_answers(&page.planned, &primary, page.primary);
        primary_curves.extend(curve_differences(&page.planned, &primary, &runs, page.alpha));
        other_curves = curve_differences(&page.planned, &others, &runs, page.alpha);
    }
    let first = if primary.is_empty() { 0 } else { sentences.len() };
    sentences.splice(first..first, primary_curves);
    for metric in others {
        sentences.extend(zwidth_report::explored_effects(&page.planned, metric));
        sentences.extend(zwidth_report::explored_groups(&page.planned, metric));
    }
    sentences.extend(other_curves);
    sentences.extend(felt);
    summary.shown = list_findings(page, files, metrics.as_ref(), sentences, &summary)?;
    if let Some(statements) = files.statements.as_ref().filter(|table| table.path().exists()) {
        let (rows, notes) = statements.read_with_notes()?;
        let (counts, mut judged) = zwidth_report::told(&rows, &notes);
        for statement in &mut judged {
            if !is_listed(&summary, &statement.path) {
                statement.path = page.gallery.table(&Shown::Statements);
            }
        }
        // A study that measured nothing of the thesis is of another kind.
        if !judged.is_empty() {
            summary.statements = counts;
            summary.judged = judged;
        }
    }
    summary.runs = list_runs(page, files, &summary)?;
    summary.left_out.extend(missing);
    summary.left_out.extend(no_tables.into_iter().map(|file| could_not_be_made(file)));
    Ok(Gathered { summary, compared, metrics })
}

/// What the trials show, each sentence with the figure or table that holds its numbers: metrics of
/// the trials, tally of the answers.
fn list_findings(
    page: &Page,
    files: &Files,
    metrics: Option<&Measured>,
    mut all: Vec<Finding>,
    summary: &Summary,
) -> Result<Vec<Listed>, TableError> {
    let tally = match &files.tally {
        Some(tally) => tally.read_if_made()?,
        None => None,
    };
    all.extend(match (metrics, tally.as_deref()) {
        (Some(metrics), tally) => findings(&page.planned, metrics, tally, &page.doubted)?,
        (None, Some(tally)) => survey(&page.planned, tally),
        (None, None) => Vec::new(),
    });
    let all = all.into_iter();
    let listed = all.map(|finding| Listed {
        question: finding.shown.question(),
        is_answer: finding.is_answer,
        ..Listed::new(page.shown_by(&finding.shown, summary), finding.text)
    });
    Ok(listed.collect())
}

/// What tasks tell can be felt.
fn felt(page: &Page, files: &Files, primary: &[MetricId]) -> Result<Vec<Finding>, TableError> {
    let Some((fits, over)) = &files.thresholds else { return Ok(Vec::new()) };
    let fits = fits.read_if_made()?.unwrap_or_default();
    let over = over.as_ref().map(Derived::read_if_made).transpose()?.flatten();
    let rows = over.unwrap_or_default();
    Ok(zwidth_report::felt_thresholds(&page.planned, &page.tasks, &fits, &rows, primary))
}

/// What runs of the model show: the cheapest that could not be told from the right one, and the
/// terms that each condition requires.
fn list_runs(page: &Page, files: &Files, summary: &Summary) -> Result<Vec<Listed>, TableError> {
    let mut findings = Vec::new();
    if let Some(trade) = &files.trade
        && let Some(choices) = trade.read_if_made()?
    {
        findings.extend(traded(&page.planned, &choices));
    }
    if let Some(ladder) = &files.ladder
        && let Some(choices) = ladder.read_if_made()?
    {
        findings.extend(laddered(&page.planned, &choices));
    }
    let listed = findings.into_iter().map(|Finding { shown, text, .. }| {
        let file = page.gallery.file(&shown);
        let path = if is_listed(summary, &file) { file } else { page.gallery.table(&shown) };
        Listed::new(path, text)
    });
    Ok(listed.collect())
}

/// Whether a figure or table was made, and so is in the summary's lists.
fn is_listed(summary: &Summary, path: &str) -> bool {
    summary.figures.iter().chain(&summary.tables).any(|listed| listed.path == path)
}

/// The results on the metrics that are compared; empty if they could not be made.
#[derive(Default)]
pub(crate) struct ReadComparison {
    metrics: Vec<Compared>,
    means: Vec<Mean>,
    contrasts: Vec<ModeDifference>,
    groups: Vec<GroupDifference>,
    group_members: Vec<GroupMember>,
    person_values: Vec<PersonValue>,
    effects: Vec<EffectDifference>,
    factor_tests: Vec<FactorTest>,
    sessions: Vec<SessionChange>,
    learning: Vec<Learning>,
    redrawn: Vec<RedrawnDifference>,
    notes: Vec<MetricNote>,
}

impl ReadComparison {
    fn of(files: &Files) -> Result<Self, TableError> {
        let tables = files.compared.as_ref().filter(|all| all.file(Compared::NAME).exists());
        let Some(tables) = tables else { return Ok(Self::default()) };
        let sessions = if files.has_session_changes { tables.table().read()? } else { Vec::new() };
        Ok(Self {
            metrics: tables.table().read()?,
            means: tables.table().read()?,
            contrasts: tables.table().read()?,
            groups: if tables.has_groups { tables.table().read()? } else { Vec::new() },
            group_members: if tables.has_groups { tables.table().read()? } else { Vec::new() },
            person_values: match tables.has_person_values() {
                true => tables.table().read()?,
                false => Vec::new(),
            },
            effects: if tables.has_effects { tables.table().read()? } else { Vec::new() },
            factor_tests: if tables.has_effects { tables.table().read()? } else { Vec::new() },
            sessions,
            learning: tables.table().read_if_made()?.unwrap_or_default(),
            redrawn: tables.table().read_if_made()?.unwrap_or_default(),
            notes: tables.table().read()?,
        })
    }

    /// Metric by metric: the rows of one stand together.
    pub(crate) fn by_metric(&self, primary: Primaries) -> Vec<ComparedMetric<'_>> {
        let compared = self.metrics.iter().map(|metric| ComparedMetric {
            metric,
            primary,
            means: own(&self.means, |row| row.metric == metric.metric),
            contrasts: own(&self.contrasts, |row| row.metric == metric.metric),
            groups: own(&self.groups, |row| row.metric == metric.metric),
            group_members: &self.group_members,
            person_values: own(&self.person_values, |row| row.metric == metric.metric),
            effects: own(&self.effects, |row| row.metric == metric.metric),
            factor_tests: own(&self.factor_tests, |row| row.metric == metric.metric),
            redrawn: own(&self.redrawn, |row| row.metric == metric.metric),
        });
        compared.collect()
    }
}

/// The first stretch of rows that belong together.
fn own<R>(rows: &[R], is_own: impl Fn(&R) -> bool) -> &[R] {
    let first = rows.iter().position(&is_own).unwrap_or(rows.len());
    let after = rows[first..].iter().position(|row| !is_own(row));
    &rows[first..after.map_or(rows.len(), |more| first + more)]
}

fn facts(data: &StudyData, findings: &Findings) -> Summary {
    let counting: Vec<_> = data.counting().collect();
    let recorded = recorded(data);
    let mut environments =
        counting.iter().filter_map(|t| data.study.environment(&t.meta.environment));
    let mut limits = Vec::new();
    if data.study.device.lever_m.is_none() && environments.any(|e| e.scene != Scene::None) {
        let limit = match has_torque_alone(data) {
            true => {
                "No lever length is known (device.lever_m), so torque stays torque: N·m on axes and in tables."
            }
            false => {
                "No lever length is known (device.lever_m): shares of the work are computed, but no energy in joules and no power, and the model is not replayed."
            }
        };
        limits.push(limit.to_owned());
    }
    if let Some(axes) = &data.study.axes {
        limits.push(along_push(axes));
    }
    // What figures and metrics must do without, because some trial was recorded without it.
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
    for (what, signals, so) in needed {
        let without =
            counting.iter().filter(|t| !signals.iter().any(|s| t.said.signals.contains(s)));
        let n = without.count();
        let all = counting.len();
        // Of positions and forces in several axes that nothing projects, the line above says all.
        let is_of_axes = data.study.axes.is_some() && n == all;
        if n > 0 && !is_of_axes {
            limits.push(format!("No {what} was recorded in {n} of {all} trials: for them {so}."));
        }
    }
    Summary {
        title: data.study.title.clone(),
        device: data.study.device.name.clone(),
        participants: recorded.participants,
        sessions: recorded.sessions,
        trials: recorded.trials,
        sweeps: recorded.sweeps,
        own_figures: shown(data),
        undrawn: crate::figures::without_own(data),
        sources: recorded.sources,
        left_out: left_out(data, findings),
        care: findings.with_care.iter().map(|finding| remark(data, finding)).collect(),
        limits,
        plan: recorded.plan,
        ..Summary::default()
    }
}

/// What a study with axes must do without, and which of its results are of one direction alone.
fn along_push(axes: &Axes) -> String {
    let [x, y, z] = axes.push;
    format!(
        "Positions and forces are in several axes ({}; paths behind a low-pass of {} Hz): what says \"along push\" is of \
         their projections on push = [{x}, {y}, {z}] alone, onset, duration_s and end among it; how long a whole trial lasts \
         is recording_s, and how long it moves in any direction completion_s. The model has one coordinate: no plant is \
         identified, no trial is replayed, and no swing is judged.",
        axes.frame, axes.low_pass_hz
    )
}

/// The trials that count whose clock, angle or velocity is in doubt: a swing is recognised by these.
fn doubted(data: &StudyData, findings: &Findings) -> TrialNames {
    let signals = [Signal::Time, Signal::Theta, Signal::ThetaDot].map(Signal::name);
    let doubts = findings.with_care.iter().filter(|doubt| {
        doubt.column.as_ref().is_some_and(|column| signals.contains(&column.as_str()))
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
    let [torque, force] = [Signal::TorqueEx, Signal::ForceEx]
        .map(|signal| data.counting().any(|trial| trial.said.signals.contains(&signal)));
    torque && !force
}

/// Every trial of the experiment that does not count, and every other finding about what is in no
/// result.
fn left_out(data: &StudyData, findings: &Findings) -> Vec<Remark> {
    let mut by_file: BTreeMap<&Path, Vec<Remark>> = BTreeMap::new();
    for finding in &findings.left_out {
        by_file.entry(&finding.path).or_default().push(remark(data, finding));
    }
    let mut all = Vec::new();
    for trial in data.trials.iter().filter(|t| t.meta.kind == Kind::Trial) {
        let Some(why) = trial.why_not() else { continue };
        // Removed: a trial is listed once, and the rest below belongs to no trial.
        let own = by_file.remove(&*trial.path).unwrap_or_default();
        let own: Vec<String> = own.into_iter().map(|remark| remark.why).collect();
        let why = if own.is_empty() { why } else { own.join("; ") };
        all.push(Remark { what: name(&trial.meta), why });
    }
    all.extend(by_file.into_values().flatten());
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

/// The remarks on trials, session by session.
pub(crate) fn remarks(sessions: &[Derived<TrialRemark>]) -> Result<Vec<TrialRemark>, TableError> {
    let mut all = Vec::new();
    for session in sessions {
        all.extend(session.read_if_made()?.unwrap_or_default());
    }
    Ok(all)
}

fn could_not_be_made(file: &Path) -> Remark {
    Remark { what: stem(file), why: "it could not be made; `zwidth run` says why".to_owned() }
}

fn stem(file: &Path) -> String {
    file.file_stem().unwrap_or_default().to_string_lossy().into_owned()
}
