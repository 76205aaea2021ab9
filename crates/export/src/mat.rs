//! MAT files of version 5 ("MAT-File Format", The MathWorks, 2019): a file for each trial, and one of all
//! tables. Not compressed; texts in ASCII, because Octave loses other letters.

use crate::ascii::ascii;
use crate::contents::Contents;
use crate::folder::Folder;
use crate::samples::{about, recorded, refused};
use crate::{ExportError, ExportedTrial};
use zwidth_results::Values;
use zwidth_store::{Samples, Signal, Storage};
use zwidth_tables::Table;

/// Types of elements, by their numbers.
mod kind {
    pub(super) const INT8: u32 = 1;
    pub(super) const UINT16: u32 = 4;
    pub(super) const INT32: u32 = 5;
    pub(super) const UINT32: u32 = 6;
    pub(super) const SINGLE: u32 = 7;
    pub(super) const DOUBLE: u32 = 9;
    pub(super) const MATRIX: u32 = 14;
}

/// Classes of arrays, by their numbers.
mod class {
    pub(super) const CELL: u32 = 1;
    pub(super) const STRUCT: u32 = 2;
    pub(super) const CHAR: u32 = 4;
    pub(super) const DOUBLE: u32 = 6;
    pub(super) const SINGLE: u32 = 7;
    pub(super) const UINT16: u32 = 11;
}

/// The longest name of a variable or a field.
const LONGEST: usize = 63;
/// Names of fields take 32 bytes each where none is longer, as every reader knows them; else 64.
const SHORT_FIELD: usize = 32;
const LONG_FIELD: usize = 64;

pub(crate) fn write(folder: &mut Folder, contents: &Contents) -> Result<(), ExportError> {
    for trial in &contents.trials {
        folder.write(
            &format!("mat/{}.mat", trial.told()),
            "samples of a trial, as a MAT file",
            |out| {
                let samples = trial.read()?.samples;
                Ok(out.write_all(&trial_file(trial, &samples, contents)?)?)
            },
        )?;
    }
    folder.write("mat/tables.mat", "the tables, as a MAT file", |out| {
        out.write_all(&header())?;
        for own in &contents.tables {
            let fields = table_fields(&own.table)?;
            out.write_all(&structure(own.table.name(), &fields))?;
        }
        Ok(())
    })
}

/// A vector for each column, and two structures: their units, and what trial it is.
fn trial_file(
    trial: &ExportedTrial,
    samples: &Samples,
    contents: &Contents,
) -> Result<Vec<u8>, ExportError> {
    let mut file = header();
    let mut units = Vec::new();
    for (column, unit, values) in recorded(samples, contents) {
        let name = name(column)?;
        let storage = Signal::from_name(column).map_or(Storage::F64, |s| s.column().storage);
        file.extend(numbers(&name, values, storage));
        units.push((name, characters("", unit)));
    }
    file.extend(structure("units", &units));
    let about = about(trial).into_iter();
    let about = about.map(|(key, value)| (key.to_owned(), characters("", &value)));
    file.extend(structure("about", &about.collect::<Vec<_>>()));
    Ok(file)
}

/// The name of a column as MATLAB can have it: it begins with a letter.
///
/// # Errors
/// One that is too long.
pub(crate) fn name(column: &str) -> Result<String, ExportError> {
    let is_plain = column.starts_with(|c: char| c.is_ascii_alphabetic());
    let name = if is_plain { column.to_owned() } else { format!("x{column}") };
    if name.len() > LONGEST {
        let what = format!("the name of column {column} has more than {LONGEST} letters");
        return Err(refused("mat", &what, "leave mat out of --with"));
    }
    Ok(name)
}

fn table_fields(table: &Table) -> Result<Vec<(String, Vec<u8>)>, ExportError> {
    let fields = table.columns().iter().map(|column| {
        let doubles = |values: Vec<f64>| numbers("", &values, Storage::F64);
        // MATLAB has no null: its number for a missing value is none.
        let values = match &column.values {
            Values::Float(v) => doubles(v.iter().map(|v| v.unwrap_or(f64::NAN)).collect()),
            #[allow(clippy::cast_precision_loss)] // Counts, far below 2⁵³.
            Values::Integer(v) => {
                doubles(v.iter().map(|v| v.map_or(f64::NAN, |v| v as f64)).collect())
            }
            Values::Flag(v) => {
                doubles(v.iter().map(|v| v.map_or(f64::NAN, |v| f64::from(u8::from(v)))).collect())
            }
            Values::Text(v) => cells(v.iter().map(|text| text.as_deref().unwrap_or_default())),
        };
        Ok((name(&column.field.name)?, values))
    });
    fields.collect()
}

