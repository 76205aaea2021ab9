//! A table of answers, guessed: a mapping of `kind = "likert"` for a questionnaire, or for the
//! output of PsychoPy.

use super::guess_names::Names;
use super::guess_read::{LOOKED_AT, first_numbers, is_number, quoted};
use super::guess_words::{ANSWERS, QUESTIONS, are_answers, label_of, said};
use super::spelling::is_missing;
use super::table::{Cell, Cells, Table};
use std::collections::BTreeSet;
use std::fmt::Write as _;
use zwidth_store::Signal;

/// How columns are called that PsychoPy writes beside those of a study.
const PSYCHOPY: [&str; 4] = ["psychopyVersion", "expName", "frameRate", "expStart"];
/// How its columns end that count a loop's rows from 0.
const LOOP: &str = ".thisN";
/// How columns of answers end, and those of the times that they took.
const ANSWERED: [&str; 2] = [".response", ".rating"];
const TOOK: &str = ".rt";

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

/// What is where in a table of answers. Columns are named by their place.
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

/// What is where, if a table is one of answers and no recording.
pub(super) fn answers(table: &Table, decimal_comma: bool) -> Option<Answers> {
    let names = table.names.as_ref()?;
    let is_numbers = |place: &usize| is_number(&table.columns[*place], decimal_comma);
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
        match labels.iter().any(|(known, _)| *known == key) {
            true => others.push((key, place)),
            false => labels.push((key, place)),
        }
    }
    let is_label = |place: &usize| {
        loops.contains(place) || labels.iter().chain(&others).any(|(_, label)| label == place)
    };
    let free = || (0..names.len()).filter(|place| !is_label(place) && !names[*place].is_empty());
    let says = |place: &usize, known: &[&str]| {
        let words = said(&names[*place]).words;
        words.iter().any(|word| known.contains(&word.as_str()))
    };
    let is_scale = |place: &usize| {
        let numbers = first_numbers(&table.columns[*place], decimal_comma);
        let on_scale = |number: &f64| number.fract() == 0.0 && SCALES.contains(number);
        is_numbers(place) && numbers.iter().flatten().all(on_scale) && !says(place, &ABOUT)
    };
    let mut asked: Vec<usize> =
        free().filter(|place| ANSWERED.iter().any(|end| names[*place].ends_with(end))).collect();
    if asked.is_empty() {
        let is_answer = |place: &usize| says(place, &ANSWERS) && !names[*place].ends_with(TOOK);
        asked = free().filter(is_answer).filter(is_numbers).collect();
    }
    let question = free().find(|place| says(place, &QUESTIONS) && !is_numbers(place));
    let has_participant = labels.iter().any(|(key, _)| *key == "participant");
    if !is_psychopy {
        let is_measured = |place: &usize| {
            let said = said(&names[*place]);
            let is_measured = said.signal.is_some_and(|signal| signal != Signal::Time);
            is_measured && is_numbers(place) && (said.unit.is_some() || !is_scale(place))
        };
        let is_clock = |place: &usize| {
            let numbers = first_numbers(&table.columns[*place], decimal_comma);
            let times: Vec<f64> = numbers.into_iter().flatten().collect();
            let rises = times.windows(2).filter(|t| t[1] > t[0]).count();
            said(&names[*place]).signal == Some(Signal::Time) && 2 * rises > times.len().max(2)
        };
        let is_recording = free().any(|place| is_measured(&place) || is_clock(&place));
        if is_recording || !(has_participant || are_answers(names)) {
            return None;
        }
    }
    let objects = free().find_map(|place| objects(&table.columns[place], place));
    let form = match (question, asked.as_slice(), objects) {
        (_, [], Some(objects)) => objects,
        (Some(question), [answer], _) => Form::Long { question, answer: *answer },
        _ => {
            if asked.is_empty() {
                asked = free().filter(is_scale).collect();
            }
            let time = |place: usize| {
                let (stem, _) = names[place].rsplit_once('.')?;
                names.iter().position(|name| name.strip_suffix(TOOK) == Some(stem))
            };
            Form::Wide(asked.iter().map(|place| (*place, time(*place))).collect())
        }
    };
    if matches!(&form, Form::Wide(columns) if columns.is_empty()) {
        return None;
    }
    let mut no_loop = None;
    if !loops.is_empty() && labels.iter().all(|(key, _)| *key != "trial") {
        match loop_of_all(table, &form, &labels, &loops) {
            Ok(place) => labels.push(("trial", place)),
            Err(why) => no_loop = Some(why),
        }
    }
    Some(Answers { labels, others, no_loop, form })
}

