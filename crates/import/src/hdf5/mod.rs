//! HDF5 files, and MAT files of version 7.3, which are HDF5: real numeric data sets.
//!
//! The library `hdf5-pure` reads the format. A file's claims are checked against limits before the
//! library allocates memory for them. If the library panics on a damaged file, that becomes an
//! error of ours.

mod fields;
mod layout;
mod links;
mod packing;
mod raw;
#[cfg(test)]
pub(super) mod tests;

use super::limits::{
    MOST_COLUMNS, MOST_UNPACKED, MOST_WHOLE_ROWS, Take, check_columns, check_name, too_many_rows,
    too_much,
};
use super::matlab::{is_object, other_class};
use super::spelling::shown;
use super::table::{Cells, ColumnRef, Declared, Table};
use super::text::HDF5;
use arrow::array::Float64Array;
use fields::{Fields, octave_range};
use hdf5_pure::{AttrValue, DType, Dataset, Datatype, DatatypeByteOrder, File, Group};
use links::{Links, MOST_DEPTH};
use packing::{CHANNEL_FACTORS, Packing};
use std::collections::BTreeMap;
use std::fmt::Display;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::Path;
use zwidth_store::StoreError;

/// Names that an error lists.
const MOST_LISTED: usize = 20;

/// Groups that MATLAB keeps beside the variables.
const OF_MATLAB: [&str; 2] = ["#refs#", "#subsystem#"];

/// The dimension of a matrix that counts its rows.
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
    matrix: Option<&str>,
    order: Order,
    take: &Take,
) -> Result<Table, StoreError> {
    catch_unwind(AssertUnwindSafe(|| {
        let file = Opened::new(path, bytes, order)?;
        match matrix {
            None => vectors(&file, None, take),
            Some(matrix) => columns(&file, matrix, take),
        }
    }))
    .unwrap_or_else(|_| Err(unreadable(path, "the library gave up on it")))
}

/// Whether a file is one of HDF5, by its signature: at its beginning or behind a block of the user's.
pub(super) fn is_hdf5(bytes: &[u8]) -> bool {
    raw::Raw::open(bytes).is_some()
}

fn unreadable(path: &Path, why: impl Display) -> StoreError {
    let why = why.to_string();
    StoreError::new(path, format!("not an HDF5 file that is read here: {}", shown(&why)), HDF5)
}

/// Reads the vectors of a file, those of one group alone if `within` names it.
fn vectors(file: &Opened, within: Option<&str>, take: &Take) -> Result<Table, StoreError> {
    let path = file.path;
    let mut table = Table { names: Some(Vec::new()), ..Table::default() };
    for group in &file.groups {
        let Some(before) = beginning(&group.before, within) else { continue };
        let first = table.columns.len();
        check_columns(path, first + group.names.len())?;
        // As the mapping spells it: MATLAB has points where HDF5 has strokes.
        let names = group.names.iter().map(|name| {
            let full = format!("{before}{name}");
            let dotted = take.columns.iter().find_map(|column| match column {
                ColumnRef::Name(name) if name.contains('.') && name.replace('.', "/") == full => {
                    Some(name.clone())
                }
                _ => None,
            });
            dotted.unwrap_or(full)
        });
        let names: Vec<String> = names.collect();
        names.iter().try_for_each(|name| check_name(path, name))?;
        let wants: Vec<bool> = (first..).zip(&names).map(|(i, n)| take.wants(i, Some(n))).collect();
        let opened = group.open(path, &wants)?;
        for ((name, own_name), data) in names.into_iter().zip(&group.names).zip(opened) {
            let column = match data {
                Some(data) => file.vector(group, own_name, &data, take)?,
                None => Column::from(Cells::Unread),
            };
            column.add_to(&mut table, name);
        }
    }
    // Links, columns of matrices and fields of tables are columns where they are asked for by name.
    for column in &take.columns {
        let ColumnRef::Name(name) = column else { continue };
        if table.names.iter().flatten().any(|other| other == name) {
            continue;
        }
        if let Some(column) = file.named_column(within, name, take)? {
            column.add_to(&mut table, name.clone());
        }
    }
    let names = table.names.iter().flatten();
    if take.columns.iter().any(|column| match column {
        ColumnRef::Name(name) => !names.clone().any(|other| other == name),
        ColumnRef::Position(_) => false,
    }) {
        table.hidden = file.hidden()?;
    }
    Ok(table)
}

