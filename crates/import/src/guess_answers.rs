//! A table of answers, guessed: a mapping of `kind = "likert"` for a questionnaire, or for the
//! output of PsychoPy.

use super::guess_names::Names;
use super::guess_read::{LOOKED_AT, first_numbers, is_number, quoted};
use super::guess_words::{
    ANSWERS, ColumnName, QUESTIONS, are_answers, has_word, label_of, parse_name,
};
use super::spelling::is_missing;
use super::table::{Cell, Cells, Table};
use std::collections::BTreeSet;
use std::fmt::Write as _;
use zwidth_store::Signal;

/// Columns that PsychoPy writes beside those of a study.
pub(super) const PSYCHOPY: [&str; 4] = ["psychopyVersion", "expName", "frameRate", "expStart"];
/// The ending of PsychoPy's columns that count the rows of a loop from 0.
pub(super) const LOOP: &str = ".thisN";
/// Endings of columns of answers, and of the times that they took.
const ANSWERED: [&str; 2] = [".response", ".rating"];
pub(super) const TOOK: &str = ".rt";

/// Words of columns of numbers that are no answers.
const ABOUT: [&str; 12] = [
    "age",
    "alter",
    "order",
    "number",
    "index",
    "id",
    "year",
    "date",
    "duration",
    "gender",
    "sex",
    "timestamp",
];
/// Answers are from here to there: a visual analogue scale has numbers from 0 to 100.
const SCALES: std::ops::RangeInclusive<f64> = -50.0..=100.0;

