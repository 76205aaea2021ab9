//! What the page's script knows of a study before it loads any sample: its conditions, its metrics
//! and each trial's row.

use super::TURNED;
use super::estimates::{ClaimOf, DifferenceOf, MeanOf};
use crate::Summary;
use crate::compared::ComparedMetric;
use serde::Serialize;
use std::collections::BTreeMap;
use zwidth_results::{Compared, GivenAnswer, Role, Size, TrialKey, Verdict};
use zwidth_study::{
    AnswerValue, Coordinate, Effect, EnvironmentId, Families, ModeId, ParticipantId, Perception,
    Question, QuestionId, SessionId, Setup, in_a_sentence,
};
use zwidth_tables::{Column, Measured, Values, shown_unit};

/// What the page shows.
#[derive(Debug, Clone, Copy)]
pub struct Page<'a> {
    /// The summary.
    pub summary: &'a Summary,
    /// What was planned.
    pub planned: &'a Setup,
    /// The study's id.
    pub study: &'a str,
    /// The trials, where there are any.
    pub contents: Option<&'a Contents>,
    /// The page's origin, if it is given.
    pub origin: Option<&'a str>,
    /// The version of the program.
    pub version: &'a str,
}

/// A study, as the page's script knows it.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Contents {
    study: String,
    title: String,
    simulated: bool,
    angle_unit: String,
    /// What an angle in rad is multiplied by to be in its unit for people.
    angle_scale: f64,
    force_unit: &'static str,
    environments: Vec<EnvironmentOf>,
    modes: Vec<Labelled>,
    metrics: Vec<MetricOf>,
    questions: Vec<QuestionOf>,
    pub(super) trials: Vec<TrialOf>,
    /// The trials whose model can be turned.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(super) turned: Option<TurnedOf>,
    /// How the differences were estimated.
    level: f64,
    alpha: f64,
    families: Families,
    curve_claims: usize,
    /// Whether groups of people are compared: no code stands with a group on the page.
    #[serde(skip_serializing_if = "std::ops::Not::not")]
    has_groups: bool,
    single_file: bool,
}

/// Where the runs of the model over its parameters lie, and whose trials they are of.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub(super) struct TurnedOf {
    data: &'static str,
    participant: String,
    session: String,
    damping_unit: String,
    /// What a damping in N·s/rad is multiplied by to be in its unit for people.
    damping_scale: f64,
}

#[derive(Debug, Clone, PartialEq, Serialize)]
struct EnvironmentOf {
    id: String,
    label: String,
    wall_rad: Option<f64>,
}

#[derive(Debug, Clone, PartialEq, Serialize)]
struct Labelled {
    id: String,
    label: String,
}

/// A metric. Its values are in SI; `scale` makes them what people read, of logarithms their powers of e.
#[derive(Debug, Clone, PartialEq, Serialize)]
struct MetricOf {
    name: String,
    label: String,
    unit: String,
    scale: f64,
    /// Whether its values are natural logarithms of what has the unit, so that differences are read as ratios.
    #[serde(skip_serializing_if = "std::ops::Not::not")]
    is_logarithm: bool,
    is_primary: bool,
    /// Whether it rests on the plant that all trials together identify.
    is_of_plant: bool,
    /// Which values are better: `lower`, `higher`, `neither`.
    better: &'static str,
    /// The share of a value that is just noticed, and the least difference that is, in SI.
    noticed: Option<[f64; 2]>,
    means: Vec<MeanOf>,
    differences: Vec<DifferenceOf>,
    /// Effects of factors, then differences between groups.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    claims: Vec<ClaimOf>,
    /// Of a score: the places of the questions whose answers it is made of.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    items: Vec<usize>,
}

/// How the differences of the study were estimated, to do it again.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Estimating {
    /// Level of every interval, as a fraction.
    pub level: f64,
    /// A claim needs an adjusted p value below this.
    pub alpha: f64,
    /// Which contrasts are adjusted together.
    pub families: Families,
    /// How many claims on primary curves share alpha with those on primary metrics (Bonferroni).
    pub curve_claims: usize,
    /// Whether groups of people are compared.
    pub has_groups: bool,
    /// What is just noticed.
    pub perception: Perception,
    /// The metrics that rest on the plant, which all trials together identify.
    pub of_plant: Vec<String>,
    /// The effects of factors with their weights.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub effects: Vec<Effect>,
    /// The questions of each score, by the metric as which it is compared.
    #[serde(skip_serializing_if = "BTreeMap::is_empty")]
    pub items: BTreeMap<String, Vec<QuestionId>>,
}

