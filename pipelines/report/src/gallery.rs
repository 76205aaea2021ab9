//! Where to see the evidence for a sentence: which figure or table, and its file.

use serde::Serialize;
use std::collections::BTreeSet;
use zwidth_results::OVER_SEVERAL;
use zwidth_study::{Curve, EnvironmentId};

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
    /// In the figure that compares groups in this metric.
    Groups(String),
    /// In the figure of the factors' effects on this metric.
    Effects(String),
    /// In the figure of a whole curve in an environment, of everybody or between groups.
    Curves {
        /// The curve.
        curve: Curve,
        /// Where.
        environment: Option<EnvironmentId>,
        /// Whether between groups.
        of_groups: bool,
    },
    /// In the figure of the changes between sessions in this metric.
    Sessions(String),
    /// In the figure of the changes from repeat to repeat in this metric.
    Learning(String),
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
    /// In the figure of everybody's thresholds of this task.
    Thresholds(String),
}

/// The question that a sentence answers.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Asked {
    /// Whether modes differ.
    Difference,
    /// Whether practice changes anything.
    Practice,
    /// What people said.
    Answers,
    /// Anything else.
    #[default]
    Else,
}

impl Shown {
    /// The question that it answers.
    pub fn question(&self) -> Asked {
        match self {
            Self::Compared(_)
            | Self::Groups(_)
            | Self::Effects(_)
            | Self::Curves { .. }
            | Self::Thresholds(_) => Asked::Difference,
            Self::Sessions(_) | Self::Learning(_) => Asked::Practice,
            Self::Answers => Asked::Answers,
            _ => Asked::Else,
        }
    }
}

/// What there is to look at in a study.
#[derive(Debug, Clone, PartialEq, Eq, Default, Serialize)]
pub struct Gallery {
    /// The names of its figures.
    pub figures: BTreeSet<String>,
    /// The names of its tables that are only for programs, because they are too long to read.
    pub for_programs: BTreeSet<String>,
    /// Participant and session, where there is only one.
    pub only_session: Option<[String; 2]>,
}

impl Gallery {
    /// The figure that shows it, from the summary's folder on, with `/`; the table if there is no
    /// such figure.
    pub fn file(&self, shown: &Shown) -> String {
        let (figure, table) = self.places(shown);
        let figure = figure.filter(|figure| self.figures.contains(figure));
        figure.map_or_else(|| self.table_file(table), |figure| format!("figures/{figure}.png"))
    }

    /// The table that holds the same numbers, from the summary's folder on.
    pub fn table(&self, shown: &Shown) -> String {
        self.table_file(self.places(shown).1)
    }

    /// The file of a table, from the summary's folder on: Markdown, or where that is not made CSV.
    pub fn table_file(&self, name: &str) -> String {
        let extension = if self.for_programs.contains(name) { "csv" } else { "md" };
        format!("tables/{name}.{extension}")
    }

    /// The figure that would show it, if one could, and the table that holds the same numbers.
    fn places(&self, shown: &Shown) -> (Option<String>, &'static str) {
        // Of several sessions no single figure shows what a sentence says of all.
        let of_session = |kind: &str, environment: &EnvironmentId| {
            let [participant, session] = self.only_session.as_ref()?;
            Some(format!("{kind}.{participant}.{session}.{environment}"))
        };
        match shown {
            Shown::Modes(environment) => (of_session("modes", environment), "metrics"),
            Shown::Conditions => (None, "conditions"),
            Shown::Metrics => (None, "metrics"),
            Shown::Answers => {
                let stems = ["likert", "ratings"];
                let stem = stems.into_iter().find(|stem| self.figures.contains(*stem));
                (stem.map(str::to_owned), "likert")
            }
            Shown::Compared(metric) => (Some(format!("compare.{metric}")), "comparison"),
            Shown::Groups(metric) => (Some(format!("groups.{metric}")), "comparison"),
            Shown::Effects(metric) => (Some(format!("effects.{metric}")), "metrics"),
            Shown::Curves { curve, environment, of_groups } => {
                let environment = environment.as_ref().map_or(OVER_SEVERAL, |id| id.as_str());
                let groups = if *of_groups { ".groups" } else { "" };
                (Some(format!("curves.{}.{environment}{groups}", curve.as_str())), "curve_tests")
            }
            Shown::Sessions(metric) => (Some(format!("sessions.{metric}")), "comparison"),
            Shown::Learning(metric) => (Some(format!("learning.{metric}")), "comparison"),
            Shown::Forces => (Some("rendering_range".to_owned()), "modes"),
            Shown::Replays(environment) => (of_session("replay", environment), "replay"),
            Shown::Weight => (None, "weight"),
            Shown::Statements => (None, "thesis"),
            Shown::Trade(scene) => (Some(format!("trade.{scene}")), "trade_summary"),
            Shown::Ladder => (None, "ladder"),
            Shown::Thresholds(task) => (Some(format!("thresholds.{task}")), "psychometric"),
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
        let one = Gallery { figures, only_session, ..Gallery::default() };
        let spring = Shown::Modes("spring".parse().unwrap());
        let file = "figures/modes.P01.S01.spring.png";
        assert_eq!(one.file(&spring), file);
        assert_eq!(one.file(&Shown::Replays("spring".parse().unwrap())), "tables/replay.md");
        assert_eq!(one.file(&Shown::Answers), "figures/likert.png");
        let several = Gallery { only_session: None, ..one };
        assert_eq!(several.file(&spring), "tables/metrics.md");
        let long = Gallery { for_programs: ["metrics".to_owned()].into(), ..several };
        assert_eq!(long.file(&spring), "tables/metrics.csv");
        assert_eq!(long.table(&Shown::Conditions), "tables/conditions.md");
    }
}
