//! Guesses a pattern for `[name]` from the names of recordings.
//!
//! A name is divided into runs of letters, of digits, and of other characters. Names of one shape
//! give a pattern: runs that are the same in all names stay, runs that differ become groups.

use std::collections::{BTreeMap, BTreeSet};
use std::fmt::Write as _;
use std::path::PathBuf;

/// Labels that a number in a name may be: the key under `[trial]`, the group of the pattern, what its value under
/// `[trial]` has besides, and the words before such a number, in small letters. The likelier of two comes first.
const NUMBERED: [(&str, &str, &str, &[&str]); 4] = [
    (
        "participant",
        "who",
        ", prefix = \"P\", digits = 2",
        &["p", "vp", "s", "sub", "subj", "subject", "participant", "proband", "user"],
    ),
    (
        "session",
        "session",
        ", prefix = \"S\", digits = 2",
        &["s", "ses", "sess", "session", "d", "day", "visit"],
    ),
    ("repeat", "repeat", "", &["r", "rep", "repeat", "repetition", "wdh", "take"]),
    ("trial", "trial", "", &["t", "trial", "run"]),
];
/// Values of a mode that are listed.
const MOST_LISTED: usize = 8;

/// A run of signs of one kind.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Kind {
    Letters,
    Digits,
    Other,
}

fn kind(letter: char) -> Kind {
    match letter {
        letter if letter.is_ascii_digit() => Kind::Digits,
        letter if letter.is_alphabetic() => Kind::Letters,
        _ => Kind::Other,
    }
}

/// `subj03_ctrlB` → `subj`, `03`, `_`, `ctrlB`.
fn runs(name: &str) -> Vec<(Kind, &str)> {
    let letters: Vec<(usize, char)> = name.char_indices().collect();
    let runs = letters.chunk_by(|(_, a), (_, b)| kind(*a) == kind(*b)).map(|run| {
        let (begin, first) = run[0];
        let length: usize = run.iter().map(|(_, letter)| letter.len_utf8()).sum();
        (kind(first), &name[begin..begin + length])
    });
    runs.collect()
}

/// Labels guessed from names: the block `[name]`, and the values of `[trial]` by their keys.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub(super) struct Names {
    block: String,
    pub(super) labels: BTreeMap<&'static str, String>,
}

impl Names {
    /// Writes `[name]` and `[trial]`; `who` stands for a participant that nobody knows.
    pub(super) fn write(&self, text: &mut String, who: &str) {
        self.write_with(text, who, "environment = \"TODO\"     # as in study.toml\n");
        if let Some(repeat) = self.labels.get("repeat") {
            let _ = writeln!(text, "repeat = {repeat}");
        }
        self.write_trial(text);
    }

    /// Writes them for answers to tasks, whose environment study.toml knows, and whose presentations are counted.
    pub(super) fn write_of_tasks(&self, text: &mut String, who: &str) {
        self.write_with(text, who, "");
        self.write_trial(text);
    }

    fn write_trial(&self, text: &mut String) {
        if let Some(trial) = self.labels.get("trial") {
            let _ = writeln!(text, "trial = {trial}");
        }
    }

    fn write_with(&self, text: &mut String, who: &str, environment: &str) {
        let label = |key: &str, to_do| self.labels.get(key).map_or(to_do, String::as_str);
        let _ = write!(
            text,
            "{}\n[trial]\nparticipant = {}\nsession = {}\n{environment}mode = {}\n",
            self.block,
            label("participant", who),
            label("session", "\"S01\""),
            label("mode", "\"TODO\"            # as in study.toml"),
        );
    }
}

