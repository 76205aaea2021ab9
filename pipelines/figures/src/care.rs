//! Doubts about the trials of a figure, in a note below it.

use crate::About;
use crate::words::plain;
use std::collections::{BTreeMap, BTreeSet};
use zwidth_draw::Figure;

/// Something found in a trial that is in the figure all the same.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Found {
    /// The trial's number.
    pub trial: u32,
    /// The column in which it was found; empty if it is about the whole trial.
    pub column: String,
    /// What it is, a phrase.
    pub what: String,
}

/// Trials that a note names before it counts the others.
const NAMED: usize = 8;

/// The figure with a note for each column in which something was found: the trials, and what was
/// found in the first.
#[must_use]
pub fn with_care(mut figure: Figure, findings: &[Found]) -> Figure {
    let mut columns: BTreeMap<&str, Vec<&Found>> = BTreeMap::new();
    for finding in findings {
        columns.entry(&finding.column).or_default().push(finding);
    }
    let notes = columns.into_iter().map(|(column, findings)| note(column, &findings));
    figure.footnotes.extend(notes);
    figure
}

/// The figure with a note that says that position, velocity and force are projections, in a study with axes.
#[must_use]
pub fn with_push(mut figure: Figure, about: &About) -> Figure {
    let notes = about.push.map(|[x, y, z]| {
        format!("Along push: position, velocity and force are projections on [{x}, {y}, {z}].")
    });
    figure.footnotes.extend(notes);
    figure
}

/// The figure with a note that says that of so many trials not every sample is drawn, those of more
/// than `most`.
#[must_use]
pub fn with_thinned(mut figure: Figure, trials: usize, most: usize) -> Figure {
    let recordings =
        if trials == 1 { "a recording".to_owned() } else { format!("{trials} recordings") };
    let note = format!(
        "Of {recordings} of more than {most} samples the extremes of each short stretch are drawn, not every sample"
    );
    figure.footnotes.extend((trials > 0).then(|| plain(&note)));
    figure
}

fn note(column: &str, findings: &[&Found]) -> String {
    // A trial may have several findings in a column.
    let trials: BTreeSet<u32> = findings.iter().map(|finding| finding.trial).collect();
    let named: Vec<String> = trials.iter().take(NAMED).map(u32::to_string).collect();
    let more = match trials.len().saturating_sub(NAMED) {
        0 => String::new(),
        n => format!(" and {n} more"),
    };
    let word = if trials.len() == 1 { "trial" } else { "trials" };
    let Found { trial, what, .. } = findings[0];
    let first = if trials.len() == 1 { String::new() } else { format!("in trial {trial}, ") };
    let column = if column.is_empty() { String::new() } else { format!(" ({column})") };
    plain(&format!("Read with care {word} {}{more}{column}: {first}{what}", named.join(", ")))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn found(trial: u32, column: &str) -> Found {
        let what = format!("the velocity is {trial} times the angle's derivative");
        Found { trial, column: column.to_owned(), what }
    }

    #[test]
    fn a_note_names_the_column_the_trials_and_what_was_found_in_the_first() {
        let note = |findings: &[Found]| {
            let figure = with_care(Figure::default(), findings);
            zwidth_draw::markup::typed(&figure.footnotes[0])
        };
        let expect =
            "Read with care trial 3 (theta_rad): the velocity is 3 times the angle's derivative";
        assert_eq!(note(&[found(3, "theta_rad")]), expect);
        let many: Vec<Found> = (1..=10).map(|trial| found(trial, "t_s")).collect();
        let expect = "Read with care trials 1, 2, 3, 4, 5, 6, 7, 8 and 2 more (t_s): in trial 1, ";
        assert!(note(&many).starts_with(expect), "{}", note(&many));
        let whole = note(&[found(3, "")]);
        assert!(whole.starts_with("Read with care trial 3: the velocity"), "{whole}");
        let two = with_care(Figure::default(), &[found(1, "b"), found(2, "a")]);
        assert_eq!(two.footnotes.len(), 2);
    }

    #[test]
    fn a_figure_of_which_nothing_was_found_stays_as_it_is() {
        assert!(with_care(Figure::default(), &[]).footnotes.is_empty());
        assert!(with_thinned(Figure::default(), 0, 9).footnotes.is_empty());
        let thinned = with_thinned(Figure::default(), 2, 9);
        assert!(thinned.footnotes[0].starts_with("Of 2 recordings of more than 9 samples"));
    }
}
