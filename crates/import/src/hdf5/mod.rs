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

use super::limits::{MOST_COLUMNS, MOST_UNPACKED, Take, check_columns, check_name, check_rows};
use super::matlab::{is_object, other_class};
use super::spelling::shown;
use super::table::{Cells, ColumnRef, Declared, MOST_LISTED, Table, listed};
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
        // The names begin with the path of the group from `within`, or from the root.
        let before = match within {
            None => Some(group.before.as_str()),
            Some(within) => group.before.strip_prefix(within).and_then(|s| s.strip_prefix('/')),
        };
        let Some(before) = before else { continue };
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
                Some(data) => DataSet { file, group, name: own_name, data }.vector(take)?,
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
    if take.columns.iter().any(|column| {
        matches!(column, ColumnRef::Name(name) if !names.clone().any(|other| other == name))
    }) {
        table.hidden = file.hidden()?;
    }
    Ok(table)
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
    /// Opens a file and goes through its groups. The links of a group are gone through a fixed number of times,
    /// however many they are.
    fn new(path: &'a Path, mut bytes: Vec<u8>, order: Order) -> Result<Self, StoreError> {
        let length = bytes.len() as u64;
        // What the library cannot read is changed before it sees the bytes.
        let links = Links::take_out(&mut bytes);
        layout::put_beginning(&mut bytes);
        layout::make_older(&mut bytes);
        let file = File::from_bytes(bytes).map_err(|e| unreadable(path, e))?;
        let mut left = vec![(String::new(), file.root(), 0)];
        let mut groups = Vec::new();
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
            groups.push(DataGroup { group, before, names, is_octave, class });
        }
        Ok(Self { path, length, order, file, links, groups })
    }

    /// The objects of MATLAB's among the variables: a table has columns that cannot be seen.
    fn hidden(&self) -> Result<Vec<String>, StoreError> {
        let mut hidden = Vec::new();
        for group in self.groups.iter().filter(|group| group.before.is_empty()) {
            for name in group.names.iter().take(MOST_LISTED) {
                let class = self.open(group, name)?.class().filter(|class| is_object(class));
                hidden.extend(class.map(|class| format!("'{}' is {class}", shown(name))));
            }
        }
        Ok(hidden)
    }

    /// The data set of this name in a group.
    fn open<'f>(&'f self, group: &'f DataGroup, name: &'f str) -> Result<DataSet<'f>, StoreError> {
        let data = group.group.dataset(name).map_err(|e| unreadable(self.path, e))?;
        Ok(DataSet { file: self, group, name, data })
    }

    /// The data set at a path.
    fn find(&self, full: &str) -> Result<Option<DataSet<'_>>, StoreError> {
        for group in &self.groups {
            let Some(name) = full.strip_prefix(&group.before) else { continue };
            if let Some(name) = group.names.iter().find(|own| *own == name) {
                return self.open(group, name).map(Some);
            }
        }
        Ok(None)
    }

    /// The data set to which a link leads, if the name is that of a link or of something behind one.
    ///
    /// # Errors
    /// A link that leads to no data set of this file.
    fn linked(&self, name: &str) -> Result<Option<DataSet<'_>>, StoreError> {
        let data = self.links.follow(name).and_then(|target| {
            let Some(target) = target else { return Ok(None) };
            self.file.dataset(&target).map(Some).map_err(|e| {
                format!("it is a link to '{target}', which is no data set of the file: {e}")
            })
        });
        let data = data.map_err(|what| {
            let remedy = "name the data set itself, or copy it into this file where the link is";
            StoreError::new(self.path, shown(&what), remedy).column(shown(name))
        })?;
        // What a group says of its data sets is meant for those that lie in it, not for this one.
        let root = data.zip(self.groups.first());
        Ok(root.map(|(data, group)| DataSet { file: self, group, name: "", data }))
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
        if let Some(data_set) = self.linked(&full)? {
            return data_set.vector(take).map(Some);
        }
        // As written first: the name of a data set may itself have a point.
        for full in [full.clone(), full.replace('.', "/")] {
            if let Some((matrix, place)) = full.strip_suffix(')').and_then(|s| s.rsplit_once('('))
                && let Some(place) = place.parse::<usize>().ok().and_then(|n| n.checked_sub(1))
                && let Some(data_set) = self.find(matrix)?
            {
                let mut all = data_set.matrix(matrix, &|at| at == place, take)?;
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
                if let Some(data_set) = self.find(&full[..at])?
                    && let Some(fields) = Fields::new(&data_set.data)
                    && let Some(cells) = data_set.field(&fields, &full[at + 1..], take)?
                {
                    return Ok(Some(Column::from(cells)));
                }
            }
        }
        Ok(None)
    }
}

