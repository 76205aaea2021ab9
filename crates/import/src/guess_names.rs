//! Guesses a pattern for `[name]` from the names of recordings.
//!
//! A name is divided into runs of letters, of digits, and of other characters. Names of one shape
//! give a pattern: runs that are the same in all names stay, runs that differ become groups.

use std::collections::BTreeSet;
use std::fmt::Write as _;
use std::path::{Path, PathBuf};

/// Words before a number, in small letters, and the label that the number then is.
const WORDS: [(Label, &[&str]); 4] = [
    (
        Label::Participant,
        &["p", "vp", "s", "sub", "subj", "subject", "participant", "proband", "user"],
    ),
    (Label::Session, &["s", "ses", "sess", "session", "d", "day", "visit"]),
    (Label::Repeat, &["r", "rep", "repeat", "repetition", "wdh", "take"]),
    (Label::Trial, &["t", "trial", "run"]),
];
/// Values of a mode that are listed.
const MOST_LISTED: usize = 8;

/// A label that a part of a name may be.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
enum Label {
    Participant,
    Session,
    Repeat,
    Trial,
    Mode,
}

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
    let mut runs = Vec::new();
    let mut begin = 0;
    let letters: Vec<(usize, char)> = name.char_indices().collect();
    for (i, (at, letter)) in letters.iter().enumerate() {
        let end = letters.get(i + 1);
        if end.is_none_or(|(_, next)| kind(*next) != kind(*letter)) {
            let to = end.map_or(name.len(), |(next, _)| *next);
            runs.push((kind(*letter), &name[begin..to]));
            begin = at + (to - at);
        }
    }
    runs
}

/// Labels guessed from names: the block `[name]`, and the values of `[trial]` by their keys.
#[derive(Debug, Default, PartialEq, Eq)]
pub(super) struct Names {
    pub(super) block: String,
    pub(super) participant: Option<String>,
    pub(super) session: Option<String>,
    pub(super) mode: Option<String>,
    pub(super) repeat: Option<String>,
    pub(super) trial: Option<String>,
}

/// What these files' names say; nothing where they have no shape in common, or no part that is
/// known for a label.
pub(super) fn names(files: &[PathBuf]) -> Names {
    let all: Vec<&str> = files.iter().filter_map(|file| file.file_name()?.to_str()).collect();
    let Some(ending) = files.first().map(|file| ending(file)) else { return Names::default() };
    let stems: Option<Vec<&str>> = all.iter().map(|name| name.strip_suffix(&ending)).collect();
    let Some(stems) = stems.filter(|stems| stems.len() == files.len()) else {
        return Names::default();
    };
    let parts: Vec<Vec<(Kind, &str)>> = stems.iter().map(|stem| runs(stem)).collect();
    let kinds = |parts: &Vec<(Kind, &str)>| parts.iter().map(|(kind, _)| *kind).collect();
    let shapes: Vec<Vec<Kind>> = parts.iter().map(kinds).collect();
    let first = &shapes[0];
    if shapes.iter().any(|shape| shape != first) {
        return Names::default();
    }
    let columns: Vec<Vec<&str>> =
        (0..first.len()).map(|k| parts.iter().map(|parts| parts[k].1).collect()).collect();
    label_runs(first, &columns, &ending, files.len())
}

/// `.csv`, or nothing.
fn ending(file: &Path) -> String {
    file.extension().map(|e| format!(".{}", e.to_string_lossy())).unwrap_or_default()
}

/// Makes groups of the runs that differ and that may be labels; each column has one run of all names.
fn label_runs(kinds: &[Kind], columns: &[Vec<&str>], ending: &str, files: usize) -> Names {
    let mut names = Names::default();
    let mut pattern = String::new();
    let mut taken = BTreeSet::new();
    let mut word = "";
    for (kind, values) in kinds.iter().zip(columns) {
        let distinct: BTreeSet<&str> = values.iter().copied().collect();
        let same = distinct.len() == 1;
        match kind {
            Kind::Digits => {
                let label = labels_of(word).find(|label| taken.insert(*label)).or_else(|| {
                    // A number of its own that differs counts something.
                    let counts = word.is_empty() && !same && taken.insert(Label::Repeat);
                    counts.then_some(Label::Repeat)
                });
                pattern += &digits(&mut names, label, word, same.then_some(values[0]));
            }
            Kind::Letters
                if !same
                    && labels_of(word).any(|l| l == Label::Participant)
                    && taken.insert(Label::Participant) =>
            {
                pattern += "(?<who>\\pL+)";
                names.participant = Some("{ name = \"who\" }".to_owned());
            }
            Kind::Letters if !same && taken.insert(Label::Mode) => {
                let common = common_start(&distinct);
                pattern += &regex::escape(common);
                pattern += "(?<mode>\\pL+)";
                names.mode = Some(mode(&distinct, common.len()));
            }
            Kind::Letters if !same => pattern += "\\pL+",
            Kind::Other if !same => pattern += "[^\\pL\\d]+",
            Kind::Letters | Kind::Other => pattern += &regex::escape(values[0]),
        }
        if *kind != Kind::Other {
            // A word that differs from file to file does not say what the number behind it is.
            word = if same && *kind == Kind::Letters { values[0] } else { "" };
        }
    }
    if taken.is_empty() {
        return Names::default();
    }
    let whose = if files == 1 { "the file's name".to_owned() } else { format!("{files} names") };
    let _ = write!(
        names.block,
        "\n[name]\n# guessed from {whose}\npattern = '{pattern}{}$'\n",
        regex::escape(ending)
    );
    names
}