/// The file's header: 116 bytes of text, 8 of no subsystem, the version, and the order of bytes.
fn header() -> Vec<u8> {
    let mut header = format!("{:<116}", "MATLAB 5.0 MAT-file, written by zwidth").into_bytes();
    header.extend([0; 8]);
    header.extend(0x0100_u16.to_le_bytes());
    header.extend(b"IM");
    header
}

/// An element: type, bytes, and zeros up to a multiple of eight.
fn element(kind: u32, bytes: &[u8]) -> Vec<u8> {
    let mut element = kind.to_le_bytes().to_vec();
    element.extend(u32::try_from(bytes.len()).unwrap_or(u32::MAX).to_le_bytes());
    element.extend(bytes);
    element.resize(element.len().next_multiple_of(8), 0);
    element
}

/// An array: its class, its two dimensions, its name, and the elements that hold its values.
fn array(class: u32, dimensions: [usize; 2], name: &str, values: &[u8]) -> Vec<u8> {
    let mut content = element(kind::UINT32, &[class.to_le_bytes(), [0; 4]].concat());
    let dimensions = dimensions.map(|n| i32::try_from(n).unwrap_or(i32::MAX).to_le_bytes());
    content.extend(element(kind::INT32, &dimensions.concat()));
    content.extend(element(kind::INT8, name.as_bytes()));
    content.extend(values);
    // All parts of it are multiples of eight already.
    element(kind::MATRIX, &content)
}

/// A column vector, in the type in which it was recorded.
#[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)] // The values came from that type.
fn numbers(name: &str, values: &[f64], storage: Storage) -> Vec<u8> {
    let (class, kind, bytes): (u32, u32, Vec<u8>) = match storage {
        Storage::F64 => {
            (class::DOUBLE, kind::DOUBLE, values.iter().flat_map(|v| v.to_le_bytes()).collect())
        }
        Storage::F32 => (
            class::SINGLE,
            kind::SINGLE,
            values.iter().flat_map(|v| (*v as f32).to_le_bytes()).collect(),
        ),
        Storage::U16 => (
            class::UINT16,
            kind::UINT16,
            values.iter().flat_map(|v| (*v as u16).to_le_bytes()).collect(),
        ),
    };
    array(class, [values.len(), 1], name, &element(kind, &bytes))
}

/// A text.
fn characters(name: &str, text: &str) -> Vec<u8> {
    let text = ascii(text);
    let letters: Vec<u8> = text.bytes().flat_map(|byte| u16::from(byte).to_le_bytes()).collect();
    let rows = usize::from(!text.is_empty());
    array(class::CHAR, [rows, text.len()], name, &element(kind::UINT16, &letters))
}

/// A column of texts.
fn cells<'t>(texts: impl ExactSizeIterator<Item = &'t str>) -> Vec<u8> {
    let n = texts.len();
    let cells: Vec<u8> = texts.flat_map(|text| characters("", text)).collect();
    array(class::CELL, [n, 1], "", &cells)
}

/// A structure with these fields, whose arrays have no names.
fn structure(name: &str, fields: &[(String, Vec<u8>)]) -> Vec<u8> {
    let is_short = fields.iter().all(|(name, _)| name.len() < SHORT_FIELD);
    let length = if is_short { SHORT_FIELD } else { LONG_FIELD };
    // A small element, as readers expect it: type and length in four bytes, the value in the next four.
    let mut content = (kind::INT32 | 4 << 16).to_le_bytes().to_vec();
    content.extend(u32::try_from(length).unwrap_or(u32::MAX).to_le_bytes());
    let names = fields.iter().flat_map(|(name, _)| {
        let mut bytes = name.clone().into_bytes();
        bytes.resize(length, 0);
        bytes
    });
    content.extend(element(kind::INT8, &names.collect::<Vec<u8>>()));
    content.extend(fields.iter().flat_map(|(_, values)| values));
    array(class::STRUCT, [1, 1], name, &content)
}
