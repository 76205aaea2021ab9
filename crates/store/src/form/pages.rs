//! The pages of a column of a recording, unpacked by one decompressor per thread: the reader of the
//! parquet crate makes a compressor and a decompressor for every column of every file, which takes
//! longer than to unpack a trial.

use crate::disk::content::Content;
use crate::form::bounds::{PageHeader, page_header, place_of, run_of_ones};
use crate::form::streams::Joined;
use bytes::Bytes;
use parquet::basic::{CompressionCodec, Encoding};
use parquet::column::page::{Page, PageMetadata, PageReader};
use parquet::errors::{ParquetError, Result};
use parquet::file::metadata::ColumnChunkMetaData;
use std::cell::RefCell;
use std::collections::VecDeque;
use std::io;
use zstd::bulk::Decompressor;

/// The pages of a column chunk, in the form that the writer of recordings gives them.
pub(crate) struct Pages {
    left: VecDeque<(Header, Bytes)>,
    is_packed: bool,
}

#[derive(Clone, Copy)]
struct Header {
    is_dictionary: bool,
    unpacked: usize,
    values: u32,
    encoding: Encoding,
    nulls: Encoding,
}

impl Pages {
    /// The pages of `column`; `None` if another writer gave them another form.
    pub(crate) fn of(content: &Content, column: &ColumnChunkMetaData) -> Option<Self> {
        let is_packed = match column.compression_codec() {
            CompressionCodec::ZSTD => true,
            CompressionCodec::UNCOMPRESSED => false,
            _ => return None,
        };
        let (from, length) = place_of(column)?;
        let chunk = content.range(from, length).ok()?;
        let mut left = VecDeque::new();
        let mut rest = &*chunk;
        while !rest.is_empty() {
            let header = page_header(rest)?;
            let (page, after) = header.page_and_rest(rest)?;
            left.push_back((Header::of(&header)?, chunk.slice_ref(page)));
            rest = after;
        }
        Some(Self { left, is_packed })
    }

    /// The number of rows, as the pages say.
    pub(crate) fn rows(&self) -> usize {
        self.left.iter().map(|(header, _)| header.values as usize).sum()
    }

    /// Fills `into` with the values of its rows, where their bytes are split into streams and none is
    /// null; `None` where they are laid otherwise, or damaged.
    pub(crate) fn split_values<T: Joined>(&self, mut into: &mut [f64]) -> Option<()> {
        for (header, page) in &self.left {
            let is_split = header.encoding == Encoding::BYTE_STREAM_SPLIT;
            if header.is_dictionary || !is_split || header.unpacked > MOST_ROOM {
                return None;
            }
            let (own, rest) = into.split_at_mut_checked(header.values as usize)?;
            match self.is_packed {
                true => UNPACKED.with_borrow_mut(|room| {
                    room.clear();
                    room.try_reserve(header.unpacked).ok()?;
                    with_decompressor(|with| with.decompress_to_buffer(page, room)).ok()?;
                    join_page::<T>(room, header, own)
                })?,
                false => join_page::<T>(page, header, own)?,
            }
            into = rest;
        }
        into.is_empty().then_some(())
    }
}

/// The values of an unpacked page whose levels say, in one run, that none is null.
fn join_page<T: Joined>(page: &[u8], header: &Header, into: &mut [f64]) -> Option<()> {
    let (length, rest) = page.split_first_chunk::<4>()?;
    let (levels, streams) = rest.split_at_checked(u32::from_le_bytes(*length) as usize)?;
    let is_whole = page.len() == header.unpacked && header.nulls == Encoding::RLE;
    if !is_whole || run_of_ones(levels)? != u64::from(header.values) {
        return None;
    }
    T::join(streams, into)
}

impl Header {
    fn of(header: &PageHeader) -> Option<Self> {
        let is_dictionary = match header.kind {
            0 => false,
            2 => true,
            _ => return None,
        };
        Some(Self {
            is_dictionary,
            unpacked: usize::try_from(header.unpacked).ok()?,
            values: u32::try_from(header.values).ok()?,
            encoding: encoding(header.encoding)?,
            // A dictionary has no null, and its header no such encoding.
            nulls: if is_dictionary { Encoding::RLE } else { encoding(header.nulls)? },
        })
    }
}

/// The encodings that recordings have, by their numbers in a file.
fn encoding(number: i64) -> Option<Encoding> {
    Some(match number {
        0 => Encoding::PLAIN,
        2 => Encoding::PLAIN_DICTIONARY,
        3 => Encoding::RLE,
        5 => Encoding::DELTA_BINARY_PACKED,
        8 => Encoding::RLE_DICTIONARY,
        9 => Encoding::BYTE_STREAM_SPLIT,
        _ => return None,
    })
}

/// Largest page that is unpacked into memory that a thread keeps, bytes (2 MiB): twice as long as
/// writers make them.
const MOST_ROOM: usize = 1 << 21;

thread_local! {
    static DECOMPRESSOR: RefCell<Option<Decompressor<'static>>> = const { RefCell::new(None) };
    static UNPACKED: RefCell<Vec<u8>> = const { RefCell::new(Vec::new()) };
}

/// Calls `unpack` with the thread's decompressor.
fn with_decompressor<T>(
    unpack: impl FnOnce(&mut Decompressor<'static>) -> io::Result<T>,
) -> io::Result<T> {
    DECOMPRESSOR.with_borrow_mut(|kept| {
        unpack(match kept {
            Some(decompressor) => decompressor,
            None => kept.insert(Decompressor::new()?),
        })
    })
}

impl PageReader for Pages {
    fn get_next_page(&mut self) -> Result<Option<Page>> {
        let Some((header, page)) = self.left.pop_front() else { return Ok(None) };
        let buf = match self.is_packed {
            true => with_decompressor(|with| with.decompress(&page, header.unpacked))?.into(),
            false => page,
        };
        if buf.len() != header.unpacked {
            let (length, expected) = (buf.len(), header.unpacked);
            let what = format!("a page has {length} bytes, not {expected}");
            return Err(ParquetError::General(what));
        }
        let Header { is_dictionary, values: num_values, encoding, nulls, .. } = header;
        Ok(Some(match is_dictionary {
            true => Page::DictionaryPage { buf, num_values, encoding, is_sorted: false },
            false => Page::DataPage {
                buf,
                num_values,
                encoding,
                def_level_encoding: nulls,
                rep_level_encoding: Encoding::RLE, // a column without lists has none
                statistics: None,
            },
        }))
    }

    fn peek_next_page(&mut self) -> Result<Option<PageMetadata>> {
        Ok(self.left.front().map(|(header, _)| PageMetadata {
            num_rows: None,
            num_levels: Some(header.values as usize),
            is_dict: header.is_dictionary,
        }))
    }

    fn skip_next_page(&mut self) -> Result<()> {
        self.left.pop_front();
        Ok(())
    }
}

impl Iterator for Pages {
    type Item = Result<Page>;

    fn next(&mut self) -> Option<Self::Item> {
        self.get_next_page().transpose()
    }
}
