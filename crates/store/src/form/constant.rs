//! A column whose values are all the same, as Parquet has it in two pages: a dictionary of the one
//! value, and one run of its index. The writer of the library looks each row up in the dictionary, which
//! for a dozen keys of a dozen million samples takes longer than all else.

use arrow::array::{ArrayRef, Float64Array, Int32Array, StringArray};
use parquet::basic::{Compression, Encoding};
use parquet::column::page::{CompressedPage, Page, PageWriter as _};
use parquet::column::writer::ColumnCloseResult;
use parquet::data_type::ByteArray;
use parquet::errors::ParquetError;
use parquet::file::metadata::ColumnChunkMetaData;
use parquet::file::page_index::offset_index::{OffsetIndexMetaData, PageLocation};
use parquet::file::statistics::Statistics;
use parquet::file::writer::{SerializedPageWriter, SerializedRowGroupWriter, TrackedWrite};
use parquet::schema::types::ColumnDescPtr;
use std::io::Write;
use std::sync::Arc;

/// The one value of a column.
#[derive(Debug, Clone, PartialEq)]
pub(crate) enum Constant {
    Text(Option<String>),
    Whole(Option<i32>),
    Number(Option<f64>),
}

impl Constant {
    /// Adds `rows` rows of it to a row group, as its next column, which may have nulls.
    pub(crate) fn append<W: Write + Send>(
        &self,
        rows: u32,
        column: ColumnDescPtr,
        group: &mut SerializedRowGroupWriter<'_, W>,
    ) -> Result<(), ParquetError> {
        let value = self.plain()?;
        let is_null = value.is_none();
        let mut sink = TrackedWrite::new(Vec::new());
        let mut pages = SerializedPageWriter::new(&mut sink);
        let dictionary = Page::DictionaryPage {
            num_values: u32::from(!is_null),
            buf: value.unwrap_or_default().into(),
            encoding: Encoding::PLAIN,
            is_sorted: false,
        };
        let data = Page::DataPage {
            buf: data_page(rows, is_null).into(),
            num_values: rows,
            encoding: Encoding::RLE_DICTIONARY,
            def_level_encoding: Encoding::RLE,
            rep_level_encoding: Encoding::RLE,
            statistics: None,
        };
        let [dictionary, data] = [dictionary, data].map(|page| {
            let size = page.buffer().len();
            pages.write_page(CompressedPage::new(page, size))
        });
        let (dictionary, data) = (dictionary?, data?);
        let bytes = sink.into_inner()?;
        let place = |offset: u64| i64::try_from(offset).map_err(|e| general(&e));
        let size = place(bytes.len() as u64)?;
        let metadata = ColumnChunkMetaData::builder(column)
            .set_compression(Compression::UNCOMPRESSED)
            .set_encodings(vec![Encoding::PLAIN, Encoding::RLE, Encoding::RLE_DICTIONARY])
            .set_num_values(rows.into())
            .set_total_compressed_size(size)
            .set_total_uncompressed_size(size)
            .set_dictionary_page_offset(Some(place(dictionary.offset)?))
            .set_data_page_offset(place(data.offset)?)
            .set_statistics(self.statistics(if is_null { rows } else { 0 }))
            .build()?;
        let close = ColumnCloseResult {
            bytes_written: bytes.len() as u64,
            rows_written: rows.into(),
            metadata,
            bloom_filter: None,
            column_index: None,
            // Without one, the library could not write those of the other columns.
            offset_index: Some(OffsetIndexMetaData {
                page_locations: vec![PageLocation {
                    offset: place(data.offset)?,
                    compressed_page_size: i32::try_from(data.bytes_written)
                        .map_err(|e| general(&e))?,
                    first_row_index: 0,
                }],
                unencoded_byte_array_data_bytes: None,
            }),
        };
        group.append_column(&bytes::Bytes::from(bytes), close)
    }

    /// `rows` rows of it as an array.
    pub(crate) fn array(&self, rows: usize) -> ArrayRef {
        match self {
            Self::Text(value) => Arc::new(StringArray::from(vec![value.as_deref(); rows])),
            Self::Whole(value) => Arc::new(Int32Array::from(vec![*value; rows])),
            Self::Number(value) => Arc::new(Float64Array::from(vec![*value; rows])),
        }
    }

    /// The value in the encoding PLAIN.
    fn plain(&self) -> Result<Option<Vec<u8>>, ParquetError> {
        Ok(match self {
            Self::Text(Some(text)) => {
                let length = u32::try_from(text.len()).map_err(|e| general(&e))?;
                Some([&length.to_le_bytes(), text.as_bytes()].concat())
            }
            Self::Whole(Some(value)) => Some(value.to_le_bytes().to_vec()),
            Self::Number(Some(value)) => Some(value.to_le_bytes().to_vec()),
            Self::Text(None) | Self::Whole(None) | Self::Number(None) => None,
        })
    }

