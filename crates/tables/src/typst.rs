//! Typst: a figure with tables, to be included in a document.

use crate::layout::{Placed, Sections, has_page};
use crate::rounding::Decimal;
use crate::shown::{Cell, Seen, one_line, rows};
use crate::symbol::{Piece, pieces};
use crate::width::Room;

/// Tables that are small: their size and gaps.
const DENSE: &str = "    set text(0.8em)\n    set table(inset: (x: 0.4em, y: 0.4em))\n";
/// Digits in a row that are read without a gap.
const UNGROUPED: usize = 4;
/// Digits between two gaps.
const GROUP: usize = 3;
/// A thin space that does not break.
const GAP: char = '\u{202f}';

/// The table as a Typst figure with caption and label `<tab:name>`, three rules, the notes below.
/// Rounded for people; numbers are aligned at the point.
///
/// It is laid out as in [`crate::latex`]: what is wide is set small, long texts wrap, and columns
/// that still do not fit stand in further tables of the figure. One that needs more than a page
/// breaks, with its headings on each.
///
/// Every text is a Typst string, which has no markup: only the quote and the backslash need an
/// escape.
pub(crate) fn typst(&Seen { table, layout, .. }: &Seen) -> String {
    let mut tables = Vec::new();
    for group in &layout.groups {
        let table = one(group, &layout.sections);
        // On one page if that has room for it.
        tables.push(match has_page(group) {
            true => format!("    block(breakable: false, {table})\n"),
            false => format!("    {table}\n"),
        });
    }
    let mut notes = String::new();
    for note in layout.notes.iter().chain(table.notes()) {
        notes += &format!("    align(left, block(text(0.85em, {})))\n", expression(note));
    }
    let figure = format!(
        "#figure(
  kind: table,
  caption: figure.caption(position: top, {caption}),
  {{
    set par(justify: false)
{size}{tables}{notes}  }},
) <tab:{label}>
",
        caption = expression(table.title()),
        size = if layout.dense { DENSE } else { "" },
        tables = tables.join("    v(0.5em)\n"),
        label = label(table.name()),
    );
    match layout.long {
        true => {
            format!("#[\n#show figure.where(kind: table): set block(breakable: true)\n{figure}]\n")
        }
        false => figure,
    }
}

fn one(group: &[Placed], sections: &Sections) -> String {
    let widths: Vec<String> = group.iter().map(width).collect();
    let align = |placed: &Placed| if placed.column.numeric { "right" } else { "left" };
    let alignment: Vec<&str> = group.iter().map(align).collect();
    let headings: Vec<String> = group.iter().map(heading).collect();
    let hidden: Vec<Vec<String>> = group.iter().map(|p| hidden(p.column.room)).collect();
    let rows = rows(group.iter().map(|p| p.column), |k, cell| set(&group[k], &hidden[k], cell));
    let mut body = String::new();
    for (i, cells) in rows.iter().enumerate() {
        if let Some(title) = sections.get(&i) {
            body += &format!(
                "      table.cell(colspan: {}, align: left, emph({})),\n",
                group.len(),
                expression(title)
            );
        }
        body += &format!("      {},\n", cells.join(", "));
    }
    format!(
        "table(
      columns: ({},),
      align: (x, y) => ({},).at(x) + if y == 0 {{ bottom }} else {{ top }},
      stroke: none,
      table.hline(),
      table.header({}),
      table.hline(stroke: 0.5pt),
{body}      table.hline(),
    )",
        widths.join(", "),
        alignment.join(", "),
        headings.join(", "),
    )
}

/// A column's width: its share of the page, rounded down so that all shares have room, or what its
/// cells need.
fn width(placed: &Placed) -> String {
    placed.share.map_or("auto".to_owned(), |s| format!("{:.1}%", (s * 1e3).floor() / 10.0))
}

/// Line by line; what stands on one line stays there.
fn heading(placed: &Placed) -> String {
    let lines: Vec<String> =
        placed.head.iter().map(|line| format!("box({})", expression(line))).collect();
    lines.join(" + linebreak() + ")
}

/// A cell; a number is followed by what makes it as long behind the point as the column's longest,
/// unseen.
fn set(placed: &Placed, hidden: &[String], cell: &Cell) -> String {
    match cell {
        Cell::Number(number) => {
            let decimals = number.mantissa.split_once('.').map_or(0, |(_, after)| after.len());
            let seen = Decimal { mantissa: grouped(&number.mantissa), ..*number };
            literal(&seen.typeset()) + hidden.get(decimals).map_or("", String::as_str)
        }
        Cell::Missing if placed.column.numeric => {
            format!("table.cell(align: center, {})", expression(&cell.typeset()))
        }
        Cell::Missing | Cell::Text(_) | Cell::Joined(_) => expression(&cell.typeset()),
    }
}

/// What follows a number of 0, 1, … decimals, unseen: what it lacks behind its point. Nothing in a
/// column with powers of ten, whose numbers end with those.
fn hidden(room: Room) -> Vec<String> {
    let zero = |decimals: usize| grouped(&format!("0.{}", "0".repeat(decimals)));
    let longest = zero(room.decimals);
    let shorter = (0..room.decimals).filter(|_| room.power == 0).map(zero);
    let lacking = shorter.map(|own| longest.chars().skip(own.chars().count()).collect::<String>());
    lacking.map(|zeros| format!(" + hide({})", literal(&zeros))).collect()
}

