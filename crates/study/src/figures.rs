//! What a study chooses for its figures.

use crate::words::words;
use std::collections::BTreeMap;

words! {
    /// How repeats are made to meet before they are averaged against time (`zwidth_average` defines
    /// both). Force against position is averaged at the angle.
    Alignment {
        /// At movement onset: t is each repeat's own time since then.
        Onset = "onset",
        /// By landmarks: each repeat's time is warped, piecewise linearly, so that its landmarks
        /// (start, wall contact, reversal, return, end) meet their mean times. What repeats do at
        /// different times is then not smeared.
        Landmarks = "landmarks",
    }
}

/// Which sessions have figures of their own.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub enum OwnFigures {
    /// All figures of a small study. No figures of a study with more than
    /// [`Figures::MOST_SESSIONS`] sessions: they would fill a disk, and nobody looks at them.
    #[default]
    OfSmallStudies,
    /// All, however many.
    All,
    /// Those named: participant and session.
    Of(Vec<[String; 2]>),
}

/// Choices for figures: for all of them, for those of a kind, or for one.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct Figures {
    /// Which sessions have figures of their own.
    pub own: OwnFigures,
    /// Files of the font in which they are set, below the study's folder: one, or one for each of
    /// upright, italic and bold. None: in the program's own.
    pub font: Vec<String>,
    /// By the beginning of a figure's id, cut at a dot; the empty text stands for every figure.
    pub(crate) alignment: BTreeMap<String, Alignment>,
}

impl Figures {
    /// The kinds of figures that show a mean of repeats. Figures are called
    /// `modes.<participant>.<session>.<environment>` and `loops.<participant>.<session>`. What stands
    /// against position knows no alignment; one for `loops` was once chosen, and is read still.
    pub(crate) const WITH_MEANS: [&'static str; 2] = ["modes", "loops"];

    /// How many files a font may have.
    pub const MOST_FONT_FILES: usize = 3;

    /// A study of more sessions has no figures of each unless it asks for them: those of 50
    /// sessions of 36 trials took 560 MB.
    pub const MOST_SESSIONS: usize = 24;

    /// Whether a session of a study with this many sessions has figures of its own.
    pub fn has_own(&self, [participant, session]: &[String; 2], sessions: usize) -> bool {
        match &self.own {
            OwnFigures::All => true,
            OwnFigures::OfSmallStudies => sessions <= Self::MOST_SESSIONS,
            OwnFigures::Of(named) => named.iter().any(|[p, s]| p == participant && s == session),
        }
    }

    /// How the figure of that id aligns its means against time: by the longest choice that its id
    /// begins with, else at onset, as the thesis' mean of six.
    pub fn alignment(&self, id: &str) -> Alignment {
        let cuts = id.match_indices('.').map(|(at, _)| &id[..at]);
        let chosen =
            std::iter::once("").chain(cuts).chain([id]).filter_map(|part| self.alignment.get(part));
        // Cuts rise along the id: the last is the longest.
        chosen.copied().last().unwrap_or(Alignment::Onset)
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
    fn sessions_of_a_large_study_have_figures_of_their_own_where_it_asks_for_them() {
        let ids = |p: &str, s: &str| [p.to_owned(), s.to_owned()];
        let has = |own: &OwnFigures, id: [String; 2], sessions| {
            Figures { own: own.clone(), ..Figures::default() }.has_own(&id, sessions)
        };
        let usual = OwnFigures::default();
        assert!(has(&usual, ids("P01", "S01"), 24) && !has(&usual, ids("P01", "S01"), 25));
        assert!(has(&OwnFigures::All, ids("P900", "S01"), 1000));
        let named = OwnFigures::Of(vec![ids("P02", "S01")]);
        assert!(has(&named, ids("P02", "S01"), 1000) && !has(&named, ids("P02", "S02"), 2));
    }

    #[test]
    fn the_choice_nearest_to_a_figure_counts() {
        let chosen = |choices: &[(&str, Alignment)]| Figures {
            alignment: choices.iter().map(|(id, a)| ((*id).to_owned(), *a)).collect(),
            ..Figures::default()
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
