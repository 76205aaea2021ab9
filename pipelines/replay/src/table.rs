//! The replays as rows: SI units, one per trial and causality.

use crate::TrialReplay;
use zwidth_results::{Causality, ReplayedTrial};
use zwidth_study::Source;

/// One row per trial and causality, in the order given: which trial, the input, the outcome, the
/// plant, and how far the model departs.
pub fn rows(replays: &[TrialReplay]) -> Vec<ReplayedTrial> {
    replays.iter().map(row).collect()
}

fn row(replay: &TrialReplay) -> ReplayedTrial {
    let TrialReplay { meta, parameters, comparison, velocity, .. } = replay;
    let all = comparison.as_ref();
    let is_of_force = replay.causality == Causality::PositionDriven;
    let of_angle = all.filter(|_| !is_of_force);
    let of_force = all.filter(|_| is_of_force);
    ReplayedTrial {
        participant: meta.participant.clone(),
        session: meta.session.clone(),
        trial: meta.trial,
        repeat: meta.repeat,
        environment: meta.environment.clone(),
        mode: meta.mode.clone(),
        source: meta.source,
        causality: replay.causality,
        model: replay.which,
        outcome: replay.outcome,
        mass_kg: parameters.mass_kg,
        damping_n_s_per_rad: parameters.damping_ns_per_rad,
        friction_n: parameters.friction_n,
        nrmse: all.and_then(|c| c.nrmse),
        vaf: all.and_then(|c| c.vaf),
        lag_s: all.and_then(|c| c.lag_s),
        rmse_rad: of_angle.map(|c| c.rmse),
        rmse_n: of_force.map(|c| c.rmse),
        peak_recorded_rad: of_angle.map(|c| c.peak_recorded),
        peak_error_rad: of_angle.map(|c| c.peak_error),
        peak_recorded_n: of_force.map(|c| c.peak_recorded),
        peak_error_n: of_force.map(|c| c.peak_error),
        peak_time_recorded_s: all.map(|c| c.peak_time_recorded_s),
        peak_time_error_s: all.map(|c| c.peak_time_error_s),
        velocity_rmse_rad_s: velocity.map(|v| v.rmse_rad_s),
        velocity_nrmse: velocity.and_then(|v| v.nrmse),
        velocity_sd_ratio: velocity.and_then(|v| v.sd_ratio),
        reversal_recorded_s: replay.reversal_recorded_s,
        reversal_error_s: replay.reversal_error_s,
    }
}

/// The replays of several conditions in the order of participant, session and trial; those of a
/// trial stay in theirs.
#[must_use]
pub fn in_order(mut rows: Vec<ReplayedTrial>) -> Vec<ReplayedTrial> {
    rows.sort_by(|a, b| {
        (&a.participant, &a.session, a.trial).cmp(&(&b.participant, &b.session, b.trial))
    });
    rows
}

/// The note on trials that a model with the same equations made.
pub fn own_model(mut sources: impl Iterator<Item = Source>) -> Option<&'static str> {
    sources.any(|source| source == Source::Twin).then_some(OWN_MODEL)
}

/// The note on simulated trials and this model.
pub(crate) const OWN_MODEL: &str = "Simulated trials: the twin that made them and the model have the same \
    equations for lever, friction, actuators and lags (the twin has a hand, ticks and sensors besides). A fitted \
    model that lies on them says that identification works, not that the model is true to a prototype.";

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testing::{rendering, simulated};
    use crate::{Parameters, replay};
    use zwidth_results::{ModelPlant, ReplayOutcome, Row};
    use zwidth_study::Analysis;

    fn replays() -> Vec<TrialReplay> {
        let trial = simulated("hybrid", &Parameters::BY_EYE);
        replay(
            &trial,
            &rendering("hybrid"),
            &Analysis::default(),
            ModelPlant::ByEye,
            &Parameters::BY_EYE,
        )
        .unwrap()
    }

    #[test]
    fn each_causality_has_its_row_and_the_units_of_what_came_out() {
        let rows = rows(&replays());
        let causalities: Vec<Causality> = rows.iter().map(|row| row.causality).collect();
        assert_eq!(causalities, Causality::ALL);
        let there = |number: fn(&ReplayedTrial) -> Option<f64>| {
            rows.iter().map(|row| number(row).is_some()).collect::<Vec<_>>()
        };
        assert_eq!(there(|row| row.rmse_rad), [true, false, true]);
        assert_eq!(there(|row| row.peak_error_n), [false, true, false]);
        assert_eq!(there(|row| row.vaf), [true; 3]);
        assert_eq!(there(|row| row.velocity_rmse_rad_s), [true, false, true]);
        assert_eq!(ReplayedTrial::read(&ReplayedTrial::columns(&rows)).unwrap(), rows);
    }

    #[test]
    fn a_model_that_diverged_is_a_word_and_nulls() {
        let (outcome, comparison) = (ReplayOutcome::Diverged, None);
        let row = row(&TrialReplay { outcome, comparison, ..replays().remove(0) });
        assert_eq!((row.outcome, row.vaf), (ReplayOutcome::Diverged, None));
    }

    #[test]
    fn conditions_come_together_in_the_order_of_their_trials() {
        let one = row(&replays().remove(0));
        let at = |participant: &str, trial, model| ReplayedTrial {
            participant: participant.parse().unwrap(),
            trial,
            model,
            ..one.clone()
        };
        let (by_eye, fitted) = (ModelPlant::ByEye, ModelPlant::Fitted);
        let rows = in_order(vec![
            at("P02", 3, by_eye),
            at("P01", 10, fitted),
            at("P01", 9, fitted),
            at("P01", 9, by_eye),
        ]);
        let found: Vec<_> =
            rows.iter().map(|row| (row.participant.as_str(), row.trial, row.model)).collect();
        let expect =
            [("P01", 9, fitted), ("P01", 9, by_eye), ("P01", 10, fitted), ("P02", 3, by_eye)];
        assert_eq!(found, expect);
    }

    /// `docs/analysis.md` is the page on which a reader looks a column up.
    #[test]
    fn every_column_is_defined_on_the_page_about_the_analysis() {
        let page = include_str!("../../../docs/analysis.md");
        // The first seven say which trial it is.
        for field in ReplayedTrial::fields().iter().skip(7) {
            assert!(page.contains(&format!("`{}`", field.name)), "{} is not defined", field.name);
        }
    }
}