/// A data set of a file, and where it lies.
struct DataSet<'a> {
    file: &'a Opened<'a>,
    group: &'a DataGroup,
    /// Its name in the group.
    name: &'a str,
    data: Dataset,
}

impl DataSet<'_> {
    /// Checks what a data set of `n` values claims against what is read.
    fn check_size(&self, n: usize) -> Result<(), StoreError> {
        let path = self.file.path;
        let data = &self.data;
        // A chunk that is not there is made of its fill value: the size claimed counts, of a chunk too.
        let chunk = data.chunk_shape().map_err(|e| unreadable(path, e))?.unwrap_or_default();
        let chunk = chunk.iter().fold(1_u64, |n, size| n.saturating_mul(*size));
        // A value takes eight bytes when it is read, however few it has in the file.
        let item = data.element_size().map_err(|e| unreadable(path, e))?.max(8);
        let claimed = chunk.max(n as u64).saturating_mul(item);
        if claimed > MOST_UNPACKED {
            let what = format!(
                "a data set unpacks to {claimed} bytes, and at most {MOST_UNPACKED} are read"
            );
            let remedy = "split it, or save it in chunks of fewer values";
            return Err(StoreError::new(path, what, remedy));
        }
        // Memory is taken for a chunk before it is read.
        let chunks = match data.is_chunked() {
            true => data.chunks().map_err(|e| unreadable(path, e))?,
            false => Vec::new(),
        };
        if chunks.iter().any(|chunk| chunk.storage_size > self.file.length) {
            let what = "it is cut off or damaged: a chunk is longer than the file";
            return Err(unreadable(path, what));
        }
        Ok(())
    }

    /// The values of a field of a table.
    fn field(&self, fields: &Fields, name: &str, take: &Take) -> Result<Option<Cells>, StoreError> {
        let path = self.file.path;
        let rows: usize = size(path, &self.data)?.iter().product();
        self.check_size(rows)?;
        check_rows(path, rows)?;
        take.room(path, rows)?;
        let bytes = self.data.read_raw().map_err(|e| unreadable(path, e))?;
        Ok(fields.values(name, &bytes, rows))
    }

    /// A data set as a column: its values if it is a vector of numbers, else why not.
    fn vector(&self, take: &Take) -> Result<Column, StoreError> {
        let path = self.file.path;
        let Self { name, data, .. } = self;
        let other = |what: String| Ok(Column::from(Cells::Other(what)));
        if let Some(range) = octave_range(data) {
            let range = range.map_err(|what| unreadable(path, what))?;
            take.room(path, range.len())?;
            return Ok(Cells::Numbers(Float64Array::from(range)).into());
        }
        let size = size(path, data)?;
        if let Some(fields) = Fields::new(data) {
            let names = fields.names().take(MOST_LISTED).collect::<Vec<_>>().join(", ");
            return other(format!(
                "it is a table of the fields {}; name one of them behind a stroke, as {name}/…, or name it as matrix \
                 in [file]",
                shown(&names)
            ));
        }
        if let Some(class) = self.class() {
            let line =
                if class.contains("in MATLAB") { String::new() } else { format!("; {HDF5}") };
            return other(format!("it is {class}{line}"));
        }
        if size.iter().filter(|n| **n != 1).count() > 1 {
            let size = size.iter().map(usize::to_string).collect::<Vec<_>>().join(" × ");
            return other(format!(
                "it is a {size} matrix; name it as matrix in [file] to use its columns, or one of them, as {name}(1)"
            ));
        }
        let packing = match self.packing() {
            Ok((packing, None)) => packing,
            Ok((_, Some(_))) => {
                let what = "it has a factor for each channel (channel_conversion) beside it; name it as matrix in [file]";
                return other(what.to_owned());
            }
            Err(what) => return other(what),
        };
        let rows: usize = size.iter().product();
        check_rows(path, rows)?;
        take.room(path, rows)?;
        self.check_size(rows)?;
        let note = packing.words(None);
        let cells = match data.dtype() {
            // Whole numbers keep every digit, unless attributes make others of them.
            Ok(DType::I64) if packing.is_plain() => {
                let values = data.read_i64().map_err(|e| unreadable(path, e))?;
                Cells::whole(values.iter().map(|value| Some(i128::from(*value))))
            }
            Ok(DType::U64) if packing.is_plain() => {
                let values = data.read_u64().map_err(|e| unreadable(path, e))?;
                Cells::whole(values.iter().map(|value| Some(i128::from(*value))))
            }
            _ => Cells::Numbers(packing.unpack(values(path, data)?.into_iter(), 1.0)),
        };
        check_count(path, rows, cells.len())?;
        Ok(Column { cells, note, unit: packing.unit })
    }

    /// A matrix' columns by position, those that are wanted; a table's fields by name.
    fn matrix(
        &self,
        full: &str,
        wants: &dyn Fn(usize) -> bool,
        take: &Take,
    ) -> Result<Table, StoreError> {
        let path = self.file.path;
        let data = &self.data;
        let size = size(path, data)?;
        if let Some(class) = self.class() {
            return Err(StoreError::new(path, format!("it is {class}"), HDF5).column(full));
        }
        let is_matlab = data.attrs().is_ok_and(|all| all.contains_key("MATLAB_class"));
        let by_columns = self.group.is_octave || is_matlab || self.file.order == Order::Columns;
        // Turned, a matrix of either kind lies as one of the other kind.
        let order = if by_columns == take.turned { Order::Rows } else { Order::Columns };
        let (rows, columns) = match (size.as_slice(), order) {
            (&[rows], _) => (rows, 1),
            (&[rows, columns], Order::Rows) | (&[columns, rows], Order::Columns) => (rows, columns),
            _ => {
                let what = format!("it has {} dimensions where 2 belong", size.len());
                return Err(no_matrix(path, full, what));
            }
        };
        check_columns(path, columns)?;
        check_rows(path, rows)?;
        let (packing, factors) = self.packing().map_err(|what| no_matrix(path, full, what))?;
        if factors.as_ref().is_some_and(|factors| factors.len() != columns) {
            let what = format!(
                "it has {columns} columns, and channel_conversion another number of factors"
            );
            return Err(no_matrix(path, full, what));
        }
        let count = rows.saturating_mul(columns);
        self.check_size(count)?;
        let all = values(path, data)?;
        check_count(path, count, all.len())?;
        let mut table = Table::default();
        table.told.extend(packing.words(factors.as_deref()));
        for place in 0..columns {
            let mut cells = Cells::Unread;
            if wants(place) {
                take.room(path, rows)?;
                let stored = (0..rows).map(|row| match order {
                    Order::Rows => all[row * columns + place],
                    Order::Columns => all[place * rows + row],
                });
                let factor = factors.as_ref().map_or(1.0, |factors| factors[place]);
                cells = Cells::Numbers(packing.unpack(stored, factor));
            }
            table.columns.push(cells);
            if let Some(unit) = packing.unit.clone() {
                table.units.insert(place, Declared { unit, is_type: false });
            }
        }
        Ok(table)
    }

    /// What the attributes of a data set say of its numbers, and the factor of each of its channels where NWB has
    /// them in a data set beside it.
    fn packing(&self) -> Result<(Packing, Option<Vec<f64>>), String> {
        let packing = Packing::new(&self.data)?;
        if self.name != "data" || !self.group.names.iter().any(|name| name == CHANNEL_FACTORS) {
            return Ok((packing, None));
        }
        let factors = self.group.group.dataset(CHANNEL_FACTORS);
        let factors = factors.and_then(|factors| factors.read_f64());
        let factors =
            factors.map_err(|e| format!("{CHANNEL_FACTORS} beside it cannot be read: {e}"))?;
        if factors.iter().all(|factor| factor.is_finite()) {
            return Ok((packing, Some(factors)));
        }
        Err(format!("{CHANNEL_FACTORS} beside it has factors that are not finite"))
    }

    /// The class of a data set that holds no real numbers.
    fn class(&self) -> Option<String> {
        use DType::{F32, F64, I8, I16, I32, I64, U8, U16, U32, U64};
        let attributes = self.data.attrs().unwrap_or_default();
        // Before the type: the values of an empty array are its dimensions.
        if attributes.contains_key("MATLAB_empty") {
            return Some("empty".to_owned());
        }
        let matlab_class = attributes.get("MATLAB_class").and_then(AttrValue::as_str);
        let other = matlab_class.and_then(|class| other_class(class, self.name));
        if let Some(class) = other.or_else(|| self.group.class.clone()) {
            return Some(class);
        }
        match self.data.dtype() {
            Ok(F32 | F64 | I8 | I16 | I32 | I64 | U8 | U16 | U32 | U64 | DType::Enum(_)) => None,
            Ok(_) if half(&self.data).is_some() => None,
            Ok(DType::String | DType::VariableLengthString) => Some("text".to_owned()),
            Ok(DType::Compound(_)) => Some("a table of several fields, or complex".to_owned()),
            Ok(_) => Some("of a type that has no numbers".to_owned()),
            Err(e) => Some(format!("of a type that is not known: {}", shown(&e.to_string()))),
        }
    }
}

