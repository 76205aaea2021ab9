//! HTML: a `<table>` to be put into a page.

use crate::shown::{Seen, Shown, one_line, rows};

/// The table as a `<table>`: caption, header cells with words, unit and (on hover) meaning, notes
/// in the footer. Rounded for people; cells of numbers have the class `number`.
pub(crate) fn html(&Seen { table, columns, .. }: &Seen) -> String {
    let headings: String = columns.iter().map(heading).collect();
    let rows =
        rows(columns, |k, cell| format!("<td{}>{}</td>", class(&columns[k]), cell.escaped(escape)));
    let body: String = rows.iter().map(|cells| format!("<tr>{}</tr>\n", cells.concat())).collect();
    let mut notes = String::new();
    for note in table.notes() {
        let note = escape(note);
        notes += &format!("<tr><td colspan=\"{}\">{note}</td></tr>\n", columns.len());
    }
    let footer = if notes.is_empty() { notes } else { format!("<tfoot>\n{notes}</tfoot>\n") };
    format!(
        "<table>\n<caption>{}</caption>\n<thead>\n<tr>{headings}</tr>\n</thead>\n<tbody>\n{body}</tbody>\n{footer}</table>\n",
        escape(table.title())
    )
}

fn heading(column: &Shown) -> String {
    let unit = column.unit.as_ref().map(|u| format!(" <span class=\"unit\">{}</span>", escape(u)));
    let unit = unit.unwrap_or_default();
    let [words, about] = [&column.words, &column.description].map(|text| escape(text));
    format!("<th scope=\"col\"{} title=\"{about}\">{words}{unit}</th>", class(column))
}

fn class(column: &Shown) -> &'static str {
    if column.numeric { " class=\"number\"" } else { "" }
}

/// `text` such that HTML shows it as it stands, on one line, between tags and within a quoted
/// attribute.
fn escape(text: &str) -> String {
    let mut escaped = String::new();
    for letter in one_line(text).chars() {
        match letter {
            '&' => escaped.push_str("&amp;"),
            '<' => escaped.push_str("&lt;"),
            '>' => escaped.push_str("&gt;"),
            '"' => escaped.push_str("&quot;"),
            '\'' => escaped.push_str("&#39;"),
            other => escaped.push(other),
        }
    }
    escaped
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::shown::tests::sample;
    use crate::{Column, Table};

    #[test]
    fn the_sample_is_a_table_with_caption_units_and_footer() {
        let expect = r#"<table>
<caption>Slope, 100 %</caption>
<thead>
<tr><th scope="col" title="the mode">mode</th><th scope="col" class="number" title="its number">trial</th><th scope="col" class="number" title="the slope">slope <span class="unit">(N/rad)</span></th><th scope="col" class="number" title="its error">slope std. error <span class="unit">(N/rad)</span></th><th scope="col" title="whether">wall reached</th></tr>
</thead>
<tbody>
<tr><td>a|b &amp; &lt;c&gt;</td><td class="number">−3</td><td class="number">−4.123</td><td class="number">0.032</td><td>yes</td></tr>
<tr><td>–</td><td class="number">12</td><td class="number">5</td><td class="number">–</td><td>–</td></tr>
</tbody>
<tfoot>
<tr><td colspan="5">Unit: one_trial.</td></tr>
</tfoot>
</table>
"#;
        assert_eq!(Seen::of(&sample(), None, html), expect);
    }

    #[test]
    fn the_sign_of_a_small_p_value_opens_no_tag() {
        let p = Column::float("p_value", "1", "", [Some(0.0)]);
        let text = Seen::of(&Table::new("t", "", vec![p]).unwrap(), None, html);
        assert!(text.contains(r#"<td class="number">&lt; 0.001</td>"#), "{text}");
    }

    #[test]
    fn the_five_signs_of_html_are_escaped() {
        assert_eq!(escape("<a href=\"x\">'&'"), "&lt;a href=&quot;x&quot;&gt;&#39;&amp;&#39;");
    }
}
