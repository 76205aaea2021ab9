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

use super::limits::{
    MOST_COLUMNS, MOST_WHOLE_ROWS, Take, check_columns, check_name, too_many_rows, too_much,
};
use super::spelling::shown;
use super::table::{Cells, Declared, Table};
use arrow_ipc::{Block, Endianness, Field, Footer, root_as_footer};
use batch::{Batch, Dictionary, Layout, Room, batch_of, dictionary_of};
use std::collections::BTreeMap;
use std::path::Path;
use values::{Growing, Kind, Words};
use zwidth_store::StoreError;

const MAGIC: &[u8] = b"ARROW1";
const REMEDY: &str = "the file may be cut off or damaged; copy or export it again";
/// Batches of rows, and of words, in a file.
const MOST_BATCHES: usize = 1 << 14;

/// Reads the columns that are taken.
pub(super) fn read(path: &Path, bytes: &[u8], take: &Take) -> Result<Table, StoreError> {
    check_magic(path, bytes)?;
    let footer = footer(bytes).map_err(|why| unreadable(path, &why))?;
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
    let taken: Vec<usize> = (0..fields.len())
        .filter(|place| kinds[*place].is_ok() && take.wants(*place, Some(&names[*place])))
        .collect();
    let room = Room::new();
    let words = words(bytes, &footer, &room, &taken, &fields, &kinds)
        .map_err(|why| unreadable(path, &why))?;
    let mut columns: Vec<Growing> = taken
        .iter()
        .filter_map(|place| kinds[*place].as_ref().ok())
        .map(|kind| Growing::new(*kind))
        .collect();
    let layouts: Vec<Layout> = fields.iter().map(batch::layout).collect();
    let mut rows = 0_usize;
    let blocks = blocks(footer.recordBatches()).map_err(|why| unreadable(path, &why))?;
    for block in blocks {
        let batch = batch_of(bytes, block, &room).map_err(|why| unreadable(path, &why))?;
        rows = rows.saturating_add(batch.rows);
        if rows > MOST_WHOLE_ROWS {
            return Err(too_many_rows(path, &format!("more than {MOST_WHOLE_ROWS}")));
        }
        if !take.budget.cells(batch.rows.saturating_mul(taken.len())) {
            return Err(too_much(path));
        }
        add(&batch, &layouts, &taken, &mut columns, &words)
            .map_err(|why| unreadable(path, &why))?;
    }
    let mut cells = columns.into_iter().map(Growing::finish);
    let columns = kinds.into_iter().enumerate().map(|(place, kind)| match kind {
        Err(why) => Cells::Other(why),
        // The places rise, as they were counted up.
        Ok(_) if taken.binary_search(&place).is_ok() => cells.next().unwrap_or(Cells::Unread),
        Ok(_) => Cells::Unread,
    });
    let columns = columns.collect();
    let units = fields.iter().enumerate().filter_map(|(place, field)| {
        let unit = values::unit(field)?.to_owned();
        Some((place, Declared { unit, is_type: true }))
    });
    Ok(Table { names: Some(names), columns, units: units.collect(), ..Table::default() })
}

/// Adds the rows of a batch to the columns taken.
fn add(
    batch: &Batch,
    layouts: &[Layout],
    taken: &[usize],
    columns: &mut [Growing],
    words: &BTreeMap<i64, Words>,
) -> Result<(), String> {
    let mut at = batch::Place::default();
    let mut next = taken.iter().zip(columns).peekable();
    for (place, layout) in layouts.iter().enumerate() {
        if let Some((_, column)) = next.next_if(|(wanted, _)| **wanted == place) {
            column.extend(batch, at, words)?;
        }
        at = at.after(layout, batch)?;
    }
    Ok(())
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
    taken: &[usize],
    fields: &[Field],
    kinds: &[Result<Kind, String>],
) -> Result<BTreeMap<i64, Words>, String> {
    let wanted: BTreeMap<i64, Kind> = taken
        .iter()
        .filter_map(|place| {
            let id = fields[*place].dictionary()?.id();
            let Ok(Kind::Word { of, .. }) = kinds[*place] else { return None };
            Some((id, Kind::Text(of)))
        })
        .take(MOST_COLUMNS)
        .collect();
    let mut all: BTreeMap<i64, Words> = BTreeMap::new();
    for block in blocks(footer.dictionaries())? {
        let Dictionary { id, is_delta, batch } = dictionary_of(bytes, block, room)?;
        let Some(Kind::Text(form)) = wanted.get(&id) else { continue };
        let words = values::words(&batch, *form)?;
        let dictionary = all.entry(id).or_default();
        if !is_delta {
            *dictionary = Words::default();
        }
        dictionary.add(words);
    }
    Ok(all)
}
