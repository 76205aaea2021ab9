//! Which model recorded trials are replayed with.

use serde::{Deserialize, Serialize};

/// `[replay] model` of a study.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum ReplayModel {
    /// The thesis' plant, chosen by eye: a mass and its damping.
    #[default]
    ByEye,
    /// The cheapest model that nobody could tell from the fullest, found by the ladder of each
    /// condition and fitted to half of its repeats (`docs/ladder.md`).
    Auto,
}

#[cfg(test)]
mod tests {
    use super::ReplayModel;
    use crate::tests::{check_round_trip, demo, with};

    #[test]
    fn a_study_replays_by_eye_unless_it_says_auto() {
        let study = demo();
        assert_eq!(study.replay, ReplayModel::ByEye);
        assert!(!study.to_toml().unwrap().contains("[replay]"));
        let auto = with("[replay]", "model = \"auto\"").unwrap();
        assert_eq!(auto.replay, ReplayModel::Auto);
        check_round_trip(&auto);
    }

    #[test]
    fn another_word_is_an_error_that_lists_those_there_are() {
        let error = with("[replay]", "model = \"best\"").unwrap_err()[0].to_string();
        assert!(error.contains("by_eye") && error.contains("auto"), "{error}");
    }
}
