//! Stage `compare`: modes, participants and sessions compared, one job for all metrics and one for answers; its figures.

mod asked;
mod chosen;
mod parameters;

pub use asked::{asked_in_vain, claims, compared, inflation_by_groups};
pub(crate) use asked::{
    claims_of_both, compares_curves, environments_of_curves, has_group_differences, is_of_one,
    took_part,
};
pub(crate) use chosen::chosen_after;
pub(crate) use parameters::{ScoreColumn, groups, order};

use crate::figures::drawing::{Drawing, Figured};
use crate::likert::figures::{self as likert_figures, Page};
use crate::shared::conditions::trial_sources;
use crate::shared::handle::{Derived, file_within, write_named};
use crate::shared::making::derived;
use crate::tables::printed::Printed;
use crate::{likert, metrics, thresholds};
use asked::are_several;
use parameters::{Comparing, OfMetrics};
use serde::Serialize;
use std::collections::BTreeSet;
use std::path::PathBuf;
use zwidth_compare::AnswerParameters;
use zwidth_draw::Figure;
use zwidth_figures::{
    ANSWERS_COMPARED, About, AnswersPage, EFFECTS_COMPARED, FigureKind, GROUPS_COMPARED,
    IN_ONE_COLUMN, MODES_COMPARED, MetricResults, PARTICIPANTS_COMPARED, REPEATS_COMPARED,
    SESSIONS_COMPARED, VERDICTS, VerdictRow, answers_compared, verdict_rows,
};
use zwidth_results::{
    AnswerDifference, AnyGroup, Cell, Compared, CovariateSlope, DoseModel, DosePoint,
    EffectDifference, FactorTest, GivenAnswer, GroupDifference, GroupMean, GroupMember,
    GroupModeDifference, GroupModel, GroupModelTest, Learning, Mean, MetricNote, ModeDifference,
    Model, NoteKind, Omnibus, OrderTest, PersonDifference, PersonSuperiority, PersonValue,
    PrintedDifference, PsychometricFit, RedrawnDifference, RepeatMean, Row, SessionChange,
    TrialScore, TrialSlope, UnitOfAnalysis,
};
use zwidth_runner::{Inputs, Job, JobError, Made, Making, Stage};
use zwidth_store::{Answer, Layout, StudyData};
use zwidth_study::{Environment, MetricId, Source};
use zwidth_tables::{Measured, Table, TableError};

pub(crate) const STAGE: Stage = Stage { name: "compare", version: zwidth_compare::VERSION };

/// The tables of a study whose people are of several groups, in the order in which they are read.
const OF_GROUPS: [&str; 6] = [
    GroupDifference::NAME,
    GroupMean::NAME,
    GroupModeDifference::NAME,
    AnyGroup::NAME,
    GroupModel::NAME,
    GroupModelTest::NAME,
];

/// The tables of a study with factors, likewise.
const OF_FACTORS: [&str; 2] = [EffectDifference::NAME, FactorTest::NAME];

/// The tables that look at repeats of a condition or at the order of trials.
const OF_REPEATS: [&str; 3] = [Model::NAME, Learning::NAME, OrderTest::NAME];

/// The results of the stage on metrics: one folder, with a table for each kind of row.
#[derive(Clone)]
pub(crate) struct Comparison {
    folder: PathBuf,
    /// Whether groups of people are compared.
    pub(crate) has_groups: bool,
    /// Whether differences are compared over numbers of people.
    has_covariates: bool,
    /// Whether means are adjusted along lines over trials.
    has_lines: bool,
    /// Whether effects of factors are compared.
    pub(crate) has_effects: bool,
    /// Whether lines over doses are.
    has_doses: bool,
}

