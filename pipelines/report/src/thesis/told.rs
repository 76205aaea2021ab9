//! The table of the thesis' statements in sentences.

use crate::people::capital;
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
    let measured = statements.iter().filter(|row| row.verdict != ClaimVerdict::NotMeasured);
    let judged: Vec<Told> = measured.map(in_words).collect();
    let count = |verdict: ClaimVerdict| -> usize {
        statements.iter().filter(|row| row.verdict == verdict).count()
    };
    let counts = format!(
        "Of {} statements, {} are supported, {} contradicted, {} undecided, and {} not measured.",
        statements.len(),
        count(ClaimVerdict::Supported),
        count(ClaimVerdict::Contradicted),
        count(ClaimVerdict::Undecided),
        count(ClaimVerdict::NotMeasured)
    );
    let notes = notes.iter().filter(|_| !judged.is_empty()).cloned();
    let sentences: Vec<String> = [counts].into_iter().chain(notes).collect();
    (sentences.join(" "), judged)
}

fn in_words(judged: &JudgedStatement) -> Told {
    let [metric, unit, units, path] =
        [&judged.metric, &judged.unit, &judged.unit_of_analysis, &judged.shown]
            .map(|text| text.clone().unwrap_or_default());
    let ends = judged.ci_low.zip(judged.ci_high);
    // A 95 % interval is about four standard errors wide, which set the digits.
    let error = ends.map(|(low, high)| (high - low) / 4.0);
    let amount = judged.value.map(|value| format!(": {}", with_unit(&number(value, error), &unit)));
    let interval = ends
        .map(|(low, high)| format!("interval {} to {}", number(low, error), number(high, error)));
    let counted = judged.n.map(|n| format!("n = {n} {units}"));
    let remark = judged.remark.as_ref().map(ToString::to_string);
    let details: Vec<String> = [interval, counted, remark].into_iter().flatten().collect();
    let details =
        if details.is_empty() { String::new() } else { format!(" ({})", details.join("; ")) };
    Told {
        statement: judged.statement.clone(),
        source: judged.source.clone(),
        verdict: judged.verdict.as_str().to_owned(),
        evidence: format!(
            "{}{}{details}; asked: {}.",
            capital(&metric),
            amount.unwrap_or_default(),
            judged.asked.as_ref().map(ToString::to_string).unwrap_or_default(),
        ),
        path,
    }
}