/// The values of trials.
#[derive(Debug, Clone, Copy)]
pub struct TrialValues<'a> {
    /// Metrics of what was recorded, where anything was.
    pub recorded: Option<&'a Measured>,
    /// Scores of answers, a table each.
    pub scores: &'a [Measured],
}

impl<'a> TrialValues<'a> {
    fn tables(self) -> impl Iterator<Item = &'a Measured> {
        self.recorded.into_iter().chain(self.scores)
    }
}

#[derive(Debug, Clone, PartialEq, Serialize)]
struct QuestionOf {
    id: String,
    label: String,
    lowest: i16,
    highest: i16,
    /// From an answer to the next one, where that is not 1.
    #[serde(skip_serializing_if = "Option::is_none")]
    step: Option<i16>,
    reversed: bool,
    /// The word of each answer, empty where it has none; empty for a scale of many points.
    labels: Vec<String>,
}

#[derive(Debug, Clone, PartialEq, Serialize)]
pub(super) struct TrialOf {
    pub(super) participant: ParticipantId,
    pub(super) session: SessionId,
    pub(super) environment: EnvironmentId,
    pub(super) mode: ModeId,
    pub(super) repeat: u32,
    pub(super) trial: u32,
    /// The script that holds its samples; none of one that was not recorded.
    data: Option<String>,
    metrics: Vec<Option<f64>>,
    answers: Vec<Option<AnswerValue>>,
}

impl Contents {
    /// The same with sliders for the model of this session's typical trials.
    #[must_use]
    pub fn with_turned(self, session: Option<[String; 2]>, coordinate: Coordinate) -> Self {
        let of = |[participant, session]: [String; 2]| {
            let (damping_unit, damping_scale) = shown_unit("N·s/rad", coordinate);
            TurnedOf { data: TURNED, participant, session, damping_unit, damping_scale }
        };
        Self { turned: session.map(of), ..self }
    }

    /// The same for a study in which the user's torque was recorded, and no force.
    #[must_use]
    pub fn with_torque(self) -> Self {
        Self { force_unit: "N·m", ..self }
    }

    /// Whether any trial was recorded.
    pub(super) fn has_recordings(&self) -> bool {
        self.trials.iter().any(|trial| trial.data.is_some())
    }

    /// Whether effects of factors or differences between groups are claimed.
    pub(super) fn has_claims(&self) -> bool {
        self.metrics.iter().any(|metric| !metric.claims.is_empty())
    }

    /// Of how many differences, effects and differences between groups it was shown that there is one, and how many of
    /// them are felt.
    pub(super) fn verdicts_in_words(&self) -> Option<String> {
        let claims = || self.metrics.iter().flat_map(|metric| &metric.claims);
        let effects = claims().filter(|claim| !claim.is_of_groups).collect::<Vec<_>>();
        let groups = claims().filter(|claim| claim.is_of_groups).collect::<Vec<_>>();
        let of_claims = |claims: &[&ClaimOf], what: &str, differ: &str| {
            let n = claims.len();
            let shown: Vec<_> = claims.iter().filter(|own| own.verdict.is_different()).collect();
            let is_tested = claims.iter().any(|own| own.verdict != Verdict::NotTested);
            let sizes = sizes(
                shown.iter().map(|own| (own.size, own.jnd)),
                "of which it is not known what is felt",
            );
            (n > 0).then(|| match is_tested {
                false => format!("None of {n} comparisons of {what} has a test."),
                true => {
                    format!("{differ} in {} of {n} comparisons in all metrics{sizes}.", shown.len())
                }
            })
        };
        let sentences = [
            self.differences_in_words(),
            of_claims(&effects, "factors", "Effects of factors are shown"),
            of_claims(&groups, "groups", "Groups differ"),
        ];
        let sentences: Vec<String> = sentences.into_iter().flatten().collect();
        (!sentences.is_empty()).then(|| sentences.join(" "))
    }

