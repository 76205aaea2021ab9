//! The data behind a figure, as a table: what is saved beside it.

use zwidth_draw::{Axis, Figure, Layer, Ticks, markup};
use zwidth_tables::{Column, Table, TableError};

/// One drawn value.
struct Row {
    panel: i64,
    axes: String,
    layer: i64,
    name: Option<String>,
    x: Option<f64>,
    y: Option<f64>,
    low: Option<f64>,
    high: Option<f64>,
}

/// Every value drawn in `figure`, in the units of its axes: one row a point, with its panel (from 1, in
/// order), what the axes show, its layer, the layer's name, x, y, and the ends of a band or whisker.
///
/// # Errors
/// A value that is infinite.
pub fn data_table(name: &str, figure: &Figure) -> Result<Table, TableError> {
    let rows: Vec<Row> = figure
        .panels
        .iter()
        .enumerate()
        .flat_map(|(p, panel)| {
            let axes = markup::plain(&format!("{} against {}", words(&panel.y), words(&panel.x)));
            panel
                .layers
                .iter()
                .enumerate()
                .flat_map(move |(l, layer)| rows_of(p as i64 + 1, &axes, l as i64 + 1, layer))
        })
        .collect();
    let text = |name, about, get: fn(&Row) -> Option<String>| Column::text(name, about, rows.iter().map(get));
    let number =
        |name, about, get: fn(&Row) -> Option<f64>| Column::float(name, "1", about, rows.iter().map(get));
    let count = |name, about, get: fn(&Row) -> i64| {
        Column::integer(name, "1", about, rows.iter().map(|r| Some(get(r))))
    };
    let title = figure.title.clone().unwrap_or_default();
    Table::new(
        name,
        &title,
        vec![
            count("panel", "panel of the figure, from 1", |r| r.panel),
            text("axes", "what its axes show, with units", |r| Some(r.axes.clone())),
            count("layer", "layer of the panel, from 1", |r| r.layer),
            text("name", "name in the legend", |r| r.name.clone()),
            number("x", "place along the x axis, in its unit", |r| r.x),
            number("y", "place along the y axis, in its unit; a count of answers", |r| r.y),
            number("low", "lower end of a band or whisker", |r| r.low),
            number("high", "upper end of a band or whisker", |r| r.high),
        ],
    )
}

/// What stands on an axis, with its unit.
fn words(axis: &Axis) -> String {
    let scale = if axis.ticks == Ticks::Powers { "log10 of " } else { "" };
    format!("{scale}{} ({})", axis.label, axis.unit)
}

/// A gap is null.
fn known(value: f64) -> Option<f64> {
    (!value.is_nan()).then_some(value)
}

fn rows_of(panel: i64, axes: &str, layer: i64, data: &Layer) -> Vec<Row> {
    let row = |name: &Option<String>, x: f64, y: f64, low: f64, high: f64| Row {
        panel,
        axes: axes.to_owned(),
        layer,
        name: name.as_deref().map(markup::plain),
        x: known(x),
        y: known(y),
        low: known(low),
        high: known(high),
    };
    let gap = f64::NAN;
    match data {
        Layer::Line(l) => l.x.iter().zip(&l.y).map(|(x, y)| row(&l.name, *x, *y, gap, gap)).collect(),
        Layer::Points(p) => p.x.iter().zip(&p.y).map(|(x, y)| row(&p.name, *x, *y, gap, gap)).collect(),
        Layer::Band(b) => (0..b.x.len()).map(|i| row(&b.name, b.x[i], gap, b.low[i], b.high[i])).collect(),
        Layer::Intervals(s) => {
            (0..s.at.len()).map(|i| row(&s.name, s.at[i], s.estimate[i], s.low[i], s.high[i])).collect()
        }
        Layer::Likert(bars) => bars
            .rows
            .iter()
            .enumerate()
            .flat_map(|(r, counts)| {
                let one = |(k, n): (usize, &u32)| {
                    row(&bars.answers.get(k).cloned(), r as f64, f64::from(*n), gap, gap)
                };
                counts.iter().enumerate().map(one).collect::<Vec<_>>()
            })
            .collect(),
        Layer::Reference(_) | Layer::Text(_) => Vec::new(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use zwidth_draw::{Cell, Line, Panel};

    #[test]
    fn every_point_of_a_line_is_a_row_and_a_gap_is_null() {
        let line =
            Line { x: vec![0.0, 1.0], y: vec![2.0, f64::NAN], name: Some("*a*".into()), ..Line::default() };
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
