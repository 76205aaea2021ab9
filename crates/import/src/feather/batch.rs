//! A batch: which of its bytes belong to which column.

use super::super::limits::{MOST_TEXT, MOST_WHOLE_ROWS};
use arrow_ipc::{
    Block, CompressionType, Field, Message, RecordBatch, Type, UnionMode, root_as_message,
};
use std::borrow::Cow;
use std::cell::Cell;
use std::io::Read as _;

/// A batch of rows, its values not unpacked yet.
pub(super) struct Batch<'a> {
    pub(super) rows: usize,
    body: &'a [u8],
    /// Where each run of bytes begins in the body, and its length.
    buffers: Vec<(i64, i64)>,
    /// How many runs of text each column of views has.
    views: Vec<i64>,
    packed: Option<CompressionType>,
    pub(super) room: &'a Room,
}

/// The room that is left for a file, over all its batches: a batch may be packed to a few bytes.
#[derive(Debug)]
pub(super) struct Room {
    /// Bytes to unpack.
    packed: Cell<usize>,
    /// Bytes of texts.
    text: Cell<usize>,
    /// Words of dictionaries.
    words: Cell<usize>,
}

impl Room {
    pub(super) fn new() -> Self {
        let packed = Cell::new(MOST_PACKED);
        Self { packed, text: Cell::new(MOST_TEXT), words: Cell::new(MOST_WHOLE_ROWS) }
    }

    fn unpack(&self, bytes: usize) -> Result<(), String> {
        spend(&self.packed, bytes, || {
            format!("its mapped columns unpack to more than {MOST_PACKED} bytes")
        })
    }

    /// Takes room for a text.
    pub(super) fn text(&self, text: Option<&str>) -> Result<(), String> {
        spend(&self.text, text.map_or(0, str::len), || {
            format!("the texts in mapped columns have more than {MOST_TEXT} bytes")
        })
    }

    /// Takes room for a word.
    pub(super) fn word(&self, word: Option<&str>) -> Result<(), String> {
        spend(&self.words, 1, || format!("it has more than {MOST_WHOLE_ROWS} words"))?;
        self.text(word)
    }
}

fn spend(left: &Cell<usize>, n: usize, why: impl FnOnce() -> String) -> Result<(), String> {
    left.set(left.get().checked_sub(n).ok_or_else(why)?);
    Ok(())
}

/// Bytes that the mapped columns unpack to, over all batches (1 GiB); of them one column of one
/// batch is held at a time.
const MOST_PACKED: usize = 1 << 30;

/// A batch of rows of a file.
pub(super) fn batch_of<'a>(
    bytes: &'a [u8],
    block: &Block,
    room: &'a Room,
) -> Result<Batch<'a>, String> {
    let (message, body) = message(bytes, block)?;
    let batch = message.header_as_record_batch().ok_or_else(other)?;
    batch_in(&batch, body, room)
}

/// A batch of words.
pub(super) struct Dictionary<'a> {
    pub(super) id: i64,
    /// Whether its words come behind those before, and not in their place.
    pub(super) is_delta: bool,
    pub(super) batch: Batch<'a>,
}

pub(super) fn dictionary_of<'a>(
    bytes: &'a [u8],
    block: &Block,
    room: &'a Room,
) -> Result<Dictionary<'a>, String> {
    let (message, body) = message(bytes, block)?;
    let words = message.header_as_dictionary_batch().ok_or_else(other)?;
    let batch = words.data().ok_or_else(other)?;
    let batch = batch_in(&batch, body, room)?;
    Ok(Dictionary { id: words.id(), is_delta: words.isDelta(), batch })
}

fn other() -> String {
    "where a batch is said to be stands something else".to_owned()
}

fn message<'a>(bytes: &'a [u8], block: &Block) -> Result<(Message<'a>, &'a [u8]), String> {
    const CUT: &str = "a batch is cut off";
    let from = usize::try_from(block.offset()).map_err(|_| CUT)?;
    let head = usize::try_from(block.metaDataLength()).map_err(|_| CUT)?;
    let body = usize::try_from(block.bodyLength()).map_err(|_| CUT)?;
    let rest = bytes.get(from..).ok_or(CUT)?;
    let (head, rest) = rest.split_at_checked(head).ok_or(CUT)?;
    let body = rest.get(..body).ok_or(CUT)?;
    // Before the message stands its length, and since 2019 a mark before that.
    let head = head.strip_prefix(&[0xff; 4]).unwrap_or(head);
    let message = head.get(4..).ok_or(CUT)?;
    let message = root_as_message(message).map_err(|e| format!("a batch is damaged ({e})"))?;
    Ok((message, body))
}

