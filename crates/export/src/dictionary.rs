//! Each column of each table: its type, its unit and what it means.

use crate::contents::Described;
use zwidth_results::{Column, UNIT_OF_ROW};
use zwidth_tables::{Table, TableError, csv};

/// A table and its columns.
pub(crate) struct Entry<'a> {
    pub(crate) table: &'a str,
    pub(crate) columns: &'a [Described],
}

/// The dictionary, as CSV.
///
/// # Errors
/// Those of a table.
pub(crate) fn dictionary(entries: &[Entry]) -> Result<String, TableError> {
    let all = entries.iter().flat_map(|e| e.columns.iter().map(|column| (e.table, column)));
    let all: Vec<(&str, &Described)> = all.collect();
    let unit = |column: &Described| match column.unit.as_str() {
        UNIT_OF_ROW => "as in the column unit".to_owned(),
        unit => unit.to_owned(),
    };
    let columns = vec![
        Column::text("table", "the table", all.iter().map(|(table, _)| Some(*table))),
        Column::text("column", "its column", all.iter().map(|(_, c)| Some(c.name.as_str()))),
        Column::text("type", "type of its values", all.iter().map(|(_, c)| Some(c.kind))),
        Column::text(
            "unit",
            "1 for a pure number or a word",
            all.iter().map(|(_, c)| Some(unit(c))),
        ),
        Column::text("definition", "what it is", all.iter().map(|(_, c)| Some(c.about.as_str()))),
    ];
    Ok(csv(&Table::new("dictionary", "Columns of all tables", columns)?))
}
