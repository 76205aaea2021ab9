//! One table object, many formats: CSV, Markdown, LaTeX, Typst, HTML, Parquet.
//!
//! [`Table`] holds SI units and radians. CSV and Parquet ([`csv`], [`Table::to_parquet`]) hold it
//! as it is, for machines; Markdown, LaTeX, Typst and HTML are rounded for people, by
//! [`for_people`] (degrees, or millimetres in a linear study). [`Table::to_bytes`] writes any
//! [`Format`].
//!
//! # How a column is named
//! `<stem>[_<part>][_<unit>]`, in snake case, the unit always last:
//!
//! | | a rotational stiffness | a pure number | the only quantity of the table |
//! |---|---|---|---|
//! | the estimate | `slope_n_per_rad` | `exponent` | `estimate` |
//! | its standard error | `slope_std_error_n_per_rad` | `exponent_std_error` | `std_error` |
//! | the standard deviation of what it is a mean of | `slope_sd_n_per_rad` | `exponent_sd` | `sd` (beside `mean`) |
//! | its interval | `slope_ci_low_n_per_rad`, `slope_ci_high_n_per_rad` | `exponent_ci_low`, `exponent_ci_high` | `ci_low`, `ci_high` |
//!
//! The unit's suffix is its letters in lower case without `·`, a power as a digit, and `/` as
//! `_per_` or `_`: `N·m` → `nm`, `rad/s²` → `rad_s2`, `N/rad` → `n_per_rad`; the unit `1` has no
//! suffix. Columns of one stem and one unit belong together, wherever they stand in the table.
//!
//! # How a number is rounded for people
//! Two significant digits of the uncertainty determine the last digit of estimate, standard error
//! and interval, row by row. The uncertainty is the standard error, or else half the interval. A
//! mean with its standard deviation is one column (`4.052 ± 0.002`, to the place of two digits of
//! the latter), and so are the ends of an interval (`[3.9, 4.2]`). Without either, a number has
//! four significant digits (never fewer than its whole part, below a million; an exact `0.5` stays
//! `0.5`). From 10⁶ on, and if more than seven decimals would be needed, powers of ten are used. A
//! p value (a pure number whose stem begins with `p_`) below 0.001 is `< 0.001`, never `0`. There
//! is no `-0`; null is `–`. CSV keeps every digit: the shortest text that reads back as the same
//! number, null is empty.

mod amounts;
mod csv;
mod display;
mod error;
mod format;
mod heading;
mod html;
mod latex;
mod latex_escape;
mod layout;
mod markdown;
mod measured;
mod of_metric;
mod parquet;
mod quantity;
mod rounding;
mod shown;
mod symbol;
mod table;
mod terminal;
mod typst;
mod unit;
mod width;
mod wording;

pub use amounts::{Amount, Amounts};
pub use csv::{csv, write_csv};
pub use display::{for_people, in_coordinate};
pub use error::TableError;
pub use format::Format;
pub use heading::heading;
pub use latex_escape::escape as escape_latex;
pub use markdown::escape as escape_markdown;
pub use measured::Measured;
pub use of_metric::of_metric;
pub use parquet::About;
pub use quantity::{given, quantity, with_unit};
pub use rounding::{number, p_value};
pub use table::{SYNTHETIC, Table};
pub use typst::expression as typst_expression;
pub use unit::{shown_unit, split_unit};
pub use wording::Wording;
pub use zwidth_results::{Column, Field, NoteKind, Type, UNIT_OF_ROW, Values};
