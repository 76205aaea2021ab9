//! A table on a terminal: columns in line, no sign escaped, no wider than the window where leaving
//! out what matters least can help it.

use crate::shown::{Cell, Seen, Shown, rows};

/// Between two columns.
const GAP: &str = "  ";

/// The table, rounded for people. Where it is wider than `width` letters, columns with these words
/// are left out, the first ones first, and named below it.
pub(crate) fn terminal(
    &Seen { table, columns, .. }: &Seen,
    width: usize,
    least: &[&str],
) -> String {
    let mut kept: Vec<&Shown> = columns.iter().collect();
    let mut left_out = Vec::new();
    for words in least {
        if total(&kept) <= width {
            break;
        }
        if let Some(place) = kept.iter().position(|column| column.words == *words) {
            left_out.push(kept.remove(place).words.as_str());
        }
    }
    let widths: Vec<usize> = kept.iter().map(|column| widest(column)).collect();
    let heads = kept.iter().map(|column| column.heading()).collect();
    let cells = rows(kept.iter().copied(), |_, cell: &Cell| cell.typeset());
    let lines = std::iter::once(heads).chain(cells).map(|cells| line(&kept, &widths, cells));
    let lines: Vec<String> = lines.collect();
    let left_out = (!left_out.is_empty())
        .then(|| format!("Not shown, for want of width: {}.", left_out.join(", ")));
    let title = table.title().to_owned();
    let parts = [title, lines.join("\n")].into_iter().chain(left_out);
    parts.chain(table.notes().iter().cloned()).collect::<Vec<_>>().join("\n\n") + "\n"
}

fn line(columns: &[&Shown], widths: &[usize], cells: Vec<String>) -> String {
    let set = |((column, width), cell): ((&&Shown, &usize), String)| {
        let room = " ".repeat(width.saturating_sub(letters(&cell)));
        if column.numeric { room + &cell } else { cell + &room }
    };
    let cells: Vec<String> = columns.iter().zip(widths).zip(cells).map(set).collect();
    cells.join(GAP).trim_end().to_owned()
}

fn total(columns: &[&Shown]) -> usize {
    let gaps = GAP.len() * columns.len().saturating_sub(1);
    columns.iter().map(|column| widest(column)).sum::<usize>() + gaps
}

fn widest(column: &Shown) -> usize {
    let cells = column.cells.iter().map(|cell| letters(&cell.typeset()));
    cells.chain([letters(&column.heading())]).max().unwrap_or_default()
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
        Seen::of(&sample(), |seen| terminal(seen, width, least))
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

    #[test]
    fn what_matters_least_goes_first_and_is_named_and_the_rest_stays() {
        let whole = shown(200, &["trial", "slope std. error"]);
        assert!(!whole.contains("Not shown"), "{whole}");
        let narrow = shown(60, &["slope std. error", "trial"]);
        assert!(narrow.contains("Not shown, for want of width: slope std. error."), "{narrow}");
        assert!(narrow.contains("trial") && narrow.contains("−4.123"), "{narrow}");
        let narrowest = shown(1, &["slope std. error", "trial", "no such column"]);
        assert!(narrowest.contains("width: slope std. error, trial."), "{narrowest}");
        assert!(narrowest.contains("wall reached"), "{narrowest}");
    }
}
