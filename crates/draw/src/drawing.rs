//! What is drawn of a figure, before it is written in a format.

use crate::sheet::Shape;
use crate::typeface::Font;

/// A figure that has been laid out and drawn.
#[derive(Debug, Clone, PartialEq)]
pub struct Drawing {
    pub(crate) shapes: Vec<Shape>,
    pub(crate) size_pt: (f64, f64),
    pub(crate) title: String,
    pub(crate) description: String,
    pub(crate) font: Option<Font>,
    pub(crate) provenance: Option<String>,
}
