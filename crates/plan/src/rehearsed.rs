//! The effect of another loop or other sensors on a study's metrics, from its trials on the
//! simulated device: `zwidth trade` asks for it, a run does not. Stages meet here: the trade
//! simulates, and the metrics are computed from the result.

use crate::shared::conditions::Repeats;
use crate::trade::{measured_conditions, scenes_calibration};
use rayon::prelude::*;
use serde::Serialize;
use zwidth_device::Twin;
use zwidth_metrics::{Parameters, TrialMetrics};
use zwidth_results::{MetricShift, SetupSummary};
use zwidth_runner::JobError;
use zwidth_store::{StudyData, Trial};
use zwidth_study::{ParticipantId, SessionId, Source, TrialMeta};
use zwidth_trade::{Bounds, Rehearsed, Setup, Stops, rehearse, setup_shifts, twin_summary};

/// At most this many trials are simulated again, each a dozen times.
const MOST_TRIALS: usize = 600;

/// The simulated device with the person of a session at it.
pub type TwinOf<'a> = dyn Fn(&ParticipantId, &SessionId) -> Result<Twin, JobError> + Sync + 'a;

/// What the trade of setups depends on, besides the twins.
#[derive(Debug, Serialize)]
pub struct Rehearsal {
    /// Participant, session, environment, mode and number of each trial.
    trials: Vec<[String; 5]>,
    setups: Vec<Setup>,
    metrics_version: u32,
}

/// The conditions that are simulated: from the first on, until there are enough trials.
fn conditions(data: &StudyData) -> Vec<Repeats<'_>> {
    let mut trials = 0;
    measured_conditions(data)
        .take_while(|repeats| {
            // The condition that passes the limit is still taken, whole.
            let before = trials;
            trials += repeats.trials.len();
            before < MOST_TRIALS
        })
        .collect()
}

/// What a study's trade of setups depends on; `None` if no condition has angle and force.
pub fn rehearsal(data: &StudyData) -> Option<Rehearsal> {
    let mut trials = Vec::new();
    for trial in conditions(data).iter().flat_map(|repeats| &repeats.trials) {
        let TrialMeta { participant, session, environment, mode, trial, .. } = &trial.meta;
        trials.push([
            participant.to_string(),
            session.to_string(),
            environment.to_string(),
            mode.to_string(),
            trial.to_string(),
        ]);
    }
    (!trials.is_empty()).then(|| Rehearsal {
        trials,
        setups: Setup::others(&data.study),
        metrics_version: zwidth_metrics::VERSION,
    })
}

/// How many trials are simulated, at all setups together.
pub fn rehearsed_trials(data: &StudyData) -> usize {
    let trials: usize = conditions(data).iter().map(|r| r.trials.len()).sum();
    trials * (1 + Setup::others(&data.study).len())
}

/// What other setups do to a study's metrics.
#[derive(Debug, Clone, PartialEq)]
pub struct OtherSetups {
    /// Every metric of every condition at every setup.
    pub shifts: Vec<MetricShift>,
    /// The same in short, one row per setup.
    pub summary: Vec<SetupSummary>,
    /// The trials that safety stopped.
    pub stops: Vec<Stops>,
}

