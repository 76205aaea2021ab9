//! HDF5 files, and MAT files of version 7.3, which are HDF5: real numeric data sets.
//!
//! The library `hdf5-pure` reads the format. What a file claims is held against limits before the
//! library takes memory for it, and a library that gives up on a damaged file is an error of ours.

use super::limits::{
    MOST_COLUMNS, MOST_UNPACKED, MOST_WHOLE_ROWS, Take, check_columns, check_name, shown,
    too_many_rows, too_much,
};
use super::table::{Cells, Table};
use super::text::HDF5;
use arrow::array::Float64Array;
use hdf5_pure::{AttrValue, DType, Dataset, File, Group};
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::Path;
use zwidth_store::StoreError;

/// Groups within groups.
const MOST_DEPTH: usize = 16;

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

fn vectors(path: &Path, bytes: Vec<u8>, take: &Take) -> Result<Table, StoreError> {
    let of = (path, bytes.len() as u64);
    let file = open(path, bytes)?;
    let mut table = Table { names: Some(Vec::new()), ..Table::default() };
    each(path, &file.root(), &mut |name, data| {
        let cells = if take.wants(table.columns.len(), Some(&name)) {
            vector(of, data, take)?
        } else {
            Cells::Unread
        };
        table.columns.push(cells);
        table.names.get_or_insert_default().push(name);
        check_columns(path, table.columns.len())
    })?;
    Ok(table)
}

/// Goes through the data sets of a group and of those in it, each with its path.
fn each(
    path: &Path,
    root: &Group,
    take: &mut dyn FnMut(String, &Dataset) -> Result<(), StoreError>,
) -> Result<(), StoreError> {
    let failed = |e: hdf5_pure::Error| unreadable(path, &e.to_string());
    let mut groups = vec![(String::new(), root.clone(), 0)];
    let mut visited = 0;
    while let Some((before, group, depth)) = groups.pop() {
        for (name, data) in named(group.datasets().map_err(failed)?, |name| group.dataset(name)) {
            let name = format!("{before}{name}");
            check_name(path, &name)?;
            take(name, &data.map_err(failed)?)?;
        }
        let within = named(group.groups().map_err(failed)?, |name| group.group(name));
        for (name, group) in within.filter(|(name, _)| !OF_MATLAB.contains(&name.as_str())) {
            visited += 1;
            if depth == MOST_DEPTH || visited > MOST_COLUMNS {
                let what = "it has more groups, or deeper ones, than are read";
                return Err(unreadable(path, what));
            }
            groups.push((format!("{before}{name}/"), group.map_err(failed)?, depth + 1));
        }
    }
    Ok(())
}

