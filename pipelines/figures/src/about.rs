//! What figures say of a study besides what was recorded and derived, and what each says of itself.

use serde::Serialize;
use zwidth_study::{Coordinate, Mode, Study};

/// What figures need to know of a study.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct About {
    /// The study's title.
    pub title: String,
    /// What axes call the coordinate.
    pub coordinate: Coordinate,
    /// Level of every interval, as a fraction.
    pub confidence: f64,
    /// The modes, in the order of their colours.
    pub modes: Vec<Mode>,
}

impl About {
    /// That of a study.
    pub fn of(study: &Study) -> Self {
        Self {
            title: study.title.clone(),
            coordinate: study.coordinate,
            confidence: study.analysis.confidence,
            modes: study.modes.clone(),
        }
    }
}

/// What a figure shows. One entry a file of this crate that draws a study's figure.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Kind {
    /// [`crate::modes`].
    Modes,
    /// [`crate::repeats`].
    Repeats,
    /// [`crate::loops`].
    Loops,
    /// [`crate::characteristic`].
    Characteristic,
    /// [`crate::likert`], by environment or group.
    Likert,
    /// [`crate::likert`], by question.
    LikertItems,
    /// [`crate::rendering_range`].
    RenderingRange,
    /// [`crate::environment`].
    Environment,
    /// [`crate::free_motion`].
    FreeMotion,
    /// [`crate::replay`].
    Replay,
    /// [`crate::modes_compared`].
    ModesCompared,
    /// [`crate::participants_compared`].
    ParticipantsCompared,
    /// [`crate::repeats_compared`].
    RepeatsCompared,
}

impl Kind {
    /// The first word of its files' names, and what it shows.
    fn words(self) -> (&'static str, &'static str) {
        match self {
            Self::Modes => {
                ("modes", "position, force and velocity against time, force against position")
            }
            Self::Repeats => ("repeats", "every repeat of one condition"),
            Self::Loops => ("loops", "force against position, all environments"),
            Self::Characteristic => {
                ("characteristic", "response to the command, with the chosen fit")
            }
            Self::Likert => ("likert", "answers, diverging bars with counts"),
            Self::LikertItems => ("likert_items", "answers to each question"),
            Self::RenderingRange => (
                "rendering_range",
                "forces that each mode can render, compressing and decompressing",
            ),
            Self::Environment => {
                ("environment", "device, spring and wall at the study's own angles")
            }
            Self::FreeMotion => {
                ("free_motion", "plane fits of free motion, sessions and modes side by side")
            }
            Self::Replay => ("replay", "recorded trials and the model given their external force"),
            Self::ModesCompared => {
                ("compare", "modes compared: means, and differences with their intervals")
            }
            Self::ParticipantsCompared => {
                ("participants", "each participant's difference between modes")
            }
            Self::RepeatsCompared => ("learning", "mean at each repeat of a condition"),
        }
    }

    /// What one of the things is called that it is drawn from.
    fn noun(self) -> &'static str {
        match self {
            Self::Characteristic => "sweep",
            Self::Likert | Self::LikertItems => "answer",
            _ => "trial",
        }
    }
}

/// What a figure says of itself.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
pub struct Caption {
    /// What it shows.
    pub kind: Kind,
    /// Of whom or what: `["P01", "S01", "spring"]`; nothing for the study.
    pub subject: Vec<String>,
    /// How many trials, sweeps or answers it is drawn from; `None` where it is drawn from a plan.
    pub n: Option<usize>,
}

impl Caption {
    /// That of a figure of a kind.
    pub fn new(kind: Kind, subject: impl IntoIterator<Item = impl Into<String>>) -> Self {
        Self { kind, subject: subject.into_iter().map(Into::into).collect(), n: None }
    }

    /// The stem of its files' names: `modes.P01.S01.spring`.
    pub fn stem(&self) -> String {
        let first = self.kind.words().0.to_owned();
        [first].into_iter().chain(self.subject.iter().cloned()).collect::<Vec<_>>().join(".")
    }

    /// What it shows and of whom, in words.
    pub fn text(&self) -> String {
        let what = self.kind.words().1;
        let who = Some(self.subject.join(" ")).filter(|who| !who.is_empty());
        let of =
            self.n.map(|n| format!("{n} {}{}", self.kind.noun(), if n == 1 { "" } else { "s" }));
        let about: Vec<String> = who.into_iter().chain(of).collect();
        match about.is_empty() {
            true => what.to_owned(),
            false => format!("{what} ({})", about.join(", ")),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_caption_gives_the_files_their_name_and_the_reader_a_line() {
        let modes = Caption::new(Kind::Modes, ["P01", "S01", "spring"]);
        assert_eq!(modes.stem(), "modes.P01.S01.spring");
        assert!(modes.text().ends_with("force against position (P01 S01 spring)"));
        let of = Caption { n: Some(18), ..modes };
        assert!(of.text().ends_with("(P01 S01 spring, 18 trials)"), "{}", of.text());
        let tally = Caption { n: Some(1), ..Caption::new(Kind::Likert, [""; 0]) };
        assert!(tally.text().ends_with("(1 answer)"), "{}", tally.text());
        let range = Caption::new(Kind::RenderingRange, [""; 0]);
        assert_eq!((range.stem().as_str(), range.text().contains('(')), ("rendering_range", false));
    }
}
