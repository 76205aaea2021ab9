//! The replays as rows: SI units, one per trial and causality.

use zwidth_results::ReplayedTrial;
use zwidth_study::Source;

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
    use crate::Parameters;
    use crate::testing::{replays, simulated};
    use zwidth_results::{Causality, ModelPlant, Row};

    #[test]
    fn each_causality_has_its_row_and_the_units_of_what_came_out() {
        let rows = replays(&simulated("hybrid", &Parameters::BY_EYE));
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
    fn conditions_come_together_in_the_order_of_their_trials() {
        let one = replays(&simulated("hybrid", &Parameters::BY_EYE)).remove(0);
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