fn batch_in<'a>(batch: &RecordBatch, body: &'a [u8], room: &'a Room) -> Result<Batch<'a>, String> {
    let rows = usize::try_from(batch.length()).ok().filter(|rows| *rows <= MOST_WHOLE_ROWS);
    let buffers = batch.buffers().into_iter().flatten().map(|b| (b.offset(), b.length()));
    Ok(Batch {
        rows: rows.ok_or_else(|| format!("a batch claims {} rows", batch.length()))?,
        body,
        buffers: buffers.collect(),
        views: batch.variadicBufferCounts().into_iter().flatten().collect(),
        packed: batch.compression().map(|packed| packed.codec()),
        room,
    })
}

const COLUMN_CUT: &str = "a column is cut off";

impl<'a> Batch<'a> {
    /// A batch of one run, for tests of how it is packed.
    #[cfg(test)]
    pub(super) fn of_one(
        rows: usize,
        body: &'a [u8],
        packed: CompressionType,
        room: &'a Room,
    ) -> Self {
        let buffers = vec![(0, i64::try_from(body.len()).unwrap_or_default())];
        Self { rows, body, buffers, views: Vec::new(), packed: Some(packed), room }
    }

    /// The bytes of a run, unpacked; at most `most` of them are needed.
    pub(super) fn buffer(&self, number: usize, most: usize) -> Result<Cow<'a, [u8]>, String> {
        let (from, length) = *self.buffers.get(number).ok_or(COLUMN_CUT)?;
        let from = usize::try_from(from).map_err(|_| COLUMN_CUT)?;
        let length = usize::try_from(length).map_err(|_| COLUMN_CUT)?;
        let bytes = self.body.get(from..).and_then(|rest| rest.get(..length));
        let bytes = bytes.ok_or(COLUMN_CUT)?;
        let Some(codec) = self.packed.filter(|_| !bytes.is_empty()) else {
            return Ok(Cow::Borrowed(bytes));
        };
        let (claimed, packed) = bytes.split_first_chunk::<8>().ok_or(COLUMN_CUT)?;
        // What would not have become smaller stands as it is.
        let claimed = match i64::from_le_bytes(*claimed) {
            -1 => return Ok(Cow::Borrowed(packed)),
            claimed => usize::try_from(claimed).map_err(|_| COLUMN_CUT)?,
        };
        // A packed column may unpack to anything: the claim is taken from the room before memory is taken.
        let wanted = claimed.min(most);
        self.room.unpack(wanted)?;
        let room = wanted as u64;
        let mut unpacked = Vec::new();
        let read = match codec {
            CompressionType::LZ4_FRAME => {
                lz4_flex::frame::FrameDecoder::new(packed).take(room).read_to_end(&mut unpacked)
            }
            CompressionType::ZSTD => zstd::stream::read::Decoder::with_buffer(packed)
                .and_then(|decoder| decoder.take(room).read_to_end(&mut unpacked)),
            _ => return Err("its columns are packed in a way that is not known".to_owned()),
        };
        let read = read.map_err(|e| format!("a column cannot be unpacked ({e})"))?;
        if read == wanted { Ok(Cow::Owned(unpacked)) } else { Err(COLUMN_CUT.to_owned()) }
    }

    /// The number of runs of text that the `number`th column of views has.
    pub(super) fn views(&self, number: usize) -> Result<usize, String> {
        let count = self.views.get(number).and_then(|count| usize::try_from(*count).ok());
        let count = count.filter(|count| *count <= self.buffers.len());
        count.ok_or_else(|| COLUMN_CUT.to_owned())
    }
}

/// The runs of bytes that a column takes in each batch, or those that lie before it.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Runs {
    pub(super) buffers: usize,
    /// Columns of views, each with more runs.
    pub(super) views: usize,
}

impl Runs {
    /// The runs before the next column.
    pub(super) fn after(self, layout: &Self, batch: &Batch) -> Result<Self, String> {
        let mut buffers = self.buffers + layout.buffers;
        for view in self.views..self.views + layout.views {
            buffers += batch.views(view)?;
        }
        Ok(Self { buffers, views: self.views + layout.views })
    }
}

/// The layout of a column: its own runs, and those of its children.
pub(super) fn layout(field: &Field) -> Runs {
    // Such a column holds the numbers of words: two runs, whatever the words are.
    if field.dictionary().is_some() {
        return Runs { buffers: 2, views: 0 };
    }
    let buffers = match field.type_type() {
        Type::Null | Type::RunEndEncoded => 0,
        Type::Struct_ | Type::FixedSizeList => 1,
        Type::Utf8 | Type::LargeUtf8 | Type::Binary | Type::LargeBinary => 3,
        Type::ListView | Type::LargeListView => 3,
        Type::Union => {
            let is_dense = field.type_as_union().is_some_and(|u| u.mode() == UnionMode::Dense);
            if is_dense { 2 } else { 1 }
        }
        _ => 2,
    };
    let views = usize::from(matches!(field.type_type(), Type::Utf8View | Type::BinaryView));
    let children = field.children().into_iter().flatten().map(|child| layout(&child));
    children.fold(Runs { buffers, views }, |sum, child| Runs {
        buffers: sum.buffers + child.buffers,
        views: sum.views + child.views,
    })
}