impl Comparison {
    fn of(data: &StudyData) -> Self {
        let has_groups = data.study.compare.groups.is_some();
        let has_covariates = !data.study.compare.covariates.is_empty();
        let effects = data.study.effects();
        let has_doses = !data.study.dose_curves().is_empty();
        let folder = derived(&data.layout, "compare");
        let has_lines = data.study.compare.over.is_some();
        Self {
            folder,
            has_groups,
            has_covariates,
            has_lines,
            has_effects: !effects.is_empty(),
            has_doses,
        }
    }

    /// Whether everybody's effects, or values in which groups are compared, are there.
    pub(crate) fn has_person_values(&self) -> bool {
        self.has_groups || self.has_effects
    }

    /// The table of rows `R`.
    pub(crate) fn table<R: Row>(&self) -> Derived<R> {
        Derived::within(&self.folder)
    }

    /// The file of the table of that name.
    pub(crate) fn file(&self, name: &str) -> PathBuf {
        file_within(&self.folder, name)
    }

    /// The results on one metric.
    fn read(&self, metric: &MetricId) -> Result<MetricResults, JobError> {
        let compared = self.table::<Compared>().read_of(metric)?.into_iter().next();
        Ok(MetricResults {
            metric: compared.ok_or_else(|| format!("the metric {metric} was not compared"))?,
            cells: self.table().read_of(metric)?,
            means: self.table().read_of(metric)?,
            contrasts: self.table().read_of(metric)?,
            participants: self.table().read_of(metric)?,
            groups: match self.has_groups {
                true => self.table().read_of(metric)?,
                false => Vec::new(),
            },
            effects: match self.has_effects {
                true => self.table().read_of(metric)?,
                false => Vec::new(),
            },
            trend_curves: match self.has_doses {
                true => self.table().read_of(metric)?,
                false => Vec::new(),
            },
            group_means: match self.has_groups {
                true => self.table().read_of(metric)?,
                false => Vec::new(),
            },
            group_members: match self.has_groups {
                true => self.table().read()?,
                false => Vec::new(),
            },
            sessions: self.table().read_of(metric)?,
            repeats: self.table().read_of(metric)?,
            redrawn: self.table().read_of(metric)?,
            notes: self.table().read_of(metric)?,
        })
    }
}

impl Inputs for Comparison {
    fn files(&self) -> Vec<PathBuf> {
        let names = [
            Compared::NAME,
            Cell::NAME,
            Mean::NAME,
            ModeDifference::NAME,
            PrintedDifference::NAME,
            Omnibus::NAME,
            Model::NAME,
            PersonDifference::NAME,
            SessionChange::NAME,
            Learning::NAME,
            RepeatMean::NAME,
            OrderTest::NAME,
            RedrawnDifference::NAME,
            MetricNote::NAME,
        ];
        let mut names = names.to_vec();
        if self.has_groups {
            names.extend(OF_GROUPS);
            names.push(GroupMember::NAME);
        }
        if self.has_covariates {
            names.push(CovariateSlope::NAME);
        }
        if self.has_lines {
            names.push(TrialSlope::NAME);
        }
        if self.has_effects {
            names.extend(OF_FACTORS);
        }
        if self.has_doses {
            names.extend([DosePoint::NAME, DoseModel::NAME]);
        }
        if self.has_person_values() {
            names.push(PersonValue::NAME);
        }
        names.into_iter().map(|name| self.file(name)).collect()
    }
}

/// What is compared in a study.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum By {
    /// Its modes: means, contrasts, and these against other orders of the trials.
    Mode,
    /// Its participants: everybody's differences between modes.
    Participant,
    /// Its groups of participants.
    Group,
    /// Its sessions: changes between them.
    Session,
    /// Its repeats: changes from one to the next.
    Repeat,
    /// Its modes, by the answers.
    Answer,
}

