//! Findings that differ only by their file and their numbers are reported once.

use std::collections::BTreeMap;

/// The most lines that are alike of which each is listed.
const LISTED: usize = 3;
/// How many of the others are named where they are counted.
const NAMED: usize = 3;

/// The lines in order of the first of each kind: of more than three that are alike the first is
/// whole, and the others are counted. A line begins with its subject, up to `, ` or `: `.
pub(crate) fn once(lines: &[String], all: bool) -> Vec<String> {
    let mut kinds: Vec<Vec<&String>> = Vec::new();
    let mut places = BTreeMap::new();
    for line in lines {
        let at = *places.entry(kind(line)).or_insert(kinds.len());
        match kinds.get_mut(at) {
            Some(alike) => alike.push(line),
            None => kinds.push(vec![line]),
        }
    }
    let mut reported = Vec::new();
    for alike in kinds {
        match alike.as_slice() {
            [first, others @ ..] if !all && others.len() >= LISTED => {
                reported.extend([(*first).clone(), counted(others)]);
            }
            _ => reported.extend(alike.into_iter().cloned()),
        }
    }
    reported
}

/// What is left of a line without its subject and without its numbers.
fn kind(line: &str) -> String {
    let rest = &line[subject(line).len()..];
    // Dots go with the digits: 0.5 and 12 are numbers alike.
    rest.chars().filter(|sign| !sign.is_ascii_digit() && *sign != '.').collect()
}

/// What a line is about.
fn subject(line: &str) -> &str {
    let end = [", ", ": "].iter().filter_map(|mark| line.find(mark)).min();
    &line[..end.unwrap_or(0)]
}

fn counted(others: &[&String]) -> String {
    let named: Vec<&str> = others.iter().take(NAMED).map(|line| subject(line)).collect();
    let more = match others.len() - named.len() {
        0 => String::new(),
        n => format!(" and {n} more"),
    };
    let n = others.len();
    format!("likewise {n} others (--verbose lists them): {}{more}", named.join(", "))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn lines(range: core::ops::Range<u32>) -> Vec<String> {
        let line =
            |i| format!("P01 S01 trial {i}, t_s, row {}: it jumps by 0.{i} s; mend it", i * 7);
        range.map(line).collect()
    }

    #[test]
    fn many_that_are_alike_are_counted_and_few_are_listed() {
        let mut all = lines(1..7);
        all.insert(2, "P01 S01 trial 3, theta_rad: it holds; look at it".to_owned());
        let expect = [
            all[0].clone(),
            "likewise 5 others (--verbose lists them): P01 S01 trial 2, P01 S01 trial 3, P01 S01 trial 4 and 2 more"
                .to_owned(),
            all[2].clone(),
        ];
        assert_eq!(once(&all, false), expect);
        assert_eq!(once(&all, true).len(), 7);
        assert_eq!(once(&lines(1..4), false), lines(1..4));
        assert_eq!(once(&lines(1..5), false).len(), 2);
    }

    #[test]
    fn a_line_about_nobody_is_a_kind_of_its_own() {
        let all = ["a", "a", "b", ""].map(str::to_owned);
        assert_eq!(once(&all, false), ["a", "a", "b", ""]);
    }
}
