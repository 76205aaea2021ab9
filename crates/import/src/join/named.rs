//! The columns of files that are joined to a recording, as a mapping names them.

use super::super::check_beside::of_file;
use super::super::limits::Budget;
use super::super::plan::Plan;
use super::super::recording::Recording;
use super::super::table::{Cells, ColumnRef, Declared};
use zwidth_store::StoreError;

/// The columns that a mapping names, and what is made of them.
pub(super) struct Named<'a> {
    pub(super) plan: &'a Plan<'a>,
    pub(super) budget: &'a Budget,
    /// Whether a time that starts over begins another trial.
    pub(super) splits_at: bool,
    /// Columns of the recording's own.
    pub(super) own: Vec<&'a ColumnRef>,
    /// Those of its own that labels come from.
    pub(super) labels: Vec<&'a ColumnRef>,
    /// Columns of files.
    pub(super) of_files: Vec<&'a ColumnRef>,
}

impl Named<'_> {
    /// The columns that are taken of a file: their names in the mapping, and there.
    pub(super) fn of<'n>(&'n self, file: &'n str) -> impl Iterator<Item = (&'n str, ColumnRef)> {
        self.of_files.iter().filter_map(move |column| match column {
            ColumnRef::Name(name) => {
                let (of, own) = of_file(column)?;
                (of == file).then(|| (name.as_str(), column_of(own)))
            }
            ColumnRef::Position(_) => None,
        })
    }
}

/// A column of a file, by its name, or by its position where it is a number and the file has no header.
fn column_of(name: &str) -> ColumnRef {
    match name.parse() {
        Ok(position) => ColumnRef::Position(position),
        Err(_) => ColumnRef::Name(name.to_owned()),
    }
}

/// Adds a column to those of a recording, under the name that the mapping has for it; its place.
pub(super) fn add(
    recording: &mut Recording,
    name: &str,
    cells: Cells,
    unit: Option<Declared>,
) -> Result<usize, StoreError> {
    let table = &mut recording.table;
    let place = table.columns.len();
    let names = table.names.get_or_insert_with(|| (1..=place).map(|i| i.to_string()).collect());
    if names.iter().any(|other| other == name) {
        let what = format!(
            "it has a column '{name}' itself, which is that of a joined file in the mapping"
        );
        return Err(recording.error(what, "rename the column, or the joined file"));
    }
    names.push(name.to_owned());
    table.columns.push(cells);
    table.units.extend(unit.map(|unit| (place, unit)));
    Ok(place)
}
