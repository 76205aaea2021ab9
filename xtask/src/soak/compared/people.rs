//! The people that studies are drawn from, and their truth.

use anyhow::{Context as _, bail, ensure};
use std::collections::{BTreeMap, BTreeSet};
use zwidth_results::{Row as _, TrialKey};
use zwidth_stats::lmm::trials::{Term, Trials, fit_trials};
use zwidth_stats::power::Plan;
use zwidth_study::Source;
use zwidth_tables::{Column, Measured, Table};

/// Repeats of a condition in a session: intervals rest on people, and more trials of each would
/// take more time and show no more.
pub(crate) const REPEATS: u32 = 2;
/// The primary metric (which the passive mode does not have), and two others that every condition
/// has.
pub(crate) const METRICS: [&str; 3] =
    ["discrepancy_user_mean_n", "stiffness_n_per_rad", "duration_s"];
/// Participants of a study.
pub(crate) const PARTICIPANTS: usize = 12;

/// The environments and the modes that are simulated.
pub(crate) const ENVIRONMENTS: [&str; 2] = ["spring", "spring_wall"];
pub(crate) const MODES: [&str; 4] = ["active", "passive", "hybrid", COPY];
/// The modes without the copy.
pub(crate) const THESIS: [&str; 3] = ["active", "passive", "hybrid"];
/// The copy of the last mode.
pub(crate) const COPY: &str = "copy";
/// The default contrasts, and the last mode with its copy.
pub(crate) const CONTRASTS: [[&str; 2]; 3] =
    [["hybrid", "active"], ["hybrid", "passive"], ["hybrid", COPY]];

/// One trial; environment and mode are indices.
#[derive(Debug, Clone)]
pub(crate) struct Trial {
    pub(crate) session: String,
    pub(crate) trial: u32,
    pub(crate) repeat: u32,
    pub(crate) environment: usize,
    pub(crate) mode: usize,
    /// One per metric.
    pub(crate) values: [Option<f64>; METRICS.len()],
}

/// What is compared: a metric in an environment, a mode with another.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) struct What {
    pub(crate) metric: usize,
    pub(crate) environment: usize,
    pub(crate) contrast: usize,
}

impl What {
    /// Every metric in every environment and contrast.
    fn all() -> impl Iterator<Item = What> {
        let of = |metric| (0..ENVIRONMENTS.len()).map(move |environment| (metric, environment));
        (0..METRICS.len()).flat_map(of).flat_map(|(metric, environment)| {
            (0..CONTRASTS.len()).map(move |contrast| What { metric, environment, contrast })
        })
    }

    /// Whether it is a mode and its copy.
    pub(crate) fn is_null(self) -> bool {
        CONTRASTS[self.contrast].contains(&COPY)
    }

    /// `discrepancy_user_mean_n, spring, hybrid − active`.
    pub(crate) fn words(self) -> String {
        let [mode, against] = CONTRASTS[self.contrast];
        format!("{}, {}, {mode} − {against}", METRICS[self.metric], ENVIRONMENTS[self.environment])
    }
}

/// The mean over people, and its standard error as a mean over all that could be simulated.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Truth {
    pub(crate) mean: f64,
    /// SD of the people's differences.
    pub(crate) sd: f64,
    pub(crate) std_error: f64,
}

/// Everybody's trials.
pub(crate) struct People {
    trials: Vec<Vec<Trial>>,
    /// How far each mode was from its copy, as simulated.
    pub(crate) copied: BTreeMap<What, Truth>,
}

impl People {
    /// Those of a table of metrics.
    pub(crate) fn of(metrics: &Measured) -> anyhow::Result<Self> {
        let mut values = Vec::new();
        for metric in METRICS {
            values.push(metrics.numbers(metric)?);
        }
        let place = |names: &[&str], name: &str| {
            names
                .iter()
                .position(|known| *known == name)
                .with_context(|| format!("what is {name}?"))
        };
        let mut people: BTreeMap<_, Vec<Trial>> = BTreeMap::new();
        for (row, key) in metrics.trials().iter().enumerate() {
            people.entry(key.participant.clone()).or_default().push(Trial {
                session: key.session.to_string(),
                trial: key.trial,
                repeat: key.repeat,
                environment: place(&ENVIRONMENTS, key.environment.as_str())?,
                mode: place(&MODES, key.mode.as_str())?,
                values: std::array::from_fn(|metric| values[metric][row]),
            });
        }
        ensure!(people.len() > PARTICIPANTS, "too few people to draw studies from");
        let trials = people.into_values().collect();
        Ok(Self { trials, copied: BTreeMap::new() }.with_exact_copies())
    }

    /// The same with every copy moved to its mode's mean: by chance the two differ over so many
    /// people, and then there would be something to find in the population.
    fn with_exact_copies(mut self) -> Self {
        for what in What::all().filter(|what| what.is_null()) {
            let Ok(truth) = self.truth(what, false) else { continue };
            self.copied.insert(what, truth);
            for trial in
                self.trials.iter_mut().flatten().filter(|trial| {
                    trial.environment == what.environment && MODES[trial.mode] == COPY
                })
            {
                let value = &mut trial.values[what.metric];
                *value = value.map(|value| value + truth.mean);
            }
        }
        self
    }

    pub(crate) fn len(&self) -> usize {
        self.trials.len()
    }