fn no_matrix(path: &Path, matrix: &str, what: String) -> StoreError {
    let remedy = "set matrix in [file] to a numeric matrix of the file";
    StoreError::new(path, what, remedy).column(matrix)
}

/// A matrix' columns by position; the fields of a table and the vectors of a group by name.
fn columns(file: &Opened, matrix: &str, take: &Take) -> Result<Table, StoreError> {
    let path = file.path;
    let slashed = matrix.replace('.', "/");
    let mut data_set = match file.find(matrix)? {
        None => file.find(&slashed)?,
        data_set => data_set,
    };
    if let Some(data_set) = &data_set
        && let Some(fields) = Fields::new(&data_set.data)
    {
        let mut table = Table::default();
        for (place, name) in fields.names().enumerate() {
            let cells = match take.wants(place, Some(name)) {
                true => data_set.field(&fields, name, take)?,
                false => Some(Cells::Unread),
            };
            let cells = cells.unwrap_or_else(|| {
                Cells::Other("it is a field without numbers of its own".to_owned())
            });
            Column::from(cells).add_to(&mut table, name.to_owned());
        }
        return Ok(table);
    }
    if data_set.is_none() {
        data_set = file.linked(matrix)?;
    }
    if let Some(data_set) = data_set {
        return data_set.matrix(matrix, &|place| take.wants(place, None), take);
    }
    for within in [matrix, &slashed] {
        if file.groups.iter().any(|group| group.before.strip_suffix('/') == Some(within)) {
            return vectors(file, Some(within), take);
        }
    }
    let names = file.groups.iter().flat_map(|group| {
        let before = &group.before;
        group.names.iter().map(move |name| shown(&format!("{before}{name}")).into_owned())
    });
    let what = format!("the data set is missing; the file has {}", listed(names));
    Err(no_matrix(path, matrix, what))
}

/// The dimensions of a data set; none of a single value.
fn size(path: &Path, data: &Dataset) -> Result<Vec<usize>, StoreError> {
    let size = data.shape().map_err(|e| unreadable(path, e))?;
    Ok(size.into_iter().map(|n| usize::try_from(n).unwrap_or(usize::MAX)).collect())
}

/// The values of a data set, as they are stored.
fn values(path: &Path, data: &Dataset) -> Result<Vec<f64>, StoreError> {
    let Some(order) = half(data) else {
        return data.read_f64().map_err(|e| unreadable(path, e));
    };
    let bytes = data.read_raw().map_err(|e| unreadable(path, e))?;
    let halves = bytes.chunks_exact(2).map(|half| match order {
        DatatypeByteOrder::BigEndian => u16::from_be_bytes([half[0], half[1]]),
        _ => u16::from_le_bytes([half[0], half[1]]),
    });
    Ok(halves.map(number_of_half).collect())
}

/// Checks that a data set has as many values as it says.
fn check_count(path: &Path, n: usize, found: usize) -> Result<(), StoreError> {
    if found == n {
        return Ok(());
    }
    Err(unreadable(path, format!("a data set says that it has {n} values, and has {found}")))
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