/// How the name of a data set begins that lies in this group: by its path from the group `within`, or
/// from the root; nothing if it lies elsewhere.
fn beginning<'a>(before: &'a str, within: Option<&str>) -> Option<&'a str> {
    match within {
        None => Some(before),
        Some(within) => before.strip_prefix(within)?.strip_prefix('/'),
    }
}

/// A data set as a column, and a note on how it was read.
struct Column {
    cells: Cells,
    note: Option<String>,
    unit: Option<String>,
}

impl From<Cells> for Column {
    fn from(cells: Cells) -> Self {
        Self { cells, note: None, unit: None }
    }
}

impl Column {
    fn add_to(self, table: &mut Table, name: String) {
        if let Some(unit) = self.unit {
            let place = table.columns.len();
            table.units.insert(place, Declared { unit, is_type: false });
        }
        table.told.extend(self.note.map(|note| format!("column {}: {note}", shown(&name))));
        table.names.get_or_insert_default().push(name);
        table.columns.push(self.cells);
    }
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
    let data = links.follow(name).and_then(|target| {
        let Some(target) = target else { return Ok(None) };
        file.dataset(&target).map(Some).map_err(|e| {
            format!("it is a link to '{target}', which is no data set of the file: {e}")
        })
    });
    data.map_err(|what| {
        let remedy = "name the data set itself, or copy it into this file where the link is";
        StoreError::new(path, shown(&what), remedy).column(shown(name))
    })
}

/// A group, with the names of its data sets.
struct DataGroup {
    group: Group,
    /// The path of the group, ending in a stroke, or nothing for the root.
    before: String,
    names: Vec<String>,
    /// Whether Octave wrote it: a variable, of which `value` has the dimensions as MATLAB has them.
    is_octave: bool,
    /// The class of its data sets if they hold no numbers of their own.
    class: Option<String>,
}

/// Data sets of a group that are opened by name: each is looked for among all of its links, while to
/// open them all at once keeps the header of each in memory.
const MOST_BY_NAME: usize = 32;

impl DataGroup {
    /// The path of a data set.
    fn full(&self, name: &str) -> String {
        format!("{}{name}", self.before)
    }

    /// Opens the data sets that are wanted, in the order of their names.
    fn open(&self, path: &Path, wants: &[bool]) -> Result<Vec<Option<Dataset>>, StoreError> {
        let opens_all = wants.iter().filter(|wants| **wants).count() > MOST_BY_NAME;
        let mut all = BTreeMap::new();
        if opens_all {
            all.extend(self.group.iter_datasets().map_err(|e| unreadable(path, e))?);
        }
        let opened = self.names.iter().zip(wants).map(|(name, wants)| match wants {
            false => Ok(None),
            true if opens_all => Ok(all.remove(name)),
            true => self.group.dataset(name).map(Some).map_err(|e| unreadable(path, e)),
        });
        opened.collect()
    }
}

