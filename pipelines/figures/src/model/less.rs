//! The effect on the metrics of fewer recorded data, or of another setup of the simulated device:
//! the change of each in the median trial and up to the 90th percentile, divided by what a person
//! just feels.

use crate::about::FigureKind;
use crate::words::{plain, powers_axis};
use std::collections::BTreeMap;
use std::sync::Arc;
use zwidth_draw::style::{self, Colour};
use zwidth_draw::{
    Axis, Cell, Direction, Figure, Intervals, Layer, Panel, Reference, TWO_COLUMNS_MM, dodge,
};
use zwidth_results::{LessKind, MetricShift};
use zwidth_study::Source;
use zwidth_tables::{TableError, split_unit};

/// What less of the recordings does.
pub const LESS: FigureKind = FigureKind::new(
    "trade_data",
    "less of the recordings: the change of each metric, over what is just felt",
    "trial",
);

/// Height of a row, mm, and of a panel without rows.
const ROW_MM: f64 = 5.4;
const FRAME_MM: f64 = 4.0;
/// Changes below this share of what is felt are drawn at it.
const LEAST: f64 = 1e-3;
/// What a mark is.
const LEGEND: &str = "How to read it: each row is a metric, each colour a change of the recording or of the setup. A mark says how much that \
     changes the metric, as a multiple of the smallest change that a person feels: right of the dashed line (1) it is felt, left of it not. \
     Marker: the median trial. Line: to the 90th percentile of the trials. Of several conditions the one that changes most is shown. \
     At the left edge: 0.001 or less. A row without a mark: the metric is not there, or is lost.";

/// In the names of an interval's ends.
const INTERVAL: &str = "_ci_";

/// Words of columns, and how people read them; the first that fits a word wins.
const READS: [(&str, &str); 7] = [
    ("discrepancy_user", "force discrepancy"),
    ("theta_max", "largest angle"),
    ("wall_past_max", "largest way past the wall"),
    ("loop_area", "net work"),
    ("force_band_rms", "RMS of fast force"),
    ("theta", "angle"),
    ("rms", "RMS"),
];

/// A metric as it stands beside its row: `saturation_theta_rad` reads `saturation angle`.
fn row_words(metric: &str, unit: &str) -> String {
    let (bare, _) = split_unit(metric, unit);
    let read = READS.iter().fold(bare.to_owned(), |text, (word, reads)| text.replace(word, reads));
    plain(&read.replace('_', " "))
}

/// One panel per kind of degradation, one row per metric whose unit has a just noticeable change,
/// one marker per degree of it. `changes` come in parts, because there may be many; `title` and
/// `notes` are those of their table.
///
/// # Errors
/// Those of the parts.
pub fn less(
    title: &str,
    notes: &[String],
    changes: impl Iterator<Item = Result<Vec<MetricShift>, TableError>>,
    sources: &[Source],
) -> Result<Figure, TableError> {
    let mut rows = Rows::default();
    let mut panels: Vec<(LessKind, Vec<Arc<str>>)> = Vec::new();
    for part in changes {
        for MetricShift { kind, less, metric, unit, median_share, p90_share, .. } in part? {
            let Some((median, p90)) = median_share.zip(p90_share) else { continue };
            if metric.contains(INTERVAL) {
                continue; // the ends of an interval change with its metric
            }
            match panels.iter_mut().find(|panel| panel.0 == kind) {
                Some(panel) if panel.1.contains(&less) => {}
                Some(panel) => panel.1.push(less.clone()),
                None => panels.push((kind, vec![less.clone()])),
            }
            rows.add(less, metric, &unit, [median, p90]);
        }
    }
    let mut before = 0;
    let panels = panels.iter().enumerate().map(|(column, (kind, less))| {
        let panel = rows.panel(column, before, *kind, less);
        before += less.len();
        panel
    });
    Ok(Figure {
        title: Some(plain(title)),
        description: format!(
            "{title}: for each kind a panel, for each metric a row: its change over what is just felt, in the median trial \
             and up to the 90th percentile of the trials."
        ),
        width_mm: TWO_COLUMNS_MM,
        panels: panels.collect(),
        footnotes: std::iter::once(LEGEND.to_owned())
            .chain(notes.iter().map(|note| plain(note)))
            .collect(),
        mark: crate::mark(sources.iter().copied()),
        ..Figure::default()
    })
}

/// Of each degree and metric, the change of the condition whose median trial changes most.
#[derive(Default)]
struct Rows {
    /// The metrics, and how people read them.
    names: Vec<(Arc<str>, String)>,
    /// Median and 90th percentile, by degree and metric.
    most: BTreeMap<(Arc<str>, Arc<str>), [f64; 2]>,
}

