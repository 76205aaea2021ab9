//! HDF5 files, and MAT files of version 7.3, which are HDF5: real numeric data sets.
//!
//! The library `hdf5-pure` reads the format. What a file claims is held against limits before the
//! library takes memory for it, and a library that gives up on a damaged file is an error of ours.

mod links;
#[cfg(test)]
pub(super) mod tests;

use super::limits::{
    MOST_COLUMNS, MOST_UNPACKED, MOST_WHOLE_ROWS, Take, check_columns, check_name, shown,
    too_many_rows, too_much,
};
use super::table::{Cells, ColumnRef, Table};
use super::text::HDF5;
use arrow::array::Float64Array;
use hdf5_pure::{AttrValue, DType, Dataset, File, Group};
use links::{Links, MOST_DEPTH};
use std::collections::BTreeMap;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::Path;
use zwidth_store::StoreError;

/// Names that an error lists.
const MOST_LISTED: usize = 20;

/// What MATLAB keeps beside the variables.
const OF_MATLAB: [&str; 2] = ["#refs#", "#subsystem#"];

/// Which dimension of a matrix counts its rows.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Order {
    /// The first: HDF5's own, as h5py writes it.
    Rows,
    /// The last: MATLAB's.
    Columns,
}

/// Reads a file: its vectors by their path (`rig/force`), or with `matrix` the columns of that data
/// set by position.
pub(super) fn read(
    path: &Path,
    bytes: Vec<u8>,
    (matrix, order): (Option<&str>, Order),
    take: &Take,
) -> Result<Table, StoreError> {
    let read = || match matrix {
        None => vectors(path, bytes, take),
        Some(matrix) => columns(path, bytes, (matrix, order), take),
    };
    catch_unwind(AssertUnwindSafe(read))
        .unwrap_or_else(|_| Err(unreadable(path, "the library gave up on it")))
}

fn unreadable(path: &Path, why: &str) -> StoreError {
    StoreError::new(path, format!("not an HDF5 file that is read here: {}", shown(why)), HDF5)
}

fn open(path: &Path, bytes: Vec<u8>) -> Result<File, StoreError> {
    File::from_bytes(bytes).map_err(|e| unreadable(path, &e.to_string()))
}

fn vectors(path: &Path, mut bytes: Vec<u8>, take: &Take) -> Result<Table, StoreError> {
    let of = (path, bytes.len() as u64);
    let links = Links::take_out(&mut bytes);
    let file = open(path, bytes)?;
    let mut table = Table { names: Some(Vec::new()), ..Table::default() };
    for found in groups(path, &file)? {
        let first = table.columns.len();
        check_columns(path, first + found.names.len())?;
        let names: Vec<String> = found.names.iter().map(|name| found.full(name)).collect();
        names.iter().try_for_each(|name| check_name(path, name))?;
        let wants: Vec<bool> = (first..).zip(&names).map(|(i, n)| take.wants(i, Some(n))).collect();
        let opened = found.open(path, &wants)?;
        for (name, data) in names.into_iter().zip(opened) {
            table.columns.push(match data {
                Some(data) => vector(of, &data, take)?,
                None => Cells::Unread,
            });
            table.names.get_or_insert_default().push(name);
        }
    }
    // A link is a column where it is asked for by its name.
    for column in &take.columns {
        let ColumnRef::Name(name) = column else { continue };
        let known = table.names.get_or_insert_default();
        if known.contains(name) {
            continue;
        }
        if let Some(data) = linked(path, &file, &links, name)? {
            known.push(name.clone());
            table.columns.push(vector(of, &data, take)?);
        }
    }
    Ok(table)
}

/// The data set to which a link leads, if the name is that of a link or of something behind one.
///
/// # Errors
/// A link that leads to no data set of this file.
fn linked(
    path: &Path,
    file: &File,
    links: &Links,
    name: &str,
) -> Result<Option<Dataset>, StoreError> {
    let refused = |what: String| {
        let remedy = "name the data set itself, or copy it into this file where the link is";
        StoreError::new(path, shown(&what), remedy).column(shown(name))
    };
    let Some(target) = links.follow(name).map_err(refused)? else { return Ok(None) };
    let found = file.dataset(&target);
    found.map(Some).map_err(|e| {
        refused(format!("it is a link to '{target}', which is no data set of the file: {e}"))
    })
}

/// A group, with the names of its data sets.
struct Found {
    group: Group,
    /// The path of the group, ending in a stroke, or nothing for the root.
    before: String,
    names: Vec<String>,
}

