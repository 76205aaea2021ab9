//! Workbooks: `.xlsx` as Excel writes them, `.ods` as LibreOffice writes them. A sheet is a table,
//! like a CSV file.
//!
//! Sources of the formats: ECMA-376 (5th edition) part 1, 18.2–18.8; OpenDocument 1.3 part 3, 9.
//! calamine 0.38 reserves room for as many texts as a file claims, and unfolds repeated cells to
//! 10⁸. This module allocates nothing for texts that are not there, and counts repeated cells.

mod dates;
mod ods;
mod parts;
mod sheet;
#[cfg(test)]
pub(super) mod tests;
mod xlsx;

use super::csv::Dialect;
use super::limits::Take;
use super::spelling::shown;
use super::table::Table;
use parts::{Parts, unreadable};
use sheet::Sheet;
use std::path::Path;
use zwidth_store::StoreError;

/// Reads the sheet named, or the only one with values, of an `.xlsx` workbook.
pub(super) fn read_xlsx(
    path: &Path,
    bytes: &[u8],
    dialect: Dialect,
    part: Option<&str>,
    take: &Take,
) -> Result<Table, StoreError> {
    let mut parts = Parts::of(path, bytes)?;
    let book = xlsx::Book::read(&mut parts).map_err(|why| unreadable(path, &why))?;
    let names: Vec<&str> = book.sheets.iter().map(|sheet| sheet.name.as_str()).collect();
    let place = choose(path, &names, part, |place| {
        let content = parts.text(&book.sheets[place].part)?;
        xlsx::has_values(&content)
    })?;
    let content = parts.text(&book.sheets[place].part).map_err(|why| unreadable(path, &why))?;
    let mut sheet = Sheet::new(path, dialect, take);
    book.cells(&content, &mut sheet).map_err(|error| error.about(path))?;
    sheet.table()
}

/// Reads the sheet named, or the only one with values, of an `.ods` workbook.
pub(super) fn read_ods(
    path: &Path,
    bytes: &[u8],
    dialect: Dialect,
    part: Option<&str>,
    take: &Take,
) -> Result<Table, StoreError> {
    let mut parts = Parts::of(path, bytes)?;
    let content = parts.text("content.xml").map_err(|why| unreadable(path, &why))?;
    let sheets = ods::sheets(&content).map_err(|why| unreadable(path, &why))?;
    let names: Vec<&str> = sheets.iter().map(|sheet| sheet.name.as_str()).collect();
    let place = choose(path, &names, part, |place| Ok(sheets[place].has_values))?;
    let mut sheet = Sheet::new(path, dialect, take);
    ods::cells(&content, place, &mut sheet).map_err(|error| error.about(path))?;
    sheet.table()
}

/// The sheet named, or the only one with values.
fn choose(
    path: &Path,
    names: &[&str],
    wanted: Option<&str>,
    mut has_values: impl FnMut(usize) -> Result<bool, String>,
) -> Result<usize, StoreError> {
    let list: Vec<_> = names.iter().take(MOST_LISTED).map(|name| shown(name)).collect();
    let list = list.join(", ") + if names.len() > MOST_LISTED { ", …" } else { "" };
    let remedy = "set sheet in [file] to one of them";
    if let Some(wanted) = wanted {
        return names.iter().position(|name| *name == wanted).ok_or_else(|| {
            let wanted = shown(wanted);
            StoreError::new(
                path,
                format!("there is no sheet '{wanted}'; the file has {list}"),
                remedy,
            )
        });
    }
    let mut filled = Vec::new();
    for place in 0..names.len() {
        // The only sheet is meant even if it is empty: the error then says that.
        if names.len() == 1 || has_values(place).map_err(|why| unreadable(path, &why))? {
            filled.push(place);
        }
    }
    match filled[..] {
        [place] => Ok(place),
        [] => Err(StoreError::new(path, "no sheet has values", "leave the file out of the import")),
        _ => {
            let what = format!("{} sheets have values; the file has {list}", filled.len());
            Err(StoreError::new(path, what, remedy))
        }
    }
}

/// Sheets that an error lists.
const MOST_LISTED: usize = 20;
