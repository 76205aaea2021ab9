//! Workbooks: `.xlsx` as Excel writes them, `.ods` as LibreOffice does. A sheet is a table as a CSV is one.
//!
//! Sources of the formats: ECMA-376 (5th edition) part 1, 18.2–18.8; OpenDocument 1.3 part 3, 9. calamine 0.38 reserves room for
//! as many texts as a file claims, and unfolds repeated cells to 10⁸: here nothing is taken that is not there, and what is
//! repeated counts.

mod dates;
mod ods;
mod sheet;
#[cfg(test)]
pub(super) mod tests;
mod xlsx;

use super::format::FormatOptions;
use super::limits::{Take, shown};
use super::table::Table;
use super::zip;
use sheet::Sheet;
use std::path::Path;
use zwidth_store::StoreError;

const REMEDY: &str = "the file may be cut off or damaged; open it and save it again, or save its sheet as CSV (UTF-8)";

/// Reads the sheet named, or the only one with values, of an `.xlsx` workbook.
pub(super) fn read_xlsx(
    path: &Path,
    bytes: &[u8],
    options: FormatOptions,
    take: &Take,
) -> Result<Table, StoreError> {
    let mut parts = Parts::of(path, bytes)?;
    let book = xlsx::Book::read(&mut parts).map_err(|why| unreadable(path, &why))?;
    let names: Vec<&str> = book.sheets.iter().map(|sheet| sheet.name.as_str()).collect();
    let place = choose(path, &names, options.part, |place| {
        let content = parts.text(&book.sheets[place].part)?;
        xlsx::has_values(&content)
    })?;
    let content = parts.text(&book.sheets[place].part).map_err(|why| unreadable(path, &why))?;
    let mut sheet = Sheet::new(path, options.dialect, take);
    book.cells(&content, &mut sheet).map_err(|error| error.about(path))?;
    sheet.table()
}

/// Reads the sheet named, or the only one with values, of an `.ods` workbook.
pub(super) fn read_ods(
    path: &Path,
    bytes: &[u8],
    options: FormatOptions,
    take: &Take,
) -> Result<Table, StoreError> {
    let mut parts = Parts::of(path, bytes)?;
    let content = parts.text("content.xml").map_err(|why| unreadable(path, &why))?;
    let sheets = ods::sheets(&content).map_err(|why| unreadable(path, &why))?;
    let names: Vec<&str> = sheets.iter().map(|sheet| sheet.name.as_str()).collect();
    let place = choose(path, &names, options.part, |place| Ok(sheets[place].has_values))?;
    let mut sheet = Sheet::new(path, options.dialect, take);
    ods::cells(&content, place, &mut sheet).map_err(|error| error.about(path))?;
    sheet.table()
}

/// Why a sheet cannot be read: what its file lacks, or more than is read.
enum Fault {
    Unreadable(String),
    Refused(StoreError),
}

impl From<String> for Fault {
    fn from(why: String) -> Self {
        Self::Unreadable(why)
    }
}

impl From<StoreError> for Fault {
    fn from(error: StoreError) -> Self {
        Self::Refused(error)
    }
}

impl Fault {
    fn about(self, path: &Path) -> StoreError {
        match self {
            Self::Unreadable(why) => unreadable(path, &why),
            Self::Refused(error) => error,
        }
    }
}

fn unreadable(path: &Path, why: &str) -> StoreError {
    StoreError::new(path, format!("not a readable workbook: {why}"), REMEDY)
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
    let mut found = Vec::new();
    for place in 0..names.len() {
        if names.len() == 1 || has_values(place).map_err(|why| unreadable(path, &why))? {
            found.push(place);
        }
    }
    match found[..] {
        [place] => Ok(place),
        [] => Err(StoreError::new(path, "no sheet has values", "leave the file out of the import")),
        _ => {
            let what = format!("{} sheets have values; the file has {list}", found.len());
            Err(StoreError::new(path, what, remedy))
        }
    }
}

/// Sheets that an error lists.
const MOST_LISTED: usize = 20;

/// The parts of a workbook's archive.
struct Parts<'a> {
    bytes: &'a [u8],
    entries: Vec<zip::Entry>,
    /// Bytes of all that was unpacked.
    unpacked: u64,
}

impl<'a> Parts<'a> {
    fn of(path: &Path, bytes: &'a [u8]) -> Result<Self, StoreError> {
        if !bytes.starts_with(b"PK") {
            let (what, remedy) = match bytes {
                [] => ("the file is empty", "leave it out of the import"),
                [0xd0, 0xcf, 0x11, 0xe0, ..] => (
                    "not a workbook that is read: an old one (.xls), or one that a password locks",
                    "save it as .xlsx without a password, or its sheet as CSV (UTF-8)",
                ),
                _ => (
                    "not a workbook: it does not begin as an .xlsx or .ods does",
                    "if it is a text, set format = \"csv\" in [file]",
                ),
            };
            return Err(StoreError::new(path, what, remedy));
        }
        let entries = zip::entries(bytes).map_err(|why| unreadable(path, &why))?;
        Ok(Self { bytes, entries, unpacked: 0 })
    }

    fn has(&self, name: &str) -> bool {
        self.entries.iter().any(|entry| entry.name == name)
    }

    /// The text of a part.
    fn text(&mut self, name: &str) -> Result<String, String> {
        let entry = self.entries.iter().find(|entry| entry.name == name);
        let entry = entry.ok_or_else(|| format!("it has no '{}'", shown(name)))?;
        let bytes = zip::unpack(self.bytes, entry, &mut self.unpacked)?;
        String::from_utf8(bytes).map_err(|_| format!("'{}' is not UTF-8 text", shown(name)))
    }
}
