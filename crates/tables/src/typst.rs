//! Typst: a figure with a table, to be included in a document.

use crate::shown::{Cell, Shown, one_line, rows, shown};
use crate::{Table, TableError};

/// The table as a Typst figure with caption and label `<tab:name>`, three rules, the notes below. Rounded for
/// people.
///
/// Every text is a Typst string, which has no markup: only the quote and the backslash need an escape.
///
/// # Errors
/// Of polars, never in practice.
pub fn typst(table: &Table) -> Result<String, TableError> {
    let columns = shown(table)?;
    let headings: Vec<String> = columns.iter().map(heading).collect();
    let body: String = rows(&columns).map(|cells| row(&cells)).collect();
    let alignment: Vec<&str> = columns.iter().map(align).collect();
    let notes: String = table.notes().iter().map(|n| note(n)).collect();
    Ok(format!(
        "#figure(
  kind: table,
  caption: figure.caption(position: top, {caption}),
  {{
    table(
      columns: {width},
      align: ({alignment},),
      stroke: none,
      table.hline(),
      table.header({headings}),
      table.hline(stroke: 0.5pt),
{body}      table.hline(),
    )
{notes}  }},
) <tab:{label}>
",
        caption = expression(table.title()),
        width = columns.len(),
        alignment = alignment.join(", "),
        headings = headings.join(", "),
        label = label(table.name()),
    ))
}

/// Words, and the unit in a box, so that no line ends within it.
fn heading(column: &Shown) -> String {
    let words = expression(&column.words);
    column
        .unit
        .as_ref()
        .map_or_else(|| words.clone(), |unit| format!("{words} + \" \" + box({})", expression(unit)))
}

fn row(cells: &[&Cell]) -> String {
    let cells: Vec<String> = cells.iter().map(|c| expression(&c.typeset())).collect();
    format!("      {},\n", cells.join(", "))
}

fn note(note: &str) -> String {
    format!("    block(text(0.85em, {}))\n", expression(note))
}

fn align(column: &Shown) -> &'static str {
    if column.numeric { "right" } else { "left" }
}

/// `text` as an expression: strings, and letters with dots above as mathematics, because text fonts drop the
/// dots of `θ̇`.
fn expression(text: &str) -> String {
    let mut parts = Vec::new();
    let mut plain = String::new();
    for letter in one_line(text).chars() {
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
    let is_empty = |part: &String| part == "\"\"";
    if parts.len() > 1 {
        parts.retain(|part| !is_empty(part));
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
    table(
      columns: 5,
      align: (left, right, right, right, left,),
      stroke: none,
      table.hline(),
      table.header("mode", "trial", "slope" + " " + box("(N/rad)"), "slope std. error" + " " + box("(N/rad)"), "wall reached"),
      table.hline(stroke: 0.5pt),
      "a|b & <c>", "−3", "−4.123", "0.032", "yes",
      "–", "12", "5", "–", "–",
      table.hline(),
    )
    block(text(0.85em, "Unit: one_trial."))
  },
) <tab:spring-rendering>
"#;
        assert_eq!(typst(&sample()).unwrap(), expect);
    }

    #[test]
    fn a_string_ends_only_at_its_own_quote() {
        assert_eq!(expression(r#"a "b" \n \"#), r#""a \"b\" \\n \\""#);
        assert_eq!(expression("#$*_`<@~=-+/[]{}\n"), "\"#$*_`<@~=-+/[]{}\"");
        assert_eq!(expression(""), "\"\"");
    }

    #[test]
    fn letters_with_dots_are_mathematics() {
        assert_eq!(expression("θ\u{307} max"), "$dot(θ)$ + \" max\"");
        assert_eq!(expression("a θ\u{308}"), "\"a \" + $dot.double(θ)$");
        assert_eq!(expression("\u{307}"), "\"\u{307}\"");
    }
}
