//! Stage `compare`: modes, participants and sessions compared, one job for all metrics and one for answers; its figures.

use crate::figures::drawing::{Drawing, Figured};
use crate::likert::figures::{self as likert_figures, Page};
use crate::page::preregistered::preregistered;
use crate::shared::conditions::trial_sources;
use crate::shared::handle::{Derived, file_within, write_named};
use crate::shared::making::derived;
use crate::tables::printed::Printed;
use crate::{likert, metrics};
use serde::Serialize;
use std::collections::BTreeSet;
use std::path::PathBuf;
use zwidth_compare::{
    AnswerParameters, Covariate, DrawnOrder, Groups, MetricParameters, Noticed, Parameters,
    SessionOrder,
};
use zwidth_draw::Figure;
use zwidth_figures::{
    ANSWERS_COMPARED, About, AnswersPage, EFFECTS_COMPARED, FigureKind, GROUPS_COMPARED,
    IN_ONE_COLUMN, MODES_COMPARED, MetricResults, PARTICIPANTS_COMPARED, REPEATS_COMPARED,
    SESSIONS_COMPARED, VERDICTS, VerdictRow, answers_compared, verdict_rows,
};
use zwidth_results::{
    AnswerDifference, AnyGroup, Cell, Column, Compared, CovariateSlope, EffectDifference,
    FactorTest, GivenAnswer, GroupDifference, GroupMean, GroupMember, GroupModeDifference,
    Learning, Mean, MetricNote, ModeDifference, Model, Omnibus, OrderTest, PersonDifference,
    PersonSuperiority, PrintedDifference, RedrawnDifference, RepeatMean, Row, SessionChange,
    TrialKey, TrialScore, TrialSlope,
};
use zwidth_runner::{Inputs, Job, JobError, Made, Making, Stage};
use zwidth_store::{Answer, Layout, SessionLog, Signal, StudyData};
use zwidth_study::order::Rules;
use zwidth_study::{
    Bound, Coordinate, Effect, Environment, Event, Families, GroupsCompared, IdError, Known,
    MetricId, ParticipantId, PersonColumnId, Score, Source, Study,
};
use zwidth_tables::{Measured, Table, TableError};

pub(crate) const STAGE: Stage = Stage { name: "compare", version: zwidth_compare::VERSION };

/// The metrics that a study compares, where it does not say which, besides the primary one and the
/// one that is primary by default.
const OTHERS: [&str; 6] = [
    "wall_past_max_rad",
    "stiffness_n_per_rad",
    "loop_area_j",
    "force_rms_error_n",
    "returned_energy_share",
    "duration_s",
];

/// The tables of a study whose people are of several groups, in the order in which they are read.
const OF_GROUPS: [&str; 4] =
    [GroupDifference::NAME, GroupMean::NAME, GroupModeDifference::NAME, AnyGroup::NAME];

/// The tables of a study with factors, likewise.
const OF_FACTORS: [&str; 2] = [EffectDifference::NAME, FactorTest::NAME];

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
}

