//! What figures say about a study besides recorded and derived data, and what each says about
//! itself.

use serde::Serialize;
use std::ops::Not;
use zwidth_study::{Coordinate, DoseCurve, Factor, Mode, REFERENCE, Study};

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
    /// Whether its trials record a set-point of the angle.
    pub has_reference: bool,
    /// Whether claims rest on several metrics.
    #[serde(skip_serializing_if = "Not::not")]
    pub has_several_primary: bool,
    /// What modes and environments have in common.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub factors: Vec<Factor>,
    /// The direction on which position and force are projections, in a study with axes.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub push: Option<[f64; 3]>,
    /// Curves over those of them that are doses.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub dose_curves: Vec<DoseCurve>,
}

impl About {
    /// That of a study.
    pub fn of(study: &Study) -> Self {
        Self {
            title: study.title.clone(),
            coordinate: study.coordinate,
            confidence: study.analysis.confidence,
            modes: study.modes.clone(),
            has_reference: study.channels.iter().any(|channel| channel.id.as_str() == REFERENCE),
            has_several_primary: study.compare.primary.are_several(),
            factors: study.factors.clone(),
            push: study.axes.as_ref().map(|axes| axes.push),
            dose_curves: study.dose_curves(),
        }
    }
}

/// What figures of a kind are called and show; each file of this crate that draws a study's figure
/// has its own.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct FigureKind {
    /// The first word of its files' names.
    pub stem: &'static str,
    /// What it shows.
    pub shows: &'static str,
    /// What one of the things is called that it is drawn from.
    pub drawn_from: &'static str,
}

impl FigureKind {
    pub(crate) const fn new(
        stem: &'static str,
        shows: &'static str,
        drawn_from: &'static str,
    ) -> Self {
        Self { stem, shows, drawn_from }
    }
}

impl Serialize for FigureKind {
    fn serialize<S: serde::Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.serialize_str(self.stem)
    }
}

/// What a figure says about itself.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
pub struct Caption {
    /// What it shows.
    pub kind: FigureKind,
    /// Of whom or what: `["P01", "S01", "spring"]`; nothing for the study.
    pub subject: Vec<String>,
    /// How many trials, sweeps or answers it is drawn from; `None` if it is drawn from a plan.
    pub n: Option<usize>,
}

impl Caption {
    /// That of a figure of a kind.
    pub fn new(kind: FigureKind, subject: impl IntoIterator<Item = impl Into<String>>) -> Self {
        Self { kind, subject: subject.into_iter().map(Into::into).collect(), n: None }
    }

    /// The stem of its files' names: `modes.P01.S01.spring`.
    pub fn stem(&self) -> String {
        let first = self.kind.stem.to_owned();
        [first].into_iter().chain(self.subject.iter().cloned()).collect::<Vec<_>>().join(".")
    }

    /// What it shows and of whom, in words.
    pub fn text(&self) -> String {
        let what = self.kind.shows;
        let who = Some(self.subject.join(" ")).filter(|who| !who.is_empty());
        let count = self
            .n
            .map(|n| format!("{n} {}{}", self.kind.drawn_from, if n == 1 { "" } else { "s" }));
        let about: Vec<String> = who.into_iter().chain(count).collect();
        match about.is_empty() {
            true => what.to_owned(),
            false => format!("{what} ({})", about.join(", ")),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{LIKERT, MODES, RENDERING_RANGE};

    #[test]
    fn a_caption_gives_the_files_their_name_and_the_reader_a_line() {
        let modes = Caption::new(MODES, ["P01", "S01", "spring"]);
        assert_eq!(modes.stem(), "modes.P01.S01.spring");
        assert!(modes.text().ends_with("force against position (P01 S01 spring)"));
        let of = Caption { n: Some(18), ..modes };
        assert!(of.text().ends_with("(P01 S01 spring, 18 trials)"), "{}", of.text());
        let tally = Caption { n: Some(1), ..Caption::new(LIKERT, [""; 0]) };
        assert!(tally.text().ends_with("(1 answer)"), "{}", tally.text());
        let range = Caption::new(RENDERING_RANGE, [""; 0]);
        assert_eq!((range.stem().as_str(), range.text().contains('(')), ("rendering_range", false));
    }
}