/// The groups of a file, each with the names of its data sets. The links of a group are gone through
/// a fixed number of times, however many they are.
fn groups(path: &Path, file: &File) -> Result<Vec<DataGroup>, StoreError> {
    let mut left = vec![(String::new(), file.root(), 0)];
    let mut all = Vec::new();
    let mut visited = 0;
    while let Some((before, group, depth)) = left.pop() {
        let names = group.datasets().map_err(|e| unreadable(path, e))?;
        let within = group.iter_groups().map_err(|e| unreadable(path, e))?;
        for (name, group) in within.filter(|(name, _)| !OF_MATLAB.contains(&name.as_str())) {
            visited += 1;
            if depth == MOST_DEPTH || visited > MOST_COLUMNS {
                let what = "it has more groups, or deeper ones, than are read";
                return Err(unreadable(path, what));
            }
            left.push((format!("{before}{name}/"), group, depth + 1));
        }
        let attributes = group.attrs().map_err(|e| unreadable(path, e))?;
        let is_octave = attributes.contains_key("OCTAVE_NEW_FORMAT");
        let class = if attributes.contains_key("MATLAB_sparse")
            || ["ridx", "cidx"].iter().all(|part| names.iter().any(|name| name == part))
        {
            other_class("sparse", before.trim_end_matches('/'))
        } else if attributes.contains_key("OCTAVE_EMPTY_MATRIX") {
            Some("empty".to_owned())
        } else if is_octave {
            let kind = group.dataset("type").and_then(|kind| kind.read_string());
            let kind = kind.ok().and_then(|mut all| all.pop()).unwrap_or_default();
            kind.contains("string").then(|| "text".to_owned())
        } else {
            None
        };
        all.push(DataGroup { group, before, names, is_octave, class });
    }
    Ok(all)
}

/// A file whose groups are known.
struct Opened<'a> {
    path: &'a Path,
    /// Bytes of the file.
    length: u64,
    order: Order,
    file: File,
    links: Links,
    groups: Vec<DataGroup>,
}

impl<'a> Opened<'a> {
    fn new(path: &'a Path, mut bytes: Vec<u8>, order: Order) -> Result<Self, StoreError> {
        let length = bytes.len() as u64;
        // What the library cannot read is changed before it sees the bytes.
        let links = Links::take_out(&mut bytes);
        layout::put_beginning(&mut bytes);
        layout::make_older(&mut bytes);
        let file = File::from_bytes(bytes).map_err(|e| unreadable(path, e))?;
        let groups = groups(path, &file)?;
        Ok(Self { path, length, order, file, links, groups })
    }

    /// The objects of MATLAB's among the variables: a table has columns that cannot be seen.
    fn hidden(&self) -> Result<Vec<String>, StoreError> {
        let mut hidden = Vec::new();
        for group in self.groups.iter().filter(|group| group.before.is_empty()) {
            for name in group.names.iter().take(MOST_LISTED) {
                let data = group.group.dataset(name);
                let data = data.map_err(|e| unreadable(self.path, e))?;
                let class = class(group, name, &data).filter(|class| is_object(class));
                hidden.extend(class.map(|class| format!("'{}' is {class}", shown(name))));
            }
        }
        Ok(hidden)
    }

    /// The data set at a path, with its group and its own name.
    fn find(&self, full: &str) -> Result<Option<(&DataGroup, &str, Dataset)>, StoreError> {
        for group in &self.groups {
            let Some(name) = full.strip_prefix(&group.before) else { continue };
            if let Some(name) = group.names.iter().find(|own| *own == name) {
                let data = group.group.dataset(name);
                let data = data.map_err(|e| unreadable(self.path, e))?;
                return Ok(Some((group, name, data)));
            }
        }
        Ok(None)
    }

