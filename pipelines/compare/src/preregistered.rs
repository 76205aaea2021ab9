//! Whether study, data and analysis are as they were planned before the data were taken.

use serde::Serialize;
use zwidth_tables::NoteKind;

/// A plan's statements about the analysis.
#[derive(Debug, Clone, PartialEq, Eq, Default, Serialize)]
pub struct Preregistered {
    /// BLAKE3 of the plan's file, hexadecimal; empty if it cannot be read.
    pub blake3: String,
    /// The deviations from the plan, each in words.
    pub deviations: Vec<String>,
    /// Other things that a reader of the plan should know: whole sentences.
    pub remarks: Vec<String>,
    /// The planned number of participants.
    pub participants: Option<u64>,
    /// The number of trials when the plan was written.
    pub trials_before: Option<u64>,
}

impl Preregistered {
    /// The plan and its deviations in one note, where `took_part` participants took part.
    pub(crate) fn note(&self, took_part: usize) -> (NoteKind, String) {
        let verdict = match self.deviations.as_slice() {
            [] => format!("{}.", self.verdict()),
            all => format!("{}: {}.", self.verdict(), all.join("; ")),
        };
        let kind = if self.deviations.is_empty() { NoteKind::General } else { NoteKind::Care };
        let sentences: Vec<String> = [verdict].into_iter().chain(self.further(took_part)).collect();
        (kind, sentences.join(" "))
    }

    /// The plan and its deviations, each in a sentence, where `took_part` participants took part.
    pub fn sentences(&self, took_part: usize) -> Vec<String> {
        let deviations = self.deviations.iter().map(|deviation| format!("Deviation: {deviation}."));
        let verdict = format!("{}.", self.verdict());
        [verdict].into_iter().chain(deviations).chain(self.further(took_part)).collect()
    }

    fn verdict(&self) -> String {
        let start: String = self.blake3.chars().take(12).collect();
        let hash = if start.is_empty() { start } else { format!(", BLAKE3 {start}…") };
        let as_planned = if self.deviations.is_empty() { "As planned" } else { "Not as planned" };
        format!("{as_planned} (plan.json{hash})")
    }

    /// Sentences about what is no deviation and worth knowing all the same.
    fn further(&self, took_part: usize) -> Vec<String> {
        let sample = self
            .participants
            .map(|planned| format!("Participants: {planned} planned, {took_part} with trials."));
        let late = self
            .trials_before
            .filter(|trials| *trials > 0)
            .map(|trials| format!("The plan was written when {trials} trials were there already."));
        sample.into_iter().chain(late).chain(self.remarks.iter().cloned()).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn plan(deviations: &[&str], trials_before: u64) -> Preregistered {
        Preregistered {
            blake3: "0123456789abcdef".to_owned(),
            deviations: deviations.iter().map(|d| (*d).to_owned()).collect(),
            remarks: Vec::new(),
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

    #[test]
    fn each_deviation_is_a_sentence_of_its_own() {
        let remarks = vec!["A remark.".to_owned()];
        let plan =
            Preregistered { remarks, ..plan(&["alpha was 0.05, is 0.01", "1 trial more"], 3) };
        let expected = [
            "Not as planned (plan.json, BLAKE3 0123456789ab…).",
            "Deviation: alpha was 0.05, is 0.01.",
            "Deviation: 1 trial more.",
            "Participants: 12 planned, 6 with trials.",
            "The plan was written when 3 trials were there already.",
            "A remark.",
        ];
        assert_eq!(plan.sentences(6), expected);
        let whole = Preregistered { participants: None, deviations: Vec::new(), ..plan };
        assert_eq!(whole.sentences(6)[0], "As planned (plan.json, BLAKE3 0123456789ab…).");
    }
}
