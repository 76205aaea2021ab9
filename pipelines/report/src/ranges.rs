//! Whether the stiffnesses of two modes were fitted over the same range of angles.

use crate::columns::{SATURATION, STIFFNESS};
use crate::trials::Trials;
use zwidth_study::{Setup, in_a_sentence};
use zwidth_tables::{Measured, TableError};

/// A sentence per environment in which the line of stiffness ends at a saturation in most trials of
/// one mode and not in most of another: it is then fitted over a smaller range of angles, and if a
/// force bends, that alone makes the two differ.
///
/// # Errors
/// A table that lacks a column.
pub fn uneven_ranges(study: &Setup, metrics: &Measured) -> Result<Vec<String>, TableError> {
    let mut sentences = Vec::new();
    for environment in &study.environments {
        let mut cut = Vec::new();
        let mut whole = Vec::new();
        for mode in &study.modes {
            let trials = Trials::of(metrics, Some(&environment.id), &mode.id);
            let fitted = trials.floats(STIFFNESS)?.len();
            let saturated = trials.floats(SATURATION)?.len();
            let share =
                format!("{saturated} of {fitted} trials with {}", in_a_sentence(&mode.label));
            match fitted {
                0 => {}
                // In more than half of the trials.
                n if 2 * saturated > n => cut.push(share),
                _ => whole.push(share),
            }
        }
        if !cut.is_empty() && !whole.is_empty() {
            sentences.push(format!(
                "{}: the line of stiffness ends at a saturation in {}, but in only {}; the other \
                 lines go over all of the compression. Where a force bends, the range alone makes \
                 modes differ in stiffness.",
                environment.label,
                cut.join(", "),
                whole.join(", ")
            ));
        }
    }
    Ok(sentences)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::trials::testing::{MetricsRow, metrics, row};

    fn said(rows: &[MetricsRow]) -> Vec<String> {
        uneven_ranges(&Setup::of(&zwidth_testing::study()), &metrics(rows)).unwrap()
    }

    #[test]
    fn a_line_that_is_cut_short_in_one_mode_alone_is_told() {
        let line = |mode: &'static str, saturation| MetricsRow {
            stiffness: Some(4.0),
            saturation,
            ..row("spring", mode)
        };
        let (cut, whole) = (Some(3.0), None);
        let uneven = [
            line("active", cut),
            line("active", cut),
            line("passive", whole),
            line("passive", cut),
        ];
        let told = said(&uneven);
        assert!(
            told[0].contains("2 of 2 trials with active, but in only 1 of 2 trials with passive"),
            "{told:?}"
        );
        assert!(said(&[line("active", cut), line("passive", cut)]).is_empty());
        assert!(said(&[line("active", whole), line("passive", whole)]).is_empty());
        let unfitted = MetricsRow { stiffness: None, ..row("spring", "passive") };
        assert!(said(&[line("active", cut), unfitted]).is_empty());
    }
}
