//! A table of answers to a task, guessed: a mapping of `kind = "psychometric"` for the output of PsychoPy or jsPsych, or
//! for a table that has what was presented and whether the answer was right.

use super::guess_answers::{LOOP, PSYCHOPY, TOOK, column};
use super::guess_names::Names;
use super::guess_read::quoted;
use super::guess_words::{has_word, label_of, parse_name};
use super::recording::number;
use super::spelling::{is_missing, plain, truth};
use super::table::{Cell, Cells, Table};
use std::collections::BTreeSet;
use std::fmt::Write as _;

/// Words of a column of what was presented.
const LEVELS: [&str; 9] = [
    "level",
    "intensity",
    "comparison",
    "contrast",
    "magnitude",
    "amplitude",
    "delta",
    "stimulus",
    "reiz",
];
/// Words of a column that says whether an answer was right.
const RIGHT: [&str; 6] = ["correct", "corr", "accuracy", "acc", "iscorrect", "richtig"];
/// Words of a column of what was pressed.
const PRESSED: [&str; 6] = ["response", "answer", "choice", "key", "keys", "antwort"];
/// Words of a column of the times that answers took.
const TIMES: [&str; 3] = ["rt", "latency", "reaktionszeit"];
/// The ending of PsychoPy's columns of what was pressed.
const KEYS: &str = ".keys";
/// The ending of PsychoPy's columns of whether that was right.
const CORR: &str = ".corr";
/// The columns of a staircase of PsychoPy: what it presented, and whether the answer was right.
const STAIRCASE: [&str; 2] = [".intensity", ".response"];
/// What jsPsych calls its kind of screen, and its number.
const JSPSYCH: [&str; 2] = ["trial_type", "trial_index"];
/// More words than these are no answers to one question.
const MOST_WORDS: usize = 4;

