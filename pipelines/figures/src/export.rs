//! The data behind a figure, as a table: what is saved beside it.

use std::iter;
use std::sync::Arc;
use zwidth_draw::{Axis, Figure, Layer, Ticks, markup};
use zwidth_tables::{Column, Table, TableError};

/// Drawn values of one layer, all columns as long as `x`.
#[derive(Default)]
struct Rows {
    panel: i64,
    axes: Arc<str>,
    layer: i64,
    name: Vec<Option<Arc<str>>>,
    x: Vec<f64>,
    y: Vec<f64>,
    low: Vec<f64>,
    high: Vec<f64>,
}

/// Every value drawn in `figure`, in the units of its axes: one row a point, with its panel (from
/// 1, in order), what the axes show, its layer, the layer's name, x, y, and the ends of a band or
/// whisker.
///
/// # Errors
/// A value that is infinite; coordinates of one layer that differ in number.
pub fn data_table(name: &str, figure: &Figure) -> Result<Table, TableError> {
    let mut layers = Vec::new();
    for (p, panel) in (1..).zip(&figure.panels) {
        let axes: Arc<str> =
            markup::plain(&format!("{} against {}", words(&panel.y), words(&panel.x))).into();
        for (l, layer) in (1..).zip(&panel.layers) {
            layers.push(Rows { panel: p, axes: axes.clone(), layer: l, ..rows_of(layer) });
        }
    }
    let number = |name, about, get: fn(&Rows) -> &Vec<f64>| {
        Column::float(
            name,
            "1",
            about,
            layers.iter().flat_map(|l| get(l).iter().copied().map(keep_known)),
        )
    };
    let count = |name, about, get: fn(&Rows) -> i64| {
        let values = layers.iter().flat_map(|l| iter::repeat_n(Some(get(l)), l.x.len()));
        Column::integer(name, "1", about, values)
    };
    let axes = layers.iter().flat_map(|l| iter::repeat_n(Some(l.axes.clone()), l.x.len()));
    let title = figure.title.clone().unwrap_or_default();
    Table::new(
        name,
        &title,
        vec![
            count("panel", "panel of the figure, from 1", |l| l.panel),
            Column::text("axes", "what its axes show, with units", axes),
            count("layer", "layer of the panel, from 1", |l| l.layer),
            Column::text(
                "name",
                "name in the legend",
                layers.iter().flat_map(|l| l.name.iter().cloned()),
            ),
            number("x", "place along the x axis, in its unit", |l| &l.x),
            number("y", "place along the y axis, in its unit; a count of answers", |l| &l.y),
            number("low", "lower end of a band or whisker", |l| &l.low),
            number("high", "upper end of a band or whisker", |l| &l.high),
        ],
    )
}

/// What stands on an axis, with its unit.
fn words(axis: &Axis) -> String {
    let scale = if axis.ticks == Ticks::Powers { "log10 of " } else { "" };
    format!("{scale}{} ({})", axis.label, axis.unit)
}

/// A gap is null.
fn keep_known(value: f64) -> Option<f64> {
    (!value.is_nan()).then_some(value)
}

/// The values of a layer, those that it has not as gaps.
fn rows_of(layer: &Layer) -> Rows {
    let gaps = |n: usize| vec![f64::NAN; n];
    let rows = |name: &Option<String>, x: &[f64], [y, low, high]: [Vec<f64>; 3]| {
        let name = vec![name.as_deref().map(|name| markup::plain(name).into()); x.len()];
        Rows { name, x: x.to_vec(), y, low, high, ..Rows::default() }
    };
    match layer {
        Layer::Line(l) => rows(&l.name, &l.x, [l.y.clone(), gaps(l.x.len()), gaps(l.x.len())]),
        Layer::Points(p) => rows(&p.name, &p.x, [p.y.clone(), gaps(p.x.len()), gaps(p.x.len())]),
        Layer::Band(b) => rows(&b.name, &b.x, [gaps(b.x.len()), b.low.clone(), b.high.clone()]),
        Layer::Intervals(s) => {
            rows(&s.name, &s.at, [s.estimate.clone(), s.low.clone(), s.high.clone()])
        }
        Layer::Likert(bars) => {
            let strips = || {
                let rows = bars.rows.iter().enumerate();
                rows.flat_map(|(row, strips)| strips.iter().map(move |counts| (row, counts)))
            };
            let counts = || strips().flat_map(|(row, counts)| iter::repeat(row).zip(counts));
            let answers =
                strips().flat_map(|(_, counts)| (0..counts.len()).map(|k| bars.answers.get(k)));
            let x: Vec<f64> = counts().map(|(row, _)| row as f64).collect();
            let y = counts().map(|(_, n)| f64::from(*n)).collect();
            let name =
                answers.map(|answer| answer.map(|answer| markup::plain(answer).into())).collect();
            Rows { name, ..rows(&None, &x, [y, gaps(x.len()), gaps(x.len())]) }
        }
        Layer::Reference(_) | Layer::Text(_) => Rows::default(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use zwidth_draw::{Cell, Line, Panel};

    #[test]
    fn every_point_of_a_line_is_a_row_and_a_gap_is_null() {
        let line = Line {
            x: vec![0.0, 1.0],
            y: vec![2.0, f64::NAN],
            name: Some("*a*".into()),
            ..Line::default()
        };
        let panel = Panel::new(
            Cell::at(0, 0),
            Axis::new("*t*", "s"),
            Axis::new("*F*_{ex}", "N"),
            vec![Layer::Line(line)],
        );
        let table = data_table("f", &Figure { panels: vec![panel], ..Figure::default() }).unwrap();
        assert_eq!(table.floats("y").unwrap(), [Some(2.0), None]);
        assert_eq!(table.texts("name").unwrap()[0].as_deref(), Some("a"));
        assert_eq!(table.texts("axes").unwrap()[0].as_deref(), Some("Fex (N) against t (s)"));
    }
}