/// Digits in groups of three on both sides of the point, where there are more than four.
fn grouped(mantissa: &str) -> String {
    let (whole, decimals) = mantissa.split_once('.').unwrap_or((mantissa, ""));
    let (sign, whole) = whole.strip_prefix('-').map_or(("", whole), |digits| ("-", digits));
    // Groups are counted from the point, so the whole part is turned round and back.
    let from_point: String = whole.chars().rev().collect();
    let whole: String = in_groups(&from_point).chars().rev().collect();
    let point = if decimals.is_empty() { "" } else { "." };
    format!("{sign}{whole}{point}{}", in_groups(decimals))
}

fn in_groups(digits: &str) -> String {
    if digits.len() <= UNGROUPED {
        return digits.to_owned();
    }
    let mut text = String::new();
    for (i, digit) in digits.chars().enumerate() {
        if i > 0 && i % GROUP == 0 {
            text.push(GAP);
        }
        text.push(digit);
    }
    text
}

/// `text` as an expression: strings, with subscripts set as such.
pub fn expression(text: &str) -> String {
    let line = one_line(text);
    let parts = pieces(&line).into_iter().map(|piece| match piece {
        Piece::Plain(text) => dotted(text),
        Piece::Below(text) => format!("sub({})", dotted(text)),
    });
    let parts: Vec<String> = parts.collect();
    if parts.is_empty() { literal("") } else { parts.join(" + ") }
}

/// Strings, and letters with dots above as mathematics, because text fonts drop the dots of `θ̇`.
fn dotted(text: &str) -> String {
    let mut parts = Vec::new();
    let mut plain = String::new();
    for letter in text.chars() {
        let base = dots(letter).zip(plain.chars().next_back().filter(|c| c.is_alphabetic()));
        let Some((dots, base)) = base else {
            plain.push(letter);
            continue;
        };
        plain.pop();
        parts.extend([literal(&plain), format!("${dots}({base})$")]);
        plain.clear();
    }
    parts.push(literal(&plain));
    // Empty strings add nothing, but one has to stay where there is nothing else.
    if parts.len() > 1 {
        parts.retain(|part| part != "\"\"");
    }
    parts.join(" + ")
}

/// The accent of Typst's mathematics for a combining sign.
fn dots(letter: char) -> Option<&'static str> {
    match letter {
        '\u{307}' => Some("dot"),
        '\u{308}' => Some("dot.double"),
        _ => None,
    }
}

/// `text` as a Typst string.
fn literal(text: &str) -> String {
    format!("\"{}\"", text.replace('\\', "\\\\").replace('"', "\\\""))
}

/// `name` with only such signs as a label may have, in Typst and in LaTeX.
pub(crate) fn label(name: &str) -> String {
    name.chars().map(|c| if c.is_ascii_alphanumeric() { c } else { '-' }).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::shown::tests::sample;

    #[test]
    fn the_sample_is_a_figure_with_a_table() {
        let expect = r#"#figure(
  kind: table,
  caption: figure.caption(position: top, "Slope, 100 %"),
  {
    set par(justify: false)
    block(breakable: false, table(
      columns: (auto, auto, auto, auto, auto,),
      align: (x, y) => (left, right, right, right, left,).at(x) + if y == 0 { bottom } else { top },
      stroke: none,
      table.hline(),
      table.header(box("mode"), box("trial"), box("slope") + linebreak() + box("(N/rad)"), box("slope std.") + linebreak() + box("error (N/rad)"), box("wall") + linebreak() + box("reached")),
      table.hline(stroke: 0.5pt),
      "a|b & <c>", "−3", "−4.123", "0.032", "yes",
      "–", "12", "5" + hide(".000"), table.cell(align: center, "–"), "–",
      table.hline(),
    ))
    align(left, block(text(0.85em, "Unit: one_trial.")))
  },
) <tab:spring-rendering>
"#;
        assert_eq!(Seen::of(&sample(), None, typst), expect);
    }

    #[test]
    fn a_string_ends_only_at_its_own_quote() {
        assert_eq!(expression(r#"a "b" \n \"#), r#""a \"b\" \\n \\""#);
        assert_eq!(expression("#$*_`<@~=-+/[]{}\n"), "\"#$*_`<@~=-+/[]{}\"");
        assert_eq!(expression(""), "\"\"");
    }

    #[test]
    fn digits_stand_in_groups_on_both_sides_of_the_point() {
        for (plain, expect) in [
            ("1234", "1234"),
            ("-12345", "-12\u{202f}345"),
            ("1234567.5", "1\u{202f}234\u{202f}567.5"),
            ("0.0012345", "0.001\u{202f}234\u{202f}5"),
        ] {
            assert_eq!(grouped(plain), expect);
        }
    }

    #[test]
    fn points_stand_below_each_other() {
        let room = |decimals| Room { decimals, ..Room::default() };
        assert_eq!(hidden(room(2)), [" + hide(\".00\")", " + hide(\"0\")"]);
        assert_eq!(hidden(room(5))[1], " + hide(\"00\u{202f}00\")");
        assert!(hidden(Room { power: 1, ..room(2) }).is_empty());
    }

    #[test]
    fn what_stands_below_a_symbol_is_set_there() {
        assert_eq!(expression("M_O, mass"), "\"M\" + sub(\"O\") + \", mass\"");
    }

    #[test]
    fn letters_with_dots_are_mathematics() {
        assert_eq!(expression("θ\u{307} max"), "$dot(θ)$ + \" max\"");
        assert_eq!(expression("a θ\u{308}"), "\"a \" + $dot.double(θ)$");
        assert_eq!(expression("\u{307}"), "\"\u{307}\"");
    }
}