fn named<T>(names: Vec<String>, open: impl Fn(&str) -> T) -> impl Iterator<Item = (String, T)> {
    names.into_iter().map(move |name| {
        let opened = open(&name);
        (name, opened)
    })
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
    bytes: Vec<u8>,
    (matrix, order): (&str, Order),
    take: &Take,
) -> Result<Table, StoreError> {
    let of = (path, bytes.len() as u64);
    let file = open(path, bytes)?;
    let (mut names, mut found) = (Vec::new(), None);
    each(path, &file.root(), &mut |name, data| {
        if name == matrix {
            found = Some(data.clone());
        }
        names.push(shown(&name).into_owned());
        check_columns(path, names.len())
    })?;
    let wrong = |what: String| {
        let remedy = "set matrix in [file] to a numeric matrix of the file";
        StoreError::new(path, what, remedy).column(matrix)
    };
    let data = found.ok_or_else(|| {
        wrong(format!("the data set is missing; the file has {}", names.join(", ")))
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

#[cfg(test)]
pub(super) mod tests {
    use super::super::limits::tests::everything;
    use super::*;
    use hdf5_pure::FileBuilder;

    /// Two vectors, one of them in a group and one as MATLAB has columns; a matrix, a text, and a
    /// whole number.
    pub(in super::super) fn written(userblock: &[u8]) -> Vec<u8> {
        let mut file = FileBuilder::new();
        if !userblock.is_empty() {
            file.with_userblock(512).with_userblock_content(userblock);
        }
        file.create_dataset("t").with_f64_data(&[0.0, 0.5, 1.0]).with_shape(&[3]);
        file.create_dataset("m").with_i32_data(&[1, 2, 3, 4, 5, 6]).with_shape(&[2, 3]);
        let mut rig = file.create_group("rig");
        let force = rig.create_dataset("f").with_f64_data(&[1.5, -2.0, 4.0]);
        force.with_shape(&[1, 3]);
        file.add_group(rig.finish());
        file.finish().unwrap()
    }

    fn read(bytes: Vec<u8>, matrix: Option<&str>, order: Order) -> Result<Table, StoreError> {
        everything(|take| super::read(Path::new("a.h5"), bytes, (matrix, order), take))
    }

    fn numbers(cells: &Cells) -> Vec<f64> {
        match cells {
            Cells::Numbers(values) => values.values().to_vec(),
            other => panic!("{other:?}"),
        }
    }

    #[test]
    fn vectors_come_by_their_path_and_a_matrix_is_told() {
        for userblock in [&b""[..], b"MATLAB 7.3 MAT-file"] {
            let table = read(written(userblock), None, Order::Rows).unwrap();
            let names = table.names.unwrap();
            let of = |name: &str| &table.columns[names.iter().position(|n| n == name).unwrap()];
            assert_eq!(numbers(of("t")), [0.0, 0.5, 1.0]);
            assert_eq!(numbers(of("rig/f")), [1.5, -2.0, 4.0]);
            let Cells::Other(why) = of("m") else { panic!("{:?}", of("m")) };
            assert!(why.contains("a 2 × 3 matrix"), "{why}");
        }
    }

    #[test]
    fn a_matrix_has_its_columns_by_the_order_of_who_wrote_it() {
        let by_rows = read(written(b""), Some("m"), Order::Rows).unwrap();
        let found: Vec<_> = by_rows.columns.iter().map(numbers).collect();
        assert_eq!(found, [[1.0, 4.0], [2.0, 5.0], [3.0, 6.0]]);
        let by_columns = read(written(b""), Some("m"), Order::Columns).unwrap();
        let found: Vec<_> = by_columns.columns.iter().map(numbers).collect();
        assert_eq!(found, [[1.0, 2.0, 3.0], [4.0, 5.0, 6.0]]);
        let error = read(written(b""), Some("x"), Order::Rows).unwrap_err();
        assert!(error.what.contains("the file has") && error.what.contains("rig/f"), "{error}");
    }

    #[test]
    fn a_file_cut_or_damaged_anywhere_is_an_error_or_a_table_and_never_a_panic() {
        let whole = written(b"");
        for cut in (0..whole.len()).step_by(7) {
            let _ = read(whole[..cut].to_vec(), None, Order::Rows);
        }
        for place in 0..whole.len() {
            let mut damaged = whole.clone();
            damaged[place] ^= 0xff;
            let found = read(damaged, None, Order::Rows);
            assert!(found.is_ok() || found.unwrap_err().remedy.contains("python -c"), "{place}");
        }
    }

    /// A chunked data set of 2⁴⁰ values of which none is written: its claim alone.
    #[test]
    fn a_claim_of_more_than_is_read_takes_no_memory() {
        let mut file = FileBuilder::new();
        file.create_dataset("t").with_f64_data(&[0.5; 8]).with_shape(&[8]);
        let mut bytes = file.finish().unwrap();
        // The dataspace' only dimension, as it is written: 8 in eight bytes.
        let size = 8_u64.to_le_bytes();
        let places: Vec<usize> =
            (0..bytes.len() - 8).filter(|i| bytes[*i..*i + 8] == size).collect();
        for place in places {
            let before = bytes.clone();
            bytes[place..place + 8].copy_from_slice(&(1_u64 << 40).to_le_bytes());
            let _ = read(bytes, None, Order::Rows);
            bytes = before;
        }
    }
}
