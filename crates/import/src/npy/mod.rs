//! NumPy's own files: an array (`.npy`), or several by name in an archive (`.npz`).
//!
//! Source of the format: NumPy 2 manual, "numpy.lib.format", versions 1.0 to 3.0.

mod header;
#[cfg(test)]
mod tests;

use super::limits::{MOST_TEXT, Take, check_columns, check_rows};
use super::spelling::shown;
use super::table::{Cells, Table};
use super::zip;
use arrow::array::LargeStringBuilder;
use header::{Header, Kind, Member};
use std::path::Path;
use zwidth_store::StoreError;

const REMEDY: &str =
    "the file may be cut off or damaged; save it again with numpy.save or numpy.savez";

/// Reads an array: a vector as a column, a matrix by its columns, a structured one by its fields.
pub(super) fn read(path: &Path, bytes: &[u8], take: &Take) -> Result<Table, StoreError> {
    let array = Array::of(bytes).map_err(|why| unreadable(path, &why))?;
    array.columns(path, take)
}

/// Reads an archive: its vectors by name, or with `matrix` the columns of that array.
pub(super) fn read_archive(
    path: &Path,
    bytes: &[u8],
    matrix: Option<&str>,
    take: &Take,
) -> Result<Table, StoreError> {
    let entries = zip::entries(bytes).map_err(|why| unreadable(path, &why))?;
    check_columns(path, entries.len())?;
    let names: Vec<String> = entries
        .iter()
        .map(|entry| entry.name.strip_suffix(".npy").unwrap_or(&entry.name).to_owned())
        .collect();
    let mut unpacked = 0;
    if let Some(matrix) = matrix {
        let Some(place) = names.iter().position(|name| name == matrix) else {
            let list: Vec<_> = names.iter().map(|name| shown(name)).collect();
            let what = format!("the array is missing; the file has {}", list.join(", "));
            let remedy = "set matrix in [file] to an array of the file";
            return Err(StoreError::new(path, what, remedy).column(matrix));
        };
        let data = zip::unpack(bytes, &entries[place], &mut unpacked)
            .map_err(|why| unreadable(path, &why))?;
        let array = Array::of(&data).map_err(|why| unreadable(path, &why))?;
        return array.columns(path, take);
    }
    let mut columns = Vec::new();
    for (place, (entry, name)) in entries.iter().zip(&names).enumerate() {
        if !take.wants(place, Some(name)) {
            columns.push(Cells::Unread);
            continue;
        }
        let data =
            zip::unpack(bytes, entry, &mut unpacked).map_err(|why| unreadable(path, &why))?;
        let array = Array::of(&data)
            .map_err(|why| unreadable(path, &format!("in the array '{}': {why}", shown(name))))?;
        columns.push(array.vector(path, take)?);
    }
    Ok(Table { names: Some(names), columns, ..Table::default() })
}

fn unreadable(path: &Path, why: &str) -> StoreError {
    StoreError::new(path, format!("not a readable NumPy file: {why}"), REMEDY)
}

/// An array whose values are all there, not decoded yet.
struct Array<'a> {
    header: Header,
    data: &'a [u8],
}

impl<'a> Array<'a> {
    /// The array in `bytes`; `Err` says why there is none. Its size is that of the bytes that are
    /// there, whatever its header claims.
    fn of(bytes: &'a [u8]) -> Result<Self, String> {
        let (header, data) = header::read(bytes)?;
        let claimed = header.values().and_then(|n| n.checked_mul(header.item));
        match claimed {
            Some(claimed) if claimed == data.len() => Ok(Self { header, data }),
            Some(claimed) => Err(format!(
                "its header claims {claimed} bytes of values, and {} are there",
                data.len()
            )),
            None => Err("its header claims more values than any file holds".to_owned()),
        }
    }

