//! MAT files of version 5 (MATLAB `-v6` and `-v7`; SciPy, Octave): real numeric variables, and the fields
//! of structures by their path, `simout.signals.values`.
//!
//! Source of the format: MathWorks, "MAT-File Format" (R2024b), "Level 5 MAT-File Format".

mod elements;
mod mi;
mod objects;

use super::limits::{MOST_COLUMNS, MOST_NAME, MOST_UNPACKED, Take};
use super::matlab::{is_object, other_class};
use super::spelling::shown;
use super::table::{Cells, ColumnRef, Table};
use arrow::array::Float64Array;
use elements::{
    ALIGN, COMPLEX, Elements, Numbers, OPAQUE, STRUCT, TOO_MUCH, beginning, text, unpack, whole,
    word,
};
use objects::Objects;
use std::borrow::Cow;
use std::path::Path;
use zwidth_store::StoreError;

/// Length of the header; its last two bytes give the byte order, the two before the version.
const HEADER: usize = 128;
/// The offset in the header of the subsystem's place, which belongs to objects.
const SUBSYSTEM: usize = 116;
/// Most bytes of the beginning of a variable: its flags, its size in [`MOST_DIMENSIONS`], its name.
const HEAD: u64 = 2 * MOST_NAME as u64;
/// Most dimensions of a variable.
const MOST_DIMENSIONS: usize = 32;

/// Reads a MAT file: its vectors by name, or with `matrix` the columns of that variable by
/// position.
pub(super) fn read(
    path: &Path,
    bytes: &[u8],
    matrix: Option<&str>,
    take: &Take,
) -> Result<Table, StoreError> {
    let remedy =
        "the file may be cut off or damaged; save it again with -v7, without what is not needed";
    let mut table = Table { names: Some(Vec::new()), ..Table::default() };
    let mut names = Vec::new();
    let mut matrix_columns = None;
    // Objects lie behind all variables: they are unpacked once, if there is one.
    let big = bytes.get(HEADER - 2..HEADER) == Some(b"MI");
    let behind = place_of_objects(bytes, big)
        .and_then(|at| objects::subsystem(bytes, at, big, MOST_UNPACKED));
    let objects = behind.as_deref().and_then(|bytes| Objects::read(bytes, big));
    variables(bytes, &mut |head, data| {
        let within = match matrix {
            None => Some(head.name.as_str()),
            Some(matrix) => head.name.strip_prefix(matrix).and_then(|rest| rest.strip_prefix('.')),
        };
        let columns_of =
            head.object.zip(objects.as_ref()).map(|(id, objects)| (objects, objects.columns(id)));
        if let Some((objects, Ok(columns))) = columns_of {
            names.push(shown(&head.name).into_owned());
            if matrix.is_some_and(|matrix| matrix != head.name) {
                return Ok(());
            }
            for column in columns {
                let name = match matrix {
                    Some(_) => column.name.clone(),
                    None => format!("{}.{}", head.name, column.name),
                };
                let place = table.columns.len();
                let is_taken = take.wants(place, Some(&name));
                table.columns.push(if is_taken {
                    objects.cells(&column, take)?
                } else {
                    Cells::Unread
                });
                table.units.extend(column.unit.map(|unit| (place, unit)));
                table.names.get_or_insert_default().push(name);
            }
            return Ok(());
        }
        // The first of the name: nothing keeps a file from having two.
        if matrix == Some(head.name.as_str()) && !head.is_struct && matrix_columns.is_none() {
            matrix_columns = Some(columns(head, data, take)?);
        }
        if let Some(class) = head.class.as_ref().filter(|class| is_object(class)) {
            table.hidden.push(format!("'{}' is {class}", shown(&head.name)));
        }
        names.push(shown(&head.name).into_owned());
        let Some(name) = within else { return Ok(()) };
        let cells = if take.wants(table.columns.len(), Some(name)) {
            vector(head, data, take)?
        } else {
            Cells::Unread
        };
        table.columns.push(cells);
        table.names.get_or_insert_default().push(name.to_owned());
        // Columns of a matrix are columns where they are asked for by name: `x(2)`, from 1.
        for column in &take.columns {
            if let ColumnRef::Name(column) = column
                && let Some(rest) = column.strip_prefix(name)
                && let Some(place) = rest.strip_prefix('(').and_then(|s| s.strip_suffix(')'))
                && let Some(place) = place.parse::<usize>().ok().and_then(|n| n.checked_sub(1))
            {
                table.columns.push(column_of(head, data, place, take)?);
                table.names.get_or_insert_default().push(column.clone());
            }
        }
        Ok(())
    })
    .map_err(|what| StoreError::new(path, format!("not a readable MAT file: {what}"), remedy))?;
    let Some(matrix) = matrix else { return Ok(table) };
    let fields = (!table.columns.is_empty()).then_some(Ok(table));
    let table = matrix_columns.or(fields).unwrap_or_else(|| {
        Err(format!("the variable is missing; the file has {}", names.join(", ")))
    });
    table.map_err(|what| {
        let remedy = "set matrix in [file] to a numeric matrix of the file, or to a structure";
        StoreError::new(path, what, remedy).column(matrix)
    })
}