    /// A column that no vector of the file is: what a link leads to, a column of a matrix, `rig/data(2)`, or
    /// the field of a table, `rig/data/force`.
    fn named_column(
        &self,
        within: Option<&str>,
        name: &str,
        take: &Take,
    ) -> Result<Option<Column>, StoreError> {
        let full = within.map_or_else(|| name.to_owned(), |within| format!("{within}/{name}"));
        if let Some(data) = linked(self.path, &self.file, &self.links, &full)? {
            // What a group says of its data sets is meant for those that lie in it, not for this one.
            let Some(group) = self.groups.first() else { return Ok(None) };
            return self.vector(group, "", &data, take).map(Some);
        }
        // As written first: the name of a data set may itself have a point.
        for full in [full.clone(), full.replace('.', "/")] {
            if let Some((matrix, place)) = full.strip_suffix(')').and_then(|s| s.rsplit_once('('))
                && let Some(place) = place.parse::<usize>().ok().and_then(|n| n.checked_sub(1))
                && let Some((group, own_name, data)) = self.find(matrix)?
            {
                let mut all =
                    self.matrix(group, own_name, matrix, &data, &|at| at == place, take)?;
                if place >= all.columns.len() {
                    let what = format!("it has {} columns", all.columns.len());
                    let error = StoreError::new(self.path, what, "name one of them, from 1");
                    return Err(error.column(name));
                }
                let unit = all.units.remove(&place).map(|declared| declared.unit);
                let cells = all.columns.swap_remove(place);
                return Ok(Some(Column { cells, note: all.told.pop(), unit }));
            }
            for (at, _) in full.match_indices('/') {
                if let Some((_, _, data)) = self.find(&full[..at])?
                    && let Some(fields) = Fields::new(&data)
                    && let Some(cells) = self.field(&data, &fields, &full[at + 1..], take)?
                {
                    return Ok(Some(Column::from(cells)));
                }
            }
        }
        Ok(None)
    }

    /// The values of a field of a table.
    fn field(
        &self,
        data: &Dataset,
        fields: &Fields,
        name: &str,
        take: &Take,
    ) -> Result<Option<Cells>, StoreError> {
        let path = self.path;
        let rows: usize = size(path, data)?.iter().product();
        check_size(path, data, rows, self.length)?;
        if rows > MOST_WHOLE_ROWS {
            return Err(too_many_rows(path, &rows.to_string()));
        }
        if !take.budget.cells(rows) {
            return Err(too_much(path));
        }
        let bytes = data.read_raw().map_err(|e| unreadable(path, e))?;
        Ok(fields.values(name, &bytes, rows))
    }

    /// A data set as a column: its values if it is a vector of numbers, else why not.
    fn vector(
        &self,
        group: &DataGroup,
        own_name: &str,
        data: &Dataset,
        take: &Take,
    ) -> Result<Column, StoreError> {
        let path = self.path;
        if let Some(range) = octave_range(data) {
            let range = range.map_err(|what| unreadable(path, what))?;
            if range.len() > MOST_WHOLE_ROWS || !take.budget.cells(range.len()) {
                return Err(too_much(path));
            }
            return Ok(Cells::Numbers(Float64Array::from(range)).into());
        }
        let size = size(path, data)?;
        if let Some(fields) = Fields::new(data) {
            let names = fields.names().take(MOST_LISTED).collect::<Vec<_>>().join(", ");
            return Ok(Cells::Other(format!(
                "it is a table of the fields {}; name one of them behind a stroke, as {own_name}/…, or name it as matrix \
                 in [file]",
                shown(&names)
            ))
            .into());
        }
        if let Some(class) = class(group, own_name, data) {
            let line =
                if class.contains("in MATLAB") { String::new() } else { format!("; {HDF5}") };
            return Ok(Cells::Other(format!("it is {class}{line}")).into());
        }
        if size.iter().filter(|n| **n != 1).count() > 1 {
            let size = size.iter().map(usize::to_string).collect::<Vec<_>>().join(" × ");
            return Ok(Cells::Other(format!(
                "it is a {size} matrix; name it as matrix in [file] to use its columns, or one of them, as {own_name}(1)"
            ))
            .into());
        }
        let packing = match packing(group, own_name, data) {
            Ok((packing, None)) => packing,
            Ok((_, Some(_))) => {
                let what = "it has a factor for each channel (channel_conversion) beside it; name it as matrix in [file]";
                return Ok(Cells::Other(what.to_owned()).into());
            }
            Err(what) => return Ok(Cells::Other(what).into()),
        };
        let rows: usize = size.iter().product();
        if rows > MOST_WHOLE_ROWS {
            return Err(too_many_rows(path, &rows.to_string()));
        }
        if !take.budget.cells(rows) {
            return Err(too_much(path));
        }
        let note = packing.words(None);
        let cells = match data.dtype() {
            // Whole numbers keep every digit, unless attributes make others of them.
            Ok(DType::I64) if packing.is_plain() => {
                check_size(path, data, rows, self.length)?;
                let values = data.read_i64().map_err(|e| unreadable(path, e))?;
                Cells::whole(values.iter().map(|value| Some(i128::from(*value))))
            }
            Ok(DType::U64) if packing.is_plain() => {
                check_size(path, data, rows, self.length)?;
                let values = data.read_u64().map_err(|e| unreadable(path, e))?;
                Cells::whole(values.iter().map(|value| Some(i128::from(*value))))
            }
            _ => {
                let stored = values(path, self.length, data, rows)?;
                Cells::Numbers(packing.unpack(stored.into_iter(), 1.0))
            }
        };
        if cells.len() != rows {
            let what =
                format!("a data set says that it has {rows} values, and has {}", cells.len());
            return Err(unreadable(path, what));
        }
        Ok(Column { cells, note, unit: packing.unit })
    }

