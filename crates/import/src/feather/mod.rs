//! Arrow's file format (`.arrow`, `.feather` version 2): record batches, whole, or packed with LZ4
//! or Zstandard.
//!
//! Source of the format: Apache Arrow, "Arrow Columnar Format" 1.5, "IPC File Format". arrow-ipc
//! reads the tables of the format's own descriptions; this module reads the values, so that a
//! file's claims never decide how much memory is allocated.

mod batch;
#[cfg(test)]
pub(super) mod tests;
mod values;

use super::limits::{MOST_WHOLE_ROWS, Take, check_columns, check_name, more_rows};
use super::spelling::shown;
use super::table::{Built, Cells, Declared, Table};
use arrow_ipc::{Block, Endianness, Field, Footer, root_as_footer};
use batch::{Dictionary, Room, Runs, batch_of, dictionary_of};
use std::collections::BTreeMap;
use std::path::Path;
use values::{Kind, Text, Words};
use zwidth_store::StoreError;

const MAGIC: &[u8] = b"ARROW1";
const REMEDY: &str = "the file may be cut off or damaged; copy or export it again";
/// Batches of rows, and of words, in a file.
const MOST_BATCHES: usize = 1 << 14;

/// Reads the columns that are taken.
pub(super) fn read(path: &Path, bytes: &[u8], take: &Take) -> Result<Table, StoreError> {
    check_magic(path, bytes)?;
    let damaged = |why: String| unreadable(path, &why);
    let footer = footer(bytes).map_err(damaged)?;
    let schema = footer.schema().ok_or_else(|| unreadable(path, "it names no columns"))?;
    if schema.endianness() != Endianness::Little {
        return Err(unreadable(path, "its numbers are big-endian"));
    }
    let fields: Vec<Field> = schema.fields().into_iter().flatten().collect();
    check_columns(path, fields.len())?;
    let names: Vec<String> =
        fields.iter().map(|f| f.name().unwrap_or_default().to_owned()).collect();
    names.iter().try_for_each(|name| check_name(path, name))?;
    let kinds: Vec<Result<Kind, String>> = fields.iter().map(values::kind).collect();
    let taken: Vec<(usize, Kind)> = kinds
        .iter()
        .enumerate()
        .filter_map(|(place, kind)| Some((place, *kind.as_ref().ok()?)))
        .filter(|(place, _)| take.wants(*place, Some(&names[*place])))
        .collect();
    let room = Room::new();
    let words = words(bytes, &footer, &room, &taken).map_err(damaged)?;
    let mut growing: Vec<Built> = taken.iter().map(|(_, kind)| values::column(*kind)).collect();
    let layouts: Vec<Runs> = fields.iter().map(batch::layout).collect();
    let mut rows = 0_usize;
    for block in blocks(footer.recordBatches()).map_err(damaged)? {
        let batch = batch_of(bytes, block, &room).map_err(damaged)?;
        rows = rows.saturating_add(batch.rows);
        if rows > MOST_WHOLE_ROWS {
            return Err(more_rows(path));
        }
        take.room(path, batch.rows.saturating_mul(taken.len()))?;
        let mut at = Runs::default();
        let mut next = taken.iter().zip(&mut growing).peekable();
        for (place, layout) in layouts.iter().enumerate() {
            if let Some(((_, kind), column)) = next.next_if(|((wanted, _), _)| *wanted == place) {
                values::extend(column, *kind, &batch, at, &words).map_err(damaged)?;
            }
            at = at.after(layout, &batch).map_err(damaged)?;
        }
    }
    let unread = kinds.into_iter().map(|kind| kind.err().map_or(Cells::Unread, Cells::Other));
    let mut columns: Vec<Cells> = unread.collect();
    for ((place, _), column) in taken.iter().zip(growing) {
        columns[*place] = column.finish();
    }
    let units = fields.iter().enumerate().filter_map(|(place, field)| {
        let unit = values::unit(field)?.to_owned();
        Some((place, Declared { unit, is_type: true }))
    });
    Ok(Table { names: Some(names), columns, units: units.collect(), ..Table::default() })
}

fn check_magic(path: &Path, bytes: &[u8]) -> Result<(), StoreError> {
    let (what, remedy) = match bytes {
        [] => ("the file is empty", "leave it out of the import"),
        bytes if bytes.starts_with(MAGIC) => return Ok(()),
        bytes if bytes.starts_with(b"FEA1") => {
            ("a Feather file of version 1", "write it again as version 2, or as Parquet")
        }
        [0xff, 0xff, 0xff, 0xff, ..] => (
            "an Arrow stream, which is not the file format",
            "convert it: python -c \"import sys, pyarrow as pa; from pyarrow import feather; \
             feather.write_feather(pa.ipc.open_stream(sys.argv[1]).read_all(), sys.argv[2])\" IN OUT.arrow",
        ),
        _ => ("not an Arrow file: it does not begin with 'ARROW1'", "set format in [file]"),
    };
    Err(StoreError::new(path, what, remedy))
}

fn unreadable(path: &Path, why: &str) -> StoreError {
    StoreError::new(path, format!("not a readable Arrow file: {}", shown(why)), REMEDY)
}

/// Reads the end of a file: its columns, and the places of its batches.
fn footer(bytes: &[u8]) -> Result<Footer<'_>, String> {
    const CUT: &str = "its footer is cut off";
    let rest = bytes.strip_suffix(MAGIC).ok_or(CUT)?;
    let (rest, length) = rest.split_last_chunk::<4>().ok_or(CUT)?;
    let length = usize::try_from(i32::from_le_bytes(*length)).map_err(|_| CUT)?;
    let from = rest.len().checked_sub(length).ok_or(CUT)?;
    root_as_footer(&rest[from..]).map_err(|e| format!("its footer is damaged ({e})"))
}

/// The places of batches. Each lies behind the one before, so that none is read twice.
fn blocks<'a>(list: Option<impl IntoIterator<Item = &'a Block>>) -> Result<Vec<&'a Block>, String> {
    // One more than is read: it shows that there are more.
    let blocks: Vec<&Block> = list.into_iter().flatten().take(MOST_BATCHES + 1).collect();
    if blocks.len() > MOST_BATCHES {
        return Err(format!("it has more than {MOST_BATCHES} batches; write it with fewer"));
    }
    let mut from = 0;
    for block in &blocks {
        let length = i64::from(block.metaDataLength()).checked_add(block.bodyLength());
        let end = length.and_then(|length| block.offset().checked_add(length));
        match end.filter(|end| block.offset() >= from && *end > block.offset()) {
            Some(end) => from = end,
            None => return Err("its batches overlap".to_owned()),
        }
    }
    Ok(blocks)
}

/// The words of the dictionaries that columns taken refer to.
fn words(
    bytes: &[u8],
    footer: &Footer,
    room: &Room,
    taken: &[(usize, Kind)],
) -> Result<BTreeMap<i64, Words>, String> {
    let wanted = taken.iter().filter_map(|(_, kind)| match kind {
        Kind::Word { dictionary, of, .. } => Some((*dictionary, *of)),
        _ => None,
    });
    let wanted: BTreeMap<i64, Text> = wanted.collect();
    let mut all: BTreeMap<i64, Words> = BTreeMap::new();
    for block in blocks(footer.dictionaries())? {
        let Dictionary { id, is_delta, batch } = dictionary_of(bytes, block, room)?;
        let Some(form) = wanted.get(&id) else { continue };
        let words = values::words(&batch, *form)?;
        let dictionary = all.entry(id).or_default();
        if !is_delta {
            dictionary.clear();
        }
        dictionary.extend(words);
    }
    Ok(all)
}
