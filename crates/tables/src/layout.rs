//! How a table is laid out on paper: its size, where headings and texts wrap, and how its columns
//! are divided among several tables if one is not wide enough.
//!
//! Widths are in digits of the size the table is set in ([`crate::width`]).

use crate::shown::{Cell, Shown, WITH_SD};
use crate::width::width;
use std::collections::{BTreeMap, BTreeSet};

/// What a page has room for: LaTeX's own `article`, whose text block is the narrowest in common
/// use.
struct Page {
    /// Width of the text block.
    digits: f64,
    /// Gap between two columns.
    gap_digits: f64,
}

/// Set in the size of the text: at 11 pt a block of 360 pt, digits of 5.48 pt, gaps of 12 pt (a
/// little more at 10 and at 12 pt).
const ROOMY: Page = Page { digits: 65.7, gap_digits: 2.4 };
/// Set small: at 12 pt a block of 390 pt, digits of 5 pt, gaps of 8 pt, which are wider at 10 pt.
const DENSE: Page = Page { digits: 78.0, gap_digits: 1.9 };
/// A column of 252 pt, as journals of engineering have it, in digits of 10 pt.
const COLUMN_DIGITS: f64 = 50.0;
/// Lines of headings, where a table has room at the size of the text.
const ROOMY_HEAD_LINES: [usize; 3] = [1, 2, usize::MAX];
/// No text is wrapped to less than this, where its table can be set in one…
const NARROWEST_TEXT_DIGITS: f64 = 11.0;
/// …and no text is set wider than this if it cannot.
const WIDEST_TEXT_DIGITS: f64 = 22.0;
/// The columns that say what a row is about may take this share of each of several tables.
const KEYS_SHARE: f64 = 0.5;
/// Several tables are made of about one width, if that takes no more of them: the first of these
/// shares of the page.
const EVEN_SHARES: [f64; 4] = [0.7, 0.8, 0.9, 1.0];
/// Lines of one page, with room for caption and notes.
const PAGE_LINES: usize = 38;
/// Lines kept for caption and notes.
const CAPTION_LINES: usize = 10;
/// Lines that heading and rules of a table take beside its rows.
const FRAME_LINES: usize = 3;

/// A table on paper.
#[derive(Debug)]
pub(crate) struct Layout<'a> {
    /// Whether it is set small.
    pub(crate) dense: bool,
    /// Whether it needs more than a page.
    pub(crate) long: bool,
    /// Tables to be set one below the other; the columns that say what a row is about stand in
    /// each.
    pub(crate) groups: Vec<Vec<Placed<'a>>>,
    /// Headings among the rows, by the row they stand above, where the first columns became such.
    pub(crate) sections: Sections,
    /// What was left out of them because it is the same in every row, in words.
    pub(crate) notes: Vec<String>,
}

impl Layout<'_> {
    /// Whether it fits a column of a page with two, where no text was wrapped to a wider one.
    pub(crate) fn fits_a_column(&self) -> bool {
        let page = Page { digits: COLUMN_DIGITS, ..ROOMY };
        !self.long
            && self.groups.iter().all(|group| {
                fits(group, &page) && group.iter().all(|placed| placed.share.is_none())
            })
    }
}

/// Headings among the rows of a table, by the row they stand above.
pub(crate) type Sections = BTreeMap<usize, String>;

/// A column in its place.
#[derive(Debug, Clone)]
pub(crate) struct Placed<'a> {
    /// The column.
    pub(crate) column: &'a Shown,
    /// Its heading, line by line.
    pub(crate) head: Vec<String>,
    /// The share of the page's width it has, if its texts wrap.
    pub(crate) share: Option<f64>,
}

/// The first that fits of: headings on one line, or more; small and texts wrapped; the first
/// columns as headings among the rows; several tables.
pub(crate) fn layout(columns: &[Shown]) -> Layout<'_> {
    let all: Vec<&Shown> = columns.iter().collect();
    for lines in ROOMY_HEAD_LINES {
        let columns: Vec<Placed> = all.iter().map(|c| placed_in(c, lines)).collect();
        if fits(&columns, &ROOMY) {
            return finished(false, vec![columns], Vec::new());
        }
    }
    let wrapped = all.iter().map(|c| place_column(c)).collect();
    match squeezed(wrapped, &DENSE, NARROWEST_TEXT_DIGITS) {
        Some(squeezed) => finished(true, vec![squeezed], Vec::new()),
        None => sectioned(&all).unwrap_or_else(|| several(&all)),
    }
}

