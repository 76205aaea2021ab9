//! Stage `compare`, of answers with metrics: how what people said goes together with what was measured.

use crate::compare::{STAGE, compared};
use crate::shared::handle::{Derived, write_named};
use crate::shared::making::derived;
use crate::tables::printed::Printed;
use crate::{likert, metrics};
use serde::Serialize;
use std::collections::BTreeSet;
use std::path::PathBuf;
use zwidth_compare::{Said, relations};
use zwidth_results::{GivenAnswer, Relation, TrialScore};
use zwidth_runner::{Inputs as _, Job, JobError, Made, Making};
use zwidth_store::StudyData;
use zwidth_study::{EnvironmentId, MetricId, Question};
use zwidth_tables::{Measured, Table};

/// What the job depends on besides tables.
#[derive(Serialize)]
struct Relating {
    /// The metrics of trials.
    metrics: Vec<MetricId>,
    /// Of scores these, by their metrics; without one every question that is a rating.
    scores: Vec<(MetricId, MetricId)>,
    questions: Vec<Question>,
    environments: Vec<EnvironmentId>,
    level: f64,
    simulated: bool,
}

/// The table, if several people have trials with metrics, and answered something after them.
pub(crate) fn of_study(data: &StudyData) -> Option<Derived<Relation>> {
    let people: BTreeSet<_> = data.counting().map(|trial| &trial.meta.participant).collect();
    let is_any = likert::ratings(data).any(|answer| people.contains(&answer.participant));
    let is_related = people.len() > 1 && is_any && !of_trials(data).is_empty();
    is_related.then(|| Derived::within(&derived(&data.layout, "compare")))
}

/// The metrics of trials that are compared.
fn of_trials(data: &StudyData) -> Vec<MetricId> {
    let of_answers = |metric: &String| zwidth_metrics::is_of_answers(&data.study, metric);
    let own = compared(data).into_iter().filter(|metric| !of_answers(metric));
    own.filter_map(|metric| metric.parse().ok()).collect()
}

/// The table as people read it.
pub(crate) fn tables(data: &StudyData) -> Vec<Printed> {
    let table = of_study(data).into_iter();
    table.map(|table| Printed::without_empty_columns(table.path())).collect()
}

/// The metrics, the answers and the scores.
type Relates = (PathBuf, Derived<GivenAnswer>, Option<Derived<TrialScore>>);

pub(crate) fn jobs(data: &StudyData) -> Vec<Job> {
    let (Some(result), Some(metrics), Some(answers)) =
        (of_study(data), metrics::of_study(data), likert::answers(data))
    else {
        return Vec::new();
    };
    let study = &data.study;
    let scores = zwidth_metrics::scores(study).map(|(metric, score)| (score.id.clone(), metric));
    let trials = data.counting().any(|trial| trial.meta.source.is_simulated());
    let parameters = Relating {
        metrics: of_trials(data),
        scores: scores.collect(),
        questions: study
            .questions
            .iter()
            .filter(|question| question.is_rating())
            .cloned()
            .collect(),
        environments: study.environments.iter().map(|e| e.id.clone()).collect(),
        level: study.compare.level,
        simulated: trials || data.sessions.iter().any(|log| log.record.source.is_simulated()),
    };
    let inputs = (metrics, answers, likert::scores(data).map(|(scores, _)| scores));
    vec![Job::new(STAGE, "compare relations", parameters, inputs, result.files(), make)]
}

fn make(
    parameters: &Relating,
    (metrics, answers, scores): &Relates,
    making: &Making,
) -> Result<Made, JobError> {
    let mut said: Vec<(String, Vec<Said>)> = Vec::new();
    if let Some(scores) = scores {
        let rows = scores.read()?;
        for (score, metric) in &parameters.scores {
            let own = rows.iter().filter(|row| row.score == *score);
            let own = own.filter_map(|row| {
                Some(Said {
                    participant: row.participant.clone(),
                    session: row.session.clone(),
                    environment: row.environment.clone(),
                    mode: row.mode.clone(),
                    value: row.value?,
                })
            });
            said.push((metric.to_string(), own.collect()));
        }
    } else {
        let rows = likert::read_counting(answers)?;
        for question in &parameters.questions {
            let own = rows.iter().filter(|row| row.question == question.id);
            let own = own.map(|row| Said {
                participant: row.participant.clone(),
                session: row.session.clone(),
                environment: row.environment.clone(),
                mode: row.mode.clone(),
                value: question.scale.score(row.answer, question.reversed).get(),
            });
            said.push((question.id.to_string(), own.collect()));
        }
    }
    let names: Vec<&str> = parameters.metrics.iter().map(MetricId::as_str).collect();
    let measured = Measured::read(metrics, &names)?;
    let Relating { environments, level, .. } = parameters;
    let rows = relations(&measured, &parameters.metrics, &said, environments, *level)?;
    let table = Table::of_rows(&rows)?.with_note(
        "Repeated-measures correlation (Bakdash & Marusich 2017) of everybody's means by session and mode: people differ in both by a \
         level of their own. Exploratory: p is not adjusted, no claim is made, and what goes together need not be cause \
         and effect.",
    );
    write_named(vec![table], making, parameters.simulated)
}