/// The tables of a comparison, as they are printed, in the order in which they are read.
pub fn comparison(data: &StudyData, by: By, metric: &str) -> Vec<Printed> {
    let tables = Comparison::of(data);
    let names = match by {
        By::Answer => {
            return vec![Printed::without_empty_columns(answers_of(&data.layout).0.path())];
        }
        By::Mode if data.study.compare.contrasts.is_empty() => {
            let of_factors = OF_FACTORS.into_iter().filter(|_| tables.has_effects);
            [Mean::NAME].into_iter().chain(of_factors).chain([Omnibus::NAME]).collect()
        }
        By::Mode => {
            let of_factors = OF_FACTORS.into_iter().filter(|_| tables.has_effects);
            let of_modes = [Mean::NAME, ModeDifference::NAME];
            of_modes.into_iter().chain(of_factors).chain([Omnibus::NAME, OrderTest::NAME]).collect()
        }
        By::Participant if tables.has_covariates => {
            vec![PersonDifference::NAME, CovariateSlope::NAME]
        }
        By::Participant => vec![PersonDifference::NAME],
        By::Group => OF_GROUPS.to_vec(),
        By::Session => vec![SessionChange::NAME],
        By::Repeat if tables.has_lines => vec![TrialSlope::NAME, Learning::NAME],
        By::Repeat => vec![Learning::NAME],
    };
    names.into_iter().map(|name| Printed::of_metric(&tables.file(name), metric)).collect()
}

/// How participants differ in a metric: the contrasts, and the mixed models.
///
/// # Errors
/// Tables that do not exist.
pub fn spreads(
    data: &StudyData,
    metric: &MetricId,
) -> Result<(Vec<ModeDifference>, Vec<Model>), TableError> {
    let tables = Comparison::of(data);
    Ok((tables.table().read_of(metric)?, tables.table().read_of(metric)?))
}

/// The contrasts of a metric as other programs print them, beside zwidth's own, as a table. They are computed from the
/// table of metrics when they are asked for: no figure or page shows them.
///
/// # Errors
/// Tables that do not exist; a metric that is not compared.
pub fn peers(data: &StudyData, metric: &str) -> Result<Table, JobError> {
    let metric: MetricId = metric.parse()?;
    let Comparing { stage, simulated } = Comparing::<OfMetrics>::of(data)?;
    let tables = read_measured(&stage, &compares(data, &stage))?;
    let (contrasts, models) = spreads(data, &metric)?;
    let compared = Comparison::of(data).table::<Compared>().read_of(&metric)?;
    let compared =
        compared.first().ok_or_else(|| format!("the metric {metric} was not compared"))?;
    if let UnitOfAnalysis::TrialsOf(who) = &compared.unit_of_analysis {
        return Err(
            format!("{who} alone took part: the other programs compare several people").into()
        );
    }
    let rows = zwidth_compare::peers(&tables, &metric, &contrasts, &models, &stage.parameters)?;
    let table =
        zwidth_tables::of_metric(&Table::of_rows(&rows)?, compared, &[])?.with_mark(simulated);
    let table = table.with_note(
        "All numbers are computed by zwidth, as the programs print them with their own defaults; docs/analysis.md \
         (\"What other programs print\") has the calls.",
    );
    let table = match stage.parameters.groups {
        Some(_) => table.with_note_of(
            NoteKind::Care,
            "zwidth's own differences give groups of people the same weight; the other programs are told of no groups.",
        ),
        None => table,
    };
    Ok(match stage.parameters.over {
        Some(_) => table.with_note_of(
            NoteKind::Care,
            "zwidth's own differences are adjusted along lines over trials; the other programs are told of none.",
        ),
        None => table,
    })
}

/// How participants differ in the effects of factors on a metric.
///
/// # Errors
/// Tables that do not exist.
pub fn effects(data: &StudyData, metric: &MetricId) -> Result<Vec<EffectDifference>, TableError> {
    Comparison::of(data).table().read_of(metric)
}

/// The results on the study's metrics, if any is compared.
pub(crate) fn of_study(data: &StudyData) -> Option<Comparison> {
    (!compared(data).is_empty()).then(|| Comparison::of(data))
}

/// Who took part in a study.
struct Attendance {
    /// Whether there were several people.
    several: bool,
    /// Whether there were several people, and one of them came again.
    several_and_again: bool,
}

