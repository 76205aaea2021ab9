//! How other programs write cells that are not plain words or numbers: a missing value, a truth
//! value, a whole number with decimals, a UUID.

use std::borrow::Cow;
use std::collections::BTreeMap;

/// What stands for a missing value, in small letters and with a decimal point: in R and pandas
/// (`NA`, `<NA>`, `None`), in tables of BIDS (`n/a`), in databases and JSON (`NULL`), in Excel
/// (`#N/A`), in SAS and Stata (`.`), and where the C of Microsoft prints a NaN (`-nan(ind)`, `1.#QNAN`).
const MISSING: [&str; 18] = [
    "",
    ".",
    "na",
    "n/a",
    "<na>",
    "#na",
    "#n/a",
    "#n/a n/a",
    "nan",
    "-nan",
    "nan(ind)",
    "-nan(ind)",
    "1.#ind",
    "-1.#ind",
    "1.#qnan",
    "-1.#qnan",
    "none",
    "null",
];
/// The longest of them.
const LONGEST: usize = 9;

/// Whether other programs write this where a value is missing.
pub(super) fn is_missing(text: &str) -> bool {
    // Most cells are numbers, and a recording has millions of them.
    if text.as_bytes().last().is_some_and(u8::is_ascii_digit) {
        return false;
    }
    let text = text.trim();
    let may_be = text.len() <= LONGEST && !text.ends_with(|last: char| last.is_ascii_digit());
    may_be && MISSING.contains(&text.to_ascii_lowercase().replace(',', ".").as_str())
}

/// The truth value of a word: R, Python and JSON write `TRUE`, `True` and `true`.
pub(super) fn truth(text: &str) -> Option<bool> {
    match text {
        text if text.eq_ignore_ascii_case("true") => Some(true),
        text if text.eq_ignore_ascii_case("false") => Some(false),
        _ => None,
    }
}

/// A word in the one spelling that all of its spellings share: `true` for `TRUE`, and `1` for `1.0`,
/// as pandas writes a whole number in a column that has a gap.
pub(super) fn plain(text: &str) -> Cow<'_, str> {
    if let Some(truth) = truth(text) {
        return Cow::Owned(truth.to_string());
    }
    let Some((whole, zeros)) = text.split_once(['.', ',']) else { return Cow::Borrowed(text) };
    let digits = whole.strip_prefix('-').unwrap_or(whole);
    let is_whole = !digits.is_empty()
        && digits.bytes().all(|b| b.is_ascii_digit())
        && !zeros.is_empty()
        && zeros.bytes().all(|b| b == b'0');
    Cow::Borrowed(if is_whole { whole } else { text })
}

/// What a table says of a word: as it is written there, or in another spelling. In a table of truth
/// values alone, `1` and `0` are such too.
pub(super) fn find<'a, T>(table: &'a BTreeMap<String, T>, word: &str) -> Option<&'a T> {
    if let Some(value) = table.get(word) {
        return Some(value);
    }
    if let Some((_, value)) = table.iter().find(|(key, _)| plain(key) == plain(word)) {
        return Some(value);
    }
    let bit = bit_of(word).filter(|_| table.keys().all(|key| bit_of(key).is_some()))?;
    let (_, value) = table.iter().find(|(key, _)| bit_of(key) == Some(bit))?;
    Some(value)
}

/// The truth value of a word in a table of truth values, where `1` and `0` are such too.
fn bit_of(word: &str) -> Option<bool> {
    match plain(word).as_ref() {
        "1" => Some(true),
        "0" => Some(false),
        word => truth(word),
    }
}

/// The lengths of the groups of a UUID, which hyphens part.
const UUID: [usize; 5] = [8, 4, 4, 4, 12];

/// A UUID without its hyphens, and without the braces that Windows sets around it.
pub(super) fn uuid(text: &str) -> Option<String> {
    let bare = text.strip_prefix('{').and_then(|text| text.strip_suffix('}')).unwrap_or(text);
    let groups: Vec<&str> = bare.split('-').collect();
    let is_uuid = groups.iter().map(|group| group.len()).eq(UUID)
        && groups.iter().all(|group| group.bytes().all(|b| b.is_ascii_hexdigit()));
    is_uuid.then(|| groups.concat())
}