/// Every metric at every setup; `None` where no condition has angle and force. Any number of threads
/// gives the same bits.
///
/// # Errors
/// Parameters of a twin that cannot be; metrics that are not numbers.
pub fn rehearsed(
    data: &StudyData,
    twin_of: &TwinOf<'_>,
    progress: &(dyn Fn() + Sync),
) -> Result<Option<OtherSetups>, JobError> {
    let calibration = scenes_calibration(data);
    let perception = crate::thresholds::perception(data);
    let mut shifts = Vec::new();
    let mut stops = Vec::new();
    let conditions = conditions(data);
    let defined = &data.study.metrics;
    let in_space = data.study.axes.is_some();
    for repeats in &conditions {
        let Some(first) = repeats.trials.first() else {
            return Err("a condition has trials".into());
        };
        let twin = twin_of(&first.meta.participant, &first.meta.session)?;
        // The metrics of each trial, or why there are none, in words.
        let metrics_at = |setup: Setup| -> Vec<Result<TrialMetrics, String>> {
            let study = setup.of(&data.study);
            let parameters = Parameters::of(&study, repeats.environment, repeats.mode);
            let rows = repeats.trials.par_iter().map(|entry| {
                let condition = (repeats.environment, repeats.mode, entry.meta.trial);
                let samples = rehearse(twin.clone(), setup, &data.study, condition, &calibration);
                let row = samples.map_err(|e| e.to_string()).and_then(|samples| {
                    // Simulated, whatever the trial was that it takes the place of.
                    let meta = TrialMeta { source: Source::Twin, ..entry.meta.clone() };
                    let trial = Trial { meta, file: entry.said.file.clone(), samples };
                    zwidth_metrics::trial_metrics(&trial, &parameters).map_err(|e| e.to_string())
                });
                progress();
                row
            });
            rows.collect()
        };
        let own = metrics_at(Setup::Own);
        let mut rehearsals = Vec::new();
        for setup in Setup::others(&data.study) {
            let changed = metrics_at(setup);
            let both = own.iter().zip(&changed);
            // Pairs alone: a trial that safety stopped at one of the setups shifts no metric.
            let pairs = both
                .filter_map(|(a, b)| Some((a.as_ref().ok()?.clone(), b.as_ref().ok()?.clone())));
            let (own, changed_rows): (Vec<_>, Vec<_>) = pairs.unzip();
            let reasons: Vec<&String> =
                changed.iter().filter_map(|row| row.as_ref().err()).collect();
            if let Some(why) = reasons.first() {
                let trials = reasons.len();
                let all = changed.len();
                let why =
                    format!("{}, {}: {trials} of {all} trials: {why}", repeats.who, setup.words());
                stops.push(Stops { setup, trials, why });
            }
            rehearsals.push(Rehearsed {
                setup,
                own: zwidth_metrics::table(&own, defined, in_space)?,
                changed: zwidth_metrics::table(&changed_rows, defined, in_space)?,
            });
        }
        let lever_m = data.study.device.lever_m.unwrap_or(0.0);
        let bounds = Bounds { perception: &perception, lever_m };
        shifts.extend(setup_shifts(&repeats.key, &rehearsals, &bounds));
    }
    let summary = twin_summary(&shifts, &stops);
    Ok((!conditions.is_empty()).then_some(OtherSetups { shifts, summary, stops }))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::tests::data;
    use zwidth_device::{Person, TwinParameters};

    fn made() -> OtherSetups {
        let of = |_: &ParticipantId, _: &SessionId| -> Result<Twin, JobError> {
            Ok(Twin::new(TwinParameters::default(), Person::typical(7), 3)?)
        };
        rehearsed(&data(), &of, &|| ()).unwrap().unwrap()
    }

    #[test]
    fn every_setup_has_a_row_and_a_mode_that_safety_refuses_is_counted_and_told() {
        let found = made();
        let setups: Vec<String> = found.summary.iter().map(|row| row.setup.to_string()).collect();
        let mut asked: Vec<String> =
            Setup::others(&data().study).into_iter().map(Setup::words).collect();
        let mut sorted = setups.clone();
        asked.sort();
        sorted.sort();
        assert_eq!(sorted, asked);
        let at = setups.iter().position(|setup| setup == "force at 10 Hz").unwrap();
        assert_eq!(found.summary[at].stopped, 2, "the loop switches on it");
        assert!(found.stops.iter().any(|stop| stop.why.contains("2 of 2 trials")), "{found:?}");
        assert!(found.shifts.iter().any(|shift| &*shift.metric == "theta_max_rad"));
        assert_eq!(made(), found, "the same every time");
    }

    #[test]
    fn a_study_says_how_many_trials_are_simulated_and_what_they_depend_on() {
        let data = data();
        assert_eq!(rehearsed_trials(&data), 2 * (1 + Setup::others(&data.study).len()));
        assert_eq!(rehearsal(&data).unwrap().trials[1], ["P01", "S01", "spring", "hybrid", "2"]);
        assert!(rehearsal(&StudyData { trials: Vec::new(), ..data }).is_none());
    }
}
