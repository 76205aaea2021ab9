//! A table on a terminal: aligned columns, no character escaped. A table that is wider than the
//! window is printed in parts, one below the other; no column is lost and no number is broken.

use crate::layout::keys;
use crate::shown::{Cell, Seen, Shown, rows};

/// Between two columns.
const GAP: &str = "  ";
/// In a table of parts a text is wrapped that is wider, where its words are not.
const WIDEST_TEXT: usize = 28;

/// A column as it stands on a terminal.
struct Set<'a> {
    column: &'a Shown,
    width: usize,
    /// Its heading, line by line.
    head: Vec<String>,
}

/// The table, rounded for people. Where it is wider than `width` letters, it stands in parts that
/// repeat the columns which say what a row is about; columns with the words of `least` come last.
pub(crate) fn terminal(
    &Seen { table, columns, .. }: &Seen,
    width: usize,
    least: &[&str],
) -> String {
    let all: Vec<&Shown> = columns.iter().collect();
    let whole: Vec<Set> = all.iter().map(|column| unwrapped(column)).collect();
    let gaps = GAP.len() * whole.len().saturating_sub(1);
    // A terminal would part words and numbers of a sentence where its line ends.
    let mut blocks = vec![broken(table.title(), width).join("\n")];
    if whole.iter().map(|set| set.width).sum::<usize>() + gaps <= width {
        blocks.push(lines(&whole));
    } else {
        blocks.extend(groups(&all, width, least).iter().map(|group| lines(group)));
    }
    blocks.extend(table.notes().iter().map(|note| broken(note, width).join("\n")));
    blocks.join("\n\n") + "\n"
}

/// The columns of each part: what says what a row is about, and as many others as have room.
fn groups<'a>(all: &[&'a Shown], width: usize, least: &[&str]) -> Vec<Vec<Set<'a>>> {
    let half = width / 2;
    let narrow =
        |columns: &[&Shown]| columns.iter().map(|c| wrapped(c).width + GAP.len()).sum::<usize>();
    let keys = keys(all, |columns| narrow(columns) <= half);
    let mut others: Vec<&Shown> = all.to_vec();
    // By their place in memory: two columns may well be alike.
    others.retain(|column| !keys.iter().any(|key| std::ptr::eq(*key, *column)));
    // Least by least, from the front of the list: the sort keeps the order of all others.
    others.sort_by_key(|column| {
        let place = least.iter().position(|words| *words == column.words);
        place.map_or(0, |place| least.len() - place)
    });
    let mut groups: Vec<Vec<&Shown>> = Vec::new();
    for column in others {
        // A gap is counted behind each column, and the last of a line has none.
        match groups.last_mut() {
            Some(group)
                if narrow(&keys) + narrow(group) + narrow(&[column]) - GAP.len() <= width =>
            {
                group.push(column);
            }
            _ => groups.push(vec![column]),
        }
    }
    if groups.is_empty() {
        groups.push(Vec::new());
    }
    groups.iter().map(|group| keys.iter().chain(group).map(|c| wrapped(c)).collect()).collect()
}

fn unwrapped(column: &Shown) -> Set<'_> {
    let cells = column.cells.iter().map(|cell| letters(&cell.typeset()));
    let heading = column.heading();
    let width = cells.chain([letters(&heading)]).max().unwrap_or_default();
    Set { column, width, head: vec![heading] }
}

/// A column as narrow as its numbers and its words allow.
fn wrapped(column: &Shown) -> Set<'_> {
    let heading = column.heading();
    let cells = column.cells.iter().map(|cell| {
        let text = cell.typeset();
        match cell {
            Cell::Text(_) => letters(&text).min(WIDEST_TEXT.max(longest_word(&text))),
            _ => letters(&text),
        }
    });
    let width = cells.chain([longest_word(&heading)]).max().unwrap_or_default();
    Set { column, width, head: broken(&heading, width) }
}

fn longest_word(text: &str) -> usize {
    text.split(' ').map(letters).max().unwrap_or_default()
}

/// A text in lines of so many letters, parted between words.
fn broken(text: &str, width: usize) -> Vec<String> {
    let mut lines: Vec<String> = Vec::new();
    for word in text.split(' ') {
        match lines.last_mut() {
            Some(line) if letters(line) + 1 + letters(word) <= width => {
                line.push(' ');
                line.push_str(word);
            }
            _ => lines.push(word.to_owned()),
        }
    }
    lines
}