/// What these files' names say; nothing where they have no shape in common, or no part that is
/// known for a label.
pub(super) fn names(files: &[PathBuf]) -> Names {
    let all: Vec<&str> = files.iter().filter_map(|file| file.file_name()?.to_str()).collect();
    let Some(first) = files.first() else { return Names::default() };
    let ending = first.extension().map(|e| format!(".{}", e.to_string_lossy())).unwrap_or_default();
    let stems: Option<Vec<&str>> = all.iter().map(|name| name.strip_suffix(&ending)).collect();
    let Some(stems) = stems.filter(|stems| stems.len() == files.len()) else {
        return Names::default();
    };
    let parts: Vec<Vec<(Kind, &str)>> = stems.iter().map(|stem| runs(stem)).collect();
    let kinds: Vec<Kind> = parts[0].iter().map(|(kind, _)| *kind).collect();
    if parts.iter().any(|parts| !parts.iter().map(|(kind, _)| kind).eq(&kinds)) {
        return Names::default();
    }
    // Runs that differ and that may be labels become groups.
    let mut labels: BTreeMap<&'static str, String> = BTreeMap::new();
    let mut pattern = String::new();
    let mut word = String::new();
    for (k, kind) in kinds.into_iter().enumerate() {
        let value = parts[0][k].1;
        let distinct: BTreeSet<&str> = parts.iter().map(|parts| parts[k].1).collect();
        let same = distinct.len() == 1;
        // Whether the word before this run is one of these.
        let may_be = |words: &[&str]| words.contains(&word.as_str());
        match kind {
            Kind::Digits => {
                let label = NUMBERED.iter().find(|(key, .., words)| {
                    // A number of its own that differs counts something.
                    let counts = *key == "repeat" && word.is_empty() && !same;
                    !labels.contains_key(key) && (may_be(words) || counts)
                });
                match label {
                    Some((key, group, form, _)) => {
                        labels.insert(*key, format!("{{ name = \"{group}\"{form} }}"));
                        let _ = write!(pattern, "(?<{group}>\\d+)");
                    }
                    // A number that is the same everywhere, and that nothing is known of.
                    None if same && !NUMBERED.iter().any(|(.., words)| may_be(words)) => {
                        pattern += &regex::escape(value);
                    }
                    None => pattern += "\\d+",
                }
            }
            Kind::Letters if same => pattern += &regex::escape(value),
            Kind::Letters if may_be(NUMBERED[0].3) && !labels.contains_key("participant") => {
                pattern += "(?<who>\\pL+)";
                labels.insert("participant", "{ name = \"who\" }".to_owned());
            }
            Kind::Letters if !labels.contains_key("mode") => {
                let common = common_start(&distinct);
                pattern += &regex::escape(common);
                pattern += "(?<mode>\\pL+)";
                labels.insert("mode", mode(&distinct, common.len()));
            }
            Kind::Letters => pattern += "\\pL+",
            Kind::Other if same => pattern += &regex::escape(value),
            Kind::Other => pattern += "[^\\pL\\d]+",
        }
        if kind != Kind::Other {
            // A word that differs from file to file does not say what the number behind it is.
            let says = same && kind == Kind::Letters;
            word = if says { value.to_lowercase() } else { String::new() };
        }
    }
    if labels.is_empty() {
        return Names::default();
    }
    let whose = match files.len() {
        1 => "the file's name".to_owned(),
        n => format!("{n} names"),
    };
    let ending = regex::escape(&ending);
    let block = format!("\n[name]\n# guessed from {whose}\npattern = '{pattern}{ending}$'\n");
    Names { block, labels }
}

/// Where all begin alike, by whole letters; not the whole of any of them, as a group must match something.
fn common_start<'a>(values: &BTreeSet<&'a str>) -> &'a str {
    // Sorted: what the first and the last have in common, all have.
    let (Some(first), Some(last)) = (values.first(), values.last()) else { return "" };
    let alike = first.char_indices().zip(last.chars()).take_while(|((_, a), b)| a == b);
    let end = alike.last().map_or(0, |((at, letter), _)| at + letter.len_utf8());
    let shortest = values.iter().map(|value| value.len()).min().unwrap_or(0);
    if end < shortest { &first[..end] } else { "" }
}