fn finished<'a>(dense: bool, groups: Vec<Vec<Placed<'a>>>, notes: Vec<String>) -> Layout<'a> {
    let lines: usize = groups.iter().map(|g| lines(g)).sum();
    Layout { dense, long: lines > PAGE_LINES, groups, sections: Sections::new(), notes }
}

/// The column with its heading in as many lines as it takes to be no wider than the cells, or than
/// its longest word.
fn place_column(column: &Shown) -> Placed<'_> {
    placed_in(column, usize::MAX)
}

/// The column with its heading in no more than so many lines.
fn placed_in(column: &Shown, lines: usize) -> Placed<'_> {
    let tokens: Vec<&str> = column.words.split(' ').chain(column.unit.as_deref()).collect();
    let mut room = tokens.iter().map(|t| width(t)).fold(column.widest, f64::max);
    let mut head = broken(&tokens, room);
    // This ends: where the whole heading has room it is one line.
    while head.len() > lines {
        room += 1.0;
        head = broken(&tokens, room);
    }
    Placed { column, head, share: None }
}

/// Words in lines of some width.
fn broken(tokens: &[&str], room: f64) -> Vec<String> {
    let mut lines: Vec<String> = Vec::new();
    for token in tokens {
        match lines.last_mut() {
            Some(line) if width(line) + width(" ") + width(token) <= room => {
                *line += &format!(" {token}")
            }
            _ => lines.push((*token).to_owned()),
        }
    }
    lines
}

/// Width of a column whose texts do not wrap.
fn natural(placed: &Placed) -> f64 {
    placed.head.iter().map(|line| width(line)).fold(placed.column.widest, f64::max)
}

/// Width below which a column cannot go.
fn least(placed: &Placed, narrowest_text: f64) -> f64 {
    if placed.column.numeric {
        return natural(placed);
    }
    let head = placed.head.iter().map(|line| width(line));
    head.fold(narrowest_text.max(placed.column.longest_word), f64::max).min(natural(placed))
}

fn gaps(columns: usize, page: &Page) -> f64 {
    page.gap_digits * columns.saturating_sub(1) as f64
}

fn fits(columns: &[Placed], page: &Page) -> bool {
    columns.iter().map(natural).sum::<f64>() + gaps(columns.len(), page) <= page.digits
}

/// The columns with texts wrapped so that all fits, if it can: what the page has beyond the least
/// widths is shared out by how far each text is from its natural width.
fn squeezed<'a>(
    mut columns: Vec<Placed<'a>>,
    page: &Page,
    narrowest_text: f64,
) -> Option<Vec<Placed<'a>>> {
    if fits(&columns, page) {
        return Some(columns);
    }
    let least_all: f64 = columns.iter().map(|c| least(c, narrowest_text)).sum();
    let spare = page.digits - gaps(columns.len(), page) - least_all;
    let wanted: f64 = columns.iter().map(|c| natural(c) - least(c, narrowest_text)).sum();
    if spare < 0.0 {
        return None;
    }
    // `wanted` is not 0 here: as wide as they would be the columns do not fit, and at the least
    // they do.
    for column in &mut columns {
        let least = least(column, narrowest_text);
        let natural = natural(column);
        if least < natural {
            column.share = Some((least + spare * (natural - least) / wanted) / page.digits);
        }
    }
    Some(columns)
}

/// One table whose first texts, as many as stay the same over several rows, are headings above
/// these rows.
fn sectioned<'a>(all: &[&'a Shown]) -> Option<Layout<'a>> {
    let texts = all.iter().take_while(|c| !c.numeric).count();
    // As many as can be: each that goes leaves more room for the others.
    let (first, sections) =
        (1..=texts).rev().find_map(|first| Some((first, sections(&all[..first])?)))?;
    let rest = all[first..].iter().map(|c| place_column(c)).collect();
    let placed = squeezed(rest, &DENSE, NARROWEST_TEXT_DIGITS)?;
    let layout = finished(true, vec![placed], Vec::new());
    let long = layout.long || lines(&layout.groups[0]) + sections.len() > PAGE_LINES;
    Some(Layout { sections, long, ..layout })
}

