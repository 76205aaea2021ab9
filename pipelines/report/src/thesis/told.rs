//! The table of the thesis' statements in sentences.

use serde::Serialize;
use zwidth_results::{ClaimVerdict, JudgedStatement};
use zwidth_tables::{number, with_unit};

/// A judged statement in words, and the file that shows it. All texts are plain.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
pub struct Told {
    /// What the thesis says.
    pub statement: String,
    /// Where: `§5.3.1.1`.
    pub source: String,
    /// `supported`, `contradicted` or `undecided`.
    pub verdict: String,
    /// The measured and the required values, in sentences.
    pub evidence: String,
    /// The file, from the summary's folder on, with `/`.
    pub path: String,
}

impl Told {
    /// All of it as a sentence.
    pub(crate) fn text(&self) -> String {
        format!("{} ({}): {}. {}", self.statement, self.source, self.verdict, self.evidence)
    }
}

/// How many statements have which verdict, with `notes` where any is judged, and then each that is
/// judged, in their order.
pub fn told(statements: &[JudgedStatement], notes: &[String]) -> (String, Vec<Told>) {
    let measured = statements.iter().filter(|of| of.verdict != ClaimVerdict::NotMeasured);
    let told: Vec<Told> = measured.map(in_words).collect();
    let notes = notes.iter().filter(|_| !told.is_empty()).cloned();
    let said: Vec<String> = [counts(statements)].into_iter().chain(notes).collect();
    (said.join(" "), told)
}

fn in_words(judged: &JudgedStatement) -> Told {
    let word = |text: &Option<String>| text.clone().unwrap_or_default();
    let ends = judged.ci_low.zip(judged.ci_high);
    let error = ends.map(|(low, high)| (high - low) / 4.0);
    let amount = judged
        .value
        .map(|value| format!(": {}", with_unit(&number(value, error), &word(&judged.unit))));
    let interval = ends
        .map(|(low, high)| format!("interval {} to {}", number(low, error), number(high, error)));
    let counted = judged.n.map(|n| format!("n = {n} {}", word(&judged.unit_of_analysis)));
    let known: Vec<String> = [interval, counted, judged.remark.as_ref().map(ToString::to_string)]
        .into_iter()
        .flatten()
        .collect();
    let known = if known.is_empty() { String::new() } else { format!(" ({})", known.join("; ")) };
    Told {
        statement: judged.statement.clone(),
        source: judged.source.clone(),
        verdict: judged.verdict.as_str().to_owned(),
        evidence: format!(
            "{}{}{known}; asked: {}.",
            capital(&word(&judged.metric)),
            amount.unwrap_or_default(),
            judged.asked.as_ref().map(ToString::to_string).unwrap_or_default(),
        ),
        path: word(&judged.shown),
    }
}

/// `Of 58 statements 20 are supported, 5 contradicted, 3 undecided, and 30 not measured.`
fn counts(statements: &[JudgedStatement]) -> String {
    let count = |verdict| statements.iter().filter(|of| of.verdict == verdict).count();
    format!(
        "Of {} statements, {} are supported, {} contradicted, {} undecided, and {} not measured.",
        statements.len(),
        count(ClaimVerdict::Supported),
        count(ClaimVerdict::Contradicted),
        count(ClaimVerdict::Undecided),
        count(ClaimVerdict::NotMeasured),
    )
}

fn capital(text: &str) -> String {
    let mut letters = text.chars();
    let first = letters.next().map(|first| first.to_uppercase().to_string());
    first.unwrap_or_default() + letters.as_str()
}
