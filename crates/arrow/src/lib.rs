//! The parts of Arrow that trials and tables need, under the names of the crate `arrow`.
//!
//! `arrow` itself also builds casts, comparisons, sums, regular expressions and rows. This takes 2½
//! minutes of a processor, and the workspace uses only the cast of a column to `f64`. Parquet
//! builds the remaining parts anyway.

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
