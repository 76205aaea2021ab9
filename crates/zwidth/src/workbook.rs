//! A workbook (XLSX), for who goes on in a spreadsheet: a sheet for each table, every digit, the table's own units.

use rust_xlsxwriter::{DocProperties, ExcelDateTime, Format, Workbook, XlsxError};
use zwidth_tables::{SYNTHETIC, Table, Values};

/// No sheet has a longer name.
const LONGEST_NAME: usize = 31;

/// Tables as a workbook, each on a sheet of its name: the title, the rows below their names, and the notes. Texts are texts,
/// whatever they begin with, and no cell holds a formula. The same tables give the same bytes.
///
/// # Errors
/// A table of more rows or columns than a sheet can hold.
pub(crate) fn workbook(tables: &[Table]) -> Result<Vec<u8>, XlsxError> {
    let mut workbook = Workbook::new();
    // Of no day: the same study gives the same file.
    let never = ExcelDateTime::from_ymd(2000, 1, 1)?;
    workbook.set_properties(&DocProperties::new().set_creation_datetime(&never));
    let [bold, marked] =
        [Format::new().set_bold(), Format::new().set_bold().set_font_color(0xB0_20_20)];
    let mut names: Vec<String> = Vec::new();
    for table in tables {
        let sheet = workbook.add_worksheet();
        let name = sheet_name(table.name(), &names);
        sheet.set_name(&name)?;
        names.push(name);
        sheet.write_string_with_format(0, 0, table.title(), &bold)?;
        if table.notes().iter().any(|note| note == SYNTHETIC) {
            sheet.write_string_with_format(1, 0, SYNTHETIC, &marked)?;
        }
        let mut below = 3;
        for (place, column) in (0_u16..).zip(table.columns()) {
            let name = &column.field.name;
            sheet.write_string_with_format(2, place, name.as_ref(), &bold)?;
            // As wide as its name, so that it can be read.
            sheet.set_column_width(place, (name.chars().count() as f64 + 2.0).max(10.0))?;
            for (row, at) in (0..table.height()).zip(3_u32..) {
                match &column.values {
                    Values::Float(v) => {
                        _ = v[row].map(|v| sheet.write_number(at, place, v)).transpose()?
                    }
                    #[allow(clippy::cast_precision_loss)] // A sheet has no other numbers.
                    Values::Integer(v) => {
                        _ = v[row].map(|v| sheet.write_number(at, place, v as f64)).transpose()?;
                    }
                    Values::Text(v) => {
                        let text = v[row].as_deref();
                        _ = text.map(|v| sheet.write_string(at, place, v)).transpose()?;
                    }
                    Values::Flag(v) => {
                        _ = v[row].map(|v| sheet.write_boolean(at, place, v)).transpose()?
                    }
                }
                below = below.max(at + 1);
            }
        }
        sheet.set_freeze_panes(3, 0)?;
        for (note, at) in table.notes().iter().zip(below + 1..) {
            sheet.write_string(at, 0, note)?;
        }
    }
    workbook.save_to_buffer()
}

/// The name of a table, cut to what a sheet may have, and unlike those of `others`.
fn sheet_name(table: &str, others: &[String]) -> String {
    let cut = |end: &str| {
        let kept: String = table.chars().take(LONGEST_NAME - end.len()).collect();
        kept + end
    };
    let is_new = |name: &String| !others.iter().any(|own| own.eq_ignore_ascii_case(name));
    let more = (2..).map(|number| cut(&format!("~{number}")));
    let mut names = std::iter::once(cut("")).chain(more);
    names.find(is_new).unwrap_or_default()
}

#[cfg(test)]
mod tests {
    use super::*;
    use zwidth_tables::Column;

    #[test]
    fn the_same_tables_give_the_same_bytes_and_each_has_a_sheet_of_its_own() {
        let table = |name: &str| {
            let columns = vec![
                Column::float("force", "N", "", [Some(0.1), None]),
                Column::text("mode", "", [Some("=1+1"), Some("active")]),
            ];
            Table::new(name, "Forces", columns).unwrap().with_note("a note").with_mark(true)
        };
        let tables = [table("forces"), table("Forces"), table(&"long".repeat(10))];
        let bytes = workbook(&tables).unwrap();
        assert!(bytes.starts_with(b"PK") && bytes == workbook(&tables).unwrap());
        assert!(workbook(&[]).is_ok());
        let mut names = Vec::new();
        for name in ["forces", "Forces", "forces", &"long".repeat(10), &"long".repeat(9)] {
            names.push(sheet_name(name, &names));
        }
        let long = "longlonglonglonglonglonglonglon";
        assert_eq!(names, ["forces", "Forces~2", "forces~3", long, &format!("{}~2", &long[..29])]);
    }
}