    /// A matrix' columns by position, those that are wanted; a table's fields by name.
    fn matrix(
        &self,
        group: &DataGroup,
        own_name: &str,
        full: &str,
        data: &Dataset,
        wants: &dyn Fn(usize) -> bool,
        take: &Take,
    ) -> Result<Table, StoreError> {
        let path = self.path;
        let size = size(path, data)?;
        if let Some(class) = class(group, own_name, data) {
            return Err(StoreError::new(path, format!("it is {class}"), HDF5).column(full));
        }
        let is_matlab = data.attrs().is_ok_and(|all| all.contains_key("MATLAB_class"));
        let by_columns = group.is_octave || is_matlab || self.order == Order::Columns;
        // Turned, a matrix of either kind lies as one of the other kind.
        let order = if by_columns == take.turned { Order::Rows } else { Order::Columns };
        let (rows, columns) = match (size.as_slice(), order) {
            (&[rows], _) => (rows, 1),
            (&[rows, columns], Order::Rows) | (&[columns, rows], Order::Columns) => (rows, columns),
            _ => {
                return Err(no_matrix(
                    path,
                    full,
                    format!("it has {} dimensions where 2 belong", size.len()),
                ));
            }
        };
        check_columns(path, columns)?;
        if rows > MOST_WHOLE_ROWS {
            return Err(too_many_rows(path, &rows.to_string()));
        }
        let (packing, factors) =
            packing(group, own_name, data).map_err(|what| no_matrix(path, full, what))?;
        if factors.as_ref().is_some_and(|factors| factors.len() != columns) {
            let what = format!(
                "it has {columns} columns, and channel_conversion another number of factors"
            );
            return Err(no_matrix(path, full, what));
        }
        let all = values(path, self.length, data, rows.saturating_mul(columns))?;
        let mut table = Table::default();
        table.told.extend(packing.words(factors.as_deref()));
        for place in 0..columns {
            table.columns.push(match wants(place) {
                true if take.budget.cells(rows) => {
                    let stored = (0..rows).map(|row| match order {
                        Order::Rows => all[row * columns + place],
                        Order::Columns => all[place * rows + row],
                    });
                    let factor = factors.as_ref().map_or(1.0, |factors| factors[place]);
                    Cells::Numbers(packing.unpack(stored, factor))
                }
                true => return Err(too_much(path)),
                false => Cells::Unread,
            });
            if let Some(unit) = packing.unit.clone() {
                table.units.insert(place, Declared { unit, is_type: false });
            }
        }
        Ok(table)
    }
}

