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
use super::table::{Table, listed};
use parts::{Parts, unreadable};
use sheet::Sheet;
use std::path::Path;
use zwidth_store::StoreError;

/// Reads the sheet named, or the only one with values, of an `.xlsx` workbook or an `.ods`.
pub(super) fn read(
    path: &Path,
    bytes: &[u8],
    is_ods: bool,
    dialect: Dialect,
    part: Option<&str>,
    take: &Take,
) -> Result<Table, StoreError> {
    let damaged = |why: String| unreadable(path, &why);
    let mut parts = Parts::of(path, bytes)?;
    let mut sheet = Sheet::new(path, dialect, take);
    if is_ods {
        let content = parts.text("content.xml").map_err(damaged)?;
        let sheets = ods::sheets(&content).map_err(damaged)?;
        let names: Vec<&str> = sheets.iter().map(|sheet| sheet.name.as_str()).collect();
        let place = choose(path, &names, part, |place| Ok(sheets[place].has_values))?;
        ods::cells(path, &content, place, &mut sheet)?;
    } else {
        let book = xlsx::Book::read(&mut parts).map_err(damaged)?;
        let names: Vec<&str> = book.sheets.iter().map(|sheet| sheet.name.as_str()).collect();
        let place = choose(path, &names, part, |place| {
            xlsx::has_values(&parts.text(&book.sheets[place].part)?)
        })?;
        let content = parts.text(&book.sheets[place].part).map_err(damaged)?;
        book.cells(path, &content, &mut sheet)?;
    }
    sheet.table()
}

/// The sheet named, or the only one with values.
fn choose(
    path: &Path,
    names: &[&str],
    wanted: Option<&str>,
    mut has_values: impl FnMut(usize) -> Result<bool, String>,
) -> Result<usize, StoreError> {
    let list = listed(names.iter().map(|name| shown(name).into_owned()));
    let remedy = "set sheet in [file] to one of them";
    if let Some(wanted) = wanted {
        return names.iter().position(|name| *name == wanted).ok_or_else(|| {
            let what = format!("there is no sheet '{}'; the file has {list}", shown(wanted));
            StoreError::new(path, what, remedy)
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