fn attendance(data: &StudyData) -> Attendance {
    let metas = data.counting().map(|trial| &trial.meta);
    let answered = data.answers.iter().map(|answer| (&answer.participant, &answer.session));
    let sessions: BTreeSet<_> =
        metas.map(|meta| (&meta.participant, &meta.session)).chain(answered).collect();
    let people: BTreeSet<_> = sessions.iter().map(|(participant, _)| participant).collect();
    let several = people.len() > 1;
    Attendance { several, several_and_again: several && sessions.len() > people.len() }
}

/// Whether the study's sessions are compared: several people took part, and one of them came again.
pub(crate) fn has_session_changes(data: &StudyData) -> bool {
    attendance(data).several_and_again
}

/// The tables that people read: that of all metrics; of every metric its means, its contrasts and its
/// changes; those of participants and sessions if there are several.
pub(crate) fn tables(data: &StudyData) -> Vec<Printed> {
    let Attendance { several, several_and_again } = attendance(data);
    let mut tables = Vec::new();
    if let Some(comparison) = of_study(data) {
        if !data.study.compare.contrasts.is_empty() {
            tables.push(Printed::whole(&comparison.file(PrintedDifference::NAME)));
        }
        let groups = data.study.compare.groups.as_ref().filter(|_| several);
        let of_groups = groups.is_some();
        let of_contrasts = !data.study.compare.contrasts.is_empty();
        let of_factors = comparison.has_effects;
        let of_more_groups = groups.is_some_and(|groups| groups.levels.len() > 2);
        let kinds = [
            (true, Mean::NAME),
            (of_contrasts, ModeDifference::NAME),
            (of_factors, EffectDifference::NAME),
            (of_factors && several && !data.study.compare.effects.is_empty(), FactorTest::NAME),
            (comparison.has_doses && several, DosePoint::NAME),
            (comparison.has_doses && several && !of_groups, DoseModel::NAME),
            (several, Omnibus::NAME),
            (several && of_contrasts, Model::NAME),
            (several && of_contrasts, PersonDifference::NAME),
            (several && comparison.has_covariates, CovariateSlope::NAME),
            (comparison.has_lines, TrialSlope::NAME),
            (of_groups, GroupDifference::NAME),
            (of_groups, GroupMean::NAME),
            (of_groups, GroupModeDifference::NAME),
            (of_groups, GroupModel::NAME),
            (of_groups && data.study.modes.len() > 1, GroupModelTest::NAME),
            (of_more_groups, AnyGroup::NAME),
            (several_and_again, SessionChange::NAME),
            (true, Learning::NAME),
            (of_contrasts, OrderTest::NAME),
        ];
        for metric in compared(data) {
            // Everybody has one threshold in a session and mode, and no repeats.
            let has_repeats = data.study.task_metric(&metric).is_none();
            let is_shown = |name| has_repeats || !OF_REPEATS.contains(&name);
            let kinds = kinds.iter().filter(|(is_printed, name)| *is_printed && is_shown(name));
            for (_, name) in kinds {
                tables.push(Printed::of_metric(&comparison.file(name), &metric));
            }
        }
    }
    tables.extend(answers(data).map(|table| Printed::without_empty_columns(&table)));
    tables
}

/// The answers compared, if there are some after several modes.
pub fn answers(data: &StudyData) -> Option<PathBuf> {
    let several = are_several(likert::ratings(data).map(|answer| &answer.condition.mode));
    likert::answers(data).filter(|_| several).map(|_| answers_of(&data.layout).0.path().to_owned())
}

/// The answers compared, and each participant's effects.
type AnswersOf = (Derived<AnswerDifference>, Derived<PersonSuperiority>);

fn answers_of(layout: &Layout) -> AnswersOf {
    let folder = derived(layout, "compare");
    (Derived::within(&folder), Derived::within(&folder))
}