    /// What a reader that looks for a value needs in order to skip the row group.
    fn statistics(&self, nulls: u32) -> Statistics {
        let nulls = Some(nulls.into());
        match self {
            Self::Text(value) => {
                let value = value.as_deref().map(ByteArray::from);
                Statistics::byte_array(value.clone(), value, None, nulls, false)
            }
            Self::Whole(value) => Statistics::int32(*value, *value, None, nulls, false),
            // Of the two zeros the format asks for the smaller one as the smallest value.
            Self::Number(Some(0.0)) => {
                Statistics::double(Some(-0.0), Some(0.0), None, nulls, false)
            }
            Self::Number(value) => Statistics::double(*value, *value, None, nulls, false),
        }
    }
}

/// `rows` times the first value of the dictionary, or null: the levels with their length before them,
/// then the indices with the width of one before them; one run each.
fn data_page(rows: u32, is_null: bool) -> Vec<u8> {
    let levels = run(rows, u8::from(!is_null));
    let indices = if is_null { Vec::new() } else { run(rows, 0) };
    // A run is six bytes at most.
    let length = u32::try_from(levels.len()).unwrap_or_default().to_le_bytes();
    [&length[..], &levels, &[1], &indices].concat()
}

/// A run of one value of one bit: twice its length in groups of seven bits, lowest first, and the value.
fn run(rows: u32, value: u8) -> Vec<u8> {
    let mut header = u64::from(rows) << 1;
    let mut bytes = Vec::new();
    while header > 0x7f {
        bytes.push(u8::try_from(header & 0x7f).unwrap_or_default() | 0x80);
        header >>= 7;
    }
    bytes.extend([u8::try_from(header).unwrap_or_default(), value]);
    bytes
}

fn general(error: &dyn std::fmt::Display) -> ParquetError {
    ParquetError::General(error.to_string())
}

#[cfg(test)]
mod tests {
    use super::*;
    use arrow::array::RecordBatch;
    use arrow::datatypes::{DataType, Field, Schema};
    use parquet::arrow::ArrowSchemaConverter;
    use parquet::arrow::arrow_reader::ParquetRecordBatchReaderBuilder;
    use parquet::file::properties::WriterProperties;
    use parquet::file::writer::SerializedFileWriter;

    #[test]
    fn a_reader_finds_the_one_value_in_every_row_and_its_statistics_and_null_where_there_is_none() {
        let columns = [
            (DataType::Utf8, [Constant::Text(Some("höher".to_owned())), Constant::Text(None)]),
            (DataType::Int32, [Constant::Whole(Some(-7)), Constant::Whole(None)]),
            (DataType::Float64, [Constant::Number(Some(0.25)), Constant::Number(None)]),
        ];
        let fields = columns.iter().zip(["text", "whole", "number"]);
        let fields: Vec<Field> =
            fields.map(|((kind, _), name)| Field::new(name, kind.clone(), true)).collect();
        let parquet_schema = ArrowSchemaConverter::new().convert(&Schema::new(fields)).unwrap();
        // Around each length at which the head of a run takes a byte more, and the longest row group.
        let lengths = [1, 8, 63, 64, 8191, 8192, 1_048_575, 1_048_576];
        let mut bytes = Vec::new();
        let properties = Arc::new(WriterProperties::default());
        let root = parquet_schema.root_schema_ptr();
        let mut file = SerializedFileWriter::new(&mut bytes, root, properties).unwrap();
        for rows in lengths {
            for nth in 0..2 {
                let mut group = file.next_row_group().unwrap();
                for ((_, values), column) in columns.iter().zip(parquet_schema.columns()) {
                    values[nth].append(rows, column.clone(), &mut group).unwrap();
                }
                group.close().unwrap();
            }
        }
        file.close().unwrap();
        let bytes = bytes::Bytes::from(bytes);
        for (place, rows) in lengths.into_iter().flat_map(|n| [n, n]).enumerate() {
            let file = ParquetRecordBatchReaderBuilder::try_new(bytes.clone()).unwrap();
            let is_null = place % 2 == 1;
            for column in file.metadata().row_group(place).columns() {
                let said = column.statistics().unwrap();
                assert_eq!(said.null_count_opt(), Some(if is_null { rows.into() } else { 0 }));
                assert_eq!(said.min_bytes_opt(), said.max_bytes_opt());
                assert_eq!(said.min_bytes_opt().is_none(), is_null);
            }
            let n = usize::try_from(rows).unwrap();
            let mut batches = file.with_row_groups(vec![place]).with_batch_size(n).build().unwrap();
            let batch: RecordBatch = batches.next().unwrap().unwrap();
            let there = !is_null;
            let text: ArrayRef = Arc::new(StringArray::from(vec![there.then_some("höher"); n]));
            let whole: ArrayRef = Arc::new(Int32Array::from(vec![there.then_some(-7); n]));
            let number: ArrayRef = Arc::new(Float64Array::from(vec![there.then_some(0.25); n]));
            assert_eq!(batch.columns(), [text, whole, number]);
            for (column, (_, values)) in batch.columns().iter().zip(&columns) {
                assert_eq!(column, &values[place % 2].array(n));
            }
            assert!(batches.next().is_none());
        }
    }
}