/// The part of the pattern for a number behind a word.
fn digits(names: &mut Names, label: Option<Label>, word: &str, same: Option<&str>) -> String {
    match label {
        Some(Label::Participant) => {
            names.participant = Some(numbered("who", 'P'));
            "(?<who>\\d+)".to_owned()
        }
        Some(Label::Session) => {
            names.session = Some(numbered("session", 'S'));
            "(?<session>\\d+)".to_owned()
        }
        Some(Label::Repeat) => {
            names.repeat = Some("{ name = \"repeat\" }".to_owned());
            "(?<repeat>\\d+)".to_owned()
        }
        Some(Label::Trial) => {
            names.trial = Some("{ name = \"trial\" }".to_owned());
            "(?<trial>\\d+)".to_owned()
        }
        // A number that is the same everywhere, or that nothing is known of.
        _ => same
            .filter(|_| labels_of(word).next().is_none())
            .map_or("\\d+".to_owned(), regex::escape),
    }
}

/// 3 → P03.
fn numbered(group: &str, prefix: char) -> String {
    format!("{{ name = \"{group}\", prefix = \"{prefix}\", digits = 2 }}")
}

/// The labels that a number behind a word may be, the likeliest first.
fn labels_of(word: &str) -> impl Iterator<Item = Label> {
    let word = word.to_lowercase();
    let listed = WORDS.iter().filter(move |(_, words)| words.contains(&word.as_str()));
    listed.map(|(label, _)| *label)
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

    /// The groups that the pattern finds in a name.
    fn found(names: &Names, file: &str) -> Vec<(String, String)> {
        let line = names.block.lines().find(|line| line.starts_with("pattern")).unwrap();
        let text = line.split('\'').nth(1).unwrap();
        let pattern = regex::Regex::new(text).unwrap();
        let groups = pattern.captures(file).unwrap_or_else(|| panic!("{text} in {file}"));
        let named = pattern.capture_names().flatten();
        named.map(|name| (name.to_owned(), groups[name].to_owned())).collect()
    }

    #[test]
    fn letters_behind_the_word_participant_are_the_participant() {
        let names = of(&["participant_A.csv", "participant_B.csv"]);
        assert_eq!(found(&names, "participant_B.csv"), pairs(&[("who", "B")]));
        assert_eq!(names.participant.as_deref(), Some("{ name = \"who\" }"));
        assert_eq!(names.mode, None);
    }

    fn pairs(expect: &[(&str, &str)]) -> Vec<(String, String)> {
        expect.iter().map(|(a, b)| ((*a).to_owned(), (*b).to_owned())).collect()
    }

    #[test]
    fn names_of_one_shape_give_a_pattern_with_what_differs_as_groups() {
        let files =
            ["x/subj01_ctrlA_rep1.csv", "x/subj01_ctrlB_rep2.csv", "x/subj12_ctrlA_rep1.csv"];
        let names = of(&files);
        let expect = pairs(&[("who", "12"), ("mode", "A"), ("repeat", "1")]);
        assert_eq!(found(&names, files[2]), expect);
        assert!(names.mode.unwrap().contains("\"A\" = \"a\", \"B\" = \"b\""));
        assert_eq!(names.participant.unwrap(), "{ name = \"who\", prefix = \"P\", digits = 2 }");
        assert_eq!(names.session, None);
    }

    #[test]
    fn one_name_tells_its_numbers_by_the_words_before_them() {
        let names = of(&["P01_S02_T003.csv"]);
        // S may be a participant's word, too, but P was one already.
        let expect = pairs(&[("who", "01"), ("session", "02"), ("trial", "003")]);
        assert_eq!(found(&names, "P01_S02_T003.csv"), expect);
        assert_eq!(found(&names, "P07_S11_T120.csv")[0].1, "07");
    }

    #[test]
    fn words_that_differ_are_a_mode_and_signs_of_a_pattern_are_meant_as_they_stand() {
        let files = ["sub-1 (active).v2.dat", "sub-2 (passive).v2.dat"];
        let names = of(&files);
        let expect = pairs(&[("who", "2"), ("mode", "passive")]);
        assert_eq!(found(&names, files[1]), expect);
        assert!(names.block.contains("guessed from 2 names"), "{}", names.block);
    }

    #[test]
    fn a_day_is_a_session_and_a_number_alone_counts_repeats() {
        let files = ["VP1_d1_haptic_1.txt", "VP2_d2_visual_3.txt"];
        let expect = pairs(&[("who", "2"), ("session", "2"), ("mode", "visual"), ("repeat", "3")]);
        assert_eq!(found(&of(&files), files[1]), expect);
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
