//! Parquet files from any program.

use super::limits::{
    MOST_TEXT, MOST_UNPACKED, MOST_WHOLE_ROWS, Take, check_columns, too_many_rows,
};
use super::spelling::shown;
use super::table::{Built, Cells, Declared, Table};
use ::parquet::arrow::ProjectionMask;
use ::parquet::arrow::arrow_reader::{
    ArrowReaderMetadata, ArrowReaderOptions, ParquetRecordBatchReaderBuilder,
};
use ::parquet::basic::Type as Physical;
use ::parquet::errors::ParquetError;
use arrow::array::{
    ArrayRef, AsArray, Float64Builder, LargeStringBuilder, StringArray, make_array,
};
use arrow::compute::floats;
use arrow::datatypes::{
    ArrowPrimitiveType, DataType, FieldRef, Fields, Int32Type, Int64Type, Schema, TimeUnit,
    UInt64Type,
};
use bytes::Bytes;
use std::path::Path;
use std::sync::Arc;
use zwidth_store::StoreError;
use zwidth_store::claims::{check_codecs, check_footer, check_pages, guarded};

const REMEDY: &str = "the file may be cut off or damaged; copy or export it again";

/// Rows that are decoded at a time: what a file claims decides no allocation.
const BATCH_ROWS: usize = 1 << 13;

/// Reads the columns that are taken of a Parquet file.
pub(super) fn read(path: &Path, bytes: Vec<u8>, take: &Take) -> Result<Table, StoreError> {
    if bytes.is_empty() {
        return Err(StoreError::new(path, "the file is empty", REMEDY));
    }
    check_footer(&bytes).map_err(|why| unreadable(path, &why))?;
    let bytes = Bytes::from(bytes);
    let options = ArrowReaderOptions::default();
    let metadata = guarded(path, REMEDY, || ArrowReaderMetadata::load(&bytes, options))?;
    check_codecs(path, metadata.metadata())?;
    let fields: Vec<FieldRef> = metadata.schema().fields().iter().cloned().collect();
    let rows = rows(path, &metadata, fields.len())?;
    let kinds: Vec<Option<Kind>> = (0..fields.len()).map(|root| kind(&metadata, root)).collect();
    let usable = (0..fields.len()).filter(|root| kinds[*root].is_some());
    let roots: Vec<usize> =
        usable.filter(|root| take.wants(*root, Some(fields[*root].name()))).collect();
    take.room(path, rows.saturating_mul(roots.len()))?;
    let schema = metadata.metadata().file_metadata().schema_descr();
    let unpacked = check_pages(&bytes, metadata.metadata(), |leaf| {
        roots.contains(&schema.get_column_root_idx(leaf))
    });
    let unpacked = unpacked.map_err(|why| unreadable(path, &why))?;
    if unpacked > MOST_UNPACKED {
        let what = format!(
            "the mapped columns unpack to {unpacked} bytes, and at most {MOST_UNPACKED} are read"
        );
        return Err(StoreError::new(path, what, "split the file"));
    }
    let mut text = 0;
    let mut growing: Vec<Built> =
        roots.iter().filter_map(|root| kinds[*root]).map(column).collect();
    guarded(path, REMEDY, || {
        if roots.is_empty() {
            return Ok(());
        }
        // Text as a dictionary: a long word that every row repeats stays one word.
        let word = DataType::Dictionary(Box::new(DataType::Int32), Box::new(DataType::Utf8));
        let typed = fields.iter().zip(&kinds).map(|(field, kind)| match kind {
            Some(Kind::Text) => field.as_ref().clone().with_data_type(word.clone()).into(),
            _ => field.clone(),
        });
        let fields: Fields = typed.collect();
        let options = ArrowReaderOptions::default().with_schema(Arc::new(Schema::new(fields)));
        let metadata = ArrowReaderMetadata::try_new(metadata.metadata().clone(), options)?;
        let mask = ProjectionMask::roots(schema, roots.iter().copied());
        let builder = ParquetRecordBatchReaderBuilder::new_with_metadata(bytes.clone(), metadata);
        for batch in builder.with_projection(mask).with_batch_size(BATCH_ROWS).build()? {
            for (column, array) in growing.iter_mut().zip(batch?.columns()) {
                extend(column, array, &mut text)?;
            }
        }
        Ok(())
    })?;
    let unread = fields.iter().zip(&kinds).map(|(field, kind)| match kind {
        Some(_) => Cells::Unread,
        None => {
            let name = field.data_type().to_string();
            Cells::Other(format!("its type {} is neither number nor text", shown(&name)))
        }
    });
    let mut columns: Vec<Cells> = unread.collect();
    for (root, read) in roots.iter().zip(growing) {
        columns[*root] = read.finish();
    }
    let names = fields.iter().map(|f| f.name().clone()).collect();
    let units = fields.iter().enumerate().filter_map(|(place, field)| {
        let unit = unit(field.data_type())?.to_owned();
        Some((place, Declared { unit, is_type: true }))
    });
    Ok(Table { names: Some(names), columns, units: units.collect(), ..Table::default() })
}