    fn differences_in_words(&self) -> Option<String> {
        let all = || self.metrics.iter().flat_map(|metric| &metric.differences);
        let shown = || all().filter(|difference| difference.verdict.is_different());
        let sizes = sizes(
            shown().map(|difference| (difference.size, difference.jnd)),
            "of metrics of which it is not known what is felt",
        );
        let mut better = Vec::new();
        for mode in &self.modes {
            let is_best = |difference: &DifferenceOf| {
                let best = difference.best.as_ref().is_some_and(|best| best.as_str() == mode.id);
                best && difference.size == Some(Size::Felt)
            };
            let best = self.metrics.iter().filter(|metric| metric.differences.iter().any(is_best));
            let metrics: Vec<&str> = best.map(|metric| metric.label.as_str()).collect();
            if !metrics.is_empty() {
                better.push(format!("{} in {}", in_a_sentence(&mode.label), metrics.join(", ")));
            }
        }
        let better = match better.is_empty() {
            true => String::new(),
            false => format!(" Better, and felt: {}.", better.join("; ")),
        };
        let n = all().count();
        let differing = shown().count();
        let is_tested = all().any(|difference| difference.verdict != Verdict::NotTested);
        (n > 0).then(|| match is_tested {
            false => format!("None of {n} comparisons of modes has a test."),
            true => format!(
                "Modes differ in {differing} of {n} comparisons in all metrics{sizes}.{better}"
            ),
        })
    }

    /// The facts about a study. `compared` names the metrics to show; `answers` are all of its
    /// answers.
    pub fn of(
        study: &str,
        title: &str,
        planned: &Setup,
        estimating: &Estimating,
        values: TrialValues,
        compared: &[ComparedMetric],
        answers: &[GivenAnswer],
    ) -> Self {
        let environment = |environment: &zwidth_study::Environment| EnvironmentOf {
            id: environment.id.to_string(),
            label: environment.label.clone(),
            wall_rad: environment.scene.wall_rad(),
        };
        let mode = |mode: &zwidth_study::Mode| Labelled {
            id: mode.id.to_string(),
            label: mode.label.clone(),
        };
        let coordinate = planned.coordinate;
        let (angle_unit, angle_scale) = shown_unit("rad", coordinate);
        let columns: Vec<ColumnOf> = compared
            .iter()
            .filter_map(|metric| {
                let mut tables = values.tables().enumerate();
                tables.find_map(|(table, values)| {
                    let column = values.metric(metric.metric.metric.as_str())?;
                    Some(ColumnOf { metric, table, column })
                })
            })
            .collect();
        Self {
            study: study.to_owned(),
            title: title.to_owned(),
            simulated: values.tables().any(crate::people::simulated),
            angle_unit,
            angle_scale,
            force_unit: "N",
            environments: planned.environments.iter().map(environment).collect(),
            modes: planned.modes.iter().map(mode).collect(),
            metrics: columns
                .iter()
                .map(|column| MetricOf::of(column.metric, planned, estimating))
                .collect(),
            questions: ratings(planned).map(QuestionOf::of).collect(),
            trials: trials(values, &columns, &answered(planned, answers)),
            turned: None,
            level: estimating.level,
            alpha: estimating.alpha,
            families: estimating.families,
            curve_claims: estimating.curve_claims,
            has_groups: estimating.has_groups,
            single_file: false,
        }
    }
}

/// How many of the differences that were shown are felt: `: 3 felt, 1 may be felt`; empty of none. `unknown` names those
/// without a just noticeable difference.
fn sizes(
    shown: impl Iterator<Item = (Option<Size>, Option<f64>)> + Clone,
    unknown: &str,
) -> String {
    let sized = |size| shown.clone().filter(|(own, _)| *own == Some(size)).count();
    let parts = [
        (sized(Size::Felt), "felt"),
        (sized(Size::MayBeFelt), "may be felt"),
        (sized(Size::BelowWhatIsFelt), "below what is felt"),
        (shown.clone().filter(|(_, jnd)| jnd.is_none()).count(), unknown),
    ];
    let parts = parts.iter().filter(|(count, _)| *count > 0);
    let parts: Vec<String> = parts.map(|(count, words)| format!("{count} {words}")).collect();
    if parts.is_empty() { String::new() } else { format!(": {}", parts.join(", ")) }
}

