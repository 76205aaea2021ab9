//! The table of the thesis' statements in sentences.

use crate::evidence::Verdict;
use serde::Serialize;
use zwidth_tables::{Table, TableError, number, with_unit};

/// A judged statement in words, and the file that shows it. All texts are plain.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
pub struct Told {
    /// What the thesis says.
    pub statement: String,
    /// Where: `§5.3.1.1`.
    pub source: String,
    /// `supported`, `contradicted` or `undecided`.
    pub verdict: String,
    /// What was measured and what was asked for, sentences.
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

/// How many statements have which verdict, with the table's notes where any is judged, and then
/// each that is judged, in the table's order.
///
/// # Errors
/// A table that is not that of the statements.
pub fn told(table: &Table) -> Result<(String, Vec<Told>), TableError> {
    let text = |name: &str| -> Result<Vec<String>, TableError> {
        Ok(table.texts(name)?.into_iter().map(Option::unwrap_or_default).collect())
    };
    let (verdicts, statements, sources) = (text("verdict")?, text("statement")?, text("source")?);
    let (metrics, asked, remarks) = (text("metric")?, text("asked")?, text("remark")?);
    let (units, over, paths) = (text("unit")?, text("unit_of_analysis")?, text("shown")?);
    let (value, n) = (table.floats("value")?, table.integers("n")?);
    let (low, high) = (table.floats("ci_low")?, table.floats("ci_high")?);
    let mut told = Vec::new();
    for row in 0..table.height() {
        if verdicts[row] == Verdict::NotMeasured.as_str() {
            continue;
        }
        let ends = low[row].zip(high[row]);
        let error = ends.map(|(low, high)| (high - low) / 4.0);
        let amount =
            value[row].map(|value| format!(": {}", with_unit(&number(value, error), &units[row])));
        let interval = ends.map(|(low, high)| {
            format!("interval {} to {}", number(low, error), number(high, error))
        });
        let counted = n[row].map(|n| format!("n = {n} {}", over[row]));
        let remark = (!remarks[row].is_empty()).then(|| remarks[row].clone());
        let known: Vec<String> = [interval, counted, remark].into_iter().flatten().collect();
        let known =
            if known.is_empty() { known.concat() } else { format!(" ({})", known.join("; ")) };
        let evidence = format!(
            "{}{}{known}; asked: {}.",
            capital(&metrics[row]),
            amount.unwrap_or_default(),
            asked[row],
        );
        told.push(Told {
            statement: statements[row].clone(),
            source: sources[row].clone(),
            verdict: verdicts[row].clone(),
            evidence,
            path: paths[row].clone(),
        });
    }
    let notes = table.notes().iter().filter(|_| !told.is_empty()).cloned();
    let said: Vec<String> = [counts(&verdicts)].into_iter().chain(notes).collect();
    Ok((said.join(" "), told))
}

/// `Of 58 statements 20 are supported, 5 contradicted, 3 undecided, and 30 not measured.`
fn counts(verdicts: &[String]) -> String {
    let count = |verdict: Verdict| verdicts.iter().filter(|v| *v == verdict.as_str()).count();
    let [supported, contradicted, undecided, not_measured] = Verdict::ALL.map(count);
    format!(
        "Of {} statements, {supported} are supported, {contradicted} contradicted, {undecided} undecided, and \
         {not_measured} not measured.",
        verdicts.len()
    )
}

fn capital(text: &str) -> String {
    let mut letters = text.chars();
    let first = letters.next().map(|first| first.to_uppercase().to_string());
    first.unwrap_or_default() + letters.as_str()
}