/// The loop that numbers the trials: it counts every row with an answer, and none as another of its session.
///
/// # Errors
/// How many of them each loop counts, in words.
fn loop_of_all(
    table: &Table,
    form: &Form,
    labels: &[(&str, usize)],
    loops: &[usize],
) -> Result<usize, String> {
    let places = form.answers();
    let is_answer = |cell: Cell| match cell {
        Cell::Empty => false,
        Cell::Text(text) => !is_missing(text),
        Cell::Number(number) => !number.is_nan(),
    };
    let rows = places.first().map_or(0, |place| table.columns[*place].len());
    let answered: Vec<usize> = (0..rows)
        .filter(|row| places.iter().any(|place| is_answer(table.columns[*place].cell(*row))))
        .collect();
    let session = |key: &str| ["participant", "session"].contains(&key);
    let session = labels.iter().filter(|(key, _)| session(key)).map(|(_, place)| *place);
    let session: Vec<usize> = session.collect();
    let counted = |place: usize| {
        let filled = answered.iter().filter(|row| table.columns[place].cell(**row) != Cell::Empty);
        let cells = |row: &usize| {
            let places = session.iter().chain([&place]);
            places.map(|place| table.columns[*place].cell(*row).to_string()).collect::<Vec<_>>()
        };
        filled.map(cells).collect::<BTreeSet<_>>().len()
    };
    let counts: Vec<(usize, usize)> = loops.iter().map(|place| (*place, counted(*place))).collect();
    if let Some((place, _)) = counts.iter().find(|(_, count)| *count == answered.len()) {
        return Ok(*place);
    }
    let told: Vec<String> =
        counts.iter().map(|(place, count)| format!("{count} ({})", table.name(*place))).collect();
    let n = answered.len();
    Err(format!("of {n} rows with an answer it tells apart {}", told.join(", ")))
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
        let column = |place: usize| {
            let name = table.names.as_ref().and_then(|names| names.get(place));
            name.map_or_else(|| (place + 1).to_string(), |name| quoted(name))
        };
        if let Some((row, why)) = table.bad.first() {
            let count = table.bad.len();
            let _ =
                writeln!(text, "bad_lines = {count}           # the first: row {}: {why}", row + 1);
        }
        if self.has_gaps(table) {
            text.push_str("missing = \"drop\"       # some rows lack a label or an answer\n");
        }
        let label = |key: &str| {
            let place = self.labels.iter().find(|(known, _)| *known == key)?.1;
            Some(format!("{{ column = {} }}", column(place)))
        };
        let fixed = |key: &str, named: &Option<String>, otherwise: &str| {
            label(key).or_else(|| named.clone()).unwrap_or_else(|| otherwise.to_owned())
        };
        let _ = write!(
            text,
            "{}\n[trial]\nparticipant = {}\nsession = {}\nenvironment = \"TODO\"     # as in study.toml\nmode = {}\n",
            names.block,
            fixed("participant", &names.participant, "\"TODO\"     # a code"),
            fixed("session", &names.session, "\"S01\""),
            fixed("mode", &names.mode, "\"TODO\"            # as in study.toml"),
        );
        for (key, named) in [("repeat", &names.repeat), ("trial", &names.trial)] {
            if let Some(label) = label(key).or_else(|| named.clone()) {
                let _ = writeln!(text, "{key} = {label}");
            }
        }
        if let Some(why) = &self.no_loop {
            let _ = writeln!(text, "# no trial, as no loop numbers all: {why}");
        }
        for (key, place) in &self.others {
            let from = column(*place);
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
                    column(*question),
                    column(*answer)
                );
            }
            Form::Json { place, keys, from_zero } => {
                if *from_zero {
                    text.push_str("\n[questions]\nlowest = 0           # their number for the lowest answer\n");
                }
                text.push_str(QUESTIONS_TO_DO);
                for key in keys {
                    let column = column(*place);
                    let named = quoted(key);
                    let _ =
                        writeln!(text, "{} = {{ column = {column}, key = {named} }}", id(key, 0));
                }
            }
            Form::Wide(columns) => {
                if columns.iter().any(|(_, time)| time.is_some()) {
                    text.push_str("\n[questions]\ntime_unit = \"s\"\n");
                }
                text.push_str(QUESTIONS_TO_DO);
                for (place, _) in columns {
                    let _ = writeln!(
                        text,
                        "{} = {}",
                        id(&table.full_name(*place), *place),
                        column(*place)
                    );
                }
                let times: Vec<_> =
                    columns.iter().filter_map(|(place, time)| Some((*place, (*time)?))).collect();
                if !times.is_empty() {
                    text.push_str("\n[questions.times]\n");
                }
                for (place, time) in times {
                    let _ =
                        writeln!(text, "{} = {}", id(&table.full_name(place), place), column(time));
                }
            }
        }
    }

    /// Whether a row lacks what it is asked for.
    fn has_gaps(&self, table: &Table) -> bool {
        let mut answers = self.form.answers();
        match &self.form {
            Form::Wide(_) => {}
            // jsPsych has a row for each screen.
            Form::Json { .. } => return true,
            Form::Long { question, .. } => answers.push(*question),
        }
        let lacks = |place: usize, is_answer: bool| {
            let cells = &table.columns[place];
            (0..cells.len()).any(|row| match cells.cell(row) {
                Cell::Empty => true,
                Cell::Text(text) => is_answer && is_missing(text),
                Cell::Number(number) => number.is_nan(),
            })
        };
        answers.iter().any(|place| lacks(*place, true))
            || self.labels.iter().any(|(_, place)| lacks(*place, false))
    }
}

/// What the questions' columns begin with.
const QUESTIONS_TO_DO: &str =
    "\n[questions.columns]\n# TODO: on the left, the ids of the questions in study.toml\n";

/// An id for the question of a column: its name in small letters, as far as an id holds it.
fn id(name: &str, place: usize) -> String {
    let name = name.to_lowercase();
    let is_plain = |letter: char| letter.is_ascii_alphanumeric();
    let words: Vec<&str> =
        name.split(|l: char| !is_plain(l)).filter(|word| !word.is_empty()).collect();
    let id: String = words.join("_").chars().take(LONGEST_ID).collect();
    if id.is_empty() { format!("question_{}", place + 1) } else { id }
}

/// Characters of an id.
const LONGEST_ID: usize = 32;