/// The number of rows, where it and that of the columns are ones that are read.
fn rows(path: &Path, metadata: &ArrowReaderMetadata, columns: usize) -> Result<usize, StoreError> {
    let file = metadata.metadata().file_metadata();
    check_columns(path, columns.max(file.schema_descr().num_columns()))?;
    let rows = usize::try_from(file.num_rows()).ok().filter(|rows| *rows <= MOST_WHOLE_ROWS);
    let rows = rows.ok_or_else(|| too_many_rows(path, &file.num_rows().to_string()))?;
    // The decoder goes by the groups, and a run of one value takes a few bytes whatever its length.
    let left =
        metadata.metadata().row_groups().iter().try_fold(rows, |left, group| {
            left.checked_sub(usize::try_from(group.num_rows()).ok()?)
        });
    if left == Some(0) {
        return Ok(rows);
    }
    Err(unreadable(path, &format!("its footer claims {rows} rows, and its row groups others")))
}

/// A column of this kind, without rows.
fn column(kind: Kind) -> Built {
    match kind {
        Kind::Number => Built::Numbers(Float64Builder::new()),
        Kind::Whole => Built::Whole(Vec::new()),
        Kind::Text => Built::Text(LargeStringBuilder::new()),
    }
}

/// Adds a batch to a column; `text` counts the bytes of all texts.
fn extend(column: &mut Built, array: &ArrayRef, text: &mut usize) -> Result<(), ParquetError> {
    match column {
        Built::Unread => {}
        Built::Numbers(numbers) => numbers.extend(&floats(array)?),
        Built::Whole(whole) => whole.extend(match array.data_type() {
            DataType::UInt64 => whole_numbers::<UInt64Type>(array)?,
            // Times and dates are whole numbers of eight bytes, or of four.
            kind if kind.primitive_width() == Some(size_of::<i64>()) => {
                whole_numbers::<Int64Type>(array)?
            }
            _ => whole_numbers::<Int32Type>(array)?,
        }),
        Built::Text(texts) => {
            let words = array
                .as_dictionary_opt::<Int32Type>()
                .and_then(|d| d.downcast_dict::<StringArray>());
            let words = words.ok_or_else(|| {
                let what = "its text has a type that cannot be read; save it as plain strings";
                ParquetError::General(what.to_owned())
            })?;
            for word in words {
                *text += word.map_or(0, str::len);
                if *text > MOST_TEXT {
                    let what =
                        format!("the texts in mapped columns have more than {MOST_TEXT} bytes");
                    return Err(ParquetError::General(what));
                }
                texts.append_option(word);
            }
        }
    }
    Ok(())
}

/// The numbers of an array whose values lie as those of this type do.
fn whole_numbers<T>(array: &ArrayRef) -> Result<Vec<Option<i128>>, ParquetError>
where
    T: ArrowPrimitiveType,
    i128: From<T::Native>,
{
    let data = array.to_data().into_builder().data_type(T::DATA_TYPE).build()?;
    let numbers = make_array(data);
    Ok(numbers.as_primitive::<T>().iter().map(|number| number.map(i128::from)).collect())
}

fn unreadable(path: &Path, why: &str) -> StoreError {
    StoreError::new(path, format!("not a readable Parquet file: {why}"), REMEDY)
}

/// The kind of a column.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Kind {
    Number,
    /// A number of eight bytes without decimals, or a time.
    Whole,
    Text,
}

/// What a column is: by its type, and by how it lies in the file. What lies there as bytes of a
/// length that the file chooses is a number only if it is short.
fn kind(metadata: &ArrowReaderMetadata, root: usize) -> Option<Kind> {
    /// Bytes of the longest number, a decimal of 256 bits.
    const LONGEST: i32 = 32;
    let schema = metadata.metadata().file_metadata().schema_descr();
    let leaf = (0..schema.num_columns()).find(|leaf| schema.get_column_root_idx(*leaf) == root)?;
    let leaf = schema.column(leaf);
    let short = match leaf.physical_type() {
        Physical::INT32 | Physical::INT64 | Physical::FLOAT | Physical::DOUBLE => true,
        Physical::FIXED_LEN_BYTE_ARRAY => (0..=LONGEST).contains(&leaf.type_length()),
        _ => false,
    };
    match kind_of(metadata.schema().field(root).data_type())? {
        Kind::Number => short.then_some(Kind::Number),
        // Old programs have times in twelve bytes.
        Kind::Whole => (short || leaf.physical_type() == Physical::INT96).then_some(Kind::Whole),
        Kind::Text => (leaf.physical_type() == Physical::BYTE_ARRAY).then_some(Kind::Text),
    }
}

