//! What a figure is drawn of.

use crate::row::rows;
use std::sync::Arc;

rows! {
    /// A point of a figure, in the units of its axes.
    FigurePoint = "figure", "A figure's data" {
        /// panel of the figure, from 1
        panel: usize,
        /// what its axes show, with units
        axes: Arc<str>,
        /// layer of the panel, from 1
        layer: usize,
        /// name in the legend
        name: Option<Arc<str>>,
        /// place along the x axis, in its unit
        x: Option<f64>,
        /// place along the y axis, in its unit; a count of answers
        y: Option<f64>,
        /// lower end of a band or whisker
        low: Option<f64>,
        /// upper end of a band or whisker
        high: Option<f64>,
    }
}
