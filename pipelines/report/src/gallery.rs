//! Where a sentence can be seen: which figure or table, and its file.

use serde::Serialize;
use std::collections::BTreeSet;
use zwidth_study::EnvironmentId;

/// Where a sentence can be seen.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Shown {
    /// In the figure of one environment's modes.
    Modes(EnvironmentId),
    /// In the table of metrics by condition.
    Conditions,
    /// In the table of metrics by trial.
    Metrics,
    /// In the figure of the answers.
    Answers,
    /// In the figure that compares the modes in this metric.
    Compared(String),
    /// In the figure of the changes between sessions in this metric.
    Sessions(String),
    /// In the figure of the forces that each mode can render.
    Forces,
    /// In the figure of one environment's replays.
    Replays(EnvironmentId),
    /// In the table of weights.
    Weight,
    /// In the table of the thesis' statements.
    Statements,
    /// In the figure of one scene's speed against accuracy.
    Trade(String),
    /// In the table of the terms that each condition requires.
    Ladder,
}

impl Shown {
    /// The table that holds the same numbers, from the summary's folder on.
    pub fn table(&self) -> &'static str {
        match self {
            Self::Modes(_) | Self::Metrics => "tables/metrics.md",
            Self::Conditions => "tables/conditions.md",
            Self::Compared(_) | Self::Sessions(_) => "tables/comparison.md",
            Self::Answers => "tables/likert.md",
            Self::Forces => "tables/modes.md",
            Self::Replays(_) => "tables/replay.md",
            Self::Weight => "tables/weight.md",
            Self::Statements => "tables/thesis.md",
            Self::Trade(_) => "tables/trade_summary.md",
            Self::Ladder => "tables/ladder.md",
        }
    }
}

/// The figures of a study.
#[derive(Debug, Clone, PartialEq, Eq, Default, Serialize)]
pub struct Gallery {
    /// Their names.
    pub figures: BTreeSet<String>,
    /// Participant and session, where there is only one.
    pub only_session: Option<[String; 2]>,
}

impl Gallery {
    /// The figure that shows it, from the summary's folder on, with `/`; the table where there is
    /// no such figure.
    pub fn file(&self, shown: &Shown) -> String {
        let figure = self.figure(shown).filter(|figure| self.figures.contains(figure));
        figure.map_or_else(|| shown.table().to_owned(), |figure| format!("figures/{figure}.png"))
    }

    fn figure(&self, shown: &Shown) -> Option<String> {
        let of_session = |kind: &str, environment: &EnvironmentId| {
            let [participant, session] = self.only_session.as_ref()?;
            Some(format!("{kind}.{participant}.{session}.{environment}"))
        };
        match shown {
            Shown::Modes(environment) => of_session("modes", environment),
            Shown::Replays(environment) => of_session("replay", environment),
            Shown::Answers => {
                let drawn = |stem: &&str| self.figures.contains(*stem);
                ["likert", "ratings"].into_iter().find(drawn).map(str::to_owned)
            }
            Shown::Compared(metric) => Some(format!("compare.{metric}")),
            Shown::Sessions(metric) => Some(format!("sessions.{metric}")),
            Shown::Forces => Some("rendering_range".to_owned()),
            Shown::Trade(scene) => Some(format!("trade.{scene}")),
            Shown::Conditions
            | Shown::Metrics
            | Shown::Weight
            | Shown::Statements
            | Shown::Ladder => None,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_figure_of_one_session_stands_for_a_study_of_one_session_alone() {
        let figures = ["likert", "modes.P01.S01.spring"].map(str::to_owned).into();
        let only_session = Some(["P01", "S01"].map(str::to_owned));
        let one = Gallery { figures, only_session };
        let spring = Shown::Modes("spring".parse().unwrap());
        let file = "figures/modes.P01.S01.spring.png";
        assert_eq!(one.file(&spring), file);
        assert_eq!(one.file(&Shown::Replays("spring".parse().unwrap())), "tables/replay.md");
        assert_eq!(one.file(&Shown::Answers), "figures/likert.png");
        let several = Gallery { only_session: None, ..one };
        assert_eq!(several.file(&spring), "tables/metrics.md");
    }
}