fn kind_of(data_type: &DataType) -> Option<Kind> {
    match data_type {
        DataType::Dictionary(_, values) => kind_of(values).map(|kind| match kind {
            Kind::Text => Kind::Text,
            Kind::Number | Kind::Whole => Kind::Number,
        }),
        DataType::Utf8 | DataType::LargeUtf8 | DataType::Utf8View => Some(Kind::Text),
        DataType::Int64 | DataType::UInt64 => Some(Kind::Whole),
        time if unit(time).is_some() => Some(Kind::Whole),
        numeric if numeric.is_numeric() => Some(Kind::Number),
        _ => None,
    }
}

/// The unit of a type of times: a duration, a moment since 1970 or a time of day in it, a date in days.
fn unit(data_type: &DataType) -> Option<&'static str> {
    match data_type {
        DataType::Duration(unit)
        | DataType::Timestamp(unit, _)
        | DataType::Time32(unit)
        | DataType::Time64(unit) => Some(match unit {
            TimeUnit::Second => "s",
            TimeUnit::Millisecond => "ms",
            TimeUnit::Microsecond => "us",
            TimeUnit::Nanosecond => "ns",
        }),
        DataType::Date32 => Some("d"),
        DataType::Date64 => Some("ms"),
        _ => None,
    }
}

#[cfg(test)]
pub(super) mod tests {
    use super::super::limits::tests::{everything, only};
    use super::super::table::Cell;
    use super::*;
    use ::parquet::arrow::ArrowWriter;
    use ::parquet::basic::CompressionCodec;
    use ::parquet::file::metadata::{
        ColumnChunkMetaData, FileMetaData, ParquetMetaDataReader, ParquetMetaDataWriter,
        RowGroupMetaData,
    };
    use arrow::array::{
        BooleanArray, Decimal128Array, DictionaryArray, Float32Array, Float64Array, Int64Array,
        LargeStringArray, RecordBatch,
    };

    fn read(bytes: Vec<u8>) -> Result<Table, StoreError> {
        everything(|take| super::read(Path::new("a.parquet"), bytes, take))
    }

    fn sample() -> Vec<u8> {
        let mode: DictionaryArray<Int32Type> = ["a", "b"].into_iter().collect();
        let batch = RecordBatch::try_from_iter([
            ("f", Arc::new(Float32Array::from(vec![Some(0.1), None])) as ArrayRef),
            ("n", Arc::new(Int64Array::from(vec![1, 2]))),
            ("mode", Arc::new(mode)),
            ("who", Arc::new(StringArray::from(vec!["x", "y"]))),
            ("on", Arc::new(BooleanArray::from(vec![true, false]))),
        ])
        .unwrap();
        encode(&batch)
    }

    /// A Parquet file with the writer's own defaults.
    pub(in super::super) fn encode(batch: &RecordBatch) -> Vec<u8> {
        let mut bytes = Vec::new();
        let mut writer = ArrowWriter::try_new(&mut bytes, batch.schema(), None).unwrap();
        writer.write(batch).unwrap();
        writer.close().unwrap();
        bytes
    }

    #[test]
    fn numbers_are_f64_words_are_text_and_the_rest_says_why_not() {
        let table = read(sample()).unwrap();
        let cell = |c: usize, r: usize| table.columns[c].cell(r);
        assert_eq!(cell(0, 0), Cell::Number(f64::from(0.1_f32)));
        assert_eq!((cell(0, 1), cell(1, 1)), (Cell::Empty, Cell::Number(2.0)));
        assert_eq!((cell(2, 1), cell(3, 0)), (Cell::Text("b"), Cell::Text("x")));
        assert!(matches!(&table.columns[4], Cells::Other(why) if why.contains("Boolean")));
    }

    #[test]
    fn a_file_compressed_with_gzip_is_named_so() {
        let mut bytes = sample();
        let metadata =
            ParquetMetaDataReader::new().parse_and_finish(&Bytes::from(bytes.clone())).unwrap();
        let group = |group: &RowGroupMetaData| {
            let said = |c: &ColumnChunkMetaData| {
                c.clone().into_builder().set_compression_codec(CompressionCodec::GZIP).build()
            };
            let columns = group.columns().iter().map(|c| said(c).unwrap()).collect();
            group.clone().into_builder().set_column_metadata(columns).build().unwrap()
        };
        let groups = metadata.row_groups().iter().map(group).collect();
        let metadata = metadata.into_builder().set_row_groups(groups).build();
        ParquetMetaDataWriter::new(&mut bytes, &metadata).finish().unwrap();
        let error = read(bytes).unwrap_err();
        assert!(error.what.contains("compressed with gzip"), "{error}");
    }

