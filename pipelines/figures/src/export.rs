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
    for (panel, drawn) in (1..).zip(&figure.panels) {
        let axes: Arc<str> =
            markup::plain(&format!("{} against {}", words(&drawn.y), words(&drawn.x))).into();
        for (layer, of_layer) in (1..).zip(&drawn.layers) {
            let row = |name: Option<Arc<str>>, [x, y, low, high]: [Option<f64>; 4]| FigurePoint {
                panel,
                axes: axes.clone(),
                layer,
                name,
                x,
                y,
                low,
                high,
            };
            match of_layer {
                Layer::Line(l) => points.extend(named(row, &l.name, [&l.x, &l.y, &[], &[]])),
                Layer::Points(p) => points.extend(named(row, &p.name, [&p.x, &p.y, &[], &[]])),
                Layer::Band(b) => points.extend(named(row, &b.name, [&b.x, &[], &b.low, &b.high])),
                Layer::Intervals(s) => {
                    points.extend(named(row, &s.name, [&s.at, &s.estimate, &s.low, &s.high]));
                }
                Layer::Likert(bars) => {
                    let rows = (0..).zip(&bars.rows);
                    for (number, counts) in
                        rows.flat_map(|(n, row)| row.iter().map(move |s| (n, s)))
                    {
                        points.extend(counts.iter().enumerate().map(|(k, n)| {
                            let answer = bars.answers.get(k).map(|text| markup::plain(text).into());
                            row(answer, [Some(f64::from(number)), Some(f64::from(*n)), None, None])
                        }));
                    }
                }
                Layer::Reference(_) | Layer::Text(_) => {}
            }
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

/// One row for each value of the first column, x: its name in the legend; x, y and the ends of a band or whisker. What
/// it has not is null, and so is a gap.
fn named<'a>(
    row: impl Fn(Option<Arc<str>>, [Option<f64>; 4]) -> FigurePoint + 'a,
    name: &Option<String>,
    columns: [&'a [f64]; 4],
) -> impl ExactSizeIterator<Item = FigurePoint> + 'a {
    let name: Option<Arc<str>> = name.as_deref().map(|name| markup::plain(name).into());
    (0..columns[0].len()).map(move |i| {
        let numbers = columns.map(|c| c.get(i).copied().filter(|value| !value.is_nan()));
        row(name.clone(), numbers)
    })
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
