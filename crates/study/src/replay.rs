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
    use crate::{Study, StudyId, template};

    fn with(replay: &str) -> Result<Study, String> {
        let text = template(&StudyId::new("demo").unwrap());
        Study::from_toml(&format!("{text}\n[replay]\n{replay}\n")).map_err(|e| e[0].to_string())
    }

    #[test]
    fn a_study_replays_by_eye_unless_it_says_auto() {
        let study = Study::from_toml(&template(&StudyId::new("demo").unwrap())).unwrap();
        assert_eq!(study.replay, ReplayModel::ByEye);
        assert!(!study.to_toml().unwrap().contains("[replay]"));
        let auto = with("model = \"auto\"").unwrap();
        assert_eq!(auto.replay, ReplayModel::Auto);
        assert_eq!(Study::from_toml(&auto.to_toml().unwrap()).unwrap(), auto);
    }

    #[test]
    fn another_word_is_an_error_that_lists_those_there_are() {
        let error = with("model = \"best\"").unwrap_err();
        assert!(error.contains("by_eye") && error.contains("auto"), "{error}");
    }
}
