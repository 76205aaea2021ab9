//! The data behind a figure, as a table: what is saved beside it.

use std::sync::Arc;
use zwidth_draw::{Axis, Figure, Layer, Ticks, markup};
use zwidth_results::FigurePoint;
use zwidth_tables::{Table, TableError};

/// Every value drawn in `figure`, in the units of its axes: one row per point, with its panel (from
/// 1, in order), what the axes show, its layer, the layer's name, x, y, and the ends of a band or
/// whisker.
///
/// # Errors
/// A value that is infinite; coordinates of one layer that differ in number.
pub fn data_table(name: &str, figure: &Figure) -> Result<Table, TableError> {
    let mut points = Vec::new();
    for (p, panel) in (1..).zip(&figure.panels) {
        let axes: Arc<str> =
            markup::plain(&format!("{} against {}", words(&panel.y), words(&panel.x))).into();
        for (l, layer) in (1..).zip(&panel.layers) {
            points.extend(points_of(layer).into_iter().map(|(name, [x, y, low, high])| {
                FigurePoint { panel: p, axes: axes.clone(), layer: l, name, x, y, low, high }
            }));
        }
    }
    let title = figure.title.clone().unwrap_or_default();
    Ok(Table::of_rows(&points)?.called(name, title))
}

/// What stands on an axis, with its unit.
fn words(axis: &Axis) -> String {
    let scale = match axis.ticks {
        Ticks::Powers => "log10 of ",
        Ticks::Logarithms => "ln of ",
        _ => "",
    };
    format!("{scale}{} ({})", axis.label, axis.unit)
}

/// The name of a point in the legend; x, y and the ends of a band or whisker. What it has not is
/// null, and so is a gap.
type Point = (Option<Arc<str>>, [Option<f64>; 4]);

fn points_of(layer: &Layer) -> Vec<Point> {
    match layer {
        Layer::Line(l) => named(&l.name, [&l.x, &l.y, &[], &[]]),
        Layer::Points(p) => named(&p.name, [&p.x, &p.y, &[], &[]]),
        Layer::Band(b) => named(&b.name, [&b.x, &[], &b.low, &b.high]),
        Layer::Intervals(s) => named(&s.name, [&s.at, &s.estimate, &s.low, &s.high]),
        Layer::Likert(bars) => {
            let mut points = Vec::new();
            for (row, strips) in bars.rows.iter().enumerate() {
                for counts in strips {
                    points.extend(counts.iter().enumerate().map(|(k, n)| {
                        let answer = bars.answers.get(k).map(|text| markup::plain(text).into());
                        (answer, [Some(row as f64), Some(f64::from(*n)), None, None])
                    }));
                }
            }
            points
        }
        Layer::Reference(_) | Layer::Text(_) => Vec::new(),
    }
}

/// One point for each value of the first column, x.
fn named(name: &Option<String>, columns: [&[f64]; 4]) -> Vec<Point> {
    let name: Option<Arc<str>> = name.as_deref().map(|name| markup::plain(name).into());
    let mut points = Vec::new();
    for i in 0..columns[0].len() {
        let numbers = columns.map(|c| c.get(i).copied().filter(|value| !value.is_nan()));
        points.push((name.clone(), numbers));
    }
    points
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
        let points: Vec<FigurePoint> = table.to_rows().unwrap();
        assert_eq!([points[0].y, points[1].y], [Some(2.0), None]);
        assert_eq!(points[0].name.as_deref(), Some("a"));
        assert_eq!(&*points[0].axes, "Fex (N) against t (s)");
    }
}