/// The mode's line, with the words that there are.
fn mode(values: &BTreeSet<&str>, from: usize) -> String {
    let words: Vec<&str> = values.iter().map(|value| &value[from..]).collect();
    let listed = words.iter().take(MOST_LISTED).copied().collect::<Vec<_>>().join(", ");
    let more = if words.len() > MOST_LISTED { ", …" } else { "" };
    let table: Vec<String> = words
        .iter()
        .take(MOST_LISTED)
        .map(|word| format!("\"{word}\" = \"{}\"", word.to_lowercase()))
        .collect();
    format!(
        "{{ name = \"mode\", translate = {{ {} }} }}  # TODO: {listed}{more}: to which mode of \
         study.toml each belongs; or is it the environment?",
        table.join(", ")
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    fn of(files: &[&str]) -> Names {
        names(&files.iter().map(PathBuf::from).collect::<Vec<_>>())
    }

    /// The pattern finds these groups in a name.
    fn finds(names: &Names, file: &str, expect: &[(&str, &str)]) {
        let line = names.block.lines().find(|line| line.starts_with("pattern")).unwrap();
        let text = line.split('\'').nth(1).unwrap();
        let pattern = regex::Regex::new(text).unwrap();
        let groups = pattern.captures(file).unwrap_or_else(|| panic!("{text} in {file}"));
        let named = pattern.capture_names().flatten();
        assert_eq!(named.map(|name| (name, &groups[name])).collect::<Vec<_>>(), expect);
    }

    #[test]
    fn letters_behind_the_word_participant_are_the_participant() {
        let names = of(&["participant_A.csv", "participant_B.csv"]);
        finds(&names, "participant_B.csv", &[("who", "B")]);
        let labels = BTreeMap::from([("participant", "{ name = \"who\" }".to_owned())]);
        assert_eq!(names.labels, labels);
    }

    #[test]
    fn names_of_one_shape_give_a_pattern_with_what_differs_as_groups() {
        let files =
            ["x/subj01_ctrlA_rep1.csv", "x/subj01_ctrlB_rep2.csv", "x/subj12_ctrlA_rep1.csv"];
        let names = of(&files);
        finds(&names, files[2], &[("who", "12"), ("mode", "A"), ("repeat", "1")]);
        assert!(names.labels["mode"].contains("\"A\" = \"a\", \"B\" = \"b\""));
        let participant = "{ name = \"who\", prefix = \"P\", digits = 2 }";
        assert_eq!(names.labels["participant"], participant);
        assert!(!names.labels.contains_key("session"));
    }

    #[test]
    fn one_name_tells_its_numbers_by_the_words_before_them() {
        let names = of(&["P01_S02_T003.csv"]);
        // S may be a participant's word, too, but P was one already.
        let expect = [("who", "01"), ("session", "02"), ("trial", "003")];
        finds(&names, "P01_S02_T003.csv", &expect);
        finds(&names, "P07_S11_T120.csv", &[("who", "07"), ("session", "11"), ("trial", "120")]);
    }

    #[test]
    fn words_that_differ_are_a_mode_and_signs_of_a_pattern_are_meant_as_they_stand() {
        let files = ["sub-1 (active).v2.dat", "sub-2 (passive).v2.dat"];
        let names = of(&files);
        finds(&names, files[1], &[("who", "2"), ("mode", "passive")]);
        assert!(names.block.contains("guessed from 2 names"), "{}", names.block);
    }

    #[test]
    fn a_day_is_a_session_and_a_number_alone_counts_repeats() {
        let files = ["VP1_d1_haptic_1.txt", "VP2_d2_visual_3.txt"];
        let expect = [("who", "2"), ("session", "2"), ("mode", "visual"), ("repeat", "3")];
        finds(&of(&files), files[1], &expect);
    }

    #[test]
    fn names_without_a_shape_or_a_label_tell_nothing() {
        for files in
            [&["data.csv"][..], &["a1.csv", "b.csv"], &["2024.csv"], &["a.csv", "a.txt"], &[]]
        {
            assert_eq!(of(files), Names::default(), "{files:?}");
        }
    }
}