/// Characters of a text of theirs that an error repeats: half from its beginning, half from its
/// end.
const MOST_SHOWN: usize = 400;

/// A text of theirs, as an error shows it: a long one without its middle.
pub(super) fn shown(text: &str) -> Cow<'_, str> {
    let half = MOST_SHOWN / 2;
    let Some((cut, _)) = text.char_indices().nth(half) else { return Cow::Borrowed(text) };
    match text.char_indices().rev().nth(half - 1) {
        Some((on, _)) if on > cut => Cow::Owned(format!("{} … {}", &text[..cut], &text[on..])),
        _ => Cow::Borrowed(text),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_long_text_is_shown_without_its_middle() {
        assert_eq!(shown("short"), "short");
        let whole = "é".repeat(MOST_SHOWN);
        assert_eq!(shown(&whole), whole);
        let long = format!("{}{}{}", "é".repeat(200), "x".repeat(1 << 20), "ü".repeat(200));
        assert_eq!(shown(&long), format!("{} … {}", "é".repeat(200), "ü".repeat(200)));
    }

    #[test]
    fn the_marks_of_missing_values_are_known_in_any_case() {
        let marks =
            "NA N/A n/a NaN nan -nan(ind) 1.#QNAN 1,#QNAN -1.#IND #N/A <NA> None null NULL .";
        for mark in marks.split(' ').chain(["", " ", "\t"]) {
            assert!(is_missing(mark), "'{mark}'");
        }
        for value in ["0", "-99", "x", "no", "Nona", "inf", "1.", "..", "#DIV/0!", "1.5"] {
            assert!(!is_missing(value), "'{value}'");
        }
        assert!(MISSING.iter().all(|mark| mark.len() <= LONGEST));
    }

    #[test]
    fn a_word_is_the_same_in_all_of_its_spellings() {
        for (word, expect) in [
            ("TRUE", "true"),
            ("False", "false"),
            ("1.0", "1"),
            ("07,00", "07"),
            ("-1.0", "-1"),
            ("1.5", "1.5"),
            ("1.", "1."),
            (".0", ".0"),
            ("v1.0", "v1.0"),
        ] {
            assert_eq!(plain(word), expect);
        }
    }

    #[test]
    fn a_table_is_searched_for_the_word_itself_first() {
        let table = |keys: &[&'static str]| {
            keys.iter().map(|key| ((*key).to_owned(), *key)).collect::<BTreeMap<_, _>>()
        };
        assert_eq!(find(&table(&["1", "1.0"]), "1.0"), Some(&"1.0"));
        assert_eq!(find(&table(&["1", "2"]), "2.0"), Some(&"2"));
        assert_eq!(find(&table(&["1.0", "2.0"]), "2"), Some(&"2.0"));
        assert_eq!(find(&table(&["true", "false"]), "TRUE"), Some(&"true"));
        assert_eq!(find(&table(&["TRUE", "FALSE"]), "0"), Some(&"FALSE"));
        assert_eq!(find(&table(&["0", "1"]), "True"), Some(&"1"));
        assert_eq!(find(&table(&["1", "2"]), "True"), None);
    }

    #[test]
    fn a_uuid_is_known_by_its_form() {
        let hyphens = "5bc8fbbc-bde5-4099-8164-d8399f767c45";
        let plain = Some("5bc8fbbcbde540998164d8399f767c45".to_owned());
        assert_eq!(uuid(hyphens), plain);
        assert_eq!(uuid(&format!("{{{hyphens}}}")), plain);
        for other in
            ["5bc8fbbcbde540998164d8399f767c45", "5bc8fbbc-bde5-4099-8164-d8399f767c4g", "a-b"]
        {
            assert_eq!(uuid(other), None);
        }
    }
}