/// The columns of a table of answers, by their places.
pub(super) struct Answers {
    /// Keys under `[trial]`, each with its column.
    labels: Vec<(&'static str, usize)>,
    /// Columns that may be such too.
    others: Vec<(&'static str, usize)>,
    /// Why none of PsychoPy's loops numbers the trials, if it has some.
    no_loop: Option<String>,
    form: Form,
}

enum Form {
    /// A column a question, with that of the times that its answers took.
    Wide(Vec<(usize, Option<usize>)>),
    /// A column of JSON objects, a key a question, as jsPsych writes them; whether a 0 is among their
    /// values.
    Json { place: usize, keys: Vec<String>, from_zero: bool },
    /// A row an answer: the columns of the questions and of the answers.
    Long { question: usize, answer: usize },
}

/// Finds the columns of a table of answers; `None` if the table is a recording.
pub(super) fn answers(table: &Table, decimal_comma: bool) -> Option<Answers> {
    let names = table.names.as_ref()?;
    let is_psychopy =
        names.iter().any(|name| PSYCHOPY.contains(&name.as_str()) || name.ends_with(LOOP));
    let (mut labels, mut others): (Vec<(&'static str, usize)>, Vec<_>) = (Vec::new(), Vec::new());
    let mut loops = Vec::new();
    for (place, name) in names.iter().enumerate() {
        let key = match label_of(name) {
            _ if is_psychopy && name.ends_with(LOOP) => {
                loops.push(place);
                None
            }
            // The loops of PsychoPy are called as their author likes.
            Some(_) if is_psychopy && name.contains('.') => None,
            // jsPsych's kind of screen.
            Some(_) if name == "trial_type" => None,
            key => key,
        };
        let Some(key) = key else { continue };
        match labels.iter().any(|(other, _)| *other == key) {
            true => others.push((key, place)),
            false => labels.push((key, place)),
        }
    }
    let mut free: Vec<usize> = (0..names.len()).collect();
    free.retain(|place| {
        let is_label = labels.iter().chain(&others).any(|(_, label)| label == place);
        !is_label && !loops.contains(place) && !names[*place].is_empty()
    });
    let mut questions = free.clone();
    // PsychoPy marks answers by the ending of the name; words are a guess for other tables.
    questions.retain(|place| ANSWERED.iter().any(|end| names[*place].ends_with(end)));
    if questions.is_empty() {
        questions.clone_from(&free);
        questions.retain(|place| {
            is_called(&names[*place], &ANSWERS)
                && !names[*place].ends_with(TOOK)
                && is_number(&table.columns[*place], decimal_comma)
        });
    }
    let question = free.iter().copied().find(|place| {
        is_called(&names[*place], &QUESTIONS) && !is_number(&table.columns[*place], decimal_comma)
    });
    if !is_psychopy {
        let is_recording = free.iter().any(|place| {
            let cells = &table.columns[*place];
            let ColumnName { signal, unit, .. } = parse_name(&names[*place]);
            match signal {
                None => false,
                // Reaction times go up and down; a clock goes up from most rows to the next.
                Some(Signal::Time) => {
                    let times = first_numbers(cells, decimal_comma).into_iter().flatten();
                    let times: Vec<f64> = times.collect();
                    let rises = times.windows(2).filter(|t| t[1] > t[0]).count();
                    2 * rises > times.len().max(2)
                }
                Some(_) => {
                    is_number(cells, decimal_comma)
                        && (unit.is_some() || !is_scale(&names[*place], cells, decimal_comma))
                }
            }
        });
        let has_participant = labels.iter().any(|(key, _)| *key == "participant");
        if is_recording || !(has_participant || are_answers(names)) {
            return None;
        }
    }
    let objects = free.iter().find_map(|place| objects(&table.columns[*place], *place));
    let form = match (question, questions.as_slice(), objects) {
        // Columns of answers go before objects, which may hold anything else.
        (_, [], Some(objects)) => objects,
        (Some(question), [answer], _) => Form::Long { question, answer: *answer },
        _ => {
            if questions.is_empty() {
                questions = free;
                questions.retain(|at| is_scale(&names[*at], &table.columns[*at], decimal_comma));
            }
            let columns = questions.iter().map(|place| {
                let time = names[*place].rsplit_once('.').and_then(|(stem, _)| {
                    names.iter().position(|name| name.strip_suffix(TOOK) == Some(stem))
                });
                (*place, time)
            });
            Form::Wide(columns.collect())
        }
    };
    if matches!(&form, Form::Wide(columns) if columns.is_empty()) {
        return None;
    }
    let mut no_loop = None;
    if !loops.is_empty() && labels.iter().all(|(key, _)| *key != "trial") {
        match loop_of_trials(table, &form, &labels, &loops) {
            Ok(place) => labels.push(("trial", place)),
            Err(why) => no_loop = Some(why),
        }
    }
    Some(Answers { labels, others, no_loop, form })
}

/// Whether a name has one of the words.
fn is_called(name: &str, listed: &[&str]) -> bool {
    has_word(&parse_name(name).words, listed)
}

/// Whether a column holds answers on a scale: whole numbers from a range, of which its name says
/// nothing else.
fn is_scale(name: &str, cells: &Cells, decimal_comma: bool) -> bool {
    let numbers = first_numbers(cells, decimal_comma);
    is_number(cells, decimal_comma)
        && numbers.iter().flatten().all(|n| n.fract() == 0.0 && SCALES.contains(n))
        && !is_called(name, &ABOUT)
}

/// The loop that numbers the trials: it counts every row with an answer, and none as another of its session.
///
/// # Errors
/// The number of rows that each loop counts, in words.
fn loop_of_trials(
    table: &Table,
    form: &Form,
    labels: &[(&str, usize)],
    loops: &[usize],
) -> Result<usize, String> {
    let places = form.answers();
    let rows = places.first().map_or(0, |place| table.columns[*place].len());
    let answered: Vec<usize> = (0..rows)
        .filter(|row| {
            places.iter().any(|place| match table.columns[*place].cell(*row) {
                Cell::Empty => false,
                Cell::Text(text) => !is_missing(text),
                Cell::Number(number) => !number.is_nan(),
            })
        })
        .collect();
    let session = labels.iter().filter(|(key, _)| ["participant", "session"].contains(key));
    let session: Vec<usize> = session.map(|(_, place)| *place).collect();
    let mut counts = Vec::new();
    for place in loops {
        let filled = answered.iter().filter(|row| table.columns[*place].cell(**row) != Cell::Empty);
        let keys = filled.map(|row| {
            let places = session.iter().chain([place]);
            places.map(|place| table.columns[*place].cell(*row).to_string()).collect::<Vec<_>>()
        });
        let count = keys.collect::<BTreeSet<_>>().len();
        if count == answered.len() {
            return Ok(*place);
        }
        counts.push(format!("{count} ({})", table.name(*place)));
    }
    let n = answered.len();
    Err(format!("of {n} rows with an answer it tells apart {}", counts.join(", ")))
}

impl Form {
    /// The columns of the answers.
    fn answers(&self) -> Vec<usize> {
        match self {
            Form::Wide(columns) => columns.iter().map(|(place, _)| *place).collect(),
            Form::Json { place, .. } => vec![*place],
            Form::Long { answer, .. } => vec![*answer],
        }
    }
}

/// The keys of the JSON objects in a column, if one of its first cells holds one.
fn objects(cells: &Cells, place: usize) -> Option<Form> {
    let mut keys = Vec::new();
    let mut from_zero = false;
    for row in 0..cells.len().min(LOOKED_AT) {
        let Cell::Text(text) = cells.cell(row) else { continue };
        let Ok(object) = serde_json::from_str::<serde_json::Map<_, _>>(text) else { continue };
        for (key, value) in object {
            // jsPsych numbers answers from 0, where a study's scale begins at 1.
            from_zero |= value == serde_json::json!(0);
            if !keys.contains(&key) {
                keys.push(key);
            }
        }
    }
    (!keys.is_empty()).then_some(Form::Json { place, keys, from_zero })
}

impl Answers {
    /// Writes the rest of `[file]`, and what follows it.
    pub(super) fn write(&self, text: &mut String, table: &Table, names: &Names) {
        if let Some((row, why)) = table.bad.first() {
            let count = table.bad.len();
            let _ =
                writeln!(text, "bad_lines = {count}           # the first: row {}: {why}", row + 1);
        }
        if self.has_gaps(table) {
            text.push_str("missing = \"drop\"       # some rows lack a label or an answer\n");
        }
        let mut names = names.clone();
        for (key, place) in &self.labels {
            names.labels.insert(*key, format!("{{ column = {} }}", column(table, *place)));
        }
        names.write(text, "\"TODO\"     # a code");
        if let Some(why) = &self.no_loop {
            let _ = writeln!(text, "# no trial, as no loop numbers all: {why}");
        }
        for (key, place) in &self.others {
            let from = column(table, *place);
            let _ = writeln!(
                text,
                "# another {key}: {from}. If a row holds several conditions, write a [[condition]] for each"
            );
        }
        match &self.form {
            Form::Long { question, answer } => {
                let _ = writeln!(
                    text,
                    "\n[questions]\n# its words are ids of study.toml, or are translated to them: translate = {{ … }}\n\
                     question = {{ column = {} }}\nanswer = {}",
                    column(table, *question),
                    column(table, *answer)
                );
            }
            Form::Json { place, keys, from_zero } => {
                if *from_zero {
                    text.push_str("\n[questions]\nlowest = 0           # their number for the lowest answer\n");
                }
                text.push_str(QUESTIONS_TO_DO);
                for key in keys {
                    let column = column(table, *place);
                    let named = quoted(key);
                    let _ =
                        writeln!(text, "{} = {{ column = {column}, key = {named} }}", id(key, 0));
                }
            }
            Form::Wide(columns) => {
                let times = columns.iter().filter_map(|(place, time)| Some((*place, (*time)?)));
                let times: Vec<(usize, usize)> = times.collect();
                let id = |place| id(&table.full_name(place), place);
                if !times.is_empty() {
                    text.push_str("\n[questions]\ntime_unit = \"s\"\n");
                }
                text.push_str(QUESTIONS_TO_DO);
                for (place, _) in columns {
                    let _ = writeln!(text, "{} = {}", id(*place), column(table, *place));
                }
                if !times.is_empty() {
                    text.push_str("\n[questions.times]\n");
                }
                for (place, time) in times {
                    let _ = writeln!(text, "{} = {}", id(place), column(table, time));
                }
            }
        }
    }

    /// Whether a row lacks a label or an answer.
    fn has_gaps(&self, table: &Table) -> bool {
        let mut answers = self.form.answers();
        match &self.form {
            Form::Wide(_) => {}
            // jsPsych has a row for each screen.
            Form::Json { .. } => return true,
            Form::Long { question, .. } => answers.push(*question),
        }
        let answers = answers.into_iter().map(|place| (place, true));
        let labels = self.labels.iter().map(|(_, place)| (*place, false));
        answers.chain(labels).any(|(place, is_answer)| {
            let cells = &table.columns[place];
            (0..cells.len()).any(|row| match cells.cell(row) {
                Cell::Empty => true,
                Cell::Text(text) => is_answer && is_missing(text),
                Cell::Number(number) => number.is_nan(),
            })
        })
    }
}

/// A column as a mapping names it: by its name, or by its position from 1.
pub(super) fn column(table: &Table, place: usize) -> String {
    let name = table.names.as_ref().and_then(|names| names.get(place));
    name.map_or_else(|| (place + 1).to_string(), |name| quoted(name))
}

/// The head of the questions' columns.
const QUESTIONS_TO_DO: &str =
    "\n[questions.columns]\n# TODO: on the left, the ids of the questions in study.toml\n";

/// An id for the question of a column: its name in small letters, as far as an id holds it.
fn id(name: &str, place: usize) -> String {
    let name = name.to_lowercase();
    let words = name.split(|l: char| !l.is_ascii_alphanumeric()).filter(|word| !word.is_empty());
    let words: Vec<&str> = words.collect();
    let id: String = words.join("_").chars().take(LONGEST_ID).collect();
    if id.is_empty() { format!("question_{}", place + 1) } else { id }
}

/// Characters of an id.
const LONGEST_ID: usize = 32;