/// The metrics of trials, the scores of answers, and what tasks tell.
type Compares = (Option<PathBuf>, Option<Derived<TrialScore>>, Option<Derived<PsychometricFit>>);

fn compares(data: &StudyData, stage: &OfMetrics) -> Compares {
    let scores = likert::scores(data).map(|(scores, _)| scores);
    let fits = thresholds::fits(data).filter(|_| !stage.thresholds.is_empty());
    (metrics::of_study(data), scores, fits)
}

pub(crate) fn jobs(data: &StudyData) -> Vec<Job> {
    let mut jobs = Vec::new();
    // Every metric that there is has a name that is an id: the parameters are never an error.
    if let (Some(tables), Ok(parameters)) = (of_study(data), Comparing::of(data)) {
        let inputs = compares(data, &parameters.stage);
        jobs.push(Job::new(STAGE, "compare metrics", parameters, inputs, tables.files(), make));
    }
    if answers(data).is_some() {
        let study = &data.study;
        let stage = AnswerParameters {
            environments: study.environments.iter().map(|e| e.id.clone()).collect(),
            modes: study.modes.iter().map(|m| m.id.clone()).collect(),
            questions: study.questions.iter().filter(|q| q.is_rating()).cloned().collect(),
            contrasts: study.compare.contrasts.clone(),
            level: study.compare.level,
        };
        let simulated = data.sessions.iter().any(|s| s.record.source.is_simulated());
        let parameters = Comparing { stage, simulated };
        let inputs = likert::answers(data);
        let outputs = answers_of(&data.layout).files();
        jobs.push(Job::new(STAGE, "compare answers", parameters, inputs, outputs, make_answers));
    }
    jobs
}

/// The values of the metrics, each in one of several tables.
fn read_measured(
    stage: &OfMetrics,
    (metrics, scores, fits): &Compares,
) -> Result<Vec<Measured>, JobError> {
    let mut tables = Vec::new();
    if let Some(scores) = scores {
        let rows = scores.read()?;
        for score in &stage.scores {
            tables.push(score.measured(&rows)?);
        }
    }
    if let Some(fits) = fits {
        let rows = fits.read()?;
        for own in &stage.thresholds {
            tables.push(own.measured(&rows)?);
        }
    }
    if let Some(metrics) = metrics {
        let names = stage.parameters.metrics.iter().map(|metric| metric.metric.as_str());
        let names: Vec<&str> = names.filter(|name| !stage.is_of_answers(name)).collect();
        tables.push(Measured::read(metrics, &names)?);
    }
    Ok(tables)
}

fn make(
    Comparing { stage, simulated }: &Comparing<OfMetrics>,
    compares: &Compares,
    making: &Making,
) -> Result<Made, JobError> {
    let tables = read_measured(stage, compares)?;
    let stage = &stage.parameters;
    let results = zwidth_compare::compare_tables(&tables, stage)?;
    let has_groups = stage.groups.is_some();
    let printed = zwidth_compare::together(&results.metrics, &results.contrasts, stage)?;
    let mut tables = vec![
        table_of(results.metrics)?,
        table_of(results.cells)?,
        table_of(results.means)?,
        table_of(results.contrasts)?,
        printed,
        table_of(results.omnibus)?,
        table_of(results.models)?,
        table_of(results.participants)?,
        table_of(results.sessions)?,
        table_of(results.learning)?,
        table_of(results.repeats)?,
        table_of(results.orders)?,
        table_of(results.redrawn)?,
        table_of(results.notes)?,
    ];
    if !stage.covariates.is_empty() {
        tables.push(table_of(results.covariates)?);
    }
    if stage.over.is_some() {
        tables.push(table_of(results.over_trials)?);
    }
    if has_groups {
        tables.extend([
            table_of(results.groups)?,
            table_of(results.group_members)?,
            table_of(results.group_means)?,
            table_of(results.group_contrasts)?,
            table_of(results.any_group)?,
            table_of(results.group_models)?,
            table_of(results.group_model_tests)?,
        ]);
    }
    if !stage.effects.is_empty() {
        tables.extend([table_of(results.effects)?, table_of(results.factor_tests)?]);
    }
    if !stage.dose_curves.is_empty() {
        tables.extend([table_of(results.trend_curves)?, table_of(results.trend_models)?]);
    }
    if has_groups || !stage.effects.is_empty() {
        tables.push(table_of(results.person_values)?);
    }
    write_named(tables, making, *simulated)
}

