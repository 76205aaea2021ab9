//! The order of files: by name, with numbers in names compared as numbers.

use std::cmp::Ordering;
use std::path::{Path, PathBuf};

/// The files in the order of their names, `P01_2` before `P01_10`, however a shell listed them: trials and
/// sweeps that the mapping gives no number are numbered in it.
pub(super) fn in_order(files: &[PathBuf]) -> Vec<PathBuf> {
    let mut files = files.to_vec();
    files.sort_by(|a, b| compare(a, b));
    files
}

fn compare(a: &Path, b: &Path) -> Ordering {
    let [a, b] = [a, b].map(|path| path.to_string_lossy().replace('\\', "/"));
    let mut x = a.as_str();
    let mut y = b.as_str();
    loop {
        let (Some(first), Some(second)) = (x.chars().next(), y.chars().next()) else {
            // The texts may differ in zeros before a number alone.
            return x.len().cmp(&y.len()).then_with(|| a.cmp(&b));
        };
        let order = if first.is_ascii_digit() && second.is_ascii_digit() {
            let m = digits(&mut x);
            let n = digits(&mut y);
            // Without zeros before it the longer number is the larger one, however many digits it has.
            m.len().cmp(&n.len()).then_with(|| m.cmp(n))
        } else {
            (x, y) = (&x[first.len_utf8()..], &y[second.len_utf8()..]);
            // A folder's files come before those of a folder whose name only begins alike.
            (first != '/', first).cmp(&(second != '/', second))
        };
        if order != Ordering::Equal {
            return order;
        }
    }
}

/// Takes the digits that a text begins with; without the zeros before them.
fn digits<'a>(text: &mut &'a str) -> &'a str {
    let end = text.bytes().position(|b| !b.is_ascii_digit()).unwrap_or(text.len());
    let (number, rest) = text.split_at(end);
    *text = rest;
    number.trim_start_matches('0')
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_in_names_count_as_numbers() {
        let names = "b/1.csv a/P10_2.csv a/P2_10.csv a/P2_9.csv a/P02_1.csv a1/x a/P2_1.csv";
        let names: Vec<PathBuf> = names.split(' ').map(PathBuf::from).collect();
        let sorted = in_order(&names);
        let sorted: Vec<&str> = sorted.iter().map(|path| path.to_str().unwrap()).collect();
        let expect = "a/P02_1.csv a/P2_1.csv a/P2_9.csv a/P2_10.csv a/P10_2.csv a1/x b/1.csv";
        assert_eq!(sorted.join(" "), expect);
    }
}
