//! What a study chooses of its figures.

use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;

/// How repeats are made to meet before they are averaged (`zwidth_average` defines both).
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Alignment {
    /// At movement onset: t is each repeat's own time since then.
    Onset,
    /// By landmarks: each repeat's time is warped, piecewise linearly, so that its landmarks
    /// (start, wall contact, reversal, end) meet their mean times. What repeats do at different
    /// times is then not smeared.
    Landmarks,
}

impl Alignment {
    /// Both.
    pub const ALL: [Self; 2] = [Self::Onset, Self::Landmarks];

    /// The word in files, tables and names.
    pub fn as_str(self) -> &'static str {
        match self {
            Self::Onset => "onset",
            Self::Landmarks => "landmarks",
        }
    }
}

/// How the means of one figure are aligned, by what they stand against.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
pub struct Alignments {
    /// Those against time.
    pub over_time: Alignment,
    /// Those against position.
    pub over_position: Alignment,
}

impl Alignments {
    /// Both alike.
    pub fn both(alignment: Alignment) -> Self {
        Self { over_time: alignment, over_position: alignment }
    }
}

impl Default for Alignments {
    /// Against time at onset, as the thesis' mean of six; against position by landmarks, because
    /// repeats that turn at different times have, at one time, a mean force at a mean position that
    /// no repeat passes.
    fn default() -> Self {
        Self { over_time: Alignment::Onset, over_position: Alignment::Landmarks }
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

    /// How the figure of that id shows its means: all of them by the longest choice that its id
    /// begins with, else each as is the default for it.
    pub fn alignments(&self, id: &str) -> Alignments {
        let cuts = id.match_indices('.').map(|(at, _)| &id[..at]);
        let chosen =
            std::iter::once("").chain(cuts).chain([id]).filter_map(|part| self.alignment.get(part));
        // Cuts rise along the id: the last is the longest.
        chosen.copied().last().map_or_else(Alignments::default, Alignments::both)
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
            assert_eq!(figures.alignments(id), Alignments::both(expect), "{id}");
        }
        let none = Figures::default().alignments("modes.P01.S01.spring");
        assert_eq!((none.over_time, none.over_position), (onset, landmarks));
    }
}
