//! What a comparison depends on besides tables.

use super::asked::{claims_of_both, compared, compares_curves, took_part};
use super::chosen::chosen_after;
use crate::page::preregistered::preregistered;
use crate::thresholds::{self, ThresholdColumn};
use serde::Serialize;
use std::collections::{BTreeMap, BTreeSet};
use zwidth_compare::{
    Covariate, DrawnOrder, Groups, MetricParameters, Noticed, Parameters, SessionOrder,
};
use zwidth_results::{Column, Row as _, TrialKey, TrialScore};
use zwidth_store::{SessionLog, StudyData};
use zwidth_study::order::Rules;
use zwidth_study::{
    Bound, Coordinate, Event, GroupsCompared, IdError, Known, MetricId, ParticipantId,
    PersonColumnId, PersonValue, Score, SessionRecord, Study,
};
use zwidth_tables::{Measured, Table, TableError};

/// What a comparison depends on.
#[derive(Serialize)]
pub(crate) struct Comparing<P> {
    pub(crate) stage: P,
    /// Whether any of the data are simulated.
    pub(crate) simulated: bool,
}

/// What a comparison of metrics depends on.
#[derive(Serialize)]
pub(crate) struct OfMetrics {
    #[serde(flatten)]
    pub(crate) parameters: Parameters,
    /// The scores among the metrics.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub(crate) scores: Vec<ScoreColumn>,
    /// What tasks tell, among the metrics.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub(crate) thresholds: Vec<ThresholdColumn>,
}

impl OfMetrics {
    /// Whether a metric is made of answers.
    pub(crate) fn is_of_answers(&self, metric: &str) -> bool {
        let of_scores = self.scores.iter().map(|score| &score.metric);
        let mut all = of_scores.chain(self.thresholds.iter().map(|own| &own.metric));
        all.any(|own| own.as_str() == metric)
    }
}

/// A score as a metric.
#[derive(Serialize)]
pub(crate) struct ScoreColumn {
    score: MetricId,
    pub(crate) metric: MetricId,
    words: String,
}

impl ScoreColumn {
    /// The scores of a study that are among the metrics compared.
    pub(crate) fn compared(study: &Study, compared: &[String]) -> Vec<Self> {
        let scores = zwidth_metrics::scores(study).map(|(metric, score)| Self {
            score: score.id.clone(),
            metric,
            words: score.in_words(),
        });
        scores.filter(|score| compared.iter().any(|own| own == score.metric.as_str())).collect()
    }

    /// The scores of trials, as a table of metrics has them.
    pub(crate) fn measured(&self, rows: &[TrialScore]) -> Result<Measured, TableError> {
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

impl Comparing<OfMetrics> {
    pub(crate) fn of(data: &StudyData) -> Result<Self, IdError> {
        let (study, compare) = (&data.study, &data.study.compare);
        let compared = compared(data);
        let curves = compares_curves(data).then_some(&compare.curves).into_iter().flatten();
        let measured: Vec<String> =
            compared.iter().cloned().chain(curves.map(|curve| curve.as_str().to_owned())).collect();
        let perception = thresholds::perception(data);
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
            let chosen_after = chosen_after(data, metric);
            let primary = compare.primary.has(metric) && chosen_after.is_none();
            metrics.push(MetricParameters {
                metric: metric.parse()?,
                primary,
                chosen_after,
                better: chosen.map_or_else(|| zwidth_metrics::better(study, metric), |(_, b)| *b),
                // A plan is a promise on primary metrics alone.
                preregistered: if primary { preregistered(data, &measured) } else { None },
                bounds: bounds.collect(),
                // What cannot be felt is not noticed from any difference on.
                noticed: is_felt(study, metric).then(|| Noticed {
                    perception: perception.clone(),
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
        let scores = ScoreColumn::compared(study, &compared);
        let of_tasks = ThresholdColumn::compared(study, &compared);
        let parameters = Parameters {
            metrics,
            environments: study.environments.iter().map(|e| e.id.clone()).collect(),
            modes: study.modes.iter().map(|m| m.id.clone()).collect(),
            contrasts: compare.contrasts.clone(),
            families: compare.families,
            curve_claims: claims_of_both(study)[0],
            alpha: compare.alpha,
            level: compare.level,
            effect_sizes: compare.effect_sizes.clone(),
            groups: compare.groups.as_ref().map(|compared| groups(data, compared)),
            covariates: compare.covariates.iter().map(|column| covariate(data, column)).collect(),
            over: compare.over,
            effects: study.effects(),
            dose_curves: study.dose_curves(),
            orders: data.sessions.iter().map(|log| order(log, study)).collect(),
        };
        let trials = data.counting().any(|trial| trial.meta.source.is_simulated());
        let sessions = data.sessions.iter().any(|log| log.record.source.is_simulated());
        Ok(Self {
            stage: OfMetrics { parameters, scores, thresholds: of_tasks },
            simulated: trials || sessions,
        })
    }
}

/// Whether a metric describes something that a person could feel.
fn is_felt(study: &Study, metric: &str) -> bool {
    !zwidth_metrics::is_of_answers(study, metric) && zwidth_metrics::is_felt(&study.metrics, metric)
}

/// The groups of those who took part.
pub(crate) fn groups(data: &StudyData, compared: &GroupsCompared) -> Groups {
    let levels_of = took_part(data).into_iter().filter_map(|who| {
        let own = data.people.level(who, &compared.column)?;
        Some((who.clone(), compared.levels.iter().position(|level| level == own)?))
    });
    let levels_of: BTreeMap<ParticipantId, usize> = levels_of.collect();
    // By the session in which it was drawn, or that knew it.
    let mut numbers = BTreeSet::new();
    let drawn = |who: &ParticipantId| {
        let own = data.sessions.iter().map(|log| &log.record).filter(|own| own.participant == *who);
        let mut given = own.filter(|record| record.drawn.contains_key(&compared.column));
        let is_that_level = |record: &&SessionRecord| {
            let level = data.people.level(who, &compared.column).cloned().map(PersonValue::Level);
            record.person.get(&compared.column) == level.as_ref()
        };
        let record = given.find(is_that_level)?;
        numbers.insert(record.order?.participant_number);
        Some((who.clone(), *record.drawn.get(&compared.column)?))
    };
    let blocks: Option<BTreeMap<ParticipantId, u32>> = levels_of.keys().map(drawn).collect();
    // Two people of one number have one level, so that chance could not have made every arrangement.
    let apart = numbers.len() == levels_of.len();
    let blocks = blocks.filter(|_| compared.assigned && apart).unwrap_or_default();
    Groups { levels_of, compared: compared.clone(), blocks }
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
pub(crate) fn order(log: &SessionLog, study: &Study) -> SessionOrder {
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_trial_that_was_done_again_twice_has_the_place_of_the_first() {
        let again = |trial, by| Event::Superseded { trial, by };
        let note = Event::Note { trial: Some(40), text: "slipped".to_owned() };
        let events = [again(2, 40), note, again(40, 41), again(3, 42)];
        assert_eq!(repeated(&events), [[40, 2], [41, 2], [42, 3]]);
    }
}