impl Comparison {
    fn of(data: &StudyData) -> Self {
        let has_groups = data.study.compare.groups.is_some();
        let has_covariates = !data.study.compare.covariates.is_empty();
        let has_effects = !data.study.effects().is_empty();
        let folder = derived(&data.layout, "compare");
        let has_lines = data.study.compare.over.is_some();
        Self { folder, has_groups, has_covariates, has_lines, has_effects }
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

/// How participants differ in the effects of factors on a metric.
///
/// # Errors
/// Tables that do not exist.
pub fn effects(data: &StudyData, metric: &MetricId) -> Result<Vec<EffectDifference>, TableError> {
    Comparison::of(data).table().read_of(metric)
}

/// The metrics that are compared: those that trials of this study can have, the primary ones first.
/// Empty in a study with one mode, unless groups of people or factors are compared.
pub fn compared(data: &StudyData) -> Vec<String> {
    let of_answers = data.answers.iter().map(|answer| &answer.condition.mode);
    let has_modes = are_several(data.counting().map(|trial| &trial.meta.mode).chain(of_answers));
    if !has_modes && !has_group_differences(data) && data.study.effects().is_empty() {
        return Vec::new();
    }
    let mut metrics = requested_metrics(&data.study);
    metrics.retain(|metric| is_possible(data, metric));
    metrics
}

/// Whether people of several groups took part, and the study compares them.
pub(crate) fn has_group_differences(data: &StudyData) -> bool {
    let Some(groups) = &data.study.compare.groups else { return false };
    are_several(
        took_part(data).into_iter().filter_map(|who| data.people.level(who, &groups.column)),
    )
}

/// Whether two items differ.
fn are_several<T: PartialEq>(mut all: impl Iterator<Item = T>) -> bool {
    all.next().is_some_and(|first| all.any(|other| other != first))
}

/// Whether some trial of the study can have a metric.
fn is_possible(data: &StudyData, metric: &str) -> bool {
    if let Some(score) = zwidth_metrics::score_of(&data.study, metric) {
        return data.answers.iter().any(|answer| score.questions.contains(&answer.question));
    }
    if data.study.device.lever_m.is_none() && zwidth_metrics::needs_lever(metric) {
        return false;
    }
    data.counting().any(|trial| {
        let environment = data.study.environment(&trial.meta.environment);
        environment.is_some_and(|e| {
            zwidth_metrics::is_possible(&data.study, metric, &e.scene, &trial.said.signals)
        })
    })
}

/// The metrics that a study asks for, the primary ones first, each once. Without a list of the others: a
/// few of zwidth's, and the study's own.
fn requested_metrics(study: &Study) -> Vec<String> {
    let others: Vec<String> = match &study.compare.metrics {
        Some(metrics) => metrics.iter().map(ToString::to_string).collect(),
        None => {
            let default = MetricId::primary().to_string();
            let own = zwidth_metrics::own_metrics(study).map(|own| own.id.to_string());
            let scores =
                study.scores.iter().filter_map(|score| Some(score.metric().ok()?.to_string()));
            let all = std::iter::once(default).chain(OTHERS.map(str::to_owned));
            all.chain(own).chain(scores).collect()
        }
    };
    let primary = study.compare.primary.metrics();
    let mut requested: Vec<String> = primary.iter().map(ToString::to_string).collect();
    for metric in others {
        if !requested.contains(&metric) {
            requested.push(metric);
        }
    }
    requested
}

/// How many claims are adjusted together with one of a metric, itself among them. As many as there can
/// be: a plan is made before it is known what every mode can have.
pub fn claims(study: &Study, metric: &str) -> usize {
    let compare = &study.compare;
    let signals: Vec<Signal> = Signal::all().collect();
    let is_claimed = |effect: &Effect| effect.is_claimed && !effect.weights.is_empty();
    let effects: Vec<Effect> = study.effects().into_iter().filter(is_claimed).collect();
    // Of groups in the mean over modes and in each contrast; in the mode, if there is one.
    let of_groups = compare.groups.as_ref().map_or(0, |groups| groups.contrasts.len());
    let in_groups = if study.modes.len() > 1 { compare.contrasts.len() + 1 } else { 1 };
    // The claims of a metric: of each environment that can have it, then those over several.
    let families = |metric: &str| -> Vec<usize> {
        let can_have = |environment: &Environment| {
            if let Some(score) = zwidth_metrics::score_of(study, metric) {
                // Answers that are imported need not be asked for anywhere.
                let asks = |place: &Environment| {
                    score.questions.iter().all(|id| place.questions().any(|own| own == id))
                };
                return asks(environment) || !study.environments.iter().any(asks);
            }
            zwidth_metrics::is_possible(study, metric, &environment.scene, &signals)
        };
        let in_each = study.environments.iter().filter(|own| can_have(own)).map(|environment| {
            let id = Some(&environment.id);
            let own = effects.iter().filter(|effect| effect.environment.as_ref() == id).count();
            compare.contrasts.len() + own + of_groups * (in_groups + own)
        });
        let over_several = effects.iter().filter(|effect| effect.environment.is_none());
        let over_several = over_several.filter(|effect| {
            let mut all = effect.weights.iter();
            all.all(|weight| study.environment(&weight.environment).is_some_and(can_have))
        });
        in_each.chain([over_several.count()]).collect()
    };
    let whole = |metric: &str| families(metric).into_iter().sum::<usize>();
    match compare.families {
        Families::Environment => families(metric).into_iter().max().unwrap_or(0),
        Families::Study if compare.primary.has(metric) => {
            compare.primary.metrics().iter().map(|metric| whole(metric.as_str())).sum()
        }
        Families::Metric | Families::Study => whole(metric),
    }
}

/// Remarks on metrics in study.toml that do not exist, and on bounds that have no effect.
pub fn asked_in_vain(study: &Study) -> Vec<String> {
    let mut remarks: Vec<String> = zwidth_metrics::taken(study)
        .map(|id| {
            format!(
                "[[metrics]] of study.toml: '{id}' is a column of the tables already; give the metric another \
                 id; it is left out"
            )
        })
        .collect();
    let mut are_unknown = false;
    for metric in requested_metrics(study) {
        if zwidth_metrics::is_number(study, &metric) {
            continue;
        }
        // A slide shows millimetres on its figures, but its metrics are named in radians like all.
        let in_radians = metric.replace("_per_mm", "_per_rad").replace("_mm", "_rad");
        let hint = match zwidth_metrics::is_number(study, &in_radians) {
            true => format!(": write {in_radians}, also on a slide"),
            false => String::new(),
        };
        are_unknown = true;
        remarks.push(format!(
            "[compare] of study.toml: there is no metric '{metric}' that is a number{hint}; \
             it is left out"
        ));
    }
    if are_unknown {
        let scores = study.scores.iter().filter_map(|score| Some(score.metric().ok()?.to_string()));
        let names: Vec<String> =
            zwidth_metrics::names(study).map(str::to_owned).chain(scores).collect();
        remarks.push(format!("[compare] of study.toml: the metrics are {}", names.join(", ")));
    }
    for (metric, bound) in &study.compare.bounds {
        let is_commanded = study
            .environments
            .iter()
            .any(|e| zwidth_metrics::commanded(metric.as_str(), &e.scene).is_some());
        if matches!(bound, Bound::Weber(_)) && !is_commanded {
            remarks.push(format!(
                "the bound of '{metric}' in study.toml is a Weber fraction, but no environment \
                 commands a value of it: give a number in its unit"
            ));
        }
    }
    remarks
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
            (several, Omnibus::NAME),
            (several && of_contrasts, Model::NAME),
            (several && of_contrasts, PersonDifference::NAME),
            (several && comparison.has_covariates, CovariateSlope::NAME),
            (comparison.has_lines, TrialSlope::NAME),
            (of_groups, GroupDifference::NAME),
            (of_groups, GroupMean::NAME),
            (of_groups, GroupModeDifference::NAME),
            (of_more_groups, AnyGroup::NAME),
            (several_and_again, SessionChange::NAME),
            (true, Learning::NAME),
            (of_contrasts, OrderTest::NAME),
        ];
        for metric in compared(data) {
            for (_, name) in kinds.iter().filter(|(is_printed, _)| *is_printed) {
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

/// What a comparison depends on.
#[derive(Serialize)]
struct Comparing<P> {
    stage: P,
    /// Whether any of the data are simulated.
    simulated: bool,
}

/// What a comparison of metrics depends on.
#[derive(Serialize)]
struct OfMetrics {
    #[serde(flatten)]
    parameters: Parameters,
    /// The scores among the metrics.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    scores: Vec<ScoreColumn>,
}

/// A score as a metric.
#[derive(Serialize)]
struct ScoreColumn {
    score: MetricId,
    metric: MetricId,
    words: String,
}

impl ScoreColumn {
    /// The scores of trials, as a table of metrics has them.
    fn measured(&self, rows: &[TrialScore]) -> Result<Measured, TableError> {
        let own = || rows.iter().filter(|row| row.score == self.score);
        let keys: Vec<TrialKey> = own()
            .map(|row| TrialKey {
                participant: row.participant.clone(),
                session: row.session.clone(),
                trial: row.trial,
                repeat: row.repeat,
                environment: row.environment.clone(),
                mode: row.mode.clone(),
                source: row.source,
            })
            .collect();
        let mut columns = TrialKey::columns(&keys);
        let mut column = Column::float("", Score::UNIT, "", own().map(|row| row.value));
        column.field.name = self.metric.to_string().into();
        column.field.description = self.words.clone().into();
        columns.push(column);
        Measured::of(Table::new(TrialScore::NAME, TrialScore::TITLE, columns)?)
    }
}

/// The metrics of trials, and the scores of answers.
type Compares = (Option<PathBuf>, Option<Derived<TrialScore>>);

impl Comparing<OfMetrics> {
    fn of(data: &StudyData) -> Result<Self, IdError> {
        let (study, compare) = (&data.study, &data.study.compare);
        let compared = compared(data);
        let mut metrics = Vec::new();
        for metric in &compared {
            let mut bounds = compare.bounds.iter();
            let bound = bounds.find(|(id, _)| id.as_str() == metric).map(|(_, bound)| bound);
            let bounds = study.environments.iter().map(|environment| match bound? {
                Bound::Absolute(bound) => Some(*bound),
                Bound::Weber(share) => {
                    let commanded = zwidth_metrics::commanded(metric, &environment.scene)?;
                    Some(share * commanded)
                }
            });
            let chosen = compare.better.iter().find(|(id, _)| id.as_str() == metric);
            let primary = compare.primary.has(metric);
            metrics.push(MetricParameters {
                metric: metric.parse()?,
                primary,
                better: chosen.map_or_else(|| zwidth_metrics::better(study, metric), |(_, b)| *b),
                // A plan is a promise on primary metrics alone.
                preregistered: if primary { preregistered(data, &compared) } else { None },
                bounds: bounds.collect(),
                // What cannot be felt is not noticed from any difference on.
                noticed: is_felt(study, metric).then(|| Noticed {
                    perception: study.perception.clone(),
                    lever_m: study.device.lever_m.unwrap_or(0.0),
                    is_slide: matches!(study.coordinate, Coordinate::Linear { .. }),
                    commanded: study
                        .environments
                        .iter()
                        .map(|e| zwidth_metrics::commanded(metric, &e.scene))
                        .collect(),
                }),
            });
        }
        let is_compared =
            |score: &ScoreColumn| compared.iter().any(|own| own == score.metric.as_str());
        let scores = study.scores.iter().filter_map(|score| {
            let metric = score.metric().ok()?;
            Some(ScoreColumn { score: score.id.clone(), metric, words: score.in_words() })
        });
        let scores: Vec<ScoreColumn> = scores.filter(is_compared).collect();
        let parameters = Parameters {
            metrics,
            environments: study.environments.iter().map(|e| e.id.clone()).collect(),
            modes: study.modes.iter().map(|m| m.id.clone()).collect(),
            contrasts: compare.contrasts.clone(),
            families: compare.families,
            alpha: compare.alpha,
            level: compare.level,
            effect_sizes: compare.effect_sizes.clone(),
            groups: compare.groups.as_ref().map(|compared| groups(data, compared)),
            covariates: compare.covariates.iter().map(|column| covariate(data, column)).collect(),
            over: compare.over,
            effects: study.effects(),
            orders: data.sessions.iter().map(|log| order(log, study)).collect(),
        };
        let trials = data.counting().any(|trial| trial.meta.source.is_simulated());
        let sessions = data.sessions.iter().any(|log| log.record.source.is_simulated());
        Ok(Self { stage: OfMetrics { parameters, scores }, simulated: trials || sessions })
    }
}

/// Who took part: who has a trial that counts, or an answer.
fn took_part(data: &StudyData) -> BTreeSet<&ParticipantId> {
    let of_trials = data.counting().map(|trial| &trial.meta.participant);
    of_trials.chain(data.answers.iter().map(|answer| &answer.participant)).collect()
}

/// Whether a metric describes something that a person could feel.
fn is_felt(study: &Study, metric: &str) -> bool {
    let is_score = zwidth_metrics::score_of(study, metric).is_some();
    !is_score && zwidth_metrics::is_felt(&study.metrics, metric)
}

/// The groups of those who took part.
pub(crate) fn groups(data: &StudyData, compared: &GroupsCompared) -> Groups {
    let levels_of = took_part(data).into_iter().filter_map(|who| {
        let own = data.people.level(who, &compared.column)?;
        Some((who.clone(), compared.levels.iter().position(|level| level == own)?))
    });
    Groups { levels_of: levels_of.collect(), compared: compared.clone() }
}

/// A number of those who took part.
fn covariate(data: &StudyData, id: &PersonColumnId) -> Covariate {
    let column = data.study.people.iter().find(|column| column.id == *id);
    let unit = match column.map(|column| &column.known) {
        Some(Known::Number { unit }) => unit.clone(),
        _ => String::new(),
    };
    let numbers = took_part(data).into_iter();
    let numbers = numbers.filter_map(|who| Some((who.clone(), data.people.number(who, id)?)));
    Covariate { column: id.clone(), unit, numbers: numbers.collect() }
}

/// How the order of a session came about. It was drawn for the study as it was then.
fn order(log: &SessionLog, study: &Study) -> SessionOrder {
    // A session without a copy of its study is taken to be of today's.
    let study = log.study.as_deref().unwrap_or(study);
    let drawn = log.record.order.map(|order| DrawnOrder {
        rules: Rules {
            scheme: order.scheme,
            ..Rules::of(study, order.participant_number, order.session_number)
        },
        seed: log.record.seed,
        familiarisation: study.design.familiarisation,
        environments: study.environments.iter().map(|e| e.id.clone()).collect(),
        modes: study.modes.iter().map(|m| m.id.clone()).collect(),
        repeated: repeated(&log.events),
    });
    let participant = log.record.participant.clone();
    let session = log.record.session.clone();
    SessionOrder { participant, session, drawn }
}

/// The trials that repeat another one, which may itself repeat a third: the number of each, and the
/// number of the trial that the order had in this place.
fn repeated(events: &[Event]) -> Vec<[u32; 2]> {
    let mut places: Vec<[u32; 2]> = Vec::new();
    for event in events {
        let Event::Superseded { trial, by } = event else { continue };
        // Events stand in the order of time, so a repeat of a repeat meets its predecessor here.
        let previous = places.iter().find(|[number, _]| number == trial);
        let place = previous.map_or(*trial, |[_, place]| *place);
        places.push([*by, place]);
    }
    places
}

pub(crate) fn jobs(data: &StudyData) -> Vec<Job> {
    let mut jobs = Vec::new();
    // Every metric that there is has a name that is an id: the parameters are never an error.
    if let (Some(tables), Ok(parameters)) = (of_study(data), Comparing::of(data)) {
        let scores = likert::scores(data).map(|(scores, _)| scores);
        let inputs = (metrics::of_study(data), scores);
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

fn make(
    Comparing { stage, simulated }: &Comparing<OfMetrics>,
    (metrics, scores): &Compares,
    making: &Making,
) -> Result<Made, JobError> {
    let mut tables = Vec::new();
    if let Some(scores) = scores {
        let rows = scores.read()?;
        for score in &stage.scores {
            tables.push(score.measured(&rows)?);
        }
    }
    if let Some(metrics) = metrics {
        let names = stage.parameters.metrics.iter().map(|metric| metric.metric.as_str());
        let is_score =
            |name: &&str| stage.scores.iter().any(|score| score.metric.as_str() == *name);
        let names: Vec<&str> = names.filter(|name| !is_score(name)).collect();
        tables.push(Measured::read(metrics, &names)?);
    }
    let stage = &stage.parameters;
    let results = zwidth_compare::compare_tables(&tables, stage)?;
    let has_groups = stage.groups.is_some();
    let printed =
        zwidth_compare::together(&results.metrics, &results.contrasts, stage.families, has_groups)?;
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
        ]);
    }
    if !stage.effects.is_empty() {
        tables.extend([table_of(results.effects)?, table_of(results.factor_tests)?]);
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
    let contrasts = zwidth_compare::answers_table(&results.contrasts)?;
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
        for (_, kind, draw_metric) in kinds.into_iter().filter(|(is_shown, ..)| *is_shown) {
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

#[cfg(test)]
mod tests {
    use super::*;
    use zwidth_study::{
        Better, Factor, FactorId, FactorOf, LevelId, OwnMetric, Primary, Statistic, Term,
        TrialPart, Weight, Weighted,
    };

    #[test]
    fn a_trial_that_was_done_again_twice_has_the_place_of_the_first() {
        let again = |trial, by| Event::Superseded { trial, by };
        let note = Event::Note { trial: Some(40), text: "slipped".to_owned() };
        let events = [again(2, 40), note, again(40, 41), again(3, 42)];
        assert_eq!(repeated(&events), [[40, 2], [41, 2], [42, 3]]);
    }

    #[test]
    fn a_primary_metric_that_there_is_not_is_told_with_those_that_there_are() {
        let mut study = crate::tests::data().study;
        assert!(asked_in_vain(&study).is_empty());
        study.compare.primary = Primary::One("softness_n".parse().unwrap());
        let told = asked_in_vain(&study);
        assert_eq!(told.len(), 2, "{told:?}");
        assert!(told[0].contains("there is no metric 'softness_n'"), "{told:?}");
        assert!(told[1].contains("the metrics are ") && told[1].contains("wall_past_max_rad"));
    }

    #[test]
    fn a_metric_of_the_studys_own_is_asked_for_unless_its_name_is_taken() {
        let mut study = crate::tests::data().study;
        let own = |id: &str| OwnMetric {
            id: id.parse().unwrap(),
            of: "force_ex_n".to_owned(),
            statistic: Statistic::Max,
            over: TrialPart::Movement,
            label: "largest push".to_owned(),
            unit: "N".to_owned(),
            better: Better::Lower,
        };
        study.metrics = vec![own("push_n"), own("wall_dwell_s"), own("participant")];
        assert_eq!(requested_metrics(&study).last().unwrap(), "push_n");
        assert_eq!(zwidth_metrics::better(&study, "push_n"), Better::Lower);
        assert_eq!(zwidth_metrics::better(&study, "wall_dwell_s"), Better::Neither);
        let told = asked_in_vain(&study);
        let taken = |id| format!("'{id}' is a column of the tables already");
        assert_eq!(told.len(), 2, "{told:?}");
        assert!(
            told[0].contains(&taken("wall_dwell_s")) && told[1].contains(&taken("participant"))
        );
    }

    #[test]
    fn a_claim_shares_alpha_with_every_other_of_its_family() {
        let mut study = crate::tests::data().study;
        let (environments, contrasts) = (study.environments.len(), study.compare.contrasts.len());
        assert!(environments > 1 && contrasts > 1);
        assert_eq!(claims(&study, "duration_s"), environments * contrasts);
        let walls = study.environments.iter().filter(|e| e.scene.wall_rad().is_some()).count();
        assert_eq!(claims(&study, "wall_past_max_rad"), walls * contrasts);
        let both = ["duration_s", "wall_past_max_rad"].map(|metric| metric.parse().unwrap());
        study.compare.primary = Primary::Several(both.to_vec());
        study.compare.families = Families::Study;
        assert_eq!(claims(&study, "duration_s"), (environments + walls) * contrasts);
        assert_eq!(claims(&study, "loop_area_j"), environments * contrasts);
        study.compare.families = Families::Environment;
        assert_eq!(claims(&study, "duration_s"), contrasts);
    }

    #[test]
    fn effects_are_claims_of_their_environment_and_a_weighted_contrast_of_its_own() {
        let mut study = crate::tests::data().study;
        let levels = ["low", "mid", "high"].map(|level| level.parse::<LevelId>().unwrap());
        let id: FactorId = "force".parse().unwrap();
        for (mode, level) in study.modes.iter_mut().zip(&levels) {
            mode.factors.insert(id.clone(), level.clone());
        }
        let of = FactorOf::Modes;
        study.factors = vec![Factor { id: id.clone(), levels: levels.to_vec(), unit: None, of }];
        study.compare.effects = vec![Term(vec![id])];
        study.compare.contrasts = Vec::new();
        assert_eq!((study.environments.len(), study.modes.len()), (2, 3));
        assert_eq!(claims(&study, "duration_s"), 2 * 2);
        // Of the wall alone.
        assert_eq!(claims(&study, "wall_dwell_s"), 2);
        let weight = |environment: usize, mode: usize, weight: f64| Weight {
            session: None,
            environment: study.environments[environment].id.clone(),
            mode: study.modes[mode].id.clone(),
            weight,
        };
        let within = vec![weight(0, 0, 1.0), weight(0, 1, -1.0)];
        let across = vec![weight(0, 0, 1.0), weight(1, 0, -1.0)];
        study.compare.weighted = [("within", within), ("across", across)]
            .map(|(id, weights)| Weighted { id: id.parse().unwrap(), weights })
            .to_vec();
        assert_eq!(claims(&study, "duration_s"), 2 * 2 + 1 + 1);
        // A metric of one environment has no contrast across both.
        assert_eq!(claims(&study, "wall_dwell_s"), 2);
        study.compare.families = Families::Environment;
        assert_eq!(claims(&study, "duration_s"), 3);
    }
}