/// The rows at which one of the columns changes; `None` if no column changes, if they change at
/// more than every other row, or if a value comes back.
fn sections(columns: &[&Shown]) -> Option<Sections> {
    let titles: Vec<String> = (0..columns[0].cells.len())
        .map(|row| columns.iter().map(|c| in_words(c, row)).collect::<Vec<_>>().join(", "))
        .collect();
    let begins = |row: &usize| *row == 0 || titles[*row] != titles[row - 1];
    let sections: Sections =
        (0..titles.len()).filter(begins).map(|row| (row, titles[row].clone())).collect();
    let distinct: BTreeSet<&String> = titles.iter().collect();
    let several = sections.len() > 1 && 2 * sections.len() <= titles.len();
    (several && distinct.len() == sections.len()).then_some(sections)
}

/// Several tables: what is the same in every row is said once, the columns that say what a row is
/// about stand in each.
fn several<'a>(all: &[&'a Shown]) -> Layout<'a> {
    // If every column is, all stay: a table needs something to show.
    let one_row = all.iter().all(|c| is_same(c));
    let (same, varying): (Vec<&Shown>, Vec<&Shown>) =
        all.iter().partition(|c| is_same(c) && !one_row);
    let keys = keys(&varying, |keys| room(keys) <= KEYS_SHARE * DENSE.digits);
    let mut others = varying;
    // By their place in memory: two columns may well be alike.
    others.retain(|column| !keys.iter().any(|key| std::ptr::eq(*key, *column)));
    let with_keys =
        |group: &[&'a Shown]| keys.iter().chain(group).map(|c| place_column(c)).collect::<Vec<_>>();
    let packed =
        |share: f64| packed(&others, |group| capped_fits(&with_keys(group), share * DENSE.digits));
    // No more tables than there must be, and of these the narrowest ones: they come out of one
    // width.
    let fewest = packed(1.0).len();
    let even = EVEN_SHARES.map(packed).into_iter().find(|g| g.len() == fewest);
    let groups = even.filter(|g| !g.is_empty()).unwrap_or_else(|| vec![Vec::new()]);
    let groups =
        groups.iter().map(|g| with_keys(g)).map(|g| squeezed(g.clone(), &DENSE, 0.0).unwrap_or(g));
    finished(true, groups.collect(), notes(&same))
}

