//! Stage: which walls a sampled device can render, mapped over pairs of quantities.
//!
//! [`map`] computes every cell of a grid over two quantities ([`zwidth_results::WallQuantity`]) and
//! keeps the limits apart: the lifted map's spectral radius, passivity, each solver's growth, and
//! the closed forms from the literature. [`curves`] are the lines on which one of them is 1, and
//! [`measured`] are points from a simulated loop. [`limits`] gives all limits at one point, each
//! with its error relative to the exact one. `docs/stability.md` has equations, sources and
//! numbers.
//!
//! Pure: a wall in memory, rows out.

mod contour;
mod curves;
mod error;
pub mod impedance;
mod limits;
mod map;
mod measured;
mod others;
mod quantity;
mod scene;
mod table;
#[cfg(test)]
mod tests;

pub use curves::{Curve, curves};
pub use error::StabilityError;
pub use limits::limits;
pub use map::{Area, Cell, METHODS, Map, Span, map};
pub use measured::measured;
pub use others::{Boundary, Extent};
pub use quantity::Point;
pub use scene::of_scene;
pub use table::{
    cells, cells_table, curves_table, extent, extents_table, limit_points, limits_table,
};

/// Version of the algorithms and of the tables' form.
pub const VERSION: u32 = 3;