    #[test]
    fn a_file_cut_anywhere_is_one_clear_error() {
        let bytes = sample();
        for cut in (0..bytes.len()).step_by(41) {
            let error = read(bytes[..cut].to_vec()).unwrap_err();
            assert!(error.what.contains("Parquet") || error.what.contains("empty"), "{error}");
        }
    }

    #[test]
    fn a_flipped_bit_never_ends_the_program() {
        let bytes = sample();
        for i in 0..bytes.len() {
            let mut bad = bytes.clone();
            bad[i] ^= 1 << (i % 8);
            let _ = read(bad);
        }
    }

    fn refused(bytes: Vec<u8>) -> String {
        read(bytes).unwrap_err().what
    }

    fn file(columns: Vec<(&str, ArrayRef)>) -> Vec<u8> {
        encode(&RecordBatch::try_from_iter(columns).unwrap())
    }

    #[test]
    fn every_way_to_write_words_and_numbers_reads_alike() {
        let decimal =
            Decimal128Array::from(vec![Some(150), None]).with_precision_and_scale(30, 2).unwrap();
        let table = read(file(vec![
            ("large", Arc::new(LargeStringArray::from(vec![Some("x"), None]))),
            ("plain", Arc::new(StringArray::from(vec!["", "ä"]))),
            ("decimal", Arc::new(decimal)),
        ]));
        let columns = table.unwrap().columns;
        let cells: Vec<_> = columns.iter().map(|c| (c.cell(0), c.cell(1))).collect();
        assert_eq!(cells[0], (Cell::Text("x"), Cell::Empty));
        assert_eq!(cells[1], (Cell::Text(""), Cell::Text("ä")));
        assert_eq!(cells[2], (Cell::Number(1.5), Cell::Empty));
    }

    #[test]
    fn a_footer_that_claims_more_rows_than_are_read_is_refused() {
        let bytes = sample();
        let metadata =
            ParquetMetaDataReader::new().parse_and_finish(&Bytes::from(bytes.clone())).unwrap();
        for rows in [MOST_WHOLE_ROWS as i64 + 1, 1_000_000_000_000, i64::MAX] {
            let old = metadata.file_metadata();
            let claims = FileMetaData::new(
                old.version(),
                rows,
                None,
                old.key_value_metadata().cloned(),
                old.schema_descr_ptr(),
                None,
            );
            let group =
                metadata.row_group(0).clone().into_builder().set_num_rows(rows).build().unwrap();
            let claims = ::parquet::file::metadata::ParquetMetaData::new(claims, vec![group]);
            let mut bad = bytes.clone();
            ParquetMetaDataWriter::new(&mut bad, &claims).finish().unwrap();
            let error = refused(bad);
            let words = format!("has {rows} rows, and at most 4194304");
            assert!(error.contains(&words), "{error}");
        }
    }

    #[test]
    fn pages_that_unpack_to_more_than_is_read_are_refused_and_only_where_they_are_mapped() {
        let zeros: ArrayRef = Arc::new(Float64Array::from(vec![0.0; 1 << 17]));
        let long: ArrayRef =
            Arc::new(StringArray::from_iter_values((0..1 << 17).map(|i| format!("{i:0>600}"))));
        let bytes = file(vec![("t", zeros), ("note", long)]);
        assert!(bytes.len() < 1 << 27, "{}", bytes.len());
        let error = refused(bytes.clone());
        assert!(error.contains("column note unpacks to more than 67108864 bytes"), "{error}");
        let read = |take: &Take| super::read(Path::new("a.parquet"), bytes, take);
        let table = only(&["t"], read).unwrap();
        assert_eq!((table.columns[0].len(), table.columns[1].len()), (1 << 17, 0));
    }

    #[test]
    fn a_long_word_that_every_row_repeats_is_refused_before_it_fills_memory() {
        let long = "x".repeat(1 << 16);
        let words: DictionaryArray<Int32Type> = (0..1 << 12).map(|_| long.as_str()).collect();
        let bytes = file(vec![("who", Arc::new(words))]);
        assert!(bytes.len() < 1 << 20, "{}", bytes.len());
        let error = refused(bytes);
        assert!(
            error.contains("texts in mapped columns have more than 134217728 bytes"),
            "{error}"
        );
    }

    #[test]
    fn more_columns_than_are_read_are_refused() {
        let one: ArrayRef = Arc::new(Int64Array::from(vec![1]));
        let names: Vec<String> = (0..=1 << 14).map(|i| i.to_string()).collect();
        let error = refused(file(names.iter().map(|n| (n.as_str(), one.clone())).collect()));
        assert!(error.contains("has 16385 columns, and at most 16384"), "{error}");
    }
}
