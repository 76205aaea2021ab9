//! Numerical building blocks: least squares, interpolation, quadrature, crossings, spectra. Pure
//! functions on slices.
//!
//! Nothing here reads a file, knows a unit or draws a random number. Sums run in the order of the
//! input, in plain loops, so that a result has the same bits on every machine, however many numbers
//! its processor takes at a time ([`wide`]).

pub mod activity;
pub mod branch;
pub mod cubic;
pub mod dense;
mod error;
pub mod expm;
pub mod fourier;
pub mod local;
pub mod low_pass;
pub mod lsq;
pub mod minimise;
pub mod moments;
pub mod nonlinear;
pub mod order;
pub mod phases;
pub mod roots;
pub mod series;
pub mod smoothness;
pub mod sobol;
pub mod spectrum;
pub mod tableau;
pub mod updates;
pub mod welch;
pub mod wide;
pub mod zigzag;

pub use error::NumericsError;
