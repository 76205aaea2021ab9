//! Words in letters five rows high, legible from where the lever is.

/// Rows of a letter.
pub(super) const ROWS: usize = 5;
/// Cells that a point of a letter takes: a cell is twice as high as wide.
const CELLS: usize = 2;
/// Points of a letter's row.
const POINTS: usize = 3;

/// The letters that are needed, each by its rows of three points.
const LETTERS: [(char, [&str; ROWS]); 24] = [
    ('0', ["###", "#.#", "#.#", "#.#", "###"]),
    ('1', [".#.", "##.", ".#.", ".#.", "###"]),
    ('2', ["###", "..#", "###", "#..", "###"]),
    ('3', ["###", "..#", ".##", "..#", "###"]),
    ('4', ["#.#", "#.#", "###", "..#", "..#"]),
    ('5', ["###", "#..", "###", "..#", "###"]),
    ('6', ["###", "#..", "###", "#.#", "###"]),
    ('7', ["###", "..#", "..#", "..#", "..#"]),
    ('8', ["###", "#.#", "###", "#.#", "###"]),
    ('9', ["###", "#.#", "###", "..#", "###"]),
    ('A', [".#.", "#.#", "###", "#.#", "#.#"]),
    ('D', ["##.", "#.#", "#.#", "#.#", "##."]),
    ('E', ["###", "#..", "##.", "#..", "###"]),
    ('G', ["###", "#..", "#.#", "#.#", "###"]),
    ('I', ["###", ".#.", ".#.", ".#.", "###"]),
    ('N', ["##.", "#.#", "#.#", "#.#", "#.#"]),
    ('O', ["###", "#.#", "#.#", "#.#", "###"]),
    ('P', ["##.", "#.#", "##.", "#..", "#.."]),
    ('R', ["##.", "#.#", "##.", "#.#", "#.#"]),
    ('S', [".##", "#..", ".#.", "..#", "##."]),
    ('T', ["###", ".#.", ".#.", ".#.", ".#."]),
    ('U', ["#.#", "#.#", "#.#", "#.#", "###"]),
    ('W', ["#.#", "#.#", "#.#", "###", "#.#"]),
    ('Y', ["#.#", "#.#", ".#.", ".#.", ".#."]),
];

/// A word in large letters, a row after the other; a letter that is not known is empty.
pub(super) fn big(word: &str) -> Vec<String> {
    (0..ROWS).map(|row| letters(word, row)).collect()
}

fn letters(word: &str, row: usize) -> String {
    let mut letters: Vec<String> = Vec::new();
    for c in word.chars() {
        let points = points(c)[row].chars().map(|point| if point == '#' { "█" } else { " " });
        letters.push(points.map(|point| point.repeat(CELLS)).collect());
    }
    letters.join(&" ".repeat(CELLS))
}

fn points(c: char) -> [&'static str; ROWS] {
    let letter = LETTERS.iter().find(|(letter, _)| *letter == c);
    letter.map_or(["..."; ROWS], |(_, points)| *points)
}

/// Cells that a word takes.
pub(super) fn big_width(word: &str) -> usize {
    (word.chars().count() * (POINTS + 1)).saturating_sub(1) * CELLS
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_word_is_five_rows_as_wide_as_it_is_said_to_be() {
        for word in ["GO", "READY", "12", ""] {
            let rows = big(word);
            assert_eq!(rows.len(), ROWS);
            assert!(rows.iter().all(|row| row.chars().count() == big_width(word)), "{rows:#?}");
        }
    }

    #[test]
    fn no_two_letters_look_alike_but_the_o_and_the_nought() {
        let all: Vec<_> = LETTERS.iter().collect();
        for (i, (a, of_a)) in all.iter().enumerate() {
            assert!(of_a.iter().all(|row| row.len() == POINTS), "{a}");
            for (b, of_b) in &all[i + 1..] {
                assert!((*a, *b) == ('0', 'O') || of_a != of_b, "{a} {b}");
            }
        }
    }
}
