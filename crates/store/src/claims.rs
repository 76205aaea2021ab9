//! Checks the claims of a Parquet file from any program before it is decoded, for readers of other
//! programs' files (`crates/import`).

pub use crate::form::bounds::{check_footer, check_pages};
pub use crate::form::codec::check_codecs;
pub use crate::form::opened::guarded;