/// The description of a variable, before its values.
struct Head {
    name: String,
    size: Vec<usize>,
    /// Its class if it is not a real numeric array.
    class: Option<String>,
    is_struct: bool,
    /// The number of the object that it stands for.
    object: Option<usize>,
}

/// Gives the values of the variable at hand; only who asks has them unpacked.
type Values<'a> = &'a dyn Fn(&mut dyn FnMut(Numbers) -> Option<()>) -> Result<(), String>;

/// A variable as a column: its values if it is a vector of numbers, else why not.
fn vector(head: &Head, values: Values, take: &Take) -> Result<Cells, String> {
    if let Some(class) = &head.class {
        return Ok(Cells::Other(format!("it is {class}")));
    }
    if head.size.iter().filter(|n| **n != 1).count() > 1 {
        let size = head.size.iter().map(usize::to_string).collect::<Vec<_>>().join(" × ");
        return Ok(Cells::Other(format!(
            "it is a {size} matrix; name it as matrix in [file] to use its columns, or one of them, as {}(1)",
            shown(&head.name)
        )));
    }
    let mut cells = Cells::Unread;
    let mut fits = true;
    values(&mut |numbers| {
        let n = numbers.count();
        fits = take.budget.cells(n);
        if fits && Some(n) == head.count() {
            cells = Cells::Numbers(Float64Array::from(numbers.values(0, n)?));
        }
        // Nothing means damage; what does not fit is told below.
        (!fits || matches!(cells, Cells::Numbers(_))).then_some(())
    })?;
    if fits { Ok(cells) } else { Err(TOO_MUCH.to_owned()) }
}

/// A column of a matrix.
fn column_of(head: &Head, values: Values, place: usize, take: &Take) -> Result<Cells, String> {
    if let Some(class) = &head.class {
        return Ok(Cells::Other(format!("it is {class}")));
    }
    let (rows, columns) = match head.size[..] {
        [rows, columns] if place < columns => (rows, columns),
        _ => {
            let size = head.size.iter().map(usize::to_string).collect::<Vec<_>>().join(" × ");
            return Ok(Cells::Other(format!(
                "its matrix is {size}, and has no column {}",
                place + 1
            )));
        }
    };
    if !take.budget.cells(rows) {
        return Err(TOO_MUCH.to_owned());
    }
    let mut cells = Cells::Unread;
    values(&mut |numbers| {
        (numbers.count() == rows.checked_mul(columns)?).then_some(())?;
        cells = Cells::Numbers(Float64Array::from(numbers.values(place.checked_mul(rows)?, rows)?));
        Some(())
    })?;
    Ok(cells)
}

/// A matrix' columns by position, or why it has none.
fn columns(head: &Head, values: Values, take: &Take) -> Result<Result<Table, String>, String> {
    if let Some(class) = &head.class {
        return Ok(Err(format!("the variable is {class}")));
    }
    let (rows, columns) = match head.size[..] {
        [columns, rows] if take.turned => (rows, columns),
        [rows, columns] => (rows, columns),
        _ => {
            let n = head.size.len();
            return Ok(Err(format!("the variable has {n} dimensions where 2 belong")));
        }
    };
    if columns > MOST_COLUMNS {
        return Err(format!(
            "the matrix has {columns} columns, and at most {MOST_COLUMNS} are read"
        ));
    }
    let mut table = Table::default();
    let mut fits = true;
    values(&mut |numbers| {
        let whole = Some(numbers.count()) == head.count();
        for place in (0..columns).filter(|_| whole && rows > 0) {
            let wanted = take.wants(place, None);
            fits = fits && (!wanted || take.budget.cells(rows));
            table.columns.push(match wanted && fits {
                true if take.turned => {
                    let all = numbers.values(0, rows * columns)?;
                    Cells::Numbers(all.into_iter().skip(place).step_by(columns).map(Some).collect())
                }
                true => Cells::Numbers(Float64Array::from(numbers.values(place * rows, rows)?)),
                false => Cells::Unread,
            });
        }
        whole.then_some(())
    })?;
    if fits { Ok(Ok(table)) } else { Err(TOO_MUCH.to_owned()) }
}