/// The table of rows, which go as soon as it is made: those of all metrics are many.
fn table_of<R: Row>(rows: Vec<R>) -> Result<Table, TableError> {
    Table::of_rows(&rows)
}

fn make_answers(
    parameters: &Comparing<AnswerParameters>,
    answers: &Option<Derived<GivenAnswer>>,
    making: &Making,
) -> Result<Made, JobError> {
    let answers = likert::read_counting(answers.as_ref().ok_or("there is no answer")?)?;
    let results = zwidth_compare::compare_answers(&answers, &parameters.stage)?;
    let contrasts = zwidth_compare::answers_table(&results.contrasts, &parameters.stage.contrasts)?;
    let participants = Table::of_rows(&results.participants)?;
    write_named(vec![contrasts, participants], making, parameters.simulated)
}

/// A figure of a metric.
type Draw = fn(&About, &[Environment], &[Source], &MetricResults) -> Figure;

/// What a figure of the stage depends on besides tables, and what draws it.
#[derive(Serialize)]
struct Drawn {
    about: About,
    environments: Vec<Environment>,
    sources: Vec<Source>,
    metric: String,
    #[serde(skip)]
    draw: Draw,
}

/// What the figure of all metrics depends on besides tables.
#[derive(Serialize)]
struct AllDrawn {
    about: About,
    environments: Vec<Environment>,
    sources: Vec<Source>,
    metrics: Vec<String>,
    is_narrow: bool,
}

fn draw_verdicts(drawn: &AllDrawn, tables: &Comparison) -> Figured {
    let AllDrawn { about, environments, sources, metrics, is_narrow } = drawn;
    let metrics = metrics.iter().map(|metric| tables.read(&metric.parse()?));
    let metrics = metrics.collect::<Result<Vec<_>, _>>()?;
    Ok((zwidth_figures::verdicts(about, environments, sources, &metrics, *is_narrow), Vec::new()))
}

/// The figure of every difference between modes, over two columns and in one.
pub(crate) fn verdict_figures(data: &StudyData) -> Vec<Drawing> {
    let metrics = compared(data);
    if metrics.is_empty() {
        return Vec::new();
    }
    let forms = [None, Some(IN_ONE_COLUMN)].map(|column| {
        let drawn = AllDrawn {
            about: About::of(&data.study),
            environments: data.study.environments.clone(),
            sources: trial_sources(data),
            metrics: metrics.clone(),
            is_narrow: column.is_some(),
        };
        let tables = Comparison::of(data);
        Drawing::new(data, VERDICTS, column, drawn, tables, draw_verdicts).of(trial_count(data))
    });
    forms.into()
}

/// Every difference between modes, as a terminal shows it.
///
/// # Errors
/// Tables that do not exist.
pub fn verdicts(data: &StudyData) -> Result<Vec<VerdictRow>, JobError> {
    let tables = Comparison::of(data);
    let metrics = compared(data).into_iter().map(|metric| tables.read(&metric.parse()?));
    let metrics = metrics.collect::<Result<Vec<_>, JobError>>()?;
    Ok(verdict_rows(&About::of(&data.study), &data.study.environments, &metrics))
}

/// How many trials are compared: those with samples, or those of a questionnaire.
fn trial_count(data: &StudyData) -> usize {
    let key = |answer: &Answer| (answer.participant.clone(), answer.session.clone(), answer.trial);
    match data.counting().count() {
        0 => data.answers.iter().map(key).collect::<BTreeSet<_>>().len(),
        trials => trials,
    }
}

