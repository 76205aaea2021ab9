//! Encodings, chosen by measurement (`cargo xtask encodings`; the numbers are in `docs/data.md`).

use arrow::datatypes::{DataType, Field, Schema};
use parquet::basic::{Compression, Encoding as ParquetEncoding, ZstdLevel};
use parquet::errors::ParquetError;
use parquet::file::metadata::KeyValue;
use parquet::file::properties::{
    EnabledStatistics, WriterProperties, WriterPropertiesBuilder, WriterVersion,
};
use parquet::schema::types::ColumnPath;

/// How a column's values are laid out before compression.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Encoding {
    /// Distinct values once, then indices. For columns that hardly vary, and held values.
    Dictionary,
    /// First bytes together, second bytes together, … For measured floats.
    ByteStreamSplit,
    /// Differences. For counts.
    Delta,
    /// Values one after the other.
    Plain,
}

/// zstd level: on real recordings level 9 saves at most 2.3 % more and takes twice as long to
/// write.
const ZSTD_LEVEL: i32 = 3;

/// The encoding of a column, by its name.
pub fn encoding_of(column: &str) -> Encoding {
    match column {
        "t_s" | "t_device_s" | "theta_rad" | "theta_dot_rad_s" | "theta_ddot_rad_s2"
        | "force_ex_n" | "torque_ex_nm" | "force_cmd_n" | "force_age_s" | "voltage_motor_v"
        | "voltage_brake_v" | "command" | "response" => Encoding::ByteStreamSplit,
        "theta_raw" => Encoding::Delta,
        _ => Encoding::Dictionary,
    }
}

/// Writer settings of a recording: what is kept for ever is made small.
pub(crate) fn recorded(
    schema: &Schema,
    footer: Vec<KeyValue>,
    group_rows: Option<usize>,
) -> Result<WriterProperties, ParquetError> {
    let columns = schema.fields().iter().map(|f| (f.name().as_str(), encoding(f)));
    let compression = Compression::ZSTD(ZstdLevel::try_new(ZSTD_LEVEL)?);
    Ok(properties(columns, footer, compression).set_max_row_group_row_count(group_rows).build())
}

/// The encoding of a recording's column; that of a study's own channel goes by its type.
fn encoding(field: &Field) -> Encoding {
    match (encoding_of(field.name()), field.data_type()) {
        (Encoding::Dictionary, DataType::Float64) => Encoding::ByteStreamSplit,
        (encoding, _) => encoding,
    }
}

/// Writer settings of a file that is read once and removed: nothing is made small.
pub(crate) fn read_once(schema: &Schema) -> WriterProperties {
    let columns = schema.fields().iter().map(|field| match field.data_type() {
        DataType::Utf8 | DataType::Int32 => (field.name().as_str(), Encoding::Dictionary),
        _ => (field.name().as_str(), Encoding::Plain),
    });
    properties(columns, Vec::new(), Compression::UNCOMPRESSED)
        .set_statistics_enabled(EnabledStatistics::None)
        .set_max_row_group_row_count(Some(GROUP_ROWS))
        .build()
}

/// Writer settings of a derived table: what can be made again is made quickly.
pub(crate) fn derived(schema: &Schema) -> WriterProperties {
    let columns = schema.fields().iter().map(|field| match field.data_type() {
        DataType::Float64 => (field.name().as_str(), Encoding::ByteStreamSplit),
        _ => (field.name().as_str(), Encoding::Dictionary),
    });
    properties(columns, Vec::new(), Compression::SNAPPY)
        .set_max_row_group_row_count(Some(TABLE_ROWS))
        .build()
}

/// Rows of a row group: a reader takes no more than a group at a time, and most trials are one.
pub(crate) const GROUP_ROWS: usize = 1 << 20;

/// Rows of a row group of a derived table: who writes one in parts holds no more than a group, encoded.
const TABLE_ROWS: usize = 1 << 16;

/// One row group unless told otherwise, page statistics off (files are small).
pub(crate) fn properties<'a>(
    columns: impl Iterator<Item = (&'a str, Encoding)>,
    footer: Vec<KeyValue>,
    compression: Compression,
) -> WriterPropertiesBuilder {
    let mut builder = WriterProperties::builder()
        // Pages of version 2 would all go the slow way: `Pages` reads none of them.
        .set_writer_version(WriterVersion::PARQUET_1_0)
        .set_compression(compression)
        .set_max_row_group_row_count(None)
        // They tell null columns and the ends of a clock without decoding anything.
        .set_statistics_enabled(EnabledStatistics::Chunk)
        .set_key_value_metadata(Some(footer));
    for (name, encoding) in columns {
        let path = ColumnPath::from(name);
        let (dictionary, fallback) = match encoding {
            Encoding::Dictionary => (true, ParquetEncoding::PLAIN),
            Encoding::ByteStreamSplit => (false, ParquetEncoding::BYTE_STREAM_SPLIT),
            Encoding::Delta => (false, ParquetEncoding::DELTA_BINARY_PACKED),
            Encoding::Plain => (false, ParquetEncoding::PLAIN),
        };
        builder = builder.set_column_dictionary_enabled(path.clone(), dictionary);
        builder = builder.set_column_encoding(path, fallback);
    }
    builder
}