    /// The columns of a table; an array of more than two dimensions has none.
    fn columns(&self, path: &Path, take: &Take) -> Result<Table, StoreError> {
        let (rows, columns) = match self.header.shape.as_slice() {
            [rows] => (*rows, self.header.members.len()),
            [rows, columns] if self.header.members.len() == 1 && take.turned => (*columns, *rows),
            [rows, columns] if self.header.members.len() == 1 => (*rows, *columns),
            shape => {
                let what = format!("it is {}", words(shape));
                let remedy = "save a vector, a matrix of rows and columns, or a structured array of one dimension";
                return Err(StoreError::new(path, what, remedy));
            }
        };
        check_columns(path, columns)?;
        let is_matrix = self.header.shape.len() == 2;
        let mut cells = Vec::new();
        for place in 0..columns {
            let member =
                if is_matrix { &self.header.members[0] } else { &self.header.members[place] };
            if !take.wants(place, member.name.as_deref()) {
                cells.push(Cells::Unread);
                continue;
            }
            let by_columns = self.header.by_columns != take.turned;
            let at = |row: usize| match (is_matrix, by_columns) {
                (false, _) => row,
                (true, false) => row * columns + place,
                (true, true) => place * rows + row,
            };
            cells.push(self.cells(path, member, rows, at, take)?);
        }
        let names = self.header.members.iter().map(|member| member.name.clone()).collect();
        Ok(Table { names, columns: cells, ..Table::default() })
    }

    /// A vector of an archive as a column; else why it is none.
    fn vector(&self, path: &Path, take: &Take) -> Result<Cells, StoreError> {
        match (self.header.shape.as_slice(), self.header.members.as_slice()) {
            ([rows], [member]) if member.name.is_none() => {
                self.cells(path, member, *rows, |row| row, take)
            }
            (shape, _) => Ok(Cells::Other(format!(
                "it is {}; name it as matrix in [file] to use its columns",
                words(shape)
            ))),
        }
    }

    /// The values of a member at the items that `at` gives for each row.
    fn cells(
        &self,
        path: &Path,
        member: &Member,
        rows: usize,
        at: impl Fn(usize) -> usize,
        take: &Take,
    ) -> Result<Cells, StoreError> {
        check_rows(path, rows)?;
        if let Kind::Other(what) = &member.kind {
            return Ok(Cells::Other(what.clone()));
        }
        take.room(path, rows)?;
        // All of them lie within the data: its length is that of the header's shape.
        let item = |row: usize| {
            let from = at(row) * self.header.item + member.offset;
            self.data.get(from..from + member.size).unwrap_or_default()
        };
        if let Kind::Number(number) = member.kind {
            let values = (0..rows).map(|row| Some(number.read(item(row))));
            return Ok(Cells::Numbers(values.collect()));
        }
        let mut built = LargeStringBuilder::new();
        let mut length = 0;
        for row in 0..rows {
            let text = member.kind.text(item(row)).map_err(|why| unreadable(path, &why))?;
            length += text.len();
            if length > MOST_TEXT {
                let what = format!("the texts in a mapped column have more than {MOST_TEXT} bytes");
                return Err(StoreError::new(path, what, "split the file"));
            }
            built.append_option(Some(text).filter(|text| !text.is_empty()));
        }
        Ok(Cells::Text(built.finish()))
    }
}

/// A shape in words: `a 3 × 4 matrix`.
fn words(shape: &[usize]) -> String {
    let size: Vec<String> = shape.iter().take(MOST_SHOWN).map(usize::to_string).collect();
    match shape.len() {
        0 => "a single value".to_owned(),
        1 => "an array of several fields".to_owned(),
        2 => format!("a {} matrix", size.join(" × ")),
        n => format!(
            "an array of {n} dimensions ({}{})",
            size.join(" × "),
            if n > MOST_SHOWN { " …" } else { "" }
        ),
    }
}

/// Dimensions that an error lists.
const MOST_SHOWN: usize = 6;
