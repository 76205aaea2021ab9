//! Markdown, as GitHub reads it.

use crate::shown::{Seen, one_line, rows};

/// The table in GitHub Flavored Markdown: the title in bold, the table, the notes as paragraphs.
/// Rounded for people.
pub(crate) fn markdown(&Seen { table, columns, .. }: &Seen) -> String {
    let headings = columns.iter().map(|c| escape(&c.heading()));
    let rules = columns.iter().map(|c| if c.numeric { "---:" } else { "---" }.to_owned());
    let mut lines = vec![line(headings), line(rules)];
    let rows = rows(columns, |_, cell| cell.escaped(escape));
    lines.extend(rows.into_iter().map(|cells| line(cells.into_iter())));
    let title = format!("**{}**", escape(table.title()));
    let notes = table.notes().iter().map(|note| escape(note));
    let parts: Vec<String> = [title, lines.join("\n")].into_iter().chain(notes).collect();
    parts.join("\n\n") + "\n"
}

fn line(cells: impl Iterator<Item = String>) -> String {
    format!("| {} |", cells.collect::<Vec<_>>().join(" | "))
}

/// `text` escaped so that Markdown sets it unchanged, on one line: in a paragraph, a list item or a
/// table's cell.
pub fn escape(text: &str) -> String {
    let text = one_line(text);
    let block = block_sign(&text);
    let mut escaped = String::new();
    for (i, letter) in text.char_indices() {
        // `$` among them: GitHub sets what stands between two of these as mathematics.
        let inline = matches!(
            letter,
            '\\' | '`' | '*' | '_' | '[' | ']' | '<' | '>' | '|' | '~' | '$' | '&' | '#'
        );
        if inline || Some(i) == block {
            escaped.push('\\');
        }
        escaped.push(letter);
    }
    escaped
}

/// Where the sign stands that would make a line a list, a heading or a rule: `- a`, `1. a`, `---`.
fn block_sign(text: &str) -> Option<usize> {
    let at = text.find(|c: char| !c.is_ascii_digit())?;
    let mut rest = text[at..].chars();
    // A sign alone on its line counts as if a space followed.
    let sign = rest.next()?;
    let next = rest.next().unwrap_or(' ');
    let numbered = at > 0 && matches!(sign, '.' | ')') && next == ' ';
    let bulleted = at == 0 && matches!(sign, '-' | '+' | '=') && (next == ' ' || next == sign);
    (numbered || bulleted).then_some(at)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::shown::tests::sample;

    #[test]
    fn the_sample_is_a_table_with_its_note_below() {
        let expect = "\
**Slope, 100 %**

| mode | trial | slope (N/rad) | slope std. error (N/rad) | wall reached |
| --- | ---: | ---: | ---: | --- |
| a\\|b \\& \\<c\\> | −3 | −4.123 | 0.032 | yes |
| – | 12 | 5 | – | – |

Unit: one\\_trial.
";
        assert_eq!(Seen::of(&sample(), None, markdown), expect);
    }

    #[test]
    fn every_sign_of_markdown_is_escaped() {
        for (text, expect) in [
            (r"\`*_[]<>|~$&#", r"\\\`\*\_\[\]\<\>\|\~\$\&\#"),
            ("- a", "\\- a"),
            ("+ a - b", "\\+ a - b"),
            ("12. a 3. b", "12\\. a 3. b"),
            ("1) a", "1\\) a"),
            ("===", "\\==="),
            ("1.5 N", "1.5 N"),
            ("-3", "-3"),
            ("---", "\\---"),
            ("7.", "7\\."),
            ("two\nlines", "two lines"),
            ("θ̇ in °", "θ̇ in °"),
        ] {
            assert_eq!(escape(text), expect);
        }
    }
}