/// The columns in groups that fit, each filled before the next is begun.
fn packed<'a>(columns: &[&'a Shown], fits: impl Fn(&[&'a Shown]) -> bool) -> Vec<Vec<&'a Shown>> {
    let mut groups: Vec<Vec<&Shown>> = Vec::new();
    for block in blocks(columns) {
        match groups.last_mut() {
            Some(group) if fits(&[group.as_slice(), &block].concat()) => group.extend(&block),
            // In as many parts as it needs to fit.
            _ => {
                let mut parts: Vec<Vec<&Shown>> = vec![Vec::new()];
                for column in block {
                    match parts.last_mut() {
                        Some(part)
                            if part.is_empty() || fits(&[part.as_slice(), &[column]].concat()) =>
                        {
                            part.push(column);
                        }
                        _ => parts.push(vec![column]),
                    }
                }
                groups.extend(parts);
            }
        }
    }
    groups
}

/// Whether the columns fit into a width when long texts are wrapped.
fn capped_fits(columns: &[Placed], digits: f64) -> bool {
    let widths = columns.iter().map(|c| match c.column.numeric {
        true => natural(c),
        false => least(c, WIDEST_TEXT_DIGITS),
    });
    widths.sum::<f64>() + gaps(columns.len(), &DENSE) <= digits
}

/// Whether each of several rows has the same in this column.
fn is_same(column: &Shown) -> bool {
    column.cells.len() > 1 && column.cells.windows(2).all(|pair| pair[0] == pair[1])
}

/// The columns that say what a row is about: texts and whole numbers in front, to the last text
/// among them; where they do not fit, only as many as tell the rows apart.
pub(crate) fn keys<'a>(
    columns: &[&'a Shown],
    fits: impl Fn(&[&'a Shown]) -> bool,
) -> Vec<&'a Shown> {
    let front = columns.iter().take_while(|c| !c.fractional).count();
    let to_last_text = columns[..front].iter().rposition(|c| !c.numeric).map_or(0, |last| last + 1);
    let mut keys = columns[..to_last_text].to_vec();
    let mut at = keys.len();
    while !fits(&keys) && at > 0 {
        at -= 1;
        let fewer = [&keys[..at], &keys[at + 1..]].concat();
        // One goes without which rows are told apart as well, or are not told apart anyhow.
        if tell_apart(&fewer) || !tell_apart(&keys) {
            keys = fewer;
        }
    }
    keys
}

/// Width of columns set small, each with a gap.
fn room(columns: &[&Shown]) -> f64 {
    columns.iter().map(|c| natural(&place_column(c)) + DENSE.gap_digits).sum()
}

fn tell_apart(columns: &[&Shown]) -> bool {
    let height = columns.first().map_or(0, |c| c.cells.len());
    let mut rows: Vec<Vec<String>> =
        (0..height).map(|row| columns.iter().map(|c| c.cells[row].typeset()).collect()).collect();
    rows.sort();
    height > 0 && rows.windows(2).all(|pair| pair[0] != pair[1])
}

/// Neighbours that belong together: their words begin with those of the first of them (`stiffness`,
/// `stiffness CI low`).
fn blocks<'a>(columns: &[&'a Shown]) -> Vec<Vec<&'a Shown>> {
    let mut blocks: Vec<Vec<&Shown>> = Vec::new();
    for column in columns {
        let block = blocks.last_mut().filter(|block| {
            let quantity = block[0].words.trim_end_matches(WITH_SD);
            column.words.starts_with(&format!("{quantity} "))
        });
        match block {
            Some(block) => block.push(column),
            None => blocks.push(vec![column]),
        }
    }
    blocks
}

/// `In every row: participant P01, source twin. Without any value: oscillation.`
fn notes(same: &[&Shown]) -> Vec<String> {
    let (empty, full): (Vec<&Shown>, Vec<&Shown>) =
        same.iter().partition(|c| c.cells[0] == Cell::Missing);
    let full: Vec<String> = full.iter().map(|c| in_words(c, 0)).collect();
    let empty: Vec<String> = empty.iter().map(|c| c.words.clone()).collect();
    let mut notes = Vec::new();
    for (words, parts) in [("In every row", full), ("Without any value", empty)] {
        if !parts.is_empty() {
            notes.push(format!("{words}: {}.", parts.join(", ")));
        }
    }
    notes
}

/// A cell with what it is: `participant P01`, `work space hits low 0`.
fn in_words(column: &Shown, row: usize) -> String {
    let unit = column.unit.as_deref().map(|u| format!(" {}", u.trim_matches(['(', ')'])));
    format!("{} {}{}", column.words, column.cells[row].typeset(), unit.unwrap_or_default())
}

/// Whether a table has room on one page, without caption and notes.
pub(crate) fn has_page(columns: &[Placed]) -> bool {
    lines(columns) <= PAGE_LINES + CAPTION_LINES
}