/// The place of what belongs to objects, which lies behind the variables.
fn place_of_objects(bytes: &[u8], big: bool) -> Option<usize> {
    let offset = *bytes.get(SUBSYSTEM..)?.first_chunk::<8>()?;
    usize::try_from(if big { u64::from_be_bytes(offset) } else { u64::from_le_bytes(offset) }).ok()
}

/// Goes through the variables of a file.
fn variables(
    bytes: &[u8],
    each: &mut dyn FnMut(&Head, Values) -> Result<(), String>,
) -> Result<(), String> {
    let header = bytes.get(..HEADER).ok_or("it is shorter than a MAT header")?;
    let big = match &header[HEADER - 2..] {
        b"IM" => false,
        b"MI" => true,
        _ => {
            return Err(
                "its header gives no byte order; only version 5 is read (save with -v7)".to_owned()
            );
        }
    };
    // The high byte of 0x0100, of 0x0200 in version 7.3; each order has it at another place.
    let version = header[if big { HEADER - 4 } else { HEADER - 3 }];
    if version != 1 {
        return Err("it is a version 7.3 (HDF5) file; save it with -v7".to_owned());
    }
    let mut elements = Elements { bytes: &bytes[HEADER..], big };
    // Behind the variables lies what belongs to the objects among them.
    let subsystem = place_of_objects(bytes, big);
    let mut last: Option<String> = None;
    let mut visited = 0;
    for count in 1.. {
        let place = bytes.len() - elements.bytes.len();
        if elements.bytes.is_empty() || Some(place) == subsystem {
            break;
        }
        if count > MOST_COLUMNS {
            return Err(format!("it has more than {MOST_COLUMNS} variables, and no more are read"));
        }
        let damaged = || match &last {
            None => "its first variable is cut off or damaged".to_owned(),
            Some(name) => format!("it is cut off or damaged after variable '{}'", shown(name)),
        };
        let (kind, data) = elements.next().ok_or_else(damaged)?;
        // Of a compressed variable only the beginning is unpacked, until its values are asked for.
        let beginning = match kind {
            mi::MATRIX => Vec::new(),
            mi::COMPRESSED => beginning(data, HEAD).ok_or_else(damaged)?,
            _ => return Err(damaged()),
        };
        let (size, plain) = match kind {
            mi::MATRIX => (data.len() as u64, data),
            _ => matrix_tag(&beginning, big).ok_or_else(damaged)?,
        };
        let (head, _) = head(plain, big, None).ok_or_else(damaged)?;
        let content = || -> Result<Cow<[u8]>, String> {
            if kind == mi::MATRIX {
                return Ok(Cow::Borrowed(data));
            }
            if size > MOST_UNPACKED {
                let name = shown(&head.name);
                return Err(format!(
                    "variable '{name}' unpacks to {size} bytes, and at most {MOST_UNPACKED} are read"
                ));
            }
            let mut plain = unpack(data, ALIGN as u64 + size).ok_or_else(damaged)?;
            // Its tag was read before.
            plain.drain(..ALIGN);
            Ok(Cow::Owned(plain))
        };
        if head.is_struct {
            visit(&mut visited, &head.name, &content()?, big, each)?;
        } else {
            each(&head, &|take| {
                let content = content()?;
                real_part(&content, big).and_then(&mut *take).ok_or_else(damaged)
            })?;
        }
        last = Some(head.name);
    }
    Ok(())
}