/// The columns of a table of answers to a task, by their places.
pub(super) struct TaskGuess {
    labels: Vec<(&'static str, usize)>,
    level: usize,
    correct: usize,
    answer: Option<usize>,
    /// With the unit, if it is known.
    time: Option<(usize, Option<&'static str>)>,
    is_jspsych: bool,
}

/// Finds the columns of answers to a task; `None` if the table is clearly none of these.
pub(super) fn task(table: &Table, decimal_comma: bool) -> Option<TaskGuess> {
    let names = table.names.as_ref()?;
    let is_psychopy =
        names.iter().any(|name| PSYCHOPY.contains(&name.as_str()) || name.ends_with(LOOP));
    let is_jspsych = JSPSYCH.iter().all(|own| names.iter().any(|name| name == own));
    let cells = |place: &usize| &table.columns[*place];
    let all = || 0..names.len();
    // Of a staircase both have the same stem.
    let staircase = all().filter(|_| is_psychopy).find_map(|at| {
        let stem = names[at].strip_suffix(STAIRCASE[0])?;
        let other = names.iter().position(|name| name.strip_suffix(STAIRCASE[1]) == Some(stem))?;
        (are_numbers(cells(&at), decimal_comma) && are_truths(cells(&other))).then_some((at, other))
    });
    let is_called = |place: &usize, words: &[&str]| has_word(&words_of(&names[*place]), words);
    let (level, correct) = match staircase {
        Some(both) => both,
        None => {
            let right = |place: &usize| {
                (names[*place].ends_with(CORR) || is_called(place, &RIGHT))
                    && are_truths(cells(place))
            };
            let level = |place: &usize| {
                is_called(place, &LEVELS)
                    && !is_called(place, &RIGHT)
                    && are_numbers(cells(place), decimal_comma)
            };
            (all().find(level)?, all().find(right)?)
        }
    };
    let stem = names[correct].strip_suffix(CORR);
    let answer = match stem {
        Some(stem) => names.iter().position(|name| name.strip_suffix(KEYS) == Some(stem)),
        None => all().find(|place| {
            is_called(place, &PRESSED) && ![level, correct].contains(place) && {
                let n = words_in(cells(place)).len();
                (2..=MOST_WORDS).contains(&n)
            }
        }),
    };
    let time = match stem {
        Some(stem) => names.iter().position(|name| name.strip_suffix(TOOK) == Some(stem)),
        None => {
            all().find(|place| is_called(place, &TIMES) && are_numbers(cells(place), decimal_comma))
        }
    };
    let unit = match (is_psychopy, is_jspsych) {
        (true, _) => Some("s"),
        (_, true) => Some("ms"),
        _ => None,
    };
    let mut labels: Vec<(&'static str, usize)> = Vec::new();
    let taken = [Some(level), Some(correct), answer, time];
    for (place, name) in names.iter().enumerate() {
        // Names of PsychoPy's components and jsPsych's own columns say nothing of the study.
        let is_own = name.contains('.') || JSPSYCH.contains(&name.as_str());
        let Some(key) = label_of(name).filter(|_| !is_own && !taken.contains(&Some(place))) else {
            continue;
        };
        if key != "repeat" && labels.iter().all(|(other, _)| *other != key) {
            labels.push((key, place));
        }
    }
    let has_participant = labels.iter().any(|(key, _)| *key == "participant");
    (is_psychopy || is_jspsych || has_participant).then(|| TaskGuess {
        labels,
        level,
        correct,
        answer,
        time: time.map(|place| (place, unit)),
        is_jspsych,
    })
}

/// The words of a name in small letters, whether a unit is among them or not.
fn words_of(name: &str) -> Vec<String> {
    let lower = name.to_lowercase();
    let words = lower.split(|letter: char| !letter.is_alphabetic()).map(str::to_owned);
    words.chain(parse_name(name).words).collect()
}

/// The cells in which something stands.
fn filled(cells: &Cells) -> impl Iterator<Item = String> {
    (0..cells.len()).filter_map(|row| match cells.cell(row) {
        Cell::Empty => None,
        Cell::Number(number) if number.is_nan() => None,
        Cell::Text(text) if is_missing(text) => None,
        cell => Some(cell.to_string()),
    })
}

/// Whether all that stands in a column are numbers, and not all the same.
fn are_numbers(cells: &Cells, decimal_comma: bool) -> bool {
    let is_number = |text: &String| matches!(number(text, decimal_comma), Ok(Some(_)));
    let mut distinct = BTreeSet::new();
    filled(cells).inspect(|text| _ = distinct.insert(text.clone())).all(|text| is_number(&text))
        && distinct.len() > 1
}

/// Whether all that stands in a column are truth values.
fn are_truths(cells: &Cells) -> bool {
    let mut n = 0;
    let is_truth = |text: String| {
        let text = plain(&text).into_owned();
        ["0", "1"].contains(&text.as_str()) || truth(&text).is_some()
    };
    filled(cells).inspect(|_| n += 1).all(is_truth) && n > 0
}

/// The different words of a column, up to one more than there may be.
fn words_in(cells: &Cells) -> BTreeSet<String> {
    let mut words = BTreeSet::new();
    for word in filled(cells) {
        words.insert(word);
        if words.len() > MOST_WORDS {
            break;
        }
    }
    words
}

impl TaskGuess {
    /// Writes the rest of `[file]`, and what follows it.
    pub(super) fn write(&self, text: &mut String, table: &Table, names: &Names) {
        if let Some((row, why)) = table.bad.first() {
            let count = table.bad.len();
            let _ =
                writeln!(text, "bad_lines = {count}           # the first: row {}: {why}", row + 1);
        }
        let needed = [Some(self.level), Some(self.correct), self.answer].into_iter().flatten();
        if needed.chain(self.labels.iter().map(|(_, place)| *place)).any(|place| {
            let cells = &table.columns[place];
            filled(cells).count() < cells.len()
        }) {
            text.push_str(
                "missing = \"drop\"       # rows of other screens, and those without an answer\n",
            );
        }
        let mut names = names.clone();
        for (key, place) in &self.labels {
            names.labels.insert(*key, format!("{{ column = {} }}", column(table, *place)));
        }
        names.write_of_tasks(text, "\"TODO\"     # a code");
        let of = |place| column(table, place);
        let _ = writeln!(
            text,
            "\n[task]\nid = \"TODO\"              # of [[tasks]] in study.toml\nlevel = {}\n\
             unit = \"TODO\"            # of the levels there; scale and offset change their numbers",
            of(self.level)
        );
        if let Some(answer) = self.answer {
            let words = words_in(&table.columns[answer]);
            let words: Vec<String> = words
                .iter()
                .enumerate()
                .map(|(i, w)| format!("{} = \"{}\"", quoted(w), i + 1))
                .collect();
            let _ = writeln!(
                text,
                "# TODO: which answer each word is: \"1\" (the first, yes, more) or \"2\" (the second, no, less); with two \
                 intervals\n# name the column that says which one held the standard, as standard = {{ column = … }}\n\
                 answer = {{ column = {}, translate = {{ {} }} }}",
                of(answer),
                words.join(", ")
            );
        }
        let _ = writeln!(text, "correct = {{ column = {} }}", of(self.correct));
        if let Some((time, unit)) = self.time {
            let unit = unit.unwrap_or("TODO");
            let _ = writeln!(text, "time = {}\ntime_unit = \"{unit}\"", of(time));
        }
        if self.is_jspsych {
            text.push_str(
                "# only rows of the screens that ask: when = { task = [\"TODO\"] }, a column and its words\n",
            );
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::guess::guess;
    use super::super::world::World;

    fn guessed(name: &str, text: &str) -> String {
        let world = World::new();
        guess(&world.file(name, text), &[]).unwrap().mapping
    }

    #[test]
    fn a_table_of_psychopy_with_judged_answers_is_one_of_a_task() {
        let map = guessed(
            "a.csv",
            "comparison_force,trials.thisN,key_resp.keys,key_resp.corr,key_resp.rt,participant,psychopyVersion,\n\
             ,,,,,7,2024.1,\n1.5,0,left,1,0.5,7,2024.1,\n2.5,1,right,0,0.7,7,2024.1,\n1.5,2,None,0,,7,2024.1,\n",
        );
        for line in [
            "kind = \"psychometric\"",
            "missing = \"drop\"",
            "participant = { column = \"participant\" }",
            "level = \"comparison_force\"",
            "answer = { column = \"key_resp.keys\", translate = { \"left\" = \"1\", \"right\" = \"2\" } }",
            "correct = { column = \"key_resp.corr\" }",
            "time = \"key_resp.rt\"\ntime_unit = \"s\"",
        ] {
            assert!(map.contains(line), "{line} is not in:\n{map}");
        }
        assert!(!map.contains("environment"), "{map}");
    }

    #[test]
    fn a_staircase_of_psychopy_has_what_it_presented_and_whether_that_was_right() {
        let map = guessed(
            "a.csv",
            "stairs.intensity,stairs.response,stairs.thisTrialN,expName,participant,\n0.8,1,0,force,3,\n0.6,0,1,force,3,\n",
        );
        assert!(map.contains("level = \"stairs.intensity\"\n"), "{map}");
        assert!(map.contains("correct = { column = \"stairs.response\" }"), "{map}");
    }

    #[test]
    fn a_table_of_jspsych_and_a_plain_one_are_recognised_and_other_answers_are_not() {
        let map = guessed(
            "a.csv",
            "rt,response,trial_type,trial_index,subject,intensity,correct\n812,f,html-keyboard-response,1,4,0.5,true\n\
             934,j,html-keyboard-response,2,4,0.7,false\n",
        );
        for line in ["level = \"intensity\"", "time = \"rt\"\ntime_unit = \"ms\"", "when = { task"]
        {
            assert!(map.contains(line), "{line} is not in:\n{map}");
        }
        let map =
            guessed("a.csv", "subject,condition,level_n,correct\nA,motor,0.5,1\nA,brake,0.7,0\n");
        for line in ["mode = { column = \"condition\" }", "level = \"level_n\""] {
            assert!(map.contains(line), "{line} is not in:\n{map}");
        }
        let map = guessed("a.csv", "subject,condition,rating\nA,motor,5\nA,brake,7\n");
        assert!(map.contains("kind = \"likert\""), "{map}");
    }
}