/// Data sets of a group that are opened by name: each is looked for among all of its links, while to
/// open them all at once keeps the header of each in memory.
const MOST_BY_NAME: usize = 32;

impl Found {
    /// The path of a data set.
    fn full(&self, name: &str) -> String {
        format!("{}{name}", self.before)
    }

    /// Those of its data sets that are wanted, in the order of their names.
    fn open(&self, path: &Path, wants: &[bool]) -> Result<Vec<Option<Dataset>>, StoreError> {
        let failed = |e: hdf5_pure::Error| unreadable(path, &e.to_string());
        if wants.iter().filter(|wants| **wants).count() > MOST_BY_NAME {
            let all = self.group.iter_datasets().map_err(failed)?;
            let mut all: BTreeMap<String, Dataset> = all.collect();
            let open = |(name, wants): (&String, &bool)| wants.then(|| all.remove(name)).flatten();
            return Ok(self.names.iter().zip(wants).map(open).collect());
        }
        let open = |(name, wants): (&String, &bool)| {
            wants.then(|| self.group.dataset(name).map_err(failed)).transpose()
        };
        self.names.iter().zip(wants).map(open).collect()
    }
}

/// The groups of a file, each with the names of its data sets. The links of a group are gone through
/// a fixed number of times, however many they are.
fn groups(path: &Path, file: &File) -> Result<Vec<Found>, StoreError> {
    let failed = |e: hdf5_pure::Error| unreadable(path, &e.to_string());
    let mut left = vec![(String::new(), file.root(), 0)];
    let mut all = Vec::new();
    let mut visited = 0;
    while let Some((before, group, depth)) = left.pop() {
        let names = group.datasets().map_err(failed)?;
        let within = group.iter_groups().map_err(failed)?;
        for (name, group) in within.filter(|(name, _)| !OF_MATLAB.contains(&name.as_str())) {
            visited += 1;
            if depth == MOST_DEPTH || visited > MOST_COLUMNS {
                let what = "it has more groups, or deeper ones, than are read";
                return Err(unreadable(path, what));
            }
            left.push((format!("{before}{name}/"), group, depth + 1));
        }
        all.push(Found { group, before, names });
    }
    Ok(all)
}

/// A data set as a column: its values if it is a vector of numbers, else why not.
fn vector(of: (&Path, u64), data: &Dataset, take: &Take) -> Result<Cells, StoreError> {
    let (path, _) = of;
    let size = size(path, data)?;
    if let Some(class) = class(data) {
        return Ok(Cells::Other(format!("it is {class}; {HDF5}")));
    }
    if size.iter().filter(|n| **n != 1).count() > 1 {
        let size = size.iter().map(usize::to_string).collect::<Vec<_>>().join(" × ");
        return Ok(Cells::Other(format!(
            "it is a {size} matrix; name it as matrix in [file] to use its columns"
        )));
    }
    let rows: usize = size.iter().product();
    if rows > MOST_WHOLE_ROWS {
        return Err(too_many_rows(path, &rows.to_string()));
    }
    if !take.budget.cells(rows) {
        return Err(too_much(path));
    }
    Ok(Cells::Numbers(Float64Array::from(values(of, data, rows)?)))
}