/// Goes through the fields of a structure, and those of structures in it: by the name of the structure, a
/// point and that of the field. Of several structures in an array each has its number, `s(2).x`.
/// `visited` counts the fields of all structures.
fn visit(
    visited: &mut usize,
    name: &str,
    data: &[u8],
    big: bool,
    each: &mut dyn FnMut(&Head, Values) -> Result<(), String>,
) -> Result<(), String> {
    let mut left = vec![(name.to_owned(), data)];
    while let Some((name, data)) = left.pop() {
        let damaged = || format!("the structure '{}' is cut off or damaged", shown(&name));
        let (outer, mut parts) = head(data, big, Some(&name)).ok_or_else(damaged)?;
        let (kind, length) = parts.next().ok_or_else(damaged)?;
        let length = Numbers::new(kind, length, big).and_then(|length| length.values(0, 1));
        let length = whole(length.ok_or_else(damaged)?[0]);
        let length = length.filter(|n| (1..=MOST_NAME).contains(n));
        let length = length.ok_or_else(damaged)?;
        let (_, names) = parts.next().ok_or_else(damaged)?;
        let names: Vec<String> = names
            .chunks_exact(length)
            .map(|name| {
                let end = name.iter().position(|byte| *byte == 0).unwrap_or(name.len());
                String::from_utf8_lossy(&name[..end]).into_owned()
            })
            .collect();
        let structures = outer.count().ok_or_else(damaged)?;
        each(&outer, &|_| Ok(()))?;
        let mut within = Vec::new();
        for structure in 0..structures {
            for field in &names {
                *visited += 1;
                let full = match structures {
                    1 => format!("{name}.{field}"),
                    _ => format!("{name}({}).{field}", structure + 1),
                };
                if *visited > MOST_COLUMNS || full.len() > MOST_NAME {
                    let what = "its structures have more fields, or deeper ones, than are read";
                    return Err(what.to_owned());
                }
                let (kind, data) = parts.next().ok_or_else(damaged)?;
                if kind != mi::MATRIX {
                    return Err(damaged());
                }
                // A field that was never set has nothing at all.
                if data.is_empty() {
                    let class = Some("empty".to_owned());
                    let size = vec![0, 0];
                    let head = Head { name: full, size, class, is_struct: false, object: None };
                    each(&head, &|_| Ok(()))?;
                    continue;
                }
                let (inner, _) = head(data, big, Some(&full)).ok_or_else(damaged)?;
                if inner.is_struct {
                    within.push((full, data));
                    continue;
                }
                each(&inner, &|take| {
                    real_part(data, big).and_then(&mut *take).ok_or_else(damaged)
                })?;
            }
        }
        left.extend(within.into_iter().rev());
    }
    Ok(())
}

/// The size that the tag of a matrix gives, bytes, and what follows the tag.
fn matrix_tag(bytes: &[u8], big: bool) -> Option<(u64, &[u8])> {
    let (tag, data) = bytes.split_at_checked(ALIGN)?;
    let size = word(&tag[4..], big)?;
    (word(tag, big)? == mi::MATRIX).then_some((u64::from(size), data))
}

/// The description of a matrix, and the elements behind it.
/// A field of a structure has no name of its own: it is called `field`.
fn head<'a>(data: &'a [u8], big: bool, field: Option<&str>) -> Option<(Head, Elements<'a>)> {
    let mut parts = Elements { bytes: data, big };
    let (_, flags) = parts.next()?;
    let flags = word(flags, big)?;
    let kind = flags & 0xff;
    if kind == OPAQUE {
        // It has no size; behind its name stand the system of its type and its class.
        let own = parts.next()?.1;
        let name = field.map_or_else(|| text(own), str::to_owned);
        let _system = parts.next()?;
        let class = text(parts.next()?.1);
        let class = other_class(&class, &name).unwrap_or_else(|| "an object".to_owned());
        // Behind that a matrix of numbers, which say where it is.
        let mut place = parts.next().map(|(_, bytes)| Elements { bytes, big });
        let place = place.as_mut().and_then(|place| place.nth(3));
        let object = place.and_then(|(_, numbers)| objects::object_of(numbers, big));
        let (size, class) = (vec![1, 1], Some(class));
        let head = Head { name, size, class, is_struct: false, object };
        return Some((head, parts));
    }
    let (size_kind, size) = parts.next()?;
    let size = Numbers::new(size_kind, size, big)?;
    let dimensions = Some(size.count()).filter(|n| *n <= MOST_DIMENSIONS)?;
    let size = size.values(0, dimensions)?.into_iter().map(whole).collect::<Option<Vec<_>>>()?;
    let own = parts.next()?.1;
    let name = field.map_or_else(|| text(own), str::to_owned);
    let class = match kind {
        // The class of an object of the old kind stands behind its name.
        3 => other_class(&text(parts.next()?.1), &name).or(Some("an object".to_owned())),
        6..=15 if flags & COMPLEX != 0 => Some(
            "complex; save its real and its imaginary part as variables of their own".to_owned(),
        ),
        6..=15 => None,
        // Table "MATLAB Array Types".
        1 => other_class("cell", &name),
        STRUCT => other_class("struct", &name),
        4 => other_class("char", &name),
        5 => other_class("sparse", &name),
        16 => other_class("function_handle", &name),
        _ => other_class("unknown", &name),
    };
    Some((Head { name, size, class, is_struct: kind == STRUCT, object: None }, parts))
}

/// The values of a matrix, as they lie in the file.
fn real_part(data: &[u8], big: bool) -> Option<Numbers<'_>> {
    let (kind, data) = head(data, big, None)?.1.next()?;
    Numbers::new(kind, data, big)
}

impl Head {
    /// The number of values that the size gives.
    fn count(&self) -> Option<usize> {
        self.size.iter().try_fold(1_usize, |n, d| n.checked_mul(*d))
    }
}

#[cfg(test)]
pub(super) mod tests;