/// Lines a table takes, texts wrapped.
pub(crate) fn lines(columns: &[Placed]) -> usize {
    let head = columns.iter().map(|c| c.head.len()).max().unwrap_or(0);
    let height = columns.first().map_or(0, |c| c.column.cells.len());
    let rows = (0..height).map(|row| {
        let lines = columns.iter().map(|placed| match placed.share {
            Some(share) => {
                let text = placed.column.cells[row].typeset();
                (width(&text) / (share * DENSE.digits)).ceil() as usize
            }
            None => 1,
        });
        // An empty cell has no line, but its row has one.
        lines.max().unwrap_or(1).max(1)
    });
    FRAME_LINES + head + rows.sum::<usize>()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::shown::{shown, tests::sample};
    use crate::{Column, Table};

    /// What each row says of itself, one column that is the same in all, and `numbers` columns.
    fn wide(numbers: usize, height: i64) -> Vec<Shown> {
        const NAMES: [&str; 6] = [
            "force_max_n",
            "force_max_sd_n",
            "loop_area_j",
            "velocity_peak_m_s",
            "share",
            "dwell_s",
        ];
        let text = |i: i64| Some(if i % 2 == 0 { "active" } else { "passive" }.to_owned());
        let mut columns = vec![
            Column::text("source", "", (0..height).map(|_| Some("twin".to_owned()))),
            Column::integer("trial", "1", "", (0..height).map(Some)),
            Column::text("mode", "", (0..height).map(text)),
            Column::integer("n", "1", "", (0..height).map(|i| Some(i % 3))),
        ];
        let number = |i: usize| {
            Column::float(
                NAMES[i % NAMES.len()],
                "1",
                "",
                (0..height).map(|row| Some(1.5 + row as f64)),
            )
        };
        columns.extend((0..numbers).map(number));
        // Names are unique in a frame; headings need not be, so that each stands here for itself.
        columns
            .iter_mut()
            .enumerate()
            .for_each(|(i, c)| c.field.name = format!("{}_{i}", c.field.name).into());
        shown(&Table::new("wide", "Wide", columns).unwrap(), None)
    }

    fn words<'a>(group: &[Placed<'a>]) -> Vec<&'a str> {
        group.iter().map(|c| c.column.words.as_str()).collect()
    }

    fn taken(group: &[Placed]) -> f64 {
        let width = |c: &Placed| c.share.map_or_else(|| natural(c), |share| share * DENSE.digits);
        group.iter().map(width).sum::<f64>() + gaps(group.len(), &DENSE)
    }

    fn texts(cells: &[&str]) -> Vec<Option<String>> {
        cells.iter().map(|c| Some((*c).to_owned())).collect()
    }

    #[test]
    fn a_small_table_is_set_in_the_size_of_the_text_with_low_headings() {
        let columns = shown(&sample(), None);
        let layout = layout(&columns);
        assert!(!layout.dense && !layout.long && layout.notes.is_empty());
        assert_eq!(layout.groups.len(), 1);
        assert!(layout.groups[0].iter().all(|c| c.head.len() <= 2 && c.share.is_none()));
    }

    #[test]
    fn each_column_of_a_wide_table_stands_in_one_group_or_is_said_once() {
        let columns = wide(20, 5);
        let layout = layout(&columns);
        assert!(layout.groups.len() > 1);
        assert_eq!(layout.notes, ["In every row: source 0 twin."]);
        let mut all: Vec<&str> = words(&layout.groups[0]);
        for group in &layout.groups {
            assert_eq!(words(group)[..2], ["trial 1", "mode 2"], "these say what a row is about");
            assert!(taken(group) <= DENSE.digits, "{} {:?}", taken(group), words(group));
        }
        all.extend(layout.groups[1..].iter().flat_map(|g| words(&g[2..])));
        assert_eq!(all, columns[1..].iter().map(|c| c.words.as_str()).collect::<Vec<_>>());
    }

    #[test]
    fn rows_that_differ_in_nothing_or_only_in_their_keys_are_still_a_table() {
        let long =
            "what every row says in so many words that it takes more than one line of any page";
        for (first, expect) in [(["a", "b"], 1), (["a", "a"], 4)] {
            let names = ["first", "second", "third", "fourth"];
            let cells = |i: usize| texts(&if i == 0 { first } else { [long; 2] });
            let columns =
                names.into_iter().enumerate().map(|(i, n)| Column::text(n, "", cells(i))).collect();
            let columns = shown(&Table::new("t", "T", columns).unwrap(), None);
            let layout = several(&columns.iter().collect::<Vec<_>>());
            let all: usize = layout.groups.iter().map(|g| g.len()).sum();
            assert_eq!((layout.groups.is_empty(), all.min(expect)), (false, expect));
        }
    }

    #[test]
    fn columns_of_one_quantity_stay_together() {
        let column = |words: &str| Shown { words: words.to_owned(), ..wide(1, 2).swap_remove(4) };
        let columns = ["stiffness", "stiffness CI low", "stiffness CI high", "stiff", "loop area"]
            .map(column);
        let blocks: Vec<usize> =
            blocks(&columns.iter().collect::<Vec<_>>()).iter().map(Vec::len).collect();
        assert_eq!(blocks, [3, 1, 1]);
    }

    #[test]
    fn a_table_is_long_when_its_groups_together_need_more_than_a_page() {
        assert!(!layout(&wide(20, 5)).long);
        assert!(layout(&wide(20, 12)).long);
        assert!(layout(&wide(1, 60)).long);
    }

    #[test]
    fn long_texts_wrap_into_what_the_page_has_left() {
        let sentence =
            "a sentence that would take most of a line of the page, and then goes on to a second";
        let columns = vec![
            Column::text("quantity", "", texts(&["mass", "damping"])),
            Column::float("value", "1", "", [Some(1.0), Some(2.5)]),
            Column::text("remark", "", texts(&[sentence, "none"])),
        ];
        let columns = shown(&Table::new("t", "T", columns).unwrap(), None);
        let layout = layout(&columns);
        assert_eq!(layout.groups.len(), 1);
        let shares: Vec<bool> = layout.groups[0].iter().map(|c| c.share.is_some()).collect();
        assert_eq!(shares, [false, false, true]);
        assert!((taken(&layout.groups[0]) - DENSE.digits).abs() < 1e-9);
    }

    #[test]
    fn first_texts_that_stay_the_same_become_headings_where_that_makes_room() {
        let long = ["a long text to be wrapped within its cell"; 4];
        let mut columns = vec![
            Column::text("actuation", "", texts(&["passive", "passive", "active", "active"])),
            Column::text("claim", "", texts(&["safe", "light", "strong", "unsafe"])),
        ];
        for name in ["first", "second", "third", "fourth", "fifth"] {
            columns.push(Column::text(name, "", texts(&long)));
        }
        let columns = shown(&Table::new("t", "T", columns).unwrap(), None);
        let layout = layout(&columns);
        let expect = [(0, "actuation passive".to_owned()), (2, "actuation active".to_owned())];
        assert_eq!(layout.sections, BTreeMap::from(expect));
        assert_eq!(words(&layout.groups[0])[0], "claim");
    }

    #[test]
    fn what_comes_back_further_down_is_no_heading() {
        let column = |cells: &[&str]| {
            let column = Column::text("mode", "", texts(cells));
            shown(&Table::new("t", "T", vec![column]).unwrap(), None).swap_remove(0)
        };
        assert_eq!(sections(&[&column(&["a", "a", "b", "b", "a", "a"])]), None);
        assert_eq!(sections(&[&column(&["a", "a", "b", "c"])]), None);
        assert_eq!(sections(&[&column(&["a", "a", "a", "a"])]), None);
        assert_eq!(sections(&[&column(&["a", "a", "b", "b"])]).unwrap().len(), 2);
    }

    #[test]
    fn keys_that_take_too_much_room_are_those_that_tell_rows_apart() {
        let long = "a name of quite some length for a key";
        let columns = vec![
            Column::text("first", "", texts(&["a", "b", "c"])),
            Column::text("second", "", texts(&[long, long, "other"])),
            Column::float("value", "1", "", [Some(1.0); 3]),
        ];
        let columns = shown(&Table::new("t", "T", columns).unwrap(), None);
        let keys = keys(&columns.iter().collect::<Vec<_>>(), |keys| {
            room(keys) <= KEYS_SHARE * DENSE.digits
        });
        assert_eq!(keys.iter().map(|c| c.words.as_str()).collect::<Vec<_>>(), ["first"]);
    }

    #[test]
    fn a_heading_breaks_between_words_and_never_within_a_unit() {
        let column = Column::float("force_rms_error_n_per_rad", "N/rad", "", [Some(1.0)]);
        let columns = shown(&Table::new("t", "T", vec![column]).unwrap(), None);
        assert_eq!(place_column(&columns[0]).head, ["force", "RMS", "error", "(N/rad)"]);
    }
}
