//! CSV, for programs: RFC 4180, every digit, the table's own units.

use crate::{Column, SYNTHETIC, Table, TableError, Values};
use std::borrow::Cow;
use std::io::Write;

/// The table as CSV (RFC 4180): a line of names, then the rows; commas, CRLF, UTF-8.
///
/// Numbers are the shortest text that reads back as the same `f64`; null is an empty field and an
/// empty text is `""`; yes and no are `true` and `false`. The title and the notes are left out: RFC
/// 4180 has no comments, and a reader would take them for rows. Only the mark of simulated data
/// ([`SYNTHETIC`]) is kept, as a last column `synthetic` that is `true` in every row.
///
/// A text that a spreadsheet would run as a formula (it begins with `=`, `+`, `-`, `@`, or their
/// wide forms, after spaces or not) gets an apostrophe in front, by which spreadsheets know text;
/// numbers are never touched.
pub fn csv(table: &Table) -> String {
    let mut text = String::new();
    let names = table.fields().map(|field| quoted(&field.name));
    line(&mut text, names.chain(mark(table, "synthetic")));
    text + &rows(table)
}

fn mark(table: &Table, text: &'static str) -> Option<Cow<'static, str>> {
    table.notes().iter().any(|note| note == SYNTHETIC).then_some(Cow::Borrowed(text))
}

/// Writes a table that is given in parts, each with the notes of the whole, as [`csv`].
///
/// # Errors
/// Those of the parts, and of `out`.
pub fn write_csv(
    parts: impl Iterator<Item = Result<Table, TableError>>,
    out: &mut dyn Write,
) -> Result<(), TableError> {
    for (number, part) in parts.enumerate() {
        let part = part?;
        let text = if number == 0 { csv(&part) } else { rows(&part) };
        out.write_all(text.as_bytes())?;
    }
    Ok(())
}

/// The lines of the rows.
fn rows(table: &Table) -> String {
    let columns = table.columns();
    let mut text = String::new();
    for row in 0..table.height() {
        line(&mut text, columns.iter().map(|c| field(c, row)).chain(mark(table, "true")));
    }
    text
}

fn line<'a>(text: &mut String, fields: impl Iterator<Item = Cow<'a, str>>) {
    for (i, field) in fields.enumerate() {
        text.push_str(if i == 0 { "" } else { "," });
        text.push_str(&field);
    }
    text.push_str("\r\n");
}

fn field(column: &Column, row: usize) -> Cow<'_, str> {
    let text = match &column.values {
        // Shortest digits either way, but `Display` would write 1e300 with all its zeros.
        Values::Float(v) => v[row].map(|v| format!("{:?}", v + 0.0).into()), // -0 + 0 is 0
        Values::Integer(v) => v[row].map(|v| v.to_string().into()),
        Values::Text(v) => v[row].as_deref().map(|text| match inert(text) {
            Cow::Borrowed(text) => quoted(text),
            Cow::Owned(text) => quoted(&text).into_owned().into(),
        }),
        Values::Flag(v) => v[row].map(|v| if v { "true" } else { "false" }.into()),
    };
    text.unwrap_or_default()
}

/// The text, so that no spreadsheet runs it.
fn inert(text: &str) -> Cow<'_, str> {
    const STARTS: [char; 8] = ['=', '+', '-', '@', '＝', '＋', '－', '＠'];
    if text.trim_start().starts_with(STARTS) {
        Cow::Owned(format!("'{text}"))
    } else {
        Cow::Borrowed(text)
    }
}

fn quoted(text: &str) -> Cow<'_, str> {
    // Some readers cut the spaces at the ends of a field without quotes.
    let plain = !text.is_empty() && text.trim() == text && !text.contains([',', '"', '\r', '\n']);
    if plain { text.into() } else { format!("\"{}\"", text.replace('"', "\"\"")).into() }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::shown::tests::sample;

    #[test]
    fn the_sample_is_written_in_full_without_title_or_notes() {
        let expect = "mode,trial,slope_n_per_rad,slope_std_error_n_per_rad,wall_reached\r\n\
                      a|b & <c>,-3,-4.1234,0.0321,true\r\n\
                      ,12,5.0,,\r\n";
        assert_eq!(csv(&sample()), expect);
    }

    #[test]
    fn simulated_data_are_marked_in_a_column_of_their_own() {
        let table = Table::new("t", "", vec![Column::integer("n", "1", "", [Some(1), None])]);
        let table = table.unwrap().with_mark(true);
        assert_eq!(csv(&table), "n,synthetic\r\n1,true\r\n,true\r\n");
    }

    #[test]
    fn texts_with_signs_of_csv_are_quoted() {
        for (text, expect) in [
            ("a,b", "\"a,b\""),
            ("say \"hi\"", "\"say \"\"hi\"\"\""),
            ("two\nlines", "\"two\nlines\""),
            ("cr\r", "\"cr\r\""),
            (" space", "\" space\""),
            ("", "\"\""),
            ("θ; plain", "θ; plain"),
        ] {
            assert_eq!(quoted(text), expect);
        }
    }

    #[test]
    fn a_text_that_a_spreadsheet_would_run_begins_with_an_apostrophe_and_a_number_does_not() {
        let texts = ["=1+1", "+x", "-x", "@a", "\t=1", " =1", "＝1", "'=1", "a=b"];
        let column = Column::text("x", "", texts.map(Some));
        let text = csv(&Table::new("t", "", vec![column]).unwrap());
        let expect = ["'=1+1", "'+x", "'-x", "'@a", "'\t=1", "' =1", "'＝1", "'=1", "a=b"];
        assert_eq!(text.lines().skip(1).collect::<Vec<_>>(), expect);
        let column = Column::float("x", "1", "", [Some(-1.0)]);
        assert_eq!(csv(&Table::new("t", "", vec![column]).unwrap()), "x\r\n-1.0\r\n");
    }

    #[test]
    fn numbers_read_back_as_the_same_bits_and_zero_has_no_sign() {
        let values = [0.1 + 0.2, 1e-321, -1.797e308, 1.0 / 3.0, 123_456_789.0];
        let column = Column::float("x", "1", "", values.map(Some));
        let text = csv(&Table::new("t", "", vec![column]).unwrap());
        let read: Vec<f64> = text.lines().skip(1).map(|l| l.parse().unwrap()).collect();
        let bits = |values: &[f64]| values.iter().map(|v| v.to_bits()).collect::<Vec<_>>();
        assert_eq!(bits(&read), bits(&values));
        let zero = Table::new("t", "", vec![Column::float("x", "1", "", [Some(-0.0)])]).unwrap();
        assert_eq!(csv(&zero), "x\r\n0.0\r\n");
    }
}