/// Headings and rows, one below the other.
fn lines(columns: &[Set]) -> String {
    let tallest = columns.iter().map(|set| set.head.len()).max().unwrap_or_default();
    let head = columns.iter().map(|set| {
        // Headings end above the first row.
        let above = vec![String::new(); tallest - set.head.len()];
        above.into_iter().chain(set.head.iter().cloned()).collect()
    });
    let mut all = in_line(columns, head.collect());
    let texts = rows(columns.iter().map(|set| set.column), |_, cell| cell.typeset());
    for row in texts {
        let cells = columns.iter().zip(row).map(|(set, text)| match set.column.numeric {
            true => vec![text],
            false => broken(&text, set.width),
        });
        all.extend(in_line(columns, cells.collect()));
    }
    all.join("\n")
}

/// Cells of several lines beside each other.
fn in_line(columns: &[Set], cells: Vec<Vec<String>>) -> Vec<String> {
    let tallest = cells.iter().map(Vec::len).max().unwrap_or_default();
    (0..tallest)
        .map(|i| {
            let parts = columns.iter().zip(&cells).map(|(set, lines)| {
                let text = lines.get(i).map_or("", String::as_str);
                let room = " ".repeat(set.width.saturating_sub(letters(text)));
                if set.column.numeric { room + text } else { text.to_owned() + &room }
            });
            parts.collect::<Vec<_>>().join(GAP).trim_end().to_owned()
        })
        .collect()
}

/// Places that a text takes on a terminal, of the letters that tables have: a sign above another
/// takes none.
fn letters(text: &str) -> usize {
    text.chars().filter(|letter| !('\u{300}'..='\u{36f}').contains(letter)).count()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::shown::tests::sample;

    fn shown(width: usize, least: &[&str]) -> String {
        Seen::of(&sample(), None, |seen| terminal(seen, width, least))
    }

    #[test]
    fn columns_stand_in_line_without_escapes() {
        let told = shown(200, &[]);
        let lines: Vec<&str> = told.lines().collect();
        assert_eq!(lines[0], "Slope, 100 %");
        assert!(lines[3].starts_with("a|b & <c>"), "{told}");
        let ends = |line: &str, words: &str| {
            let at = line.find(words).unwrap() + words.len();
            letters(&line[..at])
        };
        assert_eq!(ends(lines[2], "trial"), ends(lines[3], "−3"), "{told}");
        assert_eq!(ends(lines[2], "error (N/rad)"), ends(lines[3], "0.032"), "{told}");
        assert!(lines.iter().all(|line| *line == line.trim_end()), "{told}");
    }

    /// The length of the longest line.
    fn widest(told: &str) -> usize {
        told.lines().map(letters).max().unwrap()
    }

    #[test]
    fn a_narrow_window_has_every_column_in_parts_and_the_least_last() {
        let whole = shown(200, &["trial", "slope std. error"]);
        assert_eq!(whole.matches("a|b & <c>").count(), 1, "{whole}");
        let narrow = shown(40, &["slope std. error"]);
        assert_eq!(narrow.matches("a|b & <c>").count(), 2, "what a row is about is repeated");
        for words in ["trial", "slope", "wall", "reached", "−4.123", "0.032", "yes"] {
            assert!(narrow.contains(words), "{words}: {narrow}");
        }
        assert!(widest(&narrow) <= 40, "{narrow}");
        assert!(narrow.find("0.032") > narrow.find("yes"), "what matters least comes last");
        let narrowest = shown(1, &[]);
        assert!(narrowest.contains("−4.123") && narrowest.contains("yes"), "{narrowest}");
    }

    #[test]
    fn long_texts_are_wrapped_between_words_and_numbers_are_not() {
        let text = "a sentence of many words that is far wider than any window of eighty letters is, and goes on";
        let number = |name| crate::Column::float(name, "N", "", [Some(1_234.567_8), None]);
        let mut columns = vec![
            crate::Column::text("mode", "", ["active", "hybrid"].map(|v| Some(v.to_owned()))),
            crate::Column::text("why", "", [Some(text.to_owned()), None]),
        ];
        columns.extend(["force_n", "peak_force_n", "mean_force_n", "last_force_n"].map(number));
        let table = crate::Table::new("t", "T", columns).unwrap();
        let told = Seen::of(&table, None, |seen| terminal(seen, 80, &[]));
        assert!(widest(&told) <= 80, "{told}");
        assert_eq!(told.matches("1234.5678").count() + told.matches("1235").count(), 4, "{told}");
        let words: Vec<&str> = told.split_whitespace().collect();
        assert!(text.split(' ').all(|word| words.contains(&word)), "{told}");
    }
}