impl Rows {
    fn add(&mut self, less: Arc<str>, metric: Arc<str>, unit: &str, share: [f64; 2]) {
        if !self.names.iter().any(|(name, _)| *name == metric) {
            self.names.push((metric.clone(), row_words(&metric, unit)));
        }
        let most = self.most.entry((less, metric)).or_insert(share);
        if share[0] > most[0] {
            *most = share;
        }
    }

    /// `before` degrees stand in the panels to the left.
    fn panel(&self, column: usize, before: usize, kind: LessKind, less: &[Arc<str>]) -> Panel {
        let felt = Reference::new(Direction::Vertical, 0.0, style::reference());
        let mut layers = vec![Layer::Reference(felt)];
        for (number, degree) in less.iter().enumerate() {
            let mut median = Vec::new();
            let mut p90 = Vec::new();
            for (metric, _) in &self.names {
                let shares = self.most.get(&(degree.clone(), metric.clone()));
                // A metric without a change keeps its row, and has no mark in it.
                let [of_median, of_p90] = shares.map_or([f64::NAN; 2], |shares| {
                    shares.map(|share| libm::log10(share.max(LEAST)))
                });
                median.push(of_median);
                p90.push(of_p90);
            }
            let aside = dodge(number, less.len());
            let at = (0..self.names.len()).map(|row| row as f64 + aside).collect();
            layers.push(Layer::Intervals(Intervals {
                colour: colour(before + number),
                marker: style::marker(number),
                name: Some(plain(degree)),
                ..Intervals::new(Direction::Horizontal, at, [median.clone(), median, p90])
            }));
        }
        let x = powers_axis("change ÷ just felt", "").linked("share");
        let y =
            Axis::categories(self.names.iter().map(|(_, words)| words.clone())).linked("metric");
        let height_mm = FRAME_MM + ROW_MM * self.names.len() as f64;
        Panel::new(Cell::at(0, column), x, y, layers).titled(plain(kind.as_str())).tall(height_mm)
    }
}

/// Another colour for each degree of a figure, up to thirteen.
fn colour(number: usize) -> Colour {
    if number < style::MODE_COLOURS {
        style::mode_colour(number)
    } else {
        style::environment_colour(number - style::MODE_COLOURS)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Two kinds, the first with two degrees of which the first has two conditions.
    fn shifts() -> Vec<MetricShift> {
        let shift = |kind, less: &str, metric: &str, median_share, p90_share| MetricShift {
            condition: "P01.S01.spring.hybrid".into(),
            kind,
            less: less.into(),
            metric: metric.into(),
            unit: "N".into(),
            trials: 6,
            lost: 0,
            mean: 1.0,
            change: 0.0,
            median_change: 0.0,
            p90_change: 0.0,
            largest_change: 0.0,
            bound: None,
            median_share,
            p90_share,
        };
        let (samples, angle) = (LessKind::Samples, LessKind::Angle);
        vec![
            shift(samples, "1 of 2", "peak_n", Some(0.1), Some(50.0)),
            shift(samples, "1 of 2", "peak_n", Some(10.0), Some(20.0)),
            shift(samples, "1 of 4", "peak_n", Some(2.0), Some(3.0)),
            shift(angle, "10 bits", "peak_n", Some(1.0), Some(1.0)),
            shift(angle, "10 bits", "theta_max_rad", None, None),
        ]
    }

    fn figure(sources: &[Source]) -> Figure {
        less("Less", &[], [shifts()].map(Ok).into_iter(), sources).unwrap()
    }

    fn intervals(figure: &Figure) -> Vec<&Intervals> {
        let layers = figure.panels.iter().flat_map(|panel| &panel.layers);
        let found = layers.filter_map(|layer| match layer {
            Layer::Intervals(intervals) => Some(intervals),
            _ => None,
        });
        found.collect()
    }

    #[test]
    fn a_panel_a_kind_a_row_a_metric_and_the_condition_that_changes_most() {
        let figure = figure(&[Source::Twin]);
        assert_eq!(figure.panels.len(), 2);
        assert!(figure.mark.is_some() && zwidth_draw::draw(&figure).is_ok());
        let first = intervals(&figure)[0];
        assert!((first.estimate[0] - 1.0).abs() < 1e-12, "{:?}", first.estimate);
        assert!((first.high[0] - 20_f64.log10()).abs() < 1e-12, "{:?}", first.high);
        assert_eq!(row_words("wall_stiffness_n_per_rad", "N/rad"), "wall stiffness");
        assert_eq!(row_words("discrepancy_user_mean_n", "N"), "force discrepancy mean");
    }

    #[test]
    fn no_two_degrees_of_a_figure_look_alike() {
        let figure = figure(&[]);
        let mut colours: Vec<Colour> = intervals(&figure).iter().map(|i| i.colour).collect();
        colours.dedup();
        assert_eq!(colours.len(), 3);
        let mut all: Vec<Colour> = (0..13).map(colour).collect();
        all.sort();
        all.dedup();
        assert_eq!(all.len(), 13);
    }
}