    /// The trials of the people with these places as a table of metrics; of the first session alone
    /// if `first` says so.
    pub(crate) fn table(&self, chosen: &[usize], first: bool) -> anyhow::Result<Measured> {
        let all = chosen.iter().enumerate().flat_map(|(number, person)| {
            self.trials[*person].iter().map(move |trial| (number, trial))
        });
        let sessions: BTreeSet<&String> =
            self.trials.iter().flatten().map(|trial| &trial.session).collect();
        let is_in = |session: &String| !first || sessions.first() == Some(&session);
        let rows: Vec<(usize, &Trial)> = all.filter(|(_, trial)| is_in(&trial.session)).collect();
        let mut keys = Vec::new();
        for (number, trial) in &rows {
            keys.push(TrialKey {
                participant: format!("P{:02}", number + 1).parse()?,
                session: trial.session.parse()?,
                trial: trial.trial,
                repeat: trial.repeat,
                environment: ENVIRONMENTS[trial.environment].parse()?,
                mode: MODES[trial.mode].parse()?,
                source: Source::Twin,
            });
        }
        let mut columns = TrialKey::columns(&keys);
        for (place, metric) in METRICS.into_iter().enumerate() {
            let values = rows.iter().map(|(_, trial)| trial.values[place]);
            columns.push(Column::float(metric, "1", "", values));
        }
        Ok(Measured::of(Table::new("metrics", "", columns)?)?)
    }

    /// Everything that is compared of which people have both modes.
    pub(crate) fn compared(&self) -> Vec<What> {
        What::all().filter(|what| self.truth(*what, true).is_ok()).collect()
    }

    /// The mean over all people of (mean in one mode − mean in the other), sessions with equal
    /// weight: written here once more, apart from the code that is tried.
    pub(crate) fn truth(&self, what: What, first: bool) -> anyhow::Result<Truth> {
        let differences: Vec<f64> =
            self.trials.iter().filter_map(|trials| difference(trials, what, first)).collect();
        let n = differences.len() as f64;
        if differences.len() < 2 {
            bail!("{}: nobody has it", what.words());
        }
        let mean = differences.iter().sum::<f64>() / n;
        let squares: f64 = differences.iter().map(|d| (d - mean) * (d - mean)).sum();
        let sd = (squares / (n - 1.0)).sqrt();
        Ok(Truth { mean, sd, std_error: sd / n.sqrt() })
    }

    /// A plan for a difference of nothing: its SDs are those of the mixed model of everybody's
    /// trials in the first session, in these modes.
    pub(crate) fn plan(&self, what: What, modes: &[&str]) -> anyhow::Result<Plan> {
        let sessions: BTreeSet<&String> =
            self.trials.iter().flatten().map(|trial| &trial.session).collect();
        let mut participant = vec![];
        let mut mode = vec![];
        let mut value = vec![];
        for (person, trials) in self.trials.iter().enumerate() {
            for trial in trials {
                let side = modes.iter().position(|id| *id == MODES[trial.mode]);
                let here = trial.environment == what.environment
                    && sessions.first() == Some(&&trial.session);
                if let (true, Some(side), Some(found)) = (here, side, trial.values[what.metric]) {
                    participant.push(person);
                    mode.push(side);
                    value.push(found);
                }
            }
        }
        let session = vec![0; value.len()];
        let fitted = fit_trials(Trials {
            participant: &participant,
            session: &session,
            mode: &mode,
            value: &value,
        })?;
        let [participant, participant_mode] =
            [Term::Participant, Term::ParticipantMode].map(|term| {
                let place = fitted.structure.iter().position(|of| *of == term)?;
                Some(fitted.fit.terms.get(place)?.covariance.first()?.first()?.max(0.0).sqrt())
            });
        let none = || format!("{}: no spread", what.words());
        Ok(Plan {
            participant_sd: participant.with_context(none)?,
            interaction_sd: participant_mode.with_context(none)?,
            residual_sd: fitted.fit.residual_variance.sqrt(),
            repeats: REPEATS as usize,
            modes: modes.len(),
            difference: 0.0,
            participants: PARTICIPANTS,
        })
    }
}

fn difference(trials: &[Trial], what: What, first: bool) -> Option<f64> {
    let sessions: BTreeSet<&String> = trials.iter().map(|trial| &trial.session).collect();
    let count = if first { 1 } else { sessions.len() };
    let mean = |session: &String, mode: &str| -> Option<f64> {
        let here = trials.iter().filter(|trial| {
            trial.session == *session
                && trial.environment == what.environment
                && MODES[trial.mode] == mode
        });
        let values: Vec<f64> = here.filter_map(|trial| trial.values[what.metric]).collect();
        (!values.is_empty()).then(|| values.iter().sum::<f64>() / values.len() as f64)
    };
    let [mode, against] = CONTRASTS[what.contrast];
    let of_session = |session: &String| Some(mean(session, mode)? - mean(session, against)?);
    let found: Vec<f64> = sessions.into_iter().take(count).filter_map(of_session).collect();
    (!found.is_empty()).then(|| found.iter().sum::<f64>() / found.len() as f64)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn trial(session: &str, mode: usize, value: Option<f64>) -> Trial {
        let values = [value; METRICS.len()];
        Trial { session: session.to_owned(), trial: 1, repeat: 1, environment: 0, mode, values }
    }

    #[test]
    fn sessions_weigh_the_same_and_one_without_both_modes_does_not_count() {
        let trials = [
            trial("S01", 2, Some(5.0)),
            trial("S01", 2, Some(7.0)),
            trial("S01", 2, None),
            trial("S01", 0, Some(1.0)),
            trial("S02", 2, Some(3.0)),
            trial("S02", 0, Some(2.0)),
            trial("S03", 2, Some(100.0)),
        ];
        let what = What { metric: 0, environment: 0, contrast: 0 };
        assert_eq!(difference(&trials, what, false), Some((5.0 + 1.0) / 2.0));
        assert_eq!(difference(&trials, what, true), Some(5.0));
        assert_eq!(difference(&trials, What { environment: 1, ..what }, false), None);
    }
}
