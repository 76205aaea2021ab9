//! What a study chooses of its figures.

use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;

/// How repeats are made to meet before they are averaged (`zwidth_average` defines both).
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Alignment {
    /// At movement onset: t is each repeat's own time since then.
    #[default]
    Onset,
    /// By landmarks: each repeat's time is warped, piecewise linearly, so that its landmarks
    /// (start, wall contact, reversal, end) meet their mean times. What repeats do at different
    /// times is then not smeared.
    Landmarks,
}

impl Alignment {
    /// Both, the default first.
    pub const ALL: [Self; 2] = [Self::Onset, Self::Landmarks];

    /// The word in files, tables and names.
    pub fn as_str(self) -> &'static str {
        match self {
            Self::Onset => "onset",
            Self::Landmarks => "landmarks",
        }
    }
}

/// Choices for figures: for all of them, for those of a kind, or for one.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct Figures {
    /// By the beginning of a figure's id, cut at a dot; the empty text stands for every figure.
    pub(crate) alignment: BTreeMap<String, Alignment>,
}

impl Figures {
    /// The kinds of figures that show a mean of repeats, and hence know an alignment. Figures are
    /// called `modes.<participant>.<session>.<environment>` and
    /// `loops.<participant>.<session>`.
    pub(crate) const WITH_MEANS: [&'static str; 2] = ["modes", "loops"];

    /// How the figure of that id shows its means: by the longest choice that its id begins with,
    /// else at onset.
    pub fn alignment(&self, id: &str) -> Alignment {
        let cuts = id.match_indices('.').map(|(at, _)| &id[..at]);
        let chosen =
            std::iter::once("").chain(cuts).chain([id]).filter_map(|part| self.alignment.get(part));
        // Cuts rise along the id: the last is the longest.
        chosen.copied().last().unwrap_or_default()
    }

    /// Whatever was chosen: the beginning of an id, and the choice.
    pub fn choices(&self) -> impl Iterator<Item = (&str, Alignment)> {
        self.alignment.iter().map(|(id, alignment)| (id.as_str(), *alignment))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_choice_nearest_to_a_figure_counts() {
        let chosen = |choices: &[(&str, Alignment)]| Figures {
            alignment: choices.iter().map(|(id, a)| ((*id).to_owned(), *a)).collect(),
        };
        let [onset, landmarks] = Alignment::ALL;
        let figures =
            chosen(&[("", landmarks), ("modes.P01", onset), ("modes.P01.S02.spring", landmarks)]);
        for (id, expect) in [
            ("modes.P01.S01.spring", onset),
            ("modes.P01.S02.spring", landmarks),
            ("modes.P01.S02.spring_wall", onset),
            ("modes.P010.S01.spring", landmarks),
            ("loops.P01.S01", landmarks),
        ] {
            assert_eq!(figures.alignment(id), expect, "{id}");
        }
        assert_eq!(Figures::default().alignment("modes.P01.S01.spring"), onset);
    }
}