/// The figures of every metric.
pub(crate) fn figures(data: &StudyData) -> Vec<Drawing> {
    let Attendance { several, several_and_again } = attendance(data);
    let trials = trial_count(data);
    let sources = trial_sources(data);
    let tables = Comparison::of(data);
    // One repeat shows no learning.
    let repeated = data.study.design.repeats > 1;
    let of_groups = has_group_differences(data);
    let of_contrasts = !data.study.compare.contrasts.is_empty();
    let of_factors = !data.study.compare.effects.is_empty();
    let kinds: [(bool, FigureKind, Draw); 6] = [
        // Where factors are compared, the means stand by their levels.
        (of_contrasts || !of_factors, MODES_COMPARED, zwidth_figures::modes_compared),
        (of_factors, EFFECTS_COMPARED, zwidth_figures::effects_compared),
        (several && of_contrasts, PARTICIPANTS_COMPARED, zwidth_figures::participants_compared),
        (of_groups, GROUPS_COMPARED, zwidth_figures::groups_compared),
        (several_and_again, SESSIONS_COMPARED, zwidth_figures::sessions_compared),
        (repeated, REPEATS_COMPARED, zwidth_figures::repeats_compared),
    ];
    let mut drawings = Vec::new();
    for metric in compared(data) {
        // Thresholds have figures of their own by mode.
        let is_threshold = data.study.task_metric(&metric).is_some();
        let by_mode = [MODES_COMPARED, PARTICIPANTS_COMPARED, REPEATS_COMPARED];
        let kinds = kinds.into_iter().filter(|(is_shown, ..)| *is_shown);
        for (_, kind, draw_metric) in
            kinds.filter(|(_, kind, _)| !(is_threshold && by_mode.contains(kind)))
        {
            let drawn = Drawn {
                about: About::of(&data.study),
                environments: data.study.environments.clone(),
                sources: sources.clone(),
                metric: metric.clone(),
                draw: draw_metric,
            };
            let drawing = Drawing::new(data, kind, [&metric], drawn, tables.clone(), draw);
            drawings.push(drawing.of(trials));
        }
    }
    drawings.extend(answers_figures(data));
    drawings
}

/// The figures of answers over several participants.
fn answers_figures(data: &StudyData) -> Vec<Drawing> {
    let people: BTreeSet<_> = data.sessions.iter().map(|s| &s.record.participant).collect();
    if people.len() < 2 || answers(data).is_none() {
        return Vec::new();
    }
    let pages = zwidth_figures::answers_pages(&likert_figures::list_rated(data));
    let sources: BTreeSet<_> = data.sessions.iter().map(|s| s.record.source).collect();
    let mut drawings = Vec::new();
    for (number, page) in likert_figures::numbered(pages) {
        let shown =
            data.answers.iter().filter(|a| page.shows(&a.condition.environment, &a.question));
        let answers = shown.count();
        let sources = sources.iter().copied().collect();
        let drawn = Page { about: About::of(&data.study), page, sources };
        let tables = answers_of(&data.layout);
        let drawing = Drawing::new(data, ANSWERS_COMPARED, number, drawn, tables, draw_answers);
        drawings.push(drawing.of(answers));
    }
    drawings
}

fn draw_answers(drawn: &Page<AnswersPage>, (contrasts, participants): &AnswersOf) -> Figured {
    let Page { about, page, sources } = drawn;
    let contrasts = contrasts.read()?;
    let participants = participants.read()?;
    Ok((answers_compared(about, page, &contrasts, &participants, sources), Vec::new()))
}

fn draw(drawn: &Drawn, tables: &Comparison) -> Figured {
    let Drawn { about, environments, sources, metric, draw } = drawn;
    let results = tables.read(&metric.parse()?)?;
    Ok((draw(about, environments, sources, &results), Vec::new()))
}
