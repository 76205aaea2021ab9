//! What less of a recording does to its metrics: the largest change of each, over what a person just
//! feels.

use crate::about::FigureKind;
use crate::words::plain;
use std::collections::BTreeMap;
use zwidth_draw::style;
use zwidth_draw::{
    Axis, Cell, Direction, Figure, Layer, Panel, Points, Reference, TWO_COLUMNS_MM, Ticks,
};
use zwidth_study::Source;
use zwidth_tables::{Table, TableError};

/// What less of the recordings does.
pub const LESS: FigureKind = FigureKind {
    stem: "trade_data",
    shows: "less of the recordings: the largest change of each metric, over what is just felt",
    drawn_from: "trial",
};

/// Height of a row, mm, and of a panel without rows.
const ROW_MM: f64 = 4.2;
const FRAME_MM: f64 = 4.0;
/// Changes below this share of what is felt are drawn at it.
const LEAST: f64 = 1e-3;

/// In the names of an interval's ends.
const INTERVAL: &str = "_ci_";
/// Units at the end of a metric's name, the longest first.
const UNITS: [&str; 3] = ["_n_per_rad", "_rad", "_n"];

/// A metric as it stands beside its row: `wall_past_max_rad` reads `wall past max`.
fn row_words(metric: &str) -> String {
    let bare = UNITS.iter().find_map(|unit| metric.strip_suffix(unit)).unwrap_or(metric);
    plain(&bare.replace('_', " "))
}

/// A panel a kind of less, a row a metric whose unit has a change that is just felt, a point a degree
/// of it: the largest over trials and conditions. `changes` is the stage `trade`'s table of data.
///
/// # Errors
/// A table that lacks a column.
pub fn less(changes: &Table, sources: &[Source]) -> Result<Figure, TableError> {
    let (kinds, words) = (changes.texts("kind")?, changes.texts("less")?);
    let (metrics, shares) = (changes.texts("metric")?, changes.floats("felt_share")?);
    let mut names: Vec<String> = Vec::new();
    let mut panels: Vec<(String, Vec<String>)> = Vec::new();
    let mut most: BTreeMap<(String, String), f64> = BTreeMap::new();
    for i in 0..changes.height() {
        let (Some(kind), Some(less), Some(metric), Some(share)) =
            (&kinds[i], &words[i], &metrics[i], shares[i])
        else {
            continue;
        };
        if metric.contains(INTERVAL) {
            continue; // the ends of an interval change with its metric
        }
        if !names.contains(metric) {
            names.push(metric.clone());
        }
        match panels.iter_mut().find(|panel| panel.0 == *kind) {
            Some(panel) if panel.1.contains(less) => {}
            Some(panel) => panel.1.push(less.clone()),
            None => panels.push((kind.clone(), vec![less.clone()])),
        }
        let largest = most.entry((less.clone(), metric.clone())).or_insert(0.0);
        *largest = largest.max(share);
    }
    let rows = Rows { names, most };
    let panels = panels.iter().enumerate().map(|(i, (kind, less))| rows.panel(i, kind, less));
    Ok(Figure {
        title: Some(plain(changes.title())),
        description: format!(
            "{}: for each kind of less a panel, for each metric a row: its largest change over what is just felt.",
            changes.title()
        ),
        width_mm: TWO_COLUMNS_MM,
        panels: panels.collect(),
        footnotes: changes.notes().iter().map(|note| plain(note)).collect(),
        mark: crate::mark(sources.iter().copied()),
        ..Figure::default()
    })
}

struct Rows {
    names: Vec<String>,
    /// By what is taken and metric.
    most: BTreeMap<(String, String), f64>,
}

impl Rows {
    fn panel(&self, column: usize, kind: &str, less: &[String]) -> Panel {
        let (direction, stroke) = (Direction::Vertical, style::reference());
        let felt = Reference { direction, at: 0.0, label: None, stroke, name: None };
        let mut layers = vec![Layer::Reference(felt)];
        layers.extend(less.iter().enumerate().map(|(number, less)| {
            let share = |metric: &String| self.most.get(&(less.clone(), metric.clone())).copied();
            let log = |share: f64| libm::log10(share.max(LEAST));
            Layer::Points(Points {
                x: self.names.iter().map(|m| share(m).map_or(f64::NAN, log)).collect(),
                y: (0..self.names.len()).map(|row| row as f64).collect(),
                colour: style::mode_colour(3 * (column % 2) + number),
                diameter_pt: style::MARKER_PT,
                name: Some(plain(less)),
                ..Points::default()
            })
        }));
        let x = Axis { ticks: Ticks::Powers, ..Axis::new("change / felt", "") }.linked("share");
        let y = Axis::categories(self.names.iter().map(|name| row_words(name))).linked("metric");
        let panel = Panel::new(Cell::at(0, column), x, y, layers).titled(plain(kind));
        Panel { height_mm: Some(FRAME_MM + ROW_MM * self.names.len() as f64), ..panel }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use zwidth_tables::Column;

    #[test]
    fn a_panel_a_kind_a_row_a_metric_and_the_largest_of_the_conditions() {
        let text =
            |name, values: [&str; 4]| Column::text(name, "", values.map(|v| Some(v.to_owned())));
        let columns = vec![
            text("kind", ["fewer samples", "fewer samples", "angle", "angle"]),
            text("less", ["one sample of 2", "one sample of 2", "10 bits", "10 bits"]),
            text("metric", ["peak_n", "peak_n", "peak_n", "theta_max_rad"]),
            Column::float("felt_share", "1", "", [Some(0.1), Some(10.0), Some(1.0), None]),
        ];
        let table = Table::new("trade_data", "Less", columns).unwrap();
        let figure = less(&table, &[Source::Twin]).unwrap();
        assert_eq!(figure.panels.len(), 2);
        assert!(figure.mark.is_some() && zwidth_draw::draw(&figure).is_ok());
        let Layer::Points(points) = &figure.panels[0].layers[1] else { panic!() };
        assert_eq!(row_words("wall_stiffness_n_per_rad"), "wall stiffness");
        assert!((points.x[0] - 1.0).abs() < 1e-12, "{:?}", points.x);
    }
}
