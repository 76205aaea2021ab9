//! What anybody's Parquet file claims, looked at before it is decoded: for whoever reads files that
//! are none of ours (`crates/import`).

pub use crate::form::bounds::{check_footer, check_pages};
pub use crate::form::codec::check_codecs;
pub use crate::form::opened::guarded;
