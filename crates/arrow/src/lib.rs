//! The parts of Arrow that trials and tables need, under the names of the crate `arrow`.
//!
//! `arrow` itself brings along casts, comparisons, sums, regular expressions and rows: 2½ minutes
//! of a processor, of which nothing here calls more than the cast of a column to `f64`. What is
//! left is what Parquet builds on anyway.

pub mod compute;

/// Columns, and batches of them.
pub mod array {
    pub use arrow_array::builder::{ArrayBuilder, Float64Builder, LargeStringBuilder};
    pub use arrow_array::cast::AsArray;
    pub use arrow_array::*;
}

/// Types of columns, and the schema that lists them.
pub mod datatypes {
    pub use arrow_array::types::*;
    pub use arrow_schema::{DataType, Field, FieldRef, Fields, Schema, SchemaRef, TimeUnit};
}

/// What Arrow refuses.
pub mod error {
    pub use arrow_schema::ArrowError;
}
