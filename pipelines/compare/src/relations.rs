//! How what people said goes together with what was measured, within people.

use crate::CompareError;
use std::collections::BTreeMap;
use zwidth_results::Relation;
use zwidth_stats::repeated_correlation::within_people;
use zwidth_study::{EnvironmentId, MetricId, ModeId, ParticipantId, SessionId};
use zwidth_tables::Measured;

/// One answer or score after a trial.
#[derive(Debug, Clone, PartialEq)]
pub struct Said {
    /// Who.
    pub participant: ParticipantId,
    /// In which session.
    pub session: SessionId,
    /// What was rendered.
    pub environment: EnvironmentId,
    /// How.
    pub mode: ModeId,
    /// The number.
    pub value: f64,
}

/// A person in an environment, and their means by session and mode.
type Means<'a> =
    BTreeMap<(&'a EnvironmentId, &'a ParticipantId), BTreeMap<(&'a SessionId, &'a ModeId), f64>>;

/// What one value is of: environment, participant, session, mode.
type Key<'a> = (&'a EnvironmentId, &'a ParticipantId, &'a SessionId, &'a ModeId);

fn means<'a>(values: impl Iterator<Item = (Key<'a>, f64)>) -> Means<'a> {
    let mut sums: BTreeMap<Key, [f64; 2]> = BTreeMap::new();
    for (key, value) in values {
        let [sum, n] = sums.entry(key).or_default();
        *sum += value;
        *n += 1.0;
    }
    let mut means = Means::new();
    for ((environment, who, session, mode), [sum, n]) in sums {
        means.entry((environment, who)).or_default().insert((session, mode), sum / n);
    }
    means
}

/// The correlation of each metric with what was said, by its name, in each environment: of everybody's means by
/// session and mode, which repeats of one mode cannot make many of.
///
/// # Errors
/// A table that lacks a metric; a level outside (0, 1).
pub fn relations(
    metrics: &Measured,
    names: &[MetricId],
    said: &[(String, Vec<Said>)],
    environments: &[EnvironmentId],
    level: f64,
) -> Result<Vec<Relation>, CompareError> {
    let told: Vec<(&String, Means)> = said
        .iter()
        .map(|(name, values)| {
            let keyed = values.iter().map(|one| {
                ((&one.environment, &one.participant, &one.session, &one.mode), one.value)
            });
            (name, means(keyed))
        })
        .collect();
    let mut rows = Vec::new();
    for metric in names {
        let values = metrics.numbers(metric.as_str())?;
        let field = &metrics.table().column(metric.as_str())?.field;
        let measured = means(metrics.trials().iter().zip(values).filter_map(|(trial, value)| {
            let key = (&trial.environment, &trial.participant, &trial.session, &trial.mode);
            Some((key, value?))
        }));
        for environment in environments {
            for (name, told) in &told {
                let here = measured.iter().filter(|((place, _), _)| *place == environment);
                let people = here.filter_map(|(who, own)| {
                    let told = told.get(who)?;
                    let pairs = own.iter().filter_map(|(at, x)| Some([*x, *told.get(at)?]));
                    Some(pairs.collect::<Vec<[f64; 2]>>())
                });
                let people: Vec<Vec<[f64; 2]>> = people.collect();
                let pairs: usize = people.iter().map(Vec::len).sum();
                if pairs == 0 {
                    continue;
                }
                let found = within_people(&people, level);
                let correlation = found.as_ref().ok();
                rows.push(Relation {
                    metric: metric.clone(),
                    unit: field.unit.as_ref().into(),
                    environment: environment.clone(),
                    said: (*name).clone(),
                    n: people.iter().filter(|own| own.len() > 1).count(),
                    pairs,
                    correlation: correlation.map(|found| found.r),
                    correlation_ci_low: correlation.map(|found| found.ends[0]),
                    correlation_ci_high: correlation.map(|found| found.ends[1]),
                    df: correlation.map(|found| found.df),
                    p_value: correlation.map(|found| found.p_value),
                    remark: found.err().map(|why| why.to_string().into()),
                });
            }
        }
    }
    Ok(rows)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::tests::{Trial, metrics};

    #[test]
    fn what_was_said_goes_with_what_was_measured_within_people() {
        let modes = ["active", "passive", "hybrid"];
        let codes = ["P01", "P02", "P03", "P04"];
        let mut trials: Vec<Trial> = Vec::new();
        let mut said = Vec::new();
        for (person, who) in codes.into_iter().enumerate() {
            for (place, mode) in modes.into_iter().enumerate() {
                let (person, place) = (person as f64, place as f64);
                // Two repeats about the mean: one pair for each mode.
                let value = 10.0 * person + place;
                trials.push((who, "S01", mode, 1, Some(value - 0.5)));
                trials.push((who, "S01", mode, 2, Some(value + 0.5)));
                said.push(Said {
                    participant: who.parse().unwrap(),
                    session: "S01".parse().unwrap(),
                    environment: "spring".parse().unwrap(),
                    mode: mode.parse().unwrap(),
                    value: -4.0 * person + if place > 1.0 { 0.5 } else { place },
                });
            }
        }
        let names = ["step_n".parse().unwrap()];
        let environments = ["spring".parse().unwrap(), "wall".parse().unwrap()];
        let said = [("easy".to_owned(), said), ("hard".to_owned(), Vec::new())];
        let found = relations(&metrics(&trials), &names, &said, &environments, 0.95).unwrap();
        let [row] = &found[..] else { panic!("{found:?}") };
        assert_eq!((row.n, row.pairs, row.said.as_str()), (4, 12, "easy"));
        // Of (−1, 0, 1) and (−½, ½, 0): ½ / √(2 · ½).
        assert!((row.correlation.unwrap() - 0.5).abs() < 1e-12 && row.df == Some(7.0));
    }
}