/// A matrix' columns by position.
fn columns(
    path: &Path,
    mut bytes: Vec<u8>,
    (matrix, order): (&str, Order),
    take: &Take,
) -> Result<Table, StoreError> {
    let of = (path, bytes.len() as u64);
    let links = Links::take_out(&mut bytes);
    let file = open(path, bytes)?;
    let (mut names, mut found) = (Vec::new(), None);
    for group in groups(path, &file)? {
        check_columns(path, names.len() + group.names.len())?;
        for name in &group.names {
            let full = group.full(name);
            check_name(path, &full)?;
            if full == matrix {
                let data = group.group.dataset(name);
                found = Some(data.map_err(|e| unreadable(path, &e.to_string()))?);
            }
            names.push(shown(&full).into_owned());
        }
    }
    if found.is_none() {
        found = linked(path, &file, &links, matrix)?;
    }
    let wrong = |what: String| {
        let remedy = "set matrix in [file] to a numeric matrix of the file";
        StoreError::new(path, what, remedy).column(matrix)
    };
    let data = found.ok_or_else(|| {
        let first = names.iter().take(MOST_LISTED).map(String::as_str);
        let more = if names.len() > MOST_LISTED { ", …" } else { "" };
        let list = first.collect::<Vec<_>>().join(", ");
        wrong(format!("the data set is missing; the file has {list}{more}"))
    })?;
    let size = size(path, &data)?;
    if let Some(class) = class(&data) {
        return Err(StoreError::new(path, format!("it is {class}"), HDF5).column(matrix));
    }
    let (rows, columns) = match (size.as_slice(), order) {
        (&[rows], _) => (rows, 1),
        (&[rows, columns], Order::Rows) | (&[columns, rows], Order::Columns) => (rows, columns),
        _ => return Err(wrong(format!("it has {} dimensions where 2 belong", size.len()))),
    };
    check_columns(path, columns)?;
    if rows > MOST_WHOLE_ROWS {
        return Err(too_many_rows(path, &rows.to_string()));
    }
    let all = values(of, &data, rows.saturating_mul(columns))?;
    let at = |row: usize, place: usize| match order {
        Order::Rows => row * columns + place,
        Order::Columns => place * rows + row,
    };
    let mut table = Table::default();
    for place in 0..columns {
        table.columns.push(match take.wants(place, None) {
            true if take.budget.cells(rows) => {
                Cells::Numbers((0..rows).map(|row| Some(all[at(row, place)])).collect())
            }
            true => return Err(too_much(path)),
            false => Cells::Unread,
        });
    }
    Ok(table)
}

/// The dimensions of a data set; none of a single value.
fn size(path: &Path, data: &Dataset) -> Result<Vec<usize>, StoreError> {
    let size = data.shape().map_err(|e| unreadable(path, &e.to_string()))?;
    Ok(size.into_iter().map(|n| usize::try_from(n).unwrap_or(usize::MAX)).collect())
}

/// What a data set is where it is not one of real numbers.
fn class(data: &Dataset) -> Option<String> {
    use DType::{F32, F64, I8, I16, I32, I64, U8, U16, U32, U64};
    let attributes = data.attrs().unwrap_or_default();
    let of_matlab = attributes.get("MATLAB_class").and_then(|value| match value {
        AttrValue::String(text) | AttrValue::AsciiString(text) => Some(text.as_str()),
        _ => None,
    });
    match (data.dtype(), of_matlab) {
        _ if attributes.contains_key("MATLAB_empty") => Some("empty".to_owned()),
        (_, Some(class @ ("char" | "cell" | "struct" | "function_handle"))) => {
            Some(format!("a {class}"))
        }
        (Ok(F32 | F64 | I8 | I16 | I32 | I64 | U8 | U16 | U32 | U64), _) => None,
        (Ok(DType::Enum(_)), _) => None,
        (Ok(DType::String | DType::VariableLengthString), _) => Some("text".to_owned()),
        (Ok(DType::Compound(_)), _) => Some("a table of several fields, or complex".to_owned()),
        (Ok(_), _) => Some("of a type that has no numbers".to_owned()),
        (Err(error), _) => {
            Some(format!("of a type that is not known: {}", shown(&error.to_string())))
        }
    }
}

/// The values of a data set, `n` of them, as they lie in a file of so many bytes.
fn values((path, length): (&Path, u64), data: &Dataset, n: usize) -> Result<Vec<f64>, StoreError> {
    let failed = |e: hdf5_pure::Error| unreadable(path, &e.to_string());
    // A chunk that is not there is made of its fill value: the size claimed counts, of a chunk too.
    let chunk = data.chunk_shape().map_err(failed)?.unwrap_or_default();
    let chunk = chunk.iter().fold(1_u64, |n, of| n.saturating_mul(*of));
    let item = data.element_size().map_err(failed)?.max(8);
    let claimed = chunk.max(n as u64).saturating_mul(item);
    if claimed > MOST_UNPACKED {
        let what =
            format!("a data set unpacks to {claimed} bytes, and at most {MOST_UNPACKED} are read");
        return Err(StoreError::new(path, what, "split it, or save it in chunks of fewer values"));
    }
    // Memory is taken for a chunk before it is read.
    let chunks = if data.is_chunked() { data.chunks().map_err(failed)? } else { Vec::new() };
    if chunks.iter().any(|chunk| chunk.storage_size > length) {
        return Err(unreadable(path, "it is cut off or damaged: a chunk is longer than the file"));
    }
    let values = data.read_f64().map_err(failed)?;
    if values.len() == n {
        return Ok(values);
    }
    let what = format!("a data set says that it has {n} values, and has {}", values.len());
    Err(unreadable(path, &what))
}