/// What the attributes of a data set say of its numbers, and the factor of each of its channels where NWB has
/// them in a data set beside it.
fn packing(
    group: &DataGroup,
    own_name: &str,
    data: &Dataset,
) -> Result<(Packing, Option<Vec<f64>>), String> {
    let packing = Packing::new(data)?;
    if own_name != "data" || !group.names.iter().any(|name| name == CHANNEL_FACTORS) {
        return Ok((packing, None));
    }
    let factors = group.group.dataset(CHANNEL_FACTORS).and_then(|factors| factors.read_f64());
    let factors =
        factors.map_err(|e| format!("{CHANNEL_FACTORS} beside it cannot be read: {e}"))?;
    if factors.iter().all(|factor| factor.is_finite()) {
        return Ok((packing, Some(factors)));
    }
    Err(format!("{CHANNEL_FACTORS} beside it has factors that are not finite"))
}

fn no_matrix(path: &Path, matrix: &str, what: String) -> StoreError {
    let remedy = "set matrix in [file] to a numeric matrix of the file";
    StoreError::new(path, what, remedy).column(matrix)
}

/// A matrix' columns by position; the fields of a table and the vectors of a group by name.
fn columns(file: &Opened, matrix: &str, take: &Take) -> Result<Table, StoreError> {
    let path = file.path;
    let slashed = matrix.replace('.', "/");
    let data_set = match file.find(matrix)? {
        None => file.find(&slashed)?,
        data_set => data_set,
    };
    if let Some((group, own_name, data)) = data_set {
        if let Some(fields) = Fields::new(&data) {
            let mut table = Table::default();
            for (place, name) in fields.names().enumerate() {
                let cells = match take.wants(place, Some(name)) {
                    true => file.field(&data, &fields, name, take)?,
                    false => Some(Cells::Unread),
                };
                let cells = cells.unwrap_or_else(|| {
                    Cells::Other("it is a field without numbers of its own".to_owned())
                });
                Column::from(cells).add_to(&mut table, name.to_owned());
            }
            return Ok(table);
        }
        return file.matrix(group, own_name, matrix, &data, &|place| take.wants(place, None), take);
    }
    if let Some(data) = linked(path, &file.file, &file.links, matrix)? {
        let Some(group) = file.groups.first() else { return Ok(Table::default()) };
        return file.matrix(group, "", matrix, &data, &|place| take.wants(place, None), take);
    }
    for within in [matrix, &slashed] {
        if file.groups.iter().any(|group| group.before.strip_suffix('/') == Some(within)) {
            return vectors(file, Some(within), take);
        }
    }
    let names =
        file.groups.iter().flat_map(|group| group.names.iter().map(|name| group.full(name)));
    let names: Vec<String> = names.take(MOST_LISTED + 1).collect();
    let first = names.iter().take(MOST_LISTED).map(|name| shown(name)).collect::<Vec<_>>();
    let more = if names.len() > MOST_LISTED { ", …" } else { "" };
    let what = format!("the data set is missing; the file has {}{more}", first.join(", "));
    Err(no_matrix(path, matrix, what))
}

/// The dimensions of a data set; none of a single value.
fn size(path: &Path, data: &Dataset) -> Result<Vec<usize>, StoreError> {
    let size = data.shape().map_err(|e| unreadable(path, e))?;
    Ok(size.into_iter().map(|n| usize::try_from(n).unwrap_or(usize::MAX)).collect())
}

