//! Whether the analysis is the one that was planned before the data were taken.

use serde::Serialize;
use zwidth_tables::NoteKind;

/// What a plan says of the analysis that is made.
#[derive(Debug, Clone, PartialEq, Eq, Default, Serialize)]
pub struct Preregistered {
    /// BLAKE3 of the plan's file, hexadecimal; empty where it cannot be read.
    pub blake3: String,
    /// What is otherwise than planned, each in words.
    pub deviations: Vec<String>,
    /// How many participants were planned.
    pub participants: Option<u64>,
    /// How many trials were there when the plan was written.
    pub trials_before: Option<u64>,
}

impl Preregistered {
    /// The plan and its deviations in words, where `took_part` participants took part.
    pub(crate) fn note(&self, took_part: usize) -> (NoteKind, String) {
        let start: String = self.blake3.chars().take(12).collect();
        let hash = if start.is_empty() { start } else { format!(", BLAKE3 {start}…") };
        let sample = self
            .participants
            .map(|planned| format!(" Participants: {planned} planned, {took_part} with trials."));
        let late = self.trials_before.filter(|trials| *trials > 0).map(|trials| {
            format!(" The plan was written when {trials} trials were there already.")
        });
        let (kind, verdict) = match self.deviations.as_slice() {
            [] => (NoteKind::General, format!("As planned (plan.json{hash}).")),
            all => {
                let all = all.join("; ");
                (NoteKind::Care, format!("Not as planned (plan.json{hash}): {all}."))
            }
        };
        (kind, [Some(verdict), sample, late].into_iter().flatten().collect())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn plan(deviations: &[&str], trials_before: u64) -> Preregistered {
        Preregistered {
            blake3: "0123456789abcdef".to_owned(),
            deviations: deviations.iter().map(|d| (*d).to_owned()).collect(),
            participants: Some(12),
            trials_before: Some(trials_before),
        }
    }

    #[test]
    fn an_analysis_as_planned_says_so_with_who_is_still_missing() {
        let (kind, text) = plan(&[], 0).note(6);
        assert_eq!(kind, NoteKind::General);
        let expected = "As planned (plan.json, BLAKE3 0123456789ab…). Participants: 12 planned, 6 with trials.";
        assert_eq!(text, expected);
    }

    #[test]
    fn a_deviation_and_a_plan_after_the_data_are_named() {
        let (kind, text) = plan(&["alpha was 0.05, is 0.01"], 36).note(12);
        assert_eq!(kind, NoteKind::Care);
        assert!(text.starts_with("Not as planned") && text.contains("alpha was 0.05, is 0.01."));
        assert!(text.ends_with("when 36 trials were there already."), "{text}");
    }
}