impl MetricOf {
    fn of(metric: &ComparedMetric, planned: &Setup, estimating: &Estimating) -> Self {
        let Compared { metric: id, unit: si, role, better, .. } = metric.metric;
        let amounts = metric.amounts(planned);
        let lever_m = planned.device.lever_m.unwrap_or(0.0);
        Self {
            name: id.to_string(),
            label: metric.words(planned.coordinate),
            unit: match amounts.unit() {
                "1" => String::new(),
                unit => unit.to_owned(),
            },
            scale: amounts.factor(),
            is_logarithm: amounts.are_logarithms(),
            is_primary: *role == Role::Primary,
            is_of_plant: estimating.of_plant.iter().any(|of_plant| of_plant == id.as_str()),
            better: better.as_str(),
            noticed: estimating.perception.share_and_floor(si, lever_m),
            means: metric.means.iter().map(MeanOf::new).collect(),
            differences: metric
                .contrasts
                .iter()
                .map(|row| DifferenceOf::new(row, *better, metric.redrawn))
                .collect(),
            claims: metric
                .effects
                .iter()
                .map(|row| ClaimOf::of_effect(row, metric, &estimating.effects, planned))
                .chain(
                    metric.groups.iter().filter_map(|row| ClaimOf::of_groups(row, metric, planned)),
                )
                .collect(),
            items: {
                let items = estimating.items.get(id.as_str()).into_iter().flatten();
                items.filter_map(|id| ratings(planned).position(|own| own.id == *id)).collect()
            },
        }
    }
}

impl QuestionOf {
    fn of(question: &Question) -> Self {
        let scale = &question.scale;
        let answers = if scale.is_ordinal() { scale.answers() } else { Vec::new() };
        let word = |answer| scale.word(answer).unwrap_or_default().to_owned();
        Self {
            id: question.id.to_string(),
            label: question.text.clone(),
            lowest: scale.lowest(),
            highest: scale.highest(),
            step: Some(scale.step()).filter(|step| *step != 1),
            reversed: question.reversed,
            labels: answers.into_iter().map(word).collect(),
        }
    }
}

/// The questions that are shown beside a metric: answers to the others have no order.
fn ratings(planned: &Setup) -> impl Iterator<Item = &Question> {
    planned.questions.iter().filter(|question| question.is_rating())
}

/// Participant, session, trial.
type Key = (ParticipantId, SessionId, u32);

/// Each trial's answers, in the order of the questions.
fn answered(planned: &Setup, answers: &[GivenAnswer]) -> BTreeMap<Key, Vec<Option<AnswerValue>>> {
    let mut found: BTreeMap<Key, Vec<Option<AnswerValue>>> = BTreeMap::new();
    for row in answers {
        let key = (row.participant.clone(), row.session.clone(), row.trial);
        let answers = found.entry(key).or_insert_with(|| vec![None; ratings(planned).count()]);
        if let Some(place) = ratings(planned).position(|question| question.id == row.question) {
            answers[place] = Some(row.answer);
        }
    }
    found
}

/// A metric, and where its values are: which of the tables, and its column there.
struct ColumnOf<'a> {
    metric: &'a ComparedMetric<'a>,
    table: usize,
    column: &'a Column,
}

/// Every trial that was recorded, then every other that has a score.
fn trials(
    values: TrialValues,
    columns: &[ColumnOf],
    answers: &BTreeMap<Key, Vec<Option<AnswerValue>>>,
) -> Vec<TrialOf> {
    let key = |of: &TrialKey| (of.participant.clone(), of.session.clone(), of.trial);
    let mut trials: Vec<TrialOf> = Vec::new();
    let mut places: BTreeMap<Key, usize> = BTreeMap::new();
    for (table, own) in values.tables().enumerate() {
        let is_recorded = table == 0 && values.recorded.is_some();
        for (row, of) in own.trials().iter().enumerate() {
            let place = *places.entry(key(of)).or_insert(trials.len());
            if place == trials.len() {
                let TrialKey { participant, session, trial, repeat, environment, mode, .. } =
                    of.clone();
                let data =
                    [participant.as_str(), session.as_str(), environment.as_str(), mode.as_str()];
                trials.push(TrialOf {
                    data: is_recorded.then(|| data.join(".")),
                    metrics: vec![None; columns.len()],
                    answers: answers.get(&key(of)).cloned().unwrap_or_default(),
                    participant,
                    session,
                    environment,
                    mode,
                    repeat,
                    trial,
                });
            }
            for (column, value) in columns.iter().zip(&mut trials[place].metrics) {
                if column.table == table {
                    *value = number(column.column, row);
                }
            }
        }
    }
    trials
}

fn number(column: &Column, row: usize) -> Option<f64> {
    match &column.values {
        Values::Float(values) => values[row],
        Values::Integer(values) => values[row].map(|n| n as f64),
        Values::Text(_) | Values::Flag(_) => None,
    }
}