/// The class of a data set that holds no real numbers.
fn class(group: &DataGroup, own_name: &str, data: &Dataset) -> Option<String> {
    use DType::{F32, F64, I8, I16, I32, I64, U8, U16, U32, U64};
    let attributes = data.attrs().unwrap_or_default();
    // Before the type: the values of an empty array are its dimensions.
    if attributes.contains_key("MATLAB_empty") {
        return Some("empty".to_owned());
    }
    let matlab_class = attributes.get("MATLAB_class").and_then(AttrValue::as_str);
    let other = matlab_class.and_then(|class| other_class(class, own_name));
    if let Some(class) = other.or_else(|| group.class.clone()) {
        return Some(class);
    }
    match data.dtype() {
        Ok(F32 | F64 | I8 | I16 | I32 | I64 | U8 | U16 | U32 | U64 | DType::Enum(_)) => None,
        Ok(_) if half(data).is_some() => None,
        Ok(DType::String | DType::VariableLengthString) => Some("text".to_owned()),
        Ok(DType::Compound(_)) => Some("a table of several fields, or complex".to_owned()),
        Ok(_) => Some("of a type that has no numbers".to_owned()),
        Err(error) => Some(format!("of a type that is not known: {}", shown(&error.to_string()))),
    }
}

/// Checks what a data set of `n` values claims against what is read, in a file of so many bytes.
fn check_size(path: &Path, data: &Dataset, n: usize, length: u64) -> Result<(), StoreError> {
    // A chunk that is not there is made of its fill value: the size claimed counts, of a chunk too.
    let chunk = data.chunk_shape().map_err(|e| unreadable(path, e))?.unwrap_or_default();
    let chunk = chunk.iter().fold(1_u64, |n, size| n.saturating_mul(*size));
    // A value takes eight bytes when it is read, however few it has in the file.
    let item = data.element_size().map_err(|e| unreadable(path, e))?.max(8);
    let claimed = chunk.max(n as u64).saturating_mul(item);
    if claimed > MOST_UNPACKED {
        let what =
            format!("a data set unpacks to {claimed} bytes, and at most {MOST_UNPACKED} are read");
        return Err(StoreError::new(path, what, "split it, or save it in chunks of fewer values"));
    }
    // Memory is taken for a chunk before it is read.
    let chunks = match data.is_chunked() {
        true => data.chunks().map_err(|e| unreadable(path, e))?,
        false => Vec::new(),
    };
    if chunks.iter().any(|chunk| chunk.storage_size > length) {
        return Err(unreadable(path, "it is cut off or damaged: a chunk is longer than the file"));
    }
    Ok(())
}

/// The values of a data set, `n` of them, as they lie in a file of so many bytes.
fn values(path: &Path, length: u64, data: &Dataset, n: usize) -> Result<Vec<f64>, StoreError> {
    check_size(path, data, n, length)?;
    let values = match half(data) {
        Some(order) => {
            let bytes = data.read_raw().map_err(|e| unreadable(path, e))?;
            let halves = bytes.chunks_exact(2).map(|half| match order {
                DatatypeByteOrder::BigEndian => u16::from_be_bytes([half[0], half[1]]),
                _ => u16::from_le_bytes([half[0], half[1]]),
            });
            halves.map(number_of_half).collect()
        }
        None => data.read_f64().map_err(|e| unreadable(path, e))?,
    };
    if values.len() == n {
        return Ok(values);
    }
    let what = format!("a data set says that it has {n} values, and has {}", values.len());
    Err(unreadable(path, what))
}

/// The order of the bytes of numbers of two bytes (IEEE 754 binary16), which the library does not read;
/// nothing if they are others.
fn half(data: &Dataset) -> Option<DatatypeByteOrder> {
    match data.datatype() {
        Ok(Datatype::FloatingPoint { size: 2, byte_order, layout })
            if (layout.exponent_size, layout.mantissa_size, layout.exponent_bias)
                == (5, 10, 15) =>
        {
            Some(byte_order)
        }
        _ => None,
    }
}

/// The number of these bits of binary16.
fn number_of_half(bits: u16) -> f64 {
    let fraction = f64::from(bits & 0x3ff) / 1024.0;
    let value = match i32::from(bits >> 10 & 0x1f) {
        0 => fraction * 2_f64.powi(-14),
        31 if bits & 0x3ff == 0 => f64::INFINITY,
        31 => f64::NAN,
        exponent => (1.0 + fraction) * 2_f64.powi(exponent - 15),
    };
    if bits >> 15 == 1 { -value } else { value }
}
